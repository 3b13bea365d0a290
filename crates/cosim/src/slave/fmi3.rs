//! A slave of FMI 3.0.

use std::sync::Arc;

use fmi_bindings::import::v3::{Instance, Instantiation, Library};
use fmi_bindings::import::{Error as ImportError, Experiment, StepResult};
use modeldescription::variable::DataType;
use modeldescription::{ModelDescription, Package};

use super::address::Address;
use super::array::Arrays;
use super::selection::{Selection, TypeRun};
use super::support::{
    Room, Settings, States, instance_of, offers_bytes, offers_state, problem, same_length,
    type_error,
};
use super::value::Value;
use super::{Slave, StateId};
use crate::error::Error;

/// Values of other types than Float64 are converted on the stack, so many at once.
const CHUNK: usize = 32;

/// One instance of an FMI 3.0 co-simulation FMU.
pub(crate) struct Fmi3Slave {
    /// None only while it is being made anew.
    instance: Option<Instance>,
    library: Arc<Library>,
    description: Arc<ModelDescription>,
    settings: Settings,
    experiment: Experiment,
    states: States,
    arrays: Arrays,
    room: Room,
    package: Arc<Package>,
}

impl Fmi3Slave {
    pub(crate) fn new(
        library: Arc<Library>,
        description: Arc<ModelDescription>,
        package: Arc<Package>,
        settings: Settings,
    ) -> Result<Self, Error> {
        let mut slave = Fmi3Slave {
            room: Room::of(&settings.name, &description),
            instance: None,
            library,
            description,
            settings,
            experiment: Experiment::default(),
            states: States::default(),
            arrays: Arrays::default(),
            package,
        };
        slave.make_anew()?;
        Ok(slave)
    }

    #[inline]
    fn instance(&mut self) -> Result<&mut Instance, Error> {
        instance_of(&mut self.instance, &self.settings.name)
    }

    /// Frees the instance, then makes a new one: never two at a time, which some FMUs forbid.
    fn make_anew(&mut self) -> Result<(), Error> {
        self.states.clear();
        self.arrays.clear();
        self.instance = None;
        let Settings { name, visible, logging_on, on_message } = self.settings.clone();
        let token = self.description.instantiation_token.clone();
        let resources = self.package.resources();
        let options = Instantiation { name, token, resources, visible, logging_on, on_message };
        self.instance = Some(Instance::new(&self.library, options)?);
        Ok(())
    }
}

impl Slave for Fmi3Slave {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// FMI 3.0 tells the FMU when initialization begins.
    fn setup(&mut self, experiment: &Experiment) -> Result<(), Error> {
        self.experiment = *experiment;
        Ok(())
    }

    fn enter_initialization(&mut self) -> Result<(), Error> {
        let experiment = self.experiment;
        Ok(self.instance()?.enter_initialization_mode(&experiment)?)
    }

    fn exit_initialization(&mut self) -> Result<(), Error> {
        Ok(self.instance()?.exit_initialization_mode()?)
    }

    fn set_start(&mut self, name: &str, value: &Value) -> Result<(), Error> {
        let description = Arc::clone(&self.description);
        let address = Address::find(&self.settings.name, &description, name).map_err(problem)?;
        let variable = &address.variable;
        let mismatch = || type_error(&self.settings.name, name, variable.data_type, value);
        if !variable.dimensions.is_empty() {
            return Err(mismatch());
        }
        match value.fit(variable.data_type).ok_or_else(mismatch)? {
            Value::Text(text) => {
                Ok(self.instance()?.set_string(&[variable.value_reference], &[&text])?)
            }
            Value::Real(value) => self.set_one(name, value),
            Value::Boolean(value) => self.set_one(name, f64::from(u8::from(value))),
            Value::Integer(value) if (value as f64) as i64 == value => {
                self.set_one(name, value as f64)
            }
            Value::Integer(_) => Err(mismatch()),
        }
    }

    fn value(&mut self, name: &str) -> Result<Value, Error> {
        let description = Arc::clone(&self.description);
        let address = Address::find(&self.settings.name, &description, name).map_err(problem)?;
        let variable = &address.variable;
        if variable.data_type == DataType::String {
            let mut text = [String::new()];
            self.instance()?.get_string(&[variable.value_reference], &mut text)?;
            let [text] = text;
            return Ok(Value::Text(text));
        }
        let mut selection = Selection::default();
        selection.add_address(&self.settings.name, &address).map_err(problem)?;
        let mut value = [0.0];
        self.get(&selection, &mut value)?;
        let [value] = value;
        Ok(match variable.data_type {
            DataType::Float32 | DataType::Float64 => Value::Real(value),
            DataType::Boolean => Value::Boolean(value != 0.0),
            _ => Value::Integer(value as i64),
        })
    }

    #[inline]
    fn set(&mut self, selection: &Selection, values: &[f64]) -> Result<(), Error> {
        same_length(&self.settings.name, "set", selection, values.len())?;
        let instance = instance_of(&mut self.instance, &self.settings.name)?;
        for run in selection.runs() {
            let values = &values[run.range.clone()];
            if let Some(array) = &run.array {
                self.arrays.set(instance, &self.description, run, array, values)?;
            } else if run.data_type == DataType::Float64 {
                instance.set_float64(&selection.references()[run.range.clone()], values)?;
            } else {
                set_other(instance, selection, run, values)?;
            }
        }
        Ok(())
    }

    #[inline]
    fn get(&mut self, selection: &Selection, values: &mut [f64]) -> Result<(), Error> {
        same_length(&self.settings.name, "get", selection, values.len())?;
        let name = &self.settings.name;
        let instance = instance_of(&mut self.instance, name)?;
        for run in selection.runs() {
            let references = &selection.references()[run.range.clone()];
            let values = &mut values[run.range.clone()];
            if let Some(array) = &run.array {
                self.arrays.get(instance, &mut self.room, run, array, values)?;
            } else if run.data_type == DataType::Float64 {
                let get = |room: &mut [f64]| instance.get_float64(references, room);
                self.room.read("fmi3GetFloat64", values, get)?;
            } else {
                get_other(instance, run.data_type, references, values)?;
            }
        }
        Ok(())
    }

    #[inline]
    fn step(&mut self, time: f64, step: f64) -> Result<StepResult, Error> {
        let keep_earlier_state = !self.states.is_empty();
        Ok(self.instance()?.do_step(time, step, keep_earlier_state)?)
    }

    fn terminate(&mut self) -> Result<(), Error> {
        match self.instance()?.terminate() {
            // Without the function there is nothing to end.
            Ok(()) | Err(ImportError::MissingFunction { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    fn reset(&mut self) -> Result<(), Error> {
        self.arrays.clear();
        // An FMU that cannot be reset is freed and made anew.
        match self.instance.as_mut().map(Instance::reset) {
            Some(Ok(())) => Ok(()),
            Some(Err(dead @ ImportError::Dead { .. })) => Err(dead.into()),
            _ => self.make_anew(),
        }
    }

    fn save(&mut self, reuse: Option<StateId>) -> Result<StateId, Error> {
        offers_state(self)?;
        if let Some(state) = reuse {
            let saved = self.states.get(&self.settings.name, state)?;
            instance_of(&mut self.instance, &self.settings.name)?.save_state_into(saved)?;
            return Ok(state);
        }
        let saved = self.instance()?.save_state()?;
        Ok(self.states.insert(saved))
    }

    fn restore(&mut self, state: StateId) -> Result<(), Error> {
        offers_state(self)?;
        let saved = self.states.get(&self.settings.name, state)?;
        Ok(instance_of(&mut self.instance, &self.settings.name)?.restore_state(saved)?)
    }

    fn forget(&mut self, state: StateId) -> Result<(), Error> {
        let saved = self.states.remove(&self.settings.name, state)?;
        Ok(self.instance()?.free_state(saved)?)
    }

    fn serialize(&mut self, state: StateId) -> Result<Vec<u8>, Error> {
        offers_bytes(self)?;
        let saved = self.states.get(&self.settings.name, state)?;
        Ok(instance_of(&mut self.instance, &self.settings.name)?.serialize_state(saved)?)
    }

    fn deserialize(&mut self, bytes: &[u8]) -> Result<StateId, Error> {
        offers_bytes(self)?;
        let saved = self.instance()?.deserialize_state(bytes)?;
        Ok(self.states.insert(saved))
    }
}

impl Fmi3Slave {
    fn set_one(&mut self, name: &str, value: f64) -> Result<(), Error> {
        let description = Arc::clone(&self.description);
        let address = Address::find(&self.settings.name, &description, name).map_err(problem)?;
        let mut selection = Selection::default();
        selection.add_address(&self.settings.name, &address).map_err(problem)?;
        self.set(&selection, &[value])
    }
}

/// Writes variables of another type than Float64; a value must be one of that type.
fn set_other(
    instance: &mut Instance,
    selection: &Selection,
    run: &TypeRun,
    values: &[f64],
) -> Result<(), Error> {
    /// Converts a chunk on the stack, or names the place that does not convert.
    macro_rules! set {
        ($type:ty, $set:ident) => {
            set!($type, $set, |value: f64| value as $type, |value: $type| value as f64)
        };
        ($type:ty, $set:ident, $to:expr, $back:expr) => {{
            let references = selection.references()[run.range.clone()].chunks(CHUNK);
            let names = selection.names()[run.range.clone()].chunks(CHUNK);
            for ((references, names), values) in references.zip(names).zip(values.chunks(CHUNK)) {
                let mut converted = [<$type>::default(); CHUNK];
                for ((place, value), name) in converted.iter_mut().zip(values).zip(names) {
                    *place = $to(*value);
                    if $back(*place) != *value {
                        let value = Value::Real(*value);
                        return Err(type_error(instance.name(), name, run.data_type, &value));
                    }
                }
                instance.$set(references, &converted[..references.len()])?;
            }
        }};
    }
    match run.data_type {
        // A rounded value is a value.
        DataType::Float32 => {
            for (reference, value) in selection.references()[run.range.clone()].iter().zip(values) {
                instance.set_float32(&[*reference], &[*value as f32])?;
            }
        }
        DataType::Int8 => set!(i8, set_int8),
        DataType::UInt8 => set!(u8, set_uint8),
        DataType::Int16 => set!(i16, set_int16),
        DataType::UInt16 => set!(u16, set_uint16),
        DataType::Int32 => set!(i32, set_int32),
        DataType::UInt32 => set!(u32, set_uint32),
        DataType::UInt64 => set!(u64, set_uint64),
        DataType::Boolean => {
            set!(bool, set_boolean, |value: f64| value == 1.0, |value: bool| f64::from(u8::from(
                value
            )));
        }
        _ => set!(i64, set_int64),
    }
    Ok(())
}

/// Reads variables of another type than Float64.
fn get_other(
    instance: &mut Instance,
    data_type: DataType,
    references: &[u32],
    values: &mut [f64],
) -> Result<(), Error> {
    macro_rules! get {
        ($type:ty, $get:ident) => {
            get!($type, $get, |value: $type| value as f64)
        };
        ($type:ty, $get:ident, $back:expr) => {
            for (references, values) in references.chunks(CHUNK).zip(values.chunks_mut(CHUNK)) {
                let mut read = [<$type>::default(); CHUNK];
                instance.$get(references, &mut read[..references.len()])?;
                values.iter_mut().zip(read).for_each(|(value, read)| *value = $back(read));
            }
        };
    }
    match data_type {
        DataType::Float32 => get!(f32, get_float32),
        DataType::Int8 => get!(i8, get_int8),
        DataType::UInt8 => get!(u8, get_uint8),
        DataType::Int16 => get!(i16, get_int16),
        DataType::UInt16 => get!(u16, get_uint16),
        DataType::Int32 => get!(i32, get_int32),
        DataType::UInt32 => get!(u32, get_uint32),
        DataType::UInt64 => get!(u64, get_uint64),
        DataType::Boolean => get!(bool, get_boolean, |value: bool| f64::from(u8::from(value))),
        _ => get!(i64, get_int64),
    }
    Ok(())
}

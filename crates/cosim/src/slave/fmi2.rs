//! A slave of FMI 2.0.

use std::sync::Arc;

use fmi_bindings::import::v2::{Instance, Instantiation, Library};
use fmi_bindings::import::{Error as ImportError, Experiment, NameOf, StepResult};
use modeldescription::variable::{DataType, Variable};
use modeldescription::{ModelDescription, Package};

use super::address::Address;
use super::selection::{Selection, TypeRun};
use super::support::{
    Room, Settings, States, failed, instance_of, offers_bytes, offers_state, problem, same_length,
    type_error,
};
use super::value::Value;
use super::{Slave, StateId};
use crate::error::Error;

/// Integers, booleans and orders are made on the stack, so many at once.
const CHUNK: usize = 32;
/// The call whose room is watched.
const GET_REAL: &str = "fmi2GetReal";

/// One instance of an FMI 2.0 co-simulation FMU.
pub(crate) struct Fmi2Slave {
    /// None only while it is being made anew.
    instance: Option<Instance>,
    library: Arc<Library>,
    description: Arc<ModelDescription>,
    settings: Settings,
    states: States,
    room: Room,
    /// Also keeps the unpacked folder, which the FMU reads from.
    package: Arc<Package>,
}

impl Fmi2Slave {
    pub(crate) fn new(
        library: Arc<Library>,
        description: Arc<ModelDescription>,
        package: Arc<Package>,
        settings: Settings,
    ) -> Result<Self, Error> {
        let mut slave = Fmi2Slave {
            room: Room::of(&settings.name, &description),
            instance: None,
            library,
            description,
            settings,
            states: States::default(),
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
        self.instance = None;
        let Settings { name, visible, logging_on, on_message, .. } = self.settings.clone();
        let guid = self.description.instantiation_token.clone();
        let resource_location = self.package.resources_uri();
        let name_of = Some(names(&self.description));
        let options = Instantiation {
            name,
            guid,
            resource_location,
            visible,
            logging_on,
            on_message,
            name_of,
        };
        self.instance = Some(Instance::new(&self.library, options)?);
        Ok(())
    }

    /// Writes variables of any types.
    #[inline(never)]
    fn set_runs(&mut self, selection: &Selection, values: &[f64]) -> Result<(), Error> {
        let instance = self.instance()?;
        for run in selection.runs() {
            let references = &selection.references()[run.range.clone()];
            let values = &values[run.range.clone()];
            if run.data_type == DataType::Float64 {
                instance.set_real(references, values)?;
            } else {
                set_integers(instance, selection, run, values)?;
            }
        }
        Ok(())
    }

    /// Reads variables of any types.
    #[inline(never)]
    fn get_runs(&mut self, selection: &Selection, values: &mut [f64]) -> Result<(), Error> {
        let instance = instance_of(&mut self.instance, &self.settings.name)?;
        for run in selection.runs() {
            let references = &selection.references()[run.range.clone()];
            let values = &mut values[run.range.clone()];
            if run.data_type == DataType::Float64 {
                let get = |room: &mut [f64]| instance.get_real(references, room);
                self.room.read(GET_REAL, values, get)?;
            } else {
                get_integers(instance, run.data_type, references, values)?;
            }
        }
        Ok(())
    }
}

/// The names that references in messages stand for; of aliases the first.
fn names(description: &Arc<ModelDescription>) -> NameOf {
    let description = Arc::clone(description);
    Arc::new(move |letter, reference| {
        let is_meant = |variable: &&Variable| {
            let own = match variable.data_type {
                DataType::Float32 | DataType::Float64 => 'r',
                DataType::Boolean => 'b',
                DataType::String => 's',
                _ => 'i',
            };
            variable.value_reference == reference && own == letter
        };
        description.variables.iter().find(is_meant).map(|variable| variable.name.clone())
    })
}

impl Slave for Fmi2Slave {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn description(&self) -> &ModelDescription {
        &self.description
    }

    fn setup(&mut self, experiment: &Experiment) -> Result<(), Error> {
        Ok(self.instance()?.setup_experiment(experiment)?)
    }

    fn enter_initialization(&mut self) -> Result<(), Error> {
        Ok(self.instance()?.enter_initialization_mode()?)
    }

    fn exit_initialization(&mut self) -> Result<(), Error> {
        Ok(self.instance()?.exit_initialization_mode()?)
    }

    fn set_start(&mut self, name: &str, value: &Value) -> Result<(), Error> {
        let description = Arc::clone(&self.description);
        let address = Address::find(&self.settings.name, &description, name).map_err(problem)?;
        let variable = &address.variable;
        let mismatch = || type_error(&self.settings.name, name, variable.data_type, value);
        let value = value.fit(variable.data_type).ok_or_else(mismatch)?;
        let reference = [variable.value_reference];
        let integer = match value {
            Value::Integer(value) => Some(i32::try_from(value).map_err(|_| mismatch())?),
            _ => None,
        };
        let instance = self.instance()?;
        match value {
            Value::Real(value) => instance.set_real(&reference, &[value])?,
            Value::Integer(_) => {
                instance.set_integer(&reference, &[integer.unwrap_or_default()])?
            }
            Value::Boolean(value) => instance.set_boolean(&reference, &[value])?,
            Value::Text(text) => instance.set_string(&reference, &[&text])?,
        }
        Ok(())
    }

    fn value(&mut self, name: &str) -> Result<Value, Error> {
        let description = Arc::clone(&self.description);
        let address = Address::find(&self.settings.name, &description, name).map_err(problem)?;
        let variable = &address.variable;
        let reference = [variable.value_reference];
        let instance = self.instance()?;
        let value = match variable.data_type {
            DataType::Float64 => {
                let mut value = [0.0];
                instance.get_real(&reference, &mut value)?;
                Value::Real(value[0])
            }
            DataType::Boolean => {
                let mut value = [false];
                instance.get_boolean(&reference, &mut value)?;
                Value::Boolean(value[0])
            }
            DataType::String => {
                let mut value = [String::new()];
                instance.get_string(&reference, &mut value)?;
                let [text] = value;
                Value::Text(text)
            }
            _ => {
                let mut value = [0];
                instance.get_integer(&reference, &mut value)?;
                Value::Integer(value[0].into())
            }
        };
        Ok(value)
    }

    #[inline]
    fn set(&mut self, selection: &Selection, values: &[f64]) -> Result<(), Error> {
        same_length(&self.settings.name, "set", selection, values.len())?;
        match &mut self.instance {
            Some(instance) if selection.is_float64() => {
                instance.set_real(selection.references(), values).map_err(failed)
            }
            _ => self.set_runs(selection, values),
        }
    }

    #[inline]
    fn get(&mut self, selection: &Selection, values: &mut [f64]) -> Result<(), Error> {
        same_length(&self.settings.name, "get", selection, values.len())?;
        match &mut self.instance {
            Some(instance) if selection.is_float64() => {
                let get = |room: &mut [f64]| instance.get_real(selection.references(), room);
                self.room.read(GET_REAL, values, get)
            }
            _ => self.get_runs(selection, values),
        }
    }

    fn output_slopes(&mut self, outputs: &Selection, slopes: &mut [f64]) -> Result<(), Error> {
        let instance = instance_of(&mut self.instance, &self.settings.name)?;
        let references = outputs.references();
        for (references, slopes) in references.chunks(CHUNK).zip(slopes.chunks_mut(CHUNK)) {
            let first = &[1; CHUNK][..references.len()];
            instance.get_real_output_derivatives(references, first, slopes)?;
        }
        Ok(())
    }

    fn set_input_slopes(&mut self, inputs: &Selection, slopes: &[f64]) -> Result<(), Error> {
        let instance = instance_of(&mut self.instance, &self.settings.name)?;
        for (references, slopes) in inputs.references().chunks(CHUNK).zip(slopes.chunks(CHUNK)) {
            let first = &[1; CHUNK][..references.len()];
            instance.set_real_input_derivatives(references, first, slopes)?;
        }
        Ok(())
    }

    #[inline]
    fn step(&mut self, time: f64, step: f64) -> Result<StepResult, Error> {
        let keep_earlier_state = !self.states.is_empty();
        self.instance()?.do_step(time, step, keep_earlier_state).map_err(failed)
    }

    fn terminate(&mut self) -> Result<(), Error> {
        match self.instance()?.terminate() {
            // Without the function there is nothing to end.
            Ok(()) | Err(ImportError::MissingFunction { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    fn reset(&mut self) -> Result<(), Error> {
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

/// Writes integers, enumerations or booleans.
fn set_integers(
    instance: &mut Instance,
    selection: &Selection,
    run: &TypeRun,
    values: &[f64],
) -> Result<(), Error> {
    let references = selection.references()[run.range.clone()].chunks(CHUNK);
    let names = selection.names()[run.range.clone()].chunks(CHUNK);
    for ((references, names), values) in references.zip(names).zip(values.chunks(CHUNK)) {
        let mut integers = [0_i32; CHUNK];
        for ((integer, value), name) in integers.iter_mut().zip(values).zip(names) {
            let integer_part = *value as i32;
            let fits = f64::from(integer_part) == *value
                && (run.data_type != DataType::Boolean || matches!(integer_part, 0 | 1));
            if !fits {
                let value = Value::Real(*value);
                return Err(type_error(instance.name(), name, run.data_type, &value));
            }
            *integer = integer_part;
        }
        let integers = &integers[..references.len()];
        if run.data_type == DataType::Boolean {
            let mut booleans = [false; CHUNK];
            for (boolean, integer) in booleans.iter_mut().zip(integers) {
                *boolean = *integer == 1;
            }
            instance.set_boolean(references, &booleans[..references.len()])?;
        } else {
            instance.set_integer(references, integers)?;
        }
    }
    Ok(())
}

/// Reads integers, enumerations or booleans.
fn get_integers(
    instance: &mut Instance,
    data_type: DataType,
    references: &[u32],
    values: &mut [f64],
) -> Result<(), Error> {
    for (references, values) in references.chunks(CHUNK).zip(values.chunks_mut(CHUNK)) {
        if data_type == DataType::Boolean {
            let mut booleans = [false; CHUNK];
            instance.get_boolean(references, &mut booleans[..references.len()])?;
            values.iter_mut().zip(booleans).for_each(|(v, b)| *v = f64::from(u8::from(b)));
        } else {
            let mut integers = [0_i32; CHUNK];
            instance.get_integer(references, &mut integers[..references.len()])?;
            values.iter_mut().zip(integers).for_each(|(v, i)| *v = f64::from(i));
        }
    }
    Ok(())
}

//! A slave of FMI 3.0.

use std::collections::HashMap;
use std::sync::Arc;

use fmi_bindings::import::v3::{Instance, Instantiation, Library};
use fmi_bindings::import::{Error as ImportError, Experiment, StepResult};
use modeldescription::variable::{Causality, DataType};
use modeldescription::{ModelDescription, Package};

use super::address::Address;
use super::array::Arrays;
use super::events::Events;
use super::selection::{Selection, TypeRun};
use super::support::{
    Room, Settings, States, instance_of, offers_bytes, offers_state, problem, same_length,
    type_error,
};
use super::typed::{get_other, get_split, set_other, set_split};
use super::value::Value;
use super::{Slave, StateId, structure};
use crate::error::Error;

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
    /// The fmi3 slave's events, where it has event mode.
    events: Option<Events>,
    /// The events that belong to saved states.
    snapshots: HashMap<StateId, Events>,
    /// It was made with event mode.
    has_events: bool,
    /// Initialization has ended.
    steps: bool,
    /// Value reference and type of the first whole number that did not fit into a double; it is told when the run
    /// ends, as messages take a lock.
    rounded: Option<(u32, DataType)>,
    /// It may return early from a step.
    returns_early: bool,
    /// It has asked for the end when initialization ended, at this time.
    ended: Option<f64>,
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
            events: None,
            snapshots: HashMap::new(),
            has_events: false,
            steps: false,
            rounded: None,
            returns_early: false,
            ended: None,
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
        self.snapshots.clear();
        self.instance = None;
        let Settings { name, visible, logging_on, on_message, .. } = self.settings.clone();
        let offered = self.description.co_simulation.as_ref();
        let event_mode =
            offered.is_some_and(|cs| cs.has_event_mode) && self.library.has_event_mode();
        let early_return =
            event_mode || offered.is_some_and(|cs| cs.might_return_early_from_do_step);
        self.returns_early = early_return;
        let options = |event_mode: bool| Instantiation {
            name: name.clone(),
            token: self.description.instantiation_token.clone(),
            resources: self.package.resources(),
            visible,
            logging_on,
            event_mode,
            early_return,
            on_message: on_message.clone(),
        };
        let has_clocks = self.description.variables.iter().any(|v| v.data_type == DataType::Clock);
        self.has_events = event_mode;
        let instance = match Instance::new(&self.library, options(event_mode)) {
            // One that states event mode and refuses it runs without, unless it has clocks.
            Err(ImportError::Instantiate { .. }) if event_mode && !has_clocks => {
                let instance = Instance::new(&self.library, options(false))?;
                self.has_events = false;
                let text = "states hasEventMode, but makes no instance with it; it handles its events itself";
                instance.log().remark(text.to_owned());
                instance
            }
            built => built?,
        };
        let version_text = Some(self.library.version()).filter(|version| version.contains('-'));
        if let Some(draft) = self.description.draft.as_deref().or(version_text) {
            let text = format!("is of FMI {draft}, a draft; it is run as one of FMI 3.0");
            instance.log().remark(text);
        }
        self.instance = Some(instance);
        self.begin_anew()
    }

    /// After instantiation and reset: what the run left is forgotten, structural parameters are set.
    fn begin_anew(&mut self) -> Result<(), Error> {
        self.arrays.clear();
        self.events = Events::of(&self.description).filter(|_| self.has_events);
        (self.steps, self.ended) = (false, None);
        if self.settings.structure.is_empty() {
            return Ok(());
        }
        self.instance()?.enter_configuration_mode()?;
        for (name, value) in self.settings.structure.clone() {
            self.set_one(&name, &value)?;
        }
        Ok(self.instance()?.exit_configuration_mode()?)
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
        self.steps = true;
        let start = self.experiment.start;
        let instance = instance_of(&mut self.instance, &self.settings.name)?;
        let Some(events) = &mut self.events else {
            return Ok(instance.exit_initialization_mode()?);
        };
        events.initialized(instance, start)?;
        instance.exit_initialization_mode()?;
        let Fmi3Slave { arrays, description, .. } = self;
        let mut write = |instance: &mut Instance, selection: &Selection, values: &[f64]| {
            write(instance, arrays, description, selection, values)
        };
        if events.first(instance, start, &mut write)? {
            self.ended = Some(start);
        }
        Ok(())
    }

    fn set_start(&mut self, name: &str, value: &Value) -> Result<(), Error> {
        let description = Arc::clone(&self.description);
        let address = Address::find(&self.settings.name, &description, name).map_err(problem)?;
        let variable = &address.variable;
        if variable.causality == Causality::StructuralParameter {
            return structure::check(&self.settings.name, variable, value);
        }
        self.set_one(name, value)
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
        if let Some(value) = self.integer(&address)? {
            return Ok(value);
        }
        let mut selection = Selection::default();
        selection.add_address(&self.settings.name, &address).map_err(problem)?;
        let mut value = [0.0];
        self.get(&selection, &mut value)?;
        let [value] = value;
        Ok(match variable.data_type {
            DataType::Float32 | DataType::Float64 => Value::Real(value),
            DataType::Boolean => Value::Boolean(value != 0.0),
            _ => Value::Integer(value as i128),
        })
    }

    #[inline]
    fn set(&mut self, selection: &Selection, values: &[f64]) -> Result<(), Error> {
        same_length(&self.settings.name, "set", selection, values.len())?;
        let instance = instance_of(&mut self.instance, &self.settings.name)?;
        let Fmi3Slave { arrays, description, events, steps, .. } = self;
        let Some(events) = events else {
            return write(instance, arrays, description, selection, values);
        };
        if !*steps {
            events.feeds();
            return write(instance, arrays, description, selection, values);
        }
        for run in selection.runs() {
            let values = &values[run.range.clone()];
            let mut write = |instance: &mut Instance, selection: &Selection, values: &[f64]| {
                write(instance, arrays, description, selection, values)
            };
            if !events.keep(instance, description, (selection, run), values, &mut write)? {
                write_run(instance, arrays, description, (selection, run), values)?;
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
                let is_exact = self.arrays.get(instance, &mut self.room, run, array, values)?;
                if !is_exact && self.rounded.is_none() {
                    self.rounded = Some((array.reference, run.data_type));
                }
            } else if run.is_split {
                let inexact = get_split(instance, run.data_type, references, values)?;
                if let (Some(place), None) = (inexact, self.rounded) {
                    self.rounded = references.get(place).map(|at| (*at, run.data_type));
                }
            } else if run.data_type == DataType::Float64 {
                let get = |room: &mut [f64]| instance.get_float64(references, room);
                self.room.read("fmi3GetFloat64", values, get)?;
            } else if run.data_type == DataType::Clock {
                let ticked =
                    |clock: &u32| self.events.as_ref().is_some_and(|e| e.has_ticked(*clock));
                let flags = references.iter().map(|clock| f64::from(u8::from(ticked(clock))));
                values.iter_mut().zip(flags).for_each(|(value, flag)| *value = flag);
            } else {
                let inexact = get_other(instance, run.data_type, references, values)?;
                if let (Some(place), None) = (inexact, self.rounded) {
                    self.rounded = references.get(place).map(|at| (*at, run.data_type));
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn step(&mut self, time: f64, step: f64) -> Result<StepResult, Error> {
        let keep_earlier_state = !self.states.is_empty();
        if self.returns_early {
            return self.step_with_events(time, step, keep_earlier_state);
        }
        Ok(self.instance()?.do_step(time, step, keep_earlier_state)?)
    }

    fn terminate(&mut self) -> Result<(), Error> {
        if let Some((reference, data_type)) = self.rounded.take() {
            let found = self.description.variables.iter().find(|v| v.value_reference == reference);
            let variable = found.map(|v| v.name.clone()).unwrap_or_default();
            self.instance()?.log().remark(format!(
                "variable `{variable}` of type {} has a value beyond 2^53, which records, elements of arrays and \
                 connections to other types carry rounded to a double",
                data_type.name()
            ));
        }
        match self.instance()?.terminate() {
            // Without the function there is nothing to end.
            Ok(()) | Err(ImportError::MissingFunction { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    fn reset(&mut self) -> Result<(), Error> {
        // An FMU that cannot be reset is freed and made anew.
        match self.instance.as_mut().map(Instance::reset) {
            Some(Ok(())) => self.begin_anew(),
            Some(Err(dead @ ImportError::Dead { .. })) => Err(dead.into()),
            _ => self.make_anew(),
        }
    }

    fn save(&mut self, reuse: Option<StateId>) -> Result<StateId, Error> {
        offers_state(self)?;
        if let Some(state) = reuse {
            let saved = self.states.get(&self.settings.name, state)?;
            instance_of(&mut self.instance, &self.settings.name)?.save_state_into(saved)?;
            self.snapshots.extend(self.events.clone().map(|events| (state, events)));
            return Ok(state);
        }
        let saved = self.instance()?.save_state()?;
        let state = self.states.insert(saved);
        self.snapshots.extend(self.events.clone().map(|events| (state, events)));
        Ok(state)
    }

    fn restore(&mut self, state: StateId) -> Result<(), Error> {
        offers_state(self)?;
        let saved = self.states.get(&self.settings.name, state)?;
        instance_of(&mut self.instance, &self.settings.name)?.restore_state(saved)?;
        if let (Some(events), Some(then)) = (&mut self.events, self.snapshots.get(&state)) {
            events.clone_from(then);
        }
        Ok(())
    }

    fn forget(&mut self, state: StateId) -> Result<(), Error> {
        self.snapshots.remove(&state);
        let saved = self.states.remove(&self.settings.name, state)?;
        Ok(self.instance()?.free_state(saved)?)
    }

    fn serialize(&mut self, state: StateId) -> Result<Vec<u8>, Error> {
        offers_bytes(self)?;
        let saved = self.states.get(&self.settings.name, state)?;
        let mut bytes =
            instance_of(&mut self.instance, &self.settings.name)?.serialize_state(saved)?;
        if let Some(events) = self.snapshots.get(&state) {
            // Behind the FMU's own bytes: the events, and how many bytes they are.
            let begin = bytes.len();
            bytes = postcard::to_extend(events, bytes).map_err(|e| self.no_events(&e))?;
            let length = (bytes.len() - begin) as u64;
            bytes.extend(length.to_le_bytes());
        }
        Ok(bytes)
    }

    fn deserialize(&mut self, bytes: &[u8]) -> Result<StateId, Error> {
        offers_bytes(self)?;
        if self.events.is_none() {
            let saved = self.instance()?.deserialize_state(bytes)?;
            return Ok(self.states.insert(saved));
        }
        let cut = || {
            let (rest, length) = bytes.split_last_chunk::<8>()?;
            let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
            rest.split_at_checked(rest.len().checked_sub(length)?)
        };
        let (own, events) = cut().ok_or_else(|| self.no_events(&"they end too early"))?;
        let events = postcard::from_bytes(events).map_err(|e| self.no_events(&e))?;
        let saved = self.instance()?.deserialize_state(own)?;
        let state = self.states.insert(saved);
        self.snapshots.insert(state, events);
        Ok(state)
    }
}

impl Fmi3Slave {
    /// Gives a variable a value, whole numbers without a detour.
    fn set_one(&mut self, name: &str, value: &Value) -> Result<(), Error> {
        let description = Arc::clone(&self.description);
        let address = Address::find(&self.settings.name, &description, name).map_err(problem)?;
        let variable = &address.variable;
        let mismatch = || type_error(&self.settings.name, name, variable.data_type, value);
        if !variable.dimensions.is_empty() {
            return Err(mismatch());
        }
        let reference = [variable.value_reference];
        let number = match value.fit(variable.data_type).ok_or_else(mismatch)? {
            Value::Text(text) => return Ok(self.instance()?.set_string(&reference, &[&text])?),
            Value::Integer(integer) if address.element.is_none() => match variable.data_type {
                DataType::UInt64 => {
                    let integer = u64::try_from(integer).map_err(|_| mismatch())?;
                    return Ok(self.instance()?.set_uint64(&reference, &[integer])?);
                }
                DataType::Int64 | DataType::Enumeration => {
                    let integer = i64::try_from(integer).map_err(|_| mismatch())?;
                    return Ok(self.instance()?.set_int64(&reference, &[integer])?);
                }
                _ => integer as f64,
            },
            Value::Integer(integer) if (integer as f64) as i128 == integer => integer as f64,
            Value::Integer(_) => return Err(mismatch()),
            Value::Real(value) => value,
            Value::Boolean(value) => f64::from(u8::from(value)),
        };
        let mut selection = Selection::default();
        selection.add_address(&self.settings.name, &address).map_err(problem)?;
        let instance = instance_of(&mut self.instance, &self.settings.name)?;
        write(instance, &mut self.arrays, &description, &selection, &[number])
    }

    /// The value of a scalar of 64 bits that is no floating point number.
    fn integer(&mut self, address: &Address) -> Result<Option<Value>, Error> {
        let reference = [address.variable.value_reference];
        if address.element.is_some() || !address.variable.dimensions.is_empty() {
            return Ok(None);
        }
        Ok(match address.variable.data_type {
            DataType::UInt64 => {
                let mut value = [0];
                self.instance()?.get_uint64(&reference, &mut value)?;
                Some(Value::Integer(value[0].into()))
            }
            DataType::Int64 | DataType::Enumeration => {
                let mut value = [0];
                self.instance()?.get_int64(&reference, &mut value)?;
                Some(Value::Integer(value[0].into()))
            }
            _ => None,
        })
    }

    /// A step of an FMU that may return before its end, or has events.
    fn step_with_events(
        &mut self,
        time: f64,
        step: f64,
        keep_earlier_state: bool,
    ) -> Result<StepResult, Error> {
        if let Some(ended) = self.ended {
            return Ok(StepResult::Discarded { reached: Some(ended), terminated: true });
        }
        let Fmi3Slave { instance, settings, events, arrays, description, .. } = self;
        let instance = instance_of(instance, &settings.name)?;
        let mut write = |instance: &mut Instance, selection: &Selection, values: &[f64]| {
            write(instance, arrays, description, selection, values)
        };
        match events {
            Some(events) => events.step(instance, (time, step), keep_earlier_state, &mut write),
            None => Events::default().step(instance, (time, step), keep_earlier_state, &mut write),
        }
    }

    #[cold]
    fn no_events(&self, why: &dyn std::fmt::Display) -> Error {
        let (fmu, why) = (self.settings.name.clone(), why.to_string());
        Error::Worker(format!("FMU `{fmu}`: the bytes of its state do not hold its events: {why}"))
    }
}

/// Writes variables.
#[inline]
fn write(
    instance: &mut Instance,
    arrays: &mut Arrays,
    description: &ModelDescription,
    selection: &Selection,
    values: &[f64],
) -> Result<(), Error> {
    for run in selection.runs() {
        write_run(instance, arrays, description, (selection, run), &values[run.range.clone()])?;
    }
    Ok(())
}

/// Writes variables of one type. Clocks have no value; they tick at events.
#[inline]
fn write_run(
    instance: &mut Instance,
    arrays: &mut Arrays,
    description: &ModelDescription,
    (selection, run): (&Selection, &TypeRun),
    values: &[f64],
) -> Result<(), Error> {
    match (&run.array, run.data_type) {
        (_, DataType::Clock) => Ok(()),
        (Some(array), _) => arrays.set(instance, description, run, array, values),
        (None, DataType::Float64) => {
            Ok(instance.set_float64(&selection.references()[run.range.clone()], values)?)
        }
        (None, _) if run.is_split => set_split(instance, selection, run, values),
        (None, _) => set_other(instance, selection, run, values),
    }
}

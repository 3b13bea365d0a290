//! A slave of FMI 2.0.

use std::collections::HashMap;
use std::sync::Arc;

use fmi_bindings::import::v2::{
    Experiment, Instance, Instantiation, Library, SavedState, StepResult,
};
use fmi_bindings::import::{Error as ImportError, OnMessage};
use modeldescription::variable::DataType;
use modeldescription::{ModelDescription, Package};

use super::selection::{Selection, TypeRun, find};
use super::value::Value;
use super::{Slave, StateId};
use crate::error::Error;

/// Integers and booleans are converted on the stack, so many at once.
const CHUNK: usize = 32;

/// One instance of an FMI 2.0 co-simulation FMU.
pub struct Fmi2Slave {
    /// None only while it is being made anew.
    instance: Option<Instance>,
    library: Arc<Library>,
    description: Arc<ModelDescription>,
    settings: Settings,
    states: HashMap<StateId, SavedState>,
    next_state: usize,
    /// Keeps the unpacked folder, which the FMU reads from.
    _package: Arc<Package>,
}

/// What an instance is made with, to make it again.
#[derive(Clone, Default)]
pub(crate) struct Settings {
    pub(crate) name: String,
    pub(crate) resource_location: String,
    pub(crate) visible: bool,
    pub(crate) logging_on: bool,
    pub(crate) on_message: Option<OnMessage>,
}

impl Fmi2Slave {
    pub(crate) fn new(
        library: Arc<Library>,
        description: Arc<ModelDescription>,
        package: Arc<Package>,
        settings: Settings,
    ) -> Result<Self, Error> {
        Ok(Fmi2Slave {
            instance: Some(instantiate(&library, &description, &settings)?),
            library,
            description,
            settings,
            states: HashMap::new(),
            next_state: 0,
            _package: package,
        })
    }

    /// The instance, for calls that the master does not make.
    ///
    /// # Errors
    /// There is none: an attempt to make it anew failed.
    #[inline]
    pub fn instance(&mut self) -> Result<&mut Instance, Error> {
        match &mut self.instance {
            Some(instance) => Ok(instance),
            None => Err(ImportError::Dead { fmu: self.settings.name.clone(), call: "this" }.into()),
        }
    }

    /// Frees the instance, then makes a new one: never two at a time, which some FMUs forbid.
    fn make_anew(&mut self) -> Result<(), Error> {
        self.states.clear();
        self.instance = None;
        self.instance = Some(instantiate(&self.library, &self.description, &self.settings)?);
        Ok(())
    }

    fn saved(&mut self, state: StateId) -> Result<(&mut Instance, &SavedState), Error> {
        let unknown = || ImportError::UnknownState { fmu: self.settings.name.clone() };
        match (&mut self.instance, self.states.get(&state)) {
            (Some(instance), Some(saved)) => Ok((instance, saved)),
            _ => Err(unknown().into()),
        }
    }

    #[inline]
    fn same_length(
        &self,
        call: &'static str,
        selection: &Selection,
        values: usize,
    ) -> Result<(), Error> {
        if selection.len() == values {
            return Ok(());
        }
        let (fmu, references) = (self.settings.name.clone(), selection.len());
        Err(ImportError::Length { fmu, call, references, values }.into())
    }

    fn offers_state(&self) -> Result<(), Error> {
        let common = self.description.co_simulation.as_ref().map(|cs| &cs.common);
        if common.is_some_and(|common| common.can_get_and_set_fmu_state) {
            return Ok(());
        }
        Err(self.no_state())
    }
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
        let variable = find(&self.settings.name, &description, name).map_err(problem)?;
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
        let variable = find(&self.settings.name, &description, name).map_err(problem)?;
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
        self.same_length("set", selection, values.len())?;
        let instance = self.instance()?;
        for run in selection.runs() {
            let references = &selection.references()[run.range.clone()];
            let values = &values[run.range.clone()];
            if run.data_type == DataType::Float64 {
                instance.set_real(references, values)?;
            } else {
                set_whole(instance, selection, run, values)?;
            }
        }
        Ok(())
    }

    #[inline]
    fn get(&mut self, selection: &Selection, values: &mut [f64]) -> Result<(), Error> {
        self.same_length("get", selection, values.len())?;
        let instance = self.instance()?;
        for run in selection.runs() {
            let references = &selection.references()[run.range.clone()];
            let values = &mut values[run.range.clone()];
            if run.data_type == DataType::Float64 {
                instance.get_real(references, values)?;
            } else {
                get_whole(instance, run.data_type, references, values)?;
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
        // An FMU that cannot be reset is freed and made anew.
        match self.instance.as_mut().map(Instance::reset) {
            Some(Ok(())) => Ok(()),
            _ => self.make_anew(),
        }
    }

    fn save(&mut self, reuse: Option<StateId>) -> Result<StateId, Error> {
        self.offers_state()?;
        if let Some(state) = reuse {
            let (instance, saved) = self.saved(state)?;
            instance.save_state_into(saved)?;
            return Ok(state);
        }
        let saved = self.instance()?.save_state()?;
        let state = StateId(self.next_state);
        self.next_state += 1;
        self.states.insert(state, saved);
        Ok(state)
    }

    fn restore(&mut self, state: StateId) -> Result<(), Error> {
        self.offers_state()?;
        let (instance, saved) = self.saved(state)?;
        Ok(instance.restore_state(saved)?)
    }

    fn forget(&mut self, state: StateId) -> Result<(), Error> {
        let Some(saved) = self.states.remove(&state) else {
            return Err(ImportError::UnknownState { fmu: self.settings.name.clone() }.into());
        };
        Ok(self.instance()?.free_state(saved)?)
    }
}

fn instantiate(
    library: &Arc<Library>,
    description: &ModelDescription,
    settings: &Settings,
) -> Result<Instance, Error> {
    let Settings { name, resource_location, visible, logging_on, on_message } = settings.clone();
    let guid = description.instantiation_token.clone();
    let options = Instantiation { name, guid, resource_location, visible, logging_on, on_message };
    Ok(Instance::new(library, options)?)
}

/// Writes integers, enumerations or booleans.
fn set_whole(
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
            let whole = *value as i32;
            let fits = f64::from(whole) == *value
                && (run.data_type != DataType::Boolean || matches!(whole, 0 | 1));
            if !fits {
                let value = Value::Real(*value);
                return Err(type_error(instance.name(), name, run.data_type, &value));
            }
            *integer = whole;
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
fn get_whole(
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

fn type_error(fmu: &str, variable: &str, data_type: DataType, value: &Value) -> Error {
    Error::Type {
        fmu: fmu.to_owned(),
        variable: variable.to_owned(),
        data_type: data_type.name(),
        value: value.to_string(),
    }
}

fn problem(problem: crate::problem::Problem) -> Error {
    Error::Problems(problem.into())
}

//! A slave that is a WebAssembly component: FMI 3.0 by the draft of the layered standard FMI-LS-WASM, in wasmtime.
//!
//! What leaves its bounds, or traps, ends this instance with an error; nothing else of the run is touched.
//!
//! Source: FMI-LS-WASM 0.1 (<https://github.com/modelica/fmi-ls-wasm>).

mod runtime;

use std::sync::Arc;

use fmi_bindings::import::{Experiment, StepResult};
use modeldescription::variable::DataType;
use modeldescription::{ModelDescription, Package};

pub(crate) use self::runtime::ComponentLibrary;
use self::runtime::{Call, Live, Status};
use super::address::Address;
use super::selection::{ArrayRun, Selection};
use super::support::Settings;
use super::value::Value;
use super::{Slave, StateId};
use crate::error::Error;
use crate::problem::Problems;

/// One instance.
pub(crate) struct ComponentSlave {
    library: Arc<ComponentLibrary>,
    description: Arc<ModelDescription>,
    settings: Settings,
    experiment: Experiment,
    /// Keeps the unpacked files.
    package: Arc<Package>,
    live: Live,
    states: Vec<Option<Vec<u8>>>,
}

impl ComponentSlave {
    pub(crate) fn new(
        library: Arc<ComponentLibrary>,
        description: Arc<ModelDescription>,
        package: Arc<Package>,
        settings: Settings,
    ) -> Result<Self, Error> {
        let live = Live::new(&library, &description, &package, &settings)?;
        let (experiment, states) = (Experiment::default(), Vec::new());
        Ok(ComponentSlave { library, description, settings, experiment, package, live, states })
    }

    /// A call that answers with a status.
    fn done(&mut self, name: &str, call: impl Call<Status>) -> Result<(), Error> {
        match self.live.call(&self.settings.name, name, call)? {
            Status::Ok | Status::Warning => Ok(()),
            status => Err(self.refused(name, status)),
        }
    }

    /// A call that answers with values or a status.
    fn values<T>(&mut self, name: &str, call: impl Call<Result<T, Status>>) -> Result<T, Error> {
        self.live
            .call(&self.settings.name, name, call)?
            .map_err(|status| self.refused(name, status))
    }

    fn refused(&self, name: &str, status: Status) -> Error {
        let status = match status {
            Status::Ok => "ok",
            Status::Warning => "warning",
            Status::Discard => "discard",
            Status::Error => "error",
            Status::Fatal => "fatal",
        };
        let what = match self.live.last_message() {
            Some(reported) => format!("returned the status {status}: {reported}"),
            None => format!("returned the status {status}, and no message"),
        };
        Error::Component { fmu: self.settings.name.clone(), call: name.to_owned(), what }
    }

    fn unsupported(&self, what: &str) -> Error {
        Error::Component {
            fmu: self.settings.name.clone(),
            call: "the importer of components".to_owned(),
            what: what.to_owned(),
        }
    }

    /// All values of these variables of one type, as numbers.
    fn read(&mut self, data_type: DataType, references: &[u32]) -> Result<Vec<f64>, Error> {
        macro_rules! read {
            ($name:literal, $call:ident) => {
                self.values($name, |guest, store, instance| {
                    guest.$call(store, instance, references)
                })?
                .into_iter()
                .map(|value| value as f64)
                .collect()
            };
        }
        Ok(match data_type {
            DataType::Float64 => read!("get-float64", call_get_float64),
            DataType::Float32 => read!("get-float32", call_get_float32),
            DataType::Int8 => read!("get-int8", call_get_int8),
            DataType::UInt8 => read!("get-uint8", call_get_uint8),
            DataType::Int16 => read!("get-int16", call_get_int16),
            DataType::UInt16 => read!("get-uint16", call_get_uint16),
            DataType::Int32 => read!("get-int32", call_get_int32),
            DataType::UInt32 => read!("get-uint32", call_get_uint32),
            DataType::Int64 | DataType::Enumeration => read!("get-int64", call_get_int64),
            DataType::UInt64 => read!("get-uint64", call_get_uint64),
            DataType::Boolean => self
                .values("get-boolean", |guest, store, instance| {
                    guest.call_get_boolean(store, instance, references)
                })?
                .into_iter()
                .map(f64::from)
                .collect(),
            _ => return Err(self.unsupported("texts, binaries and clocks are no numbers")),
        })
    }

    /// Writes all values of these variables of one type.
    fn write(
        &mut self,
        data_type: DataType,
        references: &[u32],
        values: &[f64],
    ) -> Result<(), Error> {
        macro_rules! write {
            ($name:literal, $call:ident, $type:ty) => {{
                let values: Vec<$type> = values.iter().map(|value| *value as $type).collect();
                self.done($name, |guest, store, instance| {
                    guest.$call(store, instance, references, &values)
                })
            }};
        }
        match data_type {
            DataType::Float64 => self.done("set-float64", |guest, store, instance| {
                guest.call_set_float64(store, instance, references, values)
            }),
            DataType::Float32 => write!("set-float32", call_set_float32, f32),
            DataType::Int8 => write!("set-int8", call_set_int8, i8),
            DataType::UInt8 => write!("set-uint8", call_set_uint8, u8),
            DataType::Int16 => write!("set-int16", call_set_int16, i16),
            DataType::UInt16 => write!("set-uint16", call_set_uint16, u16),
            DataType::Int32 => write!("set-int32", call_set_int32, i32),
            DataType::UInt32 => write!("set-uint32", call_set_uint32, u32),
            DataType::Int64 | DataType::Enumeration => write!("set-int64", call_set_int64, i64),
            DataType::UInt64 => write!("set-uint64", call_set_uint64, u64),
            DataType::Boolean => {
                let values: Vec<bool> = values.iter().map(|value| *value != 0.0).collect();
                self.done("set-boolean", |guest, store, instance| {
                    guest.call_set_boolean(store, instance, references, &values)
                })
            }
            _ => Err(self.unsupported("texts, binaries and clocks are no numbers")),
        }
    }

    /// All elements of an array.
    fn array(&mut self, data_type: DataType, array: &ArrayRun) -> Result<Vec<f64>, Error> {
        let values = self.read(data_type, &[array.reference])?;
        if values.len() == array.size {
            return Ok(values);
        }
        let what = format!("{} values of an array of {}", values.len(), array.size);
        Err(self.unsupported(&what))
    }

    fn variable(&self, name: &str) -> Result<Address, Error> {
        let found = Address::find(&self.settings.name, &self.description, name);
        Ok(found.map_err(Problems::from)?)
    }
}

impl Slave for ComponentSlave {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn description(&self) -> &ModelDescription {
        &self.description
    }

    fn setup(&mut self, experiment: &Experiment) -> Result<(), Error> {
        self.experiment = *experiment;
        Ok(())
    }

    fn enter_initialization(&mut self) -> Result<(), Error> {
        let Experiment { start, stop, tolerance } = self.experiment;
        self.done("enter-initialization-mode", |guest, store, instance| {
            guest.call_enter_initialization_mode(store, instance, tolerance, start, stop)
        })
    }

    fn exit_initialization(&mut self) -> Result<(), Error> {
        self.done("exit-initialization-mode", |guest, store, instance| {
            guest.call_exit_initialization_mode(store, instance)
        })
    }

    fn set_start(&mut self, variable: &str, value: &Value) -> Result<(), Error> {
        let found = self.variable(variable)?;
        let reference = [found.variable.value_reference];
        let data_type = found.variable.data_type;
        let number = match value.fit(data_type) {
            Some(Value::Text(text)) => {
                return self.done("set-string", |guest, store, instance| {
                    guest.call_set_string(store, instance, &reference, &[text])
                });
            }
            Some(Value::Real(value)) => value,
            Some(Value::Integer(value)) => value as f64,
            Some(Value::Boolean(value)) => f64::from(value),
            None => {
                return Err(Error::Type {
                    fmu: self.settings.name.clone(),
                    variable: variable.to_owned(),
                    data_type: data_type.name(),
                    value: value.to_string(),
                });
            }
        };
        let one = Selection::of(&self.description, &[variable])?;
        self.set(&one, &[number])
    }

    fn value(&mut self, variable: &str) -> Result<Value, Error> {
        let found = self.variable(variable)?.variable;
        let reference = [found.value_reference];
        if found.data_type == DataType::String {
            let texts = self.values("get-string", |guest, store, instance| {
                guest.call_get_string(store, instance, &reference)
            })?;
            return Ok(Value::Text(texts.into_iter().next().unwrap_or_default()));
        }
        let one = Selection::of(&self.description, &[variable])?;
        let mut value = [0.0];
        self.get(&one, &mut value)?;
        Ok(match found.data_type {
            DataType::Float32 | DataType::Float64 => Value::Real(value[0]),
            DataType::Boolean => Value::Boolean(value[0] != 0.0),
            _ => Value::Integer(value[0] as i128),
        })
    }

    fn set(&mut self, selection: &Selection, values: &[f64]) -> Result<(), Error> {
        for run in selection.runs() {
            let part = &values[run.range.clone()];
            match &run.array {
                _ if run.is_split => {
                    return Err(self.unsupported("whole numbers of 64 bits that are connected"));
                }
                None => {
                    self.write(run.data_type, &selection.references()[run.range.clone()], part)?
                }
                Some(array) if array.is_complete() => {
                    self.write(run.data_type, &[array.reference], part)?;
                }
                Some(array) => {
                    let mut all = self.array(run.data_type, array)?;
                    array.indices.iter().zip(part).for_each(|(index, value)| all[*index] = *value);
                    self.write(run.data_type, &[array.reference], &all)?;
                }
            }
        }
        Ok(())
    }

    fn get(&mut self, selection: &Selection, values: &mut [f64]) -> Result<(), Error> {
        for run in selection.runs() {
            let found = match &run.array {
                _ if run.is_split => {
                    return Err(self.unsupported("whole numbers of 64 bits that are connected"));
                }
                None => self.read(run.data_type, &selection.references()[run.range.clone()])?,
                Some(array) => {
                    let all = self.array(run.data_type, array)?;
                    array.indices.iter().map(|index| all[*index]).collect()
                }
            };
            if found.len() != run.range.len() {
                let what =
                    format!("{} values where {} were asked for", found.len(), run.range.len());
                return Err(self.unsupported(&what));
            }
            values[run.range.clone()].copy_from_slice(&found);
        }
        Ok(())
    }

    fn step(&mut self, time: f64, step: f64) -> Result<StepResult, Error> {
        let done = self.values("do-step", |guest, store, instance| {
            guest.call_do_step(store, instance, time, step, true)
        })?;
        if done.terminate_simulation || done.early_return {
            let reached = Some(done.last_successful_time);
            return Ok(StepResult::Discarded { reached, terminated: done.terminate_simulation });
        }
        Ok(StepResult::Completed)
    }

    fn terminate(&mut self) -> Result<(), Error> {
        self.done("terminate", |guest, store, instance| guest.call_terminate(store, instance))
    }

    /// A component that has trapped is dead: it is always made anew.
    fn reset(&mut self) -> Result<(), Error> {
        self.states.clear();
        self.live = Live::new(&self.library, &self.description, &self.package, &self.settings)?;
        Ok(())
    }

    fn save(&mut self, reuse: Option<StateId>) -> Result<StateId, Error> {
        let state = self.values("get-fmu-state", |guest, store, instance| {
            guest.call_get_fmu_state(store, instance)
        })?;
        let place = reuse.map_or(self.states.len(), |id| id.0);
        if place >= self.states.len() {
            self.states.push(None);
        }
        let place = place.min(self.states.len() - 1);
        self.states[place] = Some(state);
        Ok(StateId(place))
    }

    fn restore(&mut self, state: StateId) -> Result<(), Error> {
        let Some(bytes) = self.states.get(state.0).cloned().flatten() else {
            return Err(self.unsupported("this state was not saved"));
        };
        self.done("set-fmu-state", |guest, store, instance| {
            guest.call_set_fmu_state(store, instance, &bytes)
        })
    }

    fn forget(&mut self, state: StateId) -> Result<(), Error> {
        if let Some(place) = self.states.get_mut(state.0) {
            *place = None;
        }
        Ok(())
    }

    fn serialize(&mut self, state: StateId) -> Result<Vec<u8>, Error> {
        let bytes = self.states.get(state.0).cloned().flatten();
        bytes.ok_or_else(|| self.unsupported("this state was not saved"))
    }

    fn deserialize(&mut self, bytes: &[u8]) -> Result<StateId, Error> {
        self.states.push(Some(bytes.to_vec()));
        Ok(StateId(self.states.len() - 1))
    }
}

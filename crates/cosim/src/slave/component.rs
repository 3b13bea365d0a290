//! A slave that is a WebAssembly component: FMI 3.0 by the draft of the layered standard FMI-LS-WASM, in wasmtime.
//!
//! A component gets the callbacks of the standard and nothing else: no files, no clock, no network. Each call has a budget
//! of instructions, each instance a bound of memory. What leaves them, or traps, ends this instance with an error; nothing
//! else of the run is touched.
//!
//! Source: FMI-LS-WASM 0.1 (<https://github.com/modelica/fmi-ls-wasm>).

use std::path::Path;
use std::sync::Arc;

use fmi_bindings::import::{Experiment, StepResult};
use modeldescription::variable::DataType;
use modeldescription::{ModelDescription, Package};
use wasmtime::component::{Component, HasSelf, Linker, ResourceAny};
use wasmtime::{Config, Engine, Store, StoreLimits, StoreLimitsBuilder, Trap};

use super::address::Address;
use super::selection::{ArrayRun, Selection};
use super::support::Settings;
use super::value::Value;
use super::{Slave, StateId};
use crate::error::Error;
use crate::problem::Problems;

#[allow(missing_docs, unreachable_pub, clippy::all)]
mod bindings {
    wasmtime::component::bindgen!({ path: "../fmi-bindings/wit", world: "co-simulation-fmu" });
}

use bindings::CoSimulationFmu;
use bindings::exports::fmi::fmi3::co_simulation::GuestCoSimulationInstance;
use bindings::fmi::fmi3::{callbacks, types};
use types::Status;

/// A call of an instance's function.
trait Call<T>:
    FnOnce(&GuestCoSimulationInstance<'_>, &mut Store<Host>, ResourceAny) -> wasmtime::Result<T>
{
}

impl<T, F> Call<T> for F where
    F: FnOnce(&GuestCoSimulationInstance<'_>, &mut Store<Host>, ResourceAny) -> wasmtime::Result<T>
{
}

/// Longest component that is compiled, bytes.
const LONGEST: u64 = 64 << 20;
/// Bound of the memory of an instance, bytes.
const MEMORY: usize = 256 << 20;
/// Instructions of one call, about: some seconds.
const FUEL: u64 = 5_000_000_000;
/// Messages that are kept for an error.
const KEPT: usize = 5;

/// A compiled component.
pub(crate) struct ComponentLibrary {
    engine: Engine,
    component: Component,
}

/// What an instance reaches of its host.
struct Host {
    limits: StoreLimits,
    messages: Vec<String>,
}

impl types::Host for Host {}

impl callbacks::Host for Host {
    fn log_message(&mut self, name: String, _: Status, category: String, message: String) {
        if self.messages.len() == KEPT {
            self.messages.remove(0);
        }
        let cut = |text: String, most| text.chars().take(most).collect::<String>();
        let (category, message) = (cut(category, 50), cut(message, 1000));
        self.messages.push(format!("{}: {category}: {message}", cut(name, 100)));
    }

    fn clock_update(&mut self) {}

    fn lock_preemption(&mut self) {}

    fn unlock_preemption(&mut self) {}
}

impl ComponentLibrary {
    /// Compiles a component.
    ///
    /// # Errors
    /// The file is too long, cannot be read, or is no component.
    pub(crate) fn load(file: &Path) -> Result<Self, Error> {
        let refuse = |what: String| Error::Component {
            fmu: file.display().to_string(),
            call: "the component".to_owned(),
            what,
        };
        let length = std::fs::metadata(file).map_err(|error| refuse(error.to_string()))?.len();
        if length > LONGEST {
            return Err(refuse(format!("has {length} bytes; at most {LONGEST} are compiled")));
        }
        let bytes = std::fs::read(file).map_err(|error| refuse(error.to_string()))?;
        let mut config = Config::new();
        config.wasm_component_model(true).consume_fuel(true);
        let engine = Engine::new(&config).map_err(|error| refuse(first_line(&error)))?;
        let component =
            Component::new(&engine, bytes).map_err(|error| refuse(first_line(&error)))?;
        Ok(ComponentLibrary { engine, component })
    }
}

/// What an error says, in one line from the outside to its cause.
fn first_line(error: &wasmtime::Error) -> String {
    let all: Vec<String> = error.chain().map(ToString::to_string).collect();
    let mut text = all.join(": ").replace('\n', " ");
    if text.chars().count() > 400 {
        text = text.chars().take(400).collect();
    }
    text
}

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

/// The component while it lives.
struct Live {
    store: Store<Host>,
    bindings: CoSimulationFmu,
    instance: ResourceAny,
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

    /// One call: with a fresh budget; an error where it traps.
    fn call<T>(&mut self, name: &str, call: impl Call<T>) -> Result<T, Error> {
        let Live { store, bindings, instance } = &mut self.live;
        let guest = bindings.fmi_fmi3_co_simulation();
        let done = store
            .set_fuel(FUEL)
            .and_then(|()| call(&guest.co_simulation_instance(), store, *instance));
        done.map_err(|error| trapped(&self.settings.name, name, &error, store.data()))
    }

    /// A call that answers with a status.
    fn done(&mut self, name: &str, call: impl Call<Status>) -> Result<(), Error> {
        match self.call(name, call)? {
            Status::Ok | Status::Warning => Ok(()),
            status => Err(self.refused(name, status)),
        }
    }

    /// A call that answers with values or a status.
    fn values<T>(&mut self, name: &str, call: impl Call<Result<T, Status>>) -> Result<T, Error> {
        self.call(name, call)?.map_err(|status| self.refused(name, status))
    }

    fn refused(&self, name: &str, status: Status) -> Error {
        let status = match status {
            Status::Ok => "ok",
            Status::Warning => "warning",
            Status::Discard => "discard",
            Status::Error => "error",
            Status::Fatal => "fatal",
        };
        let what = match self.live.store.data().messages.last() {
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

impl Live {
    fn new(
        library: &ComponentLibrary,
        description: &ModelDescription,
        package: &Package,
        settings: &Settings,
    ) -> Result<Self, Error> {
        let name = &settings.name;
        let host = Host {
            limits: StoreLimitsBuilder::new()
                .memory_size(MEMORY)
                .instances(64)
                .memories(16)
                .tables(64)
                .table_elements(1_000_000)
                .trap_on_grow_failure(true)
                .build(),
            messages: Vec::new(),
        };
        let mut store = Store::new(&library.engine, host);
        store.limiter(|host| &mut host.limits);
        let begin = "instantiating the component";
        let failed = |error: wasmtime::Error, host: &Host| trapped(name, begin, &error, host);
        let mut linker = Linker::new(&library.engine);
        let linked = CoSimulationFmu::add_to_linker::<_, HasSelf<_>>(&mut linker, |host| host)
            .and_then(|()| store.set_fuel(FUEL));
        linked.map_err(|error| failed(error, store.data()))?;
        let bindings = CoSimulationFmu::instantiate(&mut store, &library.component, &linker);
        let bindings = bindings.map_err(|error| failed(error, store.data()))?;
        let guest = bindings.fmi_fmi3_co_simulation();
        let created = guest.co_simulation_instance().call_instantiate_co_simulation(
            &mut store,
            name,
            &description.instantiation_token,
            &package.resources_uri(),
            settings.visible,
            settings.logging_on,
            false,
            false,
            &[],
        );
        let call = "instantiate-co-simulation";
        let instance = created.map_err(|error| trapped(name, call, &error, store.data()))?;
        let Some(instance) = instance else {
            let reported = store.data().messages.last().cloned().unwrap_or_default();
            let what = format!("gave no instance; {reported}");
            return Err(Error::Component { fmu: name.clone(), call: call.to_owned(), what });
        };
        Ok(Live { store, bindings, instance })
    }
}

/// What ended a call.
fn trapped(fmu: &str, call: &str, error: &wasmtime::Error, host: &Host) -> Error {
    let text = first_line(error);
    let mut what = match error.downcast_ref::<Trap>() {
        Some(Trap::OutOfFuel) => format!("did not end within {FUEL} instructions"),
        Some(trap) => {
            format!("trapped: {}", trap.to_string().trim_start_matches("wasm trap: "))
        }
        None if text.contains("growing memory") => {
            format!("asked for more than {} MiB of memory", MEMORY >> 20)
        }
        None if text.contains("matching implementation was not found") => {
            format!(
                "wants more than the callbacks of FMI-LS-WASM, which is all that it gets here: {text}"
            )
        }
        None => text,
    };
    if let Some(reported) = host.messages.last() {
        what += &format!("; it said: {reported}");
    }
    Error::Component { fmu: fmu.to_owned(), call: call.to_owned(), what }
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

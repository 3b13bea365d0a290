//! A component in wasmtime: compiled once, with what each of its instances reaches and may use.
//!
//! A component gets the callbacks of the standard and nothing else: no files, no clock, no network. Each call has a budget
//! of instructions, each instance a bound of memory.

use std::path::Path;

use modeldescription::{ModelDescription, Package};
use wasmtime::component::{Component, HasSelf, Linker, ResourceAny};
use wasmtime::{Config, Engine, Store, StoreLimits, StoreLimitsBuilder, Trap};

use crate::error::Error;
use crate::slave::support::Settings;

#[allow(missing_docs, unreachable_pub, clippy::all)]
mod bindings {
    wasmtime::component::bindgen!({ path: "../fmi-bindings/wit", world: "co-simulation-fmu" });
}

use bindings::CoSimulationFmu;
use bindings::exports::fmi::fmi3::co_simulation::GuestCoSimulationInstance;
use bindings::fmi::fmi3::{callbacks, types};
pub(super) use types::Status;

/// A call of an instance's function.
pub(super) trait Call<T>:
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
pub(super) struct Host {
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

/// The component while it lives.
pub(super) struct Live {
    store: Store<Host>,
    bindings: CoSimulationFmu,
    instance: ResourceAny,
}

impl Live {
    pub(super) fn new(
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

    /// One call, with a fresh budget; an error where it traps.
    pub(super) fn call<T>(
        &mut self,
        fmu: &str,
        name: &str,
        call: impl Call<T>,
    ) -> Result<T, Error> {
        let Live { store, bindings, instance } = self;
        let guest = bindings.fmi_fmi3_co_simulation();
        let done = store
            .set_fuel(FUEL)
            .and_then(|()| call(&guest.co_simulation_instance(), store, *instance));
        done.map_err(|error| trapped(fmu, name, &error, store.data()))
    }

    /// The last message that the instance reported.
    pub(super) fn last_message(&self) -> Option<&String> {
        self.store.data().messages.last()
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

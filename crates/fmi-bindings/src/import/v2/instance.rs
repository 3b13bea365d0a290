//! One FMI 2.0 co-simulation slave: its life, its steps, its status.

use std::ffi::c_void;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::super::error::{CallError, Error, LoggedText};
use super::super::host::{FloatMode, Folder};
use super::super::log::{Log, NameOf, OnMessage};
use super::super::logger::logger;
use super::super::registry::{self, Token};
use super::super::state::States;
use super::super::status::Status;
use super::super::step::{Experiment, StepResult};
use super::super::text::{c_text, text_of};
use super::library::{Functions, Library};
use crate::fmi2::*;

/// What an instance is made with.
#[derive(Default)]
pub struct Instantiation {
    /// Name of the instance, used in messages; must not be empty.
    pub name: String,
    /// `guid` of the model description.
    pub guid: String,
    /// URI of the unpacked `resources` folder (`file:///…`). It is never given as null, even if
    /// there is no such folder: FMUs are known that crash on that.
    pub resource_location: String,
    /// Ask the FMU to show windows of its own.
    pub visible: bool,
    /// Ask the FMU for debug messages.
    pub logging_on: bool,
    /// Sees each message at once.
    pub on_message: Option<OnMessage>,
    /// Names of variables, for messages that refer to them by value references.
    pub name_of: Option<NameOf>,
}

/// One FMI 2.0 co-simulation instance. Dropping it frees it.
///
/// It may be moved between threads; calls are exclusive, as the standard demands.
pub struct Instance {
    pub(super) component: fmi2Component,
    pub(super) library: Arc<Library>,
    pub(super) name: String,
    pub(super) states: States,
    log: Arc<Log>,
    folder: Folder,
    /// The mode of the thread when the instance was created. Gets and sets, which are not looked after one
    /// by one, are found out by the next step.
    mode: FloatMode,
    token: Token,
}

// SAFETY: the standard lets an instance be called from any thread, one at a time (section 2.1.2);
// `&mut self` on every call excludes two at a time. The environment is no pointer that anyone follows.
unsafe impl Send for Instance {}

unsafe extern "C" {
    fn calloc(nobj: usize, size: usize) -> *mut c_void;
    fn free(obj: *mut c_void);
}

impl Instance {
    /// Makes an instance (`fmi2Instantiate`, co-simulation).
    ///
    /// # Errors
    /// [`Error::Instantiate`] with the FMU's messages if it returns null, as it must for a wrong
    /// GUID.
    pub fn new(library: &Arc<Library>, options: Instantiation) -> Result<Self, Error> {
        let Instantiation { name, guid, resource_location: location, visible, .. } = options;
        let (logging_on, on_message) = (options.logging_on, options.on_message);
        let name_of = options.name_of;
        if library.dead.load(Ordering::Relaxed) {
            return Err(Error::Dead { fmu: name, call: "fmi2Instantiate" });
        }
        let log = Arc::new(Log::new(on_message, name_of));
        let token = Token::new(&log, &name);
        let callbacks = token.keep(callbacks(&token));
        let c_name = c_text(&name, "the instance name", &name)?;
        let c_guid = c_text(&name, "the GUID", &guid)?;
        let c_location = c_text(&name, "the resource location", &location)?;
        let (folder, mode) = (Folder::now(), FloatMode::now());
        token.call(&"fmi2Instantiate");
        // SAFETY: the texts live during the call, the callbacks for ever.
        let component = unsafe {
            (library.functions.instantiate)(
                c_name.as_ptr(),
                fmi2CoSimulation,
                c_guid.as_ptr(),
                c_location.as_ptr(),
                callbacks,
                visible.into(),
                logging_on.into(),
            )
        };
        registry::returned();
        mode.keep(&log);
        folder.keep(&log, "fmi2Instantiate");
        if component.is_null() {
            let logged = LoggedText(log.latest());
            let function = "fmi2Instantiate";
            return Err(Error::Instantiate {
                fmu: name,
                function,
                guid,
                resources: location,
                logged,
            });
        }
        let library = Arc::clone(library);
        let states = States::default();
        Ok(Instance { component, library, name, states, log, folder, mode, token })
    }

    /// Name of the instance.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The messages of the FMU.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// Switches messages of the given categories on or off; no categories: all
    /// (`fmi2SetDebugLogging`).
    pub fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Result<(), Error> {
        const CALL: &str = "fmi2SetDebugLogging";
        let set = self.optional(self.functions().set_debug_logging, CALL)?;
        let texts = categories
            .iter()
            .map(|category| c_text(&self.name, "a log category", category))
            .collect::<Result<Vec<_>, _>>()?;
        let pointers: Vec<fmi2String> = texts.iter().map(|text| text.as_ptr()).collect();
        let component = self.alive(&CALL)?;
        // SAFETY: the instance is alive; the texts outlive the call.
        let status = unsafe { set(component, on.into(), pointers.len(), pointers.as_ptr()) };
        self.check(CALL, status)
    }

    /// Tells the FMU about the run (`fmi2SetupExperiment`); before initialization mode.
    pub fn setup_experiment(&mut self, experiment: &Experiment) -> Result<(), Error> {
        const CALL: &str = "fmi2SetupExperiment";
        let component = self.alive(&CALL)?;
        let Experiment { start, stop, tolerance } = *experiment;
        // SAFETY: the instance is alive.
        let status = unsafe {
            (self.functions().setup_experiment)(
                component,
                tolerance.is_some().into(),
                tolerance.unwrap_or(0.0),
                start,
                stop.is_some().into(),
                stop.unwrap_or(0.0),
            )
        };
        self.check(CALL, status)
    }

    /// `fmi2EnterInitializationMode`
    pub fn enter_initialization_mode(&mut self) -> Result<(), Error> {
        self.plain(&"fmi2EnterInitializationMode", self.functions().enter_initialization_mode)
    }

    /// `fmi2ExitInitializationMode`
    pub fn exit_initialization_mode(&mut self) -> Result<(), Error> {
        self.plain(&"fmi2ExitInitializationMode", self.functions().exit_initialization_mode)
    }

    /// Ends the run (`fmi2Terminate`); values can still be read.
    pub fn terminate(&mut self) -> Result<(), Error> {
        const CALL: &str = "fmi2Terminate";
        let terminate = self.optional(self.functions().terminate, CALL)?;
        self.plain(&CALL, terminate)
    }

    /// Back to the state right after instantiation (`fmi2Reset`). States saved before stay.
    pub fn reset(&mut self) -> Result<(), Error> {
        const CALL: &str = "fmi2Reset";
        let reset = self.optional(self.functions().reset, CALL)?;
        self.plain(&CALL, reset)
    }

    /// Steps from `time` over `step` seconds (`fmi2DoStep`).
    ///
    /// `keep_earlier_state`: false promises not to restore a state saved before `time`, which lets
    /// the FMU drop buffers.
    ///
    /// # Errors
    /// Statuses *Error* and *Fatal*; also *Pending*, which no FMU may return to an importer that
    /// gives no `stepFinished` callback.
    #[inline]
    pub fn do_step(
        &mut self,
        time: f64,
        step: f64,
        keep_earlier_state: bool,
    ) -> Result<StepResult, Error> {
        const CALL: &str = "fmi2DoStep";
        let component = self.alive(&CALL)?;
        let drop_earlier_state = (!keep_earlier_state).into();
        // SAFETY: the instance is alive.
        let status =
            unsafe { (self.functions().do_step)(component, time, step, drop_earlier_state) };
        registry::returned();
        self.mode.keep(&self.log);
        if status == fmi2OK {
            return Ok(StepResult::Completed);
        }
        if status == fmi2Discard {
            return Ok(self.discarded());
        }
        self.check(CALL, status).map(|()| StepResult::Completed)
    }

    /// Where and why a discarded step ended, as far as the FMU tells.
    #[cold]
    fn discarded(&mut self) -> StepResult {
        let reached = self.real_status(fmi2LastSuccessfulTime).ok();
        let terminated = self.boolean_status(fmi2Terminated).unwrap_or(false);
        StepResult::Discarded { reached, terminated }
    }

    /// Cancels an asynchronous step (`fmi2CancelStep`).
    pub fn cancel_step(&mut self) -> Result<(), Error> {
        const CALL: &str = "fmi2CancelStep";
        let cancel = self.optional(self.functions().cancel_step, CALL)?;
        self.plain(&CALL, cancel)
    }

    /// `fmi2GetStatus`
    pub fn status(&mut self, kind: fmi2StatusKind) -> Result<Status, Error> {
        const CALL: &str = "fmi2GetStatus";
        let get = self.optional(self.functions().get_status, CALL)?;
        let component = self.alive(&CALL)?;
        let mut value = fmi2OK;
        // SAFETY: the instance is alive, the result has a place.
        let status = unsafe { get(component, kind, &raw mut value) };
        self.check(CALL, status).map(|()| value.into())
    }

    /// `fmi2GetRealStatus`
    pub fn real_status(&mut self, kind: fmi2StatusKind) -> Result<f64, Error> {
        const CALL: &str = "fmi2GetRealStatus";
        let get = self.optional(self.functions().get_real_status, CALL)?;
        let component = self.alive(&CALL)?;
        let mut value = 0.0;
        // SAFETY: the instance is alive, the result has a place.
        let status = unsafe { get(component, kind, &raw mut value) };
        self.check(CALL, status).map(|()| value)
    }

    /// `fmi2GetIntegerStatus`
    pub fn integer_status(&mut self, kind: fmi2StatusKind) -> Result<i32, Error> {
        const CALL: &str = "fmi2GetIntegerStatus";
        let get = self.optional(self.functions().get_integer_status, CALL)?;
        let component = self.alive(&CALL)?;
        let mut value = 0;
        // SAFETY: the instance is alive, the result has a place.
        let status = unsafe { get(component, kind, &raw mut value) };
        self.check(CALL, status).map(|()| value)
    }

    /// `fmi2GetBooleanStatus`
    pub fn boolean_status(&mut self, kind: fmi2StatusKind) -> Result<bool, Error> {
        const CALL: &str = "fmi2GetBooleanStatus";
        let get = self.optional(self.functions().get_boolean_status, CALL)?;
        let component = self.alive(&CALL)?;
        let mut value = fmi2False;
        // SAFETY: the instance is alive, the result has a place.
        let status = unsafe { get(component, kind, &raw mut value) };
        self.check(CALL, status).map(|()| value != fmi2False)
    }

    /// `fmi2GetStringStatus`
    pub fn string_status(&mut self, kind: fmi2StatusKind) -> Result<String, Error> {
        const CALL: &str = "fmi2GetStringStatus";
        let get = self.optional(self.functions().get_string_status, CALL)?;
        let component = self.alive(&CALL)?;
        let mut value: fmi2String = std::ptr::null();
        // SAFETY: the instance is alive, the result has a place.
        let status = unsafe { get(component, kind, &raw mut value) };
        self.check(CALL, status)?;
        // SAFETY: after success null or a text that lives until the next call.
        Ok(unsafe { text_of(value) })
    }

    #[inline]
    pub(super) fn functions(&self) -> &Functions {
        &self.library.functions
    }

    /// The component, unless an earlier call of it, or of another instance, was fatal. From now on this
    /// thread is in the call, until its status is [checked](Instance::check).
    #[inline]
    pub(super) fn alive(&self, call: &'static &'static str) -> Result<fmi2Component, Error> {
        if self.library.dead.load(Ordering::Relaxed) {
            return Err(Error::Dead { fmu: self.name.clone(), call });
        }
        self.token.call(call);
        Ok(self.component)
    }

    /// A function that not every library has.
    pub(super) fn optional<F>(&self, found: Option<F>, name: &'static str) -> Result<F, Error> {
        found.ok_or_else(|| Error::MissingFunction { fmu: self.name.clone(), function: name })
    }

    /// A call that takes the instance only.
    fn plain(
        &mut self,
        call: &'static &'static str,
        function: unsafe extern "C" fn(fmi2Component) -> fmi2Status,
    ) -> Result<(), Error> {
        let component = self.alive(call)?;
        // SAFETY: the instance is alive.
        let status = unsafe { function(component) };
        registry::returned();
        self.mode.keep(&self.log);
        self.log.tell_of_mode();
        self.log.tell_of_warnings();
        self.folder.keep(&self.log, call);
        self.check(call, status)
    }

    /// OK and Warning pass.
    #[inline]
    pub(super) fn check(&mut self, call: &'static str, status: fmi2Status) -> Result<(), Error> {
        registry::returned();
        if status == fmi2OK {
            return Ok(());
        }
        if status == fmi2Warning {
            self.log.has_warned(call.ends_with("DoStep"));
            return Ok(());
        }
        Err(self.failed(call, status))
    }

    #[cold]
    fn failed(&mut self, call: &'static str, status: fmi2Status) -> Error {
        if status == fmi2Fatal {
            // No function may be called any more, on no instance, not even to free it.
            self.library.dead.store(true, Ordering::Relaxed);
        }
        self.folder.keep(&self.log, call);
        let messages = self.log.latest();
        Box::new(CallError { fmu: self.name.clone(), call, status: status.into(), messages }).into()
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if self.library.dead.load(Ordering::Relaxed) {
            return;
        }
        self.free_all_states();
        self.token.call(&"fmi2FreeInstance");
        // SAFETY: the instance is alive and is not used again; the standard allows the call in
        // every state but after a fatal status.
        unsafe { (self.functions().free_instance)(self.component) };
        registry::returned();
        self.log.tell_of_mode();
        self.log.tell_of_warnings();
        self.folder.keep(&self.log, "fmi2FreeInstance");
    }
}

fn callbacks(token: &Token) -> fmi2CallbackFunctions {
    fmi2CallbackFunctions {
        logger: Some(logger()),
        allocateMemory: Some(calloc),
        freeMemory: Some(free),
        stepFinished: None,
        componentEnvironment: token.environment(),
    }
}

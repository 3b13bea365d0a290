//! One FMI 3.0 co-simulation slave: its life and its steps.

use std::path::PathBuf;
use std::ptr;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::super::error::{CallError, Error, LoggedText};
use super::super::host::{FloatMode, Folder};
use super::super::log::{Log, OnMessage};
use super::super::logger::receive_v3;
use super::super::registry::{self, Token};
use super::super::state::States;
use super::super::step::{Experiment, StepResult};
use super::super::text::c_text;
use super::library::{EventFunctions, Functions, Library};
use crate::fmi3::*;

/// What an instance is made with.
#[derive(Default)]
pub struct Instantiation {
    /// Name of the instance, used in messages; must not be empty.
    pub name: String,
    /// `instantiationToken` of the model description.
    pub token: String,
    /// The unpacked `resources` folder, absolute. It is never given as null, even if there is no
    /// such folder: FMUs are known that crash on that.
    pub resources: PathBuf,
    /// Ask the FMU to show windows of its own.
    pub visible: bool,
    /// Ask the FMU for debug messages.
    pub logging_on: bool,
    /// Events are handled in event mode, which only an FMU with `hasEventMode` offers.
    pub event_mode: bool,
    /// Steps may return early, see [`Instance::step_to_event`].
    pub early_return: bool,
    /// Sees each message at once.
    pub on_message: Option<OnMessage>,
}

/// How a step ended that may be one to an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepped {
    /// Time that the FMU has reached, s.
    pub reached: f64,
    /// It returned before the end of the step.
    pub early: bool,
    /// An event is to be handled at the time that it reached.
    pub event: bool,
    /// It asks for the end of the simulation.
    pub terminated: bool,
    /// The step was not done (status *Discard*); what it reached is not known.
    pub discarded: bool,
}

/// One FMI 3.0 co-simulation instance. Dropping it frees it.
///
/// It may be moved between threads; calls are exclusive, as the standard demands.
pub struct Instance {
    pub(super) pointer: fmi3Instance,
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

// SAFETY: the standard lets an instance be called from any thread, one at a time; `&mut self` on
// every call excludes two at a time. The environment is no pointer that anyone follows.
unsafe impl Send for Instance {}

impl Instance {
    /// Makes an instance (`fmi3InstantiateCoSimulation`), without intermediate update.
    ///
    /// # Errors
    /// [`Error::Instantiate`] with the FMU's messages if it returns null, as it must for a wrong
    /// token.
    pub fn new(library: &Arc<Library>, options: Instantiation) -> Result<Self, Error> {
        let Instantiation { name, token: guid, resources, visible, logging_on, .. } = options;
        let Instantiation { event_mode, early_return, on_message, .. } = options;
        if library.dead.load(Ordering::Relaxed) {
            return Err(Error::Dead { fmu: name, call: "fmi3InstantiateCoSimulation" });
        }
        // The standard wants a path that ends with a separator.
        let path = format!("{}{}", resources.display(), std::path::MAIN_SEPARATOR);
        let log = Arc::new(Log::new(on_message, None));
        let token = Token::new(&log, &name);
        let c_name = c_text(&name, "the instance name", &name)?;
        let c_token = c_text(&name, "the instantiation token", &guid)?;
        let c_path = c_text(&name, "the resource path", &path)?;
        let (folder, mode) = (Folder::now(), FloatMode::now());
        token.call(&"fmi3InstantiateCoSimulation");
        // SAFETY: the texts live during the call.
        let pointer = unsafe {
            (library.functions.instantiate_co_simulation)(
                c_name.as_ptr(),
                c_token.as_ptr(),
                c_path.as_ptr(),
                visible,
                logging_on,
                event_mode,
                early_return,
                ptr::null(),
                0,
                token.environment(),
                Some(receive_v3),
                None,
            )
        };
        registry::returned();
        mode.keep(&log);
        folder.keep(&log, "fmi3InstantiateCoSimulation");
        if pointer.is_null() {
            return Err(Error::Instantiate {
                fmu: name,
                function: "fmi3InstantiateCoSimulation",
                guid,
                resources: path,
                logged: LoggedText(log.latest()),
            });
        }
        let library = Arc::clone(library);
        let states = States::default();
        Ok(Instance { pointer, library, name, states, log, folder, mode, token })
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
    /// (`fmi3SetDebugLogging`).
    pub fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Result<(), Error> {
        const CALL: &str = "fmi3SetDebugLogging";
        let set = self.optional(self.functions().set_debug_logging, CALL)?;
        let texts = categories
            .iter()
            .map(|category| c_text(&self.name, "a log category", category))
            .collect::<Result<Vec<_>, _>>()?;
        let pointers: Vec<fmi3String> = texts.iter().map(|text| text.as_ptr()).collect();
        let instance = self.alive(&CALL)?;
        // SAFETY: the instance is alive; the texts outlive the call.
        let status = unsafe { set(instance, on, pointers.len(), pointers.as_ptr()) };
        self.check(CALL, status)
    }

    /// `fmi3EnterInitializationMode`, with the time span of the run.
    pub fn enter_initialization_mode(&mut self, experiment: &Experiment) -> Result<(), Error> {
        const CALL: &str = "fmi3EnterInitializationMode";
        let instance = self.alive(&CALL)?;
        let Experiment { start, stop, tolerance } = *experiment;
        // SAFETY: the instance is alive.
        let status = unsafe {
            (self.functions().enter_initialization_mode)(
                instance,
                tolerance.is_some(),
                tolerance.unwrap_or(0.0),
                start,
                stop.is_some(),
                stop.unwrap_or(0.0),
            )
        };
        self.check(CALL, status)
    }

    /// `fmi3ExitInitializationMode`
    pub fn exit_initialization_mode(&mut self) -> Result<(), Error> {
        self.plain(&"fmi3ExitInitializationMode", self.functions().exit_initialization_mode)
    }

    /// Ends the run (`fmi3Terminate`); values can still be read.
    pub fn terminate(&mut self) -> Result<(), Error> {
        const CALL: &str = "fmi3Terminate";
        let terminate = self.optional(self.functions().terminate, CALL)?;
        self.plain(&CALL, terminate)
    }

    /// Back to the state right after instantiation (`fmi3Reset`). States saved before stay.
    pub fn reset(&mut self) -> Result<(), Error> {
        const CALL: &str = "fmi3Reset";
        let reset = self.optional(self.functions().reset, CALL)?;
        self.plain(&CALL, reset)
    }

    /// Steps from `time` over `step` seconds (`fmi3DoStep`).
    ///
    /// `keep_earlier_state`: false promises not to restore a state saved before `time`.
    ///
    /// # Errors
    /// Statuses *Error* and *Fatal*. An FMU that returns early though it was not allowed to is
    /// reported as [`StepResult::Discarded`] with the time it reached.
    #[inline]
    pub fn do_step(
        &mut self,
        time: f64,
        step: f64,
        keep_earlier_state: bool,
    ) -> Result<StepResult, Error> {
        let stepped = self.step_to_event(time, step, keep_earlier_state)?;
        let Stepped { reached, early, terminated, discarded, .. } = stepped;
        if terminated || early || discarded {
            let reached = (!discarded).then_some(reached);
            return Ok(StepResult::Discarded { reached, terminated });
        }
        Ok(StepResult::Completed)
    }

    /// [`Instance::do_step`] of an instance that may return early or has event mode.
    #[inline]
    pub fn step_to_event(
        &mut self,
        time: f64,
        step: f64,
        keep_earlier_state: bool,
    ) -> Result<Stepped, Error> {
        const CALL: &str = "fmi3DoStep";
        let instance = self.alive(&CALL)?;
        // Read as bytes: a foreign FMU may write other values than 0 and 1.
        let mut flags = [0_u8; 3];
        let mut reached = time + step;
        let [event, terminate, early] = flags.each_mut().map(|flag| ptr::from_mut(flag).cast());
        // SAFETY: the instance is alive; each result has a place of the size of C's `bool`.
        let status = unsafe {
            (self.functions().do_step)(
                instance,
                time,
                step,
                !keep_earlier_state,
                event,
                terminate,
                early,
                &raw mut reached,
            )
        };
        registry::returned();
        self.mode.keep(&self.log);
        let [event, terminated, early] = flags.map(|flag| flag != 0);
        let discarded = status == fmi3Discard;
        if !discarded {
            self.check(CALL, status)?;
        }
        Ok(Stepped { reached, early, event, terminated, discarded })
    }

    pub(super) fn events(&self) -> &EventFunctions {
        &self.library.events
    }

    #[inline]
    pub(super) fn functions(&self) -> &Functions {
        &self.library.functions
    }

    /// The pointer, unless an earlier call of it, or of another instance, was fatal. From now on this
    /// thread is in the call, until its status is [checked](Instance::check).
    #[inline]
    pub(super) fn alive(&self, call: &'static &'static str) -> Result<fmi3Instance, Error> {
        if self.library.dead.load(Ordering::Relaxed) {
            return Err(Error::Dead { fmu: self.name.clone(), call });
        }
        self.token.call(call);
        Ok(self.pointer)
    }

    /// A function that not every library has.
    pub(super) fn optional<F>(&self, found: Option<F>, name: &'static str) -> Result<F, Error> {
        found.ok_or_else(|| Error::MissingFunction { fmu: self.name.clone(), function: name })
    }

    /// A call that takes the instance only.
    pub(super) fn plain(
        &mut self,
        call: &'static &'static str,
        function: unsafe extern "C" fn(fmi3Instance) -> fmi3Status,
    ) -> Result<(), Error> {
        let status = self.status_of(call, function)?;
        self.log.tell_of_mode();
        self.log.tell_of_warnings();
        self.folder.keep(&self.log, call);
        self.check(call, status)
    }

    /// A call that takes the instance only, between two steps of a cycle, where no lock may be taken: remarks follow later.
    pub(super) fn plain_in_cycle(
        &mut self,
        call: &'static &'static str,
        function: unsafe extern "C" fn(fmi3Instance) -> fmi3Status,
    ) -> Result<(), Error> {
        let status = self.status_of(call, function)?;
        self.check(call, status)
    }

    fn status_of(
        &mut self,
        call: &'static &'static str,
        function: unsafe extern "C" fn(fmi3Instance) -> fmi3Status,
    ) -> Result<fmi3Status, Error> {
        let instance = self.alive(call)?;
        // SAFETY: the instance is alive.
        let status = unsafe { function(instance) };
        registry::returned();
        self.mode.keep(&self.log);
        Ok(status)
    }

    /// OK and Warning pass.
    #[inline]
    pub(super) fn check(&mut self, call: &'static str, status: fmi3Status) -> Result<(), Error> {
        registry::returned();
        if status == fmi3OK {
            return Ok(());
        }
        if status == fmi3Warning {
            self.log.has_warned(call.ends_with("DoStep"));
            return Ok(());
        }
        Err(self.failed(call, status))
    }

    #[cold]
    fn failed(&mut self, call: &'static str, status: fmi3Status) -> Error {
        if status == fmi3Fatal {
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
        self.token.call(&"fmi3FreeInstance");
        // SAFETY: the instance is alive and is not used again.
        unsafe { (self.functions().free_instance)(self.pointer) };
        registry::returned();
        self.log.tell_of_mode();
        self.log.tell_of_warnings();
        self.folder.keep(&self.log, "fmi3FreeInstance");
    }
}

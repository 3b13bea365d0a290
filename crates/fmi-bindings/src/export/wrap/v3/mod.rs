//! The functions of FMI 3.0 of a repaired FMU, in the order of the header.
//!
//! # Safety
//! The contract of all functions of [`export::v3`](crate::export::v3).
#![allow(
    non_snake_case,
    non_upper_case_globals,
    clippy::missing_safety_doc,
    clippy::too_many_arguments
)]

use std::ffi::CStr;

use super::core::{
    Answer, CATEGORY, Code, DISCARD, OK, Original, Wrapped, call as guarded, instantiate,
};
use super::file::{Files, PLATFORM_V3};
use super::state_calls::{self, States};
use crate::export::arguments::{Room, array, text, texts};
use crate::export::guard;
use crate::export::log::Sink;
use crate::export::notice::Notice;
use crate::export::resources::Location;
use crate::fmi3::*;
use crate::import::v3::Library;

pub use crate::export::v3::fmi3GetVersion;

/// The original.
struct Inner {
    instance: fmi3Instance,
    library: Library,
    /// Whether the host promises not to go back before the current point.
    no_way_back: fmi3Boolean,
    /// What the last step reported.
    flags: StepFlags,
}

/// What a step reports; flags as bytes, because the original may write anything.
#[derive(Clone, Copy, Default)]
struct StepFlags {
    event: u8,
    terminate: u8,
    early: u8,
    time: f64,
}

type Instance = Wrapped<Inner>;

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: an instance of this library, never used again.
        unsafe { (self.library.functions.free_instance)(self.instance) }
    }
}

impl Original for Inner {
    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Code {
        let get = self.library.functions.get_float64;
        let (vr, n) = (references.as_ptr(), references.len());
        // SAFETY: the instance is alive, the arrays have these lengths.
        unsafe { get(self.instance, vr, n, values.as_mut_ptr(), values.len()).0 }
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Code {
        let set = self.library.functions.set_float64;
        let (vr, n) = (references.as_ptr(), references.len());
        // SAFETY: the instance is alive, the arrays have these lengths.
        unsafe { set(self.instance, vr, n, values.as_ptr(), values.len()).0 }
    }

    fn step(&mut self, time: f64, step: f64) -> (Code, bool) {
        let do_step = self.library.functions.do_step;
        let mut flags = StepFlags { time, ..StepFlags::default() };
        // SAFETY: the instance is alive; `bool` has the size of a byte, and whatever is written
        // there is read as a byte.
        let code = unsafe {
            do_step(
                self.instance,
                time,
                step,
                self.no_way_back,
                (&raw mut flags.event).cast(),
                (&raw mut flags.terminate).cast(),
                (&raw mut flags.early).cast(),
                &raw mut flags.time,
            )
            .0
        };
        self.flags = flags;
        (code, flags.event == 0 && flags.terminate == 0 && flags.early == 0)
    }
}

/// One call.
///
/// # Safety
/// The contract of all functions here.
unsafe fn call(
    instance: fmi3Instance,
    function: &str,
    body: impl FnOnce(&mut Instance) -> Answer,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    fmi3Status(unsafe { guarded(instance, function, body) })
}

impl Inner {
    /// Calls a function of the original that the repair does not touch.
    ///
    /// # Safety
    /// `F` is the type of the function, and `body` calls it as the host called this one.
    unsafe fn pass<F: Copy>(
        &mut self,
        function: &str,
        body: impl FnOnce(F, fmi3Instance) -> fmi3Status,
    ) -> Answer {
        // SAFETY: promised by the caller.
        match unsafe { self.library.function::<F>(function) } {
            Some(found) => Ok(body(found, self.instance).0),
            None => Err(missing(function)),
        }
    }
}

fn missing(function: &str) -> Notice {
    Notice::error(format!(
        "the original's library has no {function}, though the standard requires it"
    ))
}

/// Functions that go through as they are.
macro_rules! pass {
    ($($(#[$what:meta])* $function:ident: $kind:ty = ($($argument:ident: $type:ty),*);)*) => {
        $(
            $(#[$what])*
            pub unsafe extern "C" fn $function(instance: fmi3Instance, $($argument: $type),*) -> fmi3Status {
                const NAME: &str = stringify!($function);
                let body = |w: &mut Instance| {
                    w.touch();
                    // SAFETY: the function's own type, and the host's own arguments.
                    unsafe { w.original.pass::<$kind>(NAME, |f, inner| f(inner, $($argument),*)) }
                };
                // SAFETY: the contract of all functions here.
                unsafe { call(instance, NAME, body) }
            }
        )*
    };
}

/// Functions that are not offered.
macro_rules! never {
    ($why:literal: $($(#[$what:meta])* $function:ident($($argument:ident: $type:ty),*);)*) => {
        $(
            $(#[$what])*
            pub unsafe extern "C" fn $function(instance: fmi3Instance, $($argument: $type),*) -> fmi3Status {
                $(let _ = $argument;)*
                let body = |_: &mut Instance| Err(Notice::error($why));
                // SAFETY: the contract of all functions here.
                unsafe { call(instance, stringify!($function), body) }
            }
        )*
    };
}

mod derivative;
mod refused;
mod states;
mod values;

pub use derivative::*;
pub use refused::*;
pub use states::*;
pub use values::*;

/// Switches debug logging of the original; the repair's own messages always go out.
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: fmi3Instance,
    loggingOn: fmi3Boolean,
    nCategories: usize,
    categories: *const fmi3String,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's array of texts.
        let all = unsafe { texts(categories, nCategories, "categories")? };
        let passed: Vec<_> = all.iter().filter(|n| **n != CATEGORY).map(|n| n.as_ptr()).collect();
        if passed.is_empty() && !all.is_empty() {
            return Ok(OK);
        }
        let set = w.original.library.functions.set_debug_logging;
        let Some(set) = set else { return Err(missing("fmi3SetDebugLogging")) };
        // SAFETY: the instance is alive, the texts are the host's.
        Ok(unsafe { set(w.original.instance, loggingOn, passed.len(), passed.as_ptr()).0 })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3SetDebugLogging", body) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    instanceName: fmi3String,
    _instantiationToken: fmi3String,
    _resourcePath: fmi3String,
    _visible: fmi3Boolean,
    _loggingOn: fmi3Boolean,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: Option<fmi3LogMessageCallback>,
) -> fmi3Instance {
    // SAFETY: the caller's text.
    unsafe { refuse("fmi3InstantiateModelExchange", instanceName, instanceEnvironment, logMessage) }
}

/// Says that only co-simulation is offered.
///
/// # Safety
/// The name and the logger are the host's.
unsafe fn refuse(
    function: &str,
    name: fmi3String,
    environment: fmi3InstanceEnvironment,
    logger: Option<fmi3LogMessageCallback>,
) -> fmi3Instance {
    // SAFETY: the caller's text.
    let name = unsafe { text(name) };
    instantiate::<Inner>(function, name, Sink::v3(logger, environment), || {
        Err(Notice::error("a repaired FMU offers co-simulation only"))
    })
}

/// Makes an instance of the original and puts the effects around it.
pub unsafe fn fmi3InstantiateCoSimulation(
    instanceName: fmi3String,
    instantiationToken: fmi3String,
    resourcePath: fmi3String,
    visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    eventModeUsed: fmi3Boolean,
    _earlyReturnAllowed: fmi3Boolean,
    _requiredIntermediateVariables: *const fmi3ValueReference,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: Option<fmi3LogMessageCallback>,
    _intermediateUpdate: Option<fmi3IntermediateUpdateCallback>,
) -> fmi3Instance {
    let sink = Sink::v3(logMessage, instanceEnvironment);
    // SAFETY: the caller's texts.
    let (name, token, path) =
        unsafe { (text(instanceName), text(instantiationToken), text(resourcePath)) };
    instantiate("fmi3InstantiateCoSimulation", name, sink, || {
        if eventModeUsed || nRequiredIntermediateVariables > 0 {
            return Err(Notice::error(
                "event mode and intermediate variables are not offered through a repair",
            ));
        }
        let location = path.map_or(Location::None, |path| Location::Path(path.to_bytes()));
        let files = Files::read(location, "3.0", token)?;
        let library = Library::load(&files.library(PLATFORM_V3))
            .map_err(|e| Notice::error(format!("the original inside: {e}")))?;
        let (token, resources) = (files.token()?, files.resources_path()?);
        // SAFETY: texts end with a zero byte; environment and logger are the host's.
        let inner = unsafe {
            (library.functions.instantiate_co_simulation)(
                name.map_or(std::ptr::null(), CStr::as_ptr),
                token.as_ptr(),
                resources.as_ptr(),
                visible,
                loggingOn,
                fmi3False,
                fmi3False,
                std::ptr::null(),
                0,
                instanceEnvironment,
                logMessage,
                None,
            )
        };
        if inner.is_null() {
            return Err(Notice::error(format!(
                "the original inside, {}, cannot be instantiated; its own message, if there is one, precedes this one",
                library.path().display()
            )));
        }
        let flags = StepFlags::default();
        let original = Inner { instance: inner, library, no_way_back: fmi3False, flags };
        Ok((original, files.surround))
    })
}

/// Refused: scheduled execution is not offered.
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    instanceName: fmi3String,
    _instantiationToken: fmi3String,
    _resourcePath: fmi3String,
    _visible: fmi3Boolean,
    _loggingOn: fmi3Boolean,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: Option<fmi3LogMessageCallback>,
    _clockUpdate: Option<fmi3ClockUpdateCallback>,
    _lockPreemption: Option<fmi3LockPreemptionCallback>,
    _unlockPreemption: Option<fmi3UnlockPreemptionCallback>,
) -> fmi3Instance {
    const NAME: &str = "fmi3InstantiateScheduledExecution";
    // SAFETY: the caller's text.
    unsafe { refuse(NAME, instanceName, instanceEnvironment, logMessage) }
}

/// Frees an instance, its states, and the original.
pub unsafe extern "C" fn fmi3FreeInstance(instance: fmi3Instance) {
    // SAFETY: the contract of all functions here.
    unsafe { guard::free::<Instance>(instance, state_calls::free_all) }
}

/// Brings effects on parameters to the original and goes through.
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: fmi3Instance,
    toleranceDefined: fmi3Boolean,
    tolerance: fmi3Float64,
    startTime: fmi3Float64,
    stopTimeDefined: fmi3Boolean,
    stopTime: fmi3Float64,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        w.preset()?;
        let code = w.before_entering();
        if code >= DISCARD {
            return Ok(code);
        }
        let enter = w.original.library.functions.enter_initialization_mode;
        let inner = w.original.instance;
        // SAFETY: the instance is alive.
        let entered = unsafe {
            enter(inner, toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime).0
        };
        if entered < DISCARD {
            w.entered();
        }
        Ok(code.max(entered))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3EnterInitializationMode", body) }
}

/// Brings effects to rest and goes through.
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: fmi3Instance) -> fmi3Status {
    let body = |w: &mut Instance| {
        let code = w.before_leaving();
        if code >= DISCARD {
            return Ok(code);
        }
        let exit = w.original.library.functions.exit_initialization_mode;
        // SAFETY: the instance is alive.
        let code = code.max(unsafe { exit(w.original.instance).0 });
        if code >= DISCARD {
            return Ok(code);
        }
        Ok(code.max(w.left()))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3ExitInitializationMode", body) }
}

never! {
    "event mode is not offered through a repair":
    /// Not offered.
    fmi3EnterEventMode();
}

pass! {
    /// Goes through.
    fmi3Terminate: fmi3TerminateTYPE = ();
}

/// Goes through; effects go back to their start values.
pub unsafe extern "C" fn fmi3Reset(instance: fmi3Instance) -> fmi3Status {
    let body = |w: &mut Instance| {
        let Some(reset) = w.original.library.functions.reset else {
            return Err(missing("fmi3Reset"));
        };
        // SAFETY: the instance is alive.
        let code = unsafe { reset(w.original.instance).0 };
        w.was_reset();
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3Reset", body) }
}

/// Computes one communication step.
pub unsafe extern "C" fn fmi3DoStep(
    instance: fmi3Instance,
    currentCommunicationPoint: fmi3Float64,
    communicationStepSize: fmi3Float64,
    noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
    eventHandlingNeeded: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
    earlyReturn: *mut fmi3Boolean,
    lastSuccessfulTime: *mut fmi3Float64,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's room for one value each.
        let (event, terminate, early, last) = unsafe {
            (
                Room::new(eventHandlingNeeded, 1, "eventHandlingNeeded")?,
                Room::new(terminateSimulation, 1, "terminateSimulation")?,
                Room::new(earlyReturn, 1, "earlyReturn")?,
                Room::new(lastSuccessfulTime, 1, "lastSuccessfulTime")?,
            )
        };
        w.original.no_way_back = noSetFMUStatePriorToCurrentPoint;
        let code = w.step(currentCommunicationPoint, communicationStepSize);
        let flags = w.original.flags;
        // SAFETY: as above.
        unsafe {
            event.write(0, flags.event != 0);
            terminate.write(0, flags.terminate != 0);
            early.write(0, flags.early != 0);
            last.write(0, flags.time);
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3DoStep", body) }
}

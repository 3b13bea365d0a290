//! The functions of FMI 2.0 of a repaired FMU, in the order of the header.
//!
//! # Safety
//! The contract of all functions of [`export::v2`](crate::export::v2).
#![allow(
    non_snake_case,
    non_upper_case_globals,
    clippy::missing_safety_doc,
    clippy::too_many_arguments
)]

use std::ffi::{CStr, CString};

use super::core::{
    Answer, CATEGORY, Code, DISCARD, OK, Original, Wrapped, call as guarded, instantiate,
};
use super::file::{Files, PLATFORM_V2};
use super::state_calls::{self, States};
use crate::export::arguments::{Room, array, text, texts};
use crate::export::guard;
use crate::export::log::Sink;
use crate::export::notice::Notice;
use crate::export::resources::Location;
use crate::fmi2::*;
use crate::import::v2::Library;

pub use crate::export::v2::{fmi2GetTypesPlatform, fmi2GetVersion};

/// The original.
struct Inner {
    component: fmi2Component,
    library: Library,
    /// Whether the host promises not to go back before the current point.
    no_way_back: fmi2Boolean,
    /// What the original was given; some keep the pointer.
    _callbacks: Option<Box<fmi2CallbackFunctions>>,
}

type Instance = Wrapped<Inner>;

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: an instance of this library, never used again.
        unsafe { (self.library.functions.free_instance)(self.component) }
    }
}

impl Original for Inner {
    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Code {
        let get = self.library.functions.get_real;
        // SAFETY: the instance is alive, both arrays have this length.
        unsafe { get(self.component, references.as_ptr(), references.len(), values.as_mut_ptr()).0 }
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Code {
        let set = self.library.functions.set_real;
        // SAFETY: the instance is alive, both arrays have this length.
        unsafe { set(self.component, references.as_ptr(), references.len(), values.as_ptr()).0 }
    }

    fn step(&mut self, time: f64, step: f64) -> (Code, bool) {
        let do_step = self.library.functions.do_step;
        // SAFETY: the instance is alive.
        (unsafe { do_step(self.component, time, step, self.no_way_back).0 }, true)
    }
}

/// One call.
///
/// # Safety
/// The contract of all functions here.
unsafe fn call(
    c: fmi2Component,
    function: &str,
    body: impl FnOnce(&mut Instance) -> Answer,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    fmi2Status(unsafe { guarded(c, function, body) })
}

impl Inner {
    /// Calls a function of the original that the repair does not touch.
    ///
    /// # Safety
    /// `F` is the type of the function, and `body` calls it as the host called this one.
    unsafe fn pass<F: Copy>(
        &mut self,
        function: &str,
        body: impl FnOnce(F, fmi2Component) -> fmi2Status,
    ) -> Answer {
        // SAFETY: promised by the caller.
        match unsafe { self.library.function::<F>(function) } {
            Some(found) => Ok(body(found, self.component).0),
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
            pub unsafe extern "C" fn $function(c: fmi2Component, $($argument: $type),*) -> fmi2Status {
                const NAME: &str = stringify!($function);
                let body = |w: &mut Instance| {
                    // SAFETY: the function's own type, and the host's own arguments.
                    unsafe { w.original.pass::<$kind>(NAME, |f, inner| f(inner, $($argument),*)) }
                };
                // SAFETY: the contract of all functions here.
                unsafe { call(c, NAME, body) }
            }
        )*
    };
}

/// Functions that are not offered.
macro_rules! never {
    ($($(#[$what:meta])* $function:ident($($argument:ident: $type:ty),*) = $why:literal;)*) => {
        $(
            $(#[$what])*
            pub unsafe extern "C" fn $function(c: fmi2Component, $($argument: $type),*) -> fmi2Status {
                let body = |_: &mut Instance| Err(Notice::error($why));
                // SAFETY: the contract of all functions here.
                unsafe { call(c, stringify!($function), body) }
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
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: fmi2Component,
    loggingOn: fmi2Boolean,
    nCategories: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's array of texts.
        let all = unsafe { texts(categories, nCategories, "categories")? };
        let passed: Vec<_> = all.iter().filter(|n| **n != CATEGORY).map(|n| n.as_ptr()).collect();
        if passed.is_empty() && !all.is_empty() {
            return Ok(OK);
        }
        let set = w.original.library.functions.set_debug_logging;
        let Some(set) = set else { return Err(missing("fmi2SetDebugLogging")) };
        // SAFETY: the instance is alive, the texts are the host's.
        Ok(unsafe { set(w.original.component, loggingOn, passed.len(), passed.as_ptr()).0 })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2SetDebugLogging", body) }
}

/// Makes an instance of the original and puts the effects around it.
pub unsafe fn fmi2Instantiate(
    instanceName: fmi2String,
    fmuType: fmi2Type,
    fmuGUID: fmi2String,
    fmuResourceLocation: fmi2String,
    functions: *const fmi2CallbackFunctions,
    visible: fmi2Boolean,
    loggingOn: fmi2Boolean,
) -> fmi2Component {
    // SAFETY: the caller's texts and its structure, which is copied.
    let (name, token, uri, callbacks) = unsafe {
        (text(instanceName), text(fmuGUID), text(fmuResourceLocation), functions.as_ref().copied())
    };
    instantiate("fmi2Instantiate", name, Sink::v2(callbacks), || {
        if fmuType != fmi2CoSimulation {
            return Err(Notice::error("a repaired FMU offers co-simulation only"));
        }
        let location = uri.map_or(Location::None, |uri| Location::Uri(uri.to_bytes()));
        let files = Files::read(location, "2.0", token)?;
        // SAFETY: the host's own texts.
        let original = unsafe { inner(&files, name, callbacks.map(Box::new), visible, loggingOn)? };
        Ok((original, files.surround))
    })
}

/// Loads and instantiates the original.
///
/// # Safety
/// The callbacks are the host's.
unsafe fn inner(
    files: &Files,
    name: Option<&CStr>,
    mut callbacks: Option<Box<fmi2CallbackFunctions>>,
    visible: fmi2Boolean,
    logging_on: fmi2Boolean,
) -> Result<Inner, Notice> {
    let library = Library::load(&files.library(PLATFORM_V2))
        .map_err(|e| Notice::error(format!("the original inside: {e}")))?;
    if let Some(callbacks) = &mut callbacks {
        // A step is over when the function returns, here as in the original.
        callbacks.stepFinished = None;
    }
    let pointer: *const fmi2CallbackFunctions =
        callbacks.as_deref().map_or(std::ptr::null(), std::ptr::from_ref);
    let (token, resources): (CString, CString) = (files.token()?, files.resources_uri()?);
    // SAFETY: texts end with a zero byte; the callbacks live as long as the instance.
    let component = unsafe {
        (library.functions.instantiate)(
            name.map_or(std::ptr::null(), CStr::as_ptr),
            fmi2CoSimulation,
            token.as_ptr(),
            resources.as_ptr(),
            pointer,
            visible,
            logging_on,
        )
    };
    if component.is_null() {
        return Err(Notice::error(format!(
            "the original inside, {}, cannot be instantiated; its own message, if there is one, precedes this one",
            library.path().display()
        )));
    }
    Ok(Inner { component, library, no_way_back: fmi2False, _callbacks: callbacks })
}

/// Frees an instance, its states, and the original.
pub unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
    // SAFETY: the contract of all functions here.
    unsafe { guard::free::<Instance>(c, state_calls::free_all) }
}

pass! {
    /// Goes through.
    fmi2SetupExperiment: fmi2SetupExperimentTYPE = (toleranceDefined: fmi2Boolean, tolerance: fmi2Real, startTime: fmi2Real, stopTimeDefined: fmi2Boolean, stopTime: fmi2Real);
}

/// Brings effects on parameters to the original and goes through.
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status {
    let body = |w: &mut Instance| {
        w.preset()?;
        let code = w.before_entering();
        if code >= DISCARD {
            return Ok(code);
        }
        let enter = w.original.library.functions.enter_initialization_mode;
        // SAFETY: the instance is alive.
        let code = code.max(unsafe { enter(w.original.component).0 });
        if code < DISCARD {
            w.entered();
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2EnterInitializationMode", body) }
}

/// Brings effects to rest and goes through.
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status {
    let body = |w: &mut Instance| {
        let code = w.before_leaving();
        if code >= DISCARD {
            return Ok(code);
        }
        let exit = w.original.library.functions.exit_initialization_mode;
        // SAFETY: the instance is alive.
        let code = code.max(unsafe { exit(w.original.component).0 });
        if code >= DISCARD {
            return Ok(code);
        }
        Ok(code.max(w.left()))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2ExitInitializationMode", body) }
}

pass! {
    /// Goes through.
    fmi2Terminate: fmi2TerminateTYPE = ();
}

/// Goes through; effects go back to their start values.
pub unsafe extern "C" fn fmi2Reset(c: fmi2Component) -> fmi2Status {
    let body = |w: &mut Instance| {
        let Some(reset) = w.original.library.functions.reset else {
            return Err(missing("fmi2Reset"));
        };
        // SAFETY: the instance is alive.
        let code = unsafe { reset(w.original.component).0 };
        w.was_reset();
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2Reset", body) }
}

/// Computes one communication step.
pub unsafe extern "C" fn fmi2DoStep(
    c: fmi2Component,
    currentCommunicationPoint: fmi2Real,
    communicationStepSize: fmi2Real,
    noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
) -> fmi2Status {
    let body = |w: &mut Instance| {
        w.original.no_way_back = noSetFMUStatePriorToCurrentPoint;
        Ok(w.step(currentCommunicationPoint, communicationStepSize))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2DoStep", body) }
}

pass! {
    /// Goes through.
    fmi2CancelStep: fmi2CancelStepTYPE = ();
    /// Goes through.
    fmi2GetStatus: fmi2GetStatusTYPE = (s: fmi2StatusKind, value: *mut fmi2Status);
    /// Goes through.
    fmi2GetRealStatus: fmi2GetRealStatusTYPE = (s: fmi2StatusKind, value: *mut fmi2Real);
    /// Goes through.
    fmi2GetIntegerStatus: fmi2GetIntegerStatusTYPE = (s: fmi2StatusKind, value: *mut fmi2Integer);
    /// Goes through.
    fmi2GetBooleanStatus: fmi2GetBooleanStatusTYPE = (s: fmi2StatusKind, value: *mut fmi2Boolean);
    /// Goes through.
    fmi2GetStringStatus: fmi2GetStringStatusTYPE = (s: fmi2StatusKind, value: *mut fmi2String);
}

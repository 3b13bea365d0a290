//! The functions of FMI 3.0 for co-simulation, in the order of the header `fmi3Functions.h`.
//!
//! The same [`Instance`] as behind [`v2`](super::v2). Variables whose names differ in their last index
//! alone are one array ([`model::VariableTable::bundles`]) with the value reference that its first
//! element has in FMI 2.0; the references of the other elements are unknown. All other variables are
//! scalars with the references of FMI 2.0; the independent variable `time`, which FMI 3.0 demands,
//! has the reference behind the last of them ([`time_reference`]). Not offered, and refused with a
//! message: event mode, clocks, structural parameters, adjoint derivatives.
//! Declined, as the standard has it: early return (a step always goes to its end) and intermediate
//! update (the callback is never called).
//!
//! # Safety
//! The contract of all functions is the standard's, as in [`v2`](super::v2).
#![allow(
    non_snake_case,
    non_upper_case_globals,
    clippy::missing_safety_doc,
    clippy::too_many_arguments
)]

mod modes;
mod symbols;
mod table;
mod values;

use std::ffi::{c_char, c_void};

use model::{DataType, VariableTable};

use super::arguments::{Room, array, text, texts};
use super::guard;
use super::instance::Request;
use super::log::{Logger, Sink};
use super::notice::{Notice, Outcome, Status};
use super::resources::Location;
use super::{Factory, Instance, Rule, state_calls};
use crate::fmi3::*;
pub use modes::*;
pub use table::TABLE;
use table::*;
pub use values::*;

/// The value reference of the independent variable `time` of a model with these variables.
#[must_use]
pub fn time_reference(variables: &VariableTable) -> fmi3ValueReference {
    variables.len() as fmi3ValueReference
}

/// One call, by the rules of the table.
///
/// # Safety
/// The contract of all functions here.
unsafe fn call(
    instance: fmi3Instance,
    rule: &Rule,
    body: impl FnOnce(&mut Instance) -> Outcome,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    fmi3Status(unsafe { Instance::call(instance, rule, body) } as u32)
}

/// A function that the table allows in no state.
///
/// # Safety
/// The contract of all functions here.
unsafe fn never(instance: fmi3Instance, rule: &Rule) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, rule, |_| Err(Notice::error("is not offered"))) }
}

// Inquire version numbers and setting logging status

/// The version of the standard: `3.0`.
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    fmi3Version.as_ptr()
}

/// Switches debug logging, for all categories or for some.
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: fmi3Instance,
    loggingOn: fmi3Boolean,
    nCategories: usize,
    categories: *const fmi3String,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's array of texts.
        let categories = unsafe { texts(categories, nCategories, "categories")? };
        instance.set_debug_logging(loggingOn, &categories)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_DEBUG_LOGGING, body) }
}

// Creation and destruction of FMU instances

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
    let why = "model exchange is not offered; call fmi3InstantiateCoSimulation";
    let sink = Sink::v3(logMessage, instanceEnvironment);
    // SAFETY: the caller's text.
    unsafe { refuse("fmi3InstantiateModelExchange", instanceName, sink, why) }
}

/// Makes an instance of the model that `factory` builds; null where that fails, and the logger has
/// the reason.
pub unsafe fn fmi3InstantiateCoSimulation(
    factory: Factory,
    instanceName: fmi3String,
    instantiationToken: fmi3String,
    resourcePath: fmi3String,
    _visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    eventModeUsed: fmi3Boolean,
    _earlyReturnAllowed: fmi3Boolean,
    _requiredIntermediateVariables: *const fmi3ValueReference,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: Option<fmi3LogMessageCallback>,
    _intermediateUpdate: Option<fmi3IntermediateUpdateCallback>,
) -> fmi3Instance {
    // SAFETY: the caller's texts.
    let (name, token, path) =
        unsafe { (text(instanceName), text(instantiationToken), text(resourcePath)) };
    let sink = Sink::v3(logMessage, instanceEnvironment);
    let built = guard::caught(|| {
        if eventModeUsed {
            return Err(Notice::error(
                "event mode is not offered (hasEventMode = false); set eventModeUsed to false",
            ));
        }
        if nRequiredIntermediateVariables > 0 {
            return Err(Notice::error(
                "intermediate update is not offered (providesIntermediateUpdate = false); \
                 require no intermediate variables",
            ));
        }
        let request = Request {
            name,
            token,
            token_name: "instantiationToken",
            has_arrays_and_time: true,
            location: path.map_or(Location::None, |path| Location::Path(path.to_bytes())),
            sink,
            logging_on: loggingOn,
        };
        Instance::new(&request, factory)
    });
    match built {
        Ok(instance) => Box::into_raw(instance).cast::<c_void>(),
        Err(notice) => {
            // SAFETY: the caller's text.
            unsafe { refuse("fmi3InstantiateCoSimulation", instanceName, sink, &notice.message) }
        }
    }
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
    let why = "scheduled execution is not offered; call fmi3InstantiateCoSimulation";
    let sink = Sink::v3(logMessage, instanceEnvironment);
    // SAFETY: the caller's text.
    unsafe { refuse("fmi3InstantiateScheduledExecution", instanceName, sink, why) }
}

/// No instance, and the reason to the logger: it is sent even where logging is off, because the
/// standard demands a message with each null pointer (§2.3.1).
///
/// # Safety
/// The contract of all functions here.
unsafe fn refuse(function: &str, name: fmi3String, sink: Sink, why: &str) -> fmi3Instance {
    // SAFETY: the caller's text.
    let name = unsafe { text(name) }.unwrap_or(c"").into();
    let outcome = guard::caught(|| {
        Logger::new(sink, name, true).send(Status::Error, &format!("{function}: {why}"));
        Ok(())
    });
    drop(outcome);
    std::ptr::null_mut()
}

/// Frees an instance and the states it saved.
pub unsafe extern "C" fn fmi3FreeInstance(instance: fmi3Instance) {
    // SAFETY: the contract of all functions here.
    unsafe { guard::free::<Instance>(instance, |_| ()) }
}

// Enter and exit initialization mode, enter event mode, terminate and reset

/// Takes over start and stop time; from now on outputs follow inputs and parameters.
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: fmi3Instance,
    _toleranceDefined: fmi3Boolean,
    _tolerance: fmi3Float64,
    startTime: fmi3Float64,
    stopTimeDefined: fmi3Boolean,
    stopTime: fmi3Float64,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        instance.set_up(startTime, stopTimeDefined.then_some(stopTime))?;
        instance.enter_initialization()
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &ENTER_INITIALIZATION_MODE, body) }
}

/// The model is at rest under its inputs and ready to step.
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &EXIT_INITIALIZATION_MODE, Instance::exit_initialization) }
}

/// Refused: event mode is not offered.
pub unsafe extern "C" fn fmi3EnterEventMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &ENTER_EVENT_MODE) }
}

/// Ends the simulation; values can still be read.
pub unsafe extern "C" fn fmi3Terminate(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &TERMINATE, Instance::terminate) }
}

/// Back to the state right after instantiation.
pub unsafe extern "C" fn fmi3Reset(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &RESET, Instance::reset) }
}

mod co_simulation;
mod states;
pub use co_simulation::*;
pub use states::*;

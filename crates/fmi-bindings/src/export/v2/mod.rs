//! The functions of FMI 2.0.5 for co-simulation, in the order of the header `fmi2Functions.h`.
//!
//! Each turns C arguments into slices, asks the call table, lets the [`Instance`] do the work and
//! returns its status. [`export_fmi2!`](crate::export_fmi2) gives them their names in a library.
//!
//! # Safety
//! The contract of all functions is the standard's: `c` is null or an instance of this library that
//! is not freed, no two threads use one instance at once, arrays have the stated lengths, texts end
//! with a zero byte, and an FMU state is null or one of this library that is not freed. Null
//! pointers are answered with an error wherever something is needed.
#![allow(
    non_snake_case,
    non_upper_case_globals,
    clippy::missing_safety_doc,
    clippy::too_many_arguments
)]

mod symbols;
mod table;

use std::ffi::{c_char, c_void};

use model::DataType;

use super::arguments::{Room, array, text, texts};
use super::guard;
use super::instance::Request;
use super::log::{Logger, Sink};
use super::notice::{Notice, Outcome};
use super::resources::Location;
use super::{Factory, Instance, Rule, state_calls};
use crate::fmi2::*;
pub use table::TABLE;
use table::*;

/// One call, by the rules of the table.
///
/// # Safety
/// The contract of all functions here.
unsafe fn call(
    c: fmi2Component,
    rule: &Rule,
    body: impl FnOnce(&mut Instance) -> Outcome,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    fmi2Status(unsafe { Instance::call(c, rule, body) } as u32)
}

// Inquire version numbers of header files and setting logging status

/// The platform of the types: `default`.
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    fmi2TypesPlatform.as_ptr()
}

/// The version of the standard: `2.0`.
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    fmi2Version.as_ptr()
}

/// Switches debug logging, for all categories or for some.
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: fmi2Component,
    loggingOn: fmi2Boolean,
    nCategories: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        let on = loggingOn != fmi2False;
        // SAFETY: the caller's array of texts.
        let categories = unsafe { texts(categories, nCategories, "categories")? };
        instance.set_debug_logging(on, &categories)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &SET_DEBUG_LOGGING, body) }
}

// Creation and destruction of FMU instances

/// Makes an instance of the model that `factory` builds; null where that fails, and the logger has
/// the reason.
pub unsafe fn fmi2Instantiate(
    factory: Factory,
    instanceName: fmi2String,
    fmuType: fmi2Type,
    fmuGUID: fmi2String,
    fmuResourceLocation: fmi2String,
    functions: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    loggingOn: fmi2Boolean,
) -> fmi2Component {
    // SAFETY: the caller's texts and its structure, which is copied because it is only good during
    // this call.
    let (name, token, uri, sink) = unsafe {
        let sink = Sink::v2(functions.as_ref().copied());
        (text(instanceName), text(fmuGUID), text(fmuResourceLocation), sink)
    };
    let built = guard::caught(|| {
        if fmuType != fmi2CoSimulation {
            return Err(Notice::error(
                "this FMU offers co-simulation only; instantiate it with fmi2CoSimulation",
            ));
        }
        let request = Request {
            name,
            token,
            token_name: "GUID",
            has_arrays_and_time: false,
            location: uri.map_or(Location::None, |uri| Location::Uri(uri.to_bytes())),
            sink,
            logging_on: loggingOn != fmi2False,
        };
        Instance::new(&request, factory)
    });
    match built {
        Ok(instance) => Box::into_raw(instance).cast::<c_void>(),
        Err(notice) => {
            let name = name.unwrap_or(c"").into();
            let message = format!("fmi2Instantiate: {}", notice.message);
            Logger::new(sink, name, false).send(notice.status, &message);
            std::ptr::null_mut()
        }
    }
}

/// Frees an instance and the states it saved.
pub unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
    // SAFETY: the contract of all functions here.
    unsafe { guard::free::<Instance>(c, |_| ()) }
}

// Enter and exit initialization mode, terminate and reset

/// Takes over the start time and, where defined, the stop time.
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: fmi2Component,
    _toleranceDefined: fmi2Boolean,
    _tolerance: fmi2Real,
    startTime: fmi2Real,
    stopTimeDefined: fmi2Boolean,
    stopTime: fmi2Real,
) -> fmi2Status {
    let stop = (stopTimeDefined != fmi2False).then_some(stopTime);
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &SETUP_EXPERIMENT, |instance| instance.set_up(startTime, stop)) }
}

/// From now on outputs follow inputs and parameters.
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &ENTER_INITIALIZATION_MODE, Instance::enter_initialization) }
}

/// The model is at rest under its inputs and ready to step.
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &EXIT_INITIALIZATION_MODE, Instance::exit_initialization) }
}

/// Ends the simulation; values can still be read.
pub unsafe extern "C" fn fmi2Terminate(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &TERMINATE, Instance::terminate) }
}

/// Back to the state right after instantiation.
pub unsafe extern "C" fn fmi2Reset(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &RESET, Instance::reset) }
}

// Getting and setting variable values

/// Reads Real variables.
pub unsafe extern "C" fn fmi2GetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let (vr, room) = unsafe { (array(vr, nvr, "vr")?, Room::new(value, nvr, "value")?) };
        // SAFETY: positions are those of `vr`.
        instance.get(DataType::Real, vr, |at, value| unsafe { room.write(at, value) })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_REAL, body) }
}

/// Reads Integer variables.
pub unsafe extern "C" fn fmi2GetInteger(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Integer,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let (vr, room) = unsafe { (array(vr, nvr, "vr")?, Room::new(value, nvr, "value")?) };
        // SAFETY: positions are those of `vr`.
        let write = |at, value: f64| unsafe { room.write(at, value as fmi2Integer) };
        instance.get(DataType::Integer, vr, write)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_INTEGER, body) }
}

/// Reads Boolean variables.
pub unsafe extern "C" fn fmi2GetBoolean(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let (vr, room) = unsafe { (array(vr, nvr, "vr")?, Room::new(value, nvr, "value")?) };
        // SAFETY: positions are those of `vr`.
        let write = |at, value| unsafe { room.write(at, fmi2Boolean::from(value != 0.0)) };
        instance.get(DataType::Boolean, vr, write)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_BOOLEAN, body) }
}

/// Reads String variables, of which there are none.
pub unsafe extern "C" fn fmi2GetString(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_STRING, |instance| no_variables(instance, vr, nvr, "String")) }
}

/// Sets Real variables, all or none.
pub unsafe extern "C" fn fmi2SetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let (vr, value) = unsafe { (array(vr, nvr, "vr")?, array(value, nvr, "value")?) };
        instance.set(DataType::Real, vr, value.iter().copied())
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &SET_REAL, body) }
}

/// Sets Integer variables, all or none.
pub unsafe extern "C" fn fmi2SetInteger(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Integer,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let (vr, value) = unsafe { (array(vr, nvr, "vr")?, array(value, nvr, "value")?) };
        instance.set(DataType::Integer, vr, value.iter().map(|value| f64::from(*value)))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &SET_INTEGER, body) }
}

/// Sets Boolean variables, all or none; everything but `fmi2False` is true.
pub unsafe extern "C" fn fmi2SetBoolean(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Boolean,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let (vr, value) = unsafe { (array(vr, nvr, "vr")?, array(value, nvr, "value")?) };
        let truth = |value: &fmi2Boolean| f64::from(u8::from(*value != fmi2False));
        instance.set(DataType::Boolean, vr, value.iter().map(truth))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &SET_BOOLEAN, body) }
}

/// Sets String variables, of which there are none.
pub unsafe extern "C" fn fmi2SetString(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *const fmi2String,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &SET_STRING, |instance| no_variables(instance, vr, nvr, "String")) }
}

/// The answer about variables of a type that no model here has.
fn no_variables(
    instance: &Instance,
    vr: *const fmi2ValueReference,
    nvr: usize,
    type_name: &str,
) -> Outcome {
    // SAFETY: the caller's array of `nvr` elements.
    match unsafe { array(vr, nvr, "vr")? } {
        [] => Ok(()),
        [first, ..] => Err(instance.unknown(*first, type_name)),
    }
}

// Getting and setting the internal FMU state

/// Saves the state, into `*FMUstate` where that is not null.
pub unsafe extern "C" fn fmi2GetFMUstate(
    c: fmi2Component,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: the caller's state and pointers.
    let body = |instance: &mut Instance| unsafe { state_calls::get(instance, FMUstate) };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_FMU_STATE, body) }
}

/// Goes back to a saved state, which stays saved.
pub unsafe extern "C" fn fmi2SetFMUstate(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status {
    // SAFETY: the caller's state and pointers.
    let body = |instance: &mut Instance| unsafe { state_calls::set(instance, FMUstate) };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &SET_FMU_STATE, body) }
}

/// Frees a saved state and sets the pointer to null; null is ignored.
pub unsafe extern "C" fn fmi2FreeFMUstate(
    c: fmi2Component,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: the caller's state and pointers.
    let body = |instance: &mut Instance| unsafe { state_calls::free(instance, FMUstate) };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &FREE_FMU_STATE, body) }
}

/// Number of bytes of a saved state.
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    // SAFETY: the caller's state and pointers.
    let body =
        |instance: &mut Instance| unsafe { state_calls::serialized_size(instance, FMUstate, size) };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &SERIALIZED_FMU_STATE_SIZE, body) }
}

/// A saved state as bytes.
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    serializedState: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    // SAFETY: the caller's state and pointers.
    let body = |instance: &mut Instance| unsafe {
        state_calls::serialize(instance, FMUstate, serializedState.cast(), size)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &SERIALIZE_FMU_STATE, body) }
}

/// A saved state from bytes, into `*FMUstate` where that is not null. It is not yet the current one.
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: fmi2Component,
    serializedState: *const fmi2Byte,
    size: usize,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: the caller's state and pointers.
    let body = |instance: &mut Instance| unsafe {
        state_calls::deserialize(instance, serializedState.cast(), size, FMUstate)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &DESERIALIZE_FMU_STATE, body) }
}

// Getting partial derivatives

/// The derivative of Real outputs in a direction of Real knowns.
///
/// In a step (from the first `fmi2DoStep` on) the outputs are those of the last step,
/// `y = f_doStep(u, …)` of FMI 2.0.5 §4.1.2, and the knowns are the inputs that were held over it; in
/// Initialization Mode they are those at rest, `f_init`, and the knowns are inputs and parameters.
/// Discarded where an output jumps.
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: fmi2Component,
    vUnknown_ref: *const fmi2ValueReference,
    nUnknown: usize,
    vKnown_ref: *const fmi2ValueReference,
    nKnown: usize,
    dvKnown: *const fmi2Real,
    dvUnknown: *mut fmi2Real,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays of `nUnknown` and `nKnown` elements.
        let (unknowns, knowns, seed, room) = unsafe {
            (
                array(vUnknown_ref, nUnknown, "vUnknown_ref")?,
                array(vKnown_ref, nKnown, "vKnown_ref")?,
                array(dvKnown, nKnown, "dvKnown")?,
                Room::new(dvUnknown, nUnknown, "dvUnknown")?,
            )
        };
        // SAFETY: positions are those of the unknowns.
        let write = |at, value| unsafe { room.write(at, value) };
        instance.directional_derivative(knowns, seed, unknowns, write)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_DIRECTIONAL_DERIVATIVE, body) }
}

/// A function that the table allows in no state.
///
/// # Safety
/// The contract of all functions here.
unsafe fn never(c: fmi2Component, rule: &Rule) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, rule, |_| Err(Notice::error("is not offered"))) }
}

mod co_simulation;
mod model_exchange;
pub use co_simulation::*;
pub use model_exchange::*;

//! A panic forced inside every function of both edges: the status is Error, the importer gets a message, and
//! the instance can be reset and freed.

use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_void};
use std::mem::zeroed;
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use super::{v2, v3};
use crate::fmi2::*;
use crate::fmi3::*;

#[path = "../../tests/support/components.rs"]
#[allow(dead_code, unreachable_pub)]
mod components;

thread_local! {
    static WANTED: Cell<bool> = const { Cell::new(false) };
}

/// Panics where a test of this thread wants it.
pub(super) fn strike() {
    assert!(!WANTED.replace(false), "a forced panic");
}

/// A function of an edge on an instance, all other arguments zero.
type Entry = (&'static str, fn(*mut c_void) -> u32);

/// A function with so many arguments behind the instance.
macro_rules! entry {
    ($edge:ident::$function:ident, $count:tt) => {
        (stringify!($function), |c| entry!(@call $edge::$function, c, $count))
    };
    (@call $edge:ident::$function:ident, $c:ident, 0) => { entry!(@do $edge::$function, $c) };
    (@call $edge:ident::$function:ident, $c:ident, 1) => { entry!(@do $edge::$function, $c, zeroed()) };
    (@call $edge:ident::$function:ident, $c:ident, 2) => { entry!(@do $edge::$function, $c, zeroed(), zeroed()) };
    (@call $edge:ident::$function:ident, $c:ident, 3) => { entry!(@do $edge::$function, $c, zeroed(), zeroed(), zeroed()) };
    (@call $edge:ident::$function:ident, $c:ident, 4) => { entry!(@do $edge::$function, $c, zeroed(), zeroed(), zeroed(), zeroed()) };
    (@call $edge:ident::$function:ident, $c:ident, 5) => { entry!(@do $edge::$function, $c, zeroed(), zeroed(), zeroed(), zeroed(), zeroed()) };
    (@call $edge:ident::$function:ident, $c:ident, 6) => { entry!(@do $edge::$function, $c, zeroed(), zeroed(), zeroed(), zeroed(), zeroed(), zeroed()) };
    (@call $edge:ident::$function:ident, $c:ident, 7) => { entry!(@do $edge::$function, $c, zeroed(), zeroed(), zeroed(), zeroed(), zeroed(), zeroed(), zeroed()) };
    (@call $edge:ident::$function:ident, $c:ident, 8) => { entry!(@do $edge::$function, $c, zeroed(), zeroed(), zeroed(), zeroed(), zeroed(), zeroed(), zeroed(), zeroed()) };
    (@call $edge:ident::$function:ident, $c:ident, 9) => { entry!(@do $edge::$function, $c, zeroed(), zeroed(), zeroed(), zeroed(), zeroed(), zeroed(), zeroed(), zeroed(), zeroed()) };
    (@do $edge:ident::$function:ident, $c:ident $(, $zero:expr)*) => {
        // SAFETY: the instance is alive; zeros are no arguments of length, null pointers, and the
        // status kind 0; nothing is read before the panic.
        unsafe { $edge::$function($c $(, $zero)*).0 as u32 }
    };
}

const ENTRIES_2: &[Entry] = &[
    entry!(v2::fmi2SetDebugLogging, 3),
    entry!(v2::fmi2SetupExperiment, 5),
    entry!(v2::fmi2EnterInitializationMode, 0),
    entry!(v2::fmi2ExitInitializationMode, 0),
    entry!(v2::fmi2Terminate, 0),
    entry!(v2::fmi2Reset, 0),
    entry!(v2::fmi2GetReal, 3),
    entry!(v2::fmi2GetInteger, 3),
    entry!(v2::fmi2GetBoolean, 3),
    entry!(v2::fmi2GetString, 3),
    entry!(v2::fmi2SetReal, 3),
    entry!(v2::fmi2SetInteger, 3),
    entry!(v2::fmi2SetBoolean, 3),
    entry!(v2::fmi2SetString, 3),
    entry!(v2::fmi2GetFMUstate, 1),
    entry!(v2::fmi2SetFMUstate, 1),
    entry!(v2::fmi2FreeFMUstate, 1),
    entry!(v2::fmi2SerializedFMUstateSize, 2),
    entry!(v2::fmi2SerializeFMUstate, 3),
    entry!(v2::fmi2DeSerializeFMUstate, 3),
    entry!(v2::fmi2GetDirectionalDerivative, 6),
    entry!(v2::fmi2SetRealInputDerivatives, 4),
    entry!(v2::fmi2GetRealOutputDerivatives, 4),
    entry!(v2::fmi2DoStep, 3),
    entry!(v2::fmi2CancelStep, 0),
    entry!(v2::fmi2GetStatus, 2),
    entry!(v2::fmi2GetRealStatus, 2),
    entry!(v2::fmi2GetIntegerStatus, 2),
    entry!(v2::fmi2GetBooleanStatus, 2),
    entry!(v2::fmi2GetStringStatus, 2),
    entry!(v2::fmi2EnterEventMode, 0),
    entry!(v2::fmi2NewDiscreteStates, 1),
    entry!(v2::fmi2EnterContinuousTimeMode, 0),
    entry!(v2::fmi2CompletedIntegratorStep, 3),
    entry!(v2::fmi2SetTime, 1),
    entry!(v2::fmi2SetContinuousStates, 2),
    entry!(v2::fmi2GetDerivatives, 2),
    entry!(v2::fmi2GetEventIndicators, 2),
    entry!(v2::fmi2GetContinuousStates, 2),
    entry!(v2::fmi2GetNominalsOfContinuousStates, 2),
];
const ENTRIES_3: &[Entry] = &[
    entry!(v3::fmi3SetDebugLogging, 3),
    entry!(v3::fmi3EnterInitializationMode, 5),
    entry!(v3::fmi3ExitInitializationMode, 0),
    entry!(v3::fmi3EnterEventMode, 0),
    entry!(v3::fmi3Terminate, 0),
    entry!(v3::fmi3Reset, 0),
    entry!(v3::fmi3GetFloat32, 4),
    entry!(v3::fmi3GetFloat64, 4),
    entry!(v3::fmi3GetInt8, 4),
    entry!(v3::fmi3GetUInt8, 4),
    entry!(v3::fmi3GetInt16, 4),
    entry!(v3::fmi3GetUInt16, 4),
    entry!(v3::fmi3GetInt32, 4),
    entry!(v3::fmi3GetUInt32, 4),
    entry!(v3::fmi3GetInt64, 4),
    entry!(v3::fmi3GetUInt64, 4),
    entry!(v3::fmi3GetBoolean, 4),
    entry!(v3::fmi3GetString, 4),
    entry!(v3::fmi3GetBinary, 5),
    entry!(v3::fmi3GetClock, 3),
    entry!(v3::fmi3SetFloat32, 4),
    entry!(v3::fmi3SetFloat64, 4),
    entry!(v3::fmi3SetInt8, 4),
    entry!(v3::fmi3SetUInt8, 4),
    entry!(v3::fmi3SetInt16, 4),
    entry!(v3::fmi3SetUInt16, 4),
    entry!(v3::fmi3SetInt32, 4),
    entry!(v3::fmi3SetUInt32, 4),
    entry!(v3::fmi3SetInt64, 4),
    entry!(v3::fmi3SetUInt64, 4),
    entry!(v3::fmi3SetBoolean, 4),
    entry!(v3::fmi3SetString, 4),
    entry!(v3::fmi3SetBinary, 5),
    entry!(v3::fmi3SetClock, 3),
    entry!(v3::fmi3GetNumberOfVariableDependencies, 2),
    entry!(v3::fmi3GetVariableDependencies, 6),
    entry!(v3::fmi3GetFMUState, 1),
    entry!(v3::fmi3SetFMUState, 1),
    entry!(v3::fmi3FreeFMUState, 1),
    entry!(v3::fmi3SerializedFMUStateSize, 2),
    entry!(v3::fmi3SerializeFMUState, 3),
    entry!(v3::fmi3DeserializeFMUState, 3),
    entry!(v3::fmi3GetDirectionalDerivative, 8),
    entry!(v3::fmi3GetAdjointDerivative, 8),
    entry!(v3::fmi3EnterConfigurationMode, 0),
    entry!(v3::fmi3ExitConfigurationMode, 0),
    entry!(v3::fmi3GetIntervalDecimal, 4),
    entry!(v3::fmi3GetIntervalFraction, 5),
    entry!(v3::fmi3GetShiftDecimal, 3),
    entry!(v3::fmi3GetShiftFraction, 4),
    entry!(v3::fmi3SetIntervalDecimal, 3),
    entry!(v3::fmi3SetIntervalFraction, 4),
    entry!(v3::fmi3SetShiftDecimal, 3),
    entry!(v3::fmi3SetShiftFraction, 4),
    entry!(v3::fmi3EvaluateDiscreteStates, 0),
    entry!(v3::fmi3UpdateDiscreteStates, 6),
    entry!(v3::fmi3EnterContinuousTimeMode, 0),
    entry!(v3::fmi3CompletedIntegratorStep, 3),
    entry!(v3::fmi3SetTime, 1),
    entry!(v3::fmi3SetContinuousStates, 2),
    entry!(v3::fmi3GetContinuousStateDerivatives, 2),
    entry!(v3::fmi3GetEventIndicators, 2),
    entry!(v3::fmi3GetContinuousStates, 2),
    entry!(v3::fmi3GetNominalsOfContinuousStates, 2),
    entry!(v3::fmi3GetNumberOfEventIndicators, 1),
    entry!(v3::fmi3GetNumberOfContinuousStates, 1),
    entry!(v3::fmi3ActivateModelPartition, 2),
    entry!(v3::fmi3EnterStepMode, 0),
    entry!(v3::fmi3GetOutputDerivatives, 5),
    entry!(v3::fmi3DoStep, 7),
];

fn factory(_: &std::path::Path) -> Result<model::System, String> {
    Ok(components::plant())
}

type Received = Mutex<Vec<String>>;

unsafe extern "C" fn receive_v3(
    environment: *mut c_void,
    _: fmi3Status,
    _: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the test's own list and a text of the edge.
    unsafe {
        let text = CStr::from_ptr(message).to_string_lossy().into_owned();
        (*environment.cast::<Received>()).lock().unwrap().push(text);
    }
}

/// Resources, with a blueprint that the factory does not read; and the token.
fn given() -> (tempfile::TempDir, CString) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(super::BLUEPRINT), "").unwrap();
    (folder, CString::new(components::plant().variables().fingerprint()).unwrap())
}

fn instance_2(folder: &std::path::Path, token: &CStr) -> fmi2Component {
    let place = CString::new(format!("file://{}", folder.display())).unwrap();
    let callbacks = fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: null_mut(),
    };
    let (token, place) = (token.as_ptr(), place.as_ptr());
    // SAFETY: good arguments.
    unsafe {
        v2::fmi2Instantiate(
            factory,
            c"it".as_ptr(),
            fmi2CoSimulation,
            token,
            place,
            &callbacks,
            0,
            0,
        )
    }
}

fn instance_3(folder: &std::path::Path, token: &CStr, received: &Received) -> fmi3Instance {
    let path = CString::new(format!("{}/", folder.display())).unwrap();
    let environment = std::ptr::from_ref(received).cast_mut().cast();
    let (name, token, path, no) = (c"it".as_ptr(), token.as_ptr(), path.as_ptr(), false);
    let (log, none) = (Some(receive_v3 as fmi3LogMessageCallback), None);
    // SAFETY: good arguments.
    unsafe {
        v3::fmi3InstantiateCoSimulation(
            factory,
            name,
            token,
            path,
            no,
            true,
            no,
            no,
            null(),
            0,
            environment,
            log,
            none,
        )
    }
}

#[test]
fn every_function_survives_a_panic_inside() {
    let (folder, token) = given();
    let received = Received::default();
    // A forced panic is no news.
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !info.to_string().contains("a forced panic") {
            usual(info);
        }
    }));
    let c = instance_2(folder.path(), &token);
    let i = instance_3(folder.path(), &token, &received);
    assert!(!c.is_null() && !i.is_null());
    for (name, entry) in ENTRIES_2 {
        WANTED.set(true);
        assert_eq!(i64::from(entry(c)), i64::from(fmi2Error.0), "{name}");
        assert!(!WANTED.get(), "{name} never came to the guard");
        // SAFETY: the instance is alive.
        assert_eq!(unsafe { v2::fmi2Reset(c) }, fmi2OK, "{name}");
    }
    for (name, entry) in ENTRIES_3 {
        received.lock().unwrap().clear();
        WANTED.set(true);
        assert_eq!(i64::from(entry(i)), i64::from(fmi3Error.0), "{name}");
        let messages = received.lock().unwrap().join("|");
        let right = messages.starts_with(&format!("{name}: internal defect"));
        assert!(right && messages.contains("a forced panic"), "{name}: {messages}");
        // SAFETY: the instance is alive.
        assert_eq!(unsafe { v3::fmi3Reset(i) }, fmi3OK, "{name}");
    }
    // An instance that is made or freed: no panic leaves these either.
    WANTED.set(true);
    assert!(instance_2(folder.path(), &token).is_null() && !WANTED.get());
    WANTED.set(true);
    assert!(instance_3(folder.path(), &token, &received).is_null() && !WANTED.get());
    // SAFETY: both are alive and never used again.
    unsafe {
        v2::fmi2FreeInstance(c);
        v3::fmi3FreeInstance(i);
    }
    // All functions of the standards are here but those that make, free and name.
    assert_eq!((ENTRIES_2.len(), ENTRIES_3.len()), (v2::TABLE.len() - 1, v3::TABLE.len() - 1));
}

//! The C types of FMI 2.0.5, as `fmi2TypesPlatform.h` and `fmi2FunctionTypes.h` declare them.
//!
//! Names are the standard's own, so that a line here can be held against a line of the headers;
//! a test compiles those headers against every type of this file. Both directions of the C edge,
//! export and import, use these declarations and no others.
//!
//! Enumerations that cross the edge are transparent integers, not Rust `enum`s: a foreign FMU may
//! return a value the standard does not know, and that must not be undefined behaviour here.
#![allow(non_camel_case_types, non_snake_case, non_upper_case_globals)]

use std::ffi::{c_char, c_double, c_int, c_uint, c_void};

/// Pointer to an FMU's instance; opaque to the importer.
pub type fmi2Component = *mut c_void;
/// Pointer to the importer's data, handed back by the callbacks; opaque to the FMU.
pub type fmi2ComponentEnvironment = *mut c_void;
/// Pointer to a saved state of an FMU; opaque to the importer.
pub type fmi2FMUstate = *mut c_void;
/// Handle of a variable.
pub type fmi2ValueReference = c_uint;
/// Value of a Real variable.
pub type fmi2Real = c_double;
/// Value of an Integer or Enumeration variable.
pub type fmi2Integer = c_int;
/// Value of a Boolean variable: a C int, [`fmi2True`] or [`fmi2False`].
pub type fmi2Boolean = c_int;
/// One character.
pub type fmi2Char = c_char;
/// UTF-8 text ending with a zero byte.
pub type fmi2String = *const fmi2Char;
/// One byte of a serialised state.
pub type fmi2Byte = c_char;

/// The value true.
pub const fmi2True: fmi2Boolean = 1;
/// The value false.
pub const fmi2False: fmi2Boolean = 0;

/// What `fmi2GetTypesPlatform` returns for the types of this file.
pub const fmi2TypesPlatform: &std::ffi::CStr = c"default";
/// What `fmi2GetVersion` returns.
pub const fmi2Version: &std::ffi::CStr = c"2.0";

/// Result of a call (section 2.1.3).
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct fmi2Status(pub c_uint);

/// All well.
pub const fmi2OK: fmi2Status = fmi2Status(0);
/// Things are not quite right, but the computation may go on.
pub const fmi2Warning: fmi2Status = fmi2Status(1);
/// The step was not, or only in part, computed.
pub const fmi2Discard: fmi2Status = fmi2Status(2);
/// The instance can only be reset or freed.
pub const fmi2Error: fmi2Status = fmi2Status(3);
/// All instances of the FMU are corrupted.
pub const fmi2Fatal: fmi2Status = fmi2Status(4);
/// The step is computed asynchronously.
pub const fmi2Pending: fmi2Status = fmi2Status(5);

/// Kind of an FMU.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct fmi2Type(pub c_uint);

/// The importer brings the solver.
pub const fmi2ModelExchange: fmi2Type = fmi2Type(0);
/// The FMU brings its own solver.
pub const fmi2CoSimulation: fmi2Type = fmi2Type(1);

/// What `fmi2GetXXXStatus` is asked for (section 4.2.3).
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct fmi2StatusKind(pub c_uint);

/// Status of a pending step (`fmi2GetStatus`).
pub const fmi2DoStepStatus: fmi2StatusKind = fmi2StatusKind(0);
/// Text about a pending step (`fmi2GetStringStatus`).
pub const fmi2PendingStatus: fmi2StatusKind = fmi2StatusKind(1);
/// End of the last step that was completed (`fmi2GetRealStatus`).
pub const fmi2LastSuccessfulTime: fmi2StatusKind = fmi2StatusKind(2);
/// Whether the FMU wants to end the simulation (`fmi2GetBooleanStatus`).
pub const fmi2Terminated: fmi2StatusKind = fmi2StatusKind(3);

/// The importer's logger. It is variadic, like `printf`: `message` is a format.
pub type fmi2CallbackLogger = unsafe extern "C" fn(
    componentEnvironment: fmi2ComponentEnvironment,
    instanceName: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
    ...
);
/// The importer's `calloc`.
pub type fmi2CallbackAllocateMemory = unsafe extern "C" fn(nobj: usize, size: usize) -> *mut c_void;
/// The importer's `free`.
pub type fmi2CallbackFreeMemory = unsafe extern "C" fn(obj: *mut c_void);
/// Called by an FMU at the end of an asynchronous step.
pub type fmi2StepFinished =
    unsafe extern "C" fn(componentEnvironment: fmi2ComponentEnvironment, status: fmi2Status);

/// The importer's callbacks. Importers do pass null pointers, hence the `Option`s.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fmi2CallbackFunctions {
    /// Receives messages.
    pub logger: Option<fmi2CallbackLogger>,
    /// Allocates memory.
    pub allocateMemory: Option<fmi2CallbackAllocateMemory>,
    /// Frees memory.
    pub freeMemory: Option<fmi2CallbackFreeMemory>,
    /// Reports the end of an asynchronous step; null: steps are synchronous.
    pub stepFinished: Option<fmi2StepFinished>,
    /// Handed back to the logger and to `stepFinished`.
    pub componentEnvironment: fmi2ComponentEnvironment,
}

/// Result of `fmi2NewDiscreteStates` (model exchange).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fmi2EventInfo {
    /// The event iteration goes on.
    pub newDiscreteStatesNeeded: fmi2Boolean,
    /// The FMU wants to end the simulation.
    pub terminateSimulation: fmi2Boolean,
    /// Nominal values of states have changed.
    pub nominalsOfContinuousStatesChanged: fmi2Boolean,
    /// Values of states have changed.
    pub valuesOfContinuousStatesChanged: fmi2Boolean,
    /// Whether `nextEventTime` holds a time.
    pub nextEventTimeDefined: fmi2Boolean,
    /// Time of the next time event, s.
    pub nextEventTime: fmi2Real,
}

// Common functions, in the header's order.

/// `fmi2GetTypesPlatform`
pub type fmi2GetTypesPlatformTYPE = unsafe extern "C" fn() -> *const c_char;
/// `fmi2GetVersion`
pub type fmi2GetVersionTYPE = unsafe extern "C" fn() -> *const c_char;
/// `fmi2SetDebugLogging`
pub type fmi2SetDebugLoggingTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    loggingOn: fmi2Boolean,
    nCategories: usize,
    categories: *const fmi2String,
) -> fmi2Status;
/// `fmi2Instantiate`
pub type fmi2InstantiateTYPE = unsafe extern "C" fn(
    instanceName: fmi2String,
    fmuType: fmi2Type,
    fmuGUID: fmi2String,
    fmuResourceLocation: fmi2String,
    functions: *const fmi2CallbackFunctions,
    visible: fmi2Boolean,
    loggingOn: fmi2Boolean,
) -> fmi2Component;
/// `fmi2FreeInstance`
pub type fmi2FreeInstanceTYPE = unsafe extern "C" fn(c: fmi2Component);
/// `fmi2SetupExperiment`
pub type fmi2SetupExperimentTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    toleranceDefined: fmi2Boolean,
    tolerance: fmi2Real,
    startTime: fmi2Real,
    stopTimeDefined: fmi2Boolean,
    stopTime: fmi2Real,
) -> fmi2Status;
/// `fmi2EnterInitializationMode`
pub type fmi2EnterInitializationModeTYPE = unsafe extern "C" fn(c: fmi2Component) -> fmi2Status;
/// `fmi2ExitInitializationMode`
pub type fmi2ExitInitializationModeTYPE = unsafe extern "C" fn(c: fmi2Component) -> fmi2Status;
/// `fmi2Terminate`
pub type fmi2TerminateTYPE = unsafe extern "C" fn(c: fmi2Component) -> fmi2Status;
/// `fmi2Reset`
pub type fmi2ResetTYPE = unsafe extern "C" fn(c: fmi2Component) -> fmi2Status;
/// `fmi2GetReal`
pub type fmi2GetRealTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status;
/// `fmi2GetInteger`
pub type fmi2GetIntegerTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Integer,
) -> fmi2Status;
/// `fmi2GetBoolean`
pub type fmi2GetBooleanTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Boolean,
) -> fmi2Status;
/// `fmi2GetString`
pub type fmi2GetStringTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2String,
) -> fmi2Status;
/// `fmi2SetReal`
pub type fmi2SetRealTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status;
/// `fmi2SetInteger`
pub type fmi2SetIntegerTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Integer,
) -> fmi2Status;
/// `fmi2SetBoolean`
pub type fmi2SetBooleanTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Boolean,
) -> fmi2Status;
/// `fmi2SetString`
pub type fmi2SetStringTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2String,
) -> fmi2Status;
/// `fmi2GetFMUstate`
pub type fmi2GetFMUstateTYPE =
    unsafe extern "C" fn(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status;
/// `fmi2SetFMUstate`
pub type fmi2SetFMUstateTYPE =
    unsafe extern "C" fn(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status;
/// `fmi2FreeFMUstate`
pub type fmi2FreeFMUstateTYPE =
    unsafe extern "C" fn(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status;
/// `fmi2SerializedFMUstateSize`
pub type fmi2SerializedFMUstateSizeTYPE =
    unsafe extern "C" fn(c: fmi2Component, FMUstate: fmi2FMUstate, size: *mut usize) -> fmi2Status;
/// `fmi2SerializeFMUstate`
pub type fmi2SerializeFMUstateTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    serializedState: *mut fmi2Byte,
    size: usize,
) -> fmi2Status;
/// `fmi2DeSerializeFMUstate`
pub type fmi2DeSerializeFMUstateTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    serializedState: *const fmi2Byte,
    size: usize,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status;
/// `fmi2GetDirectionalDerivative`
pub type fmi2GetDirectionalDerivativeTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vUnknown_ref: *const fmi2ValueReference,
    nUnknown: usize,
    vKnown_ref: *const fmi2ValueReference,
    nKnown: usize,
    dvKnown: *const fmi2Real,
    dvUnknown: *mut fmi2Real,
) -> fmi2Status;

// Functions for model exchange.

/// `fmi2EnterEventMode`
pub type fmi2EnterEventModeTYPE = unsafe extern "C" fn(c: fmi2Component) -> fmi2Status;
/// `fmi2NewDiscreteStates`
pub type fmi2NewDiscreteStatesTYPE =
    unsafe extern "C" fn(c: fmi2Component, fmi2eventInfo: *mut fmi2EventInfo) -> fmi2Status;
/// `fmi2EnterContinuousTimeMode`
pub type fmi2EnterContinuousTimeModeTYPE = unsafe extern "C" fn(c: fmi2Component) -> fmi2Status;
/// `fmi2CompletedIntegratorStep`
pub type fmi2CompletedIntegratorStepTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
    enterEventMode: *mut fmi2Boolean,
    terminateSimulation: *mut fmi2Boolean,
) -> fmi2Status;
/// `fmi2SetTime`
pub type fmi2SetTimeTYPE = unsafe extern "C" fn(c: fmi2Component, time: fmi2Real) -> fmi2Status;
/// `fmi2SetContinuousStates`
pub type fmi2SetContinuousStatesTYPE =
    unsafe extern "C" fn(c: fmi2Component, x: *const fmi2Real, nx: usize) -> fmi2Status;
/// `fmi2GetDerivatives`
pub type fmi2GetDerivativesTYPE =
    unsafe extern "C" fn(c: fmi2Component, derivatives: *mut fmi2Real, nx: usize) -> fmi2Status;
/// `fmi2GetEventIndicators`
pub type fmi2GetEventIndicatorsTYPE =
    unsafe extern "C" fn(c: fmi2Component, eventIndicators: *mut fmi2Real, ni: usize) -> fmi2Status;
/// `fmi2GetContinuousStates`
pub type fmi2GetContinuousStatesTYPE =
    unsafe extern "C" fn(c: fmi2Component, x: *mut fmi2Real, nx: usize) -> fmi2Status;
/// `fmi2GetNominalsOfContinuousStates`
pub type fmi2GetNominalsOfContinuousStatesTYPE =
    unsafe extern "C" fn(c: fmi2Component, x_nominal: *mut fmi2Real, nx: usize) -> fmi2Status;

// Functions for co-simulation.

/// `fmi2SetRealInputDerivatives`
pub type fmi2SetRealInputDerivativesTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *const fmi2Real,
) -> fmi2Status;
/// `fmi2GetRealOutputDerivatives`
pub type fmi2GetRealOutputDerivativesTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *mut fmi2Real,
) -> fmi2Status;
/// `fmi2DoStep`
pub type fmi2DoStepTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    currentCommunicationPoint: fmi2Real,
    communicationStepSize: fmi2Real,
    noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
) -> fmi2Status;
/// `fmi2CancelStep`
pub type fmi2CancelStepTYPE = unsafe extern "C" fn(c: fmi2Component) -> fmi2Status;
/// `fmi2GetStatus`
pub type fmi2GetStatusTYPE =
    unsafe extern "C" fn(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Status) -> fmi2Status;
/// `fmi2GetRealStatus`
pub type fmi2GetRealStatusTYPE =
    unsafe extern "C" fn(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Real) -> fmi2Status;
/// `fmi2GetIntegerStatus`
pub type fmi2GetIntegerStatusTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Integer,
) -> fmi2Status;
/// `fmi2GetBooleanStatus`
pub type fmi2GetBooleanStatusTYPE = unsafe extern "C" fn(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status;
/// `fmi2GetStringStatus`
pub type fmi2GetStringStatusTYPE =
    unsafe extern "C" fn(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2String) -> fmi2Status;

//! The functions for model exchange, which this kind of FMU does not offer: all are refused.
//!
//! # Safety
//! The contract of all functions of [`v2`](super).

use super::*;

// Enter and exit the different modes

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi2EnterEventMode(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &ENTER_EVENT_MODE) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi2NewDiscreteStates(
    c: fmi2Component,
    _fmi2eventInfo: *mut fmi2EventInfo,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &NEW_DISCRETE_STATES) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &ENTER_CONTINUOUS_TIME_MODE) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: fmi2Component,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
    _enterEventMode: *mut fmi2Boolean,
    _terminateSimulation: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &COMPLETED_INTEGRATOR_STEP) }
}

// Providing independent variables and re-initialization of caching

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi2SetTime(c: fmi2Component, _time: fmi2Real) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &SET_TIME) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi2SetContinuousStates(
    c: fmi2Component,
    _x: *const fmi2Real,
    _nx: usize,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &SET_CONTINUOUS_STATES) }
}

// Evaluation of the model equations

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi2GetDerivatives(
    c: fmi2Component,
    _derivatives: *mut fmi2Real,
    _nx: usize,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &GET_DERIVATIVES) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi2GetEventIndicators(
    c: fmi2Component,
    _eventIndicators: *mut fmi2Real,
    _ni: usize,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &GET_EVENT_INDICATORS) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi2GetContinuousStates(
    c: fmi2Component,
    _x: *mut fmi2Real,
    _nx: usize,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &GET_CONTINUOUS_STATES) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    c: fmi2Component,
    _x_nominal: *mut fmi2Real,
    _nx: usize,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &GET_NOMINALS) }
}

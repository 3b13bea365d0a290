//! Modes, clocks, model exchange and scheduled execution, which are not offered: all are refused.
//! In the order of the header.
//!
//! # Safety
//! The contract of all functions of [`v3`](super).

use super::*;

// Entering and exiting the Configuration or Reconfiguration Mode

/// Refused: no model here has structural parameters.
pub unsafe extern "C" fn fmi3EnterConfigurationMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &ENTER_CONFIGURATION_MODE) }
}

/// Refused: no model here has structural parameters.
pub unsafe extern "C" fn fmi3ExitConfigurationMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &EXIT_CONFIGURATION_MODE) }
}

// Clocks and event mode

/// Refused: no model here has clocks.
pub unsafe extern "C" fn fmi3GetIntervalDecimal(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    _nValueReferences: usize,
    _intervals: *mut fmi3Float64,
    _qualifiers: *mut fmi3IntervalQualifier,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_INTERVAL_DECIMAL) }
}

/// Refused: no model here has clocks.
pub unsafe extern "C" fn fmi3GetIntervalFraction(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    _nValueReferences: usize,
    _counters: *mut fmi3UInt64,
    _resolutions: *mut fmi3UInt64,
    _qualifiers: *mut fmi3IntervalQualifier,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_INTERVAL_FRACTION) }
}

/// Refused: no model here has clocks.
pub unsafe extern "C" fn fmi3GetShiftDecimal(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    _nValueReferences: usize,
    _shifts: *mut fmi3Float64,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_SHIFT_DECIMAL) }
}

/// Refused: no model here has clocks.
pub unsafe extern "C" fn fmi3GetShiftFraction(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    _nValueReferences: usize,
    _counters: *mut fmi3UInt64,
    _resolutions: *mut fmi3UInt64,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_SHIFT_FRACTION) }
}

/// Refused: no model here has clocks.
pub unsafe extern "C" fn fmi3SetIntervalDecimal(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    _nValueReferences: usize,
    _intervals: *const fmi3Float64,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &SET_INTERVAL_DECIMAL) }
}

/// Refused: no model here has clocks.
pub unsafe extern "C" fn fmi3SetIntervalFraction(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    _nValueReferences: usize,
    _counters: *const fmi3UInt64,
    _resolutions: *const fmi3UInt64,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &SET_INTERVAL_FRACTION) }
}

/// Refused: no model here has clocks.
pub unsafe extern "C" fn fmi3SetShiftDecimal(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    _nValueReferences: usize,
    _shifts: *const fmi3Float64,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &SET_SHIFT_DECIMAL) }
}

/// Refused: no model here has clocks.
pub unsafe extern "C" fn fmi3SetShiftFraction(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    _nValueReferences: usize,
    _counters: *const fmi3UInt64,
    _resolutions: *const fmi3UInt64,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &SET_SHIFT_FRACTION) }
}

/// Refused: event mode is not offered.
pub unsafe extern "C" fn fmi3EvaluateDiscreteStates(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &EVALUATE_DISCRETE_STATES) }
}

/// Refused: event mode is not offered.
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: fmi3Instance,
    _discreteStatesNeedUpdate: *mut fmi3Boolean,
    _terminateSimulation: *mut fmi3Boolean,
    _nominalsOfContinuousStatesChanged: *mut fmi3Boolean,
    _valuesOfContinuousStatesChanged: *mut fmi3Boolean,
    _nextEventTimeDefined: *mut fmi3Boolean,
    _nextEventTime: *mut fmi3Float64,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &UPDATE_DISCRETE_STATES) }
}

// Functions for Model Exchange

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3EnterContinuousTimeMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &ENTER_CONTINUOUS_TIME_MODE) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3CompletedIntegratorStep(
    instance: fmi3Instance,
    _noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
    _enterEventMode: *mut fmi3Boolean,
    _terminateSimulation: *mut fmi3Boolean,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &COMPLETED_INTEGRATOR_STEP) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3SetTime(instance: fmi3Instance, _time: fmi3Float64) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &SET_TIME) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3SetContinuousStates(
    instance: fmi3Instance,
    _continuousStates: *const fmi3Float64,
    _nContinuousStates: usize,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &SET_CONTINUOUS_STATES) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3GetContinuousStateDerivatives(
    instance: fmi3Instance,
    _derivatives: *mut fmi3Float64,
    _nContinuousStates: usize,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_CONTINUOUS_STATE_DERIVATIVES) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3GetEventIndicators(
    instance: fmi3Instance,
    _eventIndicators: *mut fmi3Float64,
    _nEventIndicators: usize,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_EVENT_INDICATORS) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3GetContinuousStates(
    instance: fmi3Instance,
    _continuousStates: *mut fmi3Float64,
    _nContinuousStates: usize,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_CONTINUOUS_STATES) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3GetNominalsOfContinuousStates(
    instance: fmi3Instance,
    _nominals: *mut fmi3Float64,
    _nContinuousStates: usize,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_NOMINALS_OF_CONTINUOUS_STATES) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3GetNumberOfEventIndicators(
    instance: fmi3Instance,
    _nEventIndicators: *mut usize,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_NUMBER_OF_EVENT_INDICATORS) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3GetNumberOfContinuousStates(
    instance: fmi3Instance,
    _nContinuousStates: *mut usize,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_NUMBER_OF_CONTINUOUS_STATES) }
}

// Functions for Scheduled Execution

/// Refused: scheduled execution is not offered.
pub unsafe extern "C" fn fmi3ActivateModelPartition(
    instance: fmi3Instance,
    _clockReference: fmi3ValueReference,
    _activationTime: fmi3Float64,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &ACTIVATE_MODEL_PARTITION) }
}

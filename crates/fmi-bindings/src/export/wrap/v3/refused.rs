//! What is not offered through a repair.
//!
//! # Safety
//! The contract of all functions of [`v3`](super).

use super::*;

never! {
    "clocks are not offered through a repair":
    /// Not offered.
    fmi3GetClock(valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Clock);
    /// Not offered.
    fmi3SetClock(valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Clock);
    /// Not offered.
    fmi3GetIntervalDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *mut fmi3Float64, qualifiers: *mut fmi3IntervalQualifier);
    /// Not offered.
    fmi3GetIntervalFraction(valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64, qualifiers: *mut fmi3IntervalQualifier);
    /// Not offered.
    fmi3GetShiftDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *mut fmi3Float64);
    /// Not offered.
    fmi3GetShiftFraction(valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64);
    /// Not offered.
    fmi3SetIntervalDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *const fmi3Float64);
    /// Not offered.
    fmi3SetIntervalFraction(valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64);
    /// Not offered.
    fmi3SetShiftDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *const fmi3Float64);
    /// Not offered.
    fmi3SetShiftFraction(valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64);
}

never! {
    "adjoint derivatives and derivatives of outputs by time are not offered through a repair":
    /// Not offered.
    fmi3GetAdjointDerivative(unknowns: *const fmi3ValueReference, nUnknowns: usize, knowns: *const fmi3ValueReference, nKnowns: usize, seed: *const fmi3Float64, nSeed: usize, sensitivity: *mut fmi3Float64, nSensitivity: usize);
    /// Not offered.
    fmi3GetOutputDerivatives(valueReferences: *const fmi3ValueReference, nValueReferences: usize, orders: *const fmi3Int32, values: *mut fmi3Float64, nValues: usize);
}

never! {
    "event mode, model exchange and scheduled execution are not offered":
    /// Not offered.
    fmi3EvaluateDiscreteStates();
    /// Not offered.
    fmi3UpdateDiscreteStates(discreteStatesNeedUpdate: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean, nominalsOfContinuousStatesChanged: *mut fmi3Boolean, valuesOfContinuousStatesChanged: *mut fmi3Boolean, nextEventTimeDefined: *mut fmi3Boolean, nextEventTime: *mut fmi3Float64);
    /// Not offered.
    fmi3EnterContinuousTimeMode();
    /// Not offered.
    fmi3CompletedIntegratorStep(noSetFMUStatePriorToCurrentPoint: fmi3Boolean, enterEventMode: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean);
    /// Not offered.
    fmi3SetTime(time: fmi3Float64);
    /// Not offered.
    fmi3SetContinuousStates(continuousStates: *const fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fmi3GetContinuousStateDerivatives(derivatives: *mut fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fmi3GetEventIndicators(eventIndicators: *mut fmi3Float64, nEventIndicators: usize);
    /// Not offered.
    fmi3GetContinuousStates(continuousStates: *mut fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fmi3GetNominalsOfContinuousStates(nominals: *mut fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fmi3GetNumberOfEventIndicators(nEventIndicators: *mut usize);
    /// Not offered.
    fmi3GetNumberOfContinuousStates(nContinuousStates: *mut usize);
    /// Not offered.
    fmi3EnterStepMode();
    /// Not offered.
    fmi3ActivateModelPartition(clockReference: fmi3ValueReference, activationTime: fmi3Float64);
}

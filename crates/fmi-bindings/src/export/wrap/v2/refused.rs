//! What is not offered through a repair.
//!
//! # Safety
//! The contract of all functions of [`v2`](super).

use super::*;

never! {
    /// Not offered.
    fmi2EnterEventMode() = "model exchange is not offered";
    /// Not offered.
    fmi2NewDiscreteStates(_fmi2eventInfo: *mut fmi2EventInfo) = "model exchange is not offered";
    /// Not offered.
    fmi2EnterContinuousTimeMode() = "model exchange is not offered";
    /// Not offered.
    fmi2CompletedIntegratorStep(_noSetFMUStatePriorToCurrentPoint: fmi2Boolean, _enterEventMode: *mut fmi2Boolean, _terminateSimulation: *mut fmi2Boolean) = "model exchange is not offered";
    /// Not offered.
    fmi2SetTime(_time: fmi2Real) = "model exchange is not offered";
    /// Not offered.
    fmi2SetContinuousStates(_x: *const fmi2Real, _nx: usize) = "model exchange is not offered";
    /// Not offered.
    fmi2GetDerivatives(_derivatives: *mut fmi2Real, _nx: usize) = "model exchange is not offered";
    /// Not offered.
    fmi2GetEventIndicators(_eventIndicators: *mut fmi2Real, _ni: usize) = "model exchange is not offered";
    /// Not offered.
    fmi2GetContinuousStates(_x: *mut fmi2Real, _nx: usize) = "model exchange is not offered";
    /// Not offered.
    fmi2GetNominalsOfContinuousStates(_x_nominal: *mut fmi2Real, _nx: usize) = "model exchange is not offered";
    /// Not offered.
    fmi2SetRealInputDerivatives(_vr: *const fmi2ValueReference, _nvr: usize, _order: *const fmi2Integer, _value: *const fmi2Real) = "derivatives of inputs are not offered (canInterpolateInputs = false)";
    /// Not offered.
    fmi2GetRealOutputDerivatives(_vr: *const fmi2ValueReference, _nvr: usize, _order: *const fmi2Integer, _value: *mut fmi2Real) = "derivatives of outputs are not offered (maxOutputDerivativeOrder = 0)";
}

//! The functions for co-simulation.
//!
//! # Safety
//! The contract of all functions of [`v2`](super).

use super::*;

// Simulating the slave

/// Gives Real inputs a slope in the next step: `u(t) = u + value·(t − t_c)` from the communication
/// point `t_c` on, sampled where the model begins each of its internal steps. After that step the
/// input is held again at the value that was set. Only order 1 is offered.
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *const fmi2Real,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        unsafe {
            let vr = array(vr, nvr, "vr")?;
            instance.set_slopes(vr, array(order, nvr, "order")?, array(value, nvr, "value")?)
        }
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &SET_REAL_INPUT_DERIVATIVES, body) }
}

/// The slopes of Real outputs in time, in their unit per second: `(y_n − y_{n−1})/h` of the last two
/// hits of the internal grid, 0 before the first hit. Only order 1 is offered.
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *mut fmi2Real,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let (vr, order, room) = unsafe {
            (array(vr, nvr, "vr")?, array(order, nvr, "order")?, Room::new(value, nvr, "value")?)
        };
        // SAFETY: positions are those of `vr`.
        instance.output_slopes(vr, order, |at, slope| unsafe { room.write(at, slope) })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_REAL_OUTPUT_DERIVATIVES, body) }
}

/// Computes one communication step.
pub unsafe extern "C" fn fmi2DoStep(
    c: fmi2Component,
    currentCommunicationPoint: fmi2Real,
    communicationStepSize: fmi2Real,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
) -> fmi2Status {
    let (time, step) = (currentCommunicationPoint, communicationStepSize);
    // SAFETY: the contract of all functions here.
    unsafe { if Instance::affine_step(c, time, step) { fmi2OK } else { any_step(c, time, step) } }
}

/// Apart from the step that calls nothing, which needs no place on the stack then, and of C's kind, so that it is
/// jumped to.
#[inline(never)]
unsafe extern "C" fn any_step(c: fmi2Component, time: fmi2Real, step: fmi2Real) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &DO_STEP, |instance| instance.do_step(time, step)) }
}

/// Refused: no step is ever pending.
pub unsafe extern "C" fn fmi2CancelStep(c: fmi2Component) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(c, &CANCEL_STEP) }
}

// Inquire slave status

/// Discarded: no step is ever pending, so there is nothing to tell about one.
fn nothing_to_tell(s: fmi2StatusKind, answered: &str) -> Outcome {
    let kind = match s {
        fmi2DoStepStatus => "fmi2DoStepStatus",
        fmi2PendingStatus => "fmi2PendingStatus",
        fmi2LastSuccessfulTime => "fmi2LastSuccessfulTime",
        fmi2Terminated => "fmi2Terminated",
        _ => "an unknown status kind",
    };
    Err(Notice::discard(format!(
        "nothing to tell about {kind}: steps are computed at once, none is pending{answered}"
    )))
}

/// Discarded: no step is ever pending.
pub unsafe extern "C" fn fmi2GetStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    _value: *mut fmi2Status,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_STATUS, |_| nothing_to_tell(s, "")) }
}

/// The end of the last step, for `fmi2LastSuccessfulTime`.
pub unsafe extern "C" fn fmi2GetRealStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Real,
) -> fmi2Status {
    let body = |instance: &mut Instance| {
        if s != fmi2LastSuccessfulTime {
            return nothing_to_tell(s, "; this function knows fmi2LastSuccessfulTime");
        }
        // SAFETY: the caller's room for one number.
        unsafe { Room::new(value, 1, "value")?.write(0, instance.time()) };
        Ok(())
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_REAL_STATUS, body) }
}

/// Discarded: there is no such status in the standard.
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    _value: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_INTEGER_STATUS, |_| nothing_to_tell(s, "")) }
}

/// Whether the model wants to end the simulation, for `fmi2Terminated`: never.
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    let body = |_: &mut Instance| {
        if s != fmi2Terminated {
            return nothing_to_tell(s, "; this function knows fmi2Terminated");
        }
        // SAFETY: the caller's room for one value.
        unsafe { Room::new(value, 1, "value")?.write(0, fmi2False) };
        Ok(())
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_BOOLEAN_STATUS, body) }
}

/// Discarded: no step is ever pending.
pub unsafe extern "C" fn fmi2GetStringStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    _value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the contract of all functions here.
    unsafe { call(c, &GET_STRING_STATUS, |_| nothing_to_tell(s, "")) }
}

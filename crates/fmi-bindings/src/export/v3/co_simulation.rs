//! The functions for co-simulation.
//!
//! # Safety
//! The contract of all functions of [`v3`](super).

use super::*;

/// Refused: event mode is not offered, so the step mode is entered with the end of initialization.
pub unsafe extern "C" fn fmi3EnterStepMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &ENTER_STEP_MODE) }
}

/// The slopes of Float64 outputs in time, in their unit per second, one for each element:
/// `(y_n − y_{n−1})/h` of the last two hits of the internal grid, 0 before the first hit. Only order
/// 1 is offered.
pub unsafe extern "C" fn fmi3GetOutputDerivatives(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    orders: *const fmi3Int32,
    values: *mut fmi3Float64,
    nValues: usize,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays.
        let (references, orders, room) = unsafe {
            (
                array(valueReferences, nValueReferences, "valueReferences")?,
                array(orders, nValueReferences, "orders")?,
                Room::new(values, nValues, "values")?,
            )
        };
        // SAFETY: positions are less than `nValues`, which is the number of elements.
        let write = |at, slope| unsafe { room.write(at, slope) };
        instance.output_slopes_of_arrays(references, orders, nValues, write)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_OUTPUT_DERIVATIVES, body) }
}

/// Computes one communication step, always to its end: there are no events, and neither the end of
/// the simulation nor an early return is ever asked for.
pub unsafe extern "C" fn fmi3DoStep(
    instance: fmi3Instance,
    currentCommunicationPoint: fmi3Float64,
    communicationStepSize: fmi3Float64,
    _noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
    eventHandlingNeeded: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
    earlyReturn: *mut fmi3Boolean,
    lastSuccessfulTime: *mut fmi3Float64,
) -> fmi3Status {
    let answers = [eventHandlingNeeded, terminateSimulation, earlyReturn];
    let (time, step) = (currentCommunicationPoint, communicationStepSize);
    let is_reported = !lastSuccessfulTime.is_null()
        && lastSuccessfulTime.is_aligned()
        && answers.iter().all(|answer| !answer.is_null());
    // SAFETY: the contract of all functions here, and the caller's room for one value each.
    unsafe {
        if is_reported && Instance::affine_step(instance, time, step) {
            answers.iter().for_each(|answer| answer.write(fmi3False));
            lastSuccessfulTime.write(time + step);
            return fmi3OK;
        }
        let [events, end, early] = answers;
        any_step(instance, time, step, events, end, early, lastSuccessfulTime)
    }
}

/// Apart from the step that calls nothing, as in FMI 2.0.
#[inline(never)]
unsafe extern "C" fn any_step(
    instance: fmi3Instance,
    time: fmi3Float64,
    step: fmi3Float64,
    eventHandlingNeeded: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
    earlyReturn: *mut fmi3Boolean,
    lastSuccessfulTime: *mut fmi3Float64,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's room for one value each.
        let (answers, last) = unsafe {
            let answers = [
                Room::new(eventHandlingNeeded, 1, "eventHandlingNeeded")?,
                Room::new(terminateSimulation, 1, "terminateSimulation")?,
                Room::new(earlyReturn, 1, "earlyReturn")?,
            ];
            (answers, Room::new(lastSuccessfulTime, 1, "lastSuccessfulTime")?)
        };
        let done = instance.do_step(time, step);
        // SAFETY: as above; they tell the truth after a failure, too.
        unsafe {
            answers.iter().for_each(|answer| answer.write(0, fmi3False));
            last.write(0, instance.time());
        }
        done
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &DO_STEP, body) }
}

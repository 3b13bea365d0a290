//! Dependencies, FMU states and partial derivatives.
//!
//! # Safety
//! The contract of all functions of [`v3`](super).

use super::*;

// Getting variable dependency information

const NO_DEPENDENCIES: &str = "dependencies of single elements are not offered \
    (providesPerElementDependencies = false); the model description has those of the variables";

/// Not offered: `providesPerElementDependencies` is false.
pub unsafe extern "C" fn fmi3GetNumberOfVariableDependencies(
    instance: fmi3Instance,
    _valueReference: fmi3ValueReference,
    _nDependencies: *mut usize,
) -> fmi3Status {
    let body = |_: &mut Instance| Err(Notice::error(NO_DEPENDENCIES));
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_NUMBER_OF_VARIABLE_DEPENDENCIES, body) }
}

/// Not offered: `providesPerElementDependencies` is false.
pub unsafe extern "C" fn fmi3GetVariableDependencies(
    instance: fmi3Instance,
    _dependent: fmi3ValueReference,
    _elementIndicesOfDependent: *mut usize,
    _independents: *mut fmi3ValueReference,
    _elementIndicesOfIndependents: *mut usize,
    _dependencyKinds: *mut fmi3DependencyKind,
    _nDependencies: usize,
) -> fmi3Status {
    let body = |_: &mut Instance| Err(Notice::error(NO_DEPENDENCIES));
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_VARIABLE_DEPENDENCIES, body) }
}

// Getting and setting the internal FMU state

/// Saves the state, into `*FMUState` where that is not null.
pub unsafe extern "C" fn fmi3GetFMUState(
    instance: fmi3Instance,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the caller's state and pointers.
    let body = |instance: &mut Instance| unsafe { state_calls::get(instance, FMUState) };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_FMU_STATE, body) }
}

/// Goes back to a saved state, which stays saved.
pub unsafe extern "C" fn fmi3SetFMUState(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the caller's state and pointers.
    let body = |instance: &mut Instance| unsafe { state_calls::set(instance, FMUState) };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_FMU_STATE, body) }
}

/// Frees a saved state and sets the pointer to null; null is ignored.
pub unsafe extern "C" fn fmi3FreeFMUState(
    instance: fmi3Instance,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the caller's state and pointers.
    let body = |instance: &mut Instance| unsafe { state_calls::free(instance, FMUState) };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &FREE_FMU_STATE, body) }
}

/// Number of bytes of a saved state.
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    size: *mut usize,
) -> fmi3Status {
    // SAFETY: the caller's state and pointers.
    let body =
        |instance: &mut Instance| unsafe { state_calls::serialized_size(instance, FMUState, size) };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SERIALIZED_FMU_STATE_SIZE, body) }
}

/// A saved state as bytes.
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    serializedState: *mut fmi3Byte,
    size: usize,
) -> fmi3Status {
    // SAFETY: the caller's state and pointers.
    let body = |instance: &mut Instance| unsafe {
        state_calls::serialize(instance, FMUState, serializedState, size)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SERIALIZE_FMU_STATE, body) }
}

/// A saved state from bytes, into `*FMUState` where that is not null. It is not yet the current one.
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: fmi3Instance,
    serializedState: *const fmi3Byte,
    size: usize,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the caller's state and pointers.
    let body = |instance: &mut Instance| unsafe {
        state_calls::deserialize(instance, serializedState, size, FMUState)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &DESERIALIZE_FMU_STATE, body) }
}

// Getting partial derivatives

/// The derivative of Float64 outputs in a direction of Float64 knowns, arrays spread out; as
/// [`fmi2GetDirectionalDerivative`](crate::export::v2::fmi2GetDirectionalDerivative).
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    instance: fmi3Instance,
    unknowns: *const fmi3ValueReference,
    nUnknowns: usize,
    knowns: *const fmi3ValueReference,
    nKnowns: usize,
    seed: *const fmi3Float64,
    nSeed: usize,
    sensitivity: *mut fmi3Float64,
    nSensitivity: usize,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays of the stated lengths.
        let (unknowns, knowns, seed, room) = unsafe {
            (
                array(unknowns, nUnknowns, "unknowns")?,
                array(knowns, nKnowns, "knowns")?,
                array(seed, nSeed, "seed")?,
                Room::new(sensitivity, nSensitivity, "sensitivity")?,
            )
        };
        // SAFETY: positions are less than `nSensitivity`, which is the sum of the unknowns' sizes.
        let write = |at, value| unsafe { room.write(at, value) };
        instance.directional_derivative_of_arrays(knowns, seed, unknowns, nSensitivity, write)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_DIRECTIONAL_DERIVATIVE, body) }
}

const NO_ADJOINT: &str = "adjoint derivatives are not offered (providesAdjointDerivatives = false): \
    hysteresis is linear on each side of its kinks only; use fmi3GetDirectionalDerivative";

/// Not offered: `providesAdjointDerivatives` is false.
pub unsafe extern "C" fn fmi3GetAdjointDerivative(
    instance: fmi3Instance,
    _unknowns: *const fmi3ValueReference,
    _nUnknowns: usize,
    _knowns: *const fmi3ValueReference,
    _nKnowns: usize,
    _seed: *const fmi3Float64,
    _nSeed: usize,
    _sensitivity: *mut fmi3Float64,
    _nSensitivity: usize,
) -> fmi3Status {
    let body = |_: &mut Instance| Err(Notice::error(NO_ADJOINT));
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_ADJOINT_DERIVATIVE, body) }
}

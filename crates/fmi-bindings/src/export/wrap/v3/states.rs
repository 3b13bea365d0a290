//! FMU states of a repaired FMU: the original's with those of the effects.
//!
//! # Safety
//! The contract of all functions of [`v3`](super).

use super::*;

impl States for Inner {
    unsafe fn get_inner(&mut self, place: *mut fmi3FMUState) -> Answer {
        // SAFETY: the function's own type; the rest is the caller's.
        unsafe { self.pass::<fmi3GetFMUStateTYPE>("fmi3GetFMUState", |f, inner| f(inner, place)) }
    }

    unsafe fn set_inner(&mut self, state: fmi3FMUState) -> Answer {
        // SAFETY: as above.
        unsafe { self.pass::<fmi3SetFMUStateTYPE>("fmi3SetFMUState", |f, inner| f(inner, state)) }
    }

    unsafe fn free_inner(&mut self, place: *mut fmi3FMUState) -> Answer {
        // SAFETY: as above.
        unsafe { self.pass::<fmi3FreeFMUStateTYPE>("fmi3FreeFMUState", |f, inner| f(inner, place)) }
    }

    unsafe fn inner_size(&mut self, state: fmi3FMUState, size: *mut usize) -> Answer {
        const NAME: &str = "fmi3SerializedFMUStateSize";
        // SAFETY: as above.
        unsafe {
            self.pass::<fmi3SerializedFMUStateSizeTYPE>(NAME, |f, inner| f(inner, state, size))
        }
    }

    unsafe fn serialize_inner(
        &mut self,
        state: fmi3FMUState,
        bytes: *mut u8,
        size: usize,
    ) -> Answer {
        const NAME: &str = "fmi3SerializeFMUState";
        // SAFETY: as above.
        unsafe {
            self.pass::<fmi3SerializeFMUStateTYPE>(NAME, |f, inner| {
                f(inner, state, bytes.cast(), size)
            })
        }
    }

    unsafe fn deserialize_inner(
        &mut self,
        bytes: *const u8,
        size: usize,
        place: *mut fmi3FMUState,
    ) -> Answer {
        const NAME: &str = "fmi3DeserializeFMUState";
        // SAFETY: as above.
        unsafe {
            self.pass::<fmi3DeserializeFMUStateTYPE>(NAME, |f, inner| {
                f(inner, bytes.cast(), size, place)
            })
        }
    }
}

/// Saves the state of the original and of the effects.
pub unsafe extern "C" fn fmi3GetFMUState(
    instance: fmi3Instance,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe { state_calls::get(w, FMUState) };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3GetFMUState", body) }
}

/// Goes back to a saved state, which stays saved.
pub unsafe extern "C" fn fmi3SetFMUState(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe { state_calls::set(w, FMUState) };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3SetFMUState", body) }
}

/// Frees a saved state and sets the pointer to null; null is ignored.
pub unsafe extern "C" fn fmi3FreeFMUState(
    instance: fmi3Instance,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe { state_calls::free(w, FMUState) };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3FreeFMUState", body) }
}

/// Number of bytes of a saved state.
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    size: *mut usize,
) -> fmi3Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe { state_calls::serialized_size(w, FMUState, size) };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3SerializedFMUStateSize", body) }
}

/// A saved state as bytes.
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    serializedState: *mut fmi3Byte,
    size: usize,
) -> fmi3Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe {
        state_calls::serialize(w, FMUState, serializedState.cast(), size)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3SerializeFMUState", body) }
}

/// A saved state from bytes; it is not yet the current one.
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: fmi3Instance,
    serializedState: *const fmi3Byte,
    size: usize,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe {
        state_calls::deserialize(w, serializedState.cast(), size, FMUState)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3DeserializeFMUState", body) }
}

//! FMU states of a repaired FMU: the original's with those of the effects.
//!
//! # Safety
//! The contract of all functions of [`v2`](super).

use super::*;

impl States for Inner {
    unsafe fn get_inner(&mut self, place: *mut fmi2FMUstate) -> Answer {
        // SAFETY: the function's own type; the rest is the caller's.
        unsafe { self.pass::<fmi2GetFMUstateTYPE>("fmi2GetFMUstate", |f, inner| f(inner, place)) }
    }

    unsafe fn set_inner(&mut self, state: fmi2FMUstate) -> Answer {
        // SAFETY: as above.
        unsafe { self.pass::<fmi2SetFMUstateTYPE>("fmi2SetFMUstate", |f, inner| f(inner, state)) }
    }

    unsafe fn free_inner(&mut self, place: *mut fmi2FMUstate) -> Answer {
        // SAFETY: as above.
        unsafe { self.pass::<fmi2FreeFMUstateTYPE>("fmi2FreeFMUstate", |f, inner| f(inner, place)) }
    }

    unsafe fn inner_size(&mut self, state: fmi2FMUstate, size: *mut usize) -> Answer {
        const NAME: &str = "fmi2SerializedFMUstateSize";
        // SAFETY: as above.
        unsafe {
            self.pass::<fmi2SerializedFMUstateSizeTYPE>(NAME, |f, inner| f(inner, state, size))
        }
    }

    unsafe fn serialize_inner(
        &mut self,
        state: fmi2FMUstate,
        bytes: *mut u8,
        size: usize,
    ) -> Answer {
        const NAME: &str = "fmi2SerializeFMUstate";
        // SAFETY: as above.
        unsafe {
            self.pass::<fmi2SerializeFMUstateTYPE>(NAME, |f, inner| {
                f(inner, state, bytes.cast(), size)
            })
        }
    }

    unsafe fn deserialize_inner(
        &mut self,
        bytes: *const u8,
        size: usize,
        place: *mut fmi2FMUstate,
    ) -> Answer {
        const NAME: &str = "fmi2DeSerializeFMUstate";
        // SAFETY: as above.
        unsafe {
            self.pass::<fmi2DeSerializeFMUstateTYPE>(NAME, |f, inner| {
                f(inner, bytes.cast(), size, place)
            })
        }
    }
}

/// Saves the state of the original and of the effects.
pub unsafe extern "C" fn fmi2GetFMUstate(
    c: fmi2Component,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe { state_calls::get(w, FMUstate) };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2GetFMUstate", body) }
}

/// Goes back to a saved state, which stays saved.
pub unsafe extern "C" fn fmi2SetFMUstate(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe { state_calls::set(w, FMUstate) };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2SetFMUstate", body) }
}

/// Frees a saved state and sets the pointer to null; null is ignored.
pub unsafe extern "C" fn fmi2FreeFMUstate(
    c: fmi2Component,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe { state_calls::free(w, FMUstate) };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2FreeFMUstate", body) }
}

/// Number of bytes of a saved state.
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe { state_calls::serialized_size(w, FMUstate, size) };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2SerializedFMUstateSize", body) }
}

/// A saved state as bytes.
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    serializedState: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe {
        state_calls::serialize(w, FMUstate, serializedState.cast(), size)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2SerializeFMUstate", body) }
}

/// A saved state from bytes; it is not yet the current one.
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: fmi2Component,
    serializedState: *const fmi2Byte,
    size: usize,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: the host's own pointers.
    let body = |w: &mut Instance| unsafe {
        state_calls::deserialize(w, serializedState.cast(), size, FMUstate)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2DeSerializeFMUstate", body) }
}

//! The functions about FMU states, which are the same in all versions of the standard.
//!
//! # Safety
//! All: a state is null or one of this library that is not freed; other pointers are null or good
//! for the stated length.

use std::ffi::c_void;

use super::arguments::{Room, array};
use super::instance::{Instance, SavedState};
use super::notice::{Notice, Outcome};

/// Saves the state, into `*place` where that is not null.
pub(super) unsafe fn get(instance: &mut Instance, place: *mut *mut c_void) -> Outcome {
    // SAFETY: the contract of this module.
    unsafe {
        let place = place.as_mut().ok_or_else(null_place)?;
        *place = instance.save(place.cast())?.cast();
    }
    Ok(())
}

/// Goes back to a saved state, which stays saved.
pub(super) unsafe fn set(instance: &mut Instance, state: *mut c_void) -> Outcome {
    // SAFETY: the contract of this module.
    instance.restore(unsafe { saved(state)? })
}

/// Frees a saved state and sets the pointer to null; null is ignored.
pub(super) unsafe fn free(instance: &mut Instance, place: *mut *mut c_void) -> Outcome {
    // SAFETY: the contract of this module.
    unsafe {
        match place.as_mut() {
            Some(place) if !place.is_null() => {
                instance.free(place.cast())?;
                *place = std::ptr::null_mut();
            }
            _ => {}
        }
    }
    Ok(())
}

/// Number of bytes of a saved state.
pub(super) unsafe fn serialized_size(
    instance: &Instance,
    state: *mut c_void,
    size: *mut usize,
) -> Outcome {
    // SAFETY: the contract of this module.
    unsafe {
        let room = Room::new(size, 1, "size")?;
        room.write(0, instance.serialized_size(saved(state)?));
    }
    Ok(())
}

/// A saved state as bytes.
pub(super) unsafe fn serialize(
    instance: &Instance,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Outcome {
    // SAFETY: the contract of this module; the state fits into the room.
    unsafe {
        let state = instance.serialize(saved(state)?, size)?;
        let room = Room::new(bytes, size, "serializedState")?;
        state.iter().enumerate().for_each(|(at, byte)| room.write(at, *byte));
    }
    Ok(())
}

/// A saved state from bytes, into `*place` where that is not null. It is not yet the current one.
pub(super) unsafe fn deserialize(
    instance: &mut Instance,
    bytes: *const u8,
    size: usize,
    place: *mut *mut c_void,
) -> Outcome {
    // SAFETY: the contract of this module.
    unsafe {
        let bytes = array(bytes, size, "serializedState")?;
        let place = place.as_mut().ok_or_else(null_place)?;
        *place = instance.deserialize(bytes, place.cast())?.cast();
    }
    Ok(())
}

/// The saved state of the importer.
unsafe fn saved<'a>(state: *mut c_void) -> Result<&'a SavedState, Notice> {
    // SAFETY: the contract of this module.
    unsafe { state.cast::<SavedState>().as_ref() }.ok_or_else(|| {
        Notice::error("the FMUstate is null; save a state with the function GetFMUstate first")
    })
}

fn null_place() -> Notice {
    Notice::error("the place of the FMUstate is a null pointer; give the address of a variable")
}

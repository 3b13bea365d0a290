//! The functions about FMU states of a repaired FMU, which are the same in all versions of the
//! standard: the original's state with that of the effects.
//!
//! # Safety
//! All: a state is null or one of this instance that is not freed; other pointers are null or good
//! for the stated length.

use std::ffi::c_void;

use super::core::{Answer, Code, DISCARD, EffectState, Original, Saved, Wrapped};
use crate::export::arguments::{Room, array};
use crate::export::notice::Notice;

/// The original's own functions about its states, with the arguments of the standard but the
/// instance.
///
/// # Safety
/// All: a state is null or one of the original that is not freed; other pointers are good for the
/// stated length.
pub(super) trait States: Original {
    /// Saves, into `*place` where that is not null.
    unsafe fn get_inner(&mut self, place: *mut *mut c_void) -> Answer;
    /// Goes back to a saved state.
    unsafe fn set_inner(&mut self, state: *mut c_void) -> Answer;
    /// Frees a saved state.
    unsafe fn free_inner(&mut self, place: *mut *mut c_void) -> Answer;
    /// Number of bytes of a saved state.
    unsafe fn inner_size(&mut self, state: *mut c_void, size: *mut usize) -> Answer;
    /// A saved state as bytes.
    unsafe fn serialize_inner(&mut self, state: *mut c_void, bytes: *mut u8, size: usize)
    -> Answer;
    /// A saved state from bytes.
    unsafe fn deserialize_inner(
        &mut self,
        bytes: *const u8,
        size: usize,
        place: *mut *mut c_void,
    ) -> Answer;
}

/// Saves the state of the original and of the effects, into `*place` where that is not null.
pub(super) unsafe fn get<O: States>(w: &mut Wrapped<O>, place: *mut *mut c_void) -> Answer {
    // SAFETY: the contract of this module.
    unsafe {
        let place = place.as_mut().ok_or_else(null_place)?;
        let old = place.cast::<Saved>();
        let mut inner = if old.is_null() { std::ptr::null_mut() } else { (*old).inner };
        let code = w.original.get_inner(&raw mut inner)?;
        if code >= DISCARD {
            return Ok(code);
        }
        let saved = Saved { inner, effects: w.effects() };
        if old.is_null() {
            *place = keep(w, saved);
        } else {
            *old = saved;
        }
        Ok(code)
    }
}

/// Goes back to a saved state, which stays saved.
pub(super) unsafe fn set<O: States>(w: &mut Wrapped<O>, state: *mut c_void) -> Answer {
    // SAFETY: the contract of this module.
    unsafe {
        let saved = &*saved(state)?;
        let code = w.original.set_inner(saved.inner)?;
        if code < DISCARD {
            w.restore(&saved.effects)?;
        }
        Ok(code)
    }
}

/// Frees a saved state and sets the pointer to null; null is ignored.
pub(super) unsafe fn free<O: States>(w: &mut Wrapped<O>, place: *mut *mut c_void) -> Answer {
    // SAFETY: the contract of this module.
    unsafe {
        let Some(place) = place.as_mut().filter(|place| !place.is_null()) else { return Ok(0) };
        let saved = place.cast::<Saved>();
        *place = std::ptr::null_mut();
        discard(w, saved)
    }
}

/// Frees all states that the host has left.
pub(super) fn free_all<O: States>(w: &mut Wrapped<O>) {
    while let Some(saved) = w.saved.last().copied() {
        // SAFETY: a state of this instance that is not freed. What the original says of it interests
        // nobody any more.
        let _ = unsafe { discard(w, saved) };
    }
}

/// Number of bytes of a saved state.
pub(super) unsafe fn serialized_size<O: States>(
    w: &mut Wrapped<O>,
    state: *mut c_void,
    size: *mut usize,
) -> Answer {
    // SAFETY: the contract of this module.
    unsafe {
        let saved = &*saved(state)?;
        let room = Room::new(size, 1, "size")?;
        let (code, inner) = inner_size(w, saved)?;
        room.write(0, saved.effects.byte_len() + inner);
        Ok(code)
    }
}

/// A saved state as bytes: the effects' and then the original's.
pub(super) unsafe fn serialize<O: States>(
    w: &mut Wrapped<O>,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Answer {
    // SAFETY: the contract of this module; the state fits into the room.
    unsafe {
        let saved = &*saved(state)?;
        let (code, length) = inner_size(w, saved)?;
        let head = saved.effects.byte_len();
        if size < head + length {
            return Err(Notice::error(format!("{size} bytes are too few for {}", head + length)));
        }
        let room = Room::new(bytes, size, "serializedState")?;
        let mut complete = vec![0; head + length];
        let behind = complete[head..].as_mut_ptr();
        let code = code.max(w.original.serialize_inner(saved.inner, behind, length)?);
        saved.effects.write(&w.surround.repair().token, &mut complete);
        complete.iter().enumerate().for_each(|(at, byte)| room.write(at, *byte));
        Ok(code)
    }
}

/// A saved state from bytes, into `*place` where that is not null. It is not yet the current one.
pub(super) unsafe fn deserialize<O: States>(
    w: &mut Wrapped<O>,
    bytes: *const u8,
    size: usize,
    place: *mut *mut c_void,
) -> Answer {
    // SAFETY: the contract of this module.
    unsafe {
        let bytes = array(bytes, size, "serializedState")?;
        let place = place.as_mut().ok_or_else(null_place)?;
        let token = &w.surround.repair().token;
        let (effects, at) = EffectState::read(token, bytes).ok_or_else(|| {
            Notice::error("the bytes are no state of this FMU, or they are damaged")
        })?;
        let (behind, mut inner) = (&bytes[at..], std::ptr::null_mut());
        let code = w.original.deserialize_inner(behind.as_ptr(), behind.len(), &raw mut inner)?;
        if code < DISCARD {
            if !place.is_null() {
                let _ = discard(w, place.cast());
            }
            *place = keep(w, Saved { inner, effects });
        }
        Ok(code)
    }
}

/// Hands out a saved state, to be freed at the latest with the instance.
fn keep<O>(w: &mut Wrapped<O>, saved: Saved) -> *mut c_void {
    let new = Box::into_raw(Box::new(saved));
    w.saved.push(new);
    new.cast()
}

/// Frees a saved state.
unsafe fn discard<O: States>(w: &mut Wrapped<O>, saved: *mut Saved) -> Answer {
    w.saved.retain(|one| *one != saved);
    // SAFETY: it came from `Box::into_raw`; the contract of this module.
    unsafe {
        let mut saved = Box::from_raw(saved);
        w.original.free_inner(&raw mut saved.inner)
    }
}

/// Number of bytes of the original's part of a saved state.
unsafe fn inner_size<O: States>(
    w: &mut Wrapped<O>,
    saved: &Saved,
) -> Result<(Code, usize), Notice> {
    let mut size = 0;
    // SAFETY: the contract of this module.
    let code = unsafe { w.original.inner_size(saved.inner, &raw mut size)? };
    Ok((code, size))
}

/// The saved state of the host.
fn saved(state: *mut c_void) -> Result<*const Saved, Notice> {
    if state.is_null() {
        return Err(Notice::error(
            "the state is null; save one with the function GetFMUstate first",
        ));
    }
    Ok(state.cast())
}

fn null_place() -> Notice {
    Notice::error("the place of the state is null; give the address of a variable")
}

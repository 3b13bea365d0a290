//! FMU states of a repaired FMU: the original's with those of the effects.
//!
//! # Safety
//! As [`v3`](super).

use super::*;

/// Saves the state of the original and of the effects.
pub unsafe extern "C" fn fmi3GetFMUState(
    instance: fmi3Instance,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    const NAME: &str = "fmi3GetFMUState";
    let body = |w: &mut Instance| {
        // SAFETY: the host's own pointer.
        let place = unsafe { FMUState.as_mut() };
        let place = place.ok_or_else(|| Notice::error("the place of the state is null"))?;
        let old = if place.is_null() { None } else { Some(state(*place)?) };
        // SAFETY: a state of this instance.
        let mut inner = old.map_or(std::ptr::null_mut(), |saved| unsafe { (*saved).inner });
        // SAFETY: the function's own type; the pointer is null or a state of the original.
        let code = unsafe { w.pass::<fmi3GetFMUStateTYPE>(NAME, |f, c| f(c, &raw mut inner))? };
        if code >= DISCARD {
            return Ok(code);
        }
        let saved = Saved { inner, around: w.around() };
        match old {
            // SAFETY: a state of this instance, and the only reference to it.
            Some(old) => unsafe { *old = saved },
            None => {
                let new = Box::into_raw(Box::new(saved));
                w.saved.push(new);
                *place = new.cast();
            }
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

/// Goes back to a saved state.
pub unsafe extern "C" fn fmi3SetFMUState(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
) -> fmi3Status {
    const NAME: &str = "fmi3SetFMUState";
    let body = |w: &mut Instance| {
        let saved = state(FMUState)?;
        // SAFETY: a state of this instance.
        let (inner, around) = unsafe { ((*saved).inner, (*saved).around.clone()) };
        // SAFETY: the function's own type and a state of the original.
        let code = unsafe { w.pass::<fmi3SetFMUStateTYPE>(NAME, |f, c| f(c, inner))? };
        if code < DISCARD {
            w.restore(&around)?;
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

/// Frees a state that is in no list any more.
///
/// # Safety
/// `saved` is a state of this instance that is not freed.
pub(super) unsafe fn drop_state(w: &mut Instance, saved: *mut Saved) -> Code {
    // SAFETY: it came from `Box::into_raw`, as the caller promises.
    let mut saved = unsafe { Box::from_raw(saved) };
    let Some(free) = w.original.library.functions.free_fmu_state else { return OK };
    // SAFETY: a state of the original.
    unsafe { free(w.original.instance, &raw mut saved.inner).0 }
}

/// Frees a saved state; null is ignored.
pub unsafe extern "C" fn fmi3FreeFMUState(
    instance: fmi3Instance,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the host's own pointer.
        let Some(place) = (unsafe { FMUState.as_mut() }).filter(|p| !p.is_null()) else {
            return Ok(OK);
        };
        let saved = state(*place)?;
        w.saved.retain(|s| *s != saved);
        *place = std::ptr::null_mut();
        // SAFETY: a state of this instance, in no list any more.
        Ok(unsafe { drop_state(w, saved) })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3FreeFMUState", body) }
}

/// Number of bytes of the original's state.
///
/// # Safety
/// `inner` is a state of the original.
unsafe fn inner_size(w: &mut Instance, inner: fmi3FMUState) -> Result<(Code, usize), Notice> {
    let mut size = 0;
    // SAFETY: the function's own type and a state of the original.
    let code = unsafe {
        w.pass::<fmi3SerializedFMUStateSizeTYPE>("fmi3SerializedFMUStateSize", |f, c| {
            f(c, inner, &raw mut size)
        })?
    };
    Ok((code, size))
}

/// Number of bytes of a saved state.
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    size: *mut usize,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        let saved = state(FMUState)?;
        // SAFETY: a state of this instance; the host's room for one number.
        unsafe {
            let (code, inner) = inner_size(w, (*saved).inner)?;
            let around = &(*saved).around;
            Room::new(size, 1, "size")?.write(0, around.byte_len() + inner);
            Ok(code)
        }
    };
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
    const NAME: &str = "fmi3SerializeFMUState";
    let body = |w: &mut Instance| {
        let saved = state(FMUState)?;
        // SAFETY: a state of this instance.
        let (inner, around) = unsafe { ((*saved).inner, (*saved).around.clone()) };
        // SAFETY: a state of the original.
        let (code, length) = unsafe { inner_size(w, inner)? };
        let head = around.byte_len();
        if size < head + length {
            return Err(Notice::error(format!("{size} bytes are too few for {}", head + length)));
        }
        let mut bytes = vec![0; head + length];
        let behind = bytes[head..].as_mut_ptr().cast::<fmi3Byte>();
        // SAFETY: the function's own type; the room has this length.
        let done = unsafe {
            w.pass::<fmi3SerializeFMUStateTYPE>(NAME, |f, c| f(c, inner, behind, length))?
        };
        around.write(&w.surround.repair().token, &mut bytes);
        // SAFETY: the host's room has `size` bytes, which is not less.
        unsafe {
            let room = Room::new(serializedState.cast::<u8>(), size, "serializedState")?;
            bytes.iter().enumerate().for_each(|(at, b)| room.write(at, *b));
        }
        Ok(code.max(done))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

/// A saved state from bytes; it is not yet the current one.
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: fmi3Instance,
    serializedState: *const fmi3Byte,
    size: usize,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    const NAME: &str = "fmi3DeserializeFMUState";
    let body = |w: &mut Instance| {
        // SAFETY: the host's array of `size` bytes and its pointer.
        let (bytes, place) = unsafe {
            (array(serializedState.cast::<u8>(), size, "serializedState")?, FMUState.as_mut())
        };
        let place = place.ok_or_else(|| Notice::error("the place of the state is null"))?;
        let token = &w.surround.repair().token;
        let (around, at) = Around::read(token, bytes).ok_or_else(|| {
            Notice::error("the bytes are no state of this FMU, or they are damaged")
        })?;
        let mut inner: fmi3FMUState = std::ptr::null_mut();
        let behind = &bytes[at..];
        // SAFETY: the function's own type; the bytes have this length.
        let code = unsafe {
            w.pass::<fmi3DeserializeFMUStateTYPE>(NAME, |f, c| {
                f(c, behind.as_ptr().cast(), behind.len(), &raw mut inner)
            })?
        };
        if code < DISCARD {
            if !place.is_null() {
                let old = state(*place)?;
                w.saved.retain(|s| *s != old);
                // SAFETY: a state of this instance, in no list any more.
                unsafe { drop_state(w, old) };
            }
            let new = Box::into_raw(Box::new(Saved { inner, around }));
            w.saved.push(new);
            *place = new.cast();
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

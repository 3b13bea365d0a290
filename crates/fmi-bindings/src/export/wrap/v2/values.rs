//! Getting and setting variable values of a repaired FMU.
//!
//! # Safety
//! The contract of all functions of [`v2`](super).

use super::*;

/// Reads Real variables.
pub unsafe extern "C" fn fmi2GetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let references = unsafe { array(vr, nvr, "vr")? };
        if !w.is_ours(references) {
            // SAFETY: the host's own arguments.
            return Ok(unsafe {
                (w.original.library.functions.get_real)(w.original.component, vr, nvr, value).0
            });
        }
        let mut values = vec![0.0; nvr];
        let code = w.get(references, &mut values)?;
        // SAFETY: the caller's room for `nvr` values.
        let room = unsafe { Room::new(value, nvr, "value")? };
        // SAFETY: positions are below `nvr`.
        values.iter().enumerate().for_each(|(at, v)| unsafe { room.write(at, *v) });
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2GetReal", body) }
}

pass! {
    /// Goes through.
    fmi2GetInteger: fmi2GetIntegerTYPE = (vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Integer);
}

/// Reads Boolean variables.
pub unsafe extern "C" fn fmi2GetBoolean(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    const NAME: &str = "fmi2GetBoolean";
    let body = |w: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let (references, room) =
            unsafe { (array(vr, nvr, "vr")?, Room::new(value, nvr, "value")?) };
        let is_flag = |r: &u32| w.surround.is_flag(*r);
        let passed: Vec<u32> = references.iter().copied().filter(|r| !is_flag(r)).collect();
        let mut inner = vec![fmi2False; passed.len()];
        let mut code = OK;
        if !passed.is_empty() || nvr == 0 {
            // SAFETY: the function's own type; both arrays have this length.
            code = unsafe {
                w.original.pass::<fmi2GetBooleanTYPE>(NAME, |f, c| {
                    f(c, passed.as_ptr(), passed.len(), inner.as_mut_ptr())
                })?
            };
        }
        let mut inner = inner.into_iter();
        for (at, reference) in references.iter().enumerate() {
            let own = w.surround.get(*reference).filter(|_| w.surround.is_flag(*reference));
            let value = match own {
                Some(value) => fmi2Boolean::from(value != 0.0),
                None => inner.next().unwrap_or(fmi2False),
            };
            // SAFETY: the position is below `nvr`.
            unsafe { room.write(at, value) };
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, NAME, body) }
}

pass! {
    /// Goes through.
    fmi2GetString: fmi2GetStringTYPE = (vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2String);
}

/// Sets Real variables.
pub unsafe extern "C" fn fmi2SetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let references = unsafe { array(vr, nvr, "vr")? };
        if !w.is_ours(references) {
            w.touch();
            // SAFETY: the host's own arguments.
            return Ok(unsafe {
                (w.original.library.functions.set_real)(w.original.component, vr, nvr, value).0
            });
        }
        // SAFETY: the caller's arrays of `nvr` elements.
        w.set(references, unsafe { array(value, nvr, "value")? })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, "fmi2SetReal", body) }
}

/// Sets Integer variables of the original.
pub unsafe extern "C" fn fmi2SetInteger(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Integer,
) -> fmi2Status {
    const NAME: &str = "fmi2SetInteger";
    let body = |w: &mut Instance| {
        w.touch();
        // SAFETY: the function's own type, and the host's own arguments.
        unsafe { w.original.pass::<fmi2SetIntegerTYPE>(NAME, |f, inner| f(inner, vr, nvr, value)) }
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, NAME, body) }
}

/// Sets Boolean variables.
pub unsafe extern "C" fn fmi2SetBoolean(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Boolean,
) -> fmi2Status {
    const NAME: &str = "fmi2SetBoolean";
    let body = |w: &mut Instance| {
        // SAFETY: the caller's arrays of `nvr` elements.
        let (references, values) = unsafe { (array(vr, nvr, "vr")?, array(value, nvr, "value")?) };
        let (mut passed, mut inner) = (Vec::new(), Vec::new());
        for (reference, value) in references.iter().zip(values) {
            if w.surround.is_flag(*reference) {
                w.set_flag(*reference, *value != fmi2False)?;
            } else {
                passed.push(*reference);
                inner.push(*value);
            }
        }
        if passed.is_empty() && nvr > 0 {
            return Ok(OK);
        }
        w.touch();
        // SAFETY: the function's own type; both arrays have this length.
        unsafe {
            w.original.pass::<fmi2SetBooleanTYPE>(NAME, |f, c| {
                f(c, passed.as_ptr(), passed.len(), inner.as_ptr())
            })
        }
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(c, NAME, body) }
}

pass! {
    /// Goes through.
    fmi2SetString: fmi2SetStringTYPE = (vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2String);
}

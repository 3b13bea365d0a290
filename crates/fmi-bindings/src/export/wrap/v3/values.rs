//! Getting and setting variable values of a repaired FMU.
//!
//! # Safety
//! The contract of all functions of [`v3`](super).

use super::*;

/// Reads Float64 variables.
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *mut fmi3Float64,
    nValues: usize,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's array.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        if !w.is_ours(references) {
            let (get, inner) = (w.original.library.functions.get_float64, w.original.instance);
            // SAFETY: the host's own arguments.
            return Ok(unsafe { get(inner, valueReferences, nValueReferences, values, nValues).0 });
        }
        // Before there is room for as many as the host asks for.
        w.measure(references, nValues)?;
        let mut own = vec![0.0; nValues];
        let code = w.get(references, &mut own)?;
        // SAFETY: the caller's room for `nValues` values.
        let room = unsafe { Room::new(values, nValues, "values")? };
        // SAFETY: positions are below `nValues`.
        own.iter().enumerate().for_each(|(at, v)| unsafe { room.write(at, *v) });
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3GetFloat64", body) }
}

/// Sets Float64 variables.
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *const fmi3Float64,
    nValues: usize,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's array.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        if !w.is_ours(references) {
            w.touch();
            let (set, inner) = (w.original.library.functions.set_float64, w.original.instance);
            // SAFETY: the host's own arguments.
            return Ok(unsafe { set(inner, valueReferences, nValueReferences, values, nValues).0 });
        }
        // SAFETY: the caller's array of `nValues` values.
        w.set(references, unsafe { array(values, nValues, "values")? })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3SetFloat64", body) }
}

/// Whether all variables of a call are the repair's Booleans; a call that mixes them with others is
/// done one by one.
fn flags(w: &Instance, references: &[u32], count: usize) -> Result<bool, Notice> {
    let own = references.iter().filter(|r| w.surround.is_flag(**r)).count();
    if own > 0 && count != references.len() {
        return Err(Notice::error(
            "a call for Booleans of the repair and for arrays at once; ask for them one by one",
        ));
    }
    Ok(own > 0)
}

/// Reads Boolean variables.
pub unsafe extern "C" fn fmi3GetBoolean(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *mut fmi3Boolean,
    nValues: usize,
) -> fmi3Status {
    const NAME: &str = "fmi3GetBoolean";
    let body = |w: &mut Instance| {
        // SAFETY: the caller's array.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        if !flags(w, references, nValues)? {
            // SAFETY: the function's own type, and the host's own arguments.
            return unsafe {
                w.original.pass::<fmi3GetBooleanTYPE>(NAME, |f, c| {
                    f(c, valueReferences, nValueReferences, values, nValues)
                })
            };
        }
        // SAFETY: the caller's room for `nValues` values, as many as there are references.
        let room = unsafe { Room::new(values, nValues, "values")? };
        let mut code = OK;
        for (at, reference) in references.iter().enumerate() {
            if w.surround.is_flag(*reference) {
                let value = w.surround.get(*reference) == Some(1.0);
                // SAFETY: the position is below `nValues`.
                unsafe { room.write(at, value) };
                continue;
            }
            // SAFETY: the function's own type, and room for one value.
            code = code.max(unsafe {
                w.original.pass::<fmi3GetBooleanTYPE>(NAME, |f, c| {
                    f(c, std::ptr::from_ref(reference), 1, values.add(at), 1)
                })?
            });
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

/// Sets Boolean variables.
pub unsafe extern "C" fn fmi3SetBoolean(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *const fmi3Boolean,
    nValues: usize,
) -> fmi3Status {
    const NAME: &str = "fmi3SetBoolean";
    let body = |w: &mut Instance| {
        w.touch();
        // SAFETY: the caller's array.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        if !flags(w, references, nValues)? {
            // SAFETY: the function's own type, and the host's own arguments.
            return unsafe {
                w.original.pass::<fmi3SetBooleanTYPE>(NAME, |f, c| {
                    f(c, valueReferences, nValueReferences, values, nValues)
                })
            };
        }
        // SAFETY: the caller's array, as bytes because a host may write anything.
        let own = unsafe { array(values.cast::<u8>(), nValues, "values")? };
        let mut code = OK;
        for (at, reference) in references.iter().enumerate() {
            if w.surround.is_flag(*reference) {
                w.set_flag(*reference, own[at] != 0)?;
                continue;
            }
            // SAFETY: the function's own type, and one value of the host's.
            code = code.max(unsafe {
                w.original.pass::<fmi3SetBooleanTYPE>(NAME, |f, c| {
                    f(c, std::ptr::from_ref(reference), 1, values.add(at), 1)
                })?
            });
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

pass! {
    /// Goes through.
    fmi3GetFloat32: fmi3GetFloat32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Float32, nValues: usize);
    /// Goes through.
    fmi3GetInt8: fmi3GetInt8TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int8, nValues: usize);
    /// Goes through.
    fmi3GetUInt8: fmi3GetUInt8TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt8, nValues: usize);
    /// Goes through.
    fmi3GetInt16: fmi3GetInt16TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int16, nValues: usize);
    /// Goes through.
    fmi3GetUInt16: fmi3GetUInt16TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt16, nValues: usize);
    /// Goes through.
    fmi3GetInt32: fmi3GetInt32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int32, nValues: usize);
    /// Goes through.
    fmi3GetUInt32: fmi3GetUInt32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt32, nValues: usize);
    /// Goes through.
    fmi3GetInt64: fmi3GetInt64TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int64, nValues: usize);
    /// Goes through.
    fmi3GetUInt64: fmi3GetUInt64TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt64, nValues: usize);
    /// Goes through.
    fmi3GetString: fmi3GetStringTYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3String, nValues: usize);
    /// Goes through.
    fmi3GetBinary: fmi3GetBinaryTYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, valueSizes: *mut usize, values: *mut fmi3Binary, nValues: usize);
    /// Goes through.
    fmi3SetFloat32: fmi3SetFloat32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Float32, nValues: usize);
    /// Goes through.
    fmi3SetInt8: fmi3SetInt8TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int8, nValues: usize);
    /// Goes through.
    fmi3SetUInt8: fmi3SetUInt8TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt8, nValues: usize);
    /// Goes through.
    fmi3SetInt16: fmi3SetInt16TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int16, nValues: usize);
    /// Goes through.
    fmi3SetUInt16: fmi3SetUInt16TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt16, nValues: usize);
    /// Goes through.
    fmi3SetInt32: fmi3SetInt32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int32, nValues: usize);
    /// Goes through.
    fmi3SetUInt32: fmi3SetUInt32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt32, nValues: usize);
    /// Goes through.
    fmi3SetInt64: fmi3SetInt64TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int64, nValues: usize);
    /// Goes through.
    fmi3SetUInt64: fmi3SetUInt64TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt64, nValues: usize);
    /// Goes through.
    fmi3SetString: fmi3SetStringTYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3String, nValues: usize);
    /// Goes through.
    fmi3SetBinary: fmi3SetBinaryTYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, valueSizes: *const usize, values: *const fmi3Binary, nValues: usize);
    /// Goes through.
    fmi3GetNumberOfVariableDependencies: fmi3GetNumberOfVariableDependenciesTYPE = (valueReference: fmi3ValueReference, nDependencies: *mut usize);
    /// Goes through.
    fmi3GetVariableDependencies: fmi3GetVariableDependenciesTYPE = (dependent: fmi3ValueReference, elementIndicesOfDependent: *mut usize, independents: *mut fmi3ValueReference, elementIndicesOfIndependents: *mut usize, dependencyKinds: *mut fmi3DependencyKind, nDependencies: usize);
    /// Goes through.
    fmi3EnterConfigurationMode: fmi3EnterConfigurationModeTYPE = ();
    /// Goes through.
    fmi3ExitConfigurationMode: fmi3ExitConfigurationModeTYPE = ();
}

//! Getting and setting variable values, in the order of the header.
//!
//! # Safety
//! The contract of all functions of [`v3`](super).

use super::*;

/// Reads Float32 variables, of which there are none.
pub unsafe extern "C" fn fmi3GetFloat32(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *mut fmi3Float32,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "Float32");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_FLOAT32, body) }
}

/// Reads Float64 variables and time.
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *mut fmi3Float64,
    nValues: usize,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        // SAFETY: the caller's array of as many elements.
        let room = unsafe { Room::new(values, nValues, "values")? };
        // SAFETY: positions are less than `nValues`, which is the sum of the variables' sizes.
        let write = |at, value: f64| unsafe { room.write(at, value) };
        instance.get_arrays(DataType::Real, references, nValues, write)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_FLOAT64, body) }
}

/// Reads Int8 variables, of which there are none.
pub unsafe extern "C" fn fmi3GetInt8(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *mut fmi3Int8,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "Int8");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_INT8, body) }
}

/// Reads UInt8 variables, of which there are none.
pub unsafe extern "C" fn fmi3GetUInt8(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *mut fmi3UInt8,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "UInt8");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_UINT8, body) }
}

/// Reads Int16 variables, of which there are none.
pub unsafe extern "C" fn fmi3GetInt16(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *mut fmi3Int16,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "Int16");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_INT16, body) }
}

/// Reads UInt16 variables, of which there are none.
pub unsafe extern "C" fn fmi3GetUInt16(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *mut fmi3UInt16,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "UInt16");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_UINT16, body) }
}

/// Reads Int32 variables.
pub unsafe extern "C" fn fmi3GetInt32(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *mut fmi3Int32,
    nValues: usize,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        // SAFETY: the caller's array of as many elements.
        let room = unsafe { Room::new(values, nValues, "values")? };
        // SAFETY: positions are less than `nValues`, which is the sum of the variables' sizes.
        let write = |at, value: f64| unsafe { room.write(at, value as fmi3Int32) };
        instance.get_arrays(DataType::Integer, references, nValues, write)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_INT32, body) }
}

/// Reads UInt32 variables, of which there are none.
pub unsafe extern "C" fn fmi3GetUInt32(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *mut fmi3UInt32,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "UInt32");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_UINT32, body) }
}

/// Reads Int64 variables, of which there are none.
pub unsafe extern "C" fn fmi3GetInt64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *mut fmi3Int64,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "Int64");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_INT64, body) }
}

/// Reads UInt64 variables, of which there are none.
pub unsafe extern "C" fn fmi3GetUInt64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *mut fmi3UInt64,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "UInt64");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_UINT64, body) }
}

/// Reads Boolean variables.
pub unsafe extern "C" fn fmi3GetBoolean(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *mut fmi3Boolean,
    nValues: usize,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        // SAFETY: the caller's array of as many elements.
        let room = unsafe { Room::new(values, nValues, "values")? };
        // SAFETY: positions are less than `nValues`, which is the sum of the variables' sizes.
        let write = |at, value: f64| unsafe { room.write(at, value != 0.0) };
        instance.get_arrays(DataType::Boolean, references, nValues, write)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_BOOLEAN, body) }
}

/// Reads String variables, of which there are none.
pub unsafe extern "C" fn fmi3GetString(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *mut fmi3String,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "String");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_STRING, body) }
}

/// Reads Binary variables, of which there are none.
pub unsafe extern "C" fn fmi3GetBinary(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _valueSizes: *mut usize,
    _values: *mut fmi3Binary,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "Binary");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &GET_BINARY, body) }
}

/// Refused: no model here has clocks.
pub unsafe extern "C" fn fmi3GetClock(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    _nValueReferences: usize,
    _values: *mut fmi3Clock,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &GET_CLOCK) }
}

/// Sets Float32 variables, of which there are none.
pub unsafe extern "C" fn fmi3SetFloat32(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *const fmi3Float32,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "Float32");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_FLOAT32, body) }
}

/// Sets Float64 variables, all or none.
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *const fmi3Float64,
    nValues: usize,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        // SAFETY: the caller's array of as many elements.
        let values = unsafe { array(values, nValues, "values")? };
        instance.set_arrays(DataType::Real, references, nValues, |at| values[at])
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_FLOAT64, body) }
}

/// Sets Int8 variables, of which there are none.
pub unsafe extern "C" fn fmi3SetInt8(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *const fmi3Int8,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "Int8");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_INT8, body) }
}

/// Sets UInt8 variables, of which there are none.
pub unsafe extern "C" fn fmi3SetUInt8(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *const fmi3UInt8,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "UInt8");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_UINT8, body) }
}

/// Sets Int16 variables, of which there are none.
pub unsafe extern "C" fn fmi3SetInt16(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *const fmi3Int16,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "Int16");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_INT16, body) }
}

/// Sets UInt16 variables, of which there are none.
pub unsafe extern "C" fn fmi3SetUInt16(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *const fmi3UInt16,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "UInt16");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_UINT16, body) }
}

/// Sets Int32 variables, all or none.
pub unsafe extern "C" fn fmi3SetInt32(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *const fmi3Int32,
    nValues: usize,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        // SAFETY: the caller's array of as many elements.
        let values = unsafe { array(values, nValues, "values")? };
        instance.set_arrays(DataType::Integer, references, nValues, |at| f64::from(values[at]))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_INT32, body) }
}

/// Sets UInt32 variables, of which there are none.
pub unsafe extern "C" fn fmi3SetUInt32(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *const fmi3UInt32,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "UInt32");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_UINT32, body) }
}

/// Sets Int64 variables, of which there are none.
pub unsafe extern "C" fn fmi3SetInt64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *const fmi3Int64,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "Int64");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_INT64, body) }
}

/// Sets UInt64 variables, of which there are none.
pub unsafe extern "C" fn fmi3SetUInt64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *const fmi3UInt64,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "UInt64");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_UINT64, body) }
}

/// Sets Boolean variables, all or none.
pub unsafe extern "C" fn fmi3SetBoolean(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *const fmi3Boolean,
    nValues: usize,
) -> fmi3Status {
    let body = |instance: &mut Instance| {
        // SAFETY: the caller's arrays.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        // Read as bytes: what is neither 0 nor 1 would be undefined behaviour as a `bool`.
        // SAFETY: the caller's array of as many elements.
        let values = unsafe { array(values.cast::<u8>(), nValues, "values")? };
        instance.set_arrays(DataType::Boolean, references, nValues, |at| {
            f64::from(u8::from(values[at] != 0))
        })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_BOOLEAN, body) }
}

/// Sets String variables, of which there are none.
pub unsafe extern "C" fn fmi3SetString(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _values: *const fmi3String,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "String");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_STRING, body) }
}

/// Sets Binary variables, of which there are none.
pub unsafe extern "C" fn fmi3SetBinary(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    _valueSizes: *const usize,
    _values: *const fmi3Binary,
    _nValues: usize,
) -> fmi3Status {
    let body = |i: &mut Instance| no_variables(i, valueReferences, nValueReferences, "Binary");
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, &SET_BINARY, body) }
}

/// Refused: no model here has clocks.
pub unsafe extern "C" fn fmi3SetClock(
    instance: fmi3Instance,
    _valueReferences: *const fmi3ValueReference,
    _nValueReferences: usize,
    _values: *const fmi3Clock,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    unsafe { never(instance, &SET_CLOCK) }
}

/// The answer about variables of a type that no model here has.
fn no_variables(
    instance: &Instance,
    references: *const fmi3ValueReference,
    count: usize,
    type_name: &str,
) -> Outcome {
    // SAFETY: the caller's array of that length.
    match unsafe { array(references, count, "valueReferences")? } {
        [] => Ok(()),
        [first, ..] => Err(instance.unknown(*first, type_name)),
    }
}

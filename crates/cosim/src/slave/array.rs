//! Elements of FMI 3.0 arrays: the C interface reads and writes whole arrays only.

use fmi_bindings::import::v3::Instance;
use modeldescription::ModelDescription;
use modeldescription::variable::{DataType, Start};

use super::selection::{ArrayRun, TypeRun};
use super::support::{Room, SPARE, type_error};
use super::value::Value;
use crate::error::Error;

/// Arrays as they were last written, by value reference, so that one element can be written
/// without changing the others: nobody but the master changes what it may set.
#[derive(Default)]
pub(super) struct Arrays {
    known: Vec<(u32, Vec<f64>)>,
    /// For reading.
    scratch: Vec<f64>,
}

impl Arrays {
    pub(super) fn clear(&mut self) {
        self.known.clear();
    }

    /// Writes some elements.
    pub(super) fn set(
        &mut self,
        instance: &mut Instance,
        description: &ModelDescription,
        run: &TypeRun,
        array: &ArrayRun,
        values: &[f64],
    ) -> Result<(), Error> {
        let place = match self.known.iter().position(|(known, _)| *known == array.reference) {
            Some(place) => place,
            None => {
                let begin = match starts(description, array) {
                    Some(starts) => starts,
                    // The FMU knows what is in an array that was given another size.
                    None if array.is_complete() => vec![0.0; array.size],
                    None => {
                        let mut found = vec![0.0; array.size];
                        let mut room = Room::of(instance.name(), description);
                        read(instance, &mut room, run.data_type, array.reference, &mut found)?;
                        found
                    }
                };
                self.known.push((array.reference, begin));
                self.known.len() - 1
            }
        };
        let (_, integer) = &mut self.known[place];
        for (index, value) in array.indices.iter().zip(values) {
            if let Some(element) = integer.get_mut(*index) {
                *element = *value;
            }
        }
        write(instance, run.data_type, array.reference, integer)
    }

    /// Reads some elements. Whether the array's numbers are doubles.
    pub(super) fn get(
        &mut self,
        instance: &mut Instance,
        room: &mut Room,
        run: &TypeRun,
        array: &ArrayRun,
        values: &mut [f64],
    ) -> Result<bool, Error> {
        if array.is_complete() {
            return read(instance, room, run.data_type, array.reference, values);
        }
        self.scratch.clear();
        self.scratch.resize(array.size, 0.0);
        let is_exact = read(instance, room, run.data_type, array.reference, &mut self.scratch)?;
        for (index, value) in array.indices.iter().zip(values) {
            *value = self.scratch.get(*index).copied().unwrap_or(f64::NAN);
        }
        Ok(is_exact)
    }
}

/// Stands behind the integers that are asked for.
const MARK: u8 = 0x5e;

#[cold]
fn overrun(instance: &Instance, call: &'static str, asked: usize) -> Error {
    Error::Overrun { fmu: instance.name().to_owned(), call, asked }
}

/// The array as its description starts it, if it does.
fn starts(description: &ModelDescription, array: &ArrayRun) -> Option<Vec<f64>> {
    let variable = description.variables.iter().find(|v| v.value_reference == array.reference);
    let numbers: Vec<f64> = match variable.and_then(|v| v.start.as_ref())? {
        Start::Boolean(values) => values.iter().map(|on| f64::from(u8::from(*on))).collect(),
        start => start.numbers().unwrap_or_default().iter().map(|n| n.as_f64()).collect(),
    };
    Some(match numbers.as_slice() {
        [one] => vec![*one; array.size],
        several => (0..array.size).map(|i| several.get(i).copied().unwrap_or(0.0)).collect(),
    })
}

fn write(
    instance: &mut Instance,
    data_type: DataType,
    reference: u32,
    values: &[f64],
) -> Result<(), Error> {
    macro_rules! set {
        ($type:ty, $set:ident) => {{
            let mut converted = Vec::with_capacity(values.len());
            for (i, value) in values.iter().enumerate() {
                let integer = *value as $type;
                // At the upper end of 64 bits the nearest double is already too much.
                if integer as i128 != *value as i128 || value.fract() != 0.0 {
                    let element = format!("element {} of value reference {reference}", i + 1);
                    let value = Value::Real(*value);
                    return Err(type_error(instance.name(), &element, data_type, &value));
                }
                converted.push(integer);
            }
            instance.$set(&[reference], &converted)?
        }};
    }
    match data_type {
        DataType::Float64 => instance.set_float64(&[reference], values)?,
        DataType::Float32 => {
            let rounded: Vec<f32> = values.iter().map(|value| *value as f32).collect();
            instance.set_float32(&[reference], &rounded)?;
        }
        DataType::Int8 => set!(i8, set_int8),
        DataType::UInt8 => set!(u8, set_uint8),
        DataType::Int16 => set!(i16, set_int16),
        DataType::UInt16 => set!(u16, set_uint16),
        DataType::Int32 => set!(i32, set_int32),
        DataType::UInt32 => set!(u32, set_uint32),
        DataType::UInt64 => set!(u64, set_uint64),
        DataType::Boolean => {
            let truths: Vec<bool> = values.iter().map(|value| *value == 1.0).collect();
            if let Some(at) = values.iter().position(|value| ![0.0, 1.0].contains(value)) {
                let element = format!("element {} of value reference {reference}", at + 1);
                let value = Value::Real(values[at]);
                return Err(type_error(instance.name(), &element, data_type, &value));
            }
            instance.set_boolean(&[reference], &truths)?;
        }
        _ => set!(i64, set_int64),
    }
    Ok(())
}

fn read(
    instance: &mut Instance,
    room: &mut Room,
    data_type: DataType,
    reference: u32,
    values: &mut [f64],
) -> Result<bool, Error> {
    let asked = values.len();
    let mut is_exact = true;
    // As `Room` does, there is more room behind what is asked for.
    macro_rules! get {
        ($type:ty, $get:ident, $call:literal) => {{
            let mark = MARK as $type;
            let mut found = vec![mark; asked + SPARE];
            instance.$get(&[reference], &mut found[..asked])?;
            if found[asked] != mark {
                return Err(overrun(instance, $call, asked));
            }
            for (value, found) in values.iter_mut().zip(found) {
                *value = found as f64;
                // Of whole numbers only: what is no double is rounded.
                is_exact &= found as i128 == *value as i128;
            }
        }};
    }
    match data_type {
        DataType::Float64 => {
            let get = |room: &mut [f64]| instance.get_float64(&[reference], room);
            room.read("fmi3GetFloat64", values, get)?;
        }
        DataType::Float32 => get!(f32, get_float32, "fmi3GetFloat32"),
        DataType::Int8 => get!(i8, get_int8, "fmi3GetInt8"),
        DataType::UInt8 => get!(u8, get_uint8, "fmi3GetUInt8"),
        DataType::Int16 => get!(i16, get_int16, "fmi3GetInt16"),
        DataType::UInt16 => get!(u16, get_uint16, "fmi3GetUInt16"),
        DataType::Int32 => get!(i32, get_int32, "fmi3GetInt32"),
        DataType::UInt32 => get!(u32, get_uint32, "fmi3GetUInt32"),
        DataType::UInt64 => get!(u64, get_uint64, "fmi3GetUInt64"),
        DataType::Boolean => {
            let mut found = vec![false; asked + SPARE];
            instance.get_boolean(&[reference], &mut found[..asked])?;
            values.iter_mut().zip(found).for_each(|(value, on)| *value = f64::from(u8::from(on)));
        }
        _ => get!(i64, get_int64, "fmi3GetInt64"),
    }
    Ok(is_exact)
}

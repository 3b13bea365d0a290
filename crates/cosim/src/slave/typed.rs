//! Variables of FMI 3.0 of other types than Float64, which the master keeps as doubles.

use fmi_bindings::import::v3::Instance;
use modeldescription::variable::DataType;

use super::selection::{Selection, TypeRun};
use super::support::type_error;
use super::value::Value;
use crate::error::Error;

/// They are converted on the stack, so many at once.
const CHUNK: usize = 32;

/// Writes variables of another type than Float64; a value must be one of that type.
pub(super) fn set_other(
    instance: &mut Instance,
    selection: &Selection,
    run: &TypeRun,
    values: &[f64],
) -> Result<(), Error> {
    /// Converts a chunk on the stack, or names the place that does not convert.
    macro_rules! set {
        ($type:ty, $set:ident) => {
            // At the upper end of 64 bits the nearest double is already too much.
            set!($type, $set, |value: f64| value as $type, |place: $type, value: f64| {
                value as i128 == place as i128 && value.fract() == 0.0
            })
        };
        ($type:ty, $set:ident, $to:expr, $is_it:expr) => {{
            let references = selection.references()[run.range.clone()].chunks(CHUNK);
            let names = selection.names()[run.range.clone()].chunks(CHUNK);
            for ((references, names), values) in references.zip(names).zip(values.chunks(CHUNK)) {
                let mut converted = [<$type>::default(); CHUNK];
                for ((place, value), name) in converted.iter_mut().zip(values).zip(names) {
                    *place = $to(*value);
                    let is_it: bool = $is_it(*place, *value);
                    if !is_it {
                        let value = Value::Real(*value);
                        return Err(type_error(instance.name(), name, run.data_type, &value));
                    }
                }
                instance.$set(references, &converted[..references.len()])?;
            }
        }};
    }
    match run.data_type {
        // A rounded value is a value.
        DataType::Float32 => {
            for (reference, value) in selection.references()[run.range.clone()].iter().zip(values) {
                instance.set_float32(&[*reference], &[*value as f32])?;
            }
        }
        DataType::Int8 => set!(i8, set_int8),
        DataType::UInt8 => set!(u8, set_uint8),
        DataType::Int16 => set!(i16, set_int16),
        DataType::UInt16 => set!(u16, set_uint16),
        DataType::Int32 => set!(i32, set_int32),
        DataType::UInt32 => set!(u32, set_uint32),
        DataType::UInt64 => set!(u64, set_uint64),
        DataType::Boolean => {
            set!(bool, set_boolean, |value: f64| value == 1.0, |place: bool, value: f64| {
                f64::from(u8::from(place)) == value
            });
        }
        _ => set!(i64, set_int64),
    }
    Ok(())
}

/// Reads variables of another type than Float64; the first place whose number does not fit into a double.
pub(super) fn get_other(
    instance: &mut Instance,
    data_type: DataType,
    references: &[u32],
    values: &mut [f64],
) -> Result<Option<usize>, Error> {
    let mut inexact = None;
    macro_rules! get {
        ($type:ty, $get:ident) => {
            get!($type, $get, |value: $type| value as f64, |_, _| true)
        };
        (exact $type:ty, $get:ident) => {
            get!($type, $get, |value: $type| value as f64, |read: $type, value: f64| {
                value as i128 == i128::from(read)
            })
        };
        ($type:ty, $get:ident, $back:expr, $is_exact:expr) => {
            for (chunk, (references, values)) in
                references.chunks(CHUNK).zip(values.chunks_mut(CHUNK)).enumerate()
            {
                let mut read = [<$type>::default(); CHUNK];
                instance.$get(references, &mut read[..references.len()])?;
                for (place, (value, read)) in values.iter_mut().zip(read).enumerate() {
                    *value = $back(read);
                    let is_exact: bool = $is_exact(read, *value);
                    if !is_exact && inexact.is_none() {
                        inexact = Some(chunk * CHUNK + place);
                    }
                }
            }
        };
    }
    match data_type {
        DataType::Float32 => get!(f32, get_float32),
        DataType::Int8 => get!(i8, get_int8),
        DataType::UInt8 => get!(u8, get_uint8),
        DataType::Int16 => get!(i16, get_int16),
        DataType::UInt16 => get!(u16, get_uint16),
        DataType::Int32 => get!(i32, get_int32),
        DataType::UInt32 => get!(u32, get_uint32),
        DataType::UInt64 => get!(exact u64, get_uint64),
        DataType::Boolean => {
            get!(bool, get_boolean, |value: bool| f64::from(u8::from(value)), |_, _| true)
        }
        _ => get!(exact i64, get_int64),
    }
    Ok(inexact)
}

/// Reads whole numbers of 64 bits as two values each, the nearest double and what is left of the number; the
/// first place of one that is no double.
pub(super) fn get_split(
    instance: &mut Instance,
    data_type: DataType,
    references: &[u32],
    values: &mut [f64],
) -> Result<Option<usize>, Error> {
    let mut inexact = None;
    let pairs = references.chunks_exact(2).zip(values.chunks_exact_mut(2));
    for (number, (references, values)) in pairs.enumerate() {
        let references = &references[..1];
        let integer = match data_type {
            DataType::UInt64 => {
                let mut read = [0];
                instance.get_uint64(references, &mut read)?;
                i128::from(read[0])
            }
            _ => {
                let mut read = [0];
                instance.get_int64(references, &mut read)?;
                i128::from(read[0])
            }
        };
        let nearest = integer as f64;
        let rest = integer - nearest as i128;
        values.copy_from_slice(&[nearest, rest as f64]);
        if rest != 0 && inexact.is_none() {
            inexact = Some(2 * number);
        }
    }
    Ok(inexact)
}

/// Writes such numbers.
pub(super) fn set_split(
    instance: &mut Instance,
    selection: &Selection,
    run: &TypeRun,
    values: &[f64],
) -> Result<(), Error> {
    let references = selection.references()[run.range.clone()].chunks_exact(2);
    let names = selection.names()[run.range.clone()].chunks_exact(2);
    for ((references, names), values) in references.zip(names).zip(values.chunks_exact(2)) {
        let is_integer = values.iter().all(|value| value.fract() == 0.0);
        let integer = values[0] as i128 + values[1] as i128;
        let references = &references[..1];
        match (run.data_type, u64::try_from(integer), i64::try_from(integer)) {
            (DataType::UInt64, Ok(integer), _) if is_integer => {
                instance.set_uint64(references, &[integer])?;
            }
            (DataType::Int64, _, Ok(integer)) if is_integer => {
                instance.set_int64(references, &[integer])?;
            }
            _ => {
                let value = Value::Real(values[0] + values[1]);
                return Err(type_error(instance.name(), &names[0], run.data_type, &value));
            }
        }
    }
    Ok(())
}

//! NumPy's `.npy` and `.npz`, by crates `npyz` and `zip`.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use npyz::{DType, Endianness, NpyHeader, Order, TimeUnits, TypeChar, TypeStr};
use zip::ZipArchive;

use super::budget::Budget;
use super::{broken, half};
use crate::log::LeftOut;
use crate::log::group::{Group, Raw, Refusal};
use crate::log::ticks::{Base, Start};

/// Longest header that is read, in bytes; NumPy writes a hundred for each field.
const LONGEST_HEADER: u32 = 1 << 20;

/// One array: its fields by name, or its columns as `column[1]`, ….
pub(super) fn array(path: &Path, budget: &mut Budget) -> Result<Vec<Group>, Refusal> {
    let file = File::open(path).map_err(|error| broken("npy", error))?;
    let mut left_out = Vec::new();
    let columns = columns("column", BufReader::new(file), budget, &mut left_out)?;
    Ok(vec![Group { left_out, ..Group::new("array", columns) }])
}

/// Arrays by name; those of one length are one group, named by that length.
pub(super) fn archive(path: &Path, budget: &mut Budget) -> Result<Vec<Group>, Refusal> {
    let file = File::open(path).map_err(|error| broken("npz", error))?;
    let mut archive =
        ZipArchive::new(BufReader::new(file)).map_err(|error| broken("npz", error))?;
    let (mut groups, mut by_rows) = (Vec::<Group>::new(), HashMap::new());
    let mut left_out = Vec::new();
    for at in 0..archive.len() {
        let entry = archive.by_index(at).map_err(|error| broken("npz", error))?;
        let name = entry.name().map_err(|error| broken("npz", error))?.into_owned();
        let Some(name) = name.strip_suffix(".npy") else { continue };
        let columns = columns(name, entry, budget, &mut left_out)?;
        let Some(rows) = columns.first().map(|raw| raw.values.len()) else { continue };
        let at = *by_rows.entry(rows).or_insert(groups.len());
        if at == groups.len() {
            groups.push(Group::new(rows.to_string(), Vec::new()));
        }
        groups[at].columns.extend(columns);
    }
    if let Some(first) = groups.first_mut() {
        first.left_out = left_out;
    }
    Ok(groups)
}

/// Most columns of an array that has fewer rows: more of them are rows, of a transposed array.
const MOST_COLUMNS: usize = 1000;

/// A scalar type: where it begins in an item, and how it is read.
struct Scalar {
    name: String,
    offset: usize,
    size: usize,
    kind: TypeChar,
    is_big: bool,
    /// Of dates and durations, per second.
    ticks: Option<f64>,
}

/// The columns of an array; what cannot be one is left out.
fn columns(
    name: &str,
    mut bytes: impl Read,
    budget: &mut Budget,
    left_out: &mut Vec<LeftOut>,
) -> Result<Vec<Raw>, Refusal> {
    // `npyz` takes memory for the header that a file speaks of, from version 2 on up to 4 GB.
    let mut start = Vec::with_capacity(12);
    bytes.by_ref().take(12).read_to_end(&mut start).map_err(|error| broken(name, error))?;
    if let [_, _, _, _, _, _, version, _, length @ ..] = start.as_slice()
        && *version > 1
        && let Ok(length) = <[u8; 4]>::try_from(length).map(u32::from_le_bytes)
        && length > LONGEST_HEADER
    {
        let why = format!("its header of {length} bytes is longer than {LONGEST_HEADER}");
        return Err(broken(name, why));
    }
    let mut bytes = start.as_slice().chain(bytes);
    let header = NpyHeader::from_reader(&mut bytes).map_err(|error| broken(name, error))?;
    let (rows, wide) = match *header.shape() {
        [rows] => (rows, 1),
        [rows, wide] => (rows, wide),
        [] => return Ok(leave_out(left_out, name, "is a single number")),
        _ => return Ok(leave_out(left_out, name, "has more than two dimensions")),
    };
    let (scalars, item) = match header.dtype() {
        DType::Plain(plain) => match scalars(name, 0, &plain) {
            none if none.is_empty() => return Ok(leave_out(left_out, name, why_not(&plain))),
            scalars => (scalars, plain.num_bytes()),
        },
        DType::Record(fields) => fields_of(&fields, left_out),
        DType::Array(..) => return Ok(leave_out(left_out, name, "holds arrays")),
    };
    let Some(item) = item.filter(|item| *item > 0 && !scalars.is_empty()) else {
        return Ok(Vec::new());
    };
    let too_large = || broken(name, "its shape is larger than its data");
    let size = |count: u64| usize::try_from(count).map_err(|_| too_large());
    let (rows, wide) = (size(rows)?, size(wide)?);
    if rows == 0 || wide == 0 {
        return Ok(Vec::new());
    }
    if wide > MOST_COLUMNS && wide > rows {
        let rule = format!("{name} has {rows} rows and {wide} columns; a row is one time");
        return Err((rule, "save it transposed (array.T), with a column per signal".into()));
    }
    let count = rows.checked_mul(wide).and_then(|n| n.checked_mul(item)).ok_or_else(too_large)?;
    // Memory follows what the file holds, not what its header says.
    let mut data = Vec::new();
    let limit = u64::try_from(count).map_err(|_| too_large())?;
    budget.unpack(limit)?;
    bytes.take(limit).read_to_end(&mut data).map_err(|error| broken(name, error))?;
    if data.len() != count {
        return Err(broken(name, format!("{} of its {count} bytes are there", data.len())));
    }
    budget.take((rows * wide) as u64, 8 * scalars.len() as u64)?;
    let by_column = header.order() == Order::Fortran;
    let mut columns = Vec::new();
    for scalar in &scalars {
        for column in 0..wide {
            let item_at =
                |row: usize| if by_column { column * rows + row } else { row * wide + column };
            let bits = |row: usize| {
                let start = item_at(row) * item + scalar.offset;
                bits(&data[start..start + scalar.size], scalar)
            };
            let start = start_of(bits(0), scalar);
            let cells = (0..rows).map(|row| number(bits(row), scalar, start));
            let title = match wide {
                1 => scalar.name.clone(),
                _ => format!("{}[{}]", scalar.name, column + 1),
            };
            let unit = scalar.ticks.map(|_| "s".to_owned());
            columns.push(Raw::new(title, unit, cells.collect()).after(start));
        }
    }
    Ok(columns)
}

fn leave_out(left_out: &mut Vec<LeftOut>, name: &str, why: &str) -> Vec<Raw> {
    left_out.push(LeftOut::new(name, why));
    Vec::new()
}

/// Why items of this type are no numbers.
fn why_not(plain: &TypeStr) -> &'static str {
    match plain.type_char() {
        TypeChar::Complex | TypeChar::Int | TypeChar::Uint | TypeChar::Float | TypeChar::Bool => {
            "holds numbers of a size that is not known"
        }
        TypeChar::TimeDelta | TypeChar::DateTime => "holds dates of which no unit of time is known",
        TypeChar::ByteStr | TypeChar::UnicodeStr => "holds texts",
        _ => "holds objects",
    }
}

/// The numbers among the fields of an item, and the item's size where it is known.
fn fields_of(fields: &[npyz::Field], left_out: &mut Vec<LeftOut>) -> (Vec<Scalar>, Option<usize>) {
    let mut all = Vec::new();
    let mut offset = 0;
    for field in fields {
        let Some(size) = field.dtype.num_bytes() else { return (Vec::new(), None) };
        match &field.dtype {
            DType::Plain(plain) => match scalars(&field.name, offset, plain) {
                none if none.is_empty() => {
                    left_out.push(LeftOut::new(&field.name, why_not(plain)));
                }
                mut scalars => all.append(&mut scalars),
            },
            _ => left_out.push(LeftOut::new(&field.name, "holds arrays")),
        }
        offset += size;
    }
    (all, Some(offset))
}

/// The numbers of an item: one, two of a complex number, none of what is no number.
fn scalars(name: &str, offset: usize, plain: &TypeStr) -> Vec<Scalar> {
    let Some(size) = plain.num_bytes() else { return Vec::new() };
    let is_big = plain.endianness() == Endianness::Big;
    let ticks = ticks(plain);
    let of = |name, offset, size, kind| Scalar { name, offset, size, kind, is_big, ticks };
    let kind = plain.type_char();
    let is_number = match kind {
        TypeChar::Complex if matches!(size, 8 | 16) => {
            let part = |what: &str, offset: usize| {
                of(format!("{name}.{what}"), offset, size / 2, TypeChar::Float)
            };
            return vec![part("real", offset), part("imag", offset + size / 2)];
        }
        TypeChar::Bool => size == 1,
        TypeChar::Int | TypeChar::Uint => matches!(size, 1 | 2 | 4 | 8),
        TypeChar::Float => matches!(size, 2 | 4 | 8),
        TypeChar::TimeDelta | TypeChar::DateTime => size == 8 && ticks.is_some(),
        _ => false,
    };
    if is_number { vec![of(name.to_owned(), offset, size, kind)] } else { Vec::new() }
}

/// Ticks of a second in a type of dates or durations.
fn ticks(plain: &TypeStr) -> Option<f64> {
    Some(match plain.time_units()? {
        TimeUnits::Second => 1.0,
        TimeUnits::Millisecond => 1e3,
        TimeUnits::Microsecond => 1e6,
        TimeUnits::Nanosecond => 1e9,
        TimeUnits::Picosecond => 1e12,
        _ => return None,
    })
}

/// The bits of an item.
fn bits(bytes: &[u8], scalar: &Scalar) -> u64 {
    let mut word = [0; 8];
    let word = &mut word[..bytes.len()];
    word.copy_from_slice(bytes);
    if scalar.is_big {
        word.reverse();
    }
    word.iter().rev().fold(0_u64, |sum, byte| sum << 8 | u64::from(*byte))
}

/// The whole number that an item of 64 bits is.
fn integer(bits: u64, scalar: &Scalar) -> Option<i128> {
    match (scalar.kind, scalar.size) {
        (TypeChar::Int, 8) => Some(bits.cast_signed().into()),
        (TypeChar::Uint, 8) => Some(bits.into()),
        _ => None,
    }
}

/// What is taken off a column that begins with these bits.
fn start_of(first: u64, scalar: &Scalar) -> Start {
    match (scalar.kind, scalar.ticks, integer(first, scalar).map(Base::of)) {
        (TypeChar::DateTime, Some(ticks), _) => Start::Date(first.cast_signed(), ticks),
        (_, _, Some(base)) if !base.is_none() => Start::Long(base),
        _ => Start::None,
    }
}

/// A number from its bits, without the column's start; that of a date is in s.
fn number(bits: u64, scalar: &Scalar, start: Start) -> f64 {
    const NO_TIME: u64 = 1 << 63;
    if let (Start::Long(base), Some(integer)) = (start, integer(bits, scalar)) {
        return base.off(integer);
    }
    match (scalar.kind, scalar.size, scalar.ticks) {
        (TypeChar::TimeDelta | TypeChar::DateTime, ..) if bits == NO_TIME => f64::NAN,
        (TypeChar::DateTime, _, Some(ticks)) => {
            let first = if let Start::Date(first, _) = start { first } else { 0 };
            bits.cast_signed().wrapping_sub(first) as f64 / ticks
        }
        (TypeChar::TimeDelta, _, Some(ticks)) => bits.cast_signed() as f64 / ticks,
        (TypeChar::Float, 2, _) => half::number(bits as u16),
        (TypeChar::Float, 4, _) => f64::from(f32::from_bits(bits as u32)),
        (TypeChar::Float, ..) => f64::from_bits(bits),
        (TypeChar::Int, size, _) => {
            let unused = 64 - 8 * size as u32;
            ((bits << unused) as i64 >> unused) as f64
        }
        _ => bits as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_shape(shape: &str, data: usize) -> Result<usize, Refusal> {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(118_u16.to_le_bytes());
        bytes.extend(format!("{header:<117}\n").bytes());
        bytes.extend(vec![0; 8 * data]);
        columns("column", bytes.as_slice(), &mut Budget::new(1000, None), &mut Vec::new())
            .map(|columns| columns.len())
    }

    #[test]
    fn columns_without_rows_take_no_memory() {
        assert_eq!(of_shape("(0, 1000000000000)", 0).unwrap(), 0);
        assert_eq!(of_shape("(1000000000000, 0)", 0).unwrap(), 0);
    }

    #[test]
    fn an_array_that_is_packed_a_thousandfold_is_refused() {
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000,), }";
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(118_u16.to_le_bytes());
        bytes.extend(format!("{header:<117}\n").bytes());
        let endless = bytes.as_slice().chain(std::io::repeat(0));
        let (rule, _) =
            columns("u", endless, &mut Budget::new(1000, None), &mut Vec::new()).err().unwrap();
        assert!(rule.contains("more memory than 269 MB"), "{rule}");
    }

    #[test]
    fn a_transposed_array_is_called_one() {
        let (rule, way_out) = of_shape("(2, 100000)", 200_000).unwrap_err();
        assert!(
            rule.contains("2 rows and 100000 columns") && way_out.contains("array.T"),
            "{rule}"
        );
        assert_eq!(of_shape("(2, 10)", 20).unwrap(), 10);
        assert_eq!(of_shape("(100000, 2)", 200_000).unwrap(), 2);
    }

    #[test]
    fn a_header_that_cannot_be_takes_no_memory() {
        let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
        bytes.extend(0xffff_fff0_u32.to_le_bytes());
        bytes.extend(b"{'descr': '<f8'}");
        let message =
            columns("column", bytes.as_slice(), &mut Budget::new(1000, None), &mut Vec::new())
                .err()
                .unwrap()
                .0;
        assert!(message.contains("4294967280 bytes is longer than 1048576"), "{message}");
    }
}

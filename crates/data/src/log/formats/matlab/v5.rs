//! The elements of a MATLAB 5 file.
//!
//! Source: MathWorks, "MAT-File Format" (R2024a), chapter 1. An element is a tag (type, bytes) and
//! its data; a variable is an element `miMATRIX` of further ones (flags, size, name, parts), packed
//! by zlib inside an element `miCOMPRESSED`.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::super::broken;
use super::super::budget::Budget;
use super::{Array, Value, Variables};
use crate::log::group::Refusal;

const HEADER: usize = 128;
/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Bytes of a text that are read; texts are labels.
const LONGEST_TEXT: usize = 4096;
/// Deepest structure of structures.
const DEEPEST: usize = 32;

/// The variables of a file.
pub(super) fn read(bytes: &[u8], budget: &mut Budget) -> Result<Variables, Refusal> {
    let header = bytes.get(..HEADER).ok_or_else(|| damaged(0, "the header is cut off"))?;
    let is_little = header.ends_with(b"IM");
    if !is_little && !header.ends_with(b"MI") {
        return Err(damaged(126, "the mark of the byte order is none"));
    }
    let mut variables = Variables::new();
    let mut file = Elements { bytes, at: HEADER, is_little };
    while file.at < bytes.len() {
        let place = file.at;
        let element = file.next(place)?;
        let unpacked;
        let matrix = match element.kind {
            COMPRESSED => {
                // Packed elements have no padding.
                file.at = element.end;
                let mut content = Vec::new();
                let limit = budget.to_unpack();
                let packed = ZlibDecoder::new(element.data).take(limit.saturating_add(1));
                { packed }.read_to_end(&mut content).map_err(|error| damaged(place, error))?;
                budget.unpack(content.len() as u64)?;
                unpacked = content;
                Elements { bytes: &unpacked, at: 0, is_little }.next(place)?
            }
            _ => element,
        };
        if matrix.kind != MATRIX {
            let what = format!("there is data of type {}, no variable", matrix.kind);
            return Err(damaged(place, what));
        }
        let parts = Elements { bytes: matrix.data, at: 0, is_little };
        let (name, value) = variable(parts, place, budget, 0)?;
        // What has no name belongs to the objects of other variables.
        if !name.is_empty() {
            variables.push((name, value));
        }
    }
    Ok(variables)
}

fn damaged(place: usize, what: impl std::fmt::Display) -> Refusal {
    broken("MATLAB 5", format_args!("at byte {place} {what}"))
}

/// Elements one after the other.
struct Elements<'a> {
    bytes: &'a [u8],
    at: usize,
    is_little: bool,
}

struct Element<'a> {
    kind: u32,
    data: &'a [u8],
    /// Where the data end, before the padding.
    end: usize,
}

impl<'a> Elements<'a> {
    fn u32(&self, at: usize) -> Option<u32> {
        let word = self.bytes.get(at..at.checked_add(4)?)?.try_into().ok()?;
        Some(if self.is_little { u32::from_le_bytes(word) } else { u32::from_be_bytes(word) })
    }

    /// The next element; `place` is that of the variable, for messages.
    fn next(&mut self, place: usize) -> Result<Element<'a>, Refusal> {
        let cut = || damaged(place, "a variable is cut off");
        let first = self.u32(self.at).ok_or_else(cut)?;
        // Up to four bytes stand in the tag itself.
        let is_small = first >> 16 != 0;
        let (kind, size, start) = match is_small {
            true => (first & 0xffff, first >> 16, self.at + 4),
            false => (first, self.u32(self.at + 4).ok_or_else(cut)?, self.at + 8),
        };
        if is_small && size > 4 {
            return Err(damaged(place, format_args!("a small part has {size} bytes")));
        }
        let end = start.checked_add(size as usize).ok_or_else(cut)?;
        let data = self.bytes.get(start..end).ok_or_else(cut)?;
        self.at = if is_small { self.at + 8 } else { end.next_multiple_of(8) };
        Ok(Element { kind, data, end })
    }
}

fn variable(
    mut parts: Elements<'_>,
    place: usize,
    budget: &mut Budget,
    depth: usize,
) -> Result<(String, Value), Refusal> {
    if parts.bytes.is_empty() {
        let (size, values, unit) = (vec![0, 0], Vec::new(), None);
        return Ok((String::new(), Value::Numbers(Array { size, values, unit })));
    }
    if depth > DEEPEST {
        return Err(damaged(place, format_args!("structures are nested deeper than {DEEPEST}")));
    }
    let flags = parts.next(place)?;
    let flags = Elements { bytes: flags.data, at: 0, is_little: parts.is_little };
    let flags = flags.u32(0).ok_or_else(|| damaged(place, "a variable has no flags"))?;
    let (class, is_complex) = (flags & 0xff, flags & 0x800 != 0);
    if class == 17 {
        // An object: its name, the system of objects, its class; the values stand elsewhere.
        let [name, _, class] = [parts.next(place)?, parts.next(place)?, parts.next(place)?];
        let class = String::from_utf8_lossy(class.data).into_owned();
        return Ok((text(name.data), Value::Other(format!("is an object of class {class}"))));
    }
    let size = parts.next(place)?;
    let size: Vec<usize> = words(&size, parts.is_little)
        .map(|word| usize::try_from(word.cast_signed()).unwrap_or(0))
        .collect();
    let name = text(parts.next(place)?.data);
    let too_large = || damaged(place, format_args!("the size of {name} cannot be"));
    let count = size.iter().try_fold(1_usize, |product, length| product.checked_mul(*length));
    let count = count.ok_or_else(too_large)?;
    let value = match class {
        6..=15 => {
            let mut part = || {
                let values = numbers(&parts.next(place)?, parts.is_little, budget)?;
                if values.len() != count {
                    let found = values.len();
                    let what =
                        format_args!("{name} has {found} values where its size says {count}");
                    return Err(damaged(place, what));
                }
                Ok(Value::Numbers(Array { size: size.clone(), values, unit: None }))
            };
            let real = part()?;
            if is_complex { Value::complex(real, part()?) } else { real }
        }
        4 => Value::Text(characters(&parts.next(place)?, parts.is_little)),
        2 | 3 => {
            if class == 3 {
                parts.next(place)?;
            }
            let length = parts.next(place)?;
            let length = words(&length, parts.is_little).next().unwrap_or(0) as usize;
            let names = parts.next(place)?;
            let fields: Vec<String> = match length {
                0 => Vec::new(),
                length => names.data.chunks_exact(length).map(text).collect(),
            };
            let mut fields: Vec<(String, Vec<Value>)> =
                fields.into_iter().map(|field| (field, Vec::new())).collect();
            for _ in 0..if fields.is_empty() { 0 } else { count } {
                for (_, values) in &mut fields {
                    // Each takes at least its tag, so that a size that is not there ends here.
                    values.push(inner(&mut parts, place, budget, depth)?);
                }
            }
            Value::Structure(fields)
        }
        1 => Value::Other("is a cell array".into()),
        5 => Value::Other("is a sparse array".into()),
        16 => Value::Other("is a function".into()),
        other => Value::Other(format!("is of class {other}")),
    };
    Ok((name, value))
}

fn inner(
    parts: &mut Elements<'_>,
    place: usize,
    budget: &mut Budget,
    depth: usize,
) -> Result<Value, Refusal> {
    let element = parts.next(place)?;
    if element.kind != MATRIX {
        return Err(damaged(place, format_args!("a field is data of type {}", element.kind)));
    }
    let inside = Elements { bytes: element.data, at: 0, is_little: parts.is_little };
    Ok(variable(inside, place, budget, depth + 1)?.1)
}

fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

fn words<'a>(element: &Element<'a>, is_little: bool) -> impl Iterator<Item = u32> + 'a {
    let words = element.data.as_chunks::<4>().0.iter();
    words.map(move |w| if is_little { u32::from_le_bytes(*w) } else { u32::from_be_bytes(*w) })
}

fn characters(element: &Element<'_>, is_little: bool) -> String {
    let data = &element.data[..element.data.len().min(LONGEST_TEXT)];
    match element.kind {
        // 16 bits: whole numbers or UTF-16.
        4 | 17 => {
            let units = data.as_chunks::<2>().0.iter();
            let unit = |w: &[u8; 2]| {
                if is_little { u16::from_le_bytes(*w) } else { u16::from_be_bytes(*w) }
            };
            String::from_utf16_lossy(&units.map(unit).collect::<Vec<u16>>())
        }
        _ => String::from_utf8_lossy(data).into_owned(),
    }
}

/// Numbers, which are stored in the least type that holds them.
fn numbers(
    element: &Element<'_>,
    is_little: bool,
    budget: &mut Budget,
) -> Result<Vec<f64>, Refusal> {
    macro_rules! of {
        ($type:ty, $convert:expr) => {{
            const SIZE: usize = size_of::<$type>();
            let words = element.data.as_chunks::<SIZE>().0;
            budget.column(words.len() as u64)?;
            let number = |word: &[u8; SIZE]| match is_little {
                true => <$type>::from_le_bytes(*word),
                false => <$type>::from_be_bytes(*word),
            };
            Ok(words.iter().map(number).map($convert).collect())
        }};
    }
    match element.kind {
        1 => of!(i8, f64::from),
        2 => of!(u8, f64::from),
        3 => of!(i16, f64::from),
        4 => of!(u16, f64::from),
        5 => of!(i32, f64::from),
        6 => of!(u32, f64::from),
        7 => of!(f32, f64::from),
        9 => of!(f64, |value| value),
        12 => of!(i64, |value| value as f64),
        13 => of!(u64, |value| value as f64),
        other => Err(broken("MATLAB 5", format_args!("numbers of type {other}"))),
    }
}

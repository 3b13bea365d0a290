//! A channel of an MDF 4 file: where its value stands in a record and what it means.
//!
//! Source: ASAM MDF 4.2, sections 5.14 (CN), 5.18 (CA).

use std::rc::Rc;

use super::super::half;
use super::blocks::{Block, Blocks};
use super::conversion::{Conversion, Conversions, Converted};
use crate::log::group::{Raw, Refusal};

/// Deepest channel in a channel.
const DEEPEST: usize = 8;

/// The values of one channel, as far as they were read.
pub(super) struct Channel {
    pub(super) name: String,
    pub(super) unit: String,
    /// Whether it is the time of its group.
    pub(super) is_time: bool,
    place: Place,
    conversion: Rc<Conversion>,
    pub(super) values: Vec<f64>,
    /// Whether a value was a text.
    pub(super) has_text: bool,
}

/// Where the value stands.
#[derive(Clone, Copy)]
enum Place {
    /// In the record: the first byte, how many, bits that are below, bits, the type.
    Record { byte: usize, bytes: usize, shift: u32, bits: u32, kind: Kind, invalid: Option<usize> },
    /// Nowhere: it is the number of the record.
    Counted,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Unsigned,
    Signed,
    Float,
}

/// What channels a group has.
pub(super) struct Channels<'a, 'b> {
    pub(super) blocks: &'b Blocks<'a>,
    pub(super) conversions: &'b mut Conversions<'a>,
    /// Bytes of a record before the bits that say what is invalid.
    pub(super) data_bytes: usize,
    pub(super) found: Vec<Channel>,
    /// Names of what is no signal, and why.
    pub(super) left_out: Vec<(String, String)>,
}

impl<'a> Channels<'a, '_> {
    /// Adds a channel and what it is composed of.
    pub(super) fn add(
        &mut self,
        block: &Block<'a>,
        within: &str,
        depth: usize,
    ) -> Result<(), Refusal> {
        let own = self.blocks.text(block, 2)?;
        let name = match within {
            "" => own,
            within if own.starts_with(within) => own,
            within => format!("{within}.{own}"),
        };
        let (kind, sync, data_type) = (block.byte(0), block.byte(1), block.byte(2));
        let composition = self.blocks.any(block, 1)?;
        if let Some(inner) = composition.filter(|inner| inner.id == *b"CN") {
            if depth == DEEPEST {
                self.left_out.push((name, "is nested too deep".into()));
                return Ok(());
            }
            let mut members = vec![inner];
            members.extend(self.blocks.list(&inner, 0, b"CN")?);
            return members.iter().try_for_each(|member| self.add(member, &name, depth + 1));
        }
        let why = match (kind, data_type) {
            (1, _) | (_, 6..=9) => Some("holds texts"),
            (_, 10..=12) => Some("holds bytes"),
            (_, 13 | 14) => Some("holds dates"),
            (_, 15 | 16) => Some("holds complex numbers"),
            (_, 17..) => Some("is of a type that is not known"),
            _ if block.u32(12) & 1 != 0 => Some("has invalid values only"),
            _ => None,
        };
        if let Some(why) = why {
            self.left_out.push((name, why.into()));
            return Ok(());
        }
        let conversion = match self.conversions.of(block, 4)? {
            Ok(conversion) => conversion,
            Err(why) => {
                self.left_out.push((name, why));
                return Ok(());
            }
        };
        let mut unit = self.blocks.text(block, 6)?;
        if unit.is_empty()
            && let Some(conversion) = self.blocks.any(block, 4)?
        {
            unit = self.blocks.text(&conversion, 1)?;
        }
        let is_time = matches!(kind, 2 | 3) && sync <= 1;
        let array = match composition.filter(|inner| inner.id == *b"CA") {
            Some(array) => match elements(&array) {
                Ok(elements) => elements,
                Err(why) => {
                    self.left_out.push((name, why.into()));
                    return Ok(());
                }
            },
            None => vec![(String::new(), 0)],
        };
        for (index, offset) in array {
            let place = match kind {
                3 | 6 => Some(Place::Counted),
                _ => self.place(block, data_type, offset),
            };
            let name = format!("{name}{index}");
            let Some(place) = place else {
                self.left_out.push((name, "lies outside the record".into()));
                continue;
            };
            let conversion = Rc::clone(&conversion);
            let (unit, values, has_text) = (unit.clone(), Vec::new(), false);
            self.found.push(Channel { name, unit, is_time, place, conversion, values, has_text });
        }
        Ok(())
    }

    /// The place of a value `offset` bytes behind the first element; `None` outside the record.
    fn place(&self, block: &Block<'_>, data_type: u8, offset: usize) -> Option<Place> {
        let (shift, bits) = (u32::from(block.byte(3)), block.u32(8));
        let byte = (block.u32(4) as usize).checked_add(offset)?;
        let bytes = (shift.checked_add(bits)?.div_ceil(8)) as usize;
        let kind = match data_type {
            0 | 1 => Kind::Unsigned,
            2 | 3 => Kind::Signed,
            _ => Kind::Float,
        };
        let is_known = match kind {
            Kind::Float => matches!(bits, 16 | 32 | 64) && shift == 0,
            _ => (1..=64).contains(&bits) && shift < 8,
        };
        let is_inside = byte.checked_add(bytes)? <= self.data_bytes;
        let is_big = data_type % 2 == 1;
        let flags = block.u32(12);
        let invalid = (flags & 2 != 0).then(|| 8 * self.data_bytes + block.u32(16) as usize);
        // Big-endian numbers are marked by the order of their bytes: see `raw`.
        let shift = if is_big { shift | BIG } else { shift };
        (is_known && is_inside).then_some(Place::Record { byte, bytes, shift, bits, kind, invalid })
    }
}

/// Mark of big-endian numbers in the shift.
const BIG: u32 = 1 << 16;

/// Index and place of each element of an array whose elements stand in the record.
fn elements(array: &Block<'_>) -> Result<Vec<(String, usize)>, &'static str> {
    /// Most elements; a map of a control unit has some hundred.
    const MOST: u64 = 4096;
    let (storage, dimensions) = (array.byte(1), usize::from(array.u16(2)));
    if storage != 0 {
        return Err("is an array whose elements are in other groups");
    }
    let step = array.u32(8) as usize;
    let lengths: Vec<u64> = (0..dimensions).map(|at| array.u64(16 + 8 * at)).collect();
    let count = lengths.iter().try_fold(1_u64, |count, length| count.checked_mul(*length));
    let count = count.filter(|count| (1..=MOST).contains(count) && dimensions > 0);
    let count = count.ok_or("is an array of no elements or more than 4096")?;
    let is_inverse = array.u32(4) & (1 << 6) != 0;
    let all = (0..count).map(|element| {
        let mut rest = element;
        let mut index = vec![0; lengths.len()];
        let order: Vec<usize> = match is_inverse {
            true => (0..lengths.len()).collect(),
            false => (0..lengths.len()).rev().collect(),
        };
        for at in order {
            index[at] = rest % lengths[at] + 1;
            rest /= lengths[at];
        }
        let index: Vec<String> = index.iter().map(u64::to_string).collect();
        (format!("[{}]", index.join(",")), element as usize * step)
    });
    Ok(all.collect())
}

impl Channel {
    /// Reads a stretch of records of `size` bytes, each behind `before` bytes; `first` is the
    /// number of the first one.
    pub(super) fn read(&mut self, records: &[u8], size: usize, before: usize, first: usize) {
        self.values.reserve(records.len() / size);
        for (record, number) in records.chunks_exact(size).zip(first..) {
            let value = match self.place {
                Place::Counted => number as f64,
                Place::Record { byte, bytes, shift, bits, kind, invalid } => {
                    let record = &record[before..];
                    let is_invalid = invalid.is_some_and(|bit| {
                        record.get(bit / 8).is_some_and(|flags| flags >> (bit % 8) & 1 != 0)
                    });
                    match is_invalid {
                        true => f64::NAN,
                        false => raw(&record[byte..byte + bytes], shift, bits, kind),
                    }
                }
            };
            let value = match self.conversion.convert(value) {
                Converted::Number(value) => value,
                Converted::Text => {
                    self.has_text = true;
                    f64::NAN
                }
            };
            self.values.push(value);
        }
    }

    pub(super) fn raw(self, name: String) -> Raw {
        Raw::new(name, Some(self.unit), self.values)
    }
}

/// A number from its bytes.
fn raw(bytes: &[u8], shift: u32, bits: u32, kind: Kind) -> f64 {
    let word = match shift & BIG {
        0 => bytes.iter().rev().fold(0_u128, |word, byte| word << 8 | u128::from(*byte)),
        _ => bytes.iter().fold(0_u128, |word, byte| word << 8 | u128::from(*byte)),
    };
    let unsigned = (word >> (shift & !BIG)) as u64;
    let unused = 64 - bits;
    match (kind, bits) {
        (Kind::Unsigned, _) => (unsigned << unused >> unused) as f64,
        (Kind::Signed, _) => ((unsigned << unused) as i64 >> unused) as f64,
        (Kind::Float, 16) => half::number(unsigned as u16),
        (Kind::Float, 32) => f64::from(f32::from_bits(unsigned as u32)),
        (Kind::Float, _) => f64::from_bits(unsigned),
    }
}

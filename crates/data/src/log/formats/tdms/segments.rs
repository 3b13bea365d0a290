//! The segments of a TDMS file: what objects they list and where the values of these stand.
//!
//! Source: NI, "TDMS File Format Internal Structure". A segment has a lead-in of 28 bytes, a list of objects
//! and their values. A list may be that of the segment before, with or without changes; the values are
//! repeated as long as there are bytes (chunks).

use std::collections::{HashMap, HashSet};

use super::super::broken;
use super::super::budget::Budget;
use super::object::{Cell, Layout, Object, Property, TEXT, size_of_kind};
use super::values::{Chunk, Order, number};
use crate::log::group::Refusal;

/// Bits of a lead-in.
const OBJECTS: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const VALUES: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;
const LEAD_IN: usize = 28;
/// Place of the next segment in one that was never closed.
const OPEN: u64 = u64::MAX;
/// Indices of values.
const NO_VALUES: u32 = u32::MAX;
const AS_BEFORE: u32 = 0;
const DAQMX: u32 = 0x1269;
const DAQMX_LINES: u32 = 0x126a;

/// What a file holds.
#[derive(Default)]
pub(super) struct File {
    /// In the order in which they appear.
    pub(super) objects: Vec<Object>,
    by_path: HashMap<Vec<u8>, usize>,
    /// Where the file is cut off.
    pub(super) cut: Option<String>,
}

impl File {
    /// Reads the bytes of a file.
    pub(super) fn read(bytes: &[u8], budget: &mut Budget) -> Result<Self, Refusal> {
        let mut file = Self::default();
        let (mut place, mut list, mut chunk) = (0, Vec::new(), None);
        while place + LEAD_IN <= bytes.len() {
            let mut lead = Bytes { bytes: &bytes[place..], at: 0, is_big: false };
            if lead.take(4)? != b"TDSm" {
                return Err(broken("TDMS", format_args!("at byte {place} there is no segment")));
            }
            let bits = lead.u32()?;
            lead.is_big = bits & BIG_ENDIAN != 0;
            lead.u32()?;
            let (next, raw) = (lead.u64()?, lead.u64()?);
            let start = place + LEAD_IN;
            let end = usize::try_from(next).ok().and_then(|next| next.checked_add(start));
            let is_cut = next == OPEN || end.is_none_or(|end| end > bytes.len());
            let end = end.filter(|_| !is_cut).unwrap_or(bytes.len());
            if end < start {
                return Err(broken("TDMS", "a segment ends before it begins"));
            }
            if bits & NEW_LIST != 0 {
                list.clear();
            }
            if bits & OBJECTS != 0 {
                chunk = None;
                let content = &bytes[start..end];
                let mut content = Bytes { bytes: content, at: 0, is_big: lead.is_big };
                match file.list(&mut content, &mut list) {
                    Ok(()) => {}
                    Err(_) if is_cut => {
                        file.cut = Some(format!("in the list of objects at byte {start}"));
                        break;
                    }
                    Err(error) => return Err(error),
                }
            }
            let raw = usize::try_from(raw).ok().and_then(|raw| raw.checked_add(start));
            let values = raw.and_then(|raw| bytes.get(raw..end)).unwrap_or_default();
            if bits & VALUES != 0 && !values.is_empty() {
                let order = Order { is_big: lead.is_big, is_interleaved: bits & INTERLEAVED != 0 };
                let chunk = chunk.get_or_insert_with(|| file.chunk(&list));
                if let Some(message) = chunk.read(values, order, &mut file.objects, budget)? {
                    file.cut =
                        Some(format!("in the values of the segment at byte {place}{message}"));
                }
            }
            if is_cut {
                file.cut.get_or_insert_with(|| format!("in the segment at byte {place}"));
                break;
            }
            place = end;
        }
        Ok(file)
    }

    /// Reads a list of objects into the present one.
    fn list(&mut self, bytes: &mut Bytes<'_>, list: &mut Vec<usize>) -> Result<(), Refusal> {
        let count = bytes.u32()?;
        let mut listed: HashSet<usize> = list.iter().copied().collect();
        for _ in 0..count {
            let path = bytes.text()?;
            let at = match self.by_path.get(path) {
                Some(at) => *at,
                None => {
                    self.objects.push(Object::new(path));
                    self.by_path.insert(path.to_vec(), self.objects.len() - 1);
                    self.objects.len() - 1
                }
            };
            let object = &mut self.objects[at];
            match bytes.u32()? {
                NO_VALUES => {
                    listed.remove(&at);
                }
                index => {
                    if index != AS_BEFORE {
                        object.layout = Some(layout(bytes, index)?);
                    }
                    if listed.insert(at) {
                        list.push(at);
                    }
                }
            }
            for _ in 0..bytes.u32()? {
                let name = String::from_utf8_lossy(bytes.text()?).into_owned();
                let value = property(bytes)?;
                self.property(at, name, value);
            }
        }
        list.retain(|at| listed.remove(at));
        Ok(())
    }

    /// Takes a property; the times of a channel are those of its first values.
    fn property(&mut self, at: usize, name: String, value: Property) {
        let object = &mut self.objects[at];
        let rows = object.values.len().max(object.instants.len());
        let rows = object.raw.values().map(Vec::len).fold(rows, usize::max);
        let is_time = ["wf_start_time", "wf_start_offset", "wf_increment"].contains(&name.as_str());
        let is_other = object.properties.get(&name).is_some_and(|before| *before != value);
        if is_time && rows > 0 && is_other {
            object.changed.get_or_insert((name, rows));
        } else {
            object.properties.insert(name, value);
        }
    }

    fn chunk(&self, list: &[usize]) -> Chunk {
        let listed = list.iter().filter_map(|at| Some((*at, self.objects[*at].layout.clone()?)));
        Chunk::new(listed.collect())
    }
}

/// How the values of an object are stored.
fn layout(bytes: &mut Bytes<'_>, index: u32) -> Result<Layout, Refusal> {
    let kind = bytes.u32()?;
    if bytes.u32()? != 1 {
        return Err(broken("TDMS", "a channel has more than one dimension"));
    }
    let count = bytes.u64()?;
    if index != DAQMX && index != DAQMX_LINES {
        if !matches!(index, 20 | 28) {
            return Err(broken("TDMS", format_args!("the index of a channel has {index} bytes")));
        }
        let text_bytes = if kind == TEXT { Some(bytes.u64()?) } else { None };
        return Ok(Layout { kind, count, text_bytes, cells: Vec::new(), widths: Vec::new() });
    }
    let mut cells = Vec::new();
    for _ in 0..bytes.u32()? {
        let (kind, buffer, offset) = (bytes.u32()?, bytes.u32()?, bytes.u32()?);
        let is_line = index == DAQMX_LINES;
        bytes.take(if is_line { 1 } else { 4 })?;
        let scale = bytes.u32()?;
        let (offset, bit) = if is_line { (offset / 8, Some(offset % 8)) } else { (offset, None) };
        cells.push(Cell { scale, kind, buffer, offset, bit });
    }
    let mut widths = Vec::new();
    for _ in 0..bytes.u32()? {
        widths.push(bytes.u32()?);
    }
    Ok(Layout { kind: 0, count, text_bytes: None, cells, widths })
}

fn property(bytes: &mut Bytes<'_>) -> Result<Property, Refusal> {
    let kind = bytes.u32()?;
    Ok(match kind {
        0x20 => Property::Text(String::from_utf8_lossy(bytes.text()?).into_owned()),
        0x44 => {
            let (first, second) = (bytes.u64()?, bytes.u64()?);
            let (seconds, parts) = if bytes.is_big { (first, second) } else { (second, first) };
            Property::Instant(seconds.cast_signed(), parts)
        }
        kind => match size_of_kind(kind) {
            Some(size) => {
                let number = number(bytes.take(size)?, kind, bytes.is_big);
                number.map_or(Property::Other, Property::Number)
            }
            None => return Err(broken("TDMS", format_args!("a property is of type {kind}"))),
        },
    })
}

/// Bytes that are read one after the other.
struct Bytes<'a> {
    bytes: &'a [u8],
    at: usize,
    is_big: bool,
}

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], Refusal> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        self.at += count;
        taken.ok_or_else(|| broken("TDMS", "a list of objects is longer than its segment"))
    }

    fn u32(&mut self) -> Result<u32, Refusal> {
        let mut word = [0; 4];
        word.copy_from_slice(self.take(4)?);
        Ok(if self.is_big { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) })
    }

    fn u64(&mut self) -> Result<u64, Refusal> {
        let mut word = [0; 8];
        word.copy_from_slice(self.take(8)?);
        Ok(if self.is_big { u64::from_be_bytes(word) } else { u64::from_le_bytes(word) })
    }

    fn text(&mut self) -> Result<&'a [u8], Refusal> {
        let length = self.u32()?;
        self.take(length as usize)
    }
}

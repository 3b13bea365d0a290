//! The objects of a TDMS file: names, properties, and how and where their values are stored.

use std::collections::BTreeMap;

/// Types of values.
pub(super) const TEXT: u32 = 0x20;
pub(super) const BOOL: u32 = 0x21;
pub(super) const INSTANT: u32 = 0x44;

/// The file (`/`), a group (`/'g'`) or a channel (`/'g'/'c'`).
pub(super) struct Object {
    /// Names of the group and the channel.
    pub(super) names: Vec<String>,
    pub(super) properties: BTreeMap<String, Property>,
    /// Layout of its values in the present segment, kept for "as before".
    pub(super) layout: Option<Layout>,
    pub(super) values: Vec<f64>,
    /// Whole seconds since 1904 and parts of 2⁻⁶⁴ s, for a channel of instants.
    pub(super) instants: Vec<(i64, u64)>,
    /// Values of the scalers of DAQmx, by the number of the scale.
    pub(super) raw: BTreeMap<u32, Vec<f64>>,
    /// A property of times that a later segment changes, and the rows before it.
    pub(super) changed: Option<(String, usize)>,
    /// Why its values cannot be used.
    pub(super) why_not: Option<String>,
}

impl Object {
    pub(super) fn new(path: &[u8]) -> Self {
        let path = String::from_utf8_lossy(path);
        // `/'it''s'/'c'`: an apostrophe in a name is doubled.
        let (mut names, mut letters) = (Vec::new(), path.chars().peekable());
        while let Some(letter) = letters.next() {
            if letter != '\'' {
                continue;
            }
            let mut name = String::new();
            while let Some(letter) = letters.next() {
                if letter == '\'' && letters.next_if_eq(&'\'').is_none() {
                    break;
                }
                name.push(letter);
            }
            names.push(name);
        }
        Self {
            names,
            properties: BTreeMap::new(),
            layout: None,
            values: Vec::new(),
            instants: Vec::new(),
            raw: BTreeMap::new(),
            changed: None,
            why_not: None,
        }
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        match self.properties.get(name)? {
            Property::Number(value) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn text(&self, name: &str) -> Option<&str> {
        match self.properties.get(name)? {
            Property::Text(text) => Some(text.trim()),
            _ => None,
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Property {
    Number(f64),
    Text(String),
    /// Whole seconds since 1904 and parts of 2⁻⁶⁴ s.
    Instant(i64, u64),
    Other,
}

/// How the values of one object stand in a chunk.
#[derive(Clone)]
pub(super) struct Layout {
    pub(super) kind: u32,
    pub(super) count: u64,
    /// Bytes of all its texts.
    pub(super) text_bytes: Option<u64>,
    /// Where DAQmx has put them; empty for plain values.
    pub(super) cells: Vec<Cell>,
    /// Bytes of a sample in each buffer of DAQmx.
    pub(super) widths: Vec<u32>,
}

/// A value in a sample of a buffer of DAQmx.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    /// Number of the scale that takes it.
    pub(super) scale: u32,
    pub(super) kind: u32,
    pub(super) buffer: u32,
    pub(super) offset: u32,
    /// The bit, for digital lines.
    pub(super) bit: Option<u32>,
}

impl Layout {
    /// Bytes in a chunk; `None` where nobody can say.
    pub(super) fn bytes(&self) -> Option<u64> {
        match self.text_bytes {
            Some(bytes) => Some(bytes),
            None => self.count.checked_mul(size_of_kind(self.kind)? as u64),
        }
    }
}

/// Bytes of a value.
pub(super) fn size_of_kind(kind: u32) -> Option<usize> {
    Some(match kind {
        1 | 5 | BOOL => 1,
        2 | 6 => 2,
        3 | 7 | 9 | 0x19 => 4,
        4 | 8 | 10 | 0x1a | 0x0008_000c => 8,
        11 | 0x1b | INSTANT | 0x0010_000d => 16,
        _ => return None,
    })
}

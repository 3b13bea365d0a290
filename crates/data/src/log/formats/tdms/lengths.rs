//! What a TDMS file says about its own lengths, before the reader of `tdms-rs` believes it.
//!
//! A file is a row of segments, each with a lead-in of 28 bytes, a list of objects and their values
//! (NI, "TDMS File Format Internal Structure"). `tdms-rs` takes memory for a text before it knows
//! whether the text is there, follows a segment that points back, and passes over the bits that say
//! that values are stored otherwise, several blocks of them among those: what it would read wrongly
//! is refused here.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use tdms_rs::DataType;

use crate::log::formats::broken;
use crate::log::group::Refusal;

/// Bits of a lead-in.
const OBJECTS: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
/// Ways of storing values that are not read.
const STORED_OTHERWISE: [(u32, &str); 3] = [
    (1 << 5, "its values are interleaved"),
    (1 << 6, "its numbers are big-endian"),
    (1 << 7, "its values are raw ones of DAQmx"),
];
const LEAD_IN: u64 = 28;
/// Place of the next segment in one that was never closed.
const OPEN: u64 = u64::MAX;

/// Refuses a file whose lengths cannot be, or whose values `tdms-rs` would read wrongly. What else
/// is wrong, an end within a segment among it, is left to `tdms-rs`.
pub(super) fn check(path: &Path) -> Result<(), Refusal> {
    let open = || {
        let file = File::open(path)?;
        Ok::<_, std::io::Error>((file.metadata()?.len(), BufReader::new(file)))
    };
    let (size, file) = open().map_err(|error| broken("TDMS", error))?;
    let mut walk = Walk { file, size, known: HashMap::new(), order: Vec::new() };
    loop {
        match walk.segment() {
            Ok(()) => {}
            Err(Stop::End) => return Ok(()),
            Err(Stop::Refused(why)) => return Err(broken("TDMS", why)),
        }
    }
}

enum Stop {
    /// The end of the file, or what `tdms-rs` refuses itself.
    End,
    Refused(String),
}

impl From<std::io::Error> for Stop {
    fn from(_: std::io::Error) -> Self {
        Self::End
    }
}

fn refuse<T>(why: impl Into<String>) -> Result<T, Stop> {
    Err(Stop::Refused(why.into()))
}

/// Values of an object in one segment.
#[derive(Clone, Copy)]
struct Values {
    bytes: u64,
    are_texts: bool,
}

struct Walk {
    file: BufReader<File>,
    size: u64,
    /// What an object that says "as before" repeats.
    known: HashMap<Vec<u8>, Values>,
    /// Objects of the present list, with values or without.
    order: Vec<(Vec<u8>, bool)>,
}

impl Walk {
    fn segment(&mut self) -> Result<(), Stop> {
        let begin = self.file.stream_position()?;
        if self.array()? != *b"TDSm" {
            return Err(Stop::End);
        }
        let bits = self.u32()?;
        self.u32()?;
        let (next, raw) = (self.u64()?, self.u64()?);
        if let Some((_, why)) = STORED_OTHERWISE.iter().find(|(bit, _)| bits & bit != 0) {
            return refuse(format!("{why}, which is not read"));
        }
        if bits & NEW_LIST != 0 {
            self.order.clear();
            for _ in 0..self.u32()? {
                self.object()?;
            }
        } else if bits & OBJECTS != 0 {
            return refuse("a segment changes the list of its channels, which is not read");
        } else {
            self.order.iter_mut().for_each(|(_, has_values)| *has_values = true);
        }
        let values: Vec<Values> = self
            .order
            .iter()
            .filter(|(_, has_values)| *has_values)
            .filter_map(|(name, _)| self.known.get(name).copied())
            .collect();
        let bytes = values.iter().try_fold(0_u64, |sum, values| sum.checked_add(values.bytes));
        let Some(bytes) = bytes.filter(|bytes| *bytes <= self.size) else {
            return refuse("a segment's values are longer than the file");
        };
        let end = if next == OPEN { raw.checked_add(bytes) } else { Some(next) };
        let end = end.and_then(|end| end.checked_add(begin + LEAD_IN));
        let Some(end) = end.filter(|end| i64::try_from(*end).is_ok()) else {
            return refuse("a segment ends beyond all files");
        };
        let room = next.checked_sub(raw).filter(|_| next != OPEN);
        let are_texts = values.iter().any(|values| values.are_texts);
        if let Some(room) = room.filter(|room| *room != bytes && !are_texts) {
            return refuse(format!(
                "a segment holds {room} bytes of values where its list says {bytes}; several blocks \
                 in one segment are not read"
            ));
        }
        self.file.seek(SeekFrom::Start(end))?;
        Ok(())
    }

    fn object(&mut self) -> Result<(), Stop> {
        let name = self.text()?;
        let index = self.u32()?;
        let mut properties = None;
        if index != 0 && index != u32::MAX {
            let index = self.bytes(index)?;
            let number = |at: usize| index.get(at..at + 8)?.try_into().ok().map(u64::from_le_bytes);
            let short = |at: usize| index.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
            if let Some(kind) = short(0) {
                let kind = DataType::from_u32(kind).map_err(|_| Stop::End)?;
                let count = number(8).unwrap_or(0);
                let bytes = count.checked_mul(kind.itemsize() as u64);
                // The sum of a segment's values is bounded where they are all known.
                let bytes = bytes.unwrap_or(u64::MAX);
                let are_texts = kind == DataType::String;
                if are_texts && count > self.size {
                    return refuse("a channel has more texts than the file has bytes");
                }
                self.known.insert(name.clone(), Values { bytes, are_texts });
                properties = if are_texts { None } else { short(index.len() - 4) };
            } else {
                properties = Some(0);
            }
        }
        self.order.push((name, index != u32::MAX));
        let properties = properties.map_or_else(|| self.u32(), Ok)?;
        (0..properties).try_for_each(|_| self.property())
    }

    fn property(&mut self) -> Result<(), Stop> {
        self.text()?;
        match DataType::from_u32(self.u32()?).map_err(|_| Stop::End)? {
            DataType::String => drop(self.text()?),
            kind => drop(self.bytes(kind.itemsize() as u32)?),
        }
        Ok(())
    }

    fn text(&mut self) -> Result<Vec<u8>, Stop> {
        let length = self.u32()?;
        self.bytes(length)
    }

    fn bytes(&mut self, length: u32) -> Result<Vec<u8>, Stop> {
        if u64::from(length) > self.size {
            return refuse(format!("a part of {length} bytes is longer than the file"));
        }
        let mut bytes = vec![0; length as usize];
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, Stop> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, Stop> {
        self.array().map(u64::from_le_bytes)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Stop> {
        let mut array = [0; N];
        self.file.read_exact(&mut array)?;
        Ok(array)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A segment of one channel of three doubles with one property.
    fn segment(bits: u32, count: u64, blocks: u64) -> Vec<u8> {
        let mut list = 1_u32.to_le_bytes().to_vec();
        list.extend(8_u32.to_le_bytes());
        list.extend(b"/'g'/'c'");
        list.extend([20_u32, 10, 1].map(u32::to_le_bytes).concat());
        list.extend(count.to_le_bytes());
        list.extend([1_u32, 1].map(u32::to_le_bytes).concat());
        list.extend(b"k");
        list.extend([32_u32, 2].map(u32::to_le_bytes).concat());
        list.extend(b"mm");
        let values = 24 * blocks;
        let mut all = b"TDSm".to_vec();
        all.extend([bits, 4713].map(u32::to_le_bytes).concat());
        all.extend((list.len() as u64 + values).to_le_bytes());
        all.extend((list.len() as u64).to_le_bytes());
        all.extend(list);
        all.extend((0..values / 8).flat_map(|row| (row as f64).to_le_bytes()));
        all
    }

    fn checked(bytes: &[u8]) -> Result<(), String> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        check(file.path()).map_err(|(rule, _)| rule)
    }

    #[test]
    fn segments_that_fit_pass_and_are_read() {
        let mut twice = segment(0xe, 3, 1);
        twice.extend(segment(0xe, 3, 1));
        assert_eq!(checked(&twice), Ok(()));
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), &twice).unwrap();
        let groups = super::super::read(file.path()).unwrap();
        assert_eq!(groups[0].columns[0].values, [0.0, 1.0, 2.0, 0.0, 1.0, 2.0]);
    }

    #[test]
    fn what_would_be_read_wrongly_is_refused() {
        for (bytes, why) in [
            (segment(0x2e, 3, 1), "interleaved"),
            (segment(0x4e, 3, 1), "big-endian"),
            (segment(0x8e, 3, 1), "DAQmx"),
            (segment(0xa, 3, 1), "changes the list"),
            (segment(0xe, 3, 2), "holds 48 bytes of values where its list says 24"),
            (segment(0xe, 1 << 40, 1), "longer than the file"),
            (segment(0xe, u64::MAX, 1), "longer than the file"),
        ] {
            let said = checked(&bytes).unwrap_err();
            assert!(said.contains(why), "{said}");
        }
    }

    /// A length of 4 GB takes no memory, and a segment that points back ends.
    #[test]
    fn lengths_beyond_the_file_are_refused() {
        let good = segment(0xe, 3, 1);
        // Lengths of the name, the index, the key and the property's text.
        for at in [32, 44, 68, 77] {
            let mut bytes = good.clone();
            bytes[at..at + 4].copy_from_slice(&0xffff_fffe_u32.to_le_bytes());
            let said = checked(&bytes).unwrap_err();
            assert!(said.contains("4294967294 bytes is longer than the file"), "{at}: {said}");
        }
        let mut back = good.clone();
        back[12..20].copy_from_slice(&28_u64.wrapping_neg().to_le_bytes());
        assert!(checked(&back).unwrap_err().contains("beyond all files"));
    }
}

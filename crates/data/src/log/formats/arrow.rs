//! Durations in Parquet files of Arrow and Polars.
//!
//! Parquet has no durations; these writers keep their own schema beside it, as key `ARROW:schema`: a message of Arrow's
//! IPC format in base64, which is a `FlatBuffers` table (format/Schema.fbs and Message.fbs of Apache Arrow).

use std::collections::HashMap;

/// Seconds per tick of the columns that the schema calls durations; none where it cannot be read.
pub(super) fn durations(schema: &str) -> HashMap<String, f64> {
    let found = || {
        let bytes = base64(schema)?;
        // 0xFFFFFFFF and the length of the message, in older files the length alone.
        let start = if bytes.starts_with(&[0xff; 4]) { 8 } else { 4 };
        let message = Table::root(bytes.get(start..)?)?;
        let fields = message.table(2)?.tables(1)?;
        Some(fields.into_iter().filter_map(|field| duration(&field)).collect())
    };
    found().unwrap_or_default()
}

/// Name and tick of a field that is a duration.
fn duration(field: &Table<'_>) -> Option<(String, f64)> {
    const DURATION: u8 = 18;
    if *field.bytes.get(field.place(2)?)? != DURATION {
        return None;
    }
    let kind = field.table(3)?;
    let unit = match kind.place(0) {
        Some(at) => u16::from_le_bytes(kind.bytes.get(at..at + 2)?.try_into().ok()?),
        None => 1,
    };
    let tick = *[1.0, 1e-3, 1e-6, 1e-9].get(usize::from(unit))?;
    Some((field.text(0)?, tick))
}

/// A table of a buffer: its offsets are followed only inside the buffer.
struct Table<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Table<'a> {
    fn root(bytes: &'a [u8]) -> Option<Self> {
        Some(Self { bytes, at: word(bytes, 0)? })
    }

    /// Where the value of a field stands; `None` where it has its default.
    fn place(&self, field: usize) -> Option<usize> {
        let back = word(self.bytes, self.at)?.cast_signed();
        let entries = self.at.checked_add_signed(back.checked_neg()?)?;
        let half = |at: usize| {
            let bytes = self.bytes.get(at..at.checked_add(2)?)?;
            Some(usize::from(u16::from_le_bytes(bytes.try_into().ok()?)))
        };
        let entry = 4 + 2 * field;
        let offset =
            if entry + 2 <= half(entries)? { half(entries.checked_add(entry)?)? } else { 0 };
        if offset == 0 { None } else { self.at.checked_add(offset) }
    }

    /// What a field points to.
    fn target(&self, field: usize) -> Option<usize> {
        let at = self.place(field)?;
        at.checked_add(word(self.bytes, at)?)
    }

    fn table(&self, field: usize) -> Option<Self> {
        Some(Self { bytes: self.bytes, at: self.target(field)? })
    }

    fn text(&self, field: usize) -> Option<String> {
        let at = self.target(field)?;
        let start = at.checked_add(4)?;
        let text = self.bytes.get(start..start.checked_add(word(self.bytes, at)?)?)?;
        Some(String::from_utf8_lossy(text).into_owned())
    }

    fn tables(&self, field: usize) -> Option<Vec<Self>> {
        let at = self.target(field)?;
        let count = word(self.bytes, at)?;
        let entries = (0..count).map_while(|entry| {
            let at = at.checked_add(4 + 4 * entry)?;
            Some(Self { bytes: self.bytes, at: at.checked_add(word(self.bytes, at)?)? })
        });
        Some(entries.collect())
    }
}

/// A number of 32 bits; one with a sign keeps it.
fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(4)?)?;
    let word = i32::from_le_bytes(bytes.try_into().ok()?);
    isize::try_from(word).ok().map(isize::cast_unsigned)
}

/// The bytes of a text in base64 (RFC 4648).
fn base64(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let (mut word, mut bits) = (0_u32, 0);
    for sign in text.bytes().filter(|sign| *sign != b'=') {
        let six = match sign {
            b'A'..=b'Z' => sign - b'A',
            b'a'..=b'z' => sign - b'a' + 26,
            b'0'..=b'9' => sign - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        word = word << 6 | u32::from(six);
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push((word >> bits) as u8);
            word &= (1 << bits) - 1;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of `pyarrow` 26.0.1: columns `time` of `duration("ms")` and `d` of `duration("us")`, and `u` of doubles.
    const SCHEMA: &str = "/////9AAAAAQAAAAAAAKAAwABgAFAAgACgAAAAABBAAMAAAACAAIAAAABAAIAAAABAAAAAMAAABwAAAAMAAAAAQAAA\
        Cs////AAABAxAAAAAUAAAABAAAAAAAAAABAAAAdQAAANr///8AAAIA1P///wAAARIQAAAAGAAAAAQAAAAAAAAAAQAA\
        AGQABgAIAAYABgAAAAAAAgAQABQACAAGAAcADAAAABAAEAAAAAAAARIQAAAAHAAAAAQAAAAAAAAABAAAAHRpbWUAAA\
        AABAAEAAQAAAAAAAAA";

    #[test]
    fn durations_of_arrow_have_their_ticks() {
        let found = durations(SCHEMA);
        assert_eq!((found.len(), found["time"], found["d"]), (2, 1e-3, 1e-6));
    }

    #[test]
    fn damaged_schemas_end_in_nothing() {
        for end in 0..SCHEMA.len() {
            durations(&SCHEMA[..end]);
            let mut other = SCHEMA.as_bytes().to_vec();
            for sign in *b"A/z" {
                other[end] = sign;
                durations(std::str::from_utf8(&other).unwrap());
            }
        }
        assert!(durations("no schema").is_empty());
    }
}

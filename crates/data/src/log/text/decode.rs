//! Bytes to text: UTF-8, UTF-16 with or without a mark, Latin-1.

use std::io::{self, Read};

/// Bytes that are decoded at a time.
const CHUNK: usize = 1 << 16;

/// Whether a text in UTF-16 has its high byte first; `None` for what is no UTF-16.
pub(super) fn is_utf16(head: &[u8]) -> Option<bool> {
    match head {
        [0xff, 0xfe, ..] => return Some(false),
        [0xfe, 0xff, ..] => return Some(true),
        _ => {}
    }
    // Without a mark: nearly all characters have a byte that is 0, the same one.
    let pairs = head[..head.len().min(64)].chunks_exact(2);
    let all = pairs.len();
    let is = |high: usize| {
        let alike = pairs.clone().filter(|pair| pair[high] == 0 && pair[1 - high] != 0).count();
        all >= 4 && 8 * alike >= 7 * all
    };
    (is(0) || is(1)).then(|| is(0))
}

/// The text in UTF-8 of a text in UTF-16; what is no character becomes `U+FFFD`.
pub(super) struct Utf16<R> {
    bytes: R,
    is_big: bool,
    /// Bytes that are not decoded yet.
    left: Vec<u8>,
    text: String,
    /// Bytes of `text` that were given.
    given: usize,
}

impl<R: Read> Utf16<R> {
    pub(super) fn new(bytes: R, is_big: bool) -> Self {
        Self { bytes, is_big, left: Vec::new(), text: String::new(), given: 0 }
    }

    fn fill(&mut self) -> io::Result<()> {
        let before = self.left.len();
        self.bytes.by_ref().take(CHUNK as u64).read_to_end(&mut self.left)?;
        let is_end = self.left.len() == before;
        let mut units: Vec<u16> = self
            .left
            .chunks_exact(2)
            .map(|pair| match self.is_big {
                true => u16::from_be_bytes([pair[0], pair[1]]),
                false => u16::from_le_bytes([pair[0], pair[1]]),
            })
            .collect();
        // The second half of a pair may still come.
        if !is_end && units.last().is_some_and(|last| (0xd800..0xdc00).contains(last)) {
            units.pop();
        }
        self.left.drain(..if is_end { self.left.len() } else { 2 * units.len() });
        self.text.clear();
        self.given = 0;
        let characters =
            char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        self.text.extend(characters);
        Ok(())
    }
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.given == self.text.len() {
            self.fill()?;
        }
        let mut rest = &self.text.as_bytes()[self.given..];
        let count = rest.read(out)?;
        self.given += count;
        Ok(count)
    }
}

/// A cell of the head as text: UTF-8, else Latin-1, in which instruments write µ and °.
pub(super) fn text(cell: &[u8]) -> String {
    match std::str::from_utf8(cell) {
        Ok(text) => text.to_owned(),
        Err(_) => cell.iter().map(|byte| char::from(*byte)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utf_16_is_decoded_in_parts() {
        // A character of two units lies across the border of the chunks.
        let text = format!("{}😀µm", "a".repeat(CHUNK / 2 - 1));
        for is_big in [false, true] {
            let bytes: Vec<u8> = text
                .encode_utf16()
                .flat_map(|unit| if is_big { unit.to_be_bytes() } else { unit.to_le_bytes() })
                .collect();
            assert_eq!(is_utf16(&bytes), Some(is_big));
            let mut back = String::new();
            Utf16::new(bytes.as_slice(), is_big).read_to_string(&mut back).unwrap();
            assert!(back == text);
        }
        assert_eq!(is_utf16(b"time,u\n0,1\n"), None);
        assert_eq!(is_utf16(&[0; 64]), None);
        assert_eq!(super::text(b"y [\xb5m]"), "y [µm]");
    }
}

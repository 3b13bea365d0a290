//! Zip archives of stored entries, taken apart and put together by hand: the fields stay ours.

use crate::Random;

/// A stored entry.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) name: Vec<u8>,
    pub(crate) content: Vec<u8>,
}

const LOCAL: &[u8; 4] = b"PK\x03\x04";
const CENTRAL: &[u8; 4] = b"PK\x01\x02";
const END: &[u8; 4] = b"PK\x05\x06";

/// The stored entries at the front of an archive; none where it begins otherwise.
pub(crate) fn stored(archive: &[u8]) -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut rest = archive;
    while let Some((head, body)) = rest.split_first_chunk::<30>() {
        let half = |at: usize| usize::from(u16::from_le_bytes([head[at], head[at + 1]]));
        let size = u32::from_le_bytes([head[18], head[19], head[20], head[21]]) as usize;
        let (name, extra) = (half(26), half(28));
        let complete = (name + extra).checked_add(size);
        if &head[..4] != LOCAL
            || half(8) != 0
            || complete.is_none_or(|complete| complete > body.len())
        {
            break;
        }
        let content = body[name + extra..name + extra + size].to_vec();
        entries.push(Entry { name: body[..name].to_vec(), content });
        rest = &body[name + extra + size..];
    }
    entries
}

/// An archive of these entries, stored.
pub(crate) fn packed(entries: &[Entry]) -> Vec<u8> {
    let (mut out, mut central) = (Vec::new(), Vec::new());
    for entry in entries {
        let name = &entry.name[..entry.name.len().min(usize::from(u16::MAX))];
        let at = out.len() as u32;
        let size = (entry.content.len() as u32).to_le_bytes();
        let checksum = crc32fast::hash(&entry.content).to_le_bytes();
        // Version, flags, method, time and date of the format's first day.
        let shared: [u8; 10] = [20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
        let length = (name.len() as u16).to_le_bytes();
        let numbers = [&shared[..], &checksum, &size, &size, &length, &[0, 0]].concat();
        out.extend([&LOCAL[..], &numbers, name, &entry.content].concat());
        central.extend([&CENTRAL[..], &[20, 3], &numbers, &[0; 6]].concat());
        central
            .extend([&(0o100_644_u32 << 12).to_le_bytes()[..], &at.to_le_bytes(), name].concat());
    }
    let count = (entries.len() as u16).to_le_bytes();
    let (size, at) = ((central.len() as u32).to_le_bytes(), (out.len() as u32).to_le_bytes());
    out.extend(central);
    out.extend([&END[..], &[0; 4], &count, &count, &size, &at, &[0, 0]].concat());
    out
}

/// Sets a field of one of the archive's records.
pub(crate) fn fields(archive: &mut [u8], random: &mut Random, numbers: &[u64]) {
    let mark = *random.of(&[LOCAL, CENTRAL, END]);
    let starts = archive.windows(4).zip(0..).filter(|(bytes, _)| bytes == mark);
    let starts: Vec<usize> = starts.map(|(_, at)| at).collect();
    if starts.is_empty() {
        if let Some(byte) = archive.first_mut() {
            *byte = random.draw() as u8;
        }
        return;
    }
    let at = random.of(&starts) + 4 + random.below(44);
    let width = [1, 2, 4][random.below(3)];
    let size = archive.len() as u64;
    let number = match random.below(3) {
        0 => *random.of(numbers),
        1 => size.wrapping_sub(random.below(64) as u64),
        _ => random.draw() >> random.below(64),
    };
    for (to, byte) in archive.iter_mut().skip(at).zip(&number.to_le_bytes()[..width]) {
        *to = *byte;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_is_an_archive() {
        let entry =
            |name: &[u8], content: &[u8]| Entry { name: name.into(), content: content.into() };
        let entries = [entry(b"a", b"one"), entry(b"b/c", b"")];
        let bytes = packed(&entries);
        let again = stored(&bytes);
        assert_eq!(again.len(), 2);
        assert_eq!((&again[0].content[..], &again[1].name[..]), (&b"one"[..], &b"b/c"[..]));
    }
}

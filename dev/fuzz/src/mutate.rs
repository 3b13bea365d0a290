//! Mutations that know what they mutate: the words of a text, the entries of an archive, the fields
//! of a binary file.

use crate::{Kind, Random, zip};

/// Longest input; a reader's work on it is then bounded too.
pub const LONGEST: usize = 16 << 10;

/// Words and numbers that readers care about.
const WORDS: [&str; 64] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "3",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "2147483648",
    "-2147483649",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "1e308",
    "-1e308",
    "1e309",
    "5e-324",
    "1e-400",
    "NaN",
    "nan",
    "inf",
    "-inf",
    "Infinity",
    "0.1",
    "1e5",
    "true",
    "false",
    "null",
    "\"",
    "'",
    "\"\"",
    "''",
    "<",
    ">",
    "</",
    "/>",
    "<!--",
    "-->",
    "<![CDATA[",
    "]]>",
    "<!DOCTYPE",
    "&amp;",
    "&#0;",
    "&#x10FFFF;",
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "=",
    ",",
    ";",
    "\n",
    "\r\n",
    "\t",
    "\u{feff}",
    "\u{0}",
    "µm",
    "../",
];

/// Numbers at which fields of binary files break.
const NUMBERS: [u64; 24] = [
    0,
    1,
    2,
    7,
    8,
    16,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0x8000,
    0xffff,
    0x1_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x1_0000_0000,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0x7ff0_0000_0000_0000,
    0x7ff8_0000_0000_0000,
    0xffff_ffff_ffff_fff8,
    u64::MAX,
];

/// Mutates an input of this kind in place, up to [`LONGEST`] bytes; `other` is another input of the
/// same target, from which parts are taken.
pub fn mutate(kind: Kind, input: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    for _ in 0..=random.below(4) {
        match kind {
            Kind::Text => text(input, other, random),
            Kind::Binary => binary(input, other, random),
            Kind::Zip => archive(input, other, random),
        }
    }
    input.truncate(LONGEST);
}

/// Whether a text is cut here: where a word begins or ends.
fn is_cut(input: &[u8], at: usize) -> bool {
    let is_word = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-');
    at == 0 || at >= input.len() || is_word(input[at - 1]) != is_word(input[at])
}

/// A range of whole words, mostly a short one.
fn words(input: &[u8], random: &mut Random) -> std::ops::Range<usize> {
    let cut = |from: usize| (from..=input.len()).find(|at| is_cut(input, *at));
    let first = random.below(input.len() + 1);
    let start = (0..=first).rfind(|at| is_cut(input, *at)).unwrap_or(0);
    if random.one_in(8) {
        let far = start + random.below(input.len() - start + 1);
        return start..cut(far).unwrap_or(input.len());
    }
    let count = random.below(6);
    let end = (0..count).fold(start, |end, _| cut(end + 1).unwrap_or(input.len()));
    start..end
}

/// The range of the line around a place.
fn line(input: &[u8], at: usize) -> std::ops::Range<usize> {
    let start = input[..at].iter().rposition(|b| *b == b'\n').map_or(0, |found| found + 1);
    let end = input[at..].iter().position(|b| *b == b'\n').map_or(input.len(), |n| at + n + 1);
    start..end
}

fn text(input: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    if input.is_empty() {
        input.extend_from_slice(other);
    }
    match random.below(10) {
        0 => {
            let at = words(input, random);
            input.drain(at);
        }
        1 => {
            let at = words(input, random);
            let word = random.of(&WORDS).bytes();
            input.splice(at, word);
        }
        2 => {
            let (at, from) = (words(input, random), words(other, random));
            input.splice(at, other[from].iter().copied());
        }
        3 => {
            let (at, from) = (words(input, random).start, words(input, random));
            let copy = input[from].to_vec();
            input.splice(at..at, copy);
        }
        4 => {
            let (place, from) = (random.below(input.len() + 1), random.below(input.len() + 1));
            let (at, from) = (line(input, place).start, line(input, from));
            let copy = input[from].to_vec();
            input.splice(at..at, copy);
        }
        5 => {
            let place = random.below(input.len() + 1);
            let at = line(input, place);
            input.drain(at);
        }
        6 => {
            let at = words(input, random).start;
            let word = random.of(&WORDS).bytes();
            input.splice(at..at, word);
        }
        7 => {
            let at = words(input, random);
            let times = 1 + random.below(200);
            let copy = input[at.clone()].repeat(times);
            if copy.len() < LONGEST {
                input.splice(at, copy);
            }
        }
        8 => {
            let place = random.below(other.len() + 1);
            let from = line(other, place);
            let place = random.below(input.len() + 1);
            let at = line(input, place).start;
            input.splice(at..at, other[from].iter().copied());
        }
        _ => bytes(input, random),
    }
}

fn bytes(input: &mut Vec<u8>, random: &mut Random) {
    if input.is_empty() {
        return input.push(random.draw() as u8);
    }
    let at = random.below(input.len());
    match random.below(5) {
        0 => input[at] = random.draw() as u8,
        1 => input[at] ^= 1 << random.below(8),
        2 => input.insert(at, random.draw() as u8),
        3 => drop(input.remove(at)),
        _ => input.truncate(at),
    }
}

fn binary(input: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    if input.is_empty() {
        input.extend_from_slice(other);
    }
    let size = input.len();
    match random.below(8) {
        0..=3 => {
            let width = 1 << random.below(4);
            let near = random.draw() % 3;
            let number = match random.below(3) {
                0 => random.of(&NUMBERS).wrapping_add(near).wrapping_sub(1),
                1 => size as u64 + near,
                _ => random.draw() >> random.below(64),
            };
            // Fields stand at multiples of their width, mostly.
            let at = match random.one_in(3) {
                true => random.below(size),
                false => random.below(size) / width * width,
            };
            let number = match random.one_in(6) {
                true => number.swap_bytes().to_le_bytes(),
                false => number.to_le_bytes(),
            };
            for (to, byte) in input.iter_mut().skip(at).zip(&number[..width]) {
                *to = *byte;
            }
        }
        4 => {
            let (at, from) = (random.below(size), random.below(other.len()));
            let length = random.below(64).min(other.len() - from);
            input.splice(at..at, other[from..from + length].iter().copied());
        }
        5 => {
            let at = random.below(size);
            let end = (at + random.below(64)).min(size);
            input.drain(at..end);
        }
        _ => bytes(input, random),
    }
}

/// Archives with stored entries are taken apart and put together again with right checksums, so
/// that mutations reach what is inside.
fn archive(input: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let entries = zip::stored(input);
    if entries.is_empty() || random.one_in(3) {
        return zip::fields(input, random, &NUMBERS);
    }
    let mut entries = entries;
    let at = random.below(entries.len());
    match random.below(8) {
        0 => drop(entries.remove(at)),
        1 => entries.insert(at, entries[at].clone()),
        2 => bytes(&mut entries[at].name, random),
        3 => entries[at].name = random.of(&NAMES).as_bytes().to_vec(),
        4 => {
            let others = zip::stored(other);
            if !others.is_empty() {
                entries.push(random.of(&others).clone());
            }
        }
        _ => {
            let others = zip::stored(other);
            let content = entries[at].content.clone();
            let other = others.get(at).map_or(&content, |other| &other.content);
            text(&mut entries[at].content, other, random);
        }
    }
    *input = zip::packed(&entries);
}

/// Names of entries that readers know or must refuse.
const NAMES: [&str; 16] = [
    "modelDescription.xml",
    "SystemStructure.ssd",
    "resources/",
    "resources/blueprint.toml",
    "binaries/linux64/stage.so",
    "binaries/x86_64-linux/stage.so",
    "resources/plant.fmu",
    "start.ssv",
    "terminalsAndIcons/terminalsAndIcons.xml",
    "../harm",
    "/harm",
    "C:\\harm",
    "a//b",
    "./modelDescription.xml",
    "resources\\x",
    "con",
];

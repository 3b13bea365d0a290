//! WAV files: each coding, with the values bit by bit.
#![cfg(feature = "formats")]

#[path = "common/corpus.rs"]
mod corpus;

use std::fs;

use data::{Log, ReadOptions};

const ROWS: usize = 40;
const RATE: u32 = 48_000;

#[derive(Clone, Copy, Debug)]
enum Coding {
    Integers(u16),
    Floats(u16),
}

/// Value `k` of a channel: a number of 7 bits, which every coding holds.
fn value(k: usize, channel: usize) -> f64 {
    ((k * 37 + channel * 11) % 255) as f64 / 128.0 - 127.0 / 128.0
}

fn coded(x: f64, coding: Coding) -> Vec<u8> {
    match coding {
        Coding::Integers(8) => vec![(x * 128.0 + 128.0) as u8],
        Coding::Integers(bits) => {
            let integer = (x * 2_f64.powi(31)) as i32;
            integer.to_le_bytes()[4 - usize::from(bits / 8)..].to_vec()
        }
        Coding::Floats(32) => (x as f32).to_le_bytes().to_vec(),
        Coding::Floats(_) => x.to_le_bytes().to_vec(),
    }
}

fn chunk(name: &[u8], size: u32, content: &[u8]) -> Vec<u8> {
    let mut all = [name, &size.to_le_bytes(), content].concat();
    all.resize(all.len() + content.len() % 2, 0);
    all
}

/// The chunk `fmt `.
fn format(channels: u16, coding: Coding, is_extensible: bool) -> Vec<u8> {
    let (tag, bits) = match coding {
        Coding::Integers(bits) => (1_u16, bits),
        Coding::Floats(bits) => (3, bits),
    };
    let block = channels * bits / 8;
    let first = if is_extensible { 0xfffe } else { tag };
    let mut all = [first, channels].map(u16::to_le_bytes).concat();
    all.extend(RATE.to_le_bytes());
    all.extend((RATE * u32::from(block)).to_le_bytes());
    all.extend([block, bits].map(u16::to_le_bytes).concat());
    if is_extensible {
        all.extend([22, bits, 0, 0, tag].map(u16::to_le_bytes).concat());
        all.extend(b"\0\0\0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71");
    }
    chunk(b"fmt ", all.len() as u32, &all)
}

fn data(channels: usize, coding: Coding) -> Vec<u8> {
    (0..ROWS).flat_map(|k| (0..channels).flat_map(move |c| coded(value(k, c), coding))).collect()
}

fn file(begin: &[u8], chunks: &[Vec<u8>]) -> Vec<u8> {
    let chunks = chunks.concat();
    [begin, &(chunks.len() as u32 + 4).to_le_bytes(), b"WAVE", &chunks].concat()
}

fn wav(channels: u16, coding: Coding, is_extensible: bool) -> Vec<u8> {
    let data = data(channels.into(), coding);
    let info = chunk(b"LIST", 5, b"INFOx");
    let values = chunk(b"data", data.len() as u32, &data);
    file(b"RIFF", &[format(channels, coding, is_extensible), info, values])
}

fn read(content: &[u8]) -> Result<Log, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("recorded.wav");
    fs::write(&path, content).expect("a file");
    Log::read(&path, &ReadOptions::default()).map_err(|problems| problems.to_string())
}

fn holds(log: &Log, channels: usize, rows: usize) {
    assert_eq!(log.len(), rows);
    for (k, time) in log.time().iter().enumerate() {
        assert_eq!(*time, k as f64 / f64::from(RATE));
    }
    for channel in 0..channels {
        let column = log.column(&format!("channel[{}]", channel + 1)).expect("a channel");
        for (k, got) in column.values.iter().enumerate() {
            assert_eq!(*got, value(k, channel), "row {k} of channel {channel}");
        }
    }
}

const CODINGS: [Coding; 6] = [
    Coding::Integers(8),
    Coding::Integers(16),
    Coding::Integers(24),
    Coding::Integers(32),
    Coding::Floats(32),
    Coding::Floats(64),
];

#[test]
fn every_coding_has_its_values() {
    for coding in CODINGS {
        for channels in [1, 3] {
            for is_extensible in [false, true] {
                let log = read(&wav(channels, coding, is_extensible));
                let log = log.unwrap_or_else(|error| panic!("{coding:?}: {error}"));
                holds(&log, channels.into(), ROWS);
            }
        }
    }
    corpus::hold("wav", "integers.wav", &wav(2, Coding::Integers(16), false));
    corpus::hold("wav", "floats.wav", &wav(3, Coding::Floats(32), true));
}

#[test]
fn recordings_without_an_end_and_long_ones_are_read() {
    let coding = Coding::Integers(24);
    let data = data(2, coding);
    for size in [0, u32::MAX] {
        let open = file(b"RIFF", &[format(2, coding, false), chunk(b"data", size, &data)]);
        holds(&read(&open).expect("a log"), 2, ROWS);
    }
    let sizes = [0_u64, data.len() as u64, ROWS as u64].map(u64::to_le_bytes).concat();
    let behind = chunk(b"LIST", 4, b"INFO");
    let long = [
        chunk(b"ds64", 28, &[&sizes[..], &[0; 4]].concat()),
        format(2, coding, true),
        chunk(b"data", u32::MAX, &data),
        behind,
    ];
    let long = file(b"RF64", &long);
    holds(&read(&long).expect("a log"), 2, ROWS);
    corpus::hold("wav", "long.wav", &long);
}

#[test]
fn what_is_cut_off_or_coded_otherwise_is_stated() {
    let complete = wav(2, Coding::Integers(16), false);
    let data_at = complete.len() - ROWS * 4;
    for end in 0..complete.len() {
        match read(&complete[..end]) {
            Ok(log) => {
                let rows = (end - data_at) / 4;
                holds(&log, 2, rows);
                let reported = format!("{rows} of {ROWS} frames");
                assert!(
                    log.notes().iter().any(|note| note.contains(&reported)),
                    "{:?}",
                    log.notes()
                );
            }
            Err(message) => assert!(!message.is_empty() && end < data_at + 8, "{end}: {message}"),
        }
    }
    let mut other = complete.clone();
    other[20] = 0x55;
    let message = read(&other).expect_err("a refusal");
    assert!(message.contains("coding 85") && message.contains("PCM"), "{message}");
    let mut uneven = complete;
    uneven[32] = 5;
    let message = read(&uneven).expect_err("a refusal");
    assert!(message.contains("5 bytes per frame"), "{message}");
}

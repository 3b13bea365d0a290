//! MDF 4 files as loggers, INCA, CANape and asammdf write them.
#![cfg(feature = "formats")]

#[path = "binary/mdf.rs"]
mod mdf;

use std::time::{Duration, Instant};

use data::{Log, ReadOptions};
use mdf::{Channel, File, time};

fn read_with(bytes: &[u8], options: &ReadOptions) -> Result<Log, String> {
    let file = tempfile::Builder::new().suffix(".mf4").tempfile().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    Log::read(file.path(), options).map_err(|problems| problems.to_string())
}

fn read(file: &File) -> Result<Log, String> {
    read_with(&file.bytes, &ReadOptions::default())
}

/// Records of a time and of bytes that depend on the row.
fn records(rows: u32, more: impl Fn(u32) -> Vec<u8>) -> Vec<u8> {
    let record = |row: u32| [&(f64::from(row) * 0.01).to_le_bytes()[..], &more(row)].concat();
    (0..rows).flat_map(record).collect()
}

fn channel(name: &'static str, byte: u32, bits: u32) -> Channel {
    Channel { name, byte, bits, ..Channel::default() }
}

fn values<'a>(log: &'a Log, name: &str) -> &'a [f64] {
    &log.column(name).unwrap_or_else(|| panic!("no column {name}: {:?}", log.notes())).values
}

/// A file of one group of a time and a byte with a conversion.
fn converted(make: impl Fn(&mut File) -> u64) -> Result<Log, String> {
    let mut file = File::new();
    let conversion = make(&mut file);
    let data = file.block(b"DT", &[], &records(4, |row| vec![row as u8, 7]));
    let channels = [
        time(),
        Channel { conversion, ..channel("x", 8, 8) },
        Channel { unit: "V", ..channel("u", 9, 8) },
    ];
    file.group("g", &channels, 10, 4, data);
    read(&file)
}

#[test]
fn words_leave_their_channel_out() {
    let log = converted(|file| {
        let words = ["off", "on", "fault"].map(|word| file.text(word));
        file.conversion(7, &[words[0], words[1], words[2], 0], &[0.0, 1.0, 2.0])
    });
    let log = log.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(values(&log, "u"), [7.0; 4]);
    assert!(log.column("x").is_none());
    assert!(log.left_out()[0].why.contains("holds texts"), "{:?}", log.left_out());
    // INCA: words for a few values, a scale for all others.
    let log = converted(|file| {
        let (word, scale) = (file.text("error"), file.conversion(1, &[], &[10.0, 0.5]));
        file.conversion(8, &[word, scale], &[254.0, 255.0])
    });
    assert_eq!(values(&log.unwrap(), "x"), [10.0, 10.5, 11.0, 11.5]);
}

#[test]
fn conversions_have_their_values() {
    let of = |kind, numbers: &'static [f64]| {
        let log = converted(move |file| file.conversion(kind, &[], numbers));
        values(&log.unwrap_or_else(|error| panic!("{kind}: {error}")), "x").to_vec()
    };
    assert_eq!(of(1, &[1.0, 2.0]), [1.0, 3.0, 5.0, 7.0]);
    assert_eq!(of(2, &[0.0, 1.0, 0.0, 0.0, 1.0, 1.0]), [0.0, 0.5, 2.0 / 3.0, 0.75]);
    assert_eq!(of(4, &[0.0, 0.0, 2.0, 10.0]), [0.0, 5.0, 10.0, 10.0]);
    assert_eq!(of(5, &[0.0, 1.0, 3.0, 9.0]), [1.0, 1.0, 9.0, 9.0]);
    assert_eq!(of(6, &[0.0, 1.0, 5.0, 2.0, 2.0, 6.0, -1.0]), [5.0, 5.0, 6.0, -1.0]);
    let log = converted(|file| {
        let formula = file.text("2*X1^2 + 1");
        file.conversion(3, &[formula], &[])
    });
    assert_eq!(values(&log.unwrap(), "x"), [1.0, 3.0, 9.0, 19.0]);
}

/// A conversion in itself, formulas without end: the channel is left out, at once.
#[test]
fn conversions_that_cannot_be_are_left_out() {
    let begin = Instant::now();
    let in_itself = |file: &mut File| {
        let place = file.conversion(7, &[0, 0], &[1.0]);
        file.link(place, 5, place);
        place
    };
    let deep = |file: &mut File| {
        let mut place = file.conversion(1, &[], &[0.0, 1.0]);
        for _ in 0..10_000 {
            place = file.conversion(7, &[0, place], &[1.0]);
        }
        place
    };
    let long = |file: &mut File| {
        let formula = file.text(&("X1+".repeat(133_000) + "X1"));
        file.conversion(3, &[formula], &[])
    };
    let brackets = |file: &mut File| {
        let formula = file.text(&"(".repeat(400_000));
        file.conversion(3, &[formula], &[])
    };
    for (make, why) in [
        (&in_itself as &dyn Fn(&mut File) -> u64, "refers to itself"),
        (&deep, "deeper than 16"),
        (&long, "characters"),
        (&brackets, "characters"),
    ] {
        let log = converted(make).unwrap_or_else(|error| panic!("{why}: {error}"));
        assert_eq!(values(&log, "u"), [7.0; 4]);
        assert!(log.left_out()[0].why.contains(why), "{:?}", log.left_out());
    }
    assert!(begin.elapsed() < Duration::from_secs(5), "{:?}", begin.elapsed());
}

#[test]
fn packed_and_transposed_blocks_in_lists() {
    let data = records(1000, |row| (row as f32).to_le_bytes().to_vec());
    let channels = [time(), Channel { data_type: 4, ..channel("u", 8, 32) }];
    for size in [0, 12] {
        let mut file = File::new();
        // A cut within a record, and a last block that is not packed.
        let pieces = [file.packed(&data[..6001], size), file.packed(&data[6001..9000], size)];
        let rest = file.block(b"DT", &[], &data[9000..]);
        let second = file.block(b"DL", &[0, rest], &[0; 8]);
        let first = file.block(b"DL", &[second, pieces[0], pieces[1]], &[0; 8]);
        let list = file.block(b"HL", &[first], &[0; 8]);
        file.group("", &channels, 12, 1000, list);
        let log = read(&file).unwrap_or_else(|error| panic!("{error}"));
        let expected: Vec<f64> = (0..1000).map(f64::from).collect();
        assert_eq!(values(&log, "u"), expected, "transposed by {size}");
        assert!((log.time()[999] - 9.99).abs() < 1e-12);
    }
}

#[test]
fn bits_arrays_and_structures() {
    let mut file = File::new();
    let array = file.array(&[2, 2], 2);
    let inner =
        [channel("low", 16, 4), Channel { shift: 4, data_type: 2, ..channel("high", 16, 4) }];
    let composition = file.channels(&inner);
    let data = file.block(
        b"DT",
        &[],
        &records(2, |row| {
            let row = row as u8;
            vec![1, row, 2, row, 3, row, 4, row, 0xf0 | (row + 5)]
        }),
    );
    let channels = [
        time(),
        Channel { composition: array, data_type: 1, ..channel("map", 8, 16) },
        Channel { composition, data_type: 10, ..channel("status", 16, 8) },
        Channel { kind: 1, ..channel("text", 8, 64) },
    ];
    file.group("", &channels, 17, 2, data);
    let log = read(&file).unwrap_or_else(|error| panic!("{error}"));
    let names: Vec<&str> = log.columns().iter().map(|column| column.name.as_str()).collect();
    assert_eq!(
        names,
        ["map[1,1]", "map[1,2]", "map[2,1]", "map[2,2]", "status.low", "status.high"]
    );
    assert_eq!(values(&log, "map[2,1]"), [768.0, 769.0]);
    assert_eq!(values(&log, "status.low"), [5.0, 6.0]);
    assert_eq!(values(&log, "status.high"), [-1.0, -1.0]);
    assert_eq!(log.left_out()[0].name, "text");
}

/// Records of several groups in one stretch, each behind its number; one group of texts between them.
#[test]
fn records_of_several_groups_are_distinguished() {
    let mut file = File::new();
    let mut data = Vec::new();
    for row in 0..3_u32 {
        data.push(1);
        data.extend(records(row + 1, |_| vec![9])[9 * row as usize..].to_vec());
        data.push(2);
        data.extend([&5_u32.to_le_bytes()[..], b"hello"].concat());
    }
    let data = file.block(b"DT", &[], &data);
    let channels = file.channels(&[time(), channel("u", 8, 8)]);
    let about = |id: u64, flags: u64, size: u32| {
        let about = [id, 3, flags].map(u64::to_le_bytes).concat();
        [&about[..], &size.to_le_bytes(), &[0; 4]].concat()
    };
    let texts = file.block(b"CG", &[0; 6], &about(2, 1, 0));
    let group = file.block(b"CG", &[texts, channels, 0, 0, 0, 0], &about(1, 0, 9));
    let place = file.block(b"DG", &[0, group, data, 0], &[1, 0, 0, 0, 0, 0, 0, 0]);
    file.link(64, 0, place);
    let log = read(&file).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((log.len(), values(&log, "u")), (3, &[9.0; 3][..]));
}

#[test]
fn what_is_cut_off_is_noted() {
    let mut file = File::new();
    file.group("fast", &[time(), channel("u", 8, 8)], 9, 100, 0);
    let data = file.block(b"DT", &[], &records(100, |row| vec![row as u8]));
    let group = u64::from_le_bytes(file.bytes[88..96].try_into().unwrap());
    file.link(group, 2, data);
    file.bytes.truncate(file.bytes.len() - 40);
    let log = read(&file).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(log.len(), 95);
    let notes = log.notes().join("\n");
    assert!(notes.contains("group \"fast\" is cut off: 95 of its 100 rows are there"), "{notes}");
    // A logger that lost its supply writes neither the length nor the number of rows.
    file.bytes[..8].copy_from_slice(b"UnFinMF ");
    let log = read(&file).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(log.len(), 95);
    assert!(log.notes().join("\n").contains("was not finished"));
}

#[test]
fn lists_that_return_to_themselves_end() {
    let mut file = File::new();
    let data = file.block(b"DT", &[], &records(4, |_| vec![1]));
    file.group("", &[time(), channel("u", 8, 8)], 9, 4, data);
    let place = u64::from_le_bytes(file.bytes[88..96].try_into().unwrap());
    file.link(place, 0, place);
    assert!(read(&file).unwrap_err().contains("returns to itself"));
    let list = file.block(b"DL", &[0, data], &[0; 8]);
    file.link(list, 0, list);
    file.link(place, 0, 0);
    file.link(place, 2, list);
    assert!(read(&file).unwrap_err().contains("returns to itself"));
}

/// A small file whose blocks are packed a thousandfold, or named a thousand times, is refused with the limit.
#[test]
fn memory_is_bounded_by_the_size() {
    let mut file = File::new();
    let data = vec![0; 1 << 22];
    let packed = file.packed(&data, 0);
    let list = file.block(b"DL", &[vec![0], vec![packed; 2000]].concat(), &[0; 8]);
    let channels = [time(), channel("u", 8, 8)];
    file.group("", &channels, 16, 2000 << 18, list);
    assert!(file.bytes.len() < 40_000);
    let begin = Instant::now();
    let error = read(&file).unwrap_err();
    assert!(error.contains("more memory than 269 MB") && error.contains("--log-memory"), "{error}");
    let given = ReadOptions { memory: Some(10_000_000), ..ReadOptions::default() };
    let error = read_with(&file.bytes, &given).unwrap_err();
    assert!(error.contains("more memory than 10 MB"), "{error}");
    assert!(begin.elapsed() < Duration::from_secs(20), "{:?}", begin.elapsed());
}

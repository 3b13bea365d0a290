//! Logs in other programs' formats, written by these programs: every number is read by the bit,
//! and what cannot be read is refused with a way out.

use crate::common;

use std::path::Path;
use std::process::Command;

use common::foreign;
use data::{Log, ReadOptions};

fn written() -> Option<tempfile::TempDir> {
    let python = foreign::python()?;
    let folder = tempfile::tempdir().unwrap();
    let script = common::root().join("tests/python/write_logs.py");
    let built = Command::new(python).arg(script).arg(folder.path()).output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    Some(folder)
}

fn read(folder: &Path, name: &str) -> Result<Log, String> {
    Log::read(&folder.join(name), &ReadOptions::default()).map_err(|problems| problems.to_string())
}

#[test]
fn every_format_gives_the_same_numbers() {
    let Some(folder) = written() else { return };
    let reference = read(folder.path(), "reference.csv").unwrap();
    for name in [
        "plain.mat",
        "packed.mat",
        "structure.mat",
        "version4.mat",
        "rows.mat",
        "plain.h5",
        "fields.h5",
        "octave.h5",
        "plain.npz",
        "packed.npz",
        "fields.npy",
        "snappy.parquet",
        "gzip.parquet",
        "zstd.parquet",
        "none.parquet",
        "units.parquet",
        "plain.mf4",
        "packed.mf4",
        "transposed.mf4",
        "plain.tdms",
    ] {
        let log = read(folder.path(), name).unwrap_or_else(|error| panic!("{error}"));
        assert!(log.time() == reference.time(), "{name}: other times");
        for column in reference.columns() {
            let same = log.column(&column.name).unwrap().values == column.values;
            assert!(same, "{name}: {} has other values", column.name);
        }
        let units =
            ["units.parquet", "plain.tdms", "plain.h5"].contains(&name) || name.ends_with(".mf4");
        let unit = |name| log.column(name).unwrap().unit.as_ref().map(|unit| unit.text.as_str());
        assert_eq!(unit("u"), units.then_some("V"), "{name}");
        assert_eq!(unit("y"), units.then_some("um"), "{name}");
    }
}

#[test]
fn what_cannot_be_read_is_refused_with_a_way_out() {
    let Some(folder) = written() else { return };
    for (name, rule, way_out) in [
        ("cells.mat", "log is a cell array", "save plain arrays"),
        ("lengths.mat", "groups with different times: \"1000\" (1000 rows), \"100\"", "--group"),
        ("rates.mf4", "groups with different times", "--group"),
        ("old.mdf", "older MDF", "asammdf"),
        ("gap.parquet", "row 6: y = NaN: is a gap", "leave the row out"),
        ("cut.npy", "bytes are there", "whole"),
        ("transposed.npy", "2 rows and 2000 columns", "transposed"),
        ("tests.tdms", "different times: \"first\" (1000 rows), \"second\"", "--group"),
        ("objects.npy", "no columns of real numbers", "arrays of numbers"),
    ] {
        let error = read(folder.path(), name).expect_err(name);
        assert!(error.contains(rule) && error.contains(way_out), "{name}: {error}");
        assert!(error.contains(name), "{error}");
    }
}

/// Channels of one TDMS group that were sampled at other times are told apart, never paired row by row.
#[test]
fn channels_with_other_times_are_not_paired() {
    let Some(folder) = written() else { return };
    let alike = read(folder.path(), "alike.tdms").unwrap();
    assert_eq!((alike.columns().len(), alike.time()[0]), (2, 0.25));
    for name in ["starts.tdms", "offsets.tdms", "increments.tdms", "lengths.tdms"] {
        let error = read(folder.path(), name).expect_err(name);
        assert!(error.contains("\"run/u\" (1000 rows)"), "{name}: {error}");
        assert!(error.contains("groups with different times"), "{name}: {error}");
        let options = ReadOptions { group: Some("run/y".into()), ..Default::default() };
        let y = Log::read(&folder.path().join(name), &options).unwrap();
        let (start, period) = (y.time()[0], y.time()[1] - y.time()[0]);
        let expected = match name {
            "starts.tdms" => (3.0, 5e-4),
            "offsets.tdms" => (0.05, 5e-4),
            _ => (0.0, 1e-3),
        };
        assert!((start - expected.0).abs() < 1e-9, "{name}: {start}");
        assert!((period - expected.1).abs() < 1e-9, "{name}: {period}");
    }
}

/// Dates and durations are times in s, and whole numbers without a sign keep their values.
#[test]
fn parquet_types_are_read_as_they_are_meant() {
    let Some(folder) = written() else { return };
    let reference = read(folder.path(), "reference.csv").unwrap();
    for name in
        ["dated.parquet", "durations.parquet", "arrow.parquet", "spark.parquet", "dated.npz"]
    {
        let log = read(folder.path(), name).unwrap_or_else(|error| panic!("{error}"));
        assert!(log.time() == reference.time(), "{name}: {:?}", &log.time()[..4]);
    }
    let unsigned = read(folder.path(), "unsigned.parquet").unwrap();
    let first = |name| unsigned.column(name).unwrap().values[0];
    assert_eq!(first("big"), 4_294_967_291.0);
    assert_eq!(first("small"), 250.0);
    assert_eq!(first("huge"), 9_223_372_036_854_775_808.0);
    for name in ["half.parquet", "dated.npz"] {
        let log = read(folder.path(), name).unwrap();
        assert_eq!(log.column("half").unwrap().values[5], 0.5, "{name}");
    }
    // What NumPy's arrays hold beside numbers is left out, and said.
    let log = read(folder.path(), "dated.npz").unwrap();
    let left_out: Vec<_> = log.left_out().iter().map(|column| column.name.as_str()).collect();
    assert_eq!(left_out, ["words"]);
    let (u, z) = (log.column("u").unwrap(), log.column("z.real").unwrap());
    assert_eq!(z.values, u.values);
    assert!(log.column("z.imag").unwrap().values.iter().all(|part| *part == 1.0));
}

/// Complex numbers, as of a frequency response, are two columns.
#[test]
fn complex_numbers_are_two_columns() {
    let Some(folder) = written() else { return };
    let options = ReadOptions { rate: Some(1.0), ..ReadOptions::default() };
    for name in ["complex.mat", "complex4.mat", "complex.npz", "complex.h5"] {
        let log = Log::read(&folder.path().join(name), &options)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let values = |column: &str| {
            log.require(column).unwrap_or_else(|error| panic!("{error}")).values.clone()
        };
        assert_eq!(values("f").len(), 50, "{name}");
        for ((f, re), im) in values("f").iter().zip(values("G.real")).zip(values("G.imag")) {
            let x = f / 40.0;
            let size = 2.0 / (1.0 + x * x);
            assert!((re - size).abs() < 1e-12 && (im + size * x).abs() < 1e-12, "{name}: {f} Hz");
        }
    }
}

/// Nanoseconds since 1970 keep their last digit, and groups that begin at other instants stay apart by as much.
#[test]
fn long_whole_times_keep_their_digits() {
    let Some(folder) = written() else { return };
    for name in ["long.npz", "long.parquet"] {
        let log = read(folder.path(), name).unwrap();
        assert!(log.time().iter().enumerate().all(|(k, t)| *t == k as f64 / 1e6), "{name}");
        let count = &log.column("count").unwrap().values;
        assert_eq!(count[999], 1_700_000_000_000_999_000_u64 as f64, "{name}");
        let notes = log.notes().join("\n");
        assert!(notes.contains("after the first row, at 1700000000000000000 ns"), "{notes}");
    }
    let options = ReadOptions { resample: Some(data::Resample::Fastest), ..Default::default() };
    let reference = read(folder.path(), "reference.csv").unwrap();
    let y = &reference.column("y").unwrap().values;
    for name in ["long_groups.npz", "date_groups.npz"] {
        let log = Log::read(&folder.path().join(name), &options)
            .unwrap_or_else(|problems| panic!("{name}: {problems}"));
        for (at, time) in log.time().iter().enumerate() {
            let row = (time * 1e6).round() as usize;
            if row % 2 == 1 {
                let found = log.column("y").unwrap().values[at];
                assert!((found - y[row]).abs() < 1e-6, "{name}, {time} s: {found}, {}", y[row]);
            }
        }
        assert_eq!(log.len(), 499, "{name}: {:?}", log.time().first());
    }
}

/// The shapes in which Simulink logs, and MATLAB 7.3 with them.
#[test]
fn what_simulink_logs_is_read_by_its_names() {
    let Some(folder) = written() else { return };
    let reference = read(folder.path(), "reference.csv").unwrap();
    let compare = |log: &Log, name: &str, columns: &[(&str, &str)]| {
        assert!(log.time() == reference.time(), "{name}: other times");
        for (own, wanted) in columns {
            let column = log.column(own).unwrap_or_else(|| panic!("{name} has no {own}"));
            assert!(column.values == reference.column(wanted).unwrap().values, "{name}: {own}");
        }
        assert_eq!(log.columns().len(), columns.len(), "{name}");
    };
    let yout = [("yout_1", "u"), ("yout_2", "y"), ("yout_3", "counts")];
    let to_file = yout.map(|(own, wanted)| (own.replace("yout", "ans"), wanted));
    let to_file: Vec<(&str, &str)> =
        to_file.iter().map(|(own, wanted)| (own.as_str(), *wanted)).collect();
    let log = |name| read(folder.path(), name).unwrap_or_else(|error| panic!("{error}"));
    compare(&log("simulink.mat"), "simulink.mat", &yout);
    compare(&log("to_file.mat"), "to_file.mat", &to_file);
    let with_time = [("pos_1", "u"), ("pos_2", "y"), ("counts", "counts")];
    compare(&log("with_time.mat"), "with_time.mat", &with_time);
    let all = [&yout[..], &[("position", "u"), ("force", "y")]].concat();
    for name in ["plain73.mat", "packed73.mat"] {
        compare(&log(name), name, &all);
        assert_eq!(log(name).left_out()[0].name, "note");
    }
}

/// What a file may become in memory has a limit in every format, which is in the message.
#[test]
fn memory_has_a_limit() {
    let Some(folder) = written() else { return };
    let options = |memory| ReadOptions { memory: Some(memory), ..Default::default() };
    for name in [
        "plain.mat",
        "packed.mat",
        "version4.mat",
        "packed73.mat",
        "plain.h5",
        "packed.npz",
        "fields.npy",
        "zstd.parquet",
        "plain.mf4",
        "packed.mf4",
        "plain.tdms",
    ] {
        let path = folder.path().join(name);
        let error = Log::read(&path, &options(10_000)).expect_err(name).to_string();
        assert!(error.contains("more memory than 1 MB"), "{name}: {error}");
        assert!(error.contains("--log-memory"), "{name}: {error}");
        assert!(Log::read(&path, &options(1_000_000)).is_ok(), "{name}");
    }
}

/// Channels that are no numbers leave the others alone.
#[test]
fn words_and_units_that_nobody_knows_spoil_no_log() {
    let Some(folder) = written() else { return };
    let log = read(folder.path(), "words.mf4").unwrap_or_else(|error| panic!("{error}"));
    let names: Vec<&str> = log.columns().iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["u", "y", "counts", "squared"]);
    assert_eq!(log.column("counts").unwrap().values[0], -1399.0);
    assert_eq!(log.column("squared").unwrap().values[0], 489_999.0);
    let mut left_out: Vec<&str> =
        log.left_out().iter().map(|column| column.name.as_str()).collect();
    left_out.sort_unstable();
    assert_eq!(left_out, ["odd", "state", "text"]);
}

#[test]
fn a_group_is_chosen_by_name() {
    let Some(folder) = written() else { return };
    let options = |group: &str| ReadOptions { group: Some(group.into()), ..Default::default() };
    let path = folder.path().join("lengths.mat");
    assert_eq!(Log::read(&path, &options("1000")).unwrap().len(), 1000);
    let error = Log::read(&path, &options("1001")).unwrap_err().to_string();
    assert!(error.contains("its groups are 1000, 100"), "{error}");
}

#[test]
fn tests_in_one_file_of_tdms_keep_their_times() {
    let Some(folder) = written() else { return };
    for (group, start, column) in [("first", 0.0, "y"), ("second", 60.25, "w")] {
        let options = ReadOptions { group: Some(group.into()), ..Default::default() };
        let log = Log::read(&folder.path().join("tests.tdms"), &options).unwrap();
        assert!((log.time()[0] - start).abs() < 1e-9, "{group} begins at {}", log.time()[0]);
        assert!(log.column(column).is_some(), "{group} has no {column}");
    }
}

/// Every prefix and many damaged copies of each file end in a log or an error.
#[test]
fn damaged_files_end_in_an_error() {
    let Some(folder) = written() else { return };
    // Readers of other makes announce their panics; here they are expected.
    let announce = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let names = [
        "packed.mat",
        "packed.npz",
        "fields.npy",
        "zstd.parquet",
        "plain.mf4",
        "plain.tdms",
        "packed.mf4",
        "version4.mat",
        "packed73.mat",
        "plain.h5",
    ];
    let (mut read_anyway, mut refused) = (0, 0);
    for name in names {
        let complete = std::fs::read(folder.path().join(name)).unwrap();
        let damaged = folder.path().join(format!("damaged-{name}"));
        let mut state = 12345_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize
        };
        for round in 0..60 {
            let mut bytes = complete.clone();
            if round % 2 == 0 {
                bytes.truncate(random() % complete.len());
            } else {
                for _ in 0..8 {
                    // The first kilobytes hold the structure.
                    let at = random() % complete.len().min(4096);
                    bytes[at] = random() as u8;
                }
            }
            std::fs::write(&damaged, bytes).unwrap();
            match Log::read(&damaged, &ReadOptions::default()) {
                Ok(_) => read_anyway += 1,
                Err(_) => refused += 1,
            }
        }
    }
    std::panic::set_hook(announce);
    println!("{read_anyway} damaged files were read, {refused} refused");
    assert!(refused > 100);
}

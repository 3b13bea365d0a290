//! What is written is read again, by this program and by others.

use std::fs;
use std::path::Path;

use data::{ColumnHeader, ColumnUnit, Log, LogWriter, ReadOptions, UnitPlace, sidecar_of};
use proptest::prelude::*;

fn log() -> Log {
    let mut log = Log::with_records("log", vec![0.0, 0.1, 0.0], &[(4, 2), (2, 1)]).unwrap();
    log.add_column("position[1]", Some("um"), vec![1.0, -1e-7, 0.1 + 0.2]).unwrap();
    log.add_column("enable", None, vec![1.0, 0.0, 1.0]).unwrap();
    log
}

fn again(path: &Path) -> Log {
    Log::read(path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn the_text_is_plain_and_the_units_stand_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    log().write(&path, UnitPlace::Sidecar).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(
        text,
        "time,record,position[1],enable\n0,4,1,1\n0.1,4,-1e-7,0\n0,2,0.30000000000000004,1\n"
    );
    let sidecar = fs::read_to_string(sidecar_of(&path)).unwrap();
    assert_eq!(
        sidecar,
        "time = { column = \"time\", unit = \"s\" }\n\n[columns]\n\"position[1]\" = { unit = \"um\" }\n"
    );
    let found = again(&path);
    assert_eq!(found.columns(), log().columns());
    assert_eq!((found.time(), found.records()), (log().time(), log().records()));
}

#[test]
fn units_can_stand_in_the_header_or_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    log().write(&path, UnitPlace::Header).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("time,record,position[1] [um],enable\n"), "{text}");
    assert!(!sidecar_of(&path).exists());
    assert_eq!(again(&path).columns(), log().columns());
    log().write(&path, UnitPlace::Nowhere).unwrap();
    assert!(again(&path).columns().iter().all(|column| column.unit.is_none()));
}

#[test]
fn a_log_is_written_row_by_row_and_appears_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    let unit = Some(ColumnUnit::parse("um").unwrap());
    let column = ColumnHeader { name: "y".into(), unit, description: "Of the \"stage\"".into() };
    let columns = [column];
    let mut writer = LogWriter::create(&path, &columns, false, UnitPlace::Sidecar).unwrap();
    writer.row(0, 0.0, &[1.0]).unwrap();
    assert!(writer.row(0, 0.0, &[1.0]).unwrap_err().to_string().contains("row 2: time must be"));
    assert!(writer.row(0, 1.0, &[]).is_err());
    let error = writer.row(0, 1.0, &[f64::NAN]).unwrap_err().to_string();
    assert!(error.contains("y = NaN: row 2: is not a finite number"), "{error}");
    writer.row(0, 1.0, &[2.0]).unwrap();
    assert!(!path.exists() && !sidecar_of(&path).exists());
    writer.finish().unwrap();
    let found = again(&path);
    assert_eq!(found.column("y").unwrap().values, [1.0, 2.0]);
    assert_eq!(found.column("y").unwrap().description, "Of the \"stage\"");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);

    let writer = LogWriter::create(&path, &columns, false, UnitPlace::Sidecar).unwrap();
    drop(writer);
    assert_eq!(again(&path), found);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[cfg(unix)]
#[test]
fn a_pipe_gets_the_log_and_nothing_beside_it() {
    log().write(Path::new("/dev/null"), UnitPlace::Sidecar).unwrap();
    assert!(!Path::new("/dev/null.dataset.toml").exists());
}

#[test]
fn names_that_no_reader_takes_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    for names in [&["a\nb"][..], &["time"], &["record"], &["y", "y"], &[""], &["y [um]"]] {
        let named = |name: &&str| ColumnHeader { name: (*name).into(), ..ColumnHeader::default() };
        let columns: Vec<ColumnHeader> = names.iter().map(named).collect();
        assert!(LogWriter::create(&path, &columns, false, UnitPlace::Sidecar).is_err());
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// fmpy's `read_csv`: it splits lines at commas, strips quotation marks from names, and takes a
/// blank in a cell for an array.
fn as_fmpy_reads(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let names = lines.next().unwrap().split(',').map(|name| name.trim_matches('"').to_string());
    let rows = lines.map(|line| {
        assert!(!line.contains(' '), "{line}");
        line.split(',').map(|cell| cell.parse().unwrap()).collect()
    });
    (names.collect(), rows.collect())
}

proptest! {
    #[test]
    fn values_keep_their_bits(
        rows in prop::collection::vec((1e-9..10.0f64, any::<[f64; 2]>()), 1..50),
        place in prop_oneof![Just(UnitPlace::Sidecar), Just(UnitPlace::Header)],
    ) {
        let mut time = 0.0;
        let times = rows.iter().map(|(step, _)| { time += step; time }).collect();
        let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
        let column = |k: usize| rows.iter().map(|(_, values)| finite(values[k])).collect();
        let mut log = Log::new("log", times).unwrap();
        log.add_column("y", Some("um"), column(0)).unwrap();
        log.add_column("axis[1].w[2]", Some("um/V"), column(1)).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        log.write(&path, place).unwrap();
        let found = again(&path);
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(found.time()), bits(log.time()));
        for (found, wanted) in found.columns().iter().zip(log.columns()) {
            prop_assert_eq!(&found.name, &wanted.name);
            prop_assert_eq!(&found.unit, &wanted.unit);
            prop_assert_eq!(bits(&found.values), bits(&wanted.values));
        }
        if place == UnitPlace::Sidecar {
            let (names, rows) = as_fmpy_reads(&fs::read_to_string(&path).unwrap());
            prop_assert_eq!(names, ["time", "y", "axis[1].w[2]"]);
            for (row, time) in rows.iter().zip(log.time()) {
                prop_assert_eq!(row[0].to_bits(), time.to_bits());
            }
        }
    }

    #[test]
    fn no_bytes_make_the_reader_fall(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = Log::parse(&bytes, "any.csv", &ReadOptions::default());
    }

    #[test]
    fn no_text_makes_the_reader_fall(
        text in "(time|record|y|,|\n|\"|\\[um\\]|1|2|0\\.5|-|nan|;){0,80}",
        rate in prop::option::of(-1.0..100.0f64),
    ) {
        let options = ReadOptions { rate, ..ReadOptions::default() };
        if let Ok(log) = Log::parse(text.as_bytes(), "any.csv", &options) {
            for record in log.records() {
                let _ = log.sample_time(record, 0.01);
            }
        }
    }
}

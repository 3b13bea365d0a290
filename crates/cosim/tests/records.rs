//! Records on disk: others read them, and memory does not grow with the run.
#![allow(clippy::print_stdout)]

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::instance;
use cosim::record::Column;
use cosim::{Diagram, Jacobi, Points, RecordFile, Recorder, Run, Signals};
use counting::Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

fn columns() -> Vec<Column> {
    let column = |name: &str, unit: Option<&str>| Column {
        name: name.to_owned(),
        unit: unit.map(str::to_owned),
    };
    vec![column("position[1]", Some("µm")), column("it's µ", None)]
}

/// Three rows in two records.
fn written(path: &Path) {
    let mut file = RecordFile::create(path).unwrap();
    file.begin(0, &columns(), 2).unwrap();
    file.row(0.0, &[1.5, -2.0]).unwrap();
    file.row(0.1, &[f64::NAN, 1e-300]).unwrap();
    file.end().unwrap();
    file.begin(1, &columns(), 1).unwrap();
    file.row(0.0, &[0.1, f64::INFINITY]).unwrap();
    file.end().unwrap();
    file.finish().unwrap();
}

fn python() -> Option<PathBuf> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2)?;
    let own = || workspace.join("target/python-env/bin/python");
    let python = std::env::var_os("PIEZOLOOP_PYTHON").map_or_else(own, PathBuf::from);
    let found = Command::new(&python).args(["-c", "import numpy"]).output().ok()?;
    found.status.success().then_some(python)
}

// One test, because the allocator counts for the whole process.
#[test]
fn records_are_read_by_others_and_memory_does_not_grow() {
    numpy_reads_both_kinds();
    parquet_reads_back();
    endings_are_checked_and_files_appear_complete();
    memory_does_not_grow_with_the_run();
}

fn numpy_reads_both_kinds() {
    let Some(python) = python() else {
        println!("SKIPPED: no Python with numpy (PIEZOLOOP_PYTHON not set)");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let (npy, npz) = (folder.path().join("run.npy"), folder.path().join("run.npz"));
    written(&npy);
    written(&npz);
    let script = r#"
import sys, numpy as np
rows, columns = np.load(sys.argv[1]), np.load(sys.argv[2])
names = ("time", "record", "position[1]", "it's µ")
assert rows.dtype.names == names, rows.dtype.names
assert tuple(columns.files) == names, columns.files
expected = dict(zip(names, ([0, 0.1, 0], [0, 0, 1], [1.5, np.nan, 0.1], [-2, 1e-300, np.inf])))
for name in names:
    np.testing.assert_array_equal(rows[name], expected[name])
    np.testing.assert_array_equal(columns[name], expected[name])
    assert columns[name].dtype == np.dtype("<f8")
"#;
    let output = Command::new(python).args(["-c", script]).args([npy, npz]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[cfg(feature = "parquet")]
fn parquet_reads_back() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.parquet");
    written(&path);
    let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
    let metadata = reader.metadata().file_metadata();
    assert_eq!(metadata.num_rows(), 3);
    let units = metadata.key_value_metadata().unwrap();
    let unit = units.iter().find(|pair| pair.key == "unit:position[1]").unwrap();
    assert_eq!(unit.value.as_deref(), Some("µm"));
    let rows: Vec<Vec<f64>> = reader
        .get_row_iter(None)
        .unwrap()
        .map(|row| row.unwrap())
        .map(|row| (0..row.len()).map(|column| row.get_double(column).unwrap()).collect())
        .collect();
    assert_eq!(rows[0], [0.0, 0.0, 1.5, -2.0]);
    assert_eq!(rows[2], [0.0, 1.0, 0.1, f64::INFINITY]);
    let names = metadata.schema_descr().columns().iter().map(|c| c.name().to_owned());
    assert_eq!(names.collect::<Vec<_>>(), ["time", "record", "position[1]", "it's µ"]);
}

#[cfg(not(feature = "parquet"))]
fn parquet_reads_back() {
    println!("SKIPPED: built without the feature parquet");
}

fn endings_are_checked_and_files_appear_complete() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = RecordFile::create(&folder.path().join("run.mat")).err().unwrap().to_string();
    assert!(wrong.contains("run.mat: records are written as .csv, .npy, .npz"), "{wrong}");
    for ending in ["csv", "npy", "npz", "parquet"] {
        let Ok(mut file) = RecordFile::create(&folder.path().join("run").with_extension(ending))
        else {
            continue;
        };
        file.begin(0, &columns(), 1).unwrap();
        file.row(0.0, &[1.0, 2.0]).unwrap();
        drop(file);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{ending}");
    }
}

/// Heap at its highest during a run of so many steps, beyond what was taken before.
fn most_of_a_run(fmus: &common::Fmus, ending: &str, steps: usize) -> usize {
    let path = fmus.path(&format!("run.{ending}"));
    let mut diagram = Diagram::new();
    diagram.add(instance(&fmus.integrator(), "p")).record(("p", "position[1]"));
    let mut system = diagram.build().unwrap();
    let signals = Signals::new(&[0.0]);
    let points = Points::uniform(0.0, steps as f64 * 1e-3, 1e-3).unwrap();
    let run = Run::new(points, &signals);
    let mut file = RecordFile::create(&path).unwrap();
    let before = counting::reset_peak();
    system.run(&run, &Jacobi, &mut file).unwrap();
    file.finish().unwrap();
    assert!(std::fs::metadata(&path).unwrap().len() > 8 * steps as u64);
    counting::peak() - before
}

fn memory_does_not_grow_with_the_run() {
    let Some(fmus) = common::Fmus::new() else {
        println!("SKIPPED: no C compiler `cc`");
        return;
    };
    for ending in ["csv", "npy", "npz", "parquet"] {
        if ending == "parquet" && !cfg!(feature = "parquet") {
            continue;
        }
        // Parquet keeps one group of rows, so both runs have several.
        let (short, long) =
            (most_of_a_run(&fmus, ending, 200_000), most_of_a_run(&fmus, ending, 2_000_000));
        println!("{ending}: {short} bytes for 0.2, {long} bytes for 2 million steps");
        // The footer of Parquet has an entry per group of 65536 rows.
        let footer = if ending == "parquet" { 2_000_000 / 65_536 * 4096 } else { 4096 };
        assert!(long <= short + footer, "{ending}: {short} and {long} bytes");
        assert!(long < 8 << 20, "{ending}: {long} bytes");
    }
}

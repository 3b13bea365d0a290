//! fmi-rs, an importer and validator in Rust by the author of FMPy: it finds no fault with our FMUs,
//! and they give there what they give here, from a serialised state, too.
#![cfg(target_os = "linux")]

use crate::common;

use common::packed::{CONTROLLER, PLANT};
use common::{foreign, json, root, succeed};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const STAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/stage.toml");

/// fmi-rs wants the duration to be a multiple of the step to the last bit.
const STEP: f64 = 1.0 / 8192.0;
const STEPS: u32 = 600;

/// The importer of `tests/fmi-rs`, or `None` with a line that says why the tests are skipped.
fn importer() -> Option<&'static Path> {
    static BUILT: OnceLock<Option<PathBuf>> = OnceLock::new();
    BUILT.get_or_init(build).as_deref()
}

fn build() -> Option<PathBuf> {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent()?.join("fmi-rs");
    fs::create_dir_all(&target).expect("the target folder is writable");
    let lock = File::create(target.join("lock")).expect("the target folder is writable");
    lock.lock().expect("a lock on the folder");
    let cargo = |command: &str| {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args([command, "--quiet", "--locked"]).current_dir(root().join("tests/fmi-rs"));
        for inherited in ["RUSTC_WRAPPER", "RUSTC_WORKSPACE_WRAPPER", "CARGO_BUILD_TARGET_DIR"] {
            cargo.env_remove(inherited);
        }
        cargo.env("CARGO_TARGET_DIR", &target).output().expect("cargo starts")
    };
    let fetched = cargo("fetch");
    if !fetched.status.success() {
        let errors = String::from_utf8_lossy(&fetched.stderr);
        println!("SKIPPED: fmi-rs cannot be had: {}", errors.lines().last().unwrap_or_default());
        return None;
    }
    let built = cargo("build");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    Some(target.join("debug/fmi-rs-importer"))
}

/// Runs the importer; it must succeed. Returns all it printed.
fn message(importer: &Path, arguments: &[&str], folder: &Path) -> String {
    foreign::message(Command::new(importer).args(arguments), folder)
}

#[test]
fn fmi_rs_finds_nothing_wrong_with_our_fmus() {
    let Some(importer) = importer() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    for blueprint in [PLANT, CONTROLLER, STAGE] {
        for version in ["2", "3"] {
            let file = format!("{version}.fmu");
            succeed(&["pack", blueprint, "--fmi", version, "-o", &file], folder.path());
            assert_eq!(message(importer, &["check", &file], folder.path()), "", "{blueprint}");
        }
    }
    // It does find what is wrong with others.
    let xml = modeldescription::Package::open(folder.path().join("2.fmu")).expect("an FMU");
    let bad = folder.path().join("bad.fmu");
    spoil(xml.folder(), &bad);
    assert_ne!(message(importer, &["check", "bad.fmu"], folder.path()), "");
}

/// Writes an FMU in which an output is missing from the model structure.
fn spoil(unpacked: &Path, to: &Path) {
    let text = fs::read_to_string(unpacked.join("modelDescription.xml")).expect("an XML");
    let from = text.find("<Outputs>").expect("outputs") + "<Outputs>".len();
    let end = from + text[from..].find("/>").expect("an output") + 2;
    let python = common::python::python();
    let folder = to.parent().expect("a folder");
    fs::write(folder.join("bad.xml"), text[..from].to_owned() + &text[end..]).expect("written");
    let code =
        "import zipfile; zipfile.ZipFile('bad.fmu', 'w').write('bad.xml', 'modelDescription.xml')";
    foreign::message(Command::new(python).args(["-c", code]), folder);
}

/// The inputs of the plant as a log for our tool and as fmi-rs reads them: scalars in FMI 2.0,
/// the elements of an array in FMI 3.0.
fn write_inputs(folder: &Path) {
    let mut log = String::from("time,\"command[1]\",\"command[2]\"\n");
    let mut array = String::from("time,command\n");
    for k in 0..=STEPS {
        let t = f64::from(k) * STEP;
        let values = [60.0 - 50.0 * (44.0 * t).cos(), 50.0 + 30.0 * (131.0 * t).sin()];
        log += &format!("{t},{},{}\n", values[0], values[1]);
        array += &format!("{t},{} {}\n", values[0], values[1]);
    }
    fs::write(folder.join("log.csv"), &log).expect("the folder is writable");
    fs::write(folder.join("input2.csv"), &log).expect("the folder is writable");
    fs::write(folder.join("input3.csv"), array).expect("the folder is writable");
}

/// Rows of numbers of a CSV, arrays flattened.
fn rows(file: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(file).expect("a CSV");
    let number = |word: &str| word.parse().unwrap_or_else(|e| panic!("{word}: {e}"));
    text.lines().skip(1).map(|line| line.split([',', ' ']).map(number).collect()).collect()
}

#[test]
fn a_run_in_fmi_rs_is_our_run_bit_by_bit_and_goes_on_from_a_serialised_state() {
    let Some(importer) = importer() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    write_inputs(folder.path());
    for version in ["2", "3"] {
        succeed(&["pack", PLANT, "--fmi", version, "-o", "plant.fmu"], folder.path());
        let outputs = ["--log", "log.csv", "-o", "run.csv"];
        json(&[&["simulate", "plant.fmu"], &outputs[..]].concat(), folder.path());
        let ours = rows(&folder.path().join("run.csv"));
        let input = format!("input{version}.csv");
        let (half, complete) = (f64::from(STEPS / 2) * STEP, f64::from(STEPS) * STEP);
        let simulate = |output: &str, start: f64, stop: f64, states: &[&str]| {
            let time = [start, stop, STEP].map(|t| t.to_string());
            let first = ["simulate", "plant.fmu", &input, output, "log.txt"];
            let second = [time[0].as_str(), &time[1], &time[2]];
            let all = [&first[..], &second[..], states].concat();
            assert_eq!(message(importer, &all, folder.path()), "");
            let log = fs::read_to_string(folder.path().join("log.txt")).expect("a log");
            for line in log.lines() {
                assert!(line.starts_with("[INFO]"), "{log}");
            }
            rows(&folder.path().join(output))
        };
        let theirs = simulate("whole.csv", 0.0, complete, &[]);
        assert_eq!(theirs.len(), STEPS as usize + 1);
        let width = theirs[0].len();
        assert!(width == 3 && ours[0].len() >= width, "{:?}", theirs[0]);
        let positions = positions(&folder.path().join("run.csv"));
        for (k, row) in theirs.iter().enumerate() {
            let wanted: Vec<f64> = positions.iter().map(|column| ours[k][*column]).collect();
            assert_eq!(row[1..], wanted[..], "FMI {version}, row {k}");
        }
        let first = simulate("first.csv", 0.0, half, &["save=state.bin"]);
        let second = simulate("second.csv", half, complete, &["load=state.bin"]);
        assert_eq!(first[..], theirs[..=STEPS as usize / 2], "FMI {version}");
        assert_eq!(second[..], theirs[STEPS as usize / 2..], "FMI {version}: from the state");
        println!("fmi-rs, FMI {version}: {} rows, the same bits", theirs.len());
    }
}

/// The columns of position[1] and position[2] in our record.
fn positions(file: &Path) -> Vec<usize> {
    let text = fs::read_to_string(file).expect("a CSV");
    let header: Vec<&str> = text.lines().next().expect("a header").split(',').collect();
    let at = |name: &str| header.iter().position(|word| word.trim_matches('"').starts_with(name));
    ["position[1]", "position[2]"].map(|name| at(name).expect("a column")).to_vec()
}

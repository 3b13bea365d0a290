//! Example 03 in other tools: its parameter sets in fmpy.ssp and ecos; the examples' notebooks.
#![cfg(unix)]

use crate::common;

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use common::{foreign, refuse, root, succeed};

const README: &str = include_str!("../examples/03_system/README.md");
const NOTEBOOK: &str = include_str!("../examples/03_system/loop.ipynb");

/// Copies files of the example.
fn copied(files: &[&str], folder: &Path) {
    for file in files {
        let source = root().join("examples/03_system").join(file);
        fs::copy(source, folder.join(file)).expect("the folder is writable");
    }
}

/// The system with both parameter sets, side by side, from rest at 0.
fn prepared(folder: &Path) {
    copied(&["loop.toml", "nominal.ssv", "repaired.ssv"], folder);
    succeed(&["pack", "evc", "--all-effects", "-o", "plant.fmu"], folder);
    succeed(&["invert", "evc", "-o", "controller.toml"], folder);
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], folder);
    succeed(&["system", "loop.toml", "--export", "loop.ssp"], folder);
    let mut text = String::from("time,reference[1],reference[2]\n");
    for k in 0..2001 {
        let t = f64::from(k) * 20e-6;
        let wave = 1.0 - (2.0 * std::f64::consts::PI * 50.0 * t).cos();
        text += &format!("{t},{wave},{}\n", 1.5 * wave);
    }
    fs::write(folder.join("short.csv"), text).expect("the folder is writable");
    for set in ["nominal", "repaired"] {
        let [ssv, run] = ["ssv", "csv"].map(|ending| format!("{set}.{ending}"));
        let system = ["system", "loop.ssp", "--input", "short.csv", "--algorithm", "jacobi"];
        succeed(&[&system[..], &["--parameters", &ssv, "-o", &run]].concat(), folder);
    }
}

#[test]
fn the_parameter_sets_run_in_fmpy_ssp_and_ecos_as_in_our_master() {
    let folder = tempfile::tempdir().expect("a folder");
    prepared(folder.path());
    let python = common::python::python();
    print!("{}", foreign::script(&python, "ssp_sets.py", &["fmpy.ssp"], folder.path()));
    let Some(python) = foreign::python() else { return };
    let loads = Command::new(python).args(["-c", "import ecospy"]).output().expect("it starts");
    if !loads.status.success() {
        println!("SKIPPED: ecospy does not load: it needs libtbb12");
        return;
    }
    print!("{}", foreign::script(python, "ssp_sets.py", &["ecos"], folder.path()));
}

#[test]
fn a_set_is_the_start_values_of_a_toml_and_goes_into_an_exported_ssp() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    let text = fs::read_to_string(folder.join("loop.toml")).expect("the system");
    let start = "axis[1].mechanics.frequency\" = 441.0, \"axis[1].mechanics.damping\" = 0.014, \
                 \"axis[1].delay.enabled\" = true, \"axis[1].delay.delay\" = 2e-4";
    let start = format!("\"{start}, \"{}", start.replace("[1]", "[2]").replace("441", "268"));
    let plant = format!("plant = {{ file = \"plant.fmu\", start = {{ {start} }} }}");
    fs::write(folder.join("by_hand.toml"), text.replace("plant = \"plant.fmu\"", &plant))
        .expect("the folder is writable");
    let with = ["--input", "short.csv", "--algorithm", "jacobi", "-o"];
    succeed(&[&["system", "by_hand.toml"], &with[..], &["by_hand.csv"]].concat(), folder);
    let export = ["--parameters", "repaired.ssv", "--export", "repaired.ssp"];
    succeed(&[&["system", "loop.toml"], &export[..]].concat(), folder);
    succeed(&[&["system", "repaired.ssp"], &with[..], &["exported.csv"]].concat(), folder);
    let bytes = |name: &str| fs::read(folder.join(name)).expect("a run");
    assert!(bytes("repaired.csv") == bytes("by_hand.csv"));
    assert!(bytes("repaired.csv") == bytes("exported.csv"));
    assert!(bytes("repaired.csv") != bytes("nominal.csv"));
}

#[test]
fn a_set_that_does_not_fit_is_refused_with_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    let text = fs::read_to_string(folder.join("repaired.ssv")).expect("the set");
    for (old, new, words) in [
        ("plant.axis[1].delay.delay", "stage.axis[1].delay.delay", "bad.ssv: line 8: parameter"),
        ("plant.axis[1].delay.delay", "plant.axis[1].delay.dela", "axis[1].delay.dela"),
        ("value=\"0.0002\"", "value=\"soon\"", "bad.ssv:8"),
    ] {
        fs::write(folder.join("bad.ssv"), text.replace(old, new)).expect("writable");
        let table = ["system", "loop.ssp", "--input", "short.csv", "--parameters", "bad.ssv"];
        let message = refuse(&table, folder);
        assert!(message.contains(words), "{message}");
    }
    let message = refuse(&["system", "loop.ssp", "--parameters", "none.ssv"], folder);
    assert!(message.contains("none.ssv: cannot be read"), "{message}");
}

/// Two kernels that start at once may choose the same ports, and one of them dies.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Runs the last of these files of an example, a notebook; what its cells print, or nothing where
/// notebooks cannot be run.
fn notebook(example: &str, files: &[&str]) -> Option<String> {
    let python = foreign::environment("notebook")?;
    let folder = tempfile::tempdir().expect("a folder");
    for file in files {
        let source = root().join("examples").join(example).join(file);
        fs::copy(source, folder.path().join(file)).expect("the folder is writable");
    }
    let tools = Path::new(env!("CARGO_BIN_EXE_piezoloop")).parent().expect("a folder").to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::iter::once(tools).chain(std::env::split_paths(&path));
    let mut run = Command::new(python);
    run.arg(root().join("tests/python/run_notebook.py")).arg(files.last()?);
    run.env("PATH", std::env::join_paths(paths).expect("a PATH"));
    run.env("PYTHONPATH", root().join("python"));
    let _turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    Some(foreign::message(&mut run, folder.path()))
}

#[test]
fn the_notebook_of_the_hysteresis_runs() {
    let Some(message) = notebook("02_fmu_in_fmpy", &["hysteresis.ipynb"]) else { return };
    println!("{message}");
    assert!(message.contains("nominal: 5.96") && message.contains("with creep: 6.0"), "{message}");
    assert!(message.contains("1 pictures"), "{message}");
}

/// Arrays go into the diagnosis; the repaired FMU leaves the noise, 1 nm, in fmpy.
#[test]
fn the_notebook_goes_from_a_log_to_a_repaired_fmu() {
    let Some(message) = notebook("04_gap", &["gap.ipynb"]) else { return };
    println!("{message}");
    assert!(message.contains("effects [('delay'"), "{message}");
    assert!(message.contains("repaired in fmpy: 0.0010 um"), "{message}");
    assert!(message.contains("1 pictures"), "{message}");
}

#[test]
fn the_notebook_runs_and_its_ten_lines_stand_in_the_readme() {
    let parsed: serde_json::Value = serde_json::from_str(NOTEBOOK).expect("a notebook is JSON");
    let cells = parsed["cells"].as_array().expect("cells").iter();
    let sources = cells.map(|cell| match &cell["source"] {
        serde_json::Value::Array(lines) => {
            lines.iter().map(|line| line.as_str().unwrap_or("")).collect::<String>()
        }
        text => text.as_str().unwrap_or("").to_owned(),
    });
    let ten = sources.filter(|source| source.contains("plant.doStep")).collect::<Vec<_>>();
    assert_eq!(ten.len(), 1);
    assert_eq!(ten[0].lines().count(), 10);
    assert!(README.contains(&format!("```python\n{}\n```", ten[0])), "the README differs");
    let files = ["loop.toml", "nominal.ssv", "repaired.ssv", "loop.ipynb"];
    let Some(message) = notebook("03_system", &files) else { return };
    println!("{message}");
    assert!(message.contains("nominal: ") && message.contains("repaired: "), "{message}");
    assert!(message.contains("1 pictures"), "{message}");
}

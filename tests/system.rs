//! `piezoloop system`: the example's figures, and what is refused.
#![allow(clippy::print_stdout)]

mod common;

use std::fs;
use std::path::Path;

use common::{json, piezoloop, refuse, succeed};

/// Largest distance of position and reference on an axis, in the second half.
fn largest_error(run: &Path, axis: usize) -> f64 {
    let text = fs::read_to_string(run).expect("a run");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let place =
        |name: &str| names.iter().position(|n| *n == format!("{name}[{axis}]")).expect(name);
    let (reference, position) = (place("reference"), place("position"));
    let rows: Vec<Vec<f64>> =
        lines.map(|l| l.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
    let errors = rows[rows.len() / 2..].iter().map(|row| (row[position] - row[reference]).abs());
    errors.fold(0.0, f64::max)
}

/// Copies the example's files and packs its FMUs.
fn prepared(folder: &Path) {
    for file in ["loop.toml", "reference.csv"] {
        let source = common::root().join("examples/03_system").join(file);
        fs::copy(source, folder.join(file)).expect("the folder is writable");
    }
    succeed(&["pack", "evc", "-o", "plant.fmu"], folder);
    succeed(&["invert", "evc", "-o", "controller.toml"], folder);
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], folder);
}

#[test]
fn toml_ssp_and_separate_processes_give_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    let input = ["--input", "reference.csv", "-o"];
    let run = |file: &str, out: &str, more: &[&str]| {
        let mut all = vec!["system", file];
        all.extend(input);
        all.push(out);
        all.extend(more);
        json(&all, folder)
    };
    let answer = run("loop.toml", "run.csv", &[]);
    assert_eq!(answer["rows"], 25_001);
    assert_eq!(answer["step_s"], 2e-5);
    succeed(&["system", "loop.toml", "--export", "loop.ssp"], folder);
    run("loop.ssp", "ssp.csv", &[]);
    let bytes = |name: &str| fs::read(folder.join(name)).expect("a run");
    assert!(bytes("run.csv") == bytes("ssp.csv"), "the SSP is the TOML");
    if cfg!(unix) {
        run("loop.ssp", "isolated.csv", &["--isolate"]);
        assert!(bytes("run.csv") == bytes("isolated.csv"), "processes change no bit");
    }
    // The loop of two that `simulate` closes is this system.
    let loop_of_two = ["simulate", "--loop", "plant.fmu", "controller.fmu", "--reference"];
    succeed(&[&loop_of_two[..], &["reference.csv", "-o", "two.csv"]].concat(), folder);
    for axis in [1, 2] {
        let error = largest_error(&folder.join("run.csv"), axis);
        println!("axis {axis}: largest error {error} um");
        assert_eq!(error, largest_error(&folder.join("two.csv"), axis));
        let stated = [0.055, 0.091][axis - 1];
        assert!((error - stated).abs() < 0.001, "{error}");
    }
}

#[test]
fn what_cannot_be_run_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    let said = refuse(&["system", "loop.toml"], folder);
    assert!(said.contains("has the inputs reference[1], reference[2]"), "{said}");
    let table = ["system", "loop.toml", "--input", "reference.csv"];
    let said = refuse(&[&table[..], &["-o", "run.mat"]].concat(), folder);
    assert!(said.contains("run.mat: records are written as .csv, .npy, .npz"), "{said}");
    let said = refuse(&[&table[..], &["-o", "reference.csv"]].concat(), folder);
    assert!(said.contains("reference.csv is also read"), "{said}");
    let text = fs::read_to_string(folder.join("loop.toml")).expect("the loop");
    fs::write(folder.join("loop.toml"), text.replace("plant.position[2]", "plant.positon[2]"))
        .expect("writable");
    let said = refuse(&table, folder);
    assert!(said.contains("did you mean `position[2]` or"), "{said}");
    fs::write(folder.join("bad.ssp"), b"no archive").expect("writable");
    assert!(refuse(&["system", "bad.ssp"], folder).contains("no readable zip archive"));
    let help = piezoloop(&["system", "--help"], folder);
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    assert!(help.contains("[connections]") && !help.contains("fmu-worker"), "{help}");
}

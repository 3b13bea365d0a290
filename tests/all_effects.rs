//! `pack --all-effects` through the FMU: switched off, all effects of the library are absent to the
//! bit; a start value brings one in.

use std::path::Path;
use std::process::Command;

/// Runs the tool and returns what it printed.
fn piezoloop(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_piezoloop"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the tool runs");
    let (out, err) = (&output.stdout, &output.stderr);
    let (out, err) = (String::from_utf8_lossy(out), String::from_utf8_lossy(err));
    assert!(output.status.success(), "{arguments:?}\n{out}{err}");
    out.into_owned()
}

/// The texts of both positions of a run, row by row.
fn positions(file: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(file).expect("a run");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let column = |name: &str| names.iter().position(|n| *n == name).expect(name);
    let wanted = [column("position[1]"), column("position[2]")];
    let cells = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        wanted.iter().map(|at| cells[*at].to_owned()).collect()
    };
    lines.map(cells).collect()
}

#[test]
fn all_effects_switched_off_change_no_bit_and_one_start_value_brings_one_in() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let signal = ["signal", "p4-loop-10hz", "--rename", "u=command[1]", "-o", "u.csv"];
    piezoloop(at, &signal);
    piezoloop(at, &["pack", "evc-truth", "-o", "plain.fmu"]);
    piezoloop(at, &["pack", "evc-truth", "--all-effects", "-o", "all.fmu"]);
    piezoloop(at, &["simulate", "plain.fmu", "--log", "u.csv", "-o", "plain.csv"]);
    piezoloop(at, &["simulate", "all.fmu", "--log", "u.csv", "-o", "all.csv"]);
    let on = "axis[1].backlash.enabled=true";
    piezoloop(at, &["simulate", "all.fmu", "--log", "u.csv", "--start", on, "-o", "on.csv"]);
    let [plain, all, on] = ["plain.csv", "all.csv", "on.csv"].map(|name| positions(&at.join(name)));
    assert!(plain.len() > 1000);
    assert_eq!(plain, all);
    assert_ne!(plain, on);
    let second = |rows: &[Vec<String>]| rows.iter().map(|row| row[1].clone()).collect::<Vec<_>>();
    assert_eq!(second(&plain), second(&on));
}

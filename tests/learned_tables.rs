//! Learned tables travel with the FMU: beside the blueprint, in its resources, and run there.

use crate::common;

use std::fs;
use std::path::Path;

use common::{refuse, succeed};
use model::Table;

const PLANT: &str = r#"piezoloop = 1
kind = "plant"
name = "learned"
step = 0.005

[[axis]]
name = "x"
command = { name = "u", unit = "V", min = 0, max = 150, start = 0 }
position = { name = "y", unit = "um" }

[[axis.component]]
type = "lssvm-narx"
table = "hysteresis.npy"
sample_time = 0.005
past_inputs = 1
past_outputs = 1
command_high = 150
position_low = -20
position_high = 80
"#;

/// Bias and widths, then weight and centre of each support vector: over u(t), u(t−1), y(t−1).
const ROWS: [[f64; 4]; 3] = [[0.1, 1.0, 1.5, 2.0], [0.9, 1.0, 0.9, 0.8], [-0.3, 0.1, 0.2, 0.1]];

fn table(rows: &[f64], columns: usize) -> Vec<u8> {
    data::npy_of(&Table::new(columns, rows.to_vec()).expect("rows"))
}

/// The scaled model.
fn model(z: [f64; 3]) -> f64 {
    let kernel = |row: &[f64; 4]| {
        let squares = (0..3).map(|k| ((row[k + 1] - z[k]) / ROWS[0][k + 1]).powi(2));
        row[0] * (-squares.sum::<f64>()).exp()
    };
    ROWS[0][0] + ROWS[1..].iter().map(kernel).sum::<f64>()
}

/// A column of a log.
fn column(file: &Path, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(file).expect("a log");
    let mut lines = text.lines();
    let at = lines.next().and_then(|head| head.split(',').position(|n| n == name)).expect(name);
    let cell = |line: &str| line.split(',').nth(at).and_then(|c| c.parse().ok()).expect("a number");
    lines.map(cell).collect()
}

#[test]
fn a_packed_plant_runs_its_table_in_either_version_of_the_standard() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("plant.toml"), PLANT).expect("a file");
    fs::write(at.join("hysteresis.npy"), table(ROWS.as_flattened(), 4)).expect("a file");
    succeed(&["signal", "p0-train-h", "--rename", "u=command[1]", "-o", "u.csv"], at);
    let u: Vec<f64> = column(&at.join("u.csv"), "command[1]").iter().map(|u| u / 150.0).collect();
    for version in ["2", "3"] {
        succeed(&["pack", "plant.toml", "--fmi", version, "-o", "plant.fmu"], at);
        succeed(&["simulate", "plant.fmu", "--log", "u.csv", "-o", "run.csv"], at);
        let y = column(&at.join("run.csv"), "position[1]");
        let scaled = |y: f64| (y + 20.0) / 100.0;
        let (mut before, mut last) = (u[0], scaled(y[0]));
        assert!((model([before, before, last]) - last).abs() < 1e-9, "no rest: {last}");
        for k in 1..y.len() {
            let now = model([u[k - 1], before, last]);
            assert!((scaled(y[k]) - now).abs() < 1e-9, "FMI {version}, row {k}: {}", y[k]);
            (before, last) = (u[k - 1], now);
        }
    }
}

#[test]
fn a_packed_controller_runs_a_learned_inverse() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let controller = PLANT
        .replace("kind = \"plant\"", "kind = \"controller\"")
        .replace(
            "command = { name = \"u\", unit = \"V\", min = 0, max = 150, start = 0 }",
            "command = { unit = \"V\" }",
        )
        .replace("position = { name = \"y\", unit = \"um\" }", "position = { unit = \"um\" }")
        .replace("\"lssvm-narx\"", "\"gp-inverse\"")
        .replace("past_inputs = 1\npast_outputs = 1\n", "inputs = 2\nhalf = 0\n");
    fs::write(at.join("controller.toml"), controller).expect("a file");
    // The command is a bump of the position, whatever its rate.
    let rows = [0.2, 1.0, 1e6, 0.5, 0.4, 0.0];
    fs::write(at.join("hysteresis.npy"), table(&rows, 3)).expect("a file");
    fs::write(at.join("r.csv"), "time [s],reference[1] [um]\n0,0\n0.005,20\n0.01,60\n0.015,60\n")
        .expect("a file");
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], at);
    succeed(&["simulate", "controller.fmu", "--log", "r.csv", "-o", "run.csv"], at);
    let command = column(&at.join("run.csv"), "command[1]");
    let wanted = |r: f64| {
        let x = (r + 20.0) / 100.0;
        150.0 * (0.2 + 0.5 * (-(x - 0.4) * (x - 0.4)).exp())
    };
    for (k, r) in [(1, 0.0), (2, 20.0), (3, 60.0)] {
        assert!((command[k] - wanted(r)).abs() < 1e-6, "{command:?}");
    }
}

#[test]
fn tables_that_are_missing_or_do_not_fit_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let pack = ["pack", "plant.toml", "-o", "plant.fmu"];
    fs::write(at.join("plant.toml"), PLANT).expect("a file");
    let message = refuse(&pack, at);
    assert!(message.contains("hysteresis.npy") && message.contains("plant.toml"), "{message}");
    fs::write(at.join("hysteresis.npy"), table(&[0.1, 1.0, 1.0, 0.5, 0.2, 0.3], 3))
        .expect("a file");
    let message = refuse(&pack, at);
    assert!(message.contains("3 numbers") || message.contains("rows of 3"), "{message}");
    fs::write(at.join("plant.toml"), PLANT.replace("table = \"hysteresis.npy\"\n", ""))
        .expect("a file");
    let message = refuse(&pack, at);
    assert!(message.contains("table") && message.contains("is missing"), "{message}");
    fs::write(at.join("plant.toml"), PLANT.replace("hysteresis.npy", "../hysteresis.npy"))
        .expect("a file");
    assert!(refuse(&pack, at).contains("is no plain file name"));
}

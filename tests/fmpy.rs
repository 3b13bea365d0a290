//! The verdict of fmpy: our FMUs are valid, and give in fmpy what they give here.

use crate::common;

use common::{json, python, succeed};
use std::fs;
use std::path::Path;

/// Packs rig evc and its controller.
fn pack_loop(folder: &Path) {
    succeed(&["pack", "evc", "-o", "plant.fmu"], folder);
    succeed(&["invert", "evc", "-o", "controller.toml"], folder);
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], folder);
}

/// A log of two commands on a 0.1 ms grid: sums of sines that reach every play.
fn write_commands(folder: &Path, rows: usize) {
    let mut text = String::from("time,\"command[1]\",\"command[2]\"\n");
    for k in 0..rows {
        let t = k as f64 * 1e-4;
        let first = 60.0 - 50.0 * (2.0 * std::f64::consts::PI * 7.0 * t).cos();
        let second = 50.0 + 30.0 * (31.0 * t).sin() + 10.0 * (411.0 * t).sin();
        text += &format!("{t},{first},{second}\n");
    }
    fs::write(folder.join("commands.csv"), text).expect("the folder is writable");
}

#[test]
fn both_fmus_are_valid() {
    let folder = tempfile::tempdir().expect("a folder");
    pack_loop(folder.path());
    let code = r#"
import sys
from fmpy.validation import validate_fmu
bad = 0
for name in sys.argv[1:]:
    for problem in validate_fmu(name):
        print(name, problem)
        bad += 1
sys.exit(bad)
"#;
    let message = python::script(code, &["plant.fmu", "controller.fmu"], folder.path());
    assert_eq!(message.trim(), "");
}

#[test]
fn a_run_in_fmpy_is_our_run() {
    let folder = tempfile::tempdir().expect("a folder");
    succeed(&["pack", "evc", "-o", "plant.fmu"], folder.path());
    write_commands(folder.path(), 5000);
    succeed(&["simulate", "plant.fmu", "--log", "commands.csv", "-o", "run.csv"], folder.path());
    let code = r#"
import numpy as np
from fmpy import simulate_fmu
from fmpy.util import read_csv, write_csv
table = read_csv("commands.csv")
ours = read_csv("run.csv")
t = table["time"]
theirs = simulate_fmu("plant.fmu", start_time=t[0], stop_time=t[-1], output_interval=1e-4,
                      input=table, output=["position[1]", "position[2]"])
write_csv("fmpy.csv", theirs)
assert len(theirs) == len(ours), (len(theirs), len(ours))
for name in ("position[1]", "position[2]"):
    difference = np.abs(theirs[name] - ours[name]).max() / np.ptp(ours[name])
    print(name, difference)
    assert difference <= 1e-12, (name, difference)
    assert np.ptp(ours[name]) > 1.0
"#;
    println!("{}", python::script(code, &[], folder.path()));
    // What fmpy writes, we read: its run compared with ours, as a log.
    let result = json(
        &["simulate", "plant.fmu", "--log", "merged.csv"],
        merge(folder.path(), "commands.csv", "fmpy.csv"),
    );
    let fits = result["fits"].as_array().expect("fits");
    assert_eq!(fits.len(), 2);
    for fit in fits {
        let rmse = fit["raw_rmse"].as_f64().expect("a number");
        assert!(rmse <= 1e-12 * fit["range"].as_f64().expect("a number"), "{fit}");
    }
}

/// One log with the inputs of the first file and the outputs of the second, row by row.
fn merge<'a>(folder: &'a Path, inputs: &str, outputs: &str) -> &'a Path {
    let read = |name: &str| fs::read_to_string(folder.join(name)).expect("a file");
    let (inputs, outputs) = (read(inputs), read(outputs));
    let lines = inputs.lines().zip(outputs.lines());
    let merged: Vec<String> = lines
        .map(|(left, right)| {
            let (_, values) = right.split_once(',').expect("columns");
            format!("{left},{values}")
        })
        .collect();
    fs::write(folder.join("merged.csv"), merged.join("\n")).expect("the folder is writable");
    folder
}

#[test]
fn the_loop_stepped_by_hand_in_fmpy_is_our_loop() {
    let folder = tempfile::tempdir().expect("a folder");
    pack_loop(folder.path());
    let mut text = String::from("time,reference[1],reference[2]\n");
    for k in 0..2001 {
        let t = k as f64 * 20e-6;
        let rise = 0.5 - 0.5 * (std::f64::consts::PI * (t / 0.02).min(1.0)).cos();
        let phase = 2.0 * std::f64::consts::PI * 100.0 * t;
        text += &format!(
            "{t},{},{}\n",
            rise * (3.0 - 2.0 * phase.cos()),
            rise * (4.5 + 3.5 * phase.sin())
        );
    }
    fs::write(folder.path().join("reference.csv"), text).expect("the folder is writable");
    for coupling in ["controller-first", "side-by-side"] {
        let arguments = [
            "simulate",
            "--loop",
            "plant.fmu",
            "controller.fmu",
            "--reference",
            "reference.csv",
            "--coupling",
            coupling,
            "-o",
            "run.csv",
        ];
        succeed(&arguments, folder.path());
        println!("{coupling}: {}", python::script(BY_HAND, &[coupling], folder.path()));
    }
}

const BY_HAND: &str = r#"
import sys
import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.util import read_csv

reference = read_csv("reference.csv")
ours = read_csv("run.csv")
dt, n = 20e-6, len(reference)

def instantiate(name):
    folder, description = extract(name), read_model_description(name)
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder,
                    modelIdentifier=description.coSimulation.modelIdentifier, instanceName=name)
    references = {v.name: v.valueReference for v in description.modelVariables}
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0, stopTime=dt * (n - 1))
    fmu.enterInitializationMode()
    return fmu, references

plant, p = instantiate("plant.fmu")
controller, c = instantiate("controller.fmu")
r_in = [c["reference[1]"], c["reference[2]"]]
y_in = [c["measured[1]"], c["measured[2]"]]
u_out = [c["command[1]"], c["command[2]"]]
u_in = [p["command[1]"], p["command[2]"]]
y_out = [p["position[1]"], p["position[2]"]]
rows = [[reference["reference[1]"][k], reference["reference[2]"][k]] for k in range(n)]

first = sys.argv[1] == "controller-first"
order = ["c", "p"] if first else ["p", "c"]
# Initialization: connected values as they stand, in the order of the loop.
controller.setReal(r_in + y_in, rows[0] + plant.getReal(y_out))
plant.setReal(u_in, controller.getReal(u_out))
controller.setReal(y_in, plant.getReal(y_out))
controller.exitInitializationMode()
plant.exitInitializationMode()
run = []
for k in range(n):
    t = k * dt
    h = (k + 1) * dt - t
    y = plant.getReal(y_out)
    u = controller.getReal(u_out)
    if k < n - 1:
        controller.setReal(r_in + y_in, rows[k] + y)
        controller.doStep(t, h)
        if first:
            u = controller.getReal(u_out)
        plant.setReal(u_in, u)
        plant.doStep(t, h)
    run.append(y)
run = np.array(run)
for i in (1, 2):
    want = ours[f"position[{i}]"]
    difference = np.abs(run[:, i - 1] - want).max() / np.ptp(want)
    print(f"position[{i}]", difference)
    assert np.ptp(want) > 1.0
    assert difference <= 1e-12, difference
"#;

#[test]
fn fmpys_own_choice_of_step_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    succeed(&["pack", "evc", "-o", "plant.fmu"], folder.path());
    let code = r#"
import numpy as np
from fmpy import simulate_fmu
signals = np.array([(0.0, 0.0, 0.0), (0.0032, 0.0, 0.0), (0.0032, 70.0, 40.0), (2.0, 70.0, 40.0)],
                   dtype=[("time", float), ("command[1]", float), ("command[2]", float)])
coarse = simulate_fmu("plant.fmu", stop_time=0.1, input=signals)
fine = simulate_fmu("plant.fmu", stop_time=0.1, output_interval=20e-6, input=signals)
step = coarse["time"][1] - coarse["time"][0]
print("fmpy's step:", step)
assert step > 4 * 20e-6
for name in ("position[1]", "position[2]"):
    at = np.searchsorted(fine["time"], coarse["time"] - 1e-9)
    assert (fine[name][at] == coarse[name]).all()
    assert np.ptp(fine[name]) > 0.5
"#;
    println!("{}", python::script(code, &[], folder.path()));
}

//! `piezoloop-papers`: the quick run is complete, lists what it omits, and what it keeps runs elsewhere.

use crate::common;

use std::path::Path;
use std::process::{Command, Output};

use common::python;

/// Runs the program beside the tool, which `cargo test` at the root builds.
fn papers(arguments: &[&str], folder: &Path) -> Output {
    let name = format!("piezoloop-papers{}", std::env::consts::EXE_SUFFIX);
    let program = Path::new(env!("CARGO_BIN_EXE_piezoloop")).with_file_name(name);
    let output = Command::new(&program).args(arguments).current_dir(folder).output();
    output.unwrap_or_else(|error| {
        panic!("{}: {error}; `cargo build --release` builds it", program.display())
    })
}

/// All papers, quick, kept in the folder `kept`; the answer as JSON.
fn quick(folder: &Path) -> serde_json::Value {
    let output = papers(&["--json", "all", "--quick", "--keep", "kept"], folder);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    // 1: not every figure is reached.
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}: {errors}", output.status);
    serde_json::from_slice(&output.stdout).expect("--json prints JSON")
}

/// The kept loops stepped by hand in fmpy are the kept logs; the models, where there is one, run.
const IN_FMPY: &str = r#"
import os, sys
import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.util import read_csv

# The loop of the kept controller.
LOOPS = {
    "p0": "rate-1-system-4-feedforward-and-pid",
    "p1": "d-inverse-and-pid",
    "p2": "feedforward-and-pid-ls-svm",
    "p3": "closed-100-hz-12-inputs",
    "p4": "case-1-0",
}
ROWS = 1500

def instantiate(name):
    folder, description = extract(name), read_model_description(name)
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder,
                    modelIdentifier=description.coSimulation.modelIdentifier, instanceName="one")
    references = {v.name: v.valueReference for v in description.modelVariables}
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    return fmu, references

def check(paper):
    folder = f"kept/{paper}"
    table = read_csv(f"{folder}/loop-{LOOPS[paper]}.csv")
    axes = sum(name.startswith("command[") for name in table.dtype.names)
    of = lambda name: [f"{name}[{axis}]" for axis in range(1, axes + 1)]
    told = np.array([table[name] for name in of("reference")]).T[:ROWS]
    want = np.array([table[name] for name in of("position")]).T[:ROWS]
    time = table["time"]
    plant, p = instantiate(f"{folder}/plant.fmu")
    controller, c = instantiate(f"{folder}/controller.fmu")
    r_in, y_in, u_out = ([c[n] for n in of(name)] for name in ("reference", "measured", "command"))
    u_in, y_out = ([p[n] for n in of(name)] for name in ("command", "position"))
    # Connected values as they stand, the controller first.
    controller.setReal(r_in + y_in, list(told[0]) + plant.getReal(y_out))
    plant.setReal(u_in, controller.getReal(u_out))
    controller.setReal(y_in, plant.getReal(y_out))
    controller.exitInitializationMode()
    plant.exitInitializationMode()
    run = []
    for k in range(len(told)):
        y = plant.getReal(y_out)
        run.append(y)
        step = time[1] * (k + 1) - time[1] * k
        controller.setReal(r_in + y_in, list(told[k]) + y)
        controller.doStep(time[1] * k, step)
        plant.setReal(u_in, controller.getReal(u_out))
        plant.doStep(time[1] * k, step)
    difference = np.abs(np.array(run) - want).max(axis=0) / np.ptp(want, axis=0)
    print(paper, "positions differ by", difference, "of their range")
    assert (np.ptp(want, axis=0) > 1.0).all() and (difference <= 1e-9).all(), (paper, difference)
    model = f"{folder}/model.fmu"
    if os.path.exists(model):
        position = simulate_fmu(model, stop_time=0.02)["position[1]"]
        assert len(position) > 1 and np.isfinite(position).all(), paper

for paper in sys.argv[1:]:
    check(paper)
"#;

#[test]
fn a_quick_reproduction_says_what_it_leaves_out_and_what_it_keeps_runs_in_fmpy() {
    let folder = tempfile::tempdir().expect("a folder");
    let all = quick(folder.path());
    let all = all.as_array().expect("reproductions");
    assert_eq!(all.len(), 10);
    for one in all {
        let (paper, part) = (&one["paper"], &one["part"]);
        let count = |name: &str| one[name].as_array().map_or(0, Vec::len);
        assert!(count("left_out") > 0, "{paper} {part}");
        assert!(count("rows") > 0 && count("orders") > 0, "{paper} {part}");
        let judged = one["rows"].as_array().into_iter().flatten();
        let judged =
            judged.filter(|row| row["verdict"] == "reached" || row["verdict"] == "not-reached");
        for row in judged {
            assert!(row["own"].as_f64().is_some_and(f64::is_finite), "{row}");
        }
        let folder = folder.path().join("kept").join(paper.as_str().expect("a name"));
        let file = |name: String| assert!(folder.join(&name).is_file(), "{name}");
        let part = part.as_str().expect("a name");
        file(format!("{part}-figures.csv"));
        file(format!("{part}-orders.csv"));
        if part == "control" {
            for name in ["plant.toml", "plant.fmu", "controller.toml", "controller.fmu"] {
                file(name.to_owned());
            }
        }
    }
    // What the page on the papers says of these holds in the quick one, too.
    let of = |paper: &str, part: &str, list: &str, what: &str| -> Vec<&serde_json::Value> {
        let ours = |one: &&serde_json::Value| one["paper"] == paper && one["part"] == part;
        let one = all.iter().find(ours).unwrap_or_else(|| panic!("{paper} {part}"));
        let has = |row: &&serde_json::Value| row["what"].as_str().is_some_and(|x| x.contains(what));
        one[list].as_array().into_iter().flatten().filter(has).collect()
    };
    for (paper, part, what, count) in [
        ("p0", "control", "PSD", 3),
        ("p1", "modelling", "stops better than NARX, settings found alike", 4),
        ("p1", "control", "with the inverse better than PID alone", 4),
        ("p2", "control", "better than Bouc-Wen", 2),
        ("p2", "control", "narrower loop with LS-SVM", 2),
        ("p3", "control", "closed loop: 12 inputs better than PI alone", 3),
        ("p4", "modelling", "dynamic better than static", 4),
    ] {
        let orders = of(paper, part, "orders", what);
        assert_eq!(orders.len(), count, "{paper} {part}: {what}");
        assert!(orders.iter().all(|order| order["holds"] == true), "{paper} {part}: {what}");
    }
    for (paper, what, count) in [
        ("p0", "rate 1, system 4: feedforward and PID, PSD 1", 1),
        ("p2", "feedforward and PID, LS-SVM", 1),
        ("p3", "closed loop, 12 inputs", 6),
        ("p4", "case 1 (0°), inverse dynamic PI and PID, printed gains", 3),
    ] {
        let rows: Vec<_> = of(paper, "control", "rows", what)
            .into_iter()
            .filter(|row| !row["what"].as_str().unwrap_or_default().starts_with("width"))
            .collect();
        assert_eq!(rows.len(), count, "{paper}: {what}");
        assert!(rows.iter().all(|row| row["verdict"] == "reached"), "{paper}: {what}");
    }
    let papers = ["p0", "p1", "p2", "p3", "p4"];
    println!("{}", python::script(IN_FMPY, &papers, folder.path()));
}

#[test]
fn what_cannot_be_run_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    for (arguments, parts) in [
        (&["p4", "--quick", "--searches"][..], &["--quick", "--searches"][..]),
        (&["p9"], &["p9", "p0, p1, p2"]),
        (&["--match", "p0"], &["--match"]),
        (&["p0", "--tool", "no/such"], &["--tool", "no/such", "no such program"]),
        (&["p0", "--report", "page.csv"], &["page.csv", ".html"]),
    ] {
        let output = papers(arguments, folder.path());
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(parts.iter().all(|part| message.contains(part)), "{arguments:?}: {message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0);
}

#[test]
fn the_machines_stand_beside_the_papers_figures() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = papers(&["--match", "--json"], folder.path());
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let all: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let all = all.as_array().expect("figures");
    for rig in ["p0", "p1", "p2", "p3", "p4"] {
        let of = |figure: &&serde_json::Value| {
            figure["rig"].as_str().is_some_and(|name| name.contains(rig))
        };
        assert!(all.iter().filter(of).count() > 0, "{rig}");
    }
}

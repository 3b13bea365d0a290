//! Controllers through the tool: calibration of a Jacobian, tuning, the coordinated controller FMU.
#![cfg(target_os = "linux")]

use crate::common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use common::packed::{Host, Packed};
use common::{COORDINATED, four_axes, json, refuse, root, succeed};
use data::Blueprint;

const J: [[f64; 2]; 2] = [[500.0, 0.0], [14.0, -515.0]];

/// A log of two motions and two coordinates.
fn log(at: &Path, second: impl Fn(f64) -> f64) {
    let mut text = String::from("time [s],theta1,theta2,x [um],y [um]\n");
    for k in 0..400 {
        let turn = std::f64::consts::TAU * f64::from(k) / 400.0;
        let theta = [0.5 - 0.4 * (3.0 * turn).cos(), second(turn)];
        let p: Vec<f64> = J.iter().map(|row| 7.0 + row[0] * theta[0] + row[1] * theta[1]).collect();
        writeln!(text, "{},{},{},{},{}", 0.005 * f64::from(k), theta[0], theta[1], p[0], p[1])
            .expect("a text");
    }
    fs::write(at.join("log.csv"), text).expect("a file");
}

const CALIBRATE: [&str; 10] = [
    "calibrate",
    "log.csv",
    "--motion",
    "theta1",
    "--motion",
    "theta2",
    "--position",
    "x",
    "--position",
    "y",
];

#[test]
fn a_calibrated_jacobian_coordinates_the_controller() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    log(at, |turn| 0.5 - 0.4 * (4.0 * turn).cos());
    fs::write(at.join("controller.toml"), COORDINATED).expect("a file");
    let more = ["--blueprint", "controller.toml", "-o", "calibrated.toml"];
    let answer = json(&[&CALIBRATE[..], &more].concat(), at);
    assert!(answer["condition"].as_f64().is_some_and(|c| (1.0..1.1).contains(&c)), "{answer}");
    let rows = answer["coordinates"].as_array().expect("rows");
    for (row, truth) in rows.iter().zip(J) {
        for (found, truth) in row["row"].as_array().expect("a row").iter().zip(truth) {
            assert!((found.as_f64().expect("a number") - truth).abs() < 1e-6, "{answer}");
        }
    }
    // The error of each axis is that of the motions: e = J^-1 (p_r - p).
    let theta = [0.3, -0.2];
    let p = J.map(|row| row[0] * theta[0] + row[1] * theta[1]);
    let table = format!(
        "time [s],reference[1] [um],reference[2] [um],measured[1] [um],measured[2] [um]\n\
         0,0,0,0,0\n0.005,{0},{1},0,0\n0.01,{0},{1},0,0\n",
        p[0], p[1]
    );
    fs::write(at.join("r.csv"), table).expect("a file");
    succeed(&["pack", "calibrated.toml", "-o", "c.fmu"], at);
    succeed(&["simulate", "c.fmu", "--log", "r.csv", "-o", "run.csv"], at);
    let run = fs::read_to_string(at.join("run.csv")).expect("a run");
    let head: Vec<&str> = run.lines().next().expect("a head").split(',').collect();
    let last: Vec<f64> =
        run.lines().last().expect("a row").split(',').map(|x| x.parse().expect("number")).collect();
    let value = |name: &str| last[head.iter().position(|h| h.starts_with(name)).expect(name)];
    for (axis, theta) in [1, 2].iter().zip(theta) {
        let command = value(&format!("command[{axis}]"));
        assert!((command - 10.0 * theta).abs() < 1e-8, "axis {axis}: {command}");
    }
    assert_eq!(value("status"), 1.0);
}

/// A controller of two motions, as `invert` writes it for axes by themselves, gets the coordinator.
#[test]
fn a_controller_of_motions_gets_the_coordinator_that_was_calibrated() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    log(at, |turn| 0.5 - 0.4 * (4.0 * turn).cos());
    let mut plant =
        String::from("piezoloop = 1\nkind = \"plant\"\nname = \"motions\"\nstep = 5e-3\n");
    for name in ["a", "b"] {
        write!(
            plant,
            "[[axis]]\nname = \"{name}\"\ncommand = {{ unit = \"V\", min = 0, max = 100 }}\nposition = {{ unit = \"1\" }}\n\
             [[axis.component]]\ntype = \"actuator-gain\"\ngain = 0.01\n"
        )
        .expect("a text");
    }
    fs::write(at.join("motions.toml"), plant).expect("a file");
    succeed(&["invert", "motions.toml", "-o", "controller.toml"], at);
    let more = ["--blueprint", "controller.toml", "-o", "calibrated.toml"];
    json(&[&CALIBRATE[..], &more].concat(), at);
    let text = fs::read_to_string(at.join("calibrated.toml")).expect("a file");
    for word in ["jacobian-coordinator", "motion = { unit = \"1\" }", "unit = \"um\""] {
        assert!(text.contains(word), "{word}: {text}");
    }
    // The feedforward of a coordinate is that of its motions: u = 100·theta.
    let table = format!(
        "time [s],reference[1] [um],reference[2] [um],measured[1] [um],measured[2] [um]\n\
         0,7,7,7,7\n0.005,{0},{1},{0},{1}\n0.01,{0},{1},{0},{1}\n",
        7.0 + 500.0 * 0.3,
        7.0 + 14.0 * 0.3 - 515.0 * 0.2
    );
    fs::write(at.join("r.csv"), table).expect("a file");
    succeed(&["pack", "calibrated.toml", "-o", "c.fmu"], at);
    succeed(&["simulate", "c.fmu", "--log", "r.csv", "-o", "run.csv"], at);
    let run = fs::read_to_string(at.join("run.csv")).expect("a run");
    let head: Vec<&str> = run.lines().next().expect("a head").split(',').collect();
    let last: Vec<f64> =
        run.lines().last().expect("a row").split(',').map(|x| x.parse().expect("number")).collect();
    for (axis, wanted) in [(1, 30.0), (2, 20.0)] {
        let name = format!("feedforward[{axis}]");
        let found = last[head.iter().position(|h| h.starts_with(&name)).expect("a column")];
        assert!((found - wanted).abs() < 1e-6, "axis {axis}: {found}");
    }
}

#[test]
fn motion_that_does_not_determine_the_jacobian_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    log(at, |_| 0.3);
    assert!(refuse(&CALIBRATE, at).contains("theta2 did not move"));
    log(at, |turn| 0.5 - 0.2 * (3.0 * turn).cos());
    assert!(refuse(&CALIBRATE, at).contains("theta1 and theta2 moved together"));
    assert!(refuse(&[&CALIBRATE[..], &["--zero", "x:nothing"]].concat(), at).contains("--zero"));
}

#[test]
fn a_badly_conditioned_jacobian_is_refused_with_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for matrix in ["[[400, 800], [1, 2]]", "[[400, 0], [1, -0.001]]"] {
        let text = COORDINATED.replace("[[400, 0], [1, -400]]", matrix);
        fs::write(at.join("bad.toml"), text).expect("a file");
        let message = refuse(&["pack", "bad.toml", "-o", "bad.fmu"], at);
        assert!(
            message.contains("bad.toml:33") && message.contains("condition number"),
            "{message}"
        );
    }
}

/// One blueprint, as a packed FMU under our master and as a system in this process: the same bits.
#[test]
fn four_axes_with_learned_inverses_run_in_the_fmu_as_natively_and_allocate_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    four_axes::write(at);
    let mut table = String::from("time [s]");
    for name in ["reference", "measured"] {
        (1..=4).for_each(|axis| write!(table, ",{name}[{axis}] [um]").expect("a text"));
    }
    let rows: Vec<[f64; 8]> = (0..300)
        .map(|k| std::array::from_fn(|c| 40.0 * (0.01 * f64::from(k) * (c + 1) as f64).sin()))
        .collect();
    for (k, row) in rows.iter().enumerate() {
        write!(table, "\n{}", 0.005 * k as f64).expect("a text");
        row.iter().for_each(|x| write!(table, ",{x}").expect("a text"));
    }
    fs::write(at.join("in.csv"), table + "\n").expect("a file");
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], at);
    succeed(&["simulate", "controller.fmu", "--log", "in.csv", "-o", "run.csv"], at);
    let run = fs::read_to_string(at.join("run.csv")).expect("a run");
    let head: Vec<&str> = run.lines().next().expect("a head").split(',').collect();
    let columns: Vec<usize> = (1..=4)
        .map(|axis| {
            let name = format!("command[{axis}]");
            head.iter().position(|h| h.split(' ').next() == Some(&name)).expect("a command")
        })
        .collect();
    let blueprint = Blueprint::read(&at.join("controller.toml")).expect("a blueprint");
    let mut system = blueprint.check(learned::COMPONENTS).expect("sound").build();
    let names: Vec<u32> = ["reference", "measured"]
        .iter()
        .flat_map(|name| (1..=4).map(move |axis| format!("{name}[{axis}]")))
        .map(|name| system.variables().find(&name).expect("an input"))
        .collect();
    let commands: Vec<u32> = (1..=4)
        .map(|axis| system.variables().find(&format!("command[{axis}]")).expect("an output"))
        .collect();
    for (name, value) in names.iter().zip(rows[0]) {
        system.set(*name, value).expect("an input");
    }
    system.initialise(0.0).expect("rest");
    for (k, line) in run.lines().skip(1).enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        for (column, command) in columns.iter().zip(&commands) {
            let packed: f64 = cells[*column].parse().expect("a number");
            let native = system.get(*command).expect("an output");
            assert_eq!(packed.to_bits(), native.to_bits(), "row {k}: {packed} {native}");
        }
        for (name, value) in names.iter().zip(rows[k.min(rows.len() - 1)]) {
            system.set(*name, value).expect("an input");
        }
        system.advance(0.005 * (k + 1) as f64).expect("finite");
    }
    let path = at.join("controller.toml");
    let fmu = Packed::new(path.to_str().expect("UTF-8"), "2");
    println!("{}", Host::new("allocations.c").run(&fmu.arguments()));
}

#[test]
fn tuning_finds_gains_that_hold_their_margins() {
    for experiment in ["relay", "gain"] {
        let arguments = [
            "tune",
            "p1-truth",
            "--period",
            "2e-3",
            "--middle",
            "5",
            "--amplitude",
            "0.5",
            "--experiment",
            experiment,
        ];
        let answer = json(&arguments, root());
        let loops = answer["loops"].as_array().expect("loops");
        assert_eq!(loops.len(), 2, "{answer}");
        let robust = &loops[1]["verdict"];
        assert!(robust["stable"] == true && robust["gain_margin"].as_f64() > Some(2.9), "{answer}");
        assert!(robust["sensitivity"].as_f64() < Some(1.6), "{answer}");
        let ultimate = &answer["ultimate"];
        // A lag of 40 Hz under a period of 2 ms.
        assert!(
            ultimate["period"].as_f64().is_some_and(|t| (0.0039..0.05).contains(&t)),
            "{answer}"
        );
    }
    let message = refuse(
        &[
            "tune",
            "p1-truth",
            "--axis",
            "2",
            "--period",
            "2e-3",
            "--middle",
            "5",
            "--amplitude",
            "1",
        ],
        root(),
    );
    assert!(message.contains("axes 1 to 1"), "{message}");
}

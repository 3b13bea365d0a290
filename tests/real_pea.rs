//! A measured stack: identified by the tool, packed, and simulated as an FMU on rows it never saw.

use crate::common;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use common::{json, measured, refuse, succeed};
use data::{Blueprint, Value};

/// Largest error on the held-out half, rmse over range, in %.
const HELD_OUT: f64 = 0.4;
/// As `HELD_OUT`, on the other record.
const OTHER: f64 = 0.45;

#[test]
fn the_identified_stack_follows_the_measured_one() {
    let (Some(model), Some(test)) = (
        measured("pea_p885_1hz_inverse_ff/model_1hz_3v6.csv"),
        measured("pea_p885_1hz_inverse_ff/test_ff.csv"),
    ) else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let (model, test) = (model.to_string_lossy(), test.to_string_lossy());
    let arguments = [
        "identify",
        "--log",
        &model,
        "--input",
        "u",
        "--output",
        "y",
        "--model",
        "curved-prandtl-ishlinskii",
        "--rest",
        "0",
        "--drop",
        "2",
        "-o",
        "plant.toml",
    ];
    let identified = json(&arguments, folder.path());
    let record = &identified["axes"][0]["records"][0];
    let percent = |of: &str| 100.0 * record[of]["nrmse"].as_f64().expect("a figure");
    println!("held-out half of model_1hz_3v6.csv, rmse over range:");
    println!("  straight line (baseline) {:.3} %", percent("baseline_held_out"));
    println!("  identified plant         {:.3} %", percent("held_out"));
    assert!(percent("baseline_held_out") > 5.0, "the log has no hysteresis to speak of");
    assert!(percent("held_out") <= HELD_OUT);

    succeed(&["pack", "plant.toml", "-o", "plant.fmu"], folder.path());
    let run = json(
        &["simulate", "plant.fmu", "--log", &test, "--map", "u=u1", "--rows", "5051..6050"],
        folder.path(),
    );
    let fit = &run["fits"][0];
    let error = fit["nrmse_percent"].as_f64().expect("a figure");
    println!("rows 5051 to 6050 of test_ff.csv, never seen, by the packed FMU: {error:.3} %");
    assert_eq!((fit["first_row"].as_u64(), fit["last_row"].as_u64()), (Some(5051), Some(6050)));
    assert!(error <= OTHER);
}

/// As `the_identified_stack_follows_the_measured_one`, with nothing said but the run-in: every model is tried, and the first rows tell that the machine had rested
/// at 0 V.
#[test]
fn the_default_holds_on_the_other_record() {
    let (Some(model), Some(test)) = (
        measured("pea_p885_1hz_inverse_ff/model_1hz_3v6.csv"),
        measured("pea_p885_1hz_inverse_ff/test_ff.csv"),
    ) else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let (model, test) = (model.to_string_lossy(), test.to_string_lossy());
    let columns = ["identify", "--log", &model, "--input", "u", "--output", "y"];
    let arguments = [&columns[..], &["--drop", "2", "-o", "plant.toml"]].concat();
    let identified = json(&arguments, folder.path());
    assert!(
        identified["notes"].to_string().contains("the machine rested under 0 V"),
        "{identified}"
    );
    let held_out = &identified["axes"][0]["records"][0]["held_out"]["nrmse"];
    assert!(held_out.as_f64().is_some_and(|part| part <= 0.4e-2), "{held_out}");
    succeed(&["pack", "plant.toml", "-o", "plant.fmu"], folder.path());
    let arguments =
        ["simulate", "plant.fmu", "--log", &test, "--map", "u=u1", "--rows", "5051..6050"];
    let error = json(&arguments, folder.path())["fits"][0]["nrmse_percent"].as_f64();
    assert!(error.is_some_and(|percent| percent <= 0.55), "{error:?}");
}

/// Identifies the measured stack by one model, packs it, and gives the held-out error in % of the range, of the
/// plant and of its FMU.
fn shown(model: &str, log: &str, at: &Path) -> [f64; 2] {
    let mut arguments = vec!["identify", "--log", log, "--input", "u", "--output", "y"];
    arguments.extend(["--model", model, "--rest", "0", "--drop", "2", "-o", "plant.toml"]);
    let identified = json(&arguments, at);
    let record = &identified["axes"][0]["records"][0];
    let percent = 100.0 * record["held_out"]["nrmse"].as_f64().expect("a figure");
    assert!(at.join("plant-y.npy").is_file(), "the table lies beside the blueprint");
    succeed(&["pack", "plant.toml", "-o", "plant.fmu"], at);
    let rows = record["held_out"]["rows"].clone();
    let rows = format!("{}..{}", rows["first"].as_u64().unwrap_or(0) + 1, rows["end"]);
    let run = json(&["simulate", "plant.fmu", "--log", log, "--rows", &rows], at);
    [percent, run["fits"][0]["nrmse_percent"].as_f64().expect("a figure")]
}

/// A folder with the stack as stop operators and its FMU, and what [`shown`] gives of it: learned once for both tests.
fn stops(log: &str) -> &'static (PathBuf, [f64; 2]) {
    static STOPS: OnceLock<(PathBuf, [f64; 2])> = OnceLock::new();
    STOPS.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stack");
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a folder");
        let errors = shown("lssvm-stops", log, &folder);
        (folder, errors)
    })
}

/// The learned models know the motion that they were shown: one large sine.
#[test]
fn a_learned_stack_follows_the_motion_that_it_was_shown() {
    let Some(log) = measured("pea_p885_1hz_inverse_ff/model_1hz_3v6.csv") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let Some(other) = measured("pea_p885_1hz_inverse_ff/test_ff.csv") else { return };
    let log = log.to_string_lossy();
    let (stops, of_stops) = stops(&log);
    for (model, errors) in [
        ("lssvm-narx", shown("lssvm-narx", &log, folder.path())),
        ("gp", shown("gp", &log, folder.path())),
        ("lssvm-stops", *of_stops),
    ] {
        let [percent, packed] = errors;
        println!("held-out half of model_1hz_3v6.csv, {model}: {percent:.3} % of the range");
        println!("the same by the packed FMU, which starts under the first command: {packed:.3} %");
        assert!(percent <= 0.3, "{model}: {percent}");
        assert!((packed - percent).abs() < 0.05, "{model}: {packed} {percent}");
    }
    // Stop operators on a line, projected on the command, know smaller loops of another record, too.
    let log = other.to_string_lossy();
    let arguments =
        ["simulate", "plant.fmu", "--log", &log, "--map", "u=u1", "--rows", "5051..6050"];
    let run = json(&arguments, stops);
    let error = run["fits"][0]["nrmse_percent"].as_f64().expect("a figure");
    println!("rows 5051 to 6050 of test_ff.csv, lssvm-stops: {error:.3} %");
    assert!(error <= 0.6, "{error}");
}

/// The learned stack under its learned inverse and a PID loop, and under the loop alone: 2 Hz, swings of 10 to
/// 100 % of 37 um, in simulation on the stack's model.
#[test]
fn the_learned_inverse_of_the_stack_beats_feedback_alone() {
    let Some(log) = measured("pea_p885_1hz_inverse_ff/model_1hz_3v6.csv") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let (stops, _) = stops(&log.to_string_lossy());
    for name in ["plant.toml", "plant-y.npy", "plant.fmu"] {
        std::fs::copy(stops.join(name), at.join(name)).expect("a copy");
    }
    let answer = json(&["invert", "plant.toml", "-o", "controller.toml"], at);
    let inverse = &answer["axes"][0]["inverse"];
    let error = 100.0 * inverse["error"].as_f64().expect("a figure");
    println!("inverse on waves that it was not learned from: {error:.3} % of the range");
    assert!(error < 0.3 && at.join("controller-y.npy").is_file());
    succeed(&["invert", "plant.toml", "--feedback-only", "-o", "pid.toml"], at);
    let rest = Blueprint::read(&at.join("controller.toml")).expect("a blueprint").axes[0]
        .reference
        .clone();
    let Some(Value::Number(rest)) = rest.start else { panic!("{rest:?}") };
    let (low, high) = (-115.0, -78.0);
    let mut table = String::from("time [s],reference[1] [um]\n");
    for k in 0..4000 {
        let t = 0.005 * f64::from(k);
        let turn = std::f64::consts::TAU * (t - 2.0).max(0.0);
        let rise = 0.5 * (1.0 - (0.5 * std::f64::consts::PI * t.min(2.0)).cos());
        let size = 0.5 * (high - low) * (0.55 + 0.45 * (0.11 * turn).cos());
        let y = rest + (low - rest) * rise + size * (1.0 - (2.0 * turn).cos());
        writeln!(table, "{t},{y}").expect("a text");
    }
    std::fs::write(at.join("reference.csv"), table).expect("a file");
    let error = |controller: &str| {
        succeed(&["pack", &format!("{controller}.toml"), "-o", "c.fmu"], at);
        let run = json(
            &[
                "simulate",
                "--loop",
                "plant.fmu",
                "c.fmu",
                "--reference",
                "reference.csv",
                "--drop",
                "3",
            ],
            at,
        );
        run["fits"][0]["nrmse_percent"].as_f64().expect("a figure")
    };
    let (both, alone) = (error("controller"), error("pid"));
    println!("tracking: {both:.3} % of the range with the learned inverse, {alone:.2} % without");
    assert!(both < 0.3 && 20.0 * both < alone, "{both} {alone}");
    let text = refuse(&["invert", "plant.toml", "--period", "1e-3", "-o", "c.toml"], at);
    assert!(text.contains("0.005 s") && text.contains("leave --period out"), "{text}");
}

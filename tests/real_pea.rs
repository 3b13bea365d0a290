//! A measured stack: identified by the tool, packed, and simulated as an FMU on rows it never saw.

#![allow(clippy::print_stdout)]

mod common;

use common::{json, measured, succeed};

/// Largest error on the held-out half, rmse over range, in %.
const HELD_OUT: f64 = 0.4;
/// The same on the other record.
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

/// The learned model knows the motion that it was shown: one large sine.
#[test]
fn a_learned_stack_follows_the_motion_that_it_was_shown() {
    let Some(log) = measured("pea_p885_1hz_inverse_ff/model_1hz_3v6.csv") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let log = log.to_string_lossy();
    let mut arguments = vec!["identify", "--log", &log, "--input", "u", "--output", "y"];
    arguments.extend(["--model", "lssvm-stops", "--rest", "0", "--drop", "2", "-o", "plant.toml"]);
    let identified = json(&arguments, folder.path());
    let record = &identified["axes"][0]["records"][0];
    let percent = 100.0 * record["held_out"]["nrmse"].as_f64().expect("a figure");
    println!("held-out half of model_1hz_3v6.csv, LS-SVM: {percent:.3} % of the range");
    assert!(percent <= 0.3, "{percent}");
    assert!(folder.path().join("plant-y.npy").is_file(), "the table lies beside the blueprint");
    succeed(&["pack", "plant.toml", "-o", "plant.fmu"], folder.path());
    let rows = record["held_out"]["rows"].clone();
    let rows = format!("{}..{}", rows["first"].as_u64().unwrap_or(0) + 1, rows["end"]);
    let run = json(&["simulate", "plant.fmu", "--log", &log, "--rows", &rows], folder.path());
    let packed = run["fits"][0]["nrmse_percent"].as_f64().expect("a figure");
    println!("the same by the packed FMU, which starts under the first command: {packed:.3} %");
    assert!((packed - percent).abs() < 0.05, "{packed} {percent}");
}

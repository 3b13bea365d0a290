//! A diagnosis of an FMU that crashes, hangs, fails, prints or lies: it survives, names the FMU and
//! says how far it came. Each is a small faulty FMU in C.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use common::faulty::{Lie, build, has_compiler};
use common::{json, piezoloop, succeed};

/// Rows of the log, a hundredth of a second each.
const ROWS: usize = 600;

/// A log of a machine that follows 2·u with a lag that the FMU does not have.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = "time [s],u,x\n".to_owned();
    let (mut x, mut state) = (0.0, 12345_u32);
    for k in 0..ROWS {
        let t = k as f64 * 0.01;
        let u = (3.0 * t).sin() + 0.5 * (17.0 * t).sin() + 0.3 * (41.0 * t).cos();
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = 1e-3 * (f64::from(state >> 8) / f64::from(1 << 24) - 0.5);
        text += &format!("{t:.2},{u},{}\n", x + noise);
        x += 0.3 * (2.0 * u - x);
    }
    fs::write(folder.path().join("log.csv"), text).expect("writable");
    folder
}

const ISOLATED: [&str; 3] = ["--isolate", "--timeout", "1"];

fn diagnose<'a>(fmu: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let map = ["--log", "log.csv", "--map", "command[1]=u", "--map", "position[1]=x"];
    let least = ["--max-effects", "1", "--threads", "2"];
    [&["diagnose", "--model", fmu], &map[..], &least[..], more].concat()
}

fn fault(folder: &Path, fault: &str) -> String {
    build(folder, fault, &[&format!("FAULT={fault}")], Lie::None)
}

#[test]
fn a_failure_over_the_log_is_told_with_time_and_row() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    for (name, words) in [
        ("CRASH_STEP", "because the FMU crashed: its process ended with signal: 11"),
        ("EXIT_STEP", "because the FMU crashed: its process ended with exit status: 0"),
        ("HANG_STEP", "fmi2DoStep has not returned within 1 s"),
        ("ERROR_STEP", "the bearing is worn"),
        ("FATAL_STEP", "the bearing is gone"),
        ("DISCARD_STEP", "returned Discard"),
        ("NO_NUMBER", "variable `position[1]` has become NaN"),
        ("MANY", "wrote more"),
    ] {
        let fmu = fault(at, name);
        let needs_isolation = name.starts_with("CRASH") || name.starts_with("EXIT");
        let needs_isolation = needs_isolation || name.starts_with("HANG");
        for more in [&[][..], &ISOLATED[..]].iter().skip(usize::from(needs_isolation)) {
            fs::write(at.join("gap.json"), "old").expect("writable");
            let output =
                piezoloop(&diagnose(&fmu, &[more, &["--json", "gap.json"][..]].concat()), at);
            let message = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{name}: {message}");
            for words in ["FMU `faulty`", "at t = 0.5", "of 600 rows", "log", words] {
                assert!(message.contains(words), "{name}: \"{words}\" is not in: {message}");
            }
            assert_eq!(fs::read_to_string(at.join("gap.json")).expect("there"), "old");
        }
    }
}

#[test]
fn in_processes_of_their_own_fmus_give_the_same_answer() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    let fmu = fault(at, "SOUND");
    let begin = Instant::now();
    let here = json(&diagnose(&fmu, &[]), at);
    println!("in this process: {:.1} s", begin.elapsed().as_secs_f64());
    assert_eq!(here["verdict"], "effects", "{here}");
    let begin = Instant::now();
    let there = json(&diagnose(&fmu, &ISOLATED), at);
    println!("isolated: {:.1} s", begin.elapsed().as_secs_f64());
    assert_eq!(there["outputs"], here["outputs"]);
    // One that prints gives JSON all the same, and one that crashes when it is freed its answer.
    let print = fault(at, "PRINT");
    // A diagnosis takes some million steps.
    let leak = build(at, "LEAK", &["FAULT=LEAK", "LEAKED=256"], Lie::None);
    for fmu in [print, leak] {
        assert_eq!(json(&diagnose(&fmu, &[]), at)["outputs"], here["outputs"], "{fmu}");
    }
    let fmu = fault(at, "CRASH_FREE");
    assert_eq!(json(&diagnose(&fmu, &ISOLATED), at)["outputs"], here["outputs"]);
}

#[test]
fn what_an_fmu_changes_is_a_note() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    for (name, words) in
        [("ROUNDING", "another floating-point mode"), ("FOLDER", "the working folder had become /")]
    {
        let fmu = fault(at, name);
        let message = succeed(&diagnose(&fmu, &["--json", "gap.json"]), at);
        assert!(message.contains("note: FMU `faulty`") && message.contains(words), "{message}");
        assert!(at.join("gap.json").is_file(), "where it was asked for");
    }
}

/// A failure that comes and goes, as of a licence, costs nothing but its time.
#[test]
fn a_run_that_fails_is_repeated() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    let tuned = ["--tune", "gain=0.05"];
    let sound = json(&diagnose(&fault(at, "SOUND"), &tuned), at);
    let sometimes = fault(at, "ERROR_SOMETIMES");
    assert_eq!(json(&diagnose(&sometimes, &tuned), at)["outputs"], sound["outputs"]);
    let message = succeed(&diagnose(&sometimes, &tuned), at);
    for words in ["note: the FMU failed ", "but ran when that was repeated", "not now"] {
        assert!(message.contains(words), "\"{words}\" is not in: {message}");
    }
}

/// The search tries other parameters, with which an FMU may fail.
#[test]
fn failures_with_other_parameters_are_passed_over_unless_nothing_else_comes() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    let tuned = ["--tune", "gain=0.05"];
    let fmu = fault(at, "ERROR_HIGH");
    let message = succeed(&diagnose(&fmu, &tuned), at);
    for words in ["note: the FMU failed ", "0 of which ran", "passed over", "the gain is too high"]
    {
        assert!(message.contains(words), "\"{words}\" is not in: {message}");
    }
    let fmu = fault(at, "ERROR_TUNED");
    let output = piezoloop(&diagnose(&fmu, &tuned), at);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("faulty: ") && message.contains("the gain is not 2"), "{message}");
    for (name, words) in [
        (
            "CRASH_TUNED",
            "with other inputs or parameters the FMU failed: log.csv: at t = 0 s: FMU `faulty`",
        ),
        ("CRASH_SOMETIMES", "the FMU ran over the logs as they are, but crashed or hung"),
    ] {
        let fmu = fault(at, name);
        let begin = Instant::now();
        let output = piezoloop(&diagnose(&fmu, &[&tuned[..], &ISOLATED].concat()), at);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {message}");
        for words in ["faulty: ", words, "because the FMU crashed", "SIGSEGV"] {
            assert!(message.contains(words), "{name}: \"{words}\" is not in: {message}");
        }
        assert!(begin.elapsed() < Duration::from_secs(60), "{:?}", begin.elapsed());
    }
}

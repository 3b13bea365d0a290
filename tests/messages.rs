//! What FMUs say and how they end a run: heard once each, in names instead of numbers, and never taken
//! for success. Each is a small FMU in C.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use common::faulty::{Lie, build, has_compiler};
use common::{json, piezoloop, refuse, succeed};

const ROWS: usize = 20;

/// A folder with a log of 20 rows, 0.1 s apart; `None`, with a line, where no C compiler is.
fn prepared() -> Option<tempfile::TempDir> {
    if !has_compiler() {
        return None;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let rows: String = (0..ROWS).map(|k| format!("{},{}\n", k as f64 / 10.0, k % 3)).collect();
    fs::write(folder.path().join("log.csv"), format!("time,u\n{rows}")).expect("writable");
    Some(folder)
}

fn fmu(folder: &Path, fault: &str, more: &[&str]) -> String {
    let fault = format!("FAULT={fault}");
    let defines: Vec<&str> = [&[fault.as_str()], more].concat();
    build(folder, &defines.join("-").replace(['=', '.'], "_"), &defines, Lie::None)
}

fn simulate<'a>(fmu: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["simulate", fmu, "--log", "log.csv", "--map", "command[1]=u", "-o", "run.csv"], more]
        .concat()
}

fn times(folder: &Path) -> Vec<f64> {
    let text = fs::read_to_string(folder.join("run.csv")).expect("a run");
    let first = |line: &str| line.split(',').next().and_then(|t| t.parse().ok()).expect("a time");
    text.lines().skip(1).map(first).collect()
}

#[test]
fn a_run_that_the_fmu_ends_is_kept_and_its_end_reported() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    let grid: Vec<f64> = (0..6).map(|k| f64::from(k) / 10.0).collect();
    // At a row, within a step, without a word or with a wrong one about how far it got.
    for (fault, more, end) in [
        ("END", &["REACHED=0.5"][..], 0.5),
        ("END", &["REACHED=0.5625"], 0.5625),
        ("END", &["REACHED=0.0"], 0.5),
        ("END", &["REACHED=77.0"], 0.5),
        ("END_UNTOLD", &[], 0.5),
    ] {
        let fmu = fmu(at, fault, more);
        for isolated in [&[][..], &["--isolate"]] {
            let answer = json(&simulate(&fmu, isolated), at);
            let mut expected = grid.clone();
            expected.extend(Some(end).filter(|end| *end > 0.5));
            assert_eq!(times(at), expected, "{fault} {more:?}");
            assert_eq!(answer["endings"][0]["time_s"], end);
            assert_eq!(answer["endings"][0]["fmu"], "faulty");
            assert_eq!(answer["rows"], expected.len());
            assert!(
                answer["notes"][0].as_str().is_some_and(|n| n.contains("the end of the run at"))
            );
        }
        // The record is a log again.
        succeed(&["log", "run.csv"], at);
    }
    fs::write(
        at.join("s.toml"),
        format!(
            "step = 0.1\nstop = 1.9\n[fmus]\na = \"{}\"\n[inputs]\n\"a.command[1]\" = \"u\"\n",
            fmu(at, "END", &[])
        ),
    )
    .expect("writable");
    let answer = json(&["system", "s.toml", "--input", "log.csv", "-o", "run.csv"], at);
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
    assert!(times(at).len() == 6 && times(at).iter().zip(&grid).all(near), "{:?}", times(at));
    assert_eq!(answer["endings"][0]["fmu"], "a");
}

#[test]
fn a_warning_is_told_once_with_its_count() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    let fmu = fmu(at, "WARN", &[]);
    for isolated in [&[][..], &["--isolate"]] {
        let answer = json(&simulate(&fmu, isolated), at);
        let messages = answer["messages"].as_array().expect("messages");
        assert_eq!(messages.len(), 1, "{messages:?}");
        assert_eq!(messages[0]["text"], "returned Warning from 19 step calls");
        assert_eq!(answer["rows"], ROWS);
    }
}

#[test]
fn messages_are_finished_texts_with_names() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    let fmu = fmu(at, "TALK", &[]);
    for isolated in [&[][..], &["--isolate"]] {
        let answer = json(&simulate(&fmu, isolated), at);
        let messages = answer["messages"].as_array().expect("messages");
        assert_eq!(messages.len(), 2, "{messages:?}");
        assert_eq!(messages[0]["text"], "command[1] is 93% of full scale, # 2.5");
        assert_eq!((&messages[0]["category"], &messages[0]["count"]), (&"".into(), &19.into()));
        assert_eq!(messages[1]["text"], "at 0 s position[1] slips");
        assert_eq!((&messages[1]["category"], &messages[1]["count"]), (&"slip".into(), &19.into()));
    }
    let described = succeed(&simulate(&fmu, &[]), at);
    assert!(described.contains("slips (19 times, with other numbers)"), "{described}");
    // All of them, or none; escapes of terminals are written out.
    let described = succeed(&simulate(&fmu, &["--log-level", "info"]), at);
    assert!(
        described.contains("says [OK, chat]: \\u{1b}[31mall is well (19 times)"),
        "{described}"
    );
    let described = succeed(&simulate(&fmu, &["--log-level", "none", "--fmu-log", "said.txt"]), at);
    assert!(!described.contains("slips"), "{described}");
    let message = fs::read_to_string(at.join("said.txt")).expect("written");
    assert_eq!(message.lines().count(), 3 * 19);
    assert_eq!(message.lines().nth(1), Some("Warning\tfaulty\tslip\tat 0 s position[1] slips"));
    // It is never written over an input.
    let message = refuse(&simulate(&fmu, &["--fmu-log", "log.csv"]), at);
    assert!(
        message.contains("log.csv cannot be written: this command already uses the file"),
        "{message}"
    );
}

#[test]
fn an_fmu_that_leaves_the_program_is_no_success() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    for fault in ["EXIT_STEP", "EXIT_GET", "EXIT_FREE"] {
        let output = piezoloop(&simulate(&fmu(at, fault, &[]), &[]), at);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        if cfg!(target_env = "gnu") {
            assert_eq!(output.status.code(), Some(2), "{fault}: {message}");
            assert!(message.contains("an FMU (faulty) has ended this program"), "{message}");
        }
    }
    let described = succeed(&simulate(&fmu(at, "EXIT_FREE", &[]), &["--isolate"]), at);
    assert!(
        described.contains("FreeInstance crashed: its process ended with exit status: 0"),
        "{described}"
    );
}

#[test]
fn the_time_of_a_call_is_bounded_however_much_is_stated() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    let begin = Instant::now();
    let message = refuse(&simulate(&fmu(at, "FLOOD", &[]), &["--isolate", "--timeout", "1"]), at);
    assert!(message.contains("fmi2DoStep has not returned within 1 s"), "{message}");
    assert!(begin.elapsed() < Duration::from_secs(20), "{:?}", begin.elapsed());
}

#[test]
fn what_feeds_nothing_is_told_and_nothing_at_all_is_an_error() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    let fmu = fmu(at, "SOUND", &[]);
    let plain = ["simulate", &fmu, "--log", "log.csv", "-o", "run.csv"];
    let message = refuse(&plain, at);
    for words in ["no column feeds an input", "`u`", "`command[1]`", "--map command[1]=u"] {
        assert!(message.contains(words), "\"{words}\" is not in {message}");
    }
    assert!(!at.join("run.csv").exists());
    // A name that differs by case is the way out.
    fs::write(at.join("case.csv"), "time,Command[1]\n0,1\n1,1\n").expect("writable");
    let message = refuse(&["simulate", &fmu, "--log", "case.csv"], at);
    assert!(message.contains("--map command[1]=Command[1]"), "{message}");
    // Measured only: the input keeps its start value, which is said.
    fs::write(at.join("half.csv"), "time,position[1],spare\n0,0,1\n1,0,1\n").expect("writable");
    let answer = json(&["simulate", &fmu, "--log", "half.csv"], at);
    assert_eq!(answer["unfed_inputs"], serde_json::json!(["command[1]"]));
    assert_eq!(answer["unused_columns"], serde_json::json!(["spare"]));
    assert_eq!(answer["notes"].as_array().map(Vec::len), Some(2), "{}", answer["notes"]);
    // All is used: nothing is said.
    let answer = json(&simulate(&fmu, &[]), at);
    assert_eq!(answer["notes"], serde_json::json!([]));
}

#[test]
fn every_legal_name_is_recorded_and_read_again() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    let fmu = fmu(at, "SOUND", &[]);
    let description = at.join(&fmu).join("modelDescription.xml");
    let text = fs::read_to_string(&description).expect("readable");
    for (name, column) in [
        ("A[1,1]", "A[1,1]"),
        ("der(a.b[2,3].c, 2)", "der(a.b[2,3].c, 2)"),
        ("say \"y\"", "say \"y\""),
        ("y [um]", "y (um)"),
        ("time", "time_"),
        ("  y ", "y"),
        ("two\tparts", "two_parts"),
        ("grün ; 'q' # %", "grün ; 'q' # %"),
    ] {
        let xml = name.replace('"', "&quot;").replace('\t', "&#9;");
        let named = text.replace("name=\"position[1]\"", &format!("name=\"{xml}\""));
        fs::write(&description, named).expect("writable");
        let answer = json(&simulate(&fmu, &[]), at);
        let renamed = answer["notes"].as_array().is_some_and(|n| !n.is_empty());
        assert_eq!(renamed, name != column, "{name}: {}", answer["notes"]);
        let log = json(&["log", "run.csv"], at);
        let names: Vec<&str> = log["logs"][0]["columns"]
            .as_array()
            .expect("columns")
            .iter()
            .filter_map(|c| c["name"].as_str())
            .collect();
        assert!(names.contains(&column), "{name}: {names:?}");
        // A record can be compared with the model again.
        let map = format!("{name}={column}");
        let again = json(&["simulate", &fmu, "--log", "run.csv", "--map", &map], at);
        if name == column {
            assert_eq!(again["fits"].as_array().map(Vec::len), Some(1), "{name}");
        }
    }
}

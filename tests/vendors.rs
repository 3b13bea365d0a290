//! FMUs of others that crash, hang, fail, leak, print, lie, or change the program around them: the
//! tool survives, names the FMU and keeps the record so far. Each is a small faulty FMU in C.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use common::faulty::{Lie, build, has_compiler};
use common::{json, piezoloop, python, succeed};

/// Rows of the log, and rows that are kept of a run whose step at 0.5 s fails.
const ROWS: usize = 20;
const KEPT: usize = 6;

fn command(k: usize) -> f64 {
    [0.0, 1.0, 3.0, 2.0, -1.0][k % 5]
}

fn time(k: usize) -> f64 {
    k as f64 / 10.0
}

/// A folder with the log of commands and the references of a loop.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let mut log = "time,u\n".to_owned();
    let mut reference = "time,reference[1]\n".to_owned();
    for k in 0..ROWS {
        log += &format!("{},{}\n", time(k), command(k));
        reference += &format!("{},1\n", time(k));
    }
    fs::write(folder.path().join("log.csv"), log).expect("writable");
    fs::write(folder.path().join("reference.csv"), reference).expect("writable");
    folder
}

const DRIVEN: [&str; 6] = ["--log", "log.csv", "--map", "command[1]=u", "-o", "run.csv"];
const ISOLATED: [&str; 3] = ["--isolate", "--timeout", "1"];

fn simulate<'a>(fmu: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["simulate", fmu], &DRIVEN[..], more].concat()
}

/// The exit code of bad input, of which a failing FMU is one, and the message.
fn fails(arguments: &[&str], folder: &Path) -> String {
    let output = piezoloop(arguments, folder);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert!(!message.contains("panicked"), "{message}");
    message
}

fn contains(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "\"{word}\" is not in: {message}");
    }
}

/// The columns time and position of a run.
fn run(folder: &Path) -> Vec<(f64, f64)> {
    let text = fs::read_to_string(folder.join("run.csv")).expect("a run");
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().expect("a head").split(',').collect();
    let place = |name: &str| head.iter().position(|n| n.contains(name)).expect(name);
    let (t, y) = (place("time"), place("position"));
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|c| c.parse().expect("a number")).collect();
        (cells[t], cells[y])
    };
    lines.map(row).collect()
}

/// The first rows of the sound FMU under the log.
fn holds_rows(folder: &Path, rows: usize) {
    let expected = |k: usize| if k == 0 { 0.0 } else { 2.0 * command(k - 1) };
    let expected: Vec<(f64, f64)> = (0..rows).map(|k| (time(k), expected(k))).collect();
    assert_eq!(run(folder), expected);
}

#[test]
fn a_step_that_crashes_or_hangs_is_named_and_the_record_kept() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    for (fault, words) in [
        ("CRASH_STEP", ["fmi2DoStep has not returned, because the FMU crashed", "SIGSEGV"]),
        ("EXIT_STEP", ["fmi2DoStep has not returned, because the FMU crashed", "exit status: 0"]),
        ("HANG_STEP", ["fmi2DoStep has not returned within 1 s", "its process was ended"]),
    ] {
        let fmu = build(at, fault, &[&format!("FAULT={fault}")], Lie::None);
        fs::write(at.join("run.csv"), "old").expect("writable");
        let begin = Instant::now();
        let message = fails(&simulate(&fmu, &ISOLATED), at);
        contains(&message, &["at t = 0.5 s: FMU `faulty`", "6 rows until then are in run.csv"]);
        contains(&message, &words);
        assert!(begin.elapsed() < Duration::from_secs(20), "{:?}", begin.elapsed());
        holds_rows(at, KEPT);
    }
}

/// In this process a crash ends the program, but not without a word, and with nothing left behind.
#[test]
fn a_crash_of_this_process_is_told_of_with_the_fmu_and_its_call() {
    use std::os::unix::process::ExitStatusExt;
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    let temporary = tempfile::tempdir().expect("a folder");
    let run = |fault: &str| {
        let fmu = build(at, fault, &[&format!("FAULT={fault}")], Lie::None);
        let mut tool = std::process::Command::new(env!("CARGO_BIN_EXE_piezoloop"));
        tool.args(simulate(&fmu, &[])).current_dir(at).env("TMPDIR", temporary.path());
        let output = tool.output().expect("the tool starts");
        (output.status, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (segv, abort, fpe) = (11, 6, 8);
    for (fault, call, names, signals) in [
        ("CRASH_STEP", "`faulty`: fmi2DoStep", "SIGSEGV", &[segv][..]),
        ("CRASH_GET", "`faulty`: fmi2GetReal", "SIGSEGV", &[segv]),
        ("CRASH_INSTANTIATE", "`faulty`: fmi2Instantiate", "SIGSEGV", &[segv]),
        ("CRASH_FREE", "`faulty`: fmi2FreeInstance", "SIGSEGV", &[segv]),
        ("CRASH_LOAD", "`faulty.so`: the loading of its library", "SIGSEGV", &[segv]),
        ("ABORT_STEP", "`faulty`: fmi2DoStep", "SIGABRT", &[abort]),
        ("TRAP_STEP", "`faulty`: fmi2DoStep", "SIGFPE", &[fpe]),
        // Rust's runtime ends the program of which a stack has overflowed.
        ("OVERFLOW_STEP", "`faulty`: fmi2DoStep", "SIGSEGV", &[segv, abort]),
    ] {
        let (status, message) = run(fault);
        assert!(
            status.signal().is_some_and(|s| signals.contains(&s)),
            "{fault}: {status}: {message}"
        );
        let described: Vec<&str> = message.lines().filter(|l| l.starts_with("error: ")).collect();
        assert_eq!(described.len(), 1, "{fault}: {message}");
        contains(described[0], &[call, "because the FMU crashed", names, "--isolate"]);
        let left: Vec<_> = fs::read_dir(temporary.path()).expect("there").collect();
        assert!(left.is_empty(), "{fault} leaves {left:?}");
    }
    let (status, message) = run("CRASH_END");
    assert_eq!(status.signal(), Some(segv), "{message}");
    contains(&message, &["this program has crashed (SIGSEGV)", "in no call of an FMU"]);
    let (status, message) = run("CRASH_CHILD");
    assert!(status.success() && !message.contains("crashed"), "{message}");
}

#[test]
fn memory_beyond_the_limit_is_not_given_and_the_limit_reported() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    let limited = [&ISOLATED[..], &["--memory", "200"]].concat();
    let fmu = build(at, "LEAK_MUCH", &["FAULT=LEAK_MUCH"], Lie::None);
    let message = fails(&simulate(&fmu, &limited), at);
    contains(&message, &["at t = 0.5 s: FMU `faulty`", "the 200 MB that it is allowed"]);
    contains(&message, &["6 rows until then are in run.csv"]);
    holds_rows(at, KEPT);
    // A sound one does not notice; so little that the process itself cannot live is refused.
    let fmu = build(at, "SOUND", &["FAULT=SOUND"], Lie::None);
    succeed(&simulate(&fmu, &[&ISOLATED[..], &["--memory", "32"]].concat()), at);
    holds_rows(at, ROWS);
    let message = fails(&simulate(&fmu, &[&ISOLATED[..], &["--memory", "1"]].concat()), at);
    contains(&message, &["'1' for '--memory <MB>'", "must be 32 to"]);
}

#[test]
fn an_fmu_that_cannot_even_begin_is_named_and_an_old_record_stays() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    for (fault, words) in [
        ("CRASH_LOAD", "fmi2Instantiate has not returned, because the FMU crashed"),
        ("CRASH_INSTANTIATE", "fmi2Instantiate has not returned, because the FMU crashed"),
        ("HANG_INSTANTIATE", "fmi2Instantiate has not returned within 1 s"),
    ] {
        let fmu = build(at, fault, &[&format!("FAULT={fault}")], Lie::None);
        fs::write(at.join("run.csv"), "old").expect("writable");
        contains(&fails(&simulate(&fmu, &ISOLATED), at), &["FMU `faulty`", words]);
        assert_eq!(fs::read_to_string(at.join("run.csv")).expect("there"), "old");
    }
}

#[test]
fn an_fmu_that_ends_badly_costs_no_row() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    for (fault, words) in [
        ("CRASH_FREE", "fmi2FreeInstance crashed: its process ended with signal: 11"),
        ("HANG_FREE", "fmi2FreeInstance has not returned within 1 s and was ended"),
    ] {
        let fmu = build(at, fault, &[&format!("FAULT={fault}")], Lie::None);
        let message = succeed(&simulate(&fmu, &ISOLATED), at);
        contains(&message, &["note: FMU `faulty`", words]);
        holds_rows(at, ROWS);
    }
}

/// What fails with words does so in this process and in another.
#[test]
fn statuses_lies_and_numbers_that_are_none_are_named_and_the_record_kept() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    let kept = [
        ("ERROR_STEP", vec!["at t = 0.5 s", "returned Error", "the bearing is worn"]),
        ("FATAL_STEP", vec!["at t = 0.5 s", "returned Fatal", "the bearing is gone"]),
        ("DISCARD_STEP", vec!["at t = 0.5 s", "returned Discard", "smaller communication step"]),
        ("NO_NUMBER", vec!["at t = 0.5 s", "variable `position[1]` has become NaN"]),
        ("INFINITE", vec!["at t = 0.5 s", "variable `position[1]` has become inf"]),
        ("MANY", vec!["at t = 0.5 s", "fmi2GetReal was asked for 1 values and wrote more"]),
    ];
    for (fault, words) in kept {
        let fmu = build(at, fault, &[&format!("FAULT={fault}")], Lie::None);
        for more in [&[][..], &ISOLATED[..]] {
            fs::write(at.join("run.csv"), "old").expect("writable");
            let message = fails(&simulate(&fmu, more), at);
            contains(&message, &["FMU `faulty`", "6 rows until then are in run.csv"]);
            contains(&message, &words);
            holds_rows(at, KEPT);
        }
    }
    let refused = [
        ("guid", Lie::Guid, &[][..], vec!["FMU `faulty`", "another", "this GUID is not mine"]),
        ("reference", Lie::Reference, &[], vec!["FMU `faulty`", "there is no such variable"]),
        ("identifier", Lie::Identifier, &[], vec!["identifier.fmu", "sound"]),
        ("no_step", Lie::None, &["NO_STEP"], vec!["no_step.fmu", "fmi2DoStep"]),
    ];
    for (name, lie, defines, words) in refused {
        let fmu = build(at, name, defines, lie);
        for more in [&[][..], &ISOLATED[..]] {
            fs::write(at.join("run.csv"), "old").expect("writable");
            contains(&fails(&simulate(&fmu, more), at), &words);
            assert_eq!(fs::read_to_string(at.join("run.csv")).expect("there"), "old", "{name}");
        }
    }
}

#[test]
fn what_an_fmu_changes_of_the_program_is_put_back_and_reported() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    let faults = [
        ("LEAK", None),
        ("ROUNDING", Some("another floating-point mode")),
        ("ROUNDING_GET", Some("another floating-point mode")),
        ("FOLDER", Some("the working folder had become /")),
    ];
    for (fault, note) in faults {
        let fmu = build(at, fault, &[&format!("FAULT={fault}")], Lie::None);
        for more in [&[][..], &ISOLATED[..]] {
            let message = succeed(&simulate(&fmu, more), at);
            contains(&message, &[note.unwrap_or("20 rows"), "run.csv: written"]);
            assert_eq!(message.contains("note: FMU `faulty`"), note.is_some(), "{message}");
            holds_rows(at, ROWS);
            fs::remove_file(at.join("run.csv")).expect("it was there");
        }
    }
    // The place of a record does not move with the working folder.
    let fmu = build(at, "FOLDER_ERROR", &["FAULT=FOLDER_ERROR"], Lie::None);
    contains(&fails(&simulate(&fmu, &[]), at), &["the bearing is worn", "rows until then"]);
    holds_rows(at, KEPT);
}

#[test]
fn what_an_fmu_prints_does_not_spoil_json() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    let fmu = build(at, "PRINT", &["FAULT=PRINT"], Lie::None);
    for more in [&[][..], &ISOLATED[..]] {
        assert_eq!(json(&simulate(&fmu, more), at)["rows"], ROWS);
        let output = piezoloop(&[&["--json"], &simulate(&fmu, more)[..]].concat(), at);
        let chatter = String::from_utf8_lossy(&output.stderr);
        contains(&chatter, &["faulty: t = 0.5", "raw"]);
    }
}

/// Loop and system: plant and controller, of which the plant fails.
#[test]
fn in_a_loop_and_in_a_system_the_one_that_fails_is_named() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    build(at, "controller", &["CONTROLLER"], Lie::None);
    let system = "name = \"loop\"\nstep = 0.1\nstop = 1.9\n\n[fmus]\nstage = \"plant.fmu\"\n\
                  law = \"controller.fmu\"\n\n[connections]\n\
                  \"stage.command[1]\" = \"law.command[1]\"\n\
                  \"law.measured[1]\" = \"stage.position[1]\"\n\n[inputs]\n\
                  \"law.reference[1]\" = \"reference[1]\"\n\n[record]\n\
                  \"position[1]\" = \"stage.position[1]\"\n";
    fs::write(at.join("loop.toml"), system).expect("writable");
    let sound = |fault: &str| {
        let _ = fs::remove_dir_all(at.join("plant.fmu"));
        build(at, "plant", &[&format!("FAULT={fault}")], Lie::None);
    };
    let closed = ["simulate", "--loop", "plant.fmu", "controller.fmu"];
    let closed = [&closed[..], &["--reference", "reference.csv", "-o", "run.csv"]].concat();
    let system = ["system", "loop.toml", "--input", "reference.csv", "-o", "run.csv"];
    for (call, name) in [(&closed[..], "FMU `plant`"), (&system[..], "FMU `stage`")] {
        sound("SOUND");
        succeed(call, at);
        let complete = run(at);
        assert_eq!(complete.len(), ROWS);
        succeed(&[call, &ISOLATED].concat(), at);
        assert_eq!(run(at), complete, "isolated or not");
        for (fault, words, isolated) in [
            ("CRASH_STEP", "the FMU crashed", true),
            ("HANG_STEP", "has not returned within 1 s", true),
            ("ERROR_STEP", "the bearing is worn", false),
            ("FOLDER_ERROR", "the bearing is worn", false),
            ("FATAL_STEP", "the bearing is gone", false),
            ("NO_NUMBER", "variable `position[1]` has become NaN", false),
            ("MANY", "wrote more", false),
        ] {
            sound(fault);
            fs::write(at.join("run.csv"), "old").expect("writable");
            let more = if isolated { &ISOLATED[..] } else { &[] };
            let message = fails(&[call, more].concat(), at);
            contains(&message, &[name, "at t = 0.5 s", words, "6 rows until then are in run.csv"]);
            assert_eq!(run(at), complete[..KEPT], "{fault}");
            // The units beside it were right already.
            assert!(!message.contains("not written"), "{fault}: {message}");
        }
        sound("FOLDER");
        let message = succeed(call, at);
        contains(&message, &["note: ", name, "the working folder had become /"]);
        assert_eq!(run(at), complete);
    }
}

/// Runs in which the plant crashes are rows that say so; the others have their figures.
#[test]
fn a_sweep_outlives_an_fmu_that_crashes() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    // A sweep takes archives, which it can send elsewhere.
    build(at, "law", &["CONTROLLER"], Lie::None);
    build(at, "stage", &["FAULT=CRASH_TUNED"], Lie::None);
    let archives = "import shutil\nfor folder, file in [('law.fmu', 'controller'), ('stage.fmu', 'plant')]:\n    \
                    shutil.move(shutil.make_archive(file, 'zip', folder), file + '.fmu')\n";
    python::script(archives, &[], at);
    let plan = "seed = 1\n\n[loop]\nplant = \"plant.fmu\"\ncontroller = \"controller.fmu\"\n\
                reference = \"reference.csv\"\n\n[vary]\n\"plant.gain\" = { grid = [2.0, 3.0, 2.0] }\n";
    fs::write(at.join("plan.toml"), plan).expect("writable");
    let output = piezoloop(&[&["sweep", "plan.toml"][..], &ISOLATED].concat(), at);
    assert_eq!(output.status.code(), Some(1), "one run has failed");
    let message = String::from_utf8_lossy(&output.stdout);
    let first = "1 failed, the first is run 1: in record 1 at t = 0 s: FMU `plant`: fmi2DoStep has not \
                 returned, because the FMU crashed";
    contains(&message, &["3 runs", first]);
}

#[test]
fn tuning_names_a_machine_that_crashes() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    let fmu = build(at, "CRASH_STEP", &["FAULT=CRASH_STEP"], Lie::None);
    let call =
        [&["tune", &fmu, "--period", "0.1", "--middle", "0", "--amplitude", "1"][..], &ISOLATED]
            .concat();
    contains(&fails(&call, at), &["FMU `machine`", "because the FMU crashed"]);
}

#[test]
fn an_fmu_that_ends_the_program_is_no_success() {
    let folder = prepared();
    if !has_compiler() {
        return;
    }
    let at = folder.path();
    for fault in [
        "EXIT_STEP",
        "EXIT_ONE_STEP",
        "EXIT_GET",
        "EXIT_FREE",
        "QUICK_EXIT_STEP",
        "EXIT_LOAD",
        "AT_ONCE_STEP",
        "AT_ONCE_LOAD",
    ] {
        let fmu = build(at, fault, &[&format!("FAULT={fault}")], Lie::None);
        contains(&fails(&simulate(&fmu, &[]), at), &["has ended this program from inside (exit)"]);
    }
    let fmu = build(at, "child", &["FAULT=AT_ONCE_CHILD"], Lie::None);
    assert!(piezoloop(&simulate(&fmu, &[]), at).status.success());
    let fmu = build(at, "isolated", &["FAULT=AT_ONCE_STEP"], Lie::None);
    contains(&fails(&simulate(&fmu, &ISOLATED), at), &["because the FMU crashed"]);
    // The operating system says so itself.
    let fmu = build(at, "pipe", &["FAULT=SIGPIPE_STEP"], Lie::None);
    assert!(!piezoloop(&simulate(&fmu, &[]), at).status.success());
}

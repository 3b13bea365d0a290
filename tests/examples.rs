//! Every numbered example runs as its README says.
#![cfg(unix)]

use crate::common;

use std::path::Path;
use std::process::Command;

/// Runs the script of an example with the built tool first on the PATH; returns what it printed.
fn run(example: &str, folder: &Path) -> String {
    let (text, errors, status) = script(example, folder);
    assert!(status.success(), "{example} failed ({status}):\n{text}{errors}");
    text
}

/// As [`run`], for scripts with a bench in real time. A run during which this computer stood still measures the computer:
/// it is repeated, twice at most.
fn run_in_time(example: &str) -> (tempfile::TempDir, String) {
    for _ in 0..2 {
        let folder = tempfile::tempdir().expect("a folder");
        let (text, errors, status) = script(example, folder.path());
        let runs = text.lines().filter(|line| line.contains(" deadlines missed"));
        let missed =
            runs.map(|line| number(line, " overruns, ", "deadlines missed")).fold(0.0, f64::max);
        if missed < 20.0 && status.success() {
            return (folder, text);
        }
        let stalled = missed >= 20.0 || text.contains("no packet came from the machine");
        assert!(stalled, "{example} failed ({status}):\n{text}{errors}");
        println!(
            "{example}: {missed} deadlines missed in one run, {status}: once more\n{text}{errors}"
        );
    }
    let folder = tempfile::tempdir().expect("a folder");
    let text = run(example, folder.path());
    (folder, text)
}

/// What the script of an example printed on both streams, and how it ended.
fn script(example: &str, folder: &Path) -> (String, String, std::process::ExitStatus) {
    let tool = Path::new(env!("CARGO_BIN_EXE_piezoloop"));
    let tools = tool.parent().expect("the tool lies in a folder");
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::iter::once(tools.to_owned()).chain(std::env::split_paths(&path));
    let output = Command::new("sh")
        .arg(common::root().join("examples").join(example).join("run.sh"))
        .arg(folder)
        .env("PYTHON", common::python::python())
        .env("PATH", std::env::join_paths(paths).expect("a PATH"))
        .output()
        .expect("a shell");
    let [text, errors] =
        [&output.stdout, &output.stderr].map(|b| String::from_utf8_lossy(b).into_owned());
    (text, errors, output.status)
}

/// The number in front of `unit` in the first line that holds `words`, behind them.
fn number(text: &str, words: &str, unit: &str) -> f64 {
    let line = text.lines().find(|line| line.contains(words)).expect("the line is printed");
    let (_, rest) = line.split_once(words).expect("the words are there");
    let (before, _) = rest.split_once(unit).expect("the unit is there");
    before.split_whitespace().next_back().expect("a number").parse().expect("a number")
}

/// The last number of a line.
fn last_number(line: &str) -> f64 {
    let words = line.split_whitespace().rev();
    words.flat_map(str::parse).next().expect("a number")
}

#[test]
fn log_to_loop() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = run("01_log_to_loop", folder.path());
    println!("{message}");
    let held_out = number(&message, ".csv: held out ", "% of range");
    let line = number(&message, "a straight line ", "%");
    assert!(held_out < 1.0 && line > 3.0, "{held_out} {line}");
    assert_eq!(message.matches("no problem").count(), 2);
    let loop_line = message.lines().find(|line| line.contains("against reference[1]"));
    let largest = last_number(loop_line.expect("the loop's line"));
    assert!(largest < 0.02 * 4.0, "largest error {largest} um of 4 um");
    for file in
        ["plant.toml", "identify.html", "plant.fmu", "controller.fmu", "run.csv", "loop.csv"]
    {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn fmu_in_fmpy() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = run("02_fmu_in_fmpy", folder.path());
    println!("{message}");
    assert_eq!(message.matches("no problem").count(), 2);
    assert_eq!(message.matches("the same bits").count(), 2);
    assert_eq!(message.matches(": True").count(), 2);
    // What the README tells.
    let readme = include_str!("../examples/02_fmu_in_fmpy/README.md");
    for figure in ["5.535 um", "2.739 um", "3.648 um", "16.4 %"] {
        assert!(message.contains(figure) && readme.contains(figure), "{figure}: {message}");
    }
}

#[test]
fn gap() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = run("04_gap", folder.path());
    println!("{message}");
    let named: Vec<&str> = message.lines().filter(|line| line.starts_with("The model ")).collect();
    for line in &named {
        assert!(line.starts_with("The model lacks delay (timing, "), "{line}");
        assert!(line.contains(") and creep (actuator, "), "{line}");
    }
    assert_eq!(named.len(), 2, "as a blueprint and as an FMU");
    let errors: Vec<f64> = message
        .lines()
        .filter_map(|line| line.split_once("rows 1 to 12000: rmse "))
        .map(|(_, rest)| rest.split_once(" um").expect("a unit").0.parse().expect("a number"))
        .collect();
    let &[before, white, black] = errors.as_slice() else { panic!("{errors:?}") };
    assert!(before > 0.5 && white < 2.2e-3 && black < 2.2e-3, "{errors:?}");
    for file in ["gap.json", "gap.html", "gap.svg", "repaired.toml", "gap_fmu.html", "repaired.fmu"]
    {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn measured_gaps() {
    for (example, word) in
        [("06_pea_p885", "hysteresis"), ("08_piezo_stage_closedloop", "bandwidth")]
    {
        let folder = tempfile::tempdir().expect("a folder");
        let message = run(example, folder.path());
        println!("{message}");
        if message.starts_with("SKIPPED") {
            continue;
        }
        assert!(message.contains(word), "{message}");
        // The README quotes the sentence, in lines that begin with >.
        let readme = common::root().join("examples").join(example).join("README.md");
        let readme = std::fs::read_to_string(readme).expect("a README");
        let quoted: Vec<&str> = readme.lines().filter_map(|line| line.strip_prefix("> ")).collect();
        assert_eq!(message.lines().next(), Some(&*quoted.join(" ")), "{example}");
        for file in ["gap.json", "gap.html", "repaired.toml", "gap.svg"] {
            assert!(folder.path().join(file).is_file(), "{file}");
        }
    }
}

#[test]
fn measured_mirror() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = run("09_fsm_mirror", folder.path());
    println!("{message}");
    if message.starts_with("SKIPPED") {
        return;
    }
    let readme = common::root().join("examples/09_fsm_mirror/README.md");
    let readme = std::fs::read_to_string(readme).expect("a README");
    let quoted: Vec<&str> = readme.lines().filter_map(|line| line.strip_prefix("> ")).collect();
    let quoted = quoted.join(" ");
    assert!(quoted.starts_with("The model lacks resonance shift"), "{quoted}");
    assert!(message.lines().any(|line| line == quoted), "{message}");
    for file in ["mirror.toml", "response.html", "gap.json", "gap.html", "repaired.fmu"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
    // Half of an integral controller's error on each axis, and a tenth of it below 200 Hz.
    for (band, part) in [("200", 0.1), ("0", 0.5)] {
        let errors = ["integral", "preview"].map(|controller| {
            let begin = format!("tracking, {controller} {band}:");
            let line = message.lines().find(|line| line.starts_with(&begin)).expect("a line");
            ["y1 ", "y2 ", "y3 "].map(|axis| number(line, axis, "um"))
        });
        for (integral, preview) in errors[0].iter().zip(&errors[1]) {
            assert!(*preview < part * integral, "{band}: {errors:?}");
        }
    }
}

#[test]
fn bench() {
    let (folder, message) = run_in_time("05_bench");
    println!("{message}");
    assert!(message.contains("ended in the state safe: the plan has ended"), "{message}");
    assert!(message.contains("The model lacks delay"), "{message}");
    let line =
        message.lines().find(|line| line.contains("delay.delay =")).expect("the delay's line");
    let delay: f64 = number(line, "delay.delay =", "±");
    assert!((delay - 2e-3).abs() < 4e-4, "{line}");
    // The loop, closed by a controller FMU: 10 um of a wave.
    assert_eq!(
        message.matches("ended in the state safe: the plan has ended").count(),
        2,
        "{message}"
    );
    let error = number(&message, "loop.csv: rms error ", "um");
    assert!(error < 0.2, "{error} um of 10 um");
    for file in ["run.parquet", "gap.html", "loop.csv"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn laser_beam_steering() {
    let (folder, message) = run_in_time("10_laser_beam_steering");
    println!("{message}");
    // In parts of the detectors' ranges: the paper has 0.3 and 0.2 % on hardware, for passes in 2 and in 1 s.
    for (what, most) in [
        ("in fmpy, rate 1, PSD 1: rms ", 0.2),
        ("in fmpy, rate 1, PSD 2: rms ", 0.2),
        ("in fmpy, rate 2, PSD 1: rms ", 0.3),
        ("in fmpy, rate 2, PSD 2: rms ", 0.25),
        ("on the bench, rate 1, PSD 1: rms ", 0.3),
        ("on the bench, rate 1, PSD 2: rms ", 0.3),
    ] {
        let error = number(&message, what, "% of its range");
        assert!(error < most, "{what}{error} %");
    }
    assert!(message.contains("ended in the state safe: the plan has ended"), "{message}");
    // The machine's hysteresis is asymmetric, that of the data sheet is not.
    let lacks = message.split("The model lacks ").nth(1).expect("an answer");
    let names = lacks.lines().next().unwrap_or_default();
    assert!(names.contains("asymmetry") && names.contains("hysteresis"), "{names}");
    let errors = |model: &str| {
        let line = message.split(&format!("{model} model: rms error ")).nth(1).expect("errors");
        let line = line.lines().next().unwrap_or_default().to_owned();
        ["x1 ", "y1 ", "x2 ", "y2 "].map(|name| number(&line, name, "um"))
    };
    for (repaired, given) in errors("repaired").into_iter().zip(errors("datasheet")) {
        assert!(repaired < 0.5 * given, "{repaired} um of {given} um");
    }
    for file in ["controller.fmu", "run.csv", "paths.svg", "gap.html", "repaired.toml"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn compare_hysteresis_models() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = run("07_compare_hysteresis_models", folder.path());
    println!("{message}");
    let (rig, rest) = message.split_once("best.toml: written").expect("the rig comes first");
    let (network, stack) = rest.split_once("network.toml: written").expect("then the network");
    // What the README says of the network.
    for (text, figure) in [(network, "0.924 %"), (stack, "0.187 %")] {
        let line = text.lines().find(|line| line.contains("delay, learned-plays"));
        assert!(line.is_none_or(|line| line.contains(figure)), "{line:?}");
        assert!(line.is_some() || stack.contains("SKIPPED"), "{text}");
    }
    assert_eq!(rig.lines().filter(|line| line.trim().starts_with("delay, ")).count(), 15);
    let held_out = number(rig, "log_fast.csv: held out ", "% of range");
    assert!(held_out < 1.2, "the nested loops leave {held_out} %");
    if !stack.contains("SKIPPED") {
        let held_out = number(stack, ".csv: held out ", "% of range");
        assert!(held_out < 0.4, "the measured stack leaves {held_out} %");
    }
    for file in ["best.toml", "page.html", "loop.svg", "models"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}

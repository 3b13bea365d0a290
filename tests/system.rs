//! `piezoloop system`: the example's figures, and what is refused.

use crate::common;

use std::fs;
use std::path::Path;

use common::{json, piezoloop, refuse, succeed};

/// Largest distance of position and reference on an axis, in the second half.
fn largest_error(run: &Path, axis: usize) -> f64 {
    let text = fs::read_to_string(run).expect("a run");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let place =
        |name: &str| names.iter().position(|n| *n == format!("{name}[{axis}]")).expect(name);
    let (reference, position) = (place("reference"), place("position"));
    let rows: Vec<Vec<f64>> =
        lines.map(|l| l.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
    let errors = rows[rows.len() / 2..].iter().map(|row| (row[position] - row[reference]).abs());
    errors.fold(0.0, f64::max)
}

/// Copies the example's files and packs its FMUs.
fn prepared(folder: &Path) {
    for file in ["loop.toml", "reference.csv"] {
        let source = common::root().join("examples/03_system").join(file);
        fs::copy(source, folder.join(file)).expect("the folder is writable");
    }
    succeed(&["pack", "evc", "-o", "plant.fmu"], folder);
    succeed(&["invert", "evc", "-o", "controller.toml"], folder);
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], folder);
}

#[test]
fn toml_ssp_and_separate_processes_give_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    let input = ["--input", "reference.csv", "-o"];
    let run = |file: &str, out: &str, more: &[&str]| {
        let mut all = vec!["system", file];
        all.extend(input);
        all.push(out);
        all.extend(more);
        json(&all, folder)
    };
    let answer = run("loop.toml", "run.csv", &[]);
    assert_eq!(answer["rows"], 25_001);
    assert_eq!(answer["step_s"], 2e-5);
    succeed(&["system", "loop.toml", "--export", "loop.ssp"], folder);
    run("loop.ssp", "ssp.csv", &[]);
    let bytes = |name: &str| fs::read(folder.join(name)).expect("a run");
    assert!(bytes("run.csv") == bytes("ssp.csv"), "the SSP is the TOML");
    if cfg!(unix) {
        run("loop.ssp", "isolated.csv", &["--isolate"]);
        assert!(bytes("run.csv") == bytes("isolated.csv"), "processes change no bit");
    }
    // The loop of two that `simulate` closes is this system.
    let loop_of_two = ["simulate", "--loop", "plant.fmu", "controller.fmu", "--reference"];
    succeed(&[&loop_of_two[..], &["reference.csv", "-o", "two.csv"]].concat(), folder);
    for axis in [1, 2] {
        let error = largest_error(&folder.join("run.csv"), axis);
        println!("axis {axis}: largest error {error} um");
        assert_eq!(error, largest_error(&folder.join("two.csv"), axis));
        let stated = [0.055, 0.091][axis - 1];
        assert!((error - stated).abs() < 0.001, "{error}");
    }
}

/// What a run says of the time that it took, also of one in real time.
#[test]
fn times_of_the_fmus_are_told_and_a_pace_is_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    let begin = std::time::Instant::now();
    let paced =
        ["system", "loop.toml", "--input", "reference.csv", "--stop", "0.25", "--pace", "0.5"];
    let answer = json(&[&paced[..], &["--report", "page.html"]].concat(), folder);
    assert!(begin.elapsed().as_secs_f64() >= 0.5, "0.25 s at half the speed");
    let times = &answer["times"];
    assert_eq!(times["steps"], 12_500);
    let fmus = times["fmus"].as_array().expect("FMUs");
    assert_eq!(fmus.len(), 2);
    for fmu in fmus {
        assert_eq!(fmu["calls"], 12_500, "{fmu}");
        let number = |name: &str| fmu[name].as_f64().expect("a number");
        let counted: u64 = fmu["histogram"]
            .as_array()
            .expect("bins")
            .iter()
            .map(|bin| bin["count"].as_u64().expect("a count"))
            .sum();
        assert!(counted > 0 && fmu["timed"] == counted, "{fmu}");
        assert!(
            number("min_s") <= number("mean_s") && number("mean_s") <= number("max_s"),
            "{fmu}"
        );
        assert!((number("total_s") - 12_500.0 * number("mean_s")).abs() < 1e-12, "{fmu}");
        assert!(number("share_of_real_time") > 0.0, "{fmu}");
    }
    assert!(times["wall_s"].as_f64().is_some_and(|wall| wall >= 0.5), "{times}");
    let page = fs::read_to_string(folder.join("page.html")).expect("a page");
    assert!(page.contains("of real time"), "the page has the times");
    // The picture comes before them, and has every recorded variable with its unit.
    let picture = page.find("Signals over time").expect("the page has the signals");
    assert!(page.find("of real time").is_some_and(|times| picture < times));
    for name in ["reference[1]", "position[1]"] {
        assert!(page.contains(name), "{name} is drawn");
    }
    let message =
        refuse(&["system", "loop.toml", "--input", "reference.csv", "--pace", "0"], folder);
    assert!(message.contains("1 is real time"), "{message}");
}

/// A lag feeds a gain over communication steps of ten internal ones: held, the gain is a step behind;
/// on straight lines only an internal step and the lag's curvature are missing.
#[test]
fn extrapolated_inputs_are_nearer_to_the_truth_than_held_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let gain =
        fs::read_to_string(common::root().join("tests/blueprints/gain.toml")).expect("there");
    let lag = gain.clone() + "\n[[axis.component]]\ntype = \"sensor-lag\"\nbandwidth = 1.6\n";
    fs::write(folder.join("lag.toml"), lag).expect("the folder is writable");
    fs::write(folder.join("gain.toml"), gain).expect("the folder is writable");
    for name in ["lag", "gain"] {
        succeed(&["pack", &format!("{name}.toml"), "-o", &format!("{name}.fmu")], folder);
    }
    let text = "name = \"chain\"\nstep = 1e-2\nstop = 0.5\n[fmus]\nlag = \"lag.fmu\"\ngain = \"gain.fmu\"\n\
        [connections]\n\"gain.command[1]\" = { from = \"lag.position[1]\", convert = false }\n\
        [inputs]\n\"lag.command[1]\" = \"u\"\n\
        [record]\nfirst = \"lag.position[1]\"\nsecond = \"gain.position[1]\"\n";
    fs::write(folder.join("chain.toml"), text).expect("the folder is writable");
    fs::write(folder.join("u.csv"), "time,u\n0,0\n0.1,10\n0.6,10\n").expect("writable");
    let largest = |algorithm: &str| {
        let call = ["system", "chain.toml", "--input", "u.csv", "--stop", "0.5", "-o", "run.csv"];
        succeed(&[&call[..], &["--algorithm", algorithm]].concat(), folder);
        let run = fs::read_to_string(folder.join("run.csv")).expect("a run");
        let rows = run.lines().skip(1).map(|line| {
            let cells: Vec<f64> = line.split(',').map(|c| c.parse().expect("a number")).collect();
            (cells[2] - 2.0 * cells[1]).abs()
        });
        rows.skip(13).fold(0.0, f64::max)
    };
    let (held, straight) = (largest("jacobi"), largest("jacobi-extrapolated"));
    println!("largest error: {held} held, {straight} on straight lines");
    assert!(straight > 0.0 && held > 4.0 * straight, "{held}, {straight}");
    let message = refuse(
        &[
            "system",
            "chain.toml",
            "--input",
            "u.csv",
            "--algorithm",
            "jacobi-extrapolated",
            "--isolate",
        ],
        folder,
    );
    assert!(message.contains("leave out --isolate"), "{message}");
}

#[test]
fn what_cannot_be_run_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    let message = refuse(&["system", "loop.toml"], folder);
    assert!(message.contains("has the inputs reference[1], reference[2]"), "{message}");
    let table = ["system", "loop.toml", "--input", "reference.csv"];
    let message = refuse(&[&table[..], &["-o", "run.mat"]].concat(), folder);
    assert!(message.contains("run.mat: records are written as .csv, .npy, .npz"), "{message}");
    let message = refuse(&[&table[..], &["-o", "reference.csv"]].concat(), folder);
    assert!(
        message.contains("reference.csv cannot be written: this command already uses the file"),
        "{message}"
    );
    let text = fs::read_to_string(folder.join("loop.toml")).expect("the loop");
    fs::write(folder.join("loop.toml"), text.replace("plant.position[2]", "plant.positon[2]"))
        .expect("writable");
    let message = refuse(&table, folder);
    assert!(message.contains("did you mean `position[2]` or"), "{message}");
    fs::write(folder.join("bad.ssp"), b"no archive").expect("writable");
    assert!(refuse(&["system", "bad.ssp"], folder).contains("not a readable zip archive"));
    let help = piezoloop(&["system", "--help"], folder);
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    assert!(help.contains("[connections]") && !help.contains("fmu-worker"), "{help}");
}

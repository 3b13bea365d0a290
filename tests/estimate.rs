//! `piezoloop estimate`: a known truth is found, lies in its intervals as often as they say, and what the
//! logs do not tell is named. The FMU is a small one in C.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::faulty::has_compiler;
use common::random::Random;
use common::{json, refuse, root, succeed};
use serde_json::Value;

/// Gain a·b and time constant of the machine.
const TRUTH: (f64, f64) = (2.5, 0.3);
const ROWS: usize = 200;
const STEP: f64 = 0.05;

/// The FMU of `tests/c/lag.c` in this folder, unpacked.
fn lag(folder: &Path) {
    let platform = if cfg!(target_arch = "x86_64") { "linux64" } else { "aarch64-linux" };
    let binaries = folder.join("lag.fmu/binaries").join(platform);
    fs::create_dir_all(&binaries).expect("a folder");
    let output = Command::new("cc")
        .args(["-std=gnu11", "-O2", "-w", "-shared", "-fPIC", "-o"])
        .args([binaries.join("lag.so"), root().join("tests/c/lag.c")])
        .arg("-lm")
        .output()
        .expect("the C compiler runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let variable = |name: &str, reference: u32, kind: &str, real: &str| {
        format!(
            "<ScalarVariable name=\"{name}\" valueReference=\"{reference}\" {kind}><Real {real}/></ScalarVariable>\n"
        )
    };
    let parameter = "causality=\"parameter\" variability=\"fixed\"";
    let variables = [
        variable("u", 0, "causality=\"input\"", "start=\"0\""),
        variable("y", 1, "causality=\"output\" initial=\"exact\"", "start=\"0\""),
        variable("a", 2, parameter, "start=\"1\""),
        variable("b", 3, parameter, "start=\"1\""),
        variable("tau", 4, parameter, "start=\"1\" min=\"0.001\""),
        variable("idle", 5, parameter, "start=\"0.5\""),
        variable("z", 6, "causality=\"output\"", ""),
    ]
    .concat();
    let text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" modelName=\"lag\" \
         guid=\"lag\">\n<CoSimulation modelIdentifier=\"lag\" canHandleVariableCommunicationStepSize=\"true\"/>\n\
         <ModelVariables>\n{variables}</ModelVariables>\n<ModelStructure><Outputs><Unknown index=\"2\"/>\
         <Unknown index=\"7\"/></Outputs></ModelStructure>\n</fmiModelDescription>\n"
    );
    fs::write(folder.join("lag.fmu/modelDescription.xml"), text).expect("writable");
}

fn command(k: usize, phase: usize) -> f64 {
    [1.0, -0.5, 0.0, 2.0, 1.5][(k / 12 + phase) % 5]
}

/// A log of the machine with noise of y and of z.
fn log(file: &Path, phase: usize, noise: [f64; 2], random: &mut Random) {
    log_from(file, 0.0, phase, noise, random);
}

/// As `log`, of a machine that begins elsewhere than at rest.
fn log_from(file: &Path, begin: f64, phase: usize, noise: [f64; 2], random: &mut Random) {
    let (mut y, mut text) = (begin, "time,u,y,z\n".to_owned());
    for k in 0..ROWS {
        let u = command(k, phase);
        let (y_seen, z_seen) = (y + noise[0] * random.normal(), y * y + noise[1] * random.normal());
        text += &format!("{},{u},{y_seen},{z_seen}\n", k as f64 * STEP);
        y += (TRUTH.0 * u - y) * -f64::exp_m1(-STEP / TRUTH.1);
    }
    fs::write(file, text).expect("writable");
}

fn prepared() -> Option<tempfile::TempDir> {
    if !has_compiler() {
        return None;
    }
    let folder = tempfile::tempdir().expect("a folder");
    lag(folder.path());
    Some(folder)
}

fn found(answer: &Value, name: &str) -> Value {
    let parameters = answer["parameters"].as_array().expect("parameters");
    parameters.iter().find(|p| p["name"] == name).expect(name).clone()
}

fn value(answer: &Value, name: &str) -> f64 {
    found(answer, name)["value"].as_f64().expect("a number")
}

#[test]
fn a_known_truth_is_found_from_several_logs_and_judged_on_another() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    let mut random = Random::new(11);
    for (name, phase, noise) in
        [("a.csv", 0, [0.0; 2]), ("b.csv", 2, [0.0; 2]), ("c.csv", 3, [0.0; 2])]
    {
        log(&at.join(name), phase, noise, &mut random);
    }
    let tunes = ["--tune", "a=1", "--tune", "tau=1,0.01..10"];
    let all = [
        &[
            "estimate",
            "lag.fmu",
            "--log",
            "a.csv",
            "--log",
            "b.csv",
            "--held-out",
            "c.csv",
            "-o",
            "set.ssv",
        ][..],
        &tunes,
    ]
    .concat();
    let answer = json(&all, at);
    assert!((value(&answer, "a") - TRUTH.0).abs() < 1e-9, "{answer:#}");
    assert!((value(&answer, "tau") - TRUTH.1).abs() < 1e-9, "{answer:#}");
    let fits = answer["fits"].as_array().expect("fits");
    assert_eq!(fits.len(), 6, "two outputs of three logs");
    assert_eq!(fits.iter().filter(|fit| fit["held_out"] == true).count(), 2);
    for fit in fits {
        assert!(fit["raw_rmse"].as_f64().is_some_and(|rmse| rmse < 1e-8), "{fit}");
        assert!(fit["rmse_at_start"].as_f64().is_some_and(|rmse| rmse > 0.1), "{fit}");
    }
    // The parameter set is one that `system` takes.
    let set = fs::read_to_string(at.join("set.ssv")).expect("written");
    assert!(set.contains("name=\"tau\"") && set.contains("name=\"a\""), "{set}");
    // In processes of their own the same.
    let isolated = json(&[&all[..], &["--isolate"]].concat(), at);
    assert_eq!(value(&isolated, "tau"), value(&answer, "tau"));
    // One that crosses its own bound is held there, and said so.
    let answer =
        json(&["estimate", "lag.fmu", "--log", "a.csv", "--tune", "a=1,0..2", "--tune", "tau"], at);
    assert_eq!((value(&answer, "a"), found(&answer, "a")["at_bound"].clone()), (2.0, true.into()));
    assert!(answer["notes"].to_string().contains("ends at its bound 2"), "{}", answer["notes"]);
    let page = at.join("page.html").display().to_string();
    succeed(&[&all[..], &["--report", &page]].concat(), at);
    assert!(fs::read_to_string(&page).expect("a page").contains("Parameters of lag"));
}

#[test]
fn every_record_has_initial_values_of_its_own() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    let mut random = Random::new(12);
    for (name, begin, phase) in [("a.csv", 0.7, 0), ("b.csv", -0.4, 2), ("c.csv", 1.1, 3)] {
        log_from(&at.join(name), begin, phase, [0.0; 2], &mut random);
    }
    let answer = json(
        &[
            "estimate",
            "lag.fmu",
            "--log",
            "a.csv",
            "--log",
            "b.csv",
            "--held-out",
            "c.csv",
            "--tune",
            "a=1",
            "--tune",
            "tau=1,0.01..10",
            "--initial",
            "y=0,-2..2",
            "--output",
            "y",
            "-o",
            "set.ssv",
        ],
        at,
    );
    assert!((value(&answer, "a") - TRUTH.0).abs() < 1e-8, "{answer:#}");
    assert!((value(&answer, "tau") - TRUTH.1).abs() < 1e-8, "{answer:#}");
    let own: Vec<(String, f64)> = answer["parameters"]
        .as_array()
        .expect("parameters")
        .iter()
        .filter(|p| p["name"] == "y")
        .map(|p| {
            (p["of"].as_str().unwrap_or_default().to_owned(), p["value"].as_f64().unwrap_or(9.0))
        })
        .collect();
    for ((file, found), (expected, begin)) in own.iter().zip([("a.csv", 0.7), ("b.csv", -0.4)]) {
        assert!(file == expected && (found - begin).abs() < 1e-8, "{own:?}");
    }
    assert_eq!(own.len(), 2, "those of held-out logs are no result");
    for fit in answer["fits"].as_array().expect("fits") {
        assert!(fit["raw_rmse"].as_f64().is_some_and(|rmse| rmse < 1e-7), "{fit}");
    }
    let notes = answer["notes"].to_string();
    assert!(notes.contains("initial values that were fitted to them"), "{notes}");
    let set = fs::read_to_string(at.join("set.ssv")).expect("written");
    assert!(set.contains("name=\"tau\"") && !set.contains("name=\"y\""), "{set}");
    let asked = ["estimate", "lag.fmu", "--log", "a.csv", "--tune", "a", "--initial", "a"];
    assert!(refuse(&asked, at).contains("both a parameter of --tune and a value of --initial"));
    let both = ["estimate", "lag.fmu", "--log", "a.csv", "--held-out", "./a.csv", "--tune", "a"];
    assert!(refuse(&both, at).contains("--held-out ./a.csv: is also a --log"));
}

/// The FMU that is written begins with what was found, for an importer that sets nothing, and after a reset.
#[test]
fn an_fmu_begins_with_what_was_found() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    let mut random = Random::new(13);
    log(&at.join("a.csv"), 0, [0.0; 2], &mut random);
    log(&at.join("c.csv"), 3, [0.0; 2], &mut random);
    let b = TRUTH.0 / 2.0;
    let fixed = format!("b={b}");
    let answer = json(
        &[
            "estimate",
            "lag.fmu",
            "--log",
            "a.csv",
            "--tune",
            "a=1",
            "--tune",
            "tau=1,0.01..10",
            "--start",
            &fixed,
            "--fmu",
            "tuned.fmu",
        ],
        at,
    );
    assert!((value(&answer, "a") - 2.0).abs() < 1e-8, "{answer:#}");
    assert!(answer["fmu"] == "tuned.fmu", "{answer:#}");
    let both = fs::read_to_string(at.join("c.csv")).expect("a log");
    let both = both.replacen("time", "record,time", 1).replace('\n', "\n0,");
    let both = both.trim_end_matches("0,").to_owned();
    let again = both.lines().skip(1).map(|line| format!("1{}\n", &line[1..])).collect::<String>();
    fs::write(at.join("both.csv"), both + &again).expect("writable");
    let run = json(&["simulate", "tuned.fmu", "--log", "both.csv"], at);
    let fits = run["fits"].as_array().expect("fits");
    assert_eq!(fits.len(), 4, "two outputs, two records: {run:#}");
    for fit in fits {
        assert!(fit["raw_rmse"].as_f64().is_some_and(|rmse| rmse < 1e-7), "{fit}");
    }
    // What the importer sets counts, as ever.
    let other = json(&["simulate", "tuned.fmu", "--log", "c.csv", "--start", "a=1"], at);
    assert!(other["fits"][0]["raw_rmse"].as_f64().is_some_and(|rmse| rmse > 0.1), "{other:#}");
    succeed(&["check", "tuned.fmu"], at);
}

#[test]
fn the_truth_lies_in_19_of_20_intervals_also_of_two_outputs_of_different_noise() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    let seed = 20_261_125;
    let (mut random, mut inside, draws) = (Random::new(seed), 0, 200);
    for _ in 0..draws {
        log(&at.join("a.csv"), 0, [0.05, 0.5], &mut random);
        let answer = json(
            &[
                "estimate", "lag.fmu", "--log", "a.csv", "--tune", "a=2", "--tune", "tau=0.5",
                "--starts", "1",
            ],
            at,
        );
        for (name, truth) in [("a", TRUTH.0), ("tau", TRUTH.1)] {
            let interval = &found(&answer, name)["interval"];
            let ends = [0, 1].map(|end| interval[end].as_f64().expect("an end"));
            inside += usize::from((ends[0]..=ends[1]).contains(&truth));
        }
    }
    let share = inside as f64 / (2 * draws) as f64;
    println!("{share} of the intervals hold the truth (seed {seed})");
    assert!((0.93..=0.97).contains(&share), "{share} (seed {seed})");
}

#[test]
fn what_the_logs_do_not_determine_is_named() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    log(&at.join("a.csv"), 0, [0.01, 0.01], &mut Random::new(5));
    let answer = json(
        &[
            "estimate", "lag.fmu", "--log", "a.csv", "--tune", "a=1", "--tune", "b=2", "--tune",
            "tau=1", "--tune", "idle",
        ],
        at,
    );
    let expected = serde_json::json!([["idle"], ["a", "b"]]);
    assert_eq!(answer["undetermined"], expected, "{answer:#}");
    assert!(
        found(&answer, "a")["interval"].is_null() && found(&answer, "tau")["interval"].is_array()
    );
    let product = value(&answer, "a") * value(&answer, "b");
    assert!((product - TRUTH.0).abs() < 0.05, "{product}");
    let notes = answer["notes"].to_string();
    assert!(notes.contains("`idle`") && notes.contains("only together"), "{notes}");
}

#[test]
fn what_is_asked_wrongly_is_refused_with_the_way_out() {
    let Some(folder) = prepared() else { return };
    let at = folder.path();
    log(&at.join("a.csv"), 0, [0.0; 2], &mut Random::new(5));
    fs::write(at.join("other.csv"), "time,u,w\n0,1,1\n1,1,1\n").expect("writable");
    for (log, tune, words) in [
        ("a.csv", "mass=1", "has no variable `mass`"),
        ("a.csv", "a=x", "is no finite number"),
        ("a.csv", "a=1,2..3", "not within the bounds 2 to 3"),
        ("a.csv", "a=1,2", "write bounds as LOW..HIGH"),
        ("a.csv", "tau=-1", "not within the bounds 0.001"),
        ("other.csv", "a=1", "no column measures an output"),
        ("missing.csv", "a=1", "missing.csv"),
    ] {
        let message = refuse(&["estimate", "lag.fmu", "--log", log, "--tune", tune], at);
        assert!(message.contains(words), "{words}: {message}");
    }
    let message =
        refuse(&["estimate", "lag.fmu", "--log", "a.csv", "--tune", "a", "--tune", "a"], at);
    assert!(message.contains("asked for twice"), "{message}");
    let message =
        refuse(&["estimate", "lag.fmu", "--log", "a.csv", "--tune", "a", "-o", "a.csv"], at);
    assert!(
        message.contains("a.csv") && message.contains("this command already uses the file"),
        "{message}"
    );
}

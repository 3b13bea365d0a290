//! A machine, its model as an FMU, and the model repaired by the tool.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::{json, root, succeed};

/// Communication step of the logs in s.
pub(crate) const STEP: f64 = 5e-4;

/// A rich command in V.
fn multisine(t: f64) -> f64 {
    const TONES: [f64; 12] =
        [3.0, 7.0, 13.0, 29.0, 47.0, 71.0, 97.0, 131.0, 173.0, 211.0, 257.0, 293.0];
    let sum: f64 = TONES
        .iter()
        .enumerate()
        .map(|(k, f)| (std::f64::consts::TAU * f * t + 1.7 * (k * k) as f64).sin())
        .sum();
    75.0 + 60.0 * sum / 7.0
}

/// Levels of 0.2 s each, in V.
fn stairs(t: f64) -> f64 {
    const LEVELS: [f64; 10] = [20.0, 60.0, 100.0, 130.0, 90.0, 50.0, 10.0, 40.0, 110.0, 70.0];
    LEVELS[(t / 0.2 + 1e-9) as usize % LEVELS.len()]
}

/// Writes commands of 2 s under the name of an input.
fn commands(file: &Path, input: &str, signal: fn(f64) -> f64) {
    let mut text = format!("time,\"{input}\"\n");
    for k in 0..4000 {
        let t = f64::from(k) * STEP;
        text += &format!("{t},{}\n", signal(t));
    }
    fs::write(file, text).expect("the folder is writable");
}

/// Measures the machine of `tests/blueprints/stage_truth.toml`: `multisine.csv` and `stairs.csv`
/// with the columns time, `u` in V and `x` in um.
pub(crate) fn measure(folder: &Path) {
    measure_of(&truth(), folder);
}

/// As `measure`, of a machine without the mode and with a slow amplifier, for models of a lag.
pub(crate) fn measure_lag(folder: &Path) {
    let truth = truth().replace("bandwidth = 1500", "bandwidth = 200");
    let (head, rest) = truth.split_once("[[axis.component]]\ntype = \"mode\"").expect("a mode");
    let (_, tail) = rest.split_once("[[axis.component]]").expect("noise behind it");
    measure_of(&format!("{head}[[axis.component]]{tail}"), folder);
}

fn truth() -> String {
    let file = root().join("tests/blueprints/stage_truth.toml");
    fs::read_to_string(file).expect("the blueprint")
}

/// As `truth`, of the machine of this blueprint.
pub(crate) fn measure_of(truth: &str, folder: &Path) {
    fs::write(folder.join("truth.toml"), truth).expect("the folder is writable");
    let truth = "truth.toml";
    for (name, signal) in [("multisine", multisine as fn(f64) -> f64), ("stairs", stairs)] {
        let command = folder.join("command.csv");
        commands(&command, "command[1]", signal);
        succeed(&["simulate", truth, "--log", "command.csv", "-o", "run.csv"], folder);
        let run = fs::read_to_string(folder.join("run.csv")).expect("a run");
        let (_, rows) = run.split_once('\n').expect("a header");
        let log = format!("time [s],u [V],x [um]\n{rows}");
        fs::write(folder.join(format!("{name}.csv")), log).expect("the folder is writable");
    }
}

/// Diagnoses `model` against both logs, with `input` and `output` mapped, and repairs it.
pub(crate) fn repair(
    model: &str,
    (input, output): (&str, &str),
    repaired: &str,
    folder: &Path,
) -> Value {
    let (u, y) = (format!("{input}=u"), format!("{output}=x"));
    json(
        &[
            "diagnose",
            "--model",
            model,
            "--log",
            "multisine.csv",
            "--log",
            "stairs.csv",
            "--map",
            &u,
            "--map",
            &y,
            "--noise",
            "0.002",
            "--repair",
            repaired,
        ],
        folder,
    )
}

/// The names of the effects that were found.
pub(crate) fn effects(gap: &Value) -> Vec<&str> {
    let all = gap["effects"].as_array().expect("effects");
    all.iter().filter_map(|e| e["effect"].as_str()).collect()
}

/// Writes `rest.csv`: the machine at rest, with the columns of the other logs.
pub(crate) fn write_rest(folder: &Path) {
    fs::write(folder.join("truth.toml"), truth()).expect("the folder is writable");
    commands(&folder.join("command.csv"), "command[1]", |_| 50.0);
    succeed(&["simulate", "truth.toml", "--log", "command.csv", "-o", "run.csv"], folder);
    let run = fs::read_to_string(folder.join("run.csv")).expect("a run");
    let (_, rows) = run.split_once('\n').expect("a header");
    fs::write(folder.join("rest.csv"), format!("time [s],u [V],x [um]\n{rows}"))
        .expect("the folder is writable");
}

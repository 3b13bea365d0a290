//! A gap in a mode that several outputs share is one cause: it is named once, for all outputs, and the repaired FMU
//! has it.
#![cfg(target_os = "linux")]
#![allow(clippy::print_stdout)]

mod common;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use common::random::Random;
use common::{json, succeed};
use serde_json::Value;

const STEP: f64 = 2.5e-4;
const ROWS: usize = 6000;
/// Standard deviation of the noise in um.
const NOISE: f64 = 0.005;
const SEED: u64 = 401;

/// One mode: frequency in Hz, damping, and what each axis gives to it and sees of it.
#[derive(Clone)]
struct Mode {
    frequency: f64,
    damping: f64,
    gives: Vec<f64>,
    sees: Vec<f64>,
}

/// The structure's stiff part is behind two modes, each of which all axes move.
fn modes(axes: usize, random: &mut Random) -> Vec<Mode> {
    let shape = |random: &mut Random, k: usize| -> Vec<f64> {
        let sign = |j: usize| if k == 1 && j % 2 == 1 { -1.0 } else { 1.0 };
        (0..axes).map(|j| sign(j) * random.between(0.4, 0.8)).collect()
    };
    (0..2)
        .map(|k| {
            let shape = shape(random, k);
            Mode {
                frequency: [random.between(130.0, 200.0), random.between(280.0, 340.0)][k],
                damping: random.between(0.02, 0.04),
                gives: shape.clone(),
                sees: shape,
            }
        })
        .collect()
}

fn blueprint(axes: usize, modes: &[Mode]) -> String {
    let mut text = format!("piezoloop = 1\nkind = \"plant\"\nname = \"mirror\"\nstep = {STEP}\n");
    for k in 1..=axes {
        let _ = write!(
            text,
            "[[axis]]\nname = \"A{k}\"\ncommand = {{ name = \"u{k}\", unit = \"V\", min = 0, max = 150 }}\n\
             position = {{ name = \"y{k}\", unit = \"um\" }}\n[[axis.component]]\ntype = \"prandtl-ishlinskii\"\n\
             r = [0, 15, 30, 45]\nw = [0.06, 0.014, 0.012, 0.012]\n"
        );
    }
    let names: Vec<String> = (1..=axes).map(|k| format!("A{k}")).collect();
    let residue: Vec<f64> = modes
        .iter()
        .flat_map(|m| m.sees.iter().flat_map(|s| m.gives.iter().map(move |g| s * g)))
        .collect();
    let of = |value: fn(&Mode) -> f64| modes.iter().map(value).collect::<Vec<f64>>();
    let direct: Vec<f64> =
        (0..axes * axes).map(|n| if n % (axes + 1) == 0 { 0.3 } else { 0.0 }).collect();
    let _ = write!(
        text,
        "[[coupling]]\ntype = \"modal-matrix\"\nname = \"modes\"\naxes = {names:?}\ndirect = {direct:?}\n\
         frequency = {:?}\ndamping = {:?}\nresidue = {residue:?}\nrate_residue = {:?}\n",
        of(|m| m.frequency),
        of(|m| m.damping),
        vec![0.0; residue.len()]
    );
    text
}

/// Commands of all axes at once: waves up to 450 Hz, or levels.
fn commands(axes: usize, levels: bool, random: &mut Random) -> Vec<Vec<f64>> {
    let mut axis = |_: usize| -> Vec<f64> {
        if levels {
            let all: Vec<f64> = (0..20).map(|_| random.between(20.0, 130.0)).collect();
            return (0..ROWS).map(|n| all[n * 20 / ROWS]).collect();
        }
        let lines: Vec<(f64, f64)> =
            (0..40).map(|k| (450f64.powf(f64::from(k) / 39.0), TAU * random.uniform())).collect();
        let at = |n: usize| {
            lines.iter().map(|(f, p)| (TAU * f * n as f64 * STEP + p).sin()).sum::<f64>()
        };
        (0..ROWS).map(|n| (75.0 + 4.5 * at(n)).clamp(0.0, 150.0)).collect()
    };
    (0..axes).map(&mut axis).collect()
}

/// What the blueprint `truth.toml` answers, with the names of a log and noise.
fn measure(name: &str, commands: &[Vec<f64>], random: &mut Random, folder: &Path) {
    let axes = commands.len();
    let row = |values: Vec<String>| values.join(",") + "\n";
    let header = |names: &[&str]| {
        let of =
            |name: &&str| (1..=axes).map(|k| name.replace('#', &k.to_string())).collect::<Vec<_>>();
        format!("time,{}\n", names.iter().flat_map(of).collect::<Vec<_>>().join(","))
    };
    let mut text = header(&["command[#]"]);
    for n in 0..ROWS {
        let own = commands.iter().map(|u| u[n].to_string());
        text += &row([(n as f64 * STEP).to_string()].into_iter().chain(own).collect());
    }
    fs::write(folder.join("command.csv"), text).expect("the folder is writable");
    succeed(&["simulate", "truth.toml", "--log", "command.csv", "-o", "run.csv"], folder);
    let run = fs::read_to_string(folder.join("run.csv")).expect("a run");
    let mut log = header(&["u#", "y#"]);
    for line in run.lines().skip(1) {
        let cells = line.split(',').enumerate().map(|(k, cell)| match k {
            k if k <= axes => cell.to_owned(),
            _ => (cell.parse::<f64>().expect("a number") + NOISE * random.normal()).to_string(),
        });
        log += &row(cells.collect());
    }
    fs::write(folder.join(format!("{name}.csv")), log).expect("the folder is writable");
}

fn names(axes: usize) -> Vec<String> {
    let of = |k: usize| [format!("command[{k}]=u{k}"), format!("position[{k}]=y{k}")];
    (1..=axes).flat_map(of).flat_map(|map| ["--map".to_owned(), map]).collect()
}

/// Diagnoses the FMU of the model and checks that this effect is named once, for so many outputs, and is in the repaired
/// FMU.
fn is_named_once(
    (axes, outputs): (usize, usize),
    change: impl FnOnce(&mut Vec<Mode>, &mut Random),
    effect: &str,
    most: f64,
) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let mut random = Random(SEED ^ axes as u64);
    let mut all = modes(axes, &mut random);
    fs::write(path.join("model.toml"), blueprint(axes, &all)).expect("the folder is writable");
    change(&mut all, &mut random);
    fs::write(path.join("truth.toml"), blueprint(axes, &all)).expect("the folder is writable");
    succeed(&["pack", "model.toml", "-o", "model.fmu"], path);
    for (name, levels) in [("waves", false), ("levels", true), ("more", false), ("unseen", false)] {
        let commands = commands(axes, levels, &mut random);
        measure(name, &commands, &mut random, path);
    }
    let (names, noise) = (names(axes), NOISE.to_string());
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let call = [
        "diagnose",
        "--model",
        "model.fmu",
        "--log",
        "waves.csv",
        "--log",
        "levels.csv",
        "--log",
        "more.csv",
        "--noise",
        &noise,
        "--tune",
        "*.frequency*=0.01",
        "--tune",
        "*.damping*=0.1",
        "--repair",
        "repaired.fmu",
    ];
    let gap: Value = json(&[&call[..], &names].concat(), path);
    println!("{}", gap["sentence"]);
    let found: Vec<&Value> = gap["effects"].as_array().expect("effects").iter().collect();
    assert_eq!(found.len(), 1, "seed {SEED}: {}", gap["sentence"]);
    assert_eq!(found[0]["effect"], effect, "seed {SEED}: {}", gap["sentence"]);
    let also = found[0]["also"].as_array().expect("the other outputs");
    assert_eq!(also.len() + 1, outputs, "seed {SEED}: {}", gap["sentence"]);
    assert_eq!(found[0]["set"].as_array().map(Vec::len), Some(1), "seed {SEED}: {}", found[0]);
    // On a new record.
    let left = |fmu: &str| -> Vec<f64> {
        let simulated =
            json(&[&["simulate", fmu, "--log", "unseen.csv"][..], &names].concat(), path);
        let fits = simulated["fits"].as_array().expect("fits");
        fits.iter().map(|fit| fit["raw_rmse"].as_f64().expect("rms")).collect()
    };
    let (before, after) = (left("model.fmu"), left("repaired.fmu"));
    println!("{before:?} before, {after:?} after");
    assert_eq!(after.len(), axes);
    for (before, after) in before.iter().zip(&after) {
        let power = |rms: &f64| (rms.powi(2) - NOISE.powi(2)).max(0.0);
        // Up to 0.3 of the noise's power is no error of an output that has none.
        let most = (most * power(before)).max(0.3 * NOISE.powi(2));
        assert!(power(after) < most, "seed {SEED}: {before} before, {after} after");
    }
}

#[test]
fn a_shared_mode_of_another_frequency_is_named_once() {
    for axes in [2, 3] {
        is_named_once((axes, axes), |all, _| all[1].frequency *= 1.09, "resonance_shift", 0.01);
    }
}

#[test]
fn a_shared_mode_that_is_damped_more_is_named_once() {
    for axes in [2, 3] {
        is_named_once((axes, axes), |all, _| all[0].damping *= 2.0, "damping", 0.01);
    }
}

#[test]
fn a_shared_mode_that_the_model_lacks_is_named_once() {
    for axes in [2, 3] {
        let add = |all: &mut Vec<Mode>, random: &mut Random| {
            let shape: Vec<f64> = (0..axes).map(|_| random.between(0.15, 0.3)).collect();
            let frequency = random.between(400.0, 430.0);
            all.push(Mode { frequency, damping: 0.02, gives: shape.clone(), sees: shape });
        };
        is_named_once((axes, axes), add, "extra_mode", 0.15);
    }
}

#[test]
fn a_mode_that_another_command_moves_is_a_coupling_of_one_output() {
    let add = |all: &mut Vec<Mode>, _: &mut Random| {
        let (gives, sees) = (vec![0.0, 0.25], vec![0.25, 0.0]);
        all.push(Mode { frequency: 410.0, damping: 0.03, gives, sees });
    };
    is_named_once((2, 1), add, "cross_coupling", 0.15);
}

//! Effects between the actuator and the mode of an FMU: the mode is taken out behind the FMU, and the
//! effect goes in before it is put in again, in the diagnosis and in the repaired FMU.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;

use common::repaired::{effects, measure_of, repair};
use common::{json, root, succeed};

const NOISE: &str = "\n[[axis.component]]\ntype = \"sensor-noise\"\nrms = 2e-3\n";
const MODE: &str = "[[axis.component]]\ntype = \"mode\"\nname = \"mechanics\"\n";

/// The stage of the other tests, with its mode at a frequency of which there is much in the logs, and
/// an amplifier that is faster than its step.
fn stage() -> String {
    let file = root().join("tests/blueprints/stage.toml");
    let stage = fs::read_to_string(file).expect("the blueprint");
    assert!(stage.contains(MODE), "{stage}");
    let stage = stage.replace("frequency = 600", "frequency = 85");
    stage.replace("damping = 0.1", "damping = 0.05").replace("bandwidth = 1500", "bandwidth = 20e3")
}

/// The machine is `truth`; the FMU of the stage lacks `effect`, and repaired it is much nearer.
fn is_named_and_repaired(truth: &str, effect: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    measure_of(&format!("{truth}{NOISE}"), path);
    fs::write(path.join("stage.toml"), stage()).expect("the folder is writable");
    succeed(&["pack", "stage.toml", "-o", "stage.fmu"], path);
    let gap = repair("stage.fmu", ("command[1]", "position[1]"), "repaired.fmu", path);
    println!("{}", gap["sentence"]);
    assert_eq!(effects(&gap), [effect], "{}", gap["sentence"]);
    let off = |fmu: &str| {
        let files = ["simulate", fmu, "--log", "multisine.csv"];
        let names = ["--map", "command[1]=u", "--map", "position[1]=x"];
        let simulated = json(&[&files[..], &names].concat(), path);
        simulated["fits"][0]["raw_rmse"].as_f64().expect("rms")
    };
    let (before, after) = (off("stage.fmu"), off("repaired.fmu"));
    println!("{before} before, {after} after");
    assert!(after < before / 4.0, "{before} before, {after} after");
}

#[test]
fn clearance_before_the_mode_of_an_fmu() {
    let clearance = "[[axis.component]]\ntype = \"backlash\"\nname = \"play\"\nwidth = 0.04\n\n";
    is_named_and_repaired(&stage().replace(MODE, &format!("{clearance}{MODE}")), "backlash");
}

#[test]
fn clearance_with_a_spring_across_it_before_the_mode_of_an_fmu() {
    let clearance = "[[axis.component]]\ntype = \"backlash\"\nname = \"play\"\nwidth = 0.08\n\
                     bridge = 0.2\n\n";
    is_named_and_repaired(&stage().replace(MODE, &format!("{clearance}{MODE}")), "backlash");
}

#[test]
fn a_stiffening_spring_in_the_mode_of_an_fmu() {
    let spring = "[[axis.component]]\ntype = \"duffing\"\nname = \"mechanics\"\nhardening = 0.002\n\
                  reference = 10\n";
    is_named_and_repaired(&stage().replace(MODE, spring), "duffing");
}

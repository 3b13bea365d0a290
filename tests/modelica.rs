//! modelica/Piezoloop says what the registry says, and compiled by rumoca it moves as our FMUs do.

use crate::common;

use std::path::Path;

use common::{foreign, root};

/// Runs a task of tests/python/modelica.py; `None`: the compiler cannot be had here.
fn run(task: &str) -> Option<String> {
    let python = foreign::environment("modelica")?;
    let folder = tempfile::tempdir().expect("a folder");
    let package = root().join("modelica/Piezoloop");
    let package = package.to_str().expect("a path in UTF-8");
    let tool = Path::new(env!("CARGO_BIN_EXE_piezoloop")).to_str().expect("a path in UTF-8");
    let message = foreign::script(&python, "modelica.py", &[task, tool, package], folder.path());
    print!("{message}");
    Some(message)
}

#[test]
fn names_units_starts_bounds_and_equations_are_those_of_the_registry() {
    let Some(message) = run("text") else { return };
    assert!(message.contains(": as the registry says"), "{message}");
}

/// One line per component, each with its greatest difference; the script fails beyond a bound.
fn moves_as_in_the_fmu(task: &str, one: &str) {
    let Some(message) = run(task) else { return };
    assert!(message.lines().any(|line| line.starts_with(one)), "{message}");
}

#[test]
fn components_of_plants_move_as_in_the_fmu() {
    moves_as_in_the_fmu("plant", "bouc-wen");
}

#[test]
fn couplings_move_as_in_the_fmu() {
    moves_as_in_the_fmu("coupling", "mode-coupling");
}

#[test]
fn components_of_controllers_move_as_in_the_fmu() {
    moves_as_in_the_fmu("controller", "pid");
}

#[test]
fn each_class_has_icon_documentation_and_example_and_two_compilers_take_it() {
    let Some(message) = run("library") else { return };
    assert!(message.contains("each with icon and documentation"), "{message}");
}

#[test]
fn chains_with_pins_and_flanges_keep_their_energy() {
    let Some(message) = run("energy") else { return };
    assert!(message.contains("StageWithFriction, balance"), "{message}");
}

#[test]
fn a_voltage_at_an_input_for_a_position_is_refused() {
    let Some(message) = run("units") else { return };
    assert!(message.contains("incompatible connector types"), "{message}");
}

/// The values are those of the rigs' FMUs: the models are made from them (`text`).
#[test]
fn the_rigs_move_as_their_fmus() {
    let Some(message) = run("rig") else { return };
    assert_eq!(message.lines().filter(|line| line.starts_with("rig ")).count(), 17, "{message}");
}

//! modelica/Piezoloop says what the registry says, and compiled by rumoca it moves as our FMUs do.
#![allow(clippy::print_stdout)]

mod common;

use std::path::Path;

use common::{foreign, root};

/// Runs a task of tests/python/modelica.py; `None`: the compiler cannot be had here.
fn run(task: &str) -> Option<String> {
    let python = foreign::environment("modelica")?;
    let folder = tempfile::tempdir().expect("a folder");
    let package = root().join("modelica/Piezoloop");
    let package = package.to_str().expect("a path in UTF-8");
    let tool = Path::new(env!("CARGO_BIN_EXE_piezoloop")).to_str().expect("a path in UTF-8");
    let said = foreign::script(&python, "modelica.py", &[task, tool, package], folder.path());
    print!("{said}");
    Some(said)
}

#[test]
fn names_units_starts_bounds_and_equations_are_those_of_the_registry() {
    let Some(said) = run("text") else { return };
    assert!(said.contains(": as the registry says"), "{said}");
}

/// One line per component, each with its greatest difference; the script fails beyond a bound.
#[test]
fn components_move_as_in_the_fmu() {
    for (task, one) in [("plant", "bouc-wen"), ("coupling", "mode-coupling"), ("controller", "pid")]
    {
        let Some(said) = run(task) else { return };
        assert!(said.lines().any(|line| line.starts_with(one)), "{said}");
    }
}

#[test]
fn each_class_has_icon_documentation_and_example_and_two_compilers_take_it() {
    let Some(said) = run("library") else { return };
    assert!(said.contains("each with icon and documentation"), "{said}");
}

#[test]
fn chains_with_pins_and_flanges_keep_their_energy() {
    let Some(said) = run("energy") else { return };
    assert!(said.contains("StageWithFriction, balance"), "{said}");
}

#[test]
fn a_voltage_at_an_input_for_a_position_is_refused() {
    let Some(said) = run("units") else { return };
    assert!(said.contains("incompatible connector types"), "{said}");
}

/// The values are those of the rigs' FMUs: the models are made from them (`text`).
#[test]
fn the_rigs_move_as_their_fmus() {
    let Some(said) = run("rig") else { return };
    assert_eq!(said.lines().filter(|line| line.starts_with("rig ")).count(), 17, "{said}");
}

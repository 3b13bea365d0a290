//! docs/blueprints.md: its examples are blueprints and records that the tool takes.

use crate::common;

use std::fs;

use common::{refuse, succeed};

const PAGE: &str = include_str!("../docs/blueprints.md");

/// The page's examples in TOML.
fn examples() -> Vec<&'static str> {
    let blocks = PAGE.split("```toml\n").skip(1);
    blocks.map(|rest| rest.split("```").next().unwrap()).collect()
}

#[test]
fn the_blueprint_of_the_page_is_packed_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("stage.toml"), examples()[0]).unwrap();
    succeed(&["pack", "stage.toml", "-o", "stage.fmu"], folder.path());
    let message = succeed(&["check", "stage.fmu"], folder.path());
    assert!(message.contains("no problem"), "{message}");
}

#[test]
fn the_record_of_the_page_fills_a_component_of_a_blueprint_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("my-stage.toml"), examples()[1]).unwrap();
    let plant = "piezoloop = 1\nkind = \"plant\"\nname = \"stage\"\nstep = \"20 us\"\n[[axis]]\nname = \"X\"\n\
                 command = { name = \"u\", unit = \"V\" }\nposition = { name = \"y\", unit = \"um\" }\n\
                 [[axis.component]]\ntype = \"actuator-gain\"\ngain = 0.1\n\
                 [[axis.component]]\ntype = \"mode\"\nrecord = \"my-stage.toml\"\n";
    fs::write(folder.path().join("stage.toml"), plant).unwrap();
    succeed(&["pack", "stage.toml", "-o", "stage.fmu"], folder.path());
    let wrong = plant.replace("my-stage.toml", "no-stage.toml");
    fs::write(folder.path().join("stage.toml"), wrong).unwrap();
    let message = refuse(&["pack", "stage.toml", "-o", "stage.fmu"], folder.path());
    assert!(message.contains("stage.toml:14") && message.contains("no-stage.toml"), "{message}");
}

#[test]
fn a_connection_of_different_quantities_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = examples()[0].replace("from = \"Y.displacement\"", "from = \"Y.voltage\"");
    fs::write(folder.path().join("stage.toml"), &wrong).unwrap();
    let message = refuse(&["pack", "stage.toml", "-o", "stage.fmu"], folder.path());
    let line = wrong.lines().position(|line| line.starts_with("from =")).unwrap() + 1;
    assert!(message.contains(&format!("stage.toml:{line}")), "{message}");
}

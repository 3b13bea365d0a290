//! A plant and its controller in a closed loop for very many steps: no drift in time or state.
//!
//! `PIEZOLOOP_SOAK=1000000000 cargo test --release --test tool soak:: -- --nocapture` takes so many; with
//! `PIEZOLOOP_SOAK_SOURCES=1` of the C of source FMUs in place of the libraries. Instances live and die
//! `PIEZOLOOP_LIVES` times.
#![cfg(target_os = "linux")]

use crate::common;

use std::process::Command;

use common::packed::{Host, PLANT, Packed, headers, with};
use common::succeed;

/// A controller that is slow enough for the plant.
const SLOW: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/slow.toml");

#[test]
fn a_period_after_very_many_steps_is_the_first_one() {
    let steps = std::env::var("PIEZOLOOP_SOAK").unwrap_or_else(|_| "5000000".to_owned());
    let (plant, controller) = (Packed::new(PLANT, "2"), Packed::new(SLOW, "2"));
    if std::env::var_os("PIEZOLOOP_SOAK_SOURCES").is_some() {
        exchange(PLANT, &plant);
        exchange(SLOW, &controller);
    }
    let mut both = plant.arguments();
    both.extend(controller.arguments());
    let arguments = with(both, &[&controller.reference("enable"), &steps]);
    print!("{}", Host::new("soak.c").run(&arguments));
}

/// Puts the compiled C of a blueprint in the place of a library.
fn exchange(blueprint: &str, packed: &Packed) {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    succeed(&["pack", blueprint, "--fmi", "2", "--sources=only", "-o", "source.fmu"], at);
    let mut zip = zip::ZipArchive::new(std::fs::File::open(at.join("source.fmu")).expect("a file"));
    zip.as_mut().expect("an archive").extract(at).expect("unpacked");
    let mut cc = Command::new("cc");
    cc.args(["-std=c99", "-O2", "-shared", "-fPIC", "-I"]).arg(headers()).arg("-o");
    cc.arg(at.join("source.so")).arg(at.join("sources/fmu.c"));
    assert!(cc.status().expect("a C compiler, cc").success());
    packed.exchange_library(&at.join("source.so"));
}

#[test]
fn lives_of_instances_leave_nothing_behind() {
    let lives = std::env::var("PIEZOLOOP_LIVES").unwrap_or_else(|_| "1000".to_owned());
    let (plant, controller) = (Packed::new(PLANT, "2"), Packed::new(SLOW, "2"));
    let mut both = plant.arguments();
    both.extend(controller.arguments());
    print!("{}", Host::new("lives.c").run(&with(both, &[&lives])));
}

//! What a packed FMU computes, through the C functions: it does not depend on how the time is cut
//! into steps, it comes back from saved states, and no wrong call disturbs it.
#![cfg(target_os = "linux")]
#![allow(clippy::print_stdout)]

mod common;

use common::packed::{CONTROLLER, Host, PLANT, Packed, with};

const BOTH: [&str; 2] = [PLANT, CONTROLLER];

/// Coarse steps in periods: whole ones, fmpy's doublings, and one that no hit falls on.
const COARSE: [&str; 4] = ["16", "80", "3", "41.37"];

#[test]
fn every_partition_of_an_interval_gives_the_same_bits() {
    let host = Host::new("partition.c");
    for blueprint in BOTH {
        let fmu = Packed::new(blueprint, "2");
        for (coarse, seed) in COARSE.into_iter().zip(["11", "12", "13", "14"]) {
            let said = host.run(&with(fmu.arguments(), &[coarse, seed]));
            print!("{}: {said}", fmu.name());
        }
    }
}

#[test]
fn saved_states_come_back_bit_by_bit_also_in_another_process() {
    let host = Host::new("state.c");
    let folder = tempfile::tempdir().expect("a folder");
    for blueprint in BOTH {
        let fmu = Packed::new(blueprint, "2");
        let file = folder.path().join("state");
        let file = file.to_str().expect("UTF-8");
        let first = host.run(&with(fmu.arguments(), &["write", file, "0"]));
        let second = host.run(&with(fmu.arguments(), &["read", file, "5"]));
        assert_eq!(first, second);
        let size = std::fs::metadata(file).expect("the state").len();
        println!("{}: {size} B serialised, the same bits in another process", fmu.name());
    }
}

#[test]
fn a_state_of_another_model_is_refused() {
    let (plant, controller) = (Packed::new(PLANT, "2"), Packed::new(CONTROLLER, "2"));
    let host = Host::new("state.c");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("state");
    let file = file.to_str().expect("UTF-8");
    host.run(&with(plant.arguments(), &["write", file, "0"]));
    let output = host.output(&with(controller.arguments(), &["read", file, "0"]));
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("belongs to another model") && said.contains(plant.guid()), "{said}");
}

/// The seed of the random calls: `PIEZOLOOP_SEED`, else always the same.
fn seed() -> String {
    std::env::var("PIEZOLOOP_SEED").unwrap_or_else(|_| "20".to_owned())
}

/// The further arguments of the hosts with random calls: numbers of variables, seed, rounds, and
/// the numbers of input and output values where arrays have several.
fn random_calls(fmu: &Packed, version: &str, rounds: &str) -> Vec<String> {
    let variables = fmu.package.description().variables.len().to_string();
    let mut arguments = with(fmu.arguments(), &[&variables, &seed(), rounds]);
    if version == "3" {
        let (inputs, outputs) = if fmu.name() == "evc" { ("2", "2") } else { ("4", "6") };
        arguments = with(arguments, &[inputs, outputs]);
    }
    arguments
}

#[test]
fn no_call_of_any_function_crashes_or_leaves_a_trace_after_a_reset() {
    println!("seed {}", seed());
    for (version, source) in [("2", "fuzz2.c"), ("3", "fuzz3.c")] {
        let host = Host::new(source);
        for blueprint in BOTH {
            let fmu = Packed::new(blueprint, version);
            let said = host.run(&random_calls(&fmu, version, "3000"));
            print!("{}, FMI {version}.0, {said}", fmu.name());
        }
    }
}

#[test]
fn valgrind_finds_no_wrong_access_and_no_leak() {
    if std::process::Command::new("valgrind").arg("--version").output().is_err() {
        println!("SKIPPED: no valgrind");
        return;
    }
    for (version, source) in [("2", "fuzz2.c"), ("3", "fuzz3.c")] {
        let host = Host::new(source);
        for blueprint in BOTH {
            let fmu = Packed::new(blueprint, version);
            host.run_under_valgrind(&random_calls(&fmu, version, "60"));
        }
    }
}

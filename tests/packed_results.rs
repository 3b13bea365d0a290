//! What a packed FMU computes, through the C functions: it does not depend on how the time is cut
//! into steps, it comes back from saved states, and no wrong call disturbs it.
#![cfg(target_os = "linux")]

use crate::common;

use common::packed::{CONTROLLER, Host, PLANT, Packed, random_calls, seed, with};

const BOTH: [&str; 2] = [PLANT, CONTROLLER];

/// Coarse steps in periods: whole ones, fmpy's doublings, and one that no hit falls on.
const COARSE: [&str; 4] = ["16", "80", "3", "41.37"];

#[test]
fn every_partition_of_an_interval_gives_the_same_bits() {
    let host = Host::new("partition.c");
    for blueprint in BOTH {
        let fmu = Packed::new(blueprint, "2");
        for (coarse, seed) in COARSE.into_iter().zip(["11", "12", "13", "14"]) {
            let message = host.run(&with(fmu.arguments(), &[coarse, seed]));
            print!("{}: {message}", fmu.name());
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
fn saved_states_of_fmi_3_come_back_bit_by_bit_also_in_another_process() {
    let host = Host::new("state3.c");
    let folder = tempfile::tempdir().expect("a folder");
    for blueprint in BOTH {
        let fmu = Packed::new(blueprint, "3");
        let file = folder.path().join("state");
        let file = file.to_str().expect("UTF-8");
        let counts = fmu.array_values();
        let run = |what| host.run(&with(with(fmu.arguments(), &counts), &[what, file]));
        assert_eq!(run("write"), run("read"), "{}", fmu.name());
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
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(
        message.contains("belongs to another model") && message.contains(plant.guid()),
        "{message}"
    );
}

#[test]
fn no_call_of_any_function_crashes_or_leaves_a_trace_after_a_reset() {
    println!("seed {}", seed());
    for (version, source) in [("2", "fuzz2.c"), ("3", "fuzz3.c")] {
        let host = Host::new(source);
        for blueprint in BOTH {
            let fmu = Packed::new(blueprint, version);
            let message = host.run(&random_calls(&fmu, version, "3000"));
            print!("{}, FMI {version}.0, {message}", fmu.name());
        }
    }
}

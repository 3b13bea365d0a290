//! The emulated instrument of PI: the runner and PI's own client, PIPython, work with it.
#![cfg(unix)]
#![allow(clippy::print_stdout)]

mod common;

use std::path::Path;

use common::bench::{Process, port};
use common::{foreign, json, refuse};

fn instrument(port: u16, folder: &Path) -> Process {
    let gateway = format!("gcs://127.0.0.1:{port}");
    let call = ["bench", "emulate", "p1", "--gateway", &gateway, "--rate", "500"];
    let process = Process::tool(&call, folder);
    assert!(process.first.contains("GCS 2.0"), "{}", process.first);
    process
}

#[test]
fn the_runner_drives_the_instrument_and_its_record_replays() {
    let folder = tempfile::tempdir().unwrap();
    let (here, port) = (folder.path(), port());
    let machine = instrument(port, here);
    let plan = "rate = 50\nsettle = 0.1\napproach = 0.5\npatience = 20\n\
                [[axis]]\ncommand_limits = [0, 3]\ncommand_unit = \"um\"\nposition_unit = \"um\"\n\
                [watch]\nhold = 100\nmax_age = 100\n\
                [[sequence]]\nkind = \"rest\"\nseconds = 1\nat = [2]\n";
    std::fs::write(here.join("plan.toml"), plan).unwrap();
    let gateway = format!("gcs://127.0.0.1:{port}?timeout=2");
    let call =
        ["bench", "run", "--plan", "plan.toml", "--gateway", &gateway, "--record", "run.csv"];
    let answer = json(&call, here);
    assert_eq!(answer["reason"], "the plan has ended", "{answer:#}");
    let said = answer["machine"].as_str().unwrap();
    assert!(
        said.contains("emulated GCS 2.0 controller") && said.contains("MOV, servo on"),
        "{said}"
    );
    let log = data::Log::read(&here.join("run.csv"), &data::ReadOptions::default()).unwrap();
    let greatest = log.column("position[1]").unwrap().values.iter().fold(0.0_f64, |m, y| m.max(*y));
    assert!((1.5..2.5).contains(&greatest), "{greatest} um of 2");
    assert_eq!(json(&["bench", "replay", "run.csv"], here)["different"], 0);
    machine.signal("-TERM");
    let (said, code) = machine.end();
    assert!(code == Some(0) && said.contains("1 connections"), "{said}");

    let message = refuse(&call, here);
    assert!(message.contains("gcs://127.0.0.1") && message.contains("check power"), "{message}");
    let emulate = |more: &[&str]| {
        let all = [&["bench", "emulate", "p1", "--rate", "1k", "--protocol", "gcs"], more].concat();
        refuse(&all, here)
    };
    assert!(emulate(&["--inject", "loss,probability=1"]).contains("has no --inject"));
    assert!(emulate(&["--gateway", "udp://127.0.0.1:9000"]).contains("goes with --gateway gcs://"));
}

#[test]
fn pis_own_client_works_with_the_instrument() {
    let Some(python) = foreign::environment("pipython") else { return };
    let folder = tempfile::tempdir().unwrap();
    let port = port();
    let _machine = instrument(port, folder.path());
    let said = foreign::script(&python, "pi_client.py", &[&port.to_string()], folder.path());
    println!("{said}");
    assert!(said.contains("PIPython"));
}

//! Emulated instruments: the runner works with those of PI and of piezosystem jena, and PI's own client, PIPython,
//! with the first.
#![cfg(unix)]
#![allow(clippy::print_stdout)]

mod common;

use std::path::Path;

use common::bench::{Process, port};
use common::{foreign, json, refuse};

fn instrument(scheme: &str, protocol: &str, port: u16, folder: &Path) -> Process {
    let gateway = format!("{scheme}://127.0.0.1:{port}");
    let call = ["bench", "emulate", "p1", "--gateway", &gateway, "--rate", "500"];
    let process = Process::tool(&call, folder);
    assert!(process.first.contains(protocol), "{}", process.first);
    process
}

#[test]
fn the_runner_drives_instruments_and_the_records_replay() {
    drives("gcs", "GCS 2.0", "emulated GCS 2.0 controller", "MOV, servo on");
    drives("nv200", "NV200", "NV200/D_NET", "closed loop, from -7 to 42");
}

fn drives(scheme: &str, protocol: &str, identity: &str, mode: &str) {
    let folder = tempfile::tempdir().unwrap();
    let (here, port) = (folder.path(), port());
    let machine = instrument(scheme, protocol, port, here);
    let plan = "rate = 50\nsettle = 0.1\napproach = 0.5\npatience = 20\n\
                [[axis]]\ncommand_limits = [0, 3]\ncommand_unit = \"um\"\nposition_unit = \"um\"\n\
                [watch]\nhold = 100\nmax_age = 100\n\
                [[sequence]]\nkind = \"rest\"\nseconds = 1\nat = [2]\n";
    std::fs::write(here.join("plan.toml"), plan).unwrap();
    let gateway = format!("{scheme}://127.0.0.1:{port}?timeout=2");
    let call =
        ["bench", "run", "--plan", "plan.toml", "--gateway", &gateway, "--record", "run.csv"];
    let answer = json(&call, here);
    assert_eq!(answer["reason"], "the plan has ended", "{answer:#}");
    let messages = answer["machine"].as_str().unwrap();
    assert!(messages.contains(identity) && messages.contains(mode), "{messages}");
    let log = data::Log::read(&here.join("run.csv"), &data::ReadOptions::default()).unwrap();
    let greatest = log.column("position[1]").unwrap().values.iter().fold(0.0_f64, |m, y| m.max(*y));
    assert!((1.5..2.5).contains(&greatest), "{greatest} um of 2");
    assert_eq!(json(&["bench", "replay", "run.csv"], here)["different"], 0);
    machine.signal("-TERM");
    let (messages, code) = machine.end();
    assert!(code == Some(0) && messages.contains("1 connections"), "{messages}");

    let message = refuse(&call, here);
    assert!(
        message.contains(&format!("{scheme}://127.0.0.1")) && message.contains("check power"),
        "{message}"
    );
}

#[test]
fn what_an_instrument_has_not_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let emulate = |more: &[&str]| {
        let all = [&["bench", "emulate", "p1", "--rate", "1k", "--protocol", "gcs"], more].concat();
        refuse(&all, here)
    };
    assert!(emulate(&["--inject", "loss,probability=1"]).contains("no --inject"));
    assert!(
        emulate(&["--gateway", "udp://127.0.0.1:9000"])
            .contains("does not go with that --protocol")
    );
}

#[test]
fn pis_own_client_works_with_the_instrument() {
    let Some(python) = foreign::environment("pipython") else { return };
    let folder = tempfile::tempdir().unwrap();
    let port = port();
    let _machine = instrument("gcs", "GCS 2.0", port, folder.path());
    let messages = foreign::script(&python, "pi_client.py", &[&port.to_string()], folder.path());
    println!("{messages}");
    assert!(messages.contains("PIPython"));
}

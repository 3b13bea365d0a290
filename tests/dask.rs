//! Sweeps on Dask: on a cluster of this machine, and across two network namespaces.
#![cfg(unix)]

use crate::common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::{foreign, root, succeed};

/// The plan of a loop whose runs take milliseconds, and the package as an installation has it.
fn prepared(folder: &Path, runs: usize) {
    succeed(&["invert", "evc", "-o", "controller.toml"], folder);
    succeed(&["signal", "p4-ellipse", "--set", "duration=0.1", "-o", "ellipse.csv"], folder);
    let text = format!(
        "runs = {runs}\n[loop]\nplant = \"evc\"\ncontroller = \"controller.toml\"\n\
         reference = \"ellipse.csv\"\nmap = {{ \"reference[1]\" = \"y\", \"reference[2]\" = \"z\" }}\n\
         [vary]\n\"plant.*.mechanics.frequency\" = {{ tolerance = 0.05 }}\n"
    );
    fs::write(folder.join("plan.toml"), text).expect("the folder is writable");
}

fn with_package(command: &mut Command) -> &mut Command {
    command
        .env("PYTHONPATH", root().join("python"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("PIEZOLOOP", env!("CARGO_BIN_EXE_piezoloop"))
}

#[test]
fn a_local_cluster_gives_the_bytes_of_the_local_run_and_survives_a_kill() {
    let Some(python) = foreign::environment("dask") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    prepared(folder.path(), 200);
    let mut run = Command::new(python);
    run.arg(root().join("tests/python/sweep_on_dask.py")).arg("plan.toml");
    let message = foreign::message(with_package(&mut run), folder.path());
    println!("{message}");
    assert!(message.contains("Dask gives the bytes of the local run"), "{message}");
}

#[test]
fn two_hosts_without_a_shared_disk_give_the_bytes_of_one() {
    let Some(python) = foreign::environment("dask") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    prepared(folder.path(), 100);
    let mut run = Command::new("sh");
    run.arg(root().join("tests/python/dask_in_namespaces.sh")).arg(python);
    run.arg(root().join("tests/python/sweep_on_dask.py")).arg("plan.toml");
    let message = foreign::message(with_package(&mut run), folder.path());
    println!("{message}");
    let fine = message.contains("100 runs on 2 workers: the same bytes");
    assert!(fine || message.contains("SKIPPED"), "{message}");
}

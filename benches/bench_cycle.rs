//! What a cycle of the bench costs: a controller FMU of four axes against an emulated machine on
//! loopback, at 10 kHz and at 20 kHz.
//!
//! `cargo bench --bench bench_cycle` prints the runner's own tables. Nothing is asserted about times:
//! they belong to this computer at this moment.
#![allow(clippy::print_stdout)]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

const PLAN: &str = "settle = 0.2\napproach = 0.2\n[watch]\nhold = 2000\nmax_age = 2000\n\
                    [[sequence]]\nkind = \"rest\"\nseconds = 10\n";

fn tool(arguments: &[&str], folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_piezoloop"));
    command.args(arguments).current_dir(folder);
    command
}

fn done(arguments: &[&str], folder: &Path) {
    let output = tool(arguments, folder).output().expect("the tool starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn machine(gateway: &str, rate: &str, folder: &Path) -> Child {
    let arguments = ["bench", "emulate", "p0", "--gateway", gateway, "--rate", rate];
    let mut child = tool(&arguments, folder).stdout(Stdio::piped()).spawn().expect("it starts");
    let mut line = String::new();
    let mut out = BufReader::new(child.stdout.as_mut().expect("a pipe"));
    out.read_line(&mut line).expect("it speaks");
    child
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    std::fs::write(here.join("plan.toml"), PLAN).expect("a plan");
    done(&["invert", "p0", "--period", "1e-4", "-o", "controller.toml"], here);
    done(&["pack", "controller.toml", "-o", "controller.fmu"], here);
    for (rate, port) in [("10k", 9310), ("20k", 9312)] {
        let gateway = format!("udp://127.0.0.1:{port}");
        let mut machine = machine(&gateway, rate, here);
        let arguments = [
            "bench",
            "run",
            "controller.fmu",
            "--plan",
            "plan.toml",
            "--gateway",
            &gateway,
            "--rate",
            rate,
            "--record",
            "run.parquet",
            "--command-limits",
            "-100..100",
        ];
        println!("four axes at {rate}Hz, recorded");
        let status = tool(&arguments, here).status().expect("the tool starts");
        let _ = machine.kill();
        let _ = machine.wait();
        assert!(status.success(), "{status}");
    }
}

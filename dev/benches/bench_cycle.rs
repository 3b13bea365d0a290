//! What a cycle of the bench costs: a controller FMU of four axes against an emulated machine on
//! loopback, a million cycles at 10 kHz and a million at 20 kHz.
//!
//! `cargo bench --bench bench_cycle` prints the runner's own tables (wall time of the work, and
//! processor time of the same); a number behind `--` makes it so many cycles. Nothing is asserted
//! about times: they belong to this computer at this moment.
#![allow(clippy::print_stdout)]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Four axes of a stage rest at a place; samples may be late for a second, for the computer may be
/// loaded, and the run shall reach its end.
fn plan(rate: u32, cycles: u32) -> String {
    let seconds = f64::from(cycles) / f64::from(rate);
    format!(
        "settle = 0.2\napproach = 0.2\n[watch]\nhold = {rate}\nmax_age = {rate}\n\
         [[sequence]]\nkind = \"rest\"\nseconds = {seconds}\n"
    )
}

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
    let heartbeat = ["--heartbeat", "100000"];
    let mut arguments = vec!["bench", "emulate", "p0", "--gateway", gateway, "--rate", rate];
    arguments.extend(heartbeat);
    let mut child = tool(&arguments, folder).stdout(Stdio::piped()).spawn().expect("it starts");
    let mut line = String::new();
    let mut out = BufReader::new(child.stdout.as_mut().expect("a pipe"));
    out.read_line(&mut line).expect("it speaks");
    child
}

fn main() {
    let number = std::env::args().find_map(|argument| argument.parse::<u32>().ok());
    let cycles = number.unwrap_or(1_000_000);
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    done(&["invert", "p0", "--period", "1e-4", "-o", "controller.toml"], here);
    done(&["pack", "controller.toml", "-o", "controller.fmu"], here);
    for (rate, port) in [(10_000, 9310), (20_000, 9312)] {
        std::fs::write(here.join("plan.toml"), plan(rate, cycles)).expect("a plan");
        let gateway = format!("udp://127.0.0.1:{port}");
        let rate = rate.to_string();
        let mut machine = machine(&gateway, &rate, here);
        let arguments = [
            "bench",
            "run",
            "controller.fmu",
            "--plan",
            "plan.toml",
            "--gateway",
            &gateway,
            "--rate",
            &rate,
            "--record",
            "run.parquet",
            "--command-limits",
            "-100..100",
        ];
        println!("four axes at {rate} Hz, {cycles} cycles, recorded");
        let status = tool(&arguments, here).status().expect("the tool starts");
        let _ = machine.kill();
        let _ = machine.wait();
        println!("exit code {:?}\n", status.code());
    }
}

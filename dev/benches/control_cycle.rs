//! What one step of a controller FMU costs: four coordinated axes, each with an inverse of 350 support
//! vectors over 12 inputs and a PID, through the C interface, each step by the thread's own processor
//! time.
//!
//! `cargo bench --bench control_cycle [-- STEPS]` prints the figures, 10 million steps by default.
//! Nothing is asserted about times.
#![allow(clippy::print_stdout)]

use std::process::Command;
use std::time::Instant;

use cosim::{Experiment, Fmu, InstanceOptions, Selection};
use rustix::time::{ClockId, clock_gettime};

#[path = "../../tests/common/four_axes.rs"]
mod four_axes;

/// Processor time of this thread in ns.
fn thread_time() -> i64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

fn main() {
    let steps: usize = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(10_000_000);
    let folder = tempfile::tempdir().expect("a folder");
    four_axes::write(folder.path());
    let packed = Command::new(env!("CARGO_BIN_EXE_piezoloop"))
        .args(["pack", "controller.toml", "-o", "controller.fmu"])
        .current_dir(folder.path())
        .status();
    assert!(packed.expect("the tool starts").success());
    let fmu = Fmu::open(folder.path().join("controller.fmu")).expect("a sound FMU");
    let mut slave = fmu.instantiate("timed", &InstanceOptions::default()).expect("an instance");
    let select = |names: &[&str]| {
        let mut selection = Selection::default();
        for name in names.iter().flat_map(|n| (1..=4).map(move |axis| format!("{n}[{axis}]"))) {
            selection
                .add("timed", fmu.description().variable(&name).expect("a variable"))
                .expect("a number");
        }
        selection
    };
    let (inputs, outputs) = (select(&["reference", "measured"]), select(&["command"]));
    slave.setup(&Experiment { start: 0.0, stop: None, tolerance: None }).expect("set up");
    slave.enter_initialization().expect("initialization");
    slave.exit_initialization().expect("initialization");
    // Histogram of processor times in steps of 10 ns up to 1 ms, and of wall times.
    let mut bins = [vec![0u32; 100_001], vec![0u32; 100_001]];
    let mut greatest = [0i64; 2];
    let mut commands = [0.0; 4];
    for k in 0..steps {
        let phase = 1e-3 * k as f64;
        let values: [f64; 8] =
            std::array::from_fn(|c| 40.0 * (phase * (1.0 + 0.1 * c as f64)).sin());
        let t = 0.005 * k as f64;
        slave.set(&inputs, &values).expect("set");
        let (wall, before) = (Instant::now(), thread_time());
        slave.step(t, 0.005 * (k + 1) as f64 - t).expect("step");
        let took = [thread_time() - before, wall.elapsed().as_nanos() as i64];
        for ((bins, greatest), took) in bins.iter_mut().zip(&mut greatest).zip(took) {
            let last = bins.len() - 1;
            bins[(took.max(0) as usize / 10).min(last)] += 1;
            *greatest = (*greatest).max(took);
        }
        slave.get(&outputs, &mut commands).expect("get");
    }
    println!(
        "{steps} steps of four axes, 350 support vectors over 12 inputs each, last {commands:.3?}"
    );
    for ((name, bins), greatest) in ["thread", "wall"].iter().zip(&bins).zip(greatest) {
        let quantile = |q: f64| {
            let wanted = (q * steps as f64).ceil() as u64;
            let mut sum = 0u64;
            let at = bins.iter().position(|n| {
                sum += u64::from(*n);
                sum >= wanted
            });
            at.unwrap_or(bins.len()) as f64 / 100.0
        };
        println!(
            "{name:>6} time: median {:.2} us, p99 {:.2} us, p99.99 {:.2} us, greatest {:.2} us",
            quantile(0.5),
            quantile(0.99),
            quantile(0.9999),
            greatest as f64 / 1000.0
        );
    }
}

//! How much faster than real time the laser beam steering runs on one core: divan's item throughput is
//! the ratio (one item is one second of the machine).
//!
//! Four axes, internal steps of 0.25 ms, a new command every 5 ms as in the paper: the nominal rig,
//! the truth with its noise, creep, modes and detectors, and the truth without its noise.

use data::Blueprint;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use model::System;

/// Seconds of the machine per sample, and between two commands.
const SECONDS: f64 = 2.0;
const CONTROL: f64 = 5e-3;

fn main() {
    divan::main();
}

fn build(name: &str, without: &[&str]) -> System {
    let rig = piezoloop_rigs::find(name).expect("a rig");
    let mut blueprint = Blueprint::parse(rig.blueprint, rig.name).expect("reads");
    for axis in &mut blueprint.axes {
        axis.components.retain(|c| !without.contains(&c.kind.as_str()));
    }
    blueprint.check(components::COMPONENTS).expect("is sound").build()
}

fn run(bencher: Bencher<'_, '_>, mut system: System) {
    let commands: Vec<u32> = (1..=4)
        .map(|axis| system.variables().find(&format!("command[{axis}]")).expect("an input"))
        .collect();
    let rows = (SECONDS / CONTROL).round() as u32;
    bencher.counter(ItemsCount::new(SECONDS as usize)).bench_local(move || {
        system.reset();
        system.initialise(0.0).expect("rests");
        for row in 0..rows {
            let time = f64::from(row) * CONTROL;
            let u = 75.0 - 75.0 * (3.0 * time).cos() * (0.07 * time).cos();
            for command in &commands {
                system.set(*command, black_box(u)).expect("in range");
            }
            system.advance(time + CONTROL).expect("finite");
        }
        system.get(0)
    });
}

#[divan::bench]
fn nominal(bencher: Bencher<'_, '_>) {
    run(bencher, build("p0", &[]));
}

#[divan::bench]
fn truth(bencher: Bencher<'_, '_>) {
    run(bencher, build("p0-truth", &[]));
}

#[divan::bench]
fn truth_without_noise(bencher: Bencher<'_, '_>) {
    run(bencher, build("p0-truth", &["sensor-noise", "floor-vibration"]));
}

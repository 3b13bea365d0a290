//! Machines without hysteresis, slow and mixed rates, and records that say nothing.

#![allow(clippy::print_stdout, reason = "figures are shown with --nocapture")]

use std::f64::consts::TAU;

use crate::common::target;
use components::COMPONENTS;
use data::{AxisBlueprint, Blueprint, ComponentBlueprint};
use identify::{
    Columns, Error, Identification, Methods, Record, Settings, Silent, identify, simulate,
};
use model::Kind;
use numerics::random::SplitMix64;

/// A record of `rows` rows, `period` s apart, of a machine with these components under two sines.
fn record(components: &[ComponentBlueprint], (rows, period): (usize, f64), noise: f64) -> Record {
    let turns = |k: usize, turns: f64| (TAU * turns * k as f64 / rows as f64).sin();
    let input = (0..rows).map(|k| 50.0 + 25.0 * turns(k, 6.0) + 15.0 * turns(k, 43.0)).collect();
    record_under(components, input, period, noise)
}

/// A record of a machine with these components under this command.
fn record_under(
    components: &[ComponentBlueprint],
    input: Vec<f64>,
    period: f64,
    noise: f64,
) -> Record {
    let rows = input.len();
    let mut axis = AxisBlueprint::new("Y", "V", "um");
    axis.components = components.to_vec();
    let truth = Blueprint::new(Kind::Plant, "truth", 0.05 * period).axis(axis);
    let truth = truth.check(COMPONENTS).unwrap_or_else(|e| panic!("{e}"));
    let time: Vec<f64> = (0..rows).map(|k| k as f64 * period).collect();
    let of = |output: &[f64]| {
        let columns = Columns {
            name: "simulated",
            time: &time,
            input_name: "u",
            input: &input,
            output_name: "y",
            output,
        };
        Record::new(columns).unwrap_or_else(|e| panic!("{e:?}"))
    };
    let mut output = simulate(&truth, &of(&input)).unwrap_or_else(|e| panic!("{e}"));
    let mut random = SplitMix64::new(7);
    println!("seed 7, {rows} rows of {period} s");
    output.iter_mut().for_each(|y| *y += noise * random.normal());
    of(&output)
}

fn found(records: &[Record], methods: Methods, plays: usize) -> Identification {
    let settings = Settings { plays, methods, ..Settings::default() };
    identify(records, &target("found"), &settings, &mut Silent).unwrap_or_else(|e| panic!("{e}"))
}

fn named(name: &str) -> Methods {
    Methods::Named(vec![name.to_owned()])
}

fn component(kind: &str, values: &[(&str, f64)]) -> ComponentBlueprint {
    values.iter().fold(ComponentBlueprint::new(kind), |c, (name, value)| c.value(name, *value))
}

fn plays() -> ComponentBlueprint {
    ComponentBlueprint::new("prandtl-ishlinskii")
        .value("r", [0.0, 6.0, 15.0])
        .value("w", [0.04, 0.015, 0.015])
}

#[test]
fn a_machine_without_hysteresis_gets_gain_lag_and_delay() {
    let machine = [
        component("delay", &[("longest", 0.02), ("delay", 0.003)]),
        component("amplifier-lag", &[("bandwidth", 20.0)]),
        component("actuator-gain", &[("gain", 0.06), ("offset", 1.0)]),
    ];
    let all = found(&[record(&machine, (1500, 1e-3), 0.003)], Methods::Sensible, 8);
    assert_eq!(all.method, "linear", "{:?}", all.candidates.last());
    let value = |name: &str| {
        let found = all.parameters.iter().find(|p| p.name == name);
        found.unwrap_or_else(|| panic!("{name}: {:?}", all.parameters)).value
    };
    assert!((value("gain.gain") / 0.06 - 1.0).abs() < 0.01, "{}", value("gain.gain"));
    assert!((value("amplifier.bandwidth") / 20.0 - 1.0).abs() < 0.05);
    assert!((value("delay.delay") - 0.003).abs() < 3e-4, "{}", value("delay.delay"));
    let kinds: Vec<&str> =
        all.plant.blueprint().axes[0].components.iter().map(|c| c.kind.as_str()).collect();
    assert_eq!(kinds, ["delay", "amplifier-lag", "actuator-gain"]);
}

#[test]
fn hysteresis_is_not_taken_for_a_lag_and_linear_is_had_by_name() {
    let log = [record(&[plays()], (1500, 1e-3), 0.003)];
    assert_eq!(found(&log, Methods::Sensible, 8).method, "prandtl-ishlinskii");
    let linear = found(&log, named("linear"), 8);
    assert_eq!(linear.method, "linear");
    assert!(linear.candidates.iter().any(|c| c.accepted && c.method == Some("linear")));
    // Of those that are named the best is returned, in whatever order they are named.
    for names in [["linear", "prandtl-ishlinskii"], ["prandtl-ishlinskii", "linear"]] {
        let methods = Methods::Named(names.map(str::to_owned).to_vec());
        assert_eq!(found(&log, methods, 8).method, "prandtl-ishlinskii", "{names:?}");
    }
}

/// A broad mode imitates the lag, and the sharp one above it is not seen from there.
#[test]
fn a_mode_above_the_lag_in_front_of_it_is_found() {
    let machine = [
        component("amplifier-lag", &[("bandwidth", 40.0)]),
        component("actuator-gain", &[("gain", 0.12), ("offset", 0.0)]),
        component("mode", &[("frequency", 180.0), ("damping", 0.03)]),
    ];
    let mut random = SplitMix64::new(11);
    let lines: Vec<(f64, f64)> =
        (1..240).map(|line| (f64::from(line), TAU * random.uniform())).collect();
    let (rows, period) = (3000, 5e-4);
    let part = |k: usize, (line, phase): &(f64, f64)| {
        (TAU * line * k as f64 / rows as f64 + phase).sin() / line.sqrt()
    };
    let input = (0..rows).map(|k| 50.0 + 9.0 * lines.iter().map(|l| part(k, l)).sum::<f64>());
    let record = record_under(&machine, input.collect(), period, 0.004);
    let linear = found(&[record], named("linear"), 8);
    let value = |name: &str| {
        let found = linear.parameters.iter().find(|p| p.name == name);
        found.unwrap_or_else(|| panic!("{name}: {:?}", linear.candidates)).value
    };
    assert!((value("amplifier.bandwidth") / 40.0 - 1.0).abs() < 0.02, "{:?}", linear.parameters);
    assert!((value("mode.frequency") / 180.0 - 1.0).abs() < 0.01, "{:?}", linear.parameters);
    assert!((value("mode.damping") / 0.03 - 1.0).abs() < 0.1, "{:?}", linear.parameters);
}

#[test]
fn a_delay_beside_a_gain_states_its_tolerance() {
    let machine = [
        component("delay", &[("longest", 0.02), ("delay", 0.003)]),
        component("actuator-gain", &[("gain", 0.06), ("offset", 1.0)]),
    ];
    let linear = found(&[record(&machine, (1500, 1e-3), 0.003)], named("linear"), 8);
    let delay = &linear.plant.blueprint().axes[0].components[0];
    let tolerance = delay.tolerance.get("delay").unwrap_or_else(|| panic!("{delay:?}"));
    assert!(*tolerance > 0.0 && *tolerance < 0.1, "{tolerance}");
}

#[test]
fn slow_sampling_and_logs_of_several_rates_are_taken() {
    // A row every 4 s: 8 samples are more than a delay may be long.
    let slow = found(&[record(&[plays()], (1200, 4.0), 0.002)], named("prandtl-ishlinskii"), 8);
    assert!(slow.records[0].held_out.nrmse < 0.005, "{:?}", slow.records[0]);
    let lag = component("amplifier-lag", &[("bandwidth", 30.0)]);
    let machine = [lag, plays()];
    for (fast, slower) in [(1e-3, 2e-3), (2e-3, 3e-3)] {
        let logs = [record(&machine, (2000, fast), 0.002), record(&machine, (1500, slower), 0.002)];
        let both = found(&logs, named("prandtl-ishlinskii"), 8);
        for fit in &both.records {
            println!("{fast} and {slower} s: {:.4} %", 100.0 * fit.held_out.nrmse);
            assert!(fit.held_out.nrmse < 0.006, "{fit:?}");
        }
    }
    let odd = [record(&machine, (1500, 1e-3), 0.0), record(&machine, (1500, 1.37e-3), 0.0)];
    let settings = Settings::default();
    let error = identify(&odd, &target("found"), &settings, &mut Silent).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("no whole multiple"), "{error}");
    let learned = Settings { plays: 8, methods: named("gp"), ..Settings::default() };
    let two = [record(&machine, (1500, 1e-3), 0.0), record(&machine, (1500, 2e-3), 0.0)];
    let error = identify(&two, &target("found"), &learned, &mut Silent).map(|_| ()).unwrap_err();
    assert!(matches!(error, Error::NoModel { .. }), "{error}");
    assert!(error.to_string().contains("one rate"), "{error}");
}

//! Loops that reach beyond the first resonance: what is printed of them is true of the machine, and of a thousand others.

#![allow(clippy::print_stdout, reason = "figures and seeds are shown with --nocapture")]

use core::f64::consts::TAU;

use components::COMPONENTS;
use control::{
    ControlSettings, Damping, Feedback, Feedforward, Inversion, LoopFigures, invert, simulate_loop,
};
use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint, SignalBlueprint};
use identify::Silent;
use model::Kind;
use numerics::random::SplitMix64;

/// Sample time, the published resonance in Hz with the damping of a flexure, and the range of frequencies.
const PERIOD: f64 = 2e-5;
const RESONANCE: (f64, f64) = (739.0, 0.01);

fn component(kind: &str, values: &[(&str, f64)]) -> ComponentBlueprint {
    values.iter().fold(ComponentBlueprint::new(kind), |c, (name, value)| c.value(name, *value))
}

fn checked(blueprint: &Blueprint) -> CheckedBlueprint {
    blueprint.check(COMPONENTS).unwrap_or_else(|e| panic!("{e}"))
}

/// A stage of 100 um at 120 V with its mode; `late`: a command acts one period later.
fn stage((frequency, damping): (f64, f64), late: bool) -> CheckedBlueprint {
    let mut axis = AxisBlueprint::new("x", "V", "um");
    axis.command = SignalBlueprint::of_unit("V").between(-20.0, 120.0);
    axis.position = SignalBlueprint::of_unit("um").named("x");
    let delay = if late { PERIOD } else { 0.0 };
    axis.components = vec![
        component("delay", &[("delay", delay)]),
        component("amplifier-lag", &[("bandwidth", 5000.0)]),
        component("actuator-gain", &[("gain", 0.8)]),
        component("mode", &[("frequency", frequency), ("damping", damping)]),
        component("sensor-lag", &[("bandwidth", 10_000.0)]),
    ];
    checked(&Blueprint::new(Kind::Plant, "stage", PERIOD).axis(axis))
}

fn settings(damping: Damping) -> ControlSettings {
    ControlSettings {
        damping,
        sensitivity: 2.0,
        feedforward: Feedforward::None,
        ..ControlSettings::default()
    }
}

fn designed(plant: &CheckedBlueprint, settings: &ControlSettings) -> (Inversion, LoopFigures) {
    let found = invert(plant, settings, &mut Silent).unwrap_or_else(|e| panic!("{e}"));
    let figures = found.axes[0].clone();
    println!("{figures:?}");
    (found, figures)
}

/// Time after which the position stays within 2 % of a step, and the greatest error of the last tenth in parts of it.
fn step(
    plant: &CheckedBlueprint,
    controller: &CheckedBlueprint,
    (from, to): (f64, f64),
    rows: usize,
) -> (f64, f64) {
    let before = rows / 2;
    let axes = plant.spec().axes.len();
    let reference: Vec<f64> = (0..rows).map(|k| if k < before { from } else { to }).collect();
    let run = simulate_loop(plant, controller, &vec![reference; axes], PERIOD)
        .unwrap_or_else(|e| panic!("{e}"));
    let mut worst = (0.0_f64, 0.0_f64);
    for position in &run.position {
        let error = |y: &f64| (y - to).abs() / (to - from).abs();
        let last = position.iter().rposition(|y| error(y) > 0.02 || y.is_nan()).unwrap_or(0);
        let end = position[rows - rows / 10..].iter().map(error).fold(0.0, f64::max);
        worst = (worst.0.max((last + 1 - before) as f64 * PERIOD), worst.1.max(end));
    }
    worst
}

/// Amplitude of the position over that of a small reference at this frequency.
fn gain(plant: &CheckedBlueprint, controller: &CheckedBlueprint, frequency: f64) -> f64 {
    let samples = (40.0 / (frequency * PERIOD)) as usize;
    let wave = |k: usize| 2.0 * (TAU * frequency * k as f64 * PERIOD).sin();
    let reference: Vec<f64> = (0..samples).map(wave).collect();
    let run =
        simulate_loop(plant, controller, &[reference], PERIOD).unwrap_or_else(|e| panic!("{e}"));
    let (mut cosine, mut sine) = (0.0, 0.0);
    let tail = samples / 2..samples;
    for k in tail.clone() {
        let turn = TAU * frequency * k as f64 * PERIOD;
        let y = run.position[0][k];
        (cosine, sine) = (cosine + y * turn.cos(), sine + y * turn.sin());
    }
    2.0 * f64::hypot(cosine, sine) / tail.len() as f64 / 2.0
}

/// Factors of a frequency, 0.9 to 1.1, and of a damping, 1/2 to 2.
fn factors(draw: &mut SplitMix64) -> (f64, f64) {
    (0.9 + 0.2 * draw.uniform(), 4f64.powf(draw.uniform() - 0.5))
}

#[test]
fn the_damped_loop_reaches_beyond_the_resonance_settles_first_and_is_stable_on_1000_plants() {
    let plant = stage(RESONANCE, false);
    let (found, figures) = designed(&plant, &settings(Damping::NonMinimumPhase));
    let damping = figures.damping.clone().expect("an inner loop");
    assert!(damping.closed_loop_bandwidth >= 1.1 * damping.resonance, "{damping:?}");
    assert!(figures.sensitivity <= 2.0 && figures.gain_margin >= 1.9, "{figures:?}");
    let (notch, _) = damping.notch_settling.expect("PI with a notch");
    assert!(damping.settling <= notch / 3.0, "{damping:?}");
    // On the machine itself: the response up to the printed bandwidth, and the step.
    for part in [0.2, 0.5, 0.8, 0.9, 1.0, 1.1] {
        for late in [false, true] {
            let amplitude = gain(&stage(RESONANCE, late), &found.controller, part * RESONANCE.0);
            assert!((0.7..=1.42).contains(&amplitude), "{part} {late}: {amplitude}");
        }
    }
    let (settled, _) = step(&stage(RESONANCE, true), &found.controller, (0.0, 1.0), 2000);
    println!("a step settles in {settled} s, {} s was computed", damping.settling);
    assert!((settled - damping.settling).abs() < 0.25 * damping.settling + 4.0 * PERIOD);
    let mut draw = SplitMix64::new(0x5eed);
    let mut slowest = 0.0_f64;
    for number in 0..1000 {
        let (f, d) = factors(&mut draw);
        let machine = stage((RESONANCE.0 * f, RESONANCE.1 * d), number % 2 == 0);
        let (settled, end) = step(&machine, &found.controller, (0.0, 1.0), 2500);
        assert!(
            end < 0.02,
            "plant {number} (frequency × {f}, damping × {d}) does not settle: {end}"
        );
        slowest = slowest.max(settled);
    }
    println!("1000 of 1000 plants settle, the slowest in {slowest} s");
}

#[test]
fn every_law_damps_and_keeps_its_limits() {
    let plant = stage(RESONANCE, false);
    for law in Damping::LAWS.iter().copied().chain([Damping::Automatic]) {
        let (found, figures) = designed(&plant, &settings(law));
        let damping = figures.damping.clone().expect("an inner loop");
        assert!(figures.sensitivity <= 2.0 && damping.plants == 90, "{damping:?}");
        assert!(damping.noise <= 10.0, "{damping:?}");
        assert!(damping.closed_loop_bandwidth >= 1.1 * damping.resonance, "{damping:?}");
        for late in [false, true] {
            let (_, end) = step(&stage(RESONANCE, late), &found.controller, (0.0, 1.0), 4000);
            assert!(end < 0.02, "{law:?}: {end}");
        }
    }
}

#[test]
fn a_notch_keeps_its_limits_too_and_settles_as_computed() {
    let plant = stage(RESONANCE, false);
    let (found, figures) = designed(&plant, &settings(Damping::Notch));
    let damping = figures.damping.clone().expect("figures of the loop");
    assert!(figures.sensitivity <= 2.0 && damping.gain == 0.0, "{damping:?}");
    let (settled, _) = step(&stage(RESONANCE, true), &found.controller, (0.0, 1.0), 4000);
    assert!((settled / damping.settling - 1.0).abs() < 0.1, "{settled} {damping:?}");
}

#[test]
fn the_truth_rig_is_damped_with_all_its_hysteresis() {
    let rig = rigs::find("p4-machine").expect("a rig");
    let blueprint = Blueprint::parse(rig.blueprint, "p4-machine").expect("a blueprint");
    let plant = checked(&blueprint);
    let (found, _) = designed(&plant, &settings(Damping::NonMinimumPhase));
    for figures in &found.axes {
        let damping = figures.damping.as_ref().expect("an inner loop");
        assert!(damping.closed_loop_bandwidth >= 1.1 * damping.resonance, "{damping:?}");
    }
    let (notch, _) = designed(&plant, &settings(Damping::Notch));
    let settled = |found: &Inversion| step(&plant, &found.controller, (2.5, 3.5), 8000).0;
    let (ours, theirs) = (settled(&found), settled(&notch));
    assert!(3.0 * ours <= theirs, "{ours} {theirs}");
    println!("a step on the rig settles in {ours} s, PI with a notch in {theirs} s");
    let mut draw = SplitMix64::new(0x7e57);
    for number in 0..1000 {
        let mut other = blueprint.clone();
        for axis in &mut other.axes {
            let mode = axis.components.iter_mut().find(|c| c.get("frequency").is_some());
            let mode = mode.expect("a mode");
            let (f, d) = factors(&mut draw);
            let first = if axis.name == "Y" { 482.6 } else { 290.7 };
            mode.set("frequency", first * f);
            mode.set("damping", 0.02 * d);
        }
        let (_, end) = step(&checked(&other), &found.controller, (2.5, 3.5), 4000);
        assert!(end < 0.1, "machine {number}: {end}");
    }
}

#[test]
fn what_cannot_be_damped_is_refused_with_the_way_out() {
    let refused = |plant: &CheckedBlueprint, settings: &ControlSettings| {
        invert(plant, settings, &mut Silent).expect_err("refused").to_string()
    };
    let damped = settings(Damping::NonMinimumPhase);
    let incremental = ControlSettings { feedback: Feedback::IncrementalPid, ..damped.clone() };
    let message = refused(&stage(RESONANCE, false), &incremental);
    assert!(message.contains("--feedback pid or pi"), "{message}");
    let message = refused(&stage((739.0, 0.7), false), &damped);
    assert!(message.contains("no mode") && message.contains("--damping"), "{message}");
    let slow = ControlSettings { period: Some(4e-4), ..damped.clone() };
    let message = refused(&stage(RESONANCE, false), &slow);
    assert!(message.contains("--period of at most"), "{message}");
    let strict = ControlSettings { sensitivity: 1.01, ..damped };
    let message = refused(&stage(RESONANCE, false), &strict);
    assert!(message.contains("--sensitivity"), "{message}");
}

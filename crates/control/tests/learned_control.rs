//! Controllers of learned plants, run on the machine that they were learned from.

#![allow(clippy::print_stdout, reason = "figures and seeds are shown with --nocapture")]

use core::f64::consts::TAU;
use std::sync::OnceLock;

use crate::common::target;
use control::{ControlSettings, Error, Feedforward, Inversion, invert, simulate_loop};
use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint, SignalBlueprint};
use identify::{
    Columns, Dynamics, FeatureChoice, Identification, Learning, Methods, Observer, Record,
    Settings, Silent, identify, simulate,
};
use model::Kind;
use numerics::random::SplitMix64;

const PERIOD: f64 = 1e-3;

fn checked(blueprint: &Blueprint) -> CheckedBlueprint {
    blueprint.check(learned::COMPONENTS).unwrap_or_else(|e| panic!("{e}"))
}

/// Hysteresis of 0 to 100 V behind a delay, and a lag of 25 Hz behind it.
fn truth() -> CheckedBlueprint {
    machine(vec![
        ComponentBlueprint::new("delay").value("longest", 0.01).value("delay", 2.0 * PERIOD),
        hysteresis(),
        ComponentBlueprint::new("sensor-lag").value("bandwidth", 25.0),
    ])
}

fn hysteresis() -> ComponentBlueprint {
    ComponentBlueprint::new("bouc-wen")
        .value("gain", 0.05)
        .value("alpha", 0.4)
        .value("beta", 0.06)
        .value("gamma", 0.02)
        .value("delta", 0.01)
}

fn machine(components: Vec<ComponentBlueprint>) -> CheckedBlueprint {
    let mut axis = AxisBlueprint::new("X", "V", "um");
    axis.command = SignalBlueprint::of_unit("V").named("u").between(0.0, 100.0);
    axis.position = SignalBlueprint::of_unit("um").named("y");
    axis.components = components;
    checked(&Blueprint::new(Kind::Plant, "truth", PERIOD).axis(axis))
}

/// Loops of all sizes of the range, the same in the half that is fitted and in the half that judges.
fn record(truth: &CheckedBlueprint, noise: f64) -> Record {
    let half = 5000;
    let wave = |k: usize| {
        let t = (k % half) as f64 * PERIOD;
        let size = 50.0 * (0.55 + 0.45 * (TAU * 0.2 * t).cos());
        size * (1.0 - (TAU * (1.0 + 0.8 * t) * t).cos())
    };
    let input: Vec<f64> = (0..2 * half).map(wave).collect();
    let time: Vec<f64> = (0..input.len()).map(|k| k as f64 * PERIOD).collect();
    let columns = |output| Columns {
        name: "simulated",
        time: &time,
        input_name: "u",
        input: &input,
        output_name: "y",
        output,
    };
    let record = Record::new(columns(&input)).unwrap_or_else(|e| panic!("{e:?}"));
    let mut output = simulate(truth, &record).unwrap_or_else(|e| panic!("{e}"));
    let mut random = SplitMix64::new(5);
    output.iter_mut().for_each(|y| *y += noise * random.normal());
    Record::new(columns(&output)).unwrap_or_else(|e| panic!("{e:?}"))
}

fn identified(method: &str) -> Identification {
    let settings = Settings {
        plays: 20,
        dynamics: Dynamics::Automatic,
        methods: Methods::Named(vec![method.to_owned()]),
        ..Settings::default()
    };
    identify(&[record(&truth(), 0.002)], &target("found"), &settings, &mut Silent)
        .unwrap_or_else(|e| panic!("{method}: {e}"))
}

/// The machine as stop operators and their lag, learned once for all tests.
fn stops() -> &'static CheckedBlueprint {
    static STOPS: OnceLock<CheckedBlueprint> = OnceLock::new();
    STOPS.get_or_init(|| identified("lssvm-stops").plant)
}

fn feedback_only(found: &Inversion) -> CheckedBlueprint {
    let mut blueprint = found.controller.blueprint().clone();
    blueprint.axes[0].components.retain(|component| component.kind == "pid");
    checked(&blueprint)
}

/// Loops of several sizes at 3 Hz, from rest.
fn reference(from: f64, [low, high]: [f64; 2]) -> Vec<f64> {
    let rise = |x: f64| 0.5 * (1.0 - (0.5 * TAU * x.min(1.0)).cos());
    let at = |k: usize| {
        let t = k as f64 * PERIOD;
        let size = 0.5 * (high - low) * (0.6 + 0.4 * (TAU * 0.3 * t).cos());
        let wave = size * (1.0 - (TAU * 3.0 * (t - 1.0).max(0.0)).cos());
        from + (low - from) * rise(t) + wave
    };
    (0..6000).map(at).collect()
}

fn rms(reference: &[f64], position: &[f64]) -> f64 {
    let errors = reference.iter().zip(position).skip(1500).map(|(r, y)| (r - y).powi(2));
    (errors.sum::<f64>() / (reference.len() - 1500) as f64).sqrt()
}

#[test]
fn the_learned_inverse_beats_feedback_alone_on_the_model_and_on_the_machine() {
    let plant = stops();
    let found =
        invert(plant, &ControlSettings::default(), &mut Silent).unwrap_or_else(|e| panic!("{e}"));
    let figures = &found.axes[0];
    let inverse = figures.inverse.expect("learned");
    println!("{figures:?}");
    assert!(inverse.error < 0.005 && inverse.centres <= 400, "{inverse:?}");
    assert_eq!(found.controller.spec().period, PERIOD);
    let kinds: Vec<_> =
        found.controller.blueprint().axes[0].components.iter().map(|c| c.kind.clone()).collect();
    assert_eq!(kinds, ["reference-lead", "arx", "lssvm-stops-inverse", "pid"]);
    let (low, high) = figures.reach;
    let range = [low + 0.1 * (high - low), high - 0.1 * (high - low)];
    for (name, machine, limit) in [("model", plant, 0.005), ("machine", &truth(), 0.01)] {
        let r = reference(low, range);
        let run = |controller: &CheckedBlueprint| {
            let run = simulate_loop(machine, controller, std::slice::from_ref(&r), PERIOD);
            rms(&r, &run.unwrap_or_else(|e| panic!("{e}")).position[0]) / (range[1] - range[0])
        };
        let (both, alone) = (run(&found.controller), run(&feedback_only(&found)));
        println!("{name}: {:.3} % with the inverse, {:.2} % without", 100.0 * both, 100.0 * alone);
        assert!(both < limit && 5.0 * both < alone, "{name}: {both} {alone}");
    }
}

/// Without delay and lag, as in the paper: the feedforward runs the term that the plant runs.
#[test]
fn a_term_of_positions_is_the_feedforward_without_an_inverse() {
    let truth = machine(vec![hysteresis()]);
    let learning = Learning { features: FeatureChoice::Position, ..Learning::default() };
    let settings = Settings {
        plays: 20,
        dynamics: Dynamics::Static,
        methods: Methods::Named(vec!["lssvm-term".to_owned()]),
        learning,
        ..Settings::default()
    };
    let plant = identify(&[record(&truth, 0.002)], &target("found"), &settings, &mut Silent)
        .unwrap_or_else(|e| panic!("{e}"))
        .plant;
    let settings =
        ControlSettings { feedforward: Feedforward::InverseFree, ..ControlSettings::default() };
    let found = invert(&plant, &settings, &mut Silent).unwrap_or_else(|e| panic!("{e}"));
    let controller = found.controller.blueprint();
    let term = controller.axes[0].components.iter().find(|c| c.kind == "lssvm-feedforward");
    let term = term.unwrap_or_else(|| panic!("no feedforward"));
    let Some(data::Value::Text(file)) = term.get("table") else { panic!("{term:?}") };
    assert_eq!(controller.tables.get(file), plant.blueprint().tables.values().next());
    let (low, high) = found.axes[0].reach;
    let range = [low + 0.2 * (high - low), high - 0.2 * (high - low)];
    let r = reference(low, range);
    let run = |controller: &CheckedBlueprint| {
        let run = simulate_loop(&truth, controller, std::slice::from_ref(&r), PERIOD);
        rms(&r, &run.unwrap_or_else(|e| panic!("{e}")).position[0]) / (range[1] - range[0])
    };
    let (both, alone) = (run(&found.controller), run(&feedback_only(&found)));
    println!("{:.3} % with the term, {:.2} % without", 100.0 * both, 100.0 * alone);
    assert!(both < 0.01 && 2.0 * both < alone, "{both} {alone}");
}

#[test]
fn what_does_not_suit_a_learned_plant_is_refused_with_the_way_out() {
    let plant = stops();
    let refused = |settings: ControlSettings| {
        invert(plant, &settings, &mut Silent).expect_err("refused").to_string()
    };
    let usual = ControlSettings::default;
    let text = refused(ControlSettings { period: Some(5e-4), ..usual() });
    assert!(text.contains("0.001 s") && text.contains("0.0005 s"), "{text}");
    assert!(text.contains("leave --period out"), "{text}");
    let text = refused(ControlSettings { band: Some(200.0), ..usual() });
    assert!(text.contains("up to 100 Hz"), "{text}");
    struct Impatient;
    impl Observer for Impatient {
        fn stopped(&self) -> bool {
            true
        }
    }
    let error = invert(plant, &usual(), &mut Impatient).expect_err("stopped");
    assert_eq!(error, Error::Stopped);
    let operator = identified("prandtl-ishlinskii").plant;
    let error = invert(&operator, &ControlSettings { band: Some(5.0), ..usual() }, &mut Silent);
    assert!(error.expect_err("no use").to_string().contains("band = 5"));
}

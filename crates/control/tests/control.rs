//! Controllers made from plants, run in closed loop with them.

#![allow(clippy::print_stdout, reason = "figures and seeds are shown with --nocapture")]

use crate::common;
use core::f64::consts::TAU;

use components::COMPONENTS;
use control::{CommandActs, ControlSettings, Error, Inversion, invert, simulate_loop};
use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint, SignalBlueprint};
use identify::{Settings, Silent, identify};
use model::Kind;

const R: [f64; 10] = [0.0, 6.0, 12.0, 18.0, 24.0, 30.0, 36.0, 42.0, 48.0, 54.0];
/// Tables 2 and 3 of the elliptical-vibration-cutting paper.
const W_Y: [f64; 10] = [0.01354, 0.0279, 0.0, 0.004014, 0.007765, 0.0, 0.0, 0.0, 0.0, 0.0];
const W_Z: [f64; 10] = [0.02523, 0.04579, 0.0, 0.004541, 0.001636, 0.0, 0.0, 0.0, 0.0, 0.0];
const PERIOD: f64 = 20e-6;

fn checked(blueprint: &Blueprint) -> CheckedBlueprint {
    blueprint.check(COMPONENTS).unwrap_or_else(|e| panic!("{e}"))
}

fn axis(name: &str, components: Vec<ComponentBlueprint>) -> AxisBlueprint {
    let mut axis = AxisBlueprint::new(name, "V", "um");
    axis.command = SignalBlueprint::of_unit("V").named(&format!("u_{name}")).between(0.0, 120.0);
    axis.position = SignalBlueprint::of_unit("um").named(name);
    axis.components = components;
    axis
}

fn plays(w: &[f64]) -> ComponentBlueprint {
    ComponentBlueprint::new("prandtl-ishlinskii").value("r", &R[..w.len()]).value("w", w)
}

fn component(kind: &str, values: &[(&str, f64)]) -> ComponentBlueprint {
    values.iter().fold(ComponentBlueprint::new(kind), |c, (name, value)| c.value(name, *value))
}

fn evc() -> CheckedBlueprint {
    let parts = |w: &[f64], frequency: f64| {
        vec![
            component("amplifier-lag", &[("bandwidth", 3000.0)]),
            plays(w),
            component("mode", &[("frequency", frequency), ("damping", 0.02)]),
            component("sensor-lag", &[("bandwidth", 10_000.0)]),
        ]
    };
    let blueprint = Blueprint::new(Kind::Plant, "evc", PERIOD)
        .axis(axis("y", parts(&W_Y, 482.6)))
        .axis(axis("z", parts(&W_Z, 290.7)));
    checked(&blueprint)
}

fn controller(plant: &CheckedBlueprint, settings: &ControlSettings) -> Inversion {
    let found = invert(plant, settings, &mut Silent).unwrap_or_else(|e| panic!("{e}"));
    for axis in &found.axes {
        println!("{axis:?}");
    }
    found
}

/// The same controller without its feedforward.
fn feedback_only(found: &Inversion) -> CheckedBlueprint {
    let mut blueprint = found.controller.blueprint().clone();
    for axis in &mut blueprint.axes {
        axis.components.retain(|component| component.kind == "pid");
    }
    checked(&blueprint)
}

fn largest_error(reference: &[f64], position: &[f64], from: usize) -> f64 {
    let pairs = reference.iter().zip(position).skip(from);
    pairs.map(|(r, p)| (r - p).abs()).fold(0.0, f64::max)
}

/// Y 1–5 um and Z 1–8 um at 100 Hz, a quarter of a period apart, after a smooth start from rest.
fn ellipse(count: usize) -> Vec<Vec<f64>> {
    let wave = |low: f64, high: f64, phase: f64| {
        (0..count)
            .map(|k| {
                let t = k as f64 * PERIOD;
                let start = (t / 0.02).min(1.0);
                let mid = 0.5 * (low + high);
                start * (mid + 0.5 * (high - low) * (TAU * 100.0 * t + phase).sin())
            })
            .collect()
    };
    vec![wave(1.0, 5.0, 0.0), wave(1.0, 8.0, 0.25 * TAU)]
}

#[test]
fn ellipses_at_100_hz_are_followed_far_better_with_the_inverse_than_by_feedback_alone() {
    let plant = evc();
    let found = controller(&plant, &ControlSettings::default());
    let references = ellipse(10_000);
    let run = |controller| {
        simulate_loop(&plant, controller, &references, PERIOD).unwrap_or_else(|e| panic!("{e}"))
    };
    let (both, feedback) = (run(&found.controller), run(&feedback_only(&found)));
    for (axis, (name, stroke)) in [("y", 4.0), ("z", 7.0)].into_iter().enumerate() {
        let error = |run: &control::LoopRun| {
            largest_error(&references[axis], &run.position[axis], 5000) / stroke
        };
        let (with, without) = (error(&both), error(&feedback));
        println!(
            "{name}: {:.2} % with the inverse, {:.2} % without",
            100.0 * with,
            100.0 * without
        );
        assert!(with < 0.062, "{name}: {with}");
        assert!(3.0 * with < without, "{name}: {with} {without}");
        let commands = &both.command[axis][5000..];
        assert!(commands.iter().all(|u| *u > 0.0 && *u < 120.0), "{name} saturates");
    }
}

#[test]
fn margins_hold_and_a_step_settles_also_with_modes_ten_percent_off() {
    let plant = evc();
    // Without a limit of noise it is the sensitivity that limits the gains.
    let settings = ControlSettings { noise: f64::INFINITY, ..ControlSettings::default() };
    let found = controller(&plant, &settings);
    for axis in &found.axes {
        assert!(axis.sensitivity <= 1.5 && axis.sensitivity > 1.4, "{axis:?}");
        assert!(axis.gain_margin >= 3.0 * 0.99 && axis.phase_margin >= 38.9, "{axis:?}");
    }
    for shift in [0.9, 1.0, 1.1] {
        let mut blueprint = plant.blueprint().clone();
        for (axis, frequency) in blueprint.axes.iter_mut().zip([482.6, 290.7]) {
            axis.components[2].set("frequency", frequency * shift);
        }
        let machine = checked(&blueprint);
        let references: Vec<Vec<f64>> = (0..2)
            .map(|_| (0..60_000).map(|k| if k < 1000 { 2.0 } else { 3.0 }).collect())
            .collect();
        let run = simulate_loop(&machine, &found.controller, &references, PERIOD);
        let run = run.unwrap_or_else(|e| panic!("{e}"));
        for (axis, position) in run.position.iter().enumerate() {
            let left = largest_error(&references[axis], position, 55_000);
            assert!(left < 1e-3, "axis {axis}, modes times {shift}: {left} um left after 1 s");
        }
    }
}

#[test]
fn a_loop_designed_for_commands_that_act_at_once_is_faster_and_keeps_its_margins_there_alone() {
    // A slow sensor behind one play, at 5 ms: a period more is a large part of the loop's delay.
    let parts = vec![
        component("amplifier-lag", &[("bandwidth", 500.0)]),
        plays(&[0.01, 0.005]),
        component("sensor-butterworth", &[("order", 2.0), ("bandwidth", 50.0)]),
    ];
    let plant = checked(&Blueprint::new(Kind::Plant, "filtered", 2.5e-4).axis(axis("X", parts)));
    let of = |acts| {
        let settings = ControlSettings {
            period: Some(5e-3),
            acts,
            noise: f64::INFINITY,
            ..ControlSettings::default()
        };
        controller(&plant, &settings).axes.remove(0)
    };
    let (either, at_once, later) =
        (of(CommandActs::Either), of(CommandActs::AtOnce), of(CommandActs::NextPeriod));
    assert!(at_once.ki > 1.5 * either.ki, "{at_once:?} {either:?}");
    assert!(later.ki >= either.ki, "{later:?} {either:?}");
    for figures in [&either, &at_once, &later] {
        assert!(figures.sensitivity <= 1.5, "{figures:?}");
    }
}

#[test]
fn an_identified_piezo_stack_is_controlled() {
    let Some(folder) = common::data_folder("pea_p885_1hz_inverse_ff") else { return };
    let record = common::record(&folder.join("model_1hz_3v6.csv"), "u", "y");
    let settings = Settings { drop: 2.0, ..Settings::default() };
    let found = identify(&[record], &common::target("p885"), &settings, &mut Silent);
    let plant = found.unwrap_or_else(|e| panic!("{e}")).plant;
    let found = controller(&plant, &ControlSettings::default());
    let (low, high) = found.axes[0].reach;
    let period = plant.spec().period;
    let wave: Vec<f64> = (0..4000)
        .map(|k| low + (high - low) * (0.5 - 0.4 * (TAU * 0.2 * k as f64 * period).cos()))
        .collect();
    let run = simulate_loop(&plant, &found.controller, std::slice::from_ref(&wave), period)
        .unwrap_or_else(|e| panic!("{e}"));
    let stroke = 0.8 * (high - low);
    let error = largest_error(&wave, &run.position[0], 1000) / stroke;
    println!("0.2 Hz over {stroke:.1} um: largest error {:.2} %", 100.0 * error);
    assert!(error < 0.03, "{error}");
}

#[test]
fn feedforward_turns_round_all_static_gains() {
    let parts = vec![
        component("amplifier-lag", &[("bandwidth", 3000.0), ("gain", 10.0)]),
        ComponentBlueprint::new("prandtl-ishlinskii")
            .value("r", R)
            .value("w", W_Y)
            .value("offset", 0.4),
        component("mode", &[("frequency", 482.6), ("damping", 0.5), ("gain", 1.5)]),
    ];
    let mut axis = axis("y", parts);
    axis.command = SignalBlueprint::of_unit("V").between(0.0, 12.0);
    let plant = checked(&Blueprint::new(Kind::Plant, "amplified", PERIOD).axis(axis));
    let found = controller(&plant, &ControlSettings::default());
    // Slow enough that the feedforward alone is right.
    let mut blueprint = found.controller.blueprint().clone();
    for gain in ["kp", "ki", "kd"] {
        let mut components = blueprint.axes[0].components.iter_mut();
        components.find(|c| c.kind == "pid").expect("a pid").set(gain, 0.0);
    }
    let reference: Vec<f64> =
        (0..50_000).map(|k| 3.5 - 1.5 * (TAU * 2.0 * k as f64 * PERIOD).cos()).collect();
    let run = simulate_loop(&plant, &checked(&blueprint), std::slice::from_ref(&reference), PERIOD)
        .unwrap_or_else(|e| panic!("{e}"));
    let error = largest_error(&reference, &run.position[0], 0) / 3.0;
    assert!(error < 0.005, "feedforward alone at 2 Hz: {error}");
}

#[test]
fn a_linear_actuator_gets_a_linear_feedforward() {
    let parts = vec![component("actuator-gain", &[("gain", -0.05), ("offset", 2.0)])];
    let plant = checked(&Blueprint::new(Kind::Plant, "linear", 1e-3).axis(axis("x", parts)));
    let found = controller(&plant, &ControlSettings::default());
    let kinds: Vec<&str> =
        found.controller.blueprint().axes[0].components.iter().map(|c| c.kind.as_str()).collect();
    assert_eq!(kinds, ["feedforward-gain", "pid"]);
    assert!(found.axes[0].ki < 0.0);
    let reference: Vec<f64> = (0..300).map(|k| if k < 10 { 0.0 } else { -2.0 }).collect();
    let run = simulate_loop(&plant, &found.controller, std::slice::from_ref(&reference), 1e-3)
        .unwrap_or_else(|e| panic!("{e}"));
    assert!((run.position[0][299] + 2.0).abs() < 1e-12);
}

#[test]
fn the_controller_may_have_a_period_of_its_own() {
    let settings = ControlSettings { period: Some(1e-4), ..ControlSettings::default() };
    let found = controller(&evc(), &settings);
    assert_eq!(found.controller.spec().period, 1e-4);
    let references: Vec<Vec<f64>> =
        (0..2).map(|_| (0..10_000).map(|k| if k < 100 { 2.0 } else { 3.0 }).collect()).collect();
    let run = simulate_loop(&evc(), &found.controller, &references, 1e-4);
    let run = run.unwrap_or_else(|e| panic!("{e}"));
    for (axis, position) in run.position.iter().enumerate() {
        assert!(largest_error(&references[axis], position, 9000) < 1e-2);
    }
}

#[test]
fn plants_without_an_inverse_are_refused_on_every_axis_with_the_way_out() {
    let first =
        ComponentBlueprint::new("prandtl-ishlinskii").value("r", [2.0, 4.0]).value("w", [0.1, 0.1]);
    let zero =
        ComponentBlueprint::new("prandtl-ishlinskii").value("r", [0.0, 4.0]).value("w", [0.0, 0.1]);
    let mut unbounded = axis("c", vec![plays(&W_Y)]);
    unbounded.command = SignalBlueprint::of_unit("V");
    let blueprint = Blueprint::new(Kind::Plant, "bad", 1e-3)
        .axis(axis("a", vec![first]))
        .axis(axis("b", vec![zero]))
        .axis(unbounded);
    let error = invert(&checked(&blueprint), &ControlSettings::default(), &mut Silent)
        .expect_err("refused");
    let Error::NotInvertible(reasons) = &error else { panic!("{error}") };
    println!("{error}");
    assert_eq!(reasons.len(), 3);
    assert!(reasons[0].reason.contains("hysteresis.r[1] = 2"), "{error}");
    assert!(reasons[1].reason.contains("hysteresis.w[1] = 0"), "{error}");
    assert!(reasons[2].reason.contains("give min and max"), "{error}");
}

#[test]
fn settings_and_controllers_are_refused_with_the_rule() {
    let settings =
        ControlSettings { period: Some(-1.0), sensitivity: 0.9, ..ControlSettings::default() };
    let error = invert(&evc(), &settings, &mut Silent).expect_err("refused").to_string();
    assert!(error.contains("period = -1") && error.contains("sensitivity = 0.9"), "{error}");
    let found = controller(&evc(), &ControlSettings::default());
    let error =
        invert(&found.controller, &ControlSettings::default(), &mut Silent).expect_err("refused");
    assert!(error.to_string().contains("is a controller"), "{error}");
}

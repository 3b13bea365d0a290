//! Axes whose coupling has dynamics: their loop for all together, and the inverse of the dynamics.

use control::{ControlSettings, Feedback, Feedforward, invert, simulate_loop};
use data::{
    AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint, SignalBlueprint, Value,
};
use identify::Silent;
use model::Kind;

const PERIOD: f64 = 2e-4;

/// Two axes with gains 2 and −3 um/V behind these modes (Hz, damping, residues row by row).
fn plant(modes: &[(f64, f64, [f64; 4])]) -> CheckedBlueprint {
    let mut plant = Blueprint::new(Kind::Plant, "mirror", PERIOD);
    for (name, gain) in [("a", 2.0), ("b", -3.0)] {
        let mut axis = AxisBlueprint::new(name, "V", "um");
        axis.command = SignalBlueprint::of_unit("V").between(-5.0, 5.0);
        plant = plant
            .axis(axis.component(ComponentBlueprint::new("actuator-gain").value("gain", gain)));
    }
    let list = |values: Vec<f64>| Value::List(values.into_iter().map(Value::Number).collect());
    let entries = 4 * modes.len();
    let coupling = ComponentBlueprint::new("modal-matrix")
        .value("direct", list(vec![0.0; 4]))
        .value("frequency", list(modes.iter().map(|m| m.0).collect()))
        .value("damping", list(modes.iter().map(|m| m.1).collect()))
        .value("residue", list(modes.iter().flat_map(|m| m.2).collect()))
        .value("rate_residue", list(vec![0.0; entries]));
    plant
        .coupling(&["a", "b"], coupling)
        .check(learned::COMPONENTS)
        .unwrap_or_else(|e| panic!("{e}"))
}

/// A mode of each direction: the two diagonals, of unlike gain.
fn two_modes() -> CheckedBlueprint {
    plant(&[(310.0, 0.01, [0.6, 0.6, 0.6, 0.6]), (430.0, 0.02, [0.5, -0.5, -0.5, 0.5])])
}

fn waves() -> Vec<Vec<f64>> {
    let wave = |frequency: f64, k: usize| {
        let on = (k as f64 / 500.0).min(1.0);
        0.5 * on * (std::f64::consts::TAU * frequency * PERIOD * k as f64).sin()
    };
    vec![(0..5000).map(|k| wave(61.0, k)).collect(), (0..5000).map(|k| wave(97.0, k)).collect()]
}

/// Root mean square of the references, `late` periods before, less the positions.
fn error(plant: &CheckedBlueprint, controller: &CheckedBlueprint, late: usize) -> f64 {
    let references = waves();
    let run = simulate_loop(plant, controller, &references, PERIOD).expect("runs");
    let squares = references
        .iter()
        .zip(&run.position)
        .flat_map(|(r, p)| r.iter().zip(&p[late..]).skip(1000).map(|(r, p)| (r - p) * (r - p)));
    let all: Vec<f64> = squares.collect();
    (all.iter().sum::<f64>() / all.len() as f64).sqrt()
}

#[test]
fn two_coupled_modes_are_followed_with_a_fraction_of_an_integral_controller_s_error() {
    let (plant, other) = (two_modes(), {
        // 1 % off: what it was not designed on.
        plant(&[(313.1, 0.012, [0.6, 0.6, 0.6, 0.6]), (425.7, 0.018, [0.5, -0.5, -0.5, 0.5])])
    });
    let built =
        |settings: ControlSettings| invert(&plant, &settings, &mut Silent).expect("inverted");
    let integral = built(ControlSettings {
        feedback: Feedback::Integral,
        feedforward: Feedforward::None,
        ..ControlSettings::default()
    });
    let notched =
        built(ControlSettings { feedforward: Feedforward::None, ..ControlSettings::default() });
    let complete = built(ControlSettings {
        feedforward: Feedforward::Preview,
        acts: control::CommandActs::AtOnce,
        ..ControlSettings::default()
    });
    for found in [&integral, &notched, &complete] {
        let figures = found.coordinators[0].coupled_loop.as_ref().expect("one loop of both axes");
        assert!(figures.sensitivity <= 1.5 && figures.gain_margin >= 2.9, "{figures:?}");
        for axis in &found.axes {
            assert!(axis.sensitivity <= 1.5 && axis.phase_margin >= 38.9, "{axis:?}");
        }
    }
    // The integral's bandwidth is that which the other's figures name.
    let named = &notched.coordinators[0].coupled_loop.as_ref().expect("figures").integral_bandwidth;
    for (axis, named) in integral.axes.iter().zip(named) {
        assert!((axis.bandwidth / named - 1.0).abs() < 1e-9, "{axis:?} {named}");
    }
    for (one, other) in notched.axes.iter().zip(&integral.axes) {
        assert!(one.bandwidth > 4.0 * other.bandwidth, "{one:?} {other:?}");
    }
    let preview = complete.coordinators[0].preview.clone().expect("a preview");
    let late = (preview.preview / PERIOD).round() as usize;
    for (name, machine) in [("own", &plant), ("other", &other)] {
        let errors = [
            error(machine, &integral.controller, 0),
            error(machine, &notched.controller, 0),
            error(machine, &complete.controller, late),
        ];
        assert!(errors[2] < 0.1 * errors[0] && errors[2] < 0.1 * errors[1], "{name}: {errors:?}");
    }
}

#[test]
fn a_coupling_that_the_jacobian_decouples_exactly_gives_the_loop_of_a_single_mode() {
    // One mode, in the same matrix as the gain at rest: behind the Jacobian both axes have that mode, and nothing else.
    let matrix = [1.0, 0.4, -0.2, 0.8];
    let found = invert(
        &plant(&[(300.0, 0.05, matrix)]),
        &ControlSettings { feedback: Feedback::Integral, ..ControlSettings::default() },
        &mut Silent,
    )
    .expect("inverted");
    // |1 + L| over (0, π) for L = k·T·z⁻²/(1 − z⁻¹)·mode: the axes' gains are alike, and their sensitivity is at its limit.
    let loops: Vec<f64> =
        found.axes.iter().zip([2.0, -3.0]).map(|(axis, gain)| axis.ki * gain).collect();
    assert!((loops[0] / loops[1] - 1.0).abs() < 0.02, "{loops:?}");
    let figures = found.coordinators[0].coupled_loop.clone().expect("figures");
    assert!(figures.sensitivity > 1.45 && figures.sensitivity <= 1.5, "{figures:?}");
    // |S| = 1.5 where L = −1/3: at the resonance, k/ω·1/(2ζ), for the lightest mode 10 % low.
    let near = 2.0 * 0.025 * std::f64::consts::TAU * 270.0 / 3.0;
    assert!((loops[0] / near - 1.0).abs() < 0.15, "{loops:?} {near}");
}

#[test]
fn what_does_not_suit_is_reported() {
    let say = |plant: &CheckedBlueprint, settings: ControlSettings| {
        invert(plant, &settings, &mut Silent).expect_err("refused").to_string()
    };
    let preview =
        ControlSettings { feedforward: Feedforward::Preview, ..ControlSettings::default() };
    let mut alone = Blueprint::new(Kind::Plant, "stage", PERIOD);
    let mut axis = AxisBlueprint::new("a", "V", "um");
    axis.command = SignalBlueprint::of_unit("V").between(-5.0, 5.0);
    alone = alone.axis(axis.component(ComponentBlueprint::new("actuator-gain").value("gain", 2.0)));
    let alone = alone.check(learned::COMPONENTS).unwrap_or_else(|e| panic!("{e}"));
    let message = say(&alone, preview);
    assert!(message.contains("no coupling with dynamics"), "{message}");
}

//! Plants of every kind get a controller that follows on that very plant.

#![allow(clippy::print_stdout, reason = "figures are shown with --nocapture")]

use control::{ControlSettings, Error, Feedback, Feedforward, Inversion, invert, simulate_loop};
use data::{
    AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint, SignalBlueprint, Value,
};
use identify::Silent;
use model::Kind;

const PERIOD: f64 = 1e-3;

fn plant(components: Vec<ComponentBlueprint>) -> CheckedBlueprint {
    checked(&Blueprint::new(Kind::Plant, "machine", PERIOD).axis(axis("x", components)))
}

fn checked(blueprint: &Blueprint) -> CheckedBlueprint {
    blueprint.check(learned::COMPONENTS).unwrap_or_else(|e| panic!("{e}"))
}

fn axis(name: &str, components: Vec<ComponentBlueprint>) -> AxisBlueprint {
    let mut axis = AxisBlueprint::new(name, "V", "um");
    axis.command = SignalBlueprint::of_unit("V").between(0.0, 100.0);
    axis.components = components;
    axis
}

fn component(kind: &str, values: &[(&str, f64)]) -> ComponentBlueprint {
    values.iter().fold(ComponentBlueprint::new(kind), |c, (name, value)| c.value(name, *value))
}

fn plays(kind: &str) -> ComponentBlueprint {
    ComponentBlueprint::new(kind).value("r", [0.0, 8.0, 20.0]).value("w", [0.05, 0.02, 0.01])
}

fn built(plant: &CheckedBlueprint, settings: &ControlSettings) -> Inversion {
    invert(plant, settings, &mut Silent).unwrap_or_else(|e| panic!("{e}"))
}

/// A controller whose loop errs by no more than this part of the reach on its own plant, and its feedforward by no
/// more than that.
fn follows(name: &str, plant: &CheckedBlueprint, looped: f64, alone: f64) -> Inversion {
    let found = built(plant, &ControlSettings::default());
    for axis in &found.axes {
        let check = axis.checks[0];
        println!("{name} {}: {} {check:?}", axis.axis, axis.feedforward);
        assert!(check.closed_loop <= looped, "{name}: {axis:?}");
        assert!(check.feedforward.is_some_and(|error| error <= alone), "{name}: {axis:?}");
        assert!(check.closed_loop <= 1.05 * check.feedback + 1e-4, "{name}: {axis:?}");
        assert!(axis.gain_margin > 2.9 && axis.sensitivity <= 1.5, "{name}: {axis:?}");
    }
    found
}

#[test]
fn every_hysteresis_is_inverted_by_what_its_component_declares() {
    let bouc_wen = |delta: f64| {
        let values =
            [("gain", 0.06), ("alpha", 0.2), ("beta", 0.02), ("gamma", 0.01), ("delta", delta)];
        component("bouc-wen", &values)
    };
    let zones =
        plays("modified-prandtl-ishlinskii").value("edge", [1.0, 3.0]).value("slope", [0.2, -0.2]);
    let envelopes = [
        ("left_a0", 180.0),
        ("left_a1", 0.006),
        ("left_a2", -0.05),
        ("left_a3", 2.0),
        ("right_a0", 200.0),
        ("right_a1", 0.0055),
        ("right_a2", 0.02),
        ("right_a3", 3.0),
    ];
    let generalised =
        envelopes.iter().fold(plays("generalised-play"), |c, (name, value)| c.value(name, *value));
    let grpi = [("a1", 1.0), ("a2", -1e-6), ("b1", 1.0), ("b2", 2e-6)];
    let grpi = grpi.iter().fold(plays("grpi"), |c, (name, value)| c.value(name, *value));
    let mpi = plays("mpi")
        .value("linear", 0.03)
        .value("cubic", 1e-7)
        .value("scale", 1.1)
        .value("rate", 1e-6);
    let dynamic = plays("dynamic-prandtl-ishlinskii")
        .value("alpha", [1e-7, 2e-7, 1e-7, 2e-7])
        .value("beta", [0.0, 0.0, 0.0, 0.0]);
    let cases = [
        ("bouc-wen", bouc_wen(0.0)),
        ("bouc-wen, asymmetric", bouc_wen(0.002)),
        ("modified", zones),
        ("generalised", generalised),
        ("grpi", grpi),
        ("mpi", mpi),
        ("dynamic", dynamic),
        ("rate-dependent", plays("rate-dependent-play").value("gain", 0.02).value("rate", 1e-6)),
        ("duhem", component("duhem", &[("slope", 0.06), ("initial", 0.04), ("decay", 0.05)])),
        ("dahl", component("dahl", &[("gain", 0.06), ("height", 0.4), ("length", 20.0)])),
    ];
    for (name, hysteresis) in cases {
        let machine = plant(vec![hysteresis, component("sensor-lag", &[("bandwidth", 200.0)])]);
        let found = follows(name, &machine, 1e-3, 2e-3);
        assert!(found.axes[0].feedforward.starts_with("inverse-"), "{name}: {:?}", found.axes[0]);
    }
}

#[test]
fn curves_of_amplifier_and_sensor_and_creep_are_inverted_not_dropped() {
    let creep = ComponentBlueprint::new("kelvin-voigt-creep")
        .value("share", [0.03, 0.03])
        .value("time_constant", [0.1, 3.0]);
    let bent = |creep: Option<ComponentBlueprint>| {
        let amplifier = [("quadratic", 0.1), ("centre", 50.0), ("half_range", 50.0)];
        let sensor = [("quadratic", -0.15), ("cubic", 0.03), ("centre", 3.0), ("half_range", 3.5)];
        let parts = [component("amplifier-nonlinearity", &amplifier), plays("prandtl-ishlinskii")];
        let parts = parts.into_iter().chain(creep).chain([component("sensor-polynomial", &sensor)]);
        plant(parts.collect())
    };
    let with = follows("bent, with creep", &bent(Some(creep)), 2e-4, 2e-3);
    let kinds: Vec<&str> =
        with.controller.blueprint().axes[0].components.iter().map(|c| c.kind.as_str()).collect();
    let wanted = [
        "reference-curve",
        "inverse-kelvin-voigt-creep",
        "inverse-prandtl-ishlinskii",
        "command-curve",
        "pid",
    ];
    assert_eq!(kinds, wanted);
    follows("bent", &bent(None), 1e-4, 2e-3);
}

#[test]
fn the_reach_is_that_of_full_swings_however_late_the_position_is() {
    for (delay, bandwidth) in [(0.0, 400.0), (0.02, 400.0), (0.0, 3.0)] {
        let found = built(
            &plant(vec![
                component("delay", &[("longest", 0.02), ("delay", delay)]),
                component("amplifier-lag", &[("bandwidth", bandwidth)]),
                plays("prandtl-ishlinskii"),
            ]),
            &ControlSettings::default(),
        );
        // The plays stand their threshold away from the bound that was visited last.
        let (low, high) = found.axes[0].reach;
        let (least, most) = (0.02 * 8.0 + 0.01 * 20.0, 0.05 * 100.0 + 0.02 * 92.0 + 0.01 * 80.0);
        let off = (low - least).abs().max((high - most).abs());
        assert!(off < 5e-3, "{delay} s, {bandwidth} Hz: {low} to {high}");
    }
}

#[test]
fn hysteresis_without_an_inverse_gets_one_that_is_fitted_to_the_plant() {
    // The printed bimorph's loop curls over at its ends; a skewed play has no inverse in the registry.
    let values = [("gain", 0.06), ("alpha", 0.19), ("beta", 0.2), ("gamma", -0.17)];
    let curled = plant(vec![component("bouc-wen", &values)]);
    let found = follows("curled", &curled, 5e-3, 2e-2);
    assert!(found.axes[0].feedforward.contains("fitted"), "{:?}", found.axes[0]);
    assert!(
        found.axes[0].left_to_feedback.iter().any(|n| n.contains("curls over")),
        "{:?}",
        found.axes[0]
    );
    let skewed = plays("skewed-play")
        .value("skew", [0.0, 0.004, -0.002])
        .value("play_weight", 0.01)
        .value("width", 0.2)
        .value("width_growth", 0.1)
        .value("width_curvature", -0.05)
        .value("centre", 50.0)
        .value("half_range", 60.0);
    follows("skewed", &plant(vec![skewed]), 5e-3, 2e-2);
}

#[test]
fn margins_are_those_of_the_loop_with_every_component_at_once_and_a_period_late() {
    // A filter of the sensor of 40 Hz, and a light mode just below half the sample rate, that only a loop
    // without a period of computing excites.
    let parts = |filter: bool| {
        let filter = filter
            .then(|| component("sensor-butterworth", &[("bandwidth", 10.0)]).value("order", 2.0));
        let all = [
            component("actuator-gain", &[("gain", 0.35)]),
            component("mode", &[("frequency", 420.0), ("damping", 0.02)]),
        ];
        plant(all.into_iter().chain(filter).collect())
    };
    let (with, without) = (
        follows("filtered", &parts(true), 1e-3, 5e-3),
        follows("plain", &parts(false), 1e-3, 5e-3),
    );
    assert!(with.axes[0].delay > without.axes[0].delay + 0.02, "{:?}", with.axes[0]);
}

fn mirror(coupling: ComponentBlueprint, motion: &str) -> CheckedBlueprint {
    let mut blueprint = Blueprint::new(Kind::Plant, "mirrors", PERIOD);
    for name in ["a", "b"] {
        let mut axis = axis(
            name,
            vec![
                ComponentBlueprint::new("prandtl-ishlinskii")
                    .value("r", [0.0, 20.0])
                    .value("w", [0.006, 0.003]),
                component("sensor-lag", &[("bandwidth", 100.0)]),
            ],
        );
        axis.motion.unit = motion.to_owned();
        blueprint = blueprint.axis(axis);
    }
    checked(&blueprint.coupling(&["a", "b"], coupling))
}

fn matrix(rows: [[f64; 2]; 2]) -> Value {
    Value::List(rows.iter().map(|row| Value::from(&row[..])).collect())
}

#[test]
fn axes_that_optics_couple_get_the_coordinator() {
    let optics = ComponentBlueprint::new("optics-jacobian")
        .value("matrix", matrix([[500.0, 3.0], [14.0, -515.0]]))
        .value("offset", [-261.0, 272.0]);
    let found = follows("optics", &mirror(optics, "1"), 1e-4, 1e-3);
    let coupling = &found.controller.blueprint().couplings[0];
    assert_eq!(coupling.component.kind, "jacobian-coordinator");
    assert_eq!(coupling.component.get("matrix"), Some(&matrix([[500.0, 3.0], [14.0, -515.0]])));
    assert!(
        found.coordinators[0].note.is_empty() && found.coordinators[0].condition < 1.1,
        "{found:?}"
    );
    // What is printed as reach may be used by both at once.
    let axes = &found.axes;
    let ends: Vec<Vec<f64>> = axes
        .iter()
        .enumerate()
        .map(|(i, axis)| {
            let (low, high) = axis.reach;
            (0..8000).map(|k| if (k / (1000 << i)) % 2 == 0 { low } else { high }).collect()
        })
        .collect();
    let machine = mirror(
        ComponentBlueprint::new("optics-jacobian")
            .value("matrix", matrix([[500.0, 3.0], [14.0, -515.0]]))
            .value("offset", [-261.0, 272.0]),
        "1",
    );
    let run =
        simulate_loop(&machine, &found.controller, &ends, PERIOD).unwrap_or_else(|e| panic!("{e}"));
    for (reference, position) in ends.iter().zip(&run.position) {
        for k in (999..8000).step_by(1000) {
            assert!(
                (reference[k] - position[k]).abs() < 0.5,
                "row {k}: {} {}",
                reference[k],
                position[k]
            );
        }
    }
}

#[test]
fn other_couplings_are_decoupled_at_rest_and_what_remains_is_reported() {
    let cross = ComponentBlueprint::new("displacement-coupling")
        .value("matrix", matrix([[0.0, 0.1], [-0.2, 0.0]]));
    let found = follows("displacement", &mirror(cross, ""), 1e-4, 1e-3);
    assert!(found.coordinators[0].note.is_empty(), "{found:?}");
    let modes = ComponentBlueprint::new("mode-coupling")
        .value("matrix", matrix([[0.0, 0.0005], [0.0008, 0.0]]))
        .value("frequency", [300.0, 250.0])
        .value("damping", [0.1, 0.1]);
    let found = follows("mode", &mirror(modes, ""), 1e-3, 1e-2);
    assert!(found.coordinators[0].note.contains("dynamics between axes remain"), "{found:?}");
}

#[test]
fn any_period_is_answered_soon() {
    let machine = plant(vec![
        plays("prandtl-ishlinskii"),
        component("mode", &[("frequency", 300.0), ("damping", 0.05)]),
    ]);
    for period in [1e-6, 1.0, 1e6] {
        let started = std::time::Instant::now();
        let settings = ControlSettings { period: Some(period), ..ControlSettings::default() };
        let found = built(&machine, &settings);
        assert!(found.axes[0].checks[0].closed_loop < 1e-2, "{period} s: {:?}", found.axes[0]);
        assert!(started.elapsed().as_secs() < 60, "{period} s took {:?}", started.elapsed());
    }
}

#[test]
fn ways_and_laws_can_be_chosen_and_what_is_worse_is_refused() {
    let values = [("gain", 0.06), ("alpha", 0.2), ("beta", 0.02), ("gamma", 0.01)];
    let machine = plant(vec![component("bouc-wen", &values)]);
    let with = |feedforward, feedback| {
        let settings = ControlSettings { feedforward, feedback, ..ControlSettings::default() };
        built(&machine, &settings)
    };
    let free = with(Feedforward::InverseFree, Feedback::Pi);
    assert!(free.axes[0].feedforward.starts_with("bouc-wen-feedforward"), "{:?}", free.axes[0]);
    assert!(free.axes[0].kd == 0.0, "{:?}", free.axes[0]);
    let incremental = with(Feedforward::Linear, Feedback::IncrementalPid);
    let kinds: Vec<&str> = incremental.controller.blueprint().axes[0]
        .components
        .iter()
        .map(|c| c.kind.as_str())
        .collect();
    assert_eq!(kinds, ["feedforward-gain", "incremental-pid"]);
    let alone = with(Feedforward::Inverse, Feedback::None);
    assert_eq!(alone.axes[0].ki, 0.0);
    let back = with(Feedforward::None, Feedback::Pid);
    assert!(back.axes[0].checks[0].feedforward.is_none(), "{:?}", back.axes[0]);
    // A straight actuator has no model to run beside it.
    let straight = plant(vec![component("actuator-gain", &[("gain", 0.1)])]);
    let settings =
        ControlSettings { feedforward: Feedforward::InverseFree, ..ControlSettings::default() };
    let error = invert(&straight, &settings, &mut Silent).expect_err("refused");
    assert!(matches!(&error, Error::NotInvertible(_)), "{error}");
    assert!(error.to_string().contains("inverse-free"), "{error}");
    // The reason says nothing of what is left to feedback anyway.
    let noisy = vec![plays("prandtl-ishlinskii"), component("sensor-noise", &[("rms", 0.01)])];
    let error = invert(&plant(noisy), &settings, &mut Silent).expect_err("refused").to_string();
    assert!(
        error.contains("inverse-free") && !error.contains("moves without a command"),
        "{error}"
    );
}

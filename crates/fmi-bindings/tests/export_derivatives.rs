//! Directional derivatives, against closed forms and against steps done again.

use std::ptr::null_mut;

use crate::support::components::PERIOD;
use crate::support::{Factory, Fmu, Random, plant, plays_plant, stairs_plant};
use fmi_bindings::fmi2::*;

/// The derivative of one output by one known; the call must succeed.
fn slope(fmu: &Fmu, unknown: &str, known: &str, seed: f64) -> f64 {
    let (status, values) = fmu.derivative(&[unknown], &[known], &[seed]);
    assert_eq!(status, fmi2OK, "{unknown} by {known}: {:?}", fmu.messages());
    values[0]
}

fn near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance * wanted.abs(), "{found} instead of {wanted}");
}

#[test]
fn after_a_step_it_is_that_of_the_step() {
    // The lag over n hits of the ratio a: y = (1 − a)^n·x + gain·(1 − (1 − a)^n)·u.
    let a: f64 = PERIOD / 0.01;
    for hits in [1, 2, 7, 40] {
        let fmu = Fmu::ready(plant);
        fmu.set_real("command[1]", 3.0);
        assert_eq!(fmu.step(0.0, 5.0 * PERIOD), fmi2OK);
        fmu.set_real("command[1]", 7.0);
        assert_eq!(fmu.step(5.0 * PERIOD, f64::from(hits) * PERIOD), fmi2OK);
        let position = fmu.real("position[1]");
        let wanted = 2.0 * (1.0 - (1.0 - a).powi(hits));
        near(slope(&fmu, "position[1]", "command[1]", 1.0), wanted, 1e-10);
        near(slope(&fmu, "position[1]", "command[1]", -1e9), -1e9 * wanted, 1e-10);
        assert_eq!(slope(&fmu, "position[1]", "command[2]", 1.0), 0.0, "axes are not coupled");
        assert_eq!(slope(&fmu, "position[1]", "command[1]", 0.0), 0.0);
        assert_eq!(fmu.real("position[1]").to_bits(), position.to_bits());
    }
}

#[test]
fn a_step_without_an_internal_hit_has_none() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("command[1]", 3.0);
    assert_eq!(fmu.step(0.0, 0.75 * PERIOD), fmi2OK);
    assert_eq!(slope(&fmu, "position[1]", "command[1]", 1.0), 0.0);
    assert_eq!(fmu.step(0.75 * PERIOD, 0.25 * PERIOD), fmi2OK);
    near(slope(&fmu, "position[1]", "command[1]", 1.0), 0.2, 1e-10);
}

#[test]
fn several_outputs_in_a_direction_of_several_inputs() {
    let fmu = Fmu::ready(plant);
    fmu.step(0.0, PERIOD);
    let knowns = ["command[1]", "command[2]"];
    let (status, values) = fmu.derivative(&["position[2]", "position[1]"], &knowns, &[3.0, -2.0]);
    assert_eq!(status, fmi2OK);
    near(values[0], -2.0 * 0.5, 1e-10);
    near(values[1], 3.0 * 0.2, 1e-10);
    let (status, values) = fmu.derivative(&["position[1]"], &["command[1]"; 2], &[1.0, 0.5]);
    assert_eq!(status, fmi2OK);
    near(values[0], 1.5 * 0.2, 1e-10);
    assert_eq!(fmu.derivative(&[], &knowns, &[1.0, 1.0]).0, fmi2OK);
    let (status, values) = fmu.derivative(&["position[1]"], &[], &[]);
    assert_eq!((status, values[0]), (fmi2OK, 0.0));
}

#[test]
fn at_rest_it_is_that_of_the_initial_outputs_by_inputs_and_parameters() {
    let fmu = Fmu::new(plant);
    assert_eq!(fmu.derivative(&["position[1]"], &["command[1]"], &[1.0]).0, fmi2Error);
    assert_eq!(fmu.reset(), fmi2OK);
    fmu.set_up(0.0, None);
    fmu.enter();
    fmu.set_real("command[1]", 8.0);
    near(slope(&fmu, "position[1]", "command[1]", 1.0), 2.0, 1e-10);
    near(slope(&fmu, "position[1]", "axis[1].lag.gain", 1.0), 8.0, 1e-10);
    assert_eq!(slope(&fmu, "position[1]", "axis[1].lag.time", 1.0), 0.0);
    // On its bound, the ceiling, the gain is differentiated from inside.
    fmu.set_real("axis[1].lag.gain", 100.0);
    near(slope(&fmu, "position[1]", "axis[1].lag.gain", 1.0), 8.0, 1e-9);
    fmu.exit();
    near(slope(&fmu, "position[1]", "command[1]", 1.0), 100.0, 1e-10);
    assert_eq!(fmu.real("position[1]"), 800.0);
    fmu.set_real("command[1]", 9.0);
    near(slope(&fmu, "position[1]", "command[1]", 1.0), 100.0, 1e-10);
    fmu.step(0.0, PERIOD);
    near(slope(&fmu, "position[1]", "command[1]", 1.0), 10.0, 1e-10);
}

/// Steps through these commands, one hit each.
fn driven(factory: Factory, commands: &[f64]) -> Fmu {
    let fmu = Fmu::ready(factory);
    for (k, command) in commands.iter().enumerate() {
        fmu.set_real("command[1]", *command);
        assert_eq!(fmu.step(k as f64 * PERIOD, PERIOD), fmi2OK);
    }
    fmu
}

#[test]
fn play_operators_are_linear_on_each_side() {
    let w = 0.25;
    // Commands so far, and the derivatives upwards and downwards.
    for (commands, up, down) in [
        // Rising with both plays taken along; it may rise on, or turn at the point reached.
        (&[10.0][..], 1.0 + 2.0 * w, 1.0 + 2.0 * w),
        (&[10.0, 10.0], 1.0 + 2.0 * w, 1.0),
        // Turned by less than the first play's width: neither moves.
        (&[10.0, 9.0], 1.0, 1.0),
        // The first play just touches its other edge, then moves, then both.
        (&[10.0, 8.0], 1.0, 1.0 + w),
        (&[10.0, 7.0], 1.0 + w, 1.0 + w),
        (&[10.0, 5.0], 1.0 + 2.0 * w, 1.0 + 2.0 * w),
        (&[0.5], 1.0, 1.0),
        (&[1.0], 1.0 + w, 1.0),
    ] {
        let fmu = driven(plays_plant, commands);
        near(slope(&fmu, "position[1]", "command[1]", 1.0), up, 1e-9);
        near(slope(&fmu, "position[1]", "command[1]", -1.0), -down, 1e-9);
    }
}

#[test]
fn a_jump_has_no_derivative_and_is_reported() {
    let between = driven(stairs_plant, &[0.75]);
    near(slope(&between, "position[1]", "command[1]", 1.0), 1.0, 1e-9);
    // On the edge of a stair it goes on smoothly upwards; downwards it falls at once.
    let edge = driven(stairs_plant, &[1.5]);
    near(slope(&edge, "position[1]", "command[1]", 1.0), 1.25, 1e-9);
    let (status, values) = edge.derivative(&["position[1]"], &["command[1]"], &[-1.0]);
    assert_eq!(status, fmi2Discard);
    assert!(values[0].is_nan(), "nothing is written");
    for part in ["position[1] (value reference 1)", "jumps", "no derivative"] {
        assert!(edge.last().contains(part), "{part}: {}", edge.last());
    }
    // It goes on.
    assert_eq!(edge.step(PERIOD, PERIOD), fmi2OK);
}

#[test]
fn near_a_kink_it_is_that_of_the_piece_that_the_input_is_on() {
    let mut random = Random(11);
    for _ in 0..200 {
        // The first play (width 1) begins to move at 1; a distance of 1e-12 to 0.9 from it.
        let distance = 0.9 * 10_f64.powf(-12.0 * random.unit());
        let fmu = driven(plays_plant, &[1.0 - distance]);
        let found = slope(&fmu, "position[1]", "command[1]", 1.0);
        // The least relative step is 2·2^-32 of the range of 110 V.
        if distance > 110.0 * 2_f64.powi(-31) {
            near(found, 1.0, 1e-5);
        }
        let fmu = driven(plays_plant, &[1.0 + distance]);
        near(slope(&fmu, "position[1]", "command[1]", 1.0), 1.25, 1e-5);
    }
}

#[test]
fn it_is_the_difference_of_steps_done_again_with_slopes_and_tuned_parameters() {
    let run = |command: f64| {
        let fmu = Fmu::ready(plant);
        fmu.set_real("command[1]", 2.0);
        fmu.step(0.0, 3.3 * PERIOD);
        fmu.set_real("command[1]", command);
        fmu.set_slope("command[1]", 1, 400.0);
        fmu.set_real("axis[1].lag.gain", 6.0);
        fmu.step(3.3 * PERIOD, 12.4 * PERIOD);
        fmu
    };
    let (fmu, more) = (run(5.0), run(6.0));
    let difference = more.real("position[1]") - fmu.real("position[1]");
    near(slope(&fmu, "position[1]", "command[1]", 1.0), difference, 1e-10);
    // What is set for the next step does not matter yet.
    fmu.set_real("command[1]", 50.0);
    fmu.set_real("axis[1].lag.gain", 60.0);
    fmu.set_slope("command[1]", 1, -9.0);
    near(slope(&fmu, "position[1]", "command[1]", 1.0), difference, 1e-10);
    assert_eq!(fmu.real("command[1]"), 50.0);
}

#[test]
fn a_saved_state_keeps_the_step_to_differentiate() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("command[1]", 2.0);
    fmu.set_slope("command[1]", 1, 100.0);
    fmu.step(0.0, 8.0 * PERIOD);
    let bits = slope(&fmu, "position[1]", "command[1]", 1.0).to_bits();
    let state = fmu.save();
    let bytes = fmu.bytes(state);
    fmu.set_real("command[1]", -3.0);
    fmu.step(8.0 * PERIOD, PERIOD);
    assert_ne!(slope(&fmu, "position[1]", "command[1]", 1.0).to_bits(), bits);
    assert_eq!(fmu.restore(state), fmi2OK);
    assert_eq!(slope(&fmu, "position[1]", "command[1]", 1.0).to_bits(), bits);

    let other = Fmu::new(plant);
    let mut read = null_mut();
    assert_eq!(other.deserialize(&bytes, &mut read), fmi2OK);
    assert_eq!(other.restore(read), fmi2OK);
    assert_eq!(slope(&other, "position[1]", "command[1]", 1.0).to_bits(), bits);
}

#[test]
fn what_is_no_known_or_no_unknown_is_refused() {
    for (unknown, known, seed, parts) in [
        ("command[1]", "command[1]", 1.0, ["command[1]", "no Real output"]),
        ("moving[1]", "command[1]", 1.0, ["moving[1]", "no Real output"]),
        ("position[1]", "position[1]", 1.0, ["position[1]", "no Real input"]),
        ("position[1]", "axis[1].lag.gain", 1.0, ["axis[1].lag.gain", "Initialization Mode"]),
        ("position[1]", "command[1]", f64::NAN, ["command[1]", "NaN"]),
    ] {
        let fmu = Fmu::ready(plant);
        fmu.step(0.0, PERIOD);
        assert_eq!(fmu.derivative(&[unknown], &[known], &[seed]).0, fmi2Error);
        for part in parts {
            assert!(fmu.last().contains(part), "{part}: {}", fmu.last());
        }
    }
}

#[test]
fn a_step_that_cannot_be_done_again_is_discarded() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("axis[1].lag.fault", 1.0);
    assert_eq!(fmu.step(0.0, PERIOD), fmi2Error);
    assert_eq!(fmu.derivative(&["position[1]"], &["command[1]"], &[1.0]).0, fmi2Discard);
    assert!(fmu.last().contains("position[1] = NaN"), "{}", fmu.last());
}

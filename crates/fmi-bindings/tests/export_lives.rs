//! What is set when, and how long it lasts: slopes of inputs, tunable parameters, start values.

use std::ptr::{null, null_mut};

use crate::support::components::PERIOD;
use crate::support::{Fmu, plant};
use fmi_bindings::export::v2;
use fmi_bindings::fmi2::*;

/// The position after one hit, from rest at 0 under command 0 with a gain of 2 um/V: the lag takes a
/// tenth of the way.
fn after_one_hit(command: f64) -> f64 {
    2.0 * command * (PERIOD / 0.01)
}

#[test]
fn a_slope_may_be_set_before_the_simulation_and_acts_in_the_first_step() {
    for when in ["instantiated", "initialization"] {
        let fmu = Fmu::new(plant);
        if when == "instantiated" {
            assert_eq!(fmu.set_slope("command[1]", 1, 500.0), fmi2OK);
        }
        fmu.set_up(0.0, None);
        fmu.enter();
        if when == "initialization" {
            assert_eq!(fmu.set_slope("command[1]", 1, 500.0), fmi2OK);
        }
        assert_eq!(fmu.real("position[1]"), 0.0, "at the start the input is as it was set");
        fmu.exit();
        assert_eq!(fmu.step(0.0, 2.0 * PERIOD), fmi2OK);
        // The first hit begins at 0 V, the second at 0.5 V.
        assert_eq!(fmu.real("position[1]"), after_one_hit(500.0 * PERIOD), "{when}");
    }
}

#[test]
fn the_last_slope_counts_and_a_failing_call_sets_none() {
    let fmu = Fmu::ready(plant);
    assert_eq!(fmu.set_slope("command[1]", 1, -7.0), fmi2OK);
    assert_eq!(fmu.set_slope("command[1]", 1, 500.0), fmi2OK);
    fmu.step(0.0, 2.0 * PERIOD);
    assert_eq!(fmu.real("position[1]"), after_one_hit(500.0 * PERIOD));

    let fmu = Fmu::ready(plant);
    let state = fmu.save();
    let references = [fmu.reference("command[1]"), fmu.reference("command[2]")];
    let (orders, values) = ([1, 2], [500.0, 500.0]);
    let status = unsafe {
        v2::fmi2SetRealInputDerivatives(
            fmu.c,
            references.as_ptr(),
            2,
            orders.as_ptr(),
            values.as_ptr(),
        )
    };
    assert_eq!(status, fmi2Error);
    assert!(fmu.last().contains("command[2]") && fmu.last().contains("order 2"), "{}", fmu.last());
    fmu.restore(state);
    fmu.step(0.0, 2.0 * PERIOD);
    assert_eq!(fmu.real("position[1]"), 0.0);
}

#[test]
fn a_saved_state_keeps_slopes_that_are_still_to_act() {
    let fmu = Fmu::ready(plant);
    fmu.set_slope("command[1]", 1, 500.0);
    let state = fmu.save();
    let bytes = fmu.bytes(state);
    fmu.step(0.0, 2.0 * PERIOD);
    let wanted = fmu.real("position[1]");
    assert_eq!(fmu.restore(state), fmi2OK);
    fmu.step(0.0, 2.0 * PERIOD);
    assert_eq!(fmu.real("position[1]"), wanted);

    let other = Fmu::new(plant);
    let mut read = null_mut();
    assert_eq!(other.deserialize(&bytes, &mut read), fmi2OK);
    assert_eq!(other.restore(read), fmi2OK);
    other.step(0.0, 2.0 * PERIOD);
    assert_eq!(other.real("position[1]").to_bits(), wanted.to_bits());
}

#[test]
fn a_tunable_parameter_set_forth_and_back_leaves_no_trace() {
    let (fmu, untouched) = (Fmu::ready(plant), Fmu::ready(plant));
    for k in 0..50 {
        for instance in [&fmu, &untouched] {
            instance.set_real("command[1]", f64::from(k % 9));
        }
        fmu.set_real("axis[1].lag.gain", 77.0);
        fmu.set_real("axis[1].lag.gain", 2.0);
        for instance in [&fmu, &untouched] {
            instance.step(f64::from(k) * PERIOD, PERIOD);
        }
        let (a, b) = (fmu.real("position[1]"), untouched.real("position[1]"));
        assert_eq!(a.to_bits(), b.to_bits());
    }
}

#[test]
fn a_tunable_parameter_acts_from_the_next_step_on_and_moves_no_output_before() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("command[1]", 1.0);
    fmu.step(0.0, PERIOD);
    let before = fmu.real("position[1]");
    fmu.set_real("axis[1].lag.gain", 12.0);
    assert_eq!(fmu.real("position[1]"), before, "not before the step");
    fmu.step(PERIOD, PERIOD);
    let wanted = before + (12.0 - before) * (PERIOD / 0.01);
    assert_eq!(fmu.real("position[1]"), wanted);
    fmu.step(2.0 * PERIOD, PERIOD);
    assert!(fmu.real("position[1]") > wanted, "it stays");
}

#[test]
fn tunable_parameters_that_break_a_rule_together_are_refused_at_the_step() {
    let fmu = Fmu::ready(plant);
    assert_eq!(fmu.set_real("axis[1].lag.gain", 150.0), fmi2OK);
    assert_eq!(fmu.step(0.0, PERIOD), fmi2Error);
    for part in ["fmi2DoStep", "axis[1].lag.gain", "ceiling"] {
        assert!(fmu.last().contains(part), "{part}: {}", fmu.last());
    }
    assert_eq!(fmu.reset(), fmi2OK);
    assert_eq!(fmu.set_up(0.0, None), fmi2OK);
    assert_eq!(fmu.enter(), fmi2OK);
    assert_eq!(fmu.real("axis[1].lag.gain"), 2.0, "that of the model description");
    assert_eq!(fmu.exit(), fmi2OK);
}

#[test]
fn after_a_reset_new_start_values_act_as_in_a_new_instance() {
    let change = |fmu: &Fmu, gain: f64| {
        fmu.set_real("axis[1].lag.gain", gain);
        fmu.set_real("axis[1].lag.time", 0.02);
        fmu.set_boolean("axis[1].double.enabled", fmi2True);
        fmu.set_real("command[1]", 3.0);
    };
    let run = |fmu: &Fmu| -> Vec<u64> {
        fmu.start(1.0);
        let step = |k: i32| {
            fmu.set_real("command[1]", f64::from(k));
            fmu.step(1.0 + f64::from(k) * PERIOD, PERIOD);
            fmu.real("position[1]").to_bits()
        };
        (0..20).map(step).collect()
    };
    let fresh = Fmu::new(plant);
    change(&fresh, 7.0);
    let wanted = run(&fresh);

    let used = Fmu::new(plant);
    change(&used, 4.0);
    assert_ne!(run(&used), wanted);
    // Terminated, in the middle, after an error: always the same.
    for end in ["terminated", "running", "error"] {
        match end {
            "terminated" => assert_eq!(used.terminate(), fmi2OK),
            "error" => assert_eq!(used.step(0.0, -1.0), fmi2Error),
            _ => {}
        }
        assert_eq!(used.reset(), fmi2OK);
        change(&used, 7.0);
        assert_eq!(run(&used), wanted, "{end}");
    }
}

#[test]
fn a_state_saved_before_a_reset_outlives_it() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("command[1]", 5.0);
    fmu.step(0.0, PERIOD);
    let (state, position) = (fmu.save(), fmu.real("position[1]"));
    assert_eq!(fmu.reset(), fmi2OK);
    assert_eq!(fmu.restore(state), fmi2OK);
    assert_eq!(fmu.real("position[1]"), position);
    assert_eq!(fmu.step(PERIOD, PERIOD), fmi2OK);
}

#[test]
fn after_the_end_everything_is_read_and_nothing_is_set() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("command[1]", 5.0);
    fmu.step(0.0, PERIOD);
    let values = |fmu: &Fmu| {
        ["command[1]", "position[1]", "axis[1].lag.gain"].map(|name| fmu.real(name).to_bits())
    };
    let before = values(&fmu);
    let slope = fmu.derivative(&["position[1]"], &["command[1]"], &[1.0]);
    assert_eq!(fmu.terminate(), fmi2OK);
    assert_eq!(values(&fmu), before);
    assert_eq!(fmu.boolean("moving[1]"), fmi2True);
    assert_eq!(fmu.derivative(&["position[1]"], &["command[1]"], &[1.0]), slope);
    assert_eq!(fmu.set_real("command[1]", 6.0), fmi2Error);
    assert_eq!(values(&fmu), before, "also after the refusal");
}

#[test]
fn null_pointers_for_derivatives_are_errors_that_name_the_argument() {
    let (input, output, seed) = (0_u32, 2_u32, 1.0);
    let cases = [
        (null(), &raw const input, &raw const seed, "vUnknown_ref"),
        (&raw const output, null(), &raw const seed, "vKnown_ref"),
        (&raw const output, &raw const input, null(), "dvKnown"),
        (&raw const output, &raw const input, &raw const seed, "dvUnknown"),
    ];
    for (unknowns, knowns, seed, part) in cases {
        let fmu = Fmu::ready(plant);
        let status = unsafe {
            v2::fmi2GetDirectionalDerivative(fmu.c, unknowns, 1, knowns, 1, seed, null_mut())
        };
        assert_eq!(status, fmi2Error);
        assert!(fmu.last().contains(part) && fmu.last().contains("null"), "{}", fmu.last());
    }
}

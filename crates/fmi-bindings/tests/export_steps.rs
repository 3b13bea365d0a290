//! Steps: time, stop time, partitions, inputs on straight lines.

use crate::support::components::PERIOD;
use crate::support::{Fmu, Random, plant};
use fmi_bindings::export::v2;
use fmi_bindings::fmi2::*;

fn last_time(fmu: &Fmu) -> f64 {
    let mut time = f64::NAN;
    let status = unsafe { v2::fmi2GetRealStatus(fmu.c, fmi2LastSuccessfulTime, &mut time) };
    assert_eq!(status, fmi2OK);
    time
}

#[test]
fn every_partition_gives_the_same_bits_at_common_points() {
    let start = 0.3;
    let coarse = 0.05;
    let truth = Fmu::new(plant);
    truth.start(start);
    let mut random = Random(42);
    for seed in 0..20 {
        let fmu = Fmu::new(plant);
        fmu.start(start);
        truth.reset();
        truth.start(start);
        for k in 0..10 {
            let (begin, end) = (start + k as f64 * coarse, start + (k + 1) as f64 * coarse);
            let command = 10.0 * random.unit();
            assert_eq!(truth.set_real("command[1]", command), fmi2OK);
            assert_eq!(fmu.set_real("command[1]", command), fmi2OK);
            assert_eq!(truth.step(begin, end - begin), fmi2OK);
            let mut time = begin;
            while end - time > 3.0 * PERIOD {
                let step = random.unit() * 3.0 * PERIOD + 1e-7;
                assert_eq!(fmu.step(time, step), fmi2OK, "seed {seed}: {}", fmu.last());
                time += step;
            }
            assert_eq!(fmu.step(time, end - time), fmi2OK);
            let (a, b) = (fmu.real("position[1]"), truth.real("position[1]"));
            assert_eq!(a.to_bits(), b.to_bits(), "seed {seed}, point {k}: {a} {b}");
        }
    }
}

#[test]
fn a_step_smaller_than_the_internal_one_holds_the_outputs_until_the_next_hit() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("command[1]", 1.0);
    for k in 0..3 {
        assert_eq!(fmu.step(k as f64 * 0.25 * PERIOD, 0.25 * PERIOD), fmi2OK);
        assert_eq!(fmu.real("position[1]"), 0.0);
    }
    assert_eq!(fmu.step(0.75 * PERIOD, 0.25 * PERIOD), fmi2OK);
    assert!(fmu.real("position[1]") > 0.0);
}

#[test]
fn a_master_that_adds_up_its_steps_is_followed_far_from_zero() {
    // One hit per step, neither missed nor doubled, although 1e5 s is no multiple of the step.
    let start = 1e5;
    let fmu = Fmu::new(plant);
    fmu.start(start);
    fmu.set_real("command[1]", 1.0);
    let mut time = start;
    let mut last = 0.0;
    for k in 0..200 {
        assert_eq!(fmu.step(time, PERIOD), fmi2OK, "{}", fmu.last());
        time = start + (k + 1) as f64 * PERIOD;
        let now = fmu.real("position[1]");
        assert!(now > last, "no hit in step {k}");
        last = now;
    }
}

#[test]
fn the_communication_point_may_be_off_by_rounding_only() {
    let fmu = Fmu::ready(plant);
    assert_eq!(fmu.step(0.0, 0.1), fmi2OK);
    assert_eq!(fmu.step(0.1 * (1.0 + 3.0 * f64::EPSILON), 0.1), fmi2OK);
    assert_eq!(last_time(&fmu), 0.1 * (1.0 + 3.0 * f64::EPSILON) + 0.1);
    for wrong in [0.0, 0.1, 0.3, 0.2001, f64::NAN, f64::INFINITY] {
        let state = fmu.save();
        assert_eq!(fmu.step(wrong, 0.1), fmi2Error, "{wrong}");
        assert!(fmu.last().contains(&format!("communication point {wrong} s")), "{}", fmu.last());
        assert_eq!(fmu.restore(state), fmi2OK);
    }
}

#[test]
fn the_step_must_be_positive_and_finite() {
    for step in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        let fmu = Fmu::ready(plant);
        assert_eq!(fmu.step(0.0, step), fmi2Error);
        assert!(fmu.last().contains("greater than 0"), "{}", fmu.last());
    }
}

#[test]
fn times_that_cannot_be_resolved_are_refused_instead_of_never_reached() {
    let fmu = Fmu::ready(plant);
    assert_eq!(fmu.step(0.0, 1e300), fmi2Error);
    assert!(fmu.last().contains("internal step of 0.001 s"), "{}", fmu.last());
    let fmu = Fmu::new(plant);
    fmu.start(1e15);
    assert_eq!(fmu.step(1e15, 1.0), fmi2Error);
}

#[test]
fn the_stop_time_is_the_end_but_for_rounding() {
    let fmu = Fmu::new(plant);
    fmu.set_up(0.0, Some(0.3));
    fmu.enter();
    fmu.exit();
    assert_eq!(fmu.step(0.0, 0.1), fmi2OK);
    assert_eq!(fmu.step(0.1, 0.1), fmi2OK);
    // What fmpy's last step is.
    assert_eq!(fmu.step(0.2, 0.100_000_000_000_000_03), fmi2OK);
    assert_eq!(fmu.step(0.300_000_000_000_000_04, 0.1), fmi2Error);
    for part in ["stop time 0.3 s", "0.4", "without a stop time"] {
        assert!(fmu.last().contains(part), "{part}: {}", fmu.last());
    }
}

#[test]
fn the_experiment_is_checked() {
    for (start, stop, part) in [
        (f64::NAN, None, "start time NaN"),
        (f64::INFINITY, None, "start time inf"),
        (1.0, Some(0.5), "stop time 0.5"),
        (1.0, Some(f64::NAN), "stop time NaN"),
    ] {
        let fmu = Fmu::new(plant);
        assert_eq!(fmu.set_up(start, stop), fmi2Error);
        assert!(fmu.last().contains(part), "{}", fmu.last());
    }
    let fmu = Fmu::new(plant);
    assert_eq!(fmu.set_up(1.0, Some(2.0)), fmi2OK);
    assert_eq!(fmu.set_up(-5.0, None), fmi2OK, "the last one counts");
    fmu.enter();
    fmu.exit();
    assert_eq!(last_time(&fmu), -5.0);
    assert_eq!(fmu.step(-5.0, 10.0), fmi2OK);
}

#[test]
fn without_an_experiment_time_starts_at_zero_with_a_warning() {
    let fmu = Fmu::new(plant);
    assert_eq!(fmu.enter(), fmi2Warning);
    assert_eq!(fmu.messages()[0].category, "logStatusWarning");
    assert_eq!(fmu.exit(), fmi2OK);
    assert_eq!(fmu.step(0.0, 1e-3), fmi2OK);
}

/// What a master does that sets the input at every internal hit.
fn stepped_finely(start: f64, from: f64, slope: f64, hits: usize) -> Fmu {
    let fmu = Fmu::new(plant);
    fmu.start(start);
    for n in 0..hits {
        let begin = start + n as f64 * PERIOD;
        fmu.set_real("command[1]", from + slope * (begin - start));
        assert_eq!(fmu.step(begin, PERIOD), fmi2OK);
    }
    fmu
}

#[test]
fn an_input_on_a_straight_line_is_as_if_set_at_every_internal_hit() {
    let (start, from, slope) = (0.25, 1.0, 40.0);
    let truth = stepped_finely(start, from, slope, 50);
    let fmu = Fmu::new(plant);
    fmu.start(start);
    fmu.set_real("command[1]", from);
    assert_eq!(fmu.set_slope("command[1]", 1, slope), fmi2OK);
    assert_eq!(fmu.step(start, 50.0 * PERIOD), fmi2OK);
    assert_eq!(fmu.real("position[1]").to_bits(), truth.real("position[1]").to_bits());
    assert_eq!(fmu.real("command[1]"), from, "the input is as it was set");

    // The slope was for one step; now the input is held.
    let before = fmu.real("position[1]");
    assert_eq!(fmu.step(start + 50.0 * PERIOD, PERIOD), fmi2OK);
    let held = before + (2.0 * from - before) * (PERIOD / 0.01);
    assert!((fmu.real("position[1]") - held).abs() < 1e-12);
}

#[test]
fn a_line_in_pieces_between_the_hits_is_the_same_line() {
    let (from, slope) = (1.0, 40.0);
    let truth = stepped_finely(0.0, from, slope, 50);
    let fmu = Fmu::ready(plant);
    let mut random = Random(7);
    let (mut time, end) = (0.0, 50.0 * PERIOD);
    while time < end {
        let step = (random.unit() * 3.0 * PERIOD + 1e-6).min(end - time);
        fmu.set_real("command[1]", from + slope * time);
        assert_eq!(fmu.set_slope("command[1]", 1, slope), fmi2OK);
        assert_eq!(fmu.step(time, step), fmi2OK);
        time += step;
    }
    let (a, b) = (fmu.real("position[1]"), truth.real("position[1]"));
    assert!((a - b).abs() < 1e-12 * b.abs(), "{a} {b}");
}

#[test]
fn a_slope_is_for_continuous_inputs_of_first_order_and_finite() {
    for (name, order, slope, part) in [
        ("position[1]", 1, 1.0, "no continuous input"),
        ("axis[1].lag.gain", 1, 1.0, "no continuous input"),
        ("command[1]", 2, 1.0, "order 2"),
        ("command[1]", 0, 1.0, "order 0"),
        ("command[1]", 1, f64::NAN, "NaN"),
        ("moving[1]", 1, 1.0, "Boolean"),
    ] {
        let fmu = Fmu::ready(plant);
        assert_eq!(fmu.set_slope(name, order, slope), fmi2Error, "{name}");
        assert!(fmu.last().contains(part) && fmu.last().contains(name), "{}", fmu.last());
    }
}

#[test]
fn a_model_that_leaves_its_range_is_an_error_that_names_the_output() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("axis[1].lag.fault", 1.0);
    assert_eq!(fmu.step(0.0, 1e-3), fmi2Error);
    assert!(fmu.last().contains("position[1] = NaN at 0.001 s"), "{}", fmu.last());
    assert_eq!(fmu.reset(), fmi2OK);
    fmu.start(0.0);
    assert_eq!(fmu.step(0.0, 1e-3), fmi2OK);
    assert_eq!(fmu.real("position[1]"), 0.0);
}

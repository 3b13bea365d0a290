//! Slopes of outputs in time, against closed forms and against differences of outputs.

use std::ptr::null_mut;

use crate::support::components::PERIOD;
use crate::support::{Factory, Fmu, Random, plant, plays_plant, stairs_plant};
use fmi_bindings::export::v2;
use fmi_bindings::fmi2::*;

fn slopes(fmu: &Fmu, names: &[&str], order: i32) -> (fmi2Status, Vec<f64>) {
    let references: Vec<u32> = names.iter().map(|name| fmu.reference(name)).collect();
    let orders = vec![order; names.len()];
    let mut values = vec![f64::NAN; names.len()];
    let status = unsafe {
        v2::fmi2GetRealOutputDerivatives(
            fmu.c,
            references.as_ptr(),
            references.len(),
            orders.as_ptr(),
            values.as_mut_ptr(),
        )
    };
    (status, values)
}

fn slope(fmu: &Fmu, name: &str) -> f64 {
    let (status, values) = slopes(fmu, &[name], 1);
    assert_eq!(status, fmi2OK, "{}", fmu.last());
    values[0]
}

#[test]
fn at_rest_outputs_do_not_move() {
    let fmu = Fmu::new(plant);
    fmu.set_real("command[1]", 3.0);
    fmu.start(0.0);
    assert_eq!(slope(&fmu, "position[1]"), 0.0);
    fmu.set_real("command[1]", 9.0);
    assert_eq!(slope(&fmu, "position[1]"), 0.0);
    assert_eq!(fmu.step(0.0, 0.5 * PERIOD), fmi2OK);
    assert_eq!(slope(&fmu, "position[1]"), 0.0, "no hit, no motion");
}

/// A lag from 0 under a constant input: y_n = 6·(1 − (1 − a)^n), so the slope is 6·a·(1 − a)^(n−1)/h.
#[test]
fn it_is_that_of_the_last_internal_step_for_every_partition() {
    let a: f64 = PERIOD / 0.01;
    for hits in [1, 2, 3, 25] {
        let wanted = 6.0 * a * (1.0 - a).powi(hits - 1) / PERIOD;
        let started = || {
            let fmu = Fmu::ready(plant);
            fmu.set_real("command[1]", 3.0);
            fmu
        };
        let complete = started();
        assert_eq!(complete.step(0.0, f64::from(hits) * PERIOD), fmi2OK);
        let found = slope(&complete, "position[1]");
        assert!((found - wanted).abs() <= 1e-9 * wanted.abs(), "{found} instead of {wanted}");
        let cut = started();
        for k in 0..2 * hits {
            assert_eq!(cut.step(f64::from(k) * 0.5 * PERIOD, 0.5 * PERIOD), fmi2OK);
        }
        assert_eq!(slope(&cut, "position[1]").to_bits(), found.to_bits(), "{hits} hits");
        let time = f64::from(hits) * PERIOD;
        assert_eq!(cut.step(time, 0.4 * PERIOD), fmi2OK);
        assert_eq!(slope(&cut, "position[1]").to_bits(), found.to_bits(), "held between hits");
    }
}

/// Also along slopes of the inputs, after tunable parameters changed, and for operators with memory.
#[test]
fn it_is_the_difference_of_the_outputs_at_the_last_two_hits() {
    let mut random = Random(20_261_121);
    for factory in [plant as Factory, plays_plant] {
        let (fast, slow) = (Fmu::ready(factory), Fmu::ready(factory));
        let mut hit = 0;
        for _ in 0..200 {
            let hits = 1 + (4.0 * random.unit()) as u32;
            let (level, rate) = (20.0 * random.unit(), 1e3 * random.unit());
            let time = f64::from(hit) * PERIOD;
            for fmu in [&fast, &slow] {
                fmu.set_real("command[1]", level);
                fmu.set_slope("command[1]", 1, rate);
            }
            assert_eq!(slow.step(time, f64::from(hits) * PERIOD), fmi2OK, "{}", slow.last());
            let mut before = fast.real("position[1]");
            for k in 0..hits {
                let now = f64::from(hit + k) * PERIOD;
                before = fast.real("position[1]");
                if k > 0 {
                    fast.set_real("command[1]", level + rate * (now - time));
                }
                assert_eq!(fast.step(now, PERIOD), fmi2OK);
            }
            let moved = fast.real("position[1]") - before;
            assert_eq!(slope(&fast, "position[1]").to_bits(), (moved / PERIOD).to_bits());
            let (found, scale) = (slope(&slow, "position[1]"), moved.abs() + 1e-9);
            assert!((found * PERIOD - moved).abs() <= 1e-9 * scale, "{found} for {moved}");
            hit += hits;
        }
    }
}

#[test]
fn a_jump_is_in_it_for_one_internal_step() {
    let fmu = Fmu::ready(stairs_plant);
    fmu.set_real("command[1]", 0.0);
    fmu.step(0.0, PERIOD);
    let low = fmu.real("position[1]");
    fmu.set_real("command[1]", 50.0);
    fmu.step(PERIOD, PERIOD);
    let jump = fmu.real("position[1]") - low;
    assert!(jump != 0.0);
    assert_eq!(slope(&fmu, "position[1]"), jump / PERIOD);
    fmu.step(2.0 * PERIOD, PERIOD);
    assert_eq!(slope(&fmu, "position[1]"), 0.0);
}

#[test]
fn it_belongs_to_the_state() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("command[1]", 3.0);
    fmu.step(0.0, 7.0 * PERIOD);
    let (state, found) = (fmu.save(), slope(&fmu, "position[1]"));
    let bytes = fmu.bytes(state);
    fmu.set_real("command[1]", -8.0);
    fmu.set_real("axis[1].lag.gain", 5.0);
    fmu.step(7.0 * PERIOD, 3.0 * PERIOD);
    assert!(slope(&fmu, "position[1]") != found);
    fmu.restore(state);
    assert_eq!(slope(&fmu, "position[1]").to_bits(), found.to_bits());
    let other = Fmu::new(plant);
    let mut read = null_mut();
    assert_eq!(other.deserialize(&bytes, &mut read), fmi2OK);
    assert_eq!(other.restore(read), fmi2OK);
    assert_eq!(slope(&other, "position[1]").to_bits(), found.to_bits());
}

#[test]
fn others_than_real_outputs_and_order_1_are_refused() {
    for (names, order, parts) in [
        (&["position[1]", "command[1]"][..], 1, &["command[1]", "is no Real output"][..]),
        (&["moving[1]"], 1, &["moving[1]", "is no Real output"]),
        (&["position[1]"], 2, &["order 2", "give order 1"]),
        (&["position[1]"], 0, &["order 0", "give order 1"]),
    ] {
        let fmu = Fmu::ready(plant);
        fmu.step(0.0, PERIOD);
        let (status, values) = slopes(&fmu, names, order);
        assert_eq!(status, fmi2Error);
        assert!(values.iter().all(|value| value.is_nan()), "nothing is written");
        for part in parts {
            assert!(fmu.last().contains(part), "{part}: {}", fmu.last());
        }
    }
}

//! Each property of the controller, seen on its outputs.

use super::*;
use crate::testing::{Instance, Random};

const T: f64 = 1e-3;

fn pid(kp: f64, ki: f64, kd: f64, min: f64, max: f64) -> Instance {
    Instance::new(&Pid, &[], &[kp, ki, kd, 0.0, min, max, 1.0, 0.0, 0.0, 1.0, 0.0], T).unwrap()
}

/// Command, feedforward, feedback, saturated.
fn outputs(pid: &Instance) -> [f64; 4] {
    pid.outputs.as_slice().try_into().unwrap()
}

#[test]
fn is_the_positional_form_sample_by_sample() {
    let (kp, ki, kd) = (50.0, 300.0, 0.06);
    let mut pid = pid(kp, ki, kd, -1e9, 1e9);
    let mut random = Random::new(9);
    pid.rest(&[0.0, 0.3, 0.1, 1.0]);
    let (mut sum, mut last) = (0.0, 0.3 - 0.1);
    for _ in 0..1000 {
        let (ff, r, y) =
            (random.between(-9.0, 9.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        let e = r - y;
        sum += e;
        let expected = ff + kp * e + ki * T * sum + kd * (e - last) / T;
        last = e;
        let command = pid.step(&[ff, r, y, 1.0]);
        assert!((command - expected).abs() < 1e-9, "{command} {expected}");
        let [command, feedforward, feedback, saturated] = outputs(&pid);
        assert_eq!((feedforward, command, saturated), (ff, ff + feedback, 0.0));
    }
}

#[test]
fn at_rest_the_command_is_the_limited_feedforward_without_feedback() {
    let mut pid = pid(50.0, 300.0, 0.06, 0.0, 120.0);
    pid.rest(&[60.0, 5.0, 1.0, 1.0]);
    assert_eq!(outputs(&pid), [60.0, 60.0, 0.0, 0.0]);
    pid.rest(&[150.0, 5.0, 1.0, 1.0]);
    assert_eq!(outputs(&pid), [120.0, 150.0, 0.0, 1.0]);
    pid.rest(&[-3.0, 5.0, 1.0, 1.0]);
    assert_eq!(outputs(&pid), [0.0, -3.0, 0.0, 1.0]);
}

#[test]
fn the_derivative_does_not_kick_at_the_first_step() {
    let mut pid = pid(0.0, 0.0, 1.0, -1e9, 1e9);
    pid.rest(&[7.0, 5.0, 1.0, 1.0]);
    assert_eq!(pid.step(&[7.0, 5.0, 1.0, 1.0]), 7.0);
}

#[test]
fn the_command_stays_within_its_limits_and_says_so() {
    let mut pid = pid(100.0, 1000.0, 0.1, 0.0, 120.0);
    let mut random = Random::new(2);
    pid.rest(&[60.0, 0.0, 0.0, 1.0]);
    let mut hits = 0;
    for _ in 0..2000 {
        let r = random.between(-2.0, 2.0);
        pid.step(&[60.0, r, 0.0, 1.0]);
        let [command, feedforward, feedback, saturated] = outputs(&pid);
        assert!((0.0..=120.0).contains(&command));
        let free = feedforward + feedback;
        assert_eq!(saturated == 1.0, !(0.0..=120.0).contains(&free));
        hits += u32::from(saturated == 1.0);
    }
    assert!(hits > 100, "the test must reach the limits: {hits}");
}

#[test]
fn the_integral_does_not_wind_up_and_leaves_saturation_at_once() {
    let mut pid = pid(1.0, 1000.0, 0.0, 0.0, 10.0);
    pid.rest(&[5.0, 0.0, 0.0, 1.0]);
    for _ in 0..1000 {
        pid.step(&[5.0, 1.0, 0.0, 1.0]);
    }
    assert_eq!(outputs(&pid)[0], 10.0);
    // A second of unit error would have integrated 1000; the sign changes, and the command leaves
    // the limit with the first steps: 2 from kp, 1 from each step of ki.
    let command = pid.step(&[5.0, -1.0, 0.0, 1.0]);
    assert!(command <= 8.0, "{command}");
}

#[test]
fn the_integral_moves_on_where_it_leads_out_of_saturation() {
    let mut pid = pid(0.0, 1000.0, 0.0, 0.0, 10.0);
    pid.rest(&[14.5, 0.0, 0.0, 1.0]);
    let commands: std::vec::Vec<f64> = (0..7).map(|_| pid.step(&[14.5, -1.0, 0.0, 1.0])).collect();
    assert_eq!(commands, [10.0, 10.0, 10.0, 10.0, 9.5, 8.5, 7.5]);
}

#[test]
fn disabled_holds_and_enabling_continues_without_a_jump() {
    let mut pid = pid(50.0, 300.0, 0.06, 0.0, 120.0);
    pid.rest(&[60.0, 0.0, 0.0, 1.0]);
    for n in 0..50 {
        pid.step(&[60.0, 0.02 * f64::from(n % 7), 0.1, 1.0]);
    }
    let held = outputs(&pid)[0];
    assert!(held > 1.0 && held < 119.0, "{held}");
    for n in 0..20 {
        assert_eq!(pid.step(&[70.0 + f64::from(n), 1.0, 0.3, 0.0]), held);
        assert_eq!(outputs(&pid)[2..], [0.0, 0.0]);
    }
    let command = pid.step(&[90.0, 0.7, 0.1, 1.0]);
    assert!((command - held).abs() < 1e-12 * held, "{command} {held}");
    // From there on it integrates as ever.
    let next = pid.step(&[90.0, 0.7, 0.1, 1.0]);
    assert!((next - command - 300.0 * T * 0.6).abs() < 1e-9, "{next} {command}");
}

#[test]
fn disabled_from_the_start_holds_the_feedforward_of_the_start() {
    let mut pid = pid(50.0, 300.0, 0.0, 0.0, 120.0);
    pid.rest(&[60.0, 1.0, 0.0, 0.0]);
    assert_eq!(pid.step(&[90.0, 1.0, 0.0, 0.0]), 60.0);
    let command = pid.step(&[90.0, 1.0, 0.0, 1.0]);
    assert!((command - 60.0).abs() < 1e-12, "{command}");
}

#[test]
fn a_changed_ki_causes_no_jump() {
    let mut pid = pid(0.0, 300.0, 0.0, -1e3, 1e3);
    pid.rest(&[0.0, 0.0, 0.0, 1.0]);
    for _ in 0..100 {
        pid.step(&[0.0, 1.0, 0.0, 1.0]);
    }
    let before = outputs(&pid)[0];
    pid.set(&[0.0, 900.0, 0.0, 0.0, -1e3, 1e3, 1.0, 0.0, 0.0, 1.0, 0.0]).unwrap();
    assert_eq!(pid.step(&[0.0, 0.0, 0.0, 1.0]), before);
    let after = pid.step(&[0.0, 1.0, 0.0, 1.0]);
    assert!((after - before - 900.0 * T).abs() < 1e-12);
}

#[test]
fn limits_that_shrink_while_held_are_kept() {
    let mut pid = pid(1.0, 0.0, 0.0, 0.0, 120.0);
    pid.rest(&[100.0, 0.0, 0.0, 1.0]);
    pid.set(&[1.0, 0.0, 0.0, 0.0, 0.0, 80.0, 1.0, 0.0, 0.0, 1.0, 0.0]).unwrap();
    assert_eq!(pid.step(&[100.0, 0.0, 0.0, 0.0]), 80.0);
}

#[test]
fn crossed_limits_are_refused() {
    let error =
        Instance::new(&Pid, &[], &[1.0, 0.0, 0.0, 0.0, 120.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0], T)
            .err();
    assert_eq!(error.map(|e| (e.quantity, e.value)), Some(("output_min", 120.0)));
}

#[test]
fn the_filtered_derivative_of_a_ramp_settles_at_its_slope_geometrically() {
    let (kd, filter, slope) = (0.06, 5e-3, 2.0);
    let mut pid =
        Instance::new(&Pid, &[], &[0.0, 0.0, kd, filter, -1e9, 1e9, 1.0, 0.0, 0.0, 1.0, 0.0], T)
            .unwrap();
    pid.rest(&[0.0, 0.0, 0.0, 1.0]);
    let keep = (-T / filter).exp();
    for n in 1..100 {
        let reference = slope * f64::from(n) * T;
        let command = pid.step(&[0.0, reference, 0.0, 1.0]);
        let expected = kd * slope * (1.0 - keep.powi(n));
        assert!((command - expected).abs() < 1e-12, "{n}: {command} {expected}");
    }
}

/// kp 2, ki 300, no derivative, 0 to 100, with the settings behind the limits.
fn with(settings: [f64; 5]) -> Instance {
    let p = [&[2.0, 300.0, 0.0, 0.0, 0.0, 100.0][..], &settings].concat();
    Instance::new(&Pid, &[], &p, T).unwrap()
}

#[test]
fn the_command_moves_no_faster_than_its_rate_and_the_integral_waits() {
    let mut pid = with([1.0, 2000.0, 0.0, 1.0, 0.0]);
    let mut last = pid.rest(&[10.0, 0.0, 0.0, 1.0]);
    for n in 1..=40 {
        let now = pid.step(&[90.0, 0.0, 0.0, 1.0]);
        assert!((now - last - 2.0).abs() < 1e-12, "step {n}: {last} to {now}");
        assert_eq!(pid.outputs[3], f64::from(u8::from(n < 40)));
        last = now;
    }
    assert_eq!(pid.step(&[90.0, 0.0, 0.0, 1.0]), 90.0);
}

#[test]
fn back_calculation_leads_the_integral_to_the_limit() {
    // Held beyond the limit by a constant error, kp·e + I settles where the excess is
    // ki·tracking_time·e.
    let tracking = 0.02;
    let mut pid = with([1.0, 0.0, tracking, 1.0, 0.0]);
    pid.rest(&[50.0, 0.0, 0.0, 1.0]);
    for _ in 0..2000 {
        pid.step(&[50.0, 0.5, 0.0, 1.0]);
    }
    let free = pid.outputs[1] + pid.outputs[2];
    let excess = 300.0 * tracking * 0.5;
    // u_k holds one increment more than the integral that it leads to.
    assert!((free - 100.0 - excess).abs() < 1e-6, "{free}");
}

#[test]
fn disabled_it_goes_to_the_safe_command_at_the_rate_limit_where_it_does_not_hold() {
    let mut pid = with([1.0, 5000.0, 0.0, 0.0, 20.0]);
    assert_eq!(pid.rest(&[50.0, 0.0, 0.0, 0.0]), 20.0);
    assert_eq!(pid.rest(&[50.0, 0.0, 0.0, 1.0]), 50.0);
    for n in 1..=10 {
        let command = pid.step(&[50.0, 3.0, 0.0, 0.0]);
        assert_eq!(command, (50.0 - 5.0 * f64::from(n)).max(20.0));
    }
    // And back without a jump.
    let back = pid.step(&[50.0, 3.0, 0.0, 1.0]);
    assert!((back - 20.0).abs() < 1e-12, "{back}");
}

#[test]
fn the_feedforward_has_its_share() {
    let mut pid = with([0.9, 0.0, 0.0, 1.0, 0.0]);
    pid.rest(&[50.0, 0.0, 0.0, 1.0]);
    assert_eq!(pid.step(&[60.0, 0.0, 0.0, 1.0]), 54.0);
    assert_eq!(outputs(&pid), [54.0, 54.0, 0.0, 0.0]);
}

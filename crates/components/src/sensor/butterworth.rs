//! Butterworth low-pass of the sensor or its anti-aliasing filter, orders 1 to 8.
//!
//! `|G(jω)|² = 1/(1 + (f/bandwidth)^(2·order))`
//!
//! * bandwidth in Hz: −3 dB; order is structural.
//! * The filter is taken apart into its poles, `G(s) = Σ c_k·(−p_k)/(s − p_k)`, whose complex
//!   first-order parts are each exact for an input held over a step, and so is the sum.
//! * State: one complex number for each pair of poles, one real one for an odd order.
//!
//! Source: S. Butterworth, Experimental Wireless and the Wireless Engineer 7 (1930) 536–541.

use core::f64::consts::{PI, TAU};

use libm::{cos, exp, sin};
use model::{Component, Declaration, Quantity, Sizes, Stage, Structural, Tick, Violation};

use crate::rules::{WRONG_LENGTH, positive_frequency};
use crate::{effects, phenomena};

/// The component `sensor-butterworth`.
pub struct SensorButterworth;

static DECLARATION: Declaration = Declaration {
    kind: "sensor-butterworth",
    name: "filter",
    summary: "Butterworth low-pass of the sensor, orders 1 to 8",
    equation: "|G(j*2*pi*f)|^2 = 1/(1 + (f/bandwidth)^(2*order))",
    reference: "S. Butterworth, Experimental Wireless and the Wireless Engineer 7 (1930) 536-541",
    stage: Stage::Sensor,
    effect: Some(&effects::SENSOR_BANDWIDTH),
    phenomena: &[&phenomena::SENSOR_BANDWIDTH],
    structure: &[Structural {
        start: Some(2.0),
        ..Structural::count("order", "Order of the filter", 1, 8)
    }],
    parameters: &[Quantity::new(
        "bandwidth",
        "Hz",
        "Frequency at which the reading has fallen by 3 dB",
    )
    .min(0.0)
    .fitted()],
    ..Declaration::PATH
};

fn order(structure: &[f64]) -> usize {
    structure.first().map_or(0, |n| *n as usize)
}

/// Pole number k of the filter of bandwidth 1 rad/s, as real and imaginary part: on the unit
/// circle, from the imaginary axis to the real one, the upper half only.
fn pole(k: usize, order: usize) -> [f64; 2] {
    if 2 * k + 1 == order {
        return [-1.0, 0.0];
    }
    let angle = PI * (2 * k + 1) as f64 / (2 * order) as f64;
    [-sin(angle), cos(angle)]
}

/// c_k = Π_{j ≠ k} p_j/(p_j − p_k) over all poles, those of the lower half included.
fn residue(k: usize, order: usize) -> [f64; 2] {
    let p = pole(k, order);
    let mut c = [1.0, 0.0];
    for j in 0..order.div_ceil(2) {
        let [re, im] = pole(j, order);
        if j != k {
            c = times(c, quotient([re, im], [re - p[0], im - p[1]]));
        }
        if 2 * j + 1 != order {
            c = times(c, quotient([re, -im], [re - p[0], -im - p[1]]));
        }
    }
    c
}

fn times(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn quotient(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let square = b[0] * b[0] + b[1] * b[1];
    [(a[0] * b[0] + a[1] * b[1]) / square, (a[1] * b[0] - a[0] * b[1]) / square]
}

/// Real part of the weighted sum of the parts.
fn output(coefficients: &[f64], states: &[[f64; 2]]) -> f64 {
    let (parts, _) = coefficients.as_chunks::<4>();
    let terms = states.iter().zip(parts);
    terms.fold(0.0, |y, ([re, im], [_, _, c, s])| y + c * re - s * im)
}

impl Component for SensorButterworth {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        {
            let parts = order(structure).div_ceil(2);
            Sizes { coefficients: 4 * parts, states: 2 * parts }
        }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[bandwidth] = parameters else { return Err(WRONG_LENGTH) };
        positive_frequency("bandwidth", bandwidth)?;
        let order = order(structure);
        let (parts, _) = coefficients.as_chunks_mut::<4>();
        for (k, part) in parts.iter_mut().enumerate() {
            let pole = pole(k, order);
            let residue = residue(k, order);
            // A real pole counts once, a pair of poles twice.
            let twice = if 2 * k + 1 == order { 1.0 } else { 2.0 };
            let [decay, turn] =
                [TAU * bandwidth * period * pole[0], TAU * bandwidth * period * pole[1]];
            let remain = [exp(decay) * cos(turn), exp(decay) * sin(turn)];
            *part = [remain[0], remain[1], twice * residue[0], twice * residue[1]];
        }
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[x], [y]) = (inputs, outputs) else { return };
        let (states, _) = state.as_chunks_mut::<2>();
        states.fill([x, 0.0]);
        *y = output(coefficients, states);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[x], [y]) = (inputs, outputs) else { return };
        let (states, _) = state.as_chunks_mut::<2>();
        let (parts, _) = coefficients.as_chunks::<4>();
        for ([re, im], [decay, turn, ..]) in states.iter_mut().zip(parts) {
            // z ← x + e^(pT)·(z − x): the pole's part, scaled to a static gain of 1.
            let (a, b) = (*re - x, *im);
            (*re, *im) = (x + decay * a - turn * b, turn * a + decay * b);
        }
        *y = output(coefficients, states);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{SENSOR_SECOND_ORDER, SensorLag};
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn order_one_and_two_are_the_plain_lag_and_the_flat_second_order() {
        let signal = Random::new(3).signal(-1.0, 1.0, 300);
        let run = |component: &'static dyn Component, s: &[f64], p: &[f64]| {
            Instance::new(component, s, p, 1e-3).unwrap().response(0.3, &signal)
        };
        let one = run(&SensorButterworth, &[1.0], &[40.0]);
        let lag = run(&SensorLag, &[], &[40.0]);
        let two = run(&SensorButterworth, &[2.0], &[40.0]);
        let flat = run(&SENSOR_SECOND_ORDER, &[], &[40.0, core::f64::consts::FRAC_1_SQRT_2]);
        for n in 0..300 {
            assert!((one[n] - lag[n]).abs() < 1e-12 && (two[n] - flat[n]).abs() < 1e-12);
        }
    }

    #[test]
    fn the_gain_is_that_of_the_definition_for_all_orders() {
        let period = 1e-5;
        for order in 1..=8i32 {
            for f in [50.0, 100.0, 200.0] {
                let p = [100.0];
                let mut filter =
                    Instance::new(&SensorButterworth, &[f64::from(order)], &p, period).unwrap();
                filter.rest(&[0.0]);
                let (mut re, mut im) = (0.0, 0.0);
                let settle = 20_000;
                for n in 0..settle + 20_000 {
                    let phase = TAU * f * period * f64::from(n);
                    let y = filter.step(&[phase.sin()]);
                    if n >= settle {
                        re += y * phase.sin() / 10_000.0;
                        im += y * phase.cos() / 10_000.0;
                    }
                }
                let expected = (1.0 / (1.0 + (f / 100.0).powi(2 * order))).sqrt();
                let gain = re.hypot(im);
                assert!((gain - expected).abs() < 2e-4, "order {order}, {f} Hz: {gain} {expected}");
            }
        }
    }

    #[test]
    fn a_held_input_is_read_as_it_is() {
        for order in 1..=8 {
            let mut filter =
                Instance::new(&SensorButterworth, &[f64::from(order)], &[40.0], 1e-3).unwrap();
            assert!((filter.rest(&[3.0]) - 3.0).abs() < 1e-12);
            assert!((filter.step(&[3.0]) - 3.0).abs() < 1e-12);
        }
    }
}

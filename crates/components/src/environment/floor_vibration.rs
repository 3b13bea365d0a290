//! Floor vibration: noise through the mode of the floor or of the table.
//!
//! `y = x + n(t)`, `n″ + 2ζω n′ + ω² n = ω²·(white noise)`
//!
//! * rms in position: standard deviation of n; frequency in Hz and damping: of the mode that shapes
//!   it (floor 5–30 Hz, table 1–5 Hz); seed: any number, mixed with the component's place.
//! * The noise is held over each step and its strength set so that the standard deviation is rms at
//!   any period. It is a function of seed and step.
//! * State: n and n′/ω, at rest 0: the noise builds up within 1/(ζω).
//!
//! Limits: one mode; independent axes.

use libm::sqrt;
use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::linear::Transition;
use crate::random::normal;
use crate::rules::{WRONG_LENGTH, second_order};
use crate::{effects, phenomena};

/// The component `floor-vibration`.
pub struct FloorVibration;

static DECLARATION: Declaration = Declaration {
    kind: "floor-vibration",
    name: "floor",
    summary: "Floor vibration: noise through a mode",
    equation: "y = x + n; n'' + 2*damping*w*n' + w^2*n = w^2*white noise; w = 2*pi*frequency",
    reference: "C. G. Gordon, Proc. SPIE 1619 (1992) 71-85 (levels)",
    stage: Stage::Environment,
    effect: Some(&effects::FLOOR_VIBRATION),
    phenomena: &[&phenomena::FLOOR_VIBRATION],
    parameters: &[
        Quantity::new("rms", "{position}", "Standard deviation").min(0.0).fitted(),
        Quantity::new("frequency", "Hz", "Frequency of the mode").start(10.0).min(0.0),
        Quantity::new("damping", "1", "Damping ratio of the mode").start(0.1).min(0.0),
        Quantity::new("seed", "1", "Seed of the noise").start(1.0).seed(),
    ],
    ..Declaration::PATH
};

/// Variance of the mode driven by held white noise of variance 1: the first entry of the P that
/// solves P = A·P·Aᵀ + B·Bᵀ, by doubling: after k rounds the sum has 2ᵏ terms.
fn variance(t: Transition) -> f64 {
    let mut a = [t.same, t.cross, -t.cross, t.rate];
    let b = [1.0 - t.same, t.cross];
    let mut p = [b[0] * b[0], b[0] * b[1], b[1] * b[1]];
    for _ in 0..64 {
        let [a11, a12, a21, a22] = a;
        let [p11, p12, p22] = p;
        // A·P, then (A·P)·Aᵀ.
        let [m11, m12] = [a11 * p11 + a12 * p12, a11 * p12 + a12 * p22];
        let [m21, m22] = [a21 * p11 + a22 * p12, a21 * p12 + a22 * p22];
        p = [p11 + m11 * a11 + m12 * a12, p12 + m11 * a21 + m12 * a22, p22 + m21 * a21 + m22 * a22];
        a = [
            a11 * a11 + a12 * a21,
            a11 * a12 + a12 * a22,
            a21 * a11 + a22 * a21,
            a21 * a12 + a22 * a22,
        ];
    }
    p[0]
}

impl Component for FloorVibration {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 5, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[rms, frequency, damping, seed], [same, cross, rate, strength, key]) =
            (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        second_order(frequency, damping, period)?;
        let t = Transition::new(frequency, damping, period);
        (*same, *cross, *rate) = (t.same, t.cross, t.rate);
        (*strength, *key) = (rms / sqrt(variance(t)), seed);
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[x], [n, v], [y]) = (inputs, state, outputs) else { return };
        (*n, *v) = (0.0, 0.0);
        *y = x;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[same, cross, rate, strength, seed], &[x], [n, v], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let target = strength * normal(seed, 0, tick.index);
        let (e, scaled_rate) = Transition { same, cross, rate }.apply(*n - target, *v);
        (*n, *v) = (target + e, scaled_rate);
        *y = x + *n;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn has_its_standard_deviation_at_every_step() {
        for period in [1e-3, 5e-3, 0.03] {
            let p = [2.5, 10.0, 0.2, 7.0];
            let mut floor = Instance::new(&FloorVibration, &[], &p, period).unwrap();
            floor.rest(&[1.0]);
            let count = (2000.0 / period) as u32;
            let mut sum = 0.0;
            for _ in 0..count {
                let n = floor.step(&[1.0]) - 1.0;
                sum += n * n;
            }
            let rms = (sum / f64::from(count)).sqrt();
            assert!((rms / 2.5 - 1.0).abs() < 0.03, "period {period}: {rms}");
        }
    }
}

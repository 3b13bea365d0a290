//! A resonance with its antiresonance, as a sensor beside the actuator sees it.
//!
//! `G(s) = (s²/ω_z² + 2ζ_z·s/ω_z + 1)/(s²/ω_p² + 2ζ_p·s/ω_p + 1)`
//!
//! * frequency, damping: of the resonance (ω_p, ζ_p); zero_frequency, zero_damping: of the
//!   antiresonance (ω_z, ζ_z), below the resonance for a collocated pair and above it for a
//!   non-collocated one. Static gain 1; gain (ω_p/ω_z)² far above both.
//! * State: x and x′/ω_p of the resonance. Exact at any period, as the input is held over a step.
//!
//! Limits: the part that follows at once is as fast as the input.

use model::{Component, Declaration, Quantity, Role, Sizes, Stage, Tick, Violation};

use crate::linear::Transition;
use crate::rules::{WRONG_LENGTH, positive_frequency, second_order};
use crate::{effects, phenomena};

/// The component `collocated-mode`.
pub struct CollocatedMode;

static DECLARATION: Declaration = Declaration {
    kind: "collocated-mode",
    name: "mode",
    summary: "Resonance with its antiresonance",
    equation: "G(s) = (s^2/wz^2 + 2*zero_damping*s/wz + 1)/(s^2/wp^2 + 2*damping*s/wp + 1); wp = \
               2*pi*frequency; wz = 2*pi*zero_frequency",
    reference: "A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 2",
    stage: Stage::Mechanics,
    effect: Some(&effects::EXTRA_MODE),
    phenomena: &[&phenomena::SECOND_MODE],
    parameters: &[
        Quantity::new("frequency", "Hz", "Natural frequency of the resonance")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio of the resonance")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .min(0.0)
            .fitted(),
        Quantity::new("zero_frequency", "Hz", "Natural frequency of the antiresonance")
            .min(0.0)
            .fitted(),
        Quantity::new("zero_damping", "1", "Damping ratio of the antiresonance").min(0.0).fitted(),
    ],
    ..Declaration::PATH
};

impl Component for CollocatedMode {
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
        let (&[frequency, damping, zero, zero_damping], [same, cross, rate, direct, slope]) =
            (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        second_order(frequency, damping, period)?;
        positive_frequency("zero_frequency", zero)?;
        let t = Transition::new(frequency, damping, period);
        (*same, *cross, *rate) = (t.same, t.cross, t.rate);
        // s²x = ω_p²·(u − x) − 2ζ_p·ω_p·x′ takes the second derivative out of the numerator.
        let ratio = frequency / zero;
        *direct = ratio * ratio;
        *slope = 2.0 * ratio * (zero_damping - damping * ratio);
        Ok(())
    }

    #[cfg_attr(feature = "records", inline)]
    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [x, v], [y]) = (inputs, state, outputs) else { return };
        (*x, *v) = (u, 0.0);
        *y = u;
    }

    #[cfg_attr(feature = "records", inline)]
    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[same, cross, rate, direct, slope], &[u], [x, v], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let (e, scaled_rate) = Transition { same, cross, rate }.apply(*x - u, *v);
        (*x, *v) = (u + e, scaled_rate);
        *y = *x - direct * e + slope * *v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    use crate::testing::{Instance, Random};

    #[test]
    fn gain_and_phase_are_those_of_the_transfer_function() {
        let period = 1e-6;
        let p = [300.0, 0.05, 200.0, 0.03];
        for f in [50.0, 200.0, 300.0, 1000.0] {
            let mut mode = Instance::new(&CollocatedMode, &[], &p, period).unwrap();
            mode.rest(&[0.0]);
            let settle = 100_000;
            let (mut re, mut im) = (0.0, 0.0);
            for n in 0..settle + 100_000 {
                let phase = TAU * f * period * f64::from(n);
                let y = mode.step(&[phase.sin()]);
                if n >= settle {
                    re += y * phase.sin() / 50_000.0;
                    im += y * phase.cos() / 50_000.0;
                }
            }
            let part = |w: f64, d: f64| (1.0 - (f / w).powi(2), 2.0 * d * f / w);
            let ((a, b), (c, d)) = (part(200.0, 0.03), part(300.0, 0.05));
            let square = c * c + d * d;
            let (x, y) = ((a * c + b * d) / square, (b * c - a * d) / square);
            assert!(
                (re - x).hypot(im - y) < 0.02 * x.hypot(y) + 1e-3,
                "{f} Hz: {re} {im}, {x} {y}"
            );
        }
    }

    #[test]
    fn equal_pole_and_zero_cancel() {
        let p = [300.0, 0.05, 300.0, 0.05];
        let mut mode = Instance::new(&CollocatedMode, &[], &p, 1e-4).unwrap();
        mode.rest(&[0.0]);
        for u in Random::new(3).signal(-1.0, 1.0, 200) {
            assert!((mode.step(&[u]) - u).abs() < 1e-12);
        }
    }
}

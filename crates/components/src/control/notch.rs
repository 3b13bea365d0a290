//! Notch: takes a resonance out of a signal.
//!
//! ```text
//! y = N(s)·u,  N(s) = (s² + 2·damping·depth·ω·s + ω²) / (s² + 2·damping·ω·s + ω²),  ω = 2π·frequency
//! ```
//!
//! * frequency in Hz; damping of the poles gives the width; depth is what is left of a signal at the
//!   frequency: 0 takes it out, 1 leaves it as it is.
//! * Bilinear transform with the notch's frequency kept (prewarped); the static gain is exactly 1.
//! * May be changed during a run. At rest y = u.
//! * It fits anywhere on a controller's path: in front of the inverse it shapes the reference of the
//!   feedforward, behind it the command.
//!
//! Source: K. J. Åström, T. Hägglund, Advanced PID Control, ISA 2006, ch. 8.

use core::f64::consts::PI;

use libm::tan;
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use crate::rules::{WRONG_LENGTH, require};

/// The component `notch`.
pub struct Notch;

static DECLARATION: Declaration = Declaration {
    kind: "notch",
    name: "notch",
    summary: "Notch filter against a resonance",
    equation: "y = (s^2 + 2*damping*depth*w*s + w^2)/(s^2 + 2*damping*w*s + w^2)*u; w = 2*pi*frequency",
    reference: "K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, ch. 8",
    stage: Stage::Control,
    conversion: Conversion::None,
    effect: None,
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: &[],
    parameters: &[
        Quantity::new("frequency", "Hz", "Frequency that is taken out").min(0.0).tunable(),
        Quantity::new("damping", "1", "Damping ratio of the poles").start(0.5).min(0.0).tunable(),
        Quantity::new("depth", "1", "What is left at the frequency")
            .start(0.0)
            .min(0.0)
            .max(1.0)
            .tunable(),
    ],
};

impl Component for Notch {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 4, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[frequency, damping, depth], [b0, b1, b2, a2]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        require(
            frequency > 0.0 && frequency * period < 0.5,
            "frequency",
            frequency,
            "must be above 0 and below half the controller's sampling frequency",
        )?;
        require(damping > 0.0, "damping", damping, "must be above 0; 0.5 is usual")?;
        let w = tan(PI * frequency * period);
        let (square, broad) = (w * w, 2.0 * damping * w);
        let sum = 1.0 + square + broad;
        // b1 is a1 too.
        *b0 = (1.0 + square + depth * broad) / sum;
        *b1 = 2.0 * (square - 1.0) / sum;
        *b2 = (1.0 + square - depth * broad) / sum;
        *a2 = (1.0 + square - broad) / sum;
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[b0, _, b2, a2], &[u], [first, second], [y]) = (coefficients, inputs, state, outputs)
        else {
            return;
        };
        *y = u;
        (*first, *second) = ((1.0 - b0) * u, (b2 - a2) * u);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[b0, b1, b2, a2], &[u], [first, second], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        *y = b0 * u + *first;
        *first = b1 * (u - *y) + *second;
        *second = b2 * u - a2 * *y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    /// Amplitude behind the notch of a unit sine, once it has settled.
    fn amplitude(parameters: [f64; 3], frequency: f64, period: f64) -> f64 {
        let mut notch = Instance::new(&Notch, &[], &parameters, period).unwrap();
        let samples = 40_000;
        let sine: std::vec::Vec<f64> = (0..samples)
            .map(|n| (core::f64::consts::TAU * frequency * period * f64::from(n)).sin())
            .collect();
        let y = notch.response(0.0, &sine);
        let tail = &y[samples as usize / 2..];
        (2.0 * tail.iter().map(|y| y * y).sum::<f64>() / tail.len() as f64).sqrt()
    }

    #[test]
    fn it_takes_out_its_frequency_and_leaves_the_rest() {
        let (period, frequency) = (1e-4, 800.0);
        assert!(amplitude([frequency, 0.5, 0.0], frequency, period) < 1e-9);
        assert!((amplitude([frequency, 0.5, 0.3], frequency, period) - 0.3).abs() < 1e-6);
        for other in [10.0, 4900.0] {
            let left = amplitude([frequency, 0.5, 0.0], other, period);
            assert!((left - 1.0).abs() < 0.02, "{other} Hz: {left}");
        }
    }

    #[test]
    fn a_constant_passes() {
        let mut notch = Instance::new(&Notch, &[], &[120.0, 0.3, 0.1], 1e-3).unwrap();
        assert_eq!(notch.rest(&[0.7]), 0.7);
        for _ in 0..1000 {
            assert!((notch.step(&[0.7]) - 0.7).abs() < 1e-14);
        }
    }

    #[test]
    fn frequencies_beyond_half_the_sampling_rate_are_refused() {
        let found = Instance::new(&Notch, &[], &[500.0, 0.5, 0.0], 1e-3).err().unwrap();
        assert_eq!(found.quantity, "frequency");
    }
}

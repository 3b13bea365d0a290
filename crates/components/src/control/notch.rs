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
//! * `feedback-notch` has the same filter on the reference and on the measured position of the law behind it, and lets
//!   the path through: the loop is that of a notch behind the law, but feedforward and limits are not filtered.
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
    parameters: &PARAMETERS,
    ..Declaration::PATH
};

const PARAMETERS: [Quantity; 3] = [
    Quantity::new("frequency", "Hz", "Frequency of the notch").min(0.0).tunable(),
    Quantity::new("damping", "1", "Damping ratio of the poles").start(0.5).min(0.0).tunable(),
    Quantity::new("depth", "1", "Gain at that frequency").start(0.0).min(0.0).max(1.0).tunable(),
];

/// The component `feedback-notch`.
pub struct FeedbackNotch;

static FEEDBACK: Declaration = Declaration {
    kind: "feedback-notch",
    name: "notch",
    summary: "Notch filter against a resonance, on the error of the law behind it",
    equation: "path = u; reference = N*reference; measured = N*measured; N = (s^2 + 2*damping*depth*w*s + \
               w^2)/(s^2 + 2*damping*w*s + w^2); w = 2*pi*frequency",
    reference: "K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, ch. 8",
    stage: Stage::Control,
    conversion: Conversion::Control,
    inputs: &[Input::PATH, Input::axis_at_rest("reference"), Input::axis_at_rest("measured")],
    outputs: &[
        Output::PATH,
        Output { name: "reference", published: None },
        Output { name: "measured", published: None },
    ],
    parameters: &PARAMETERS,
    ..Declaration::PATH
};

impl Component for Notch {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[("frequency", &[480.0]), ("damping", &[0.5]), ("depth", &[0.1])]
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
        let (&[u], [y]) = (inputs, outputs) else { return };
        *y = settled(coefficients, state, u);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[u], [y]) = (inputs, outputs) else { return };
        *y = filtered(coefficients, state, u);
    }
}

/// The state of the filter at rest, and its output.
fn settled(coefficients: &[f64], state: &mut [f64], u: f64) -> f64 {
    if let (&[b0, _, b2, a2], [first, second]) = (coefficients, state) {
        (*first, *second) = ((1.0 - b0) * u, (b2 - a2) * u);
    }
    u
}

/// A step of the filter.
fn filtered(coefficients: &[f64], state: &mut [f64], u: f64) -> f64 {
    let (&[b0, b1, b2, a2], [first, second]) = (coefficients, state) else { return u };
    let y = b0 * u + *first;
    *first = b1 * (u - y) + *second;
    *second = b2 * u - a2 * y;
    y
}

impl Component for FeedbackNotch {
    fn declaration(&self) -> &'static Declaration {
        &FEEDBACK
    }

    fn example(&self) -> model::Example {
        &[("frequency", &[480.0]), ("damping", &[0.5]), ("depth", &[0.1])]
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 4, states: 4 }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        Notch.prepare(structure, parameters, period, coefficients)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u, wanted, found], [path, reference, measured]) = (inputs, outputs) else { return };
        let Some((one, other)) = state.split_at_mut_checked(2) else { return };
        *path = u;
        *reference = settled(coefficients, one, wanted);
        *measured = settled(coefficients, other, found);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[u, wanted, found], [path, reference, measured]) = (inputs, outputs) else { return };
        let Some((one, other)) = state.split_at_mut_checked(2) else { return };
        *path = u;
        *reference = filtered(coefficients, one, wanted);
        *measured = filtered(coefficients, other, found);
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
    fn on_the_feedback_it_filters_reference_and_position_but_not_the_path() {
        let parameters = [80.0, 0.4, 0.1];
        let mut alone = [(); 2].map(|()| Instance::new(&Notch, &[], &parameters, 1e-3).unwrap());
        let mut notch = Instance::new(&FeedbackNotch, &[], &parameters, 1e-3).unwrap();
        let inputs = |k: i32| [f64::from(k), f64::from(k * k % 7) - 2.0, f64::from(k % 5) + 0.5];
        for k in 0..50 {
            let [u, wanted, found] = inputs(k);
            let each = [(0, wanted), (1, found)].map(|(at, value)| {
                let own = &mut alone[at];
                if k == 0 { own.rest(&[value]) } else { own.step(&[value]) }
            });
            let path = if k == 0 { notch.rest(&inputs(k)) } else { notch.step(&inputs(k)) };
            assert_eq!((path, notch.outputs[1], notch.outputs[2]), (u, each[0], each[1]), "{k}");
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

//! Linear feedforward: command proportional to the reference position.
//!
//! `u = gain · (y − offset)`
//!
//! * gain in command per position; its exact value for a plant `y = g·u + offset` is 1/g.
//! * No state. The gain may be changed during a run.
//!
//! Limits: no hysteresis, no dynamics; the baseline against which inverse models are judged.

use model::{Component, Conversion, Declaration, Quantity, Sizes, Stage, Violation};

use crate::phenomena;
use crate::rules::WRONG_LENGTH;

/// The component `feedforward-gain`.
pub struct FeedforwardGain;

static DECLARATION: Declaration = Declaration {
    kind: "feedforward-gain",
    name: "feedforward",
    summary: "Linear feedforward: command proportional to the reference position",
    equation: "u = gain*(y - offset)",
    reference: "inverse of a linear actuator",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    phenomena: &[&phenomena::CONTROLLER_DIFFERENCE],
    parameters: &[
        Quantity::new("gain", "{command}/{position}", "Command per position").tunable().fitted(),
        Quantity::new("offset", "{position}", "Position at zero command")
            .start(0.0)
            .tunable()
            .fitted(),
    ],
    ..Declaration::PATH
};

impl Component for FeedforwardGain {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[("gain", &[15.0]), ("offset", &[0.3])]
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 2, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        if parameters.len() != coefficients.len() {
            return Err(WRONG_LENGTH);
        }
        coefficients.copy_from_slice(parameters);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[gain, offset], &[y], [u]) = (coefficients, inputs, outputs) else { return };
        *u = gain * (y - offset);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator::ACTUATOR_GAIN;
    use crate::testing::Instance;

    #[test]
    fn is_the_inverse_of_a_linear_actuator() {
        let mut actuator = Instance::new(&ACTUATOR_GAIN, &[], &[0.25, 3.0], 1e-3).unwrap();
        let mut feedforward = Instance::new(&FeedforwardGain, &[], &[4.0, 3.0], 1e-3).unwrap();
        for u in [-7.5, 0.0, 120.0] {
            assert_eq!(feedforward.step(&[actuator.step(&[u])]), u);
        }
    }
}

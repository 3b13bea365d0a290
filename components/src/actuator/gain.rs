//! A linear actuator: position proportional to command.
//!
//! `y = gain · u + offset`
//!
//! * gain in position per command (effective d33 times the number of layers, times every other
//!   constant factor of the path that data cannot separate).
//! * No state.
//!
//! Limits: no hysteresis, no dynamics; a linear baseline, or the actuator in front of a mode whose
//! gain is 1.

use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use crate::effects;
use crate::rules::WRONG_LENGTH;

/// The component `actuator-gain`.
pub struct ActuatorGain;

static DECLARATION: Declaration = Declaration {
    kind: "actuator-gain",
    name: "gain",
    summary: "Linear actuator: position proportional to command",
    equation: "y = gain*u + offset",
    reference: "linear piezoelectric effect, IEEE Std 176-1987",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::ACTUATOR_GAIN),
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: &[],
    parameters: &[
        Quantity::new("gain", "{position}/{command}", "Position per command").fitted(),
        Quantity::new("offset", "{position}", "Position at zero command").start(0.0).fitted(),
    ],
};

impl Component for ActuatorGain {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
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
        let (&[gain, offset], &[u], [y]) = (coefficients, inputs, outputs) else { return };
        *y = gain * u + offset;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        self.rest(coefficients, inputs, state, outputs);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn position_is_gain_times_command_plus_offset() {
        let mut gain = Instance::new(&ActuatorGain, &[], &[0.25, 3.0], 1e-3).unwrap();
        assert_eq!(gain.rest(&[8.0]), 5.0);
        assert_eq!(gain.step(&[-4.0]), 2.0);
    }
}

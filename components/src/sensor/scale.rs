//! Gain and offset of the sensor.
//!
//! `y = gain·x + offset`
//!
//! * gain without unit; offset in position. No state.
//!
//! Limits: position and command alone cannot tell this gain from the actuator's.

use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use crate::effects;
use crate::rules::WRONG_LENGTH;

/// The component `sensor-scale`.
pub struct SensorScale;

static DECLARATION: Declaration = Declaration {
    kind: "sensor-scale",
    name: "scale",
    summary: "Gain and offset of the sensor",
    equation: "y = gain*x + offset",
    reference: "linear sensor",
    stage: Stage::Sensor,
    conversion: Conversion::None,
    effect: Some(&effects::ACTUATOR_GAIN),
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: &[],
    parameters: &[
        Quantity::new("gain", "1", "Reading per position").start(1.0).fitted(),
        Quantity::new("offset", "{position}", "Reading at position 0").start(0.0).fitted(),
    ],
};

impl Component for SensorScale {
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
        if coefficients.len() != parameters.len() {
            return Err(WRONG_LENGTH);
        }
        coefficients.copy_from_slice(parameters);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[gain, offset], &[x], [y]) = (coefficients, inputs, outputs) else { return };
        *y = gain * x + offset;
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
    fn scales_and_shifts() {
        let mut scale = Instance::new(&SensorScale, &[], &[1.25, -3.0], 1e-3).unwrap();
        assert_eq!(scale.rest(&[8.0]), 7.0);
        assert_eq!(scale.step(&[4.0]), 2.0);
    }
}

//! Temperature dependence of the actuator's gain.
//!
//! `y = x·[1 + coefficient·(temperature − reference)]`
//!
//! * coefficient in 1/K (0.0005–0.003); temperature and reference in degC or K. The temperature may
//!   be changed during a run, and so serves as an input.
//! * No state.
//!
//! Limits: linear; it scales the whole path, as sensor data cannot tell it from a sensor's gain.

use model::{Component, Declaration, Quantity, Sizes, Stage, Violation};

use crate::rules::WRONG_LENGTH;
use crate::{effects, phenomena};

/// The component `actuator-temperature`.
pub struct ActuatorTemperature;

static DECLARATION: Declaration = Declaration {
    kind: "actuator-temperature",
    name: "temperature",
    summary: "Temperature dependence of the actuator's gain",
    equation: "y = x*(1 + coefficient*(temperature - reference))",
    reference: "makers' tables of multilayer actuators",
    stage: Stage::Actuator,
    effect: Some(&effects::ACTUATOR_GAIN),
    phenomena: &[&phenomena::GAIN_OVER_TEMPERATURE],
    parameters: &[
        Quantity::new("coefficient", "1/K", "Relative change of the gain per kelvin").fitted(),
        Quantity::new("temperature", "degC", "Temperature of the actuator")
            .start(20.0)
            .min(-273.15)
            .tunable(),
        Quantity::new("reference", "degC", "Temperature at which the gain is 1")
            .start(20.0)
            .min(-273.15),
    ],
    ..Declaration::PATH
};

impl Component for ActuatorTemperature {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 1, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[coefficient, temperature, reference], [gain]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        *gain = 1.0 + coefficient * (temperature - reference);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[gain], &[x], [y]) = (coefficients, inputs, outputs) else { return };
        *y = gain * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn the_gain_follows_the_temperature_during_the_run() {
        let mut gain =
            Instance::new(&ActuatorTemperature, &[], &[0.002, 293.15, 293.15], 1e-3).unwrap();
        assert_eq!(gain.rest(&[5.0]), 5.0);
        gain.set(&[0.002, 303.15, 293.15]).unwrap();
        assert!((gain.step(&[5.0]) - 5.1).abs() < 1e-12);
    }
}

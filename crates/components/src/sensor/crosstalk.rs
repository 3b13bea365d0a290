//! Electrical feed-through from the command to the reading.
//!
//! `y = x + gain·u + rate_gain·u̇`
//!
//! * gain in position per command, rate_gain in position-seconds per command: ohmic and capacitive
//!   coupling; u is the axis' command, u̇ its change over the step.
//! * State: the last command. At rest u̇ = 0.
//!
//! Limits: before any amplifier: the command as it enters the plant.

use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Tick, Violation};

use crate::rules::WRONG_LENGTH;
use crate::{effects, phenomena};

/// The component `crosstalk`.
pub struct Crosstalk;

static DECLARATION: Declaration = Declaration {
    kind: "crosstalk",
    name: "crosstalk",
    summary: "Electrical feed-through from the command to the reading",
    equation: "y = x + gain*u + rate_gain*u'",
    reference: "H. W. Ott, Electromagnetic Compatibility Engineering, Wiley 2009, ch. 2",
    stage: Stage::Sensor,
    effect: Some(&effects::CROSSTALK),
    phenomena: &[&phenomena::CROSSTALK],
    inputs: &[Input::PATH, Input { at_rest: true, ..Input::axis("command") }],
    parameters: &[
        Quantity::new("gain", "{position}/{command}", "Reading per command").start(0.0).fitted(),
        Quantity::new("rate_gain", "{position}.s/{command}", "Reading per rate of the command")
            .start(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};

impl Component for Crosstalk {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 2, states: 1 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[gain, rate_gain], [direct, change]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        (*direct, *change) = (gain, rate_gain / period);
        Ok(())
    }

    #[cfg_attr(feature = "records", inline)]
    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[gain, _], &[x, u], [last], [y]) = (coefficients, inputs, state, outputs) else {
            return;
        };
        *last = u;
        *y = x + gain * u;
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
        let (&[gain, change], &[x, u], [last], [y]) = (coefficients, inputs, state, outputs) else {
            return;
        };
        *y = x + gain * u + change * (u - *last);
        *last = u;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn couples_the_command_and_its_rate() {
        let mut model = Instance::new(&Crosstalk, &[], &[0.5, 0.01], 0.1).unwrap();
        assert_eq!(model.rest(&[1.0, 2.0]), 2.0);
        assert!((model.step(&[1.0, 4.0]) - (1.0 + 2.0 + 0.01 * 20.0)).abs() < 1e-12);
        assert_eq!(model.step(&[1.0, 4.0]), 3.0);
    }
}

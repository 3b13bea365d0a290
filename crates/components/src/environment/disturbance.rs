//! A disturbance from outside, as from a log that is played back.
//!
//! `y = x + gain·d`
//!
//! * d is the axis' input `disturbance`, in position; gain scales it.
//! * No state.

use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Violation};

use crate::phenomena;
use crate::rules::WRONG_LENGTH;

/// The component `disturbance`.
pub struct Disturbance;

static DECLARATION: Declaration = Declaration {
    kind: "disturbance",
    name: "disturbance",
    summary: "External disturbance of the position, for example played back from a log",
    equation: "y = x + gain*disturbance",
    reference: "definition",
    stage: Stage::Environment,
    phenomena: &[&phenomena::DISTURBANCE],
    inputs: &[Input::PATH, Input::axis_at_rest("disturbance")],
    parameters: &[Quantity::new("gain", "1", "Factor of the disturbance").start(1.0)],
    ..Declaration::PATH
};

impl Component for Disturbance {
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
        let (&[gain], [own]) = (parameters, coefficients) else { return Err(WRONG_LENGTH) };
        *own = gain;
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[gain], &[x, d], [y]) = (coefficients, inputs, outputs) else { return };
        *y = x + gain * d;
    }
}

//! Backlash: clearance or a loose preload, as a play of constant width.
//!
//! `y ← max(x − width/2, min(x + width/2, y))`
//!
//! * width in position: the clearance.
//! * State: y. At rest: moved monotonically from the middle (0 at 0).
//!
//! Limits: no impact dynamics.

use crate::hysteresis::play::play;
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use crate::effects;
use crate::rules::WRONG_LENGTH;

/// The component `backlash`.
pub struct Backlash;

static DECLARATION: Declaration = Declaration {
    kind: "backlash",
    name: "backlash",
    summary: "Clearance, as a play of constant width",
    equation: "y = max(x - width/2, min(x + width/2, y))",
    reference: "G. Tao, P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor \
                Nonlinearities, Wiley 1996",
    stage: Stage::Mechanics,
    conversion: Conversion::None,
    effect: Some(&effects::BACKLASH),
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: &[],
    parameters: &[Quantity::new("width", "{position}", "Clearance").min(0.0).fitted()],
};

impl Component for Backlash {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 1, states: 1 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[width], [half]) = (parameters, coefficients) else { return Err(WRONG_LENGTH) };
        *half = 0.5 * width;
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[half], &[x], [position], [y]) = (coefficients, inputs, state, outputs) else {
            return;
        };
        *position = play(x, half, 0.0);
        *y = *position;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[half], &[x], [position], [y]) = (coefficients, inputs, state, outputs) else {
            return;
        };
        *position = play(x, half, *position);
        *y = *position;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn motion_below_the_clearance_is_lost() {
        let mut model = Instance::new(&Backlash, &[], &[0.5], 1e-3).unwrap();
        assert_eq!(model.rest(&[2.0]), 1.75);
        assert_eq!(model.step(&[1.75]), 1.75);
        assert_eq!(model.step(&[1.5]), 1.75);
        assert_eq!(model.step(&[1.0]), 1.25);
        assert_eq!(model.step(&[3.0]), 2.75);
    }
}

//! Backlash: clearance or a loose preload, as a play of constant width.
//!
//! `y = bridge·x + (1 − bridge)·P`, `P ← max(x − width/2, min(x + width/2, P))`
//!
//! * width in position: the clearance.
//! * bridge: the share of a motion that passes within the clearance, through a spring (a preload) across it.
//! * State: P. At rest: moved monotonically from the middle (0 at 0).
//!
//! Limits: no impact dynamics.

use crate::hysteresis::play::{Drive, Threshold, play};
use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::rules::WRONG_LENGTH;
use crate::{effects, phenomena};

/// The component `backlash`.
pub struct Backlash;

static DECLARATION: Declaration = Declaration {
    kind: "backlash",
    name: "backlash",
    summary: "Clearance, as a play of constant width",
    equation: "y = bridge x + (1 - bridge) P, P = max(x - width/2, min(x + width/2, P))",
    reference: "G. Tao, P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor \
                Nonlinearities, Wiley 1996",
    stage: Stage::Mechanics,
    effect: Some(&effects::BACKLASH),
    phenomena: &[&phenomena::BACKLASH],
    parameters: &[
        Quantity::new("width", "{position}", "Clearance").min(0.0).fitted(),
        Quantity::new("bridge", "1", "Share of a motion that passes within the clearance")
            .start(0.0)
            .min(0.0)
            .max(1.0),
    ],
    ..Declaration::PATH
};

impl Component for Backlash {
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
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[width, bridge], [half, share]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        (*half, *share) = (0.5 * width, bridge);
        Ok(())
    }

    #[cfg_attr(feature = "records", inline)]
    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[half, bridge], &[x], [position], [y]) = (coefficients, inputs, state, outputs)
        else {
            return;
        };
        *position = play(Drive(x), Threshold(half), 0.0);
        *y = *position + bridge * (x - *position);
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
        let (&[half, bridge], &[x], [position], [y]) = (coefficients, inputs, state, outputs)
        else {
            return;
        };
        *position = play(Drive(x), Threshold(half), *position);
        *y = *position + bridge * (x - *position);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn motion_below_the_clearance_is_lost() {
        let mut model = Instance::new(&Backlash, &[], &[0.5, 0.0], 1e-3).unwrap();
        assert_eq!(model.rest(&[2.0]), 1.75);
        assert_eq!(model.step(&[1.75]), 1.75);
        assert_eq!(model.step(&[1.5]), 1.75);
        assert_eq!(model.step(&[1.0]), 1.25);
        assert_eq!(model.step(&[3.0]), 2.75);
    }

    #[test]
    fn a_spring_across_the_clearance_carries_its_share() {
        let mut model = Instance::new(&Backlash, &[], &[0.5, 0.25], 1e-3).unwrap();
        let first = model.rest(&[2.0]);
        assert_eq!(first, 0.25 * 2.0 + 0.75 * 1.75);
        // Within the clearance a quarter of the motion passes.
        assert!((model.step(&[1.6]) - (first - 0.25 * 0.4)).abs() < 1e-15);
        // Beyond it all of it.
        let beyond = model.step(&[1.0]);
        assert!((model.step(&[0.5]) - (beyond - 0.5)).abs() < 1e-15);
    }
}

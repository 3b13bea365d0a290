//! The mechanical port of an axis: position and velocity of its tip, in SI.
//!
//! ```text
//! tip = x,   tip_velocity = dx/dt
//! ```
//!
//! * x is the path's position at this place, behind the mechanics: the true one, without what couplings,
//!   surroundings and sensor add behind it. tip_velocity is the change of x over the step, its mean in it.
//! * The path passes unchanged. The force of the port is the input `force` of `load-force`, in N, positive
//!   on the tip towards greater positions. It is held over a step, so `force·tip_velocity·period` is exactly
//!   the work that it does on the axis in the step.
//! * State: the last x. At rest tip_velocity = 0.
//!
//! Limits: one degree of freedom, along the axis.

use model::{Component, Declaration, Output, Sizes, Stage, Tick, Violation};

use crate::phenomena;

/// The component `mechanical-port`.
pub struct MechanicalPort;

static DECLARATION: Declaration = Declaration {
    kind: "mechanical-port",
    name: "tip",
    summary: "Mechanical port of the axis: position and velocity of its tip as outputs, in SI",
    equation: "tip = x; tip_velocity = dx/dt",
    reference: "F. E. Cellier, Continuous System Modeling, Springer 1991, ch. 7",
    stage: Stage::Mechanics,
    phenomena: &[&phenomena::TIP_MOTION],
    outputs: &[
        Output::PATH,
        Output::published(
            "tip",
            "{si_position}",
            "Position of the tip behind the mechanics",
            false,
        ),
        Output::published(
            "tip_velocity",
            "{si_position}/s",
            "Velocity of the tip, mean of the step",
            false,
        ),
    ],
    ..Declaration::PATH
};

impl Component for MechanicalPort {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 0, states: 1 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        _parameters: &[f64],
        _period: f64,
        _coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[x], [last], [y, tip, velocity]) = (inputs, state, outputs) else { return };
        *last = x;
        (*y, *tip, *velocity) = (x, x, 0.0);
    }

    fn step(
        &self,
        _coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[x], [last], [y, tip, velocity]) = (inputs, state, outputs) else { return };
        (*y, *tip, *velocity) = (x, x, (x - *last) / tick.period);
        *last = x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn the_velocity_is_the_mean_of_the_step() {
        let mut port = Instance::new(&MechanicalPort, &[], &[], 1e-3).unwrap();
        assert_eq!(port.rest(&[2e-6]), 2e-6);
        assert_eq!(port.outputs, [2e-6, 2e-6, 0.0]);
        assert_eq!(port.step(&[5e-6]), 5e-6);
        assert_eq!(port.outputs[1], 5e-6);
        assert!((port.outputs[2] - 3e-3).abs() < 1e-18);
        port.step(&[5e-6]);
        assert_eq!(port.outputs[2], 0.0);
    }
}

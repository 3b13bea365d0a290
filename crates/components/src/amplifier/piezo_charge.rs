//! The electrical port of the actuator: voltage, charge and current.
//!
//! ```text
//! q = capacitance·v + transduction·x,   i = dq/dt
//! ```
//!
//! * v is the path's voltage at this place, x the axis' displacement behind the mechanics as it was
//!   at the previous hit (the displacement is computed later on the path); transduction is the
//!   force factor, in C per position = N per volt; i is the change of q over the step, the mean
//!   current in it.
//! * The path passes unchanged; outputs: voltage, charge, current of the axis.
//! * State: the last charge. At rest i = 0.
//!
//! Limits: linear capacitance, no losses; the voltage is imposed: the amplifier's reaction to the
//! current is the amplifier components' business.

use model::{Component, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation};

use crate::phenomena;
use crate::rules::WRONG_LENGTH;

/// The component `piezo-charge`.
pub struct PiezoCharge;

static DECLARATION: Declaration = Declaration {
    kind: "piezo-charge",
    name: "electrical",
    summary: "Electrical port of the actuator: voltage, charge and current as outputs",
    equation: "q = capacitance*v + transduction*x; i = dq/dt",
    reference: "M. Goldfarb, N. Celanovic, IEEE Control Systems 17 (1997) 69-79",
    stage: Stage::Amplifier,
    phenomena: &[&phenomena::CHARGE],
    inputs: &[Input::PATH, Input::axis_at_rest("displacement")],
    outputs: &[
        Output::PATH,
        Output::published("voltage", "{command}", "Voltage at the actuator", false),
        Output::published("charge", "C", "Charge on the actuator", false),
        Output::published("current", "A", "Current into the actuator, mean of the step", false),
    ],
    parameters: &[
        Quantity::new("capacitance", "C/{command}", "Capacitance at constant length")
            .min(0.0)
            .fitted(),
        Quantity::new("transduction", "C/{position}", "Charge per displacement")
            .start(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};

impl Component for PiezoCharge {
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
        let (&[capacitance, transduction], [c, n]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        (*c, *n) = (capacitance, transduction);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[c, n], &[v, x], [charge], [y, voltage, q, current]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        *charge = c * v + n * x;
        (*y, *voltage, *q, *current) = (v, v, *charge, 0.0);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[c, n], &[v, x], [charge], [y, voltage, q, current]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let before = *charge;
        *charge = c * v + n * x;
        (*y, *voltage, *q, *current) = (v, v, *charge, (*charge - before) / tick.period);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn charge_of_a_ramp_and_of_the_motion() {
        let mut port = Instance::new(&PiezoCharge, &[], &[2e-6, 3.0], 1e-3).unwrap();
        assert_eq!(port.rest(&[10.0, 1e-6]), 10.0);
        assert_eq!(port.outputs, [10.0, 10.0, 2e-6 * 10.0 + 3.0 * 1e-6, 0.0]);
        port.step(&[11.0, 1e-6]);
        assert!((port.outputs[3] - 2e-6 / 1e-3).abs() < 1e-15);
        port.step(&[11.0, 2e-6]);
        assert!((port.outputs[3] - 3.0 * 1e-6 / 1e-3).abs() < 1e-15);
    }
}

//! Reference filter: a low-pass of second order in front of a controller.
//!
//! `r_f = r/(1 + 2·damping·s/ω + s²/ω²)`, ω = 2π·frequency
//!
//! * Feedforward and feedback behind it both see r_f, so steps of the reference are smoothed before
//!   anything differentiates them.
//! * frequency in Hz, damping ≥ 0.1 (1 rises without overshoot); exact while the reference is held.
//! * At rest r_f = r.
//!
//! Source: K. J. Åström, T. Hägglund, Advanced PID Control, ISA 2006, ch. 5 (set-point filter).

use model::{Component, Declaration, Output, Quantity, Sizes, Stage, Tick, Violation};

use crate::linear::SecondOrder;
use crate::rules::{WRONG_LENGTH, require};

/// The component `reference-filter`.
pub struct ReferenceFilter;

static DECLARATION: Declaration = Declaration {
    kind: "reference-filter",
    name: "filter",
    summary: "Second-order low-pass for the reference of both feedforward and feedback",
    equation: "r_f + 2*damping*r_f'/w + r_f''/w^2 = r; w = 2*pi*frequency",
    reference: "K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, ch. 5",
    stage: Stage::Control,
    outputs: &[Output::PATH, Output { name: "reference", published: None }],
    parameters: &[
        Quantity::new("frequency", "Hz", "Natural frequency").min(0.0).tunable(),
        Quantity::new("damping", "1", "Damping ratio").start(1.0).min(0.1).tunable(),
    ],
    ..Declaration::PATH
};

impl Component for ReferenceFilter {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[("frequency", &[200.0]), ("damping", &[0.8])]
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: SecondOrder::COEFFICIENTS, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[frequency, damping] = parameters else { return Err(WRONG_LENGTH) };
        let rule = "must be above 0; omit the filter if nothing is to be smoothed";
        require(frequency > 0.0, "frequency", frequency, rule)?;
        let own = <&mut [f64; 4]>::try_from(coefficients).map_err(|_| WRONG_LENGTH)?;
        *own = SecondOrder::new(frequency, damping, 1.0, period).to_array();
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[r], [x, v]) = (inputs, state) else { return };
        (*x, *v) = (r, 0.0);
        outputs.fill(r);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Ok(own), &[r]) = (<[f64; 4]>::try_from(coefficients), inputs) else { return };
        let Ok(state) = <&mut [f64; 2]>::try_from(state) else { return };
        outputs.fill(SecondOrder::of(own).step(r, state));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn a_step_rises_as_the_closed_form_says() {
        let (period, frequency) = (1e-3, 10.0);
        let mut filter = Instance::new(&ReferenceFilter, &[], &[frequency, 1.0], period).unwrap();
        assert_eq!(filter.rest(&[2.0]), 2.0);
        filter.rest(&[0.0]);
        for n in 1..400 {
            let x = core::f64::consts::TAU * frequency * period * f64::from(n);
            let exact = 1.0 - (1.0 + x) * (-x).exp();
            assert!((filter.step(&[1.0]) - exact).abs() < 1e-12);
            assert_eq!(filter.outputs[0], filter.outputs[1]);
        }
    }
}

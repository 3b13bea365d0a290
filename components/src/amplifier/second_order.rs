//! Bandwidth of the amplifier, second order.
//!
//! `v″ + 2ζω v′ + ω² v = ω²·gain·u`, ω = 2π·frequency
//!
//! * frequency in Hz: natural frequency (the −3 dB bandwidth for ζ = 0.707); damping: ζ > 0; gain:
//!   as of `amplifier-lag`.
//! * State: v and v′/ω. Exact at any period, as the input is held over a step.
//!
//! Limits: linear: no current limit, no saturation.

use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use crate::effects;
use crate::linear::SecondOrder;
use crate::rules::{WRONG_LENGTH, second_order};

/// The component `amplifier-second-order`.
pub struct AmplifierSecondOrder;

static DECLARATION: Declaration = Declaration {
    kind: "amplifier-second-order",
    name: "amplifier",
    summary: "Second-order bandwidth of the amplifier into the actuator's capacitance",
    equation: "v'' + 2*damping*w*v' + w^2*v = w^2*gain*u; w = 2*pi*frequency",
    reference: "A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning \
                Systems, Springer 2014, ch. 14",
    stage: Stage::Amplifier,
    conversion: Conversion::None,
    effect: Some(&effects::AMPLIFIER_BANDWIDTH),
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: &[],
    parameters: &[
        Quantity::new("frequency", "Hz", "Natural frequency").min(0.0).fitted(),
        Quantity::new("damping", "1", "Damping ratio; 0.707 is flat").min(0.0).fitted(),
        Quantity::new("gain", "1", "Gain at low frequency").start(1.0).fitted(),
    ],
};

impl Component for AmplifierSecondOrder {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
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
        let (&[frequency, damping, gain], Ok(values)) =
            (parameters, <&mut [f64; 4]>::try_from(coefficients))
        else {
            return Err(WRONG_LENGTH);
        };
        second_order(frequency, damping, period)?;
        *values = SecondOrder::new(frequency, damping, gain, period).to_array();
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[a, b, c, d], &[u], Ok(state), [y]) =
            (coefficients, inputs, state.try_into(), outputs)
        else {
            return;
        };
        *y = SecondOrder::of([a, b, c, d]).rest(u, state);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[a, b, c, d], &[u], Ok(state), [y]) =
            (coefficients, inputs, state.try_into(), outputs)
        else {
            return;
        };
        *y = SecondOrder::of([a, b, c, d]).step(u, state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn a_flat_amplifier_overshoots_by_four_percent() {
        let mut amplifier = Instance::new(
            &AmplifierSecondOrder,
            &[],
            &[1000.0, core::f64::consts::FRAC_1_SQRT_2, 10.0],
            1e-6,
        )
        .unwrap();
        let peak = amplifier.response(0.0, &[1.0; 2000]).iter().fold(0.0f64, |m, v| m.max(*v));
        assert!((peak / 10.0 - 1.0 - (-core::f64::consts::PI).exp()).abs() < 1e-5, "{peak}");
    }
}

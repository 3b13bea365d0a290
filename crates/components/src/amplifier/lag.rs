//! Bandwidth of the amplifier into the actuator's capacitance, first order.
//!
//! `τ v′ + v = gain · u`, τ = R·C = 1/(2π·bandwidth)
//!
//! * bandwidth in Hz: −3 dB; R the output resistance, C the actuator's capacitance.
//! * gain: of the amplifier (10 for a driver with a ±10 V input); 1 where the command is in volts
//!   at the actuator.
//! * State: v. The input is held over a step, so the step `v += (1 − exp(−period/τ))·(gain·u − v)`
//!   is exact at any period.
//!
//! Limits: no current limit, no saturation, the capacitance is constant.

use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::linear::lag_fraction;
use crate::rules::{WRONG_LENGTH, positive_frequency};
use crate::{effects, phenomena};

/// The component `amplifier-lag`.
pub struct AmplifierLag;

static DECLARATION: Declaration = Declaration {
    kind: "amplifier-lag",
    name: "amplifier",
    summary: "First-order bandwidth of the amplifier into the actuator's capacitance",
    equation: "v'/(2*pi*bandwidth) + v = gain*u",
    reference: "A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning \
                Systems, Springer 2014, ch. 14",
    stage: Stage::Amplifier,
    effect: Some(&effects::AMPLIFIER_BANDWIDTH),
    phenomena: &[&phenomena::AMPLIFIER_LAG],
    parameters: &[
        Quantity::new("bandwidth", "Hz", "Frequency at which the gain has fallen by 3 dB")
            .releases(&effects::AMPLIFIER_BANDWIDTH)
            .min(0.0)
            .fitted(),
        Quantity::new("gain", "1", "Gain at low frequency").start(1.0).fitted(),
    ],
    ..Declaration::PATH
};

impl Component for AmplifierLag {
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
        let (&[bandwidth, gain], [fraction, factor]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        positive_frequency("bandwidth", bandwidth)?;
        (*fraction, *factor) = (lag_fraction(bandwidth, period), gain);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[_, gain], &[u], [v], [y]) = (coefficients, inputs, state, outputs) else { return };
        *v = gain * u;
        *y = *v;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[fraction, gain], &[u], [v], [y]) = (coefficients, inputs, state, outputs) else {
            return;
        };
        *v += fraction * (gain * u - *v);
        *y = *v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn step_response_is_the_exponential_at_every_step_size() {
        for period in [1e-6, 1e-4, 1e-3, 1.0] {
            let mut lag = Instance::new(&AmplifierLag, &[], &[270.0, 10.0], period).unwrap();
            assert_eq!(lag.rest(&[0.0]), 0.0);
            for n in 1..200 {
                let exact =
                    -10.0 * (-core::f64::consts::TAU * 270.0 * period * f64::from(n)).exp_m1();
                let error = lag.step(&[1.0]) - exact;
                assert!(error.abs() < 1e-13, "period {period}, step {n}: {error}");
            }
        }
    }

    #[test]
    fn rest_is_an_equilibrium_to_the_bit() {
        let mut lag = Instance::new(&AmplifierLag, &[], &[270.0, 9.7], 1e-4).unwrap();
        let rest = lag.rest(&[0.3]);
        assert!((0..10).all(|_| lag.step(&[0.3]).to_bits() == rest.to_bits()));
    }

    #[test]
    fn a_bandwidth_of_zero_is_refused() {
        let error = Instance::new(&AmplifierLag, &[], &[0.0, 1.0], 1e-4).err();
        assert_eq!(error.map(|e| e.quantity), Some("bandwidth"));
    }
}

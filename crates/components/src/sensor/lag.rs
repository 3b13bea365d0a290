//! Bandwidth of the sensor (demodulator, anti-aliasing filter), first order.
//!
//! `τ y′ + y = x`, τ = 1/(2π·bandwidth)
//!
//! * bandwidth in Hz: −3 dB.
//! * State: y. The input is held over a step, so the step `y += (1 − exp(−period/τ))·(x − y)` is
//!   exact at any period.
//!
//! Limits: first order; a filter of higher order has more phase at the same bandwidth.

use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::linear::lag_fraction;
use crate::rules::{WRONG_LENGTH, positive_frequency};
use crate::{effects, phenomena};

/// The component `sensor-lag`.
pub struct SensorLag;

static DECLARATION: Declaration = Declaration {
    kind: "sensor-lag",
    name: "sensor",
    summary: "First-order bandwidth of the sensor and its filter",
    equation: "y'/(2*pi*bandwidth) + y = x",
    reference: "A. J. Fleming, A review of nanometer resolution position sensors, Sensors and \
                Actuators A 190 (2013) 106-126",
    stage: Stage::Sensor,
    effect: Some(&effects::SENSOR_BANDWIDTH),
    phenomena: &[&phenomena::SENSOR_BANDWIDTH],
    parameters: &[Quantity::new(
        "bandwidth",
        "Hz",
        "Frequency at which the reading has fallen by 3 dB",
    )
    .releases(&effects::SENSOR_BANDWIDTH)
    .min(0.0)
    .fitted()],
    ..Declaration::PATH
};

impl Component for SensorLag {
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
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[bandwidth], [fraction]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        positive_frequency("bandwidth", bandwidth)?;
        *fraction = lag_fraction(bandwidth, period);
        Ok(())
    }

    #[cfg_attr(feature = "records", inline)]
    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[x], [y], [reading]) = (inputs, state, outputs) else { return };
        (*y, *reading) = (x, x);
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
        let (&[fraction], &[x], [y], [reading]) = (coefficients, inputs, state, outputs) else {
            return;
        };
        *y += fraction * (x - *y);
        *reading = *y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn step_response_is_the_exponential_at_every_step_size() {
        for period in [1e-6, 1e-4, 1e-2] {
            let mut lag = Instance::new(&SensorLag, &[], &[40.0], period).unwrap();
            assert_eq!(lag.rest(&[2.0]), 2.0);
            for n in 1..200 {
                let decay = (-core::f64::consts::TAU * 40.0 * period * f64::from(n)).exp();
                let error = lag.step(&[-1.0]) - (-1.0 + 3.0 * decay);
                assert!(error.abs() < 1e-13, "period {period}, step {n}: {error}");
            }
        }
    }

    #[test]
    fn halves_the_power_of_a_sine_at_its_bandwidth() {
        let period = 1e-5;
        let mut lag = Instance::new(&SensorLag, &[], &[100.0], period).unwrap();
        let omega = core::f64::consts::TAU * 100.0 * period;
        let signal: std::vec::Vec<f64> =
            (0..20_000).map(|n| (omega * f64::from(n)).sin()).collect();
        let output = lag.response(0.0, &signal);
        let peak = output[10_000..].iter().fold(0.0f64, |m, y| m.max(y.abs()));
        assert!((peak - core::f64::consts::FRAC_1_SQRT_2).abs() < 1e-3, "{peak}");
    }
}

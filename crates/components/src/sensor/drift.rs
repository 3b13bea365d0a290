//! Drift of the sensor's zero, as a random walk.
//!
//! `y = x + d`, `d_n = d_{n−1} + per_hour·√(T/3600 s)·(normal number n)`
//!
//! * per_hour in position: standard deviation after one hour; after t it is per_hour·√(t/1 h).
//!   seed: any number, mixed with the component's place.
//! * State: d, at rest 0. The draws are functions of seed and step.
//!
//! Limits: no bound; steady and thermal drift are in `thermal-drift`.

use libm::sqrt;
use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::random::normal;
use crate::rules::WRONG_LENGTH;
use crate::{effects, phenomena};

/// The component `sensor-drift`.
pub struct SensorDrift;

static DECLARATION: Declaration = Declaration {
    kind: "sensor-drift",
    name: "zero",
    summary: "Drift of the sensor's zero, as a random walk",
    equation: "y = x + d; d[n] = d[n-1] + per_hour*sqrt(T/3600 s)*normal",
    reference: "A. J. Fleming, Sensors and Actuators A 190 (2013) 106-126",
    stage: Stage::Sensor,
    effect: Some(&effects::THERMAL_DRIFT),
    phenomena: &[&phenomena::SENSOR_DRIFT],
    parameters: &[
        Quantity::new("per_hour", "{position}", "Standard deviation after one hour")
            .min(0.0)
            .fitted(),
        Quantity::new("seed", "1", "Seed of the walk").start(1.0).seed(),
    ],
    ..Declaration::PATH
};

impl Component for SensorDrift {
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
        let (&[per_hour, seed], [step, key]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        (*step, *key) = (per_hour * sqrt(period / 3600.0), seed);
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[x], [d], [y]) = (inputs, state, outputs) else { return };
        (*d, *y) = (0.0, x);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[step, seed], &[x], [d], [y]) = (coefficients, inputs, state, outputs) else {
            return;
        };
        *d += step * normal(seed, 0, tick.index);
        *y = x + *d;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn spreads_with_the_root_of_the_time() {
        let mut sum = 0.0;
        for seed in 0..400 {
            let mut drift = Instance::new(&SensorDrift, &[], &[2.0, f64::from(seed)], 9.0).unwrap();
            assert_eq!(drift.rest(&[1.0]), 1.0);
            let end = (0..100).map(|_| drift.step(&[1.0])).last().unwrap() - 1.0;
            sum += end * end;
        }
        // 900 s: half of the deviation after an hour.
        let rms = f64::sqrt(sum / 400.0);
        assert!((rms - 1.0).abs() < 0.15, "{rms}");
    }
}

//! Static nonlinearity of the sensor.
//!
//! `y = x + half_range·(quadratic·ξ² + cubic·ξ³)`, ξ = (x − centre)/half_range
//!
//! * centre, half_range in position: the measuring range; quadratic, cubic without unit: deviation
//!   at its ends as a part of half of it (1e-4 to 1e-2).
//! * No state.
//!
//! Limits: meant for |ξ| ≤ 1; no cross terms with another axis.

use model::{Component, Declaration, Quantity, Sizes, Stage, Violation};

use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `sensor-polynomial`.
pub struct SensorPolynomial;

static DECLARATION: Declaration = Declaration {
    kind: "sensor-polynomial",
    name: "linearity",
    summary: "Static nonlinearity of the sensor, quadratic and cubic",
    equation: "y = x + half_range*(quadratic*xi^2 + cubic*xi^3); xi = (x - centre)/half_range",
    reference: "A. J. Fleming, Sensors and Actuators A 190 (2013) 106-126",
    stage: Stage::Sensor,
    effect: Some(&effects::SENSOR_NONLINEARITY),
    phenomena: &[&phenomena::ABBE_ERROR, &phenomena::SENSOR_NONLINEARITY],
    parameters: &[
        Quantity::new("quadratic", "1", "Quadratic deviation at the end of the range")
            .start(0.0)
            .fitted(),
        Quantity::new("cubic", "1", "Cubic deviation at the end of the range").start(0.0).fitted(),
        Quantity::new("centre", "{position}", "Middle of the range"),
        Quantity::new("half_range", "{position}", "Half of the range").min(0.0),
    ],
    ..Declaration::PATH
};

impl Component for SensorPolynomial {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 4, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[.., half_range] = parameters else { return Err(WRONG_LENGTH) };
        require(half_range > 0.0, "half_range", half_range, "must be above zero")?;
        kept(parameters, coefficients)
    }

    #[cfg_attr(feature = "records", inline)]
    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[quadratic, cubic, centre, half_range], &[x], [y]) = (coefficients, inputs, outputs)
        else {
            return;
        };
        let xi = (x - centre) / half_range;
        *y = x + half_range * (quadratic + cubic * xi) * xi * xi;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn deviates_as_given_at_the_ends_and_not_in_the_middle() {
        let mut map =
            Instance::new(&SensorPolynomial, &[], &[0.002, -0.004, 5.0, 5.0], 1e-3).unwrap();
        assert_eq!(map.step(&[5.0]), 5.0);
        assert!((map.step(&[10.0]) - 9.99).abs() < 1e-12);
        assert!((map.step(&[0.0]) - 0.03).abs() < 1e-12);
    }
}

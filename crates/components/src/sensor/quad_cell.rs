//! Saturation of a quadrant detector.
//!
//! `y = scale·erf(√2·(x − centre)/radius)`, scale = radius·√(π/8), so that the slope in the middle
//! is 1
//!
//! * radius in position: 1/e² radius of a Gaussian spot; centre in position.
//! * No state.
//!
//! Limits: spot smaller than the cell, gap neglected; one axis.
//!
//! Source: L. P. Salles, D. W. de Lima Monteiro, IEEE Sensors Journal 10 (2010) 286–293.

use core::f64::consts::{FRAC_2_SQRT_PI, SQRT_2};

use libm::erf;
use model::{Component, Declaration, Quantity, Sizes, Stage, Violation};

use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `sensor-quad-cell`.
pub struct SensorQuadCell;

static DECLARATION: Declaration = Declaration {
    kind: "sensor-quad-cell",
    name: "linearity",
    summary: "Saturation of a quadrant detector under a Gaussian spot",
    equation: "y = centre + radius*sqrt(pi/8)*erf(sqrt(2)*(x - centre)/radius)",
    reference: "L. P. Salles, D. W. de Lima Monteiro, IEEE Sensors Journal 10 (2010) 286-293",
    stage: Stage::Sensor,
    effect: Some(&effects::SENSOR_NONLINEARITY),
    phenomena: &[&phenomena::QUAD_CELL_SATURATION],
    parameters: &[
        Quantity::new("radius", "{position}", "1/e^2 radius of the spot").min(0.0).fitted(),
        Quantity::new("centre", "{position}", "Middle of the detector").start(0.0).fitted(),
    ],
    ..Declaration::PATH
};

impl Component for SensorQuadCell {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 2, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[radius, _] = parameters else { return Err(WRONG_LENGTH) };
        require(radius > 0.0, "radius", radius, "must be above zero")?;
        kept(parameters, coefficients)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[radius, centre], &[x], [y]) = (coefficients, inputs, outputs) else { return };
        let slope = SQRT_2 / radius;
        *y = centre + erf(slope * (x - centre)) / (slope * FRAC_2_SQRT_PI);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn is_linear_in_the_middle_and_saturates() {
        let mut cell = Instance::new(&SensorQuadCell, &[], &[2.0, 1.0], 1e-3).unwrap();
        assert!((cell.step(&[1.001]) - 1.001).abs() < 1e-9);
        let end = 1.0 + 2.0 * (core::f64::consts::PI / 8.0).sqrt();
        assert!((cell.step(&[50.0]) - end).abs() < 1e-12);
        // 3 % below the straight line at 0.21 of the radius: −2/3·(x/w)².
        let y = cell.step(&[1.42]) - 1.0;
        assert!((y / 0.42 - (1.0 - 2.0 / 3.0 * 0.21 * 0.21)).abs() < 1e-3, "{y}");
    }
}

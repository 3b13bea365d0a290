//! Pincushion distortion of a position-sensitive detector: a cubic with cross terms.
//!
//! `p_i′ = p_i·(1 + distortion·(p_1² + p_2²)/half_size²)`
//!
//! * p_1, p_2 are the coordinates of the spot from the middle of the detector; half_size in position,
//!   half its edge; distortion: relative shift at half_size on an axis, positive outwards.
//! * No state. Two axes.
//!
//! Limits: the third order only; isotropic.
//!
//! Source: W. Wang, I. J. Busch-Vishniac, Applied Optics 28 (1989) 4504.

use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Structural, Violation};

use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `psd-pincushion`.
pub struct PsdPincushion;

static DECLARATION: Declaration = Declaration {
    kind: "psd-pincushion",
    name: "pincushion",
    summary: "Pincushion distortion of a position-sensitive detector",
    equation: "q[i] = p[i]*(1 + distortion*(p[1]^2 + p[2]^2)/half_size^2)",
    reference: "W. Wang, I. J. Busch-Vishniac, Applied Optics 28 (1989) 4504",
    stage: Stage::Coupling,
    effect: Some(&effects::SENSOR_NONLINEARITY),
    phenomena: &[&phenomena::PINCUSHION],
    inputs: &[Input::EACH_PATH],
    structure: &[Structural::count("axes", "Number of axes, 2", 2, 2)],
    parameters: &[
        Quantity::new("distortion", "1", "Relative shift at half_size on an axis").fitted(),
        Quantity::new("half_size", "{position}", "Half the edge of the detector").min(0.0),
    ],
    ..Declaration::PATH
};

impl Component for PsdPincushion {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 1, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[distortion, half_size], [factor]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        let rule = "must be above zero and not tiny; give half the edge of the detector";
        *factor = distortion / (half_size * half_size);
        require(half_size > 0.0 && factor.is_finite(), "half_size", half_size, rule)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[factor], &[x, y], [p, q]) = (coefficients, inputs, outputs) else { return };
        let scale = 1.0 + factor * (x * x + y * y);
        (*p, *q) = (x * scale, y * scale);
    }
}

//! Optics: from the angles of several mirrors to the coordinates of the spots on the sensors.
//!
//! `p = J·θ + p0`
//!
//! * matrix J in position per motion, row by row: a row per coordinate, a column per axis; offset
//!   p0 in position. In front of it the axes carry motions in their unit of motion, behind it
//!   positions.
//! * No state. Up to 32 axes.
//!
//! Limits: small angles, fixed geometry.

use model::{
    Component, Conversion, Declaration, Input, Quantity, Sizes, Stage, Structural, Violation,
};

use super::matrix;
use crate::phenomena;
use crate::rules::WRONG_LENGTH;

/// The component `optics-jacobian`.
pub struct OpticsJacobian;

static STRUCTURE: [Structural; 2] = matrix::structure(32);
static DECLARATION: Declaration = Declaration {
    kind: "optics-jacobian",
    name: "optics",
    summary: "From the angles of several mirrors to the coordinates of the spots on the sensors",
    equation: "p[i] = offset[i] + sum(matrix[i,j]*theta[j])",
    reference: "laser beam steering with dual-axis mirrors and position-sensitive detectors: p = \
                J*theta + p0",
    stage: Stage::Coupling,
    conversion: Conversion::MotionToPosition,
    phenomena: &[&phenomena::OPTICS],
    inputs: &[Input::EACH_PATH],
    structure: &STRUCTURE,
    parameters: &[
        // In a conversion of motion {command} is the unit of the motion.
        Quantity::new("matrix", "{position}/{command}", "Jacobian, row by row").per(1).fitted(),
        Quantity::new("offset", "{position}", "Coordinates at zero angles").per(0).fitted(),
    ],
    ..Declaration::PATH
};

impl Component for OpticsJacobian {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let coefficients = matrix::entries(structure) + matrix::axes(structure);
        Sizes { coefficients, states: 0 }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let wanted = matrix::entries(structure) + matrix::axes(structure);
        if parameters.len() != wanted || coefficients.len() != wanted {
            return Err(WRONG_LENGTH);
        }
        matrix::is_square(structure)?;
        coefficients.copy_from_slice(parameters);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let n = inputs.len();
        let Some((matrix, offset)) = coefficients.split_at_checked(n * n) else { return };
        matrix::product(matrix, offset.iter(), inputs, outputs);
    }
}

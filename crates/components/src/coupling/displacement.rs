//! Static coupling from the neighbours' motion.
//!
//! `y_i = x_i + Σ_j K_ij·x_j`
//!
//! * matrix K, row by row, a row per axis that is moved; its diagonal is zero. x_j is the motion of
//!   axis j where the coupling stands: behind the mechanics it carries the neighbour's mode,
//!   hysteresis and creep.
//! * No state. Up to eight axes.
//!
//! Limits: linear; the neighbour does not feel the motion that it causes.

use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Structural, Violation};

use super::matrix;
use crate::rules::WRONG_LENGTH;
use crate::{effects, phenomena};

/// The component `displacement-coupling`.
pub struct DisplacementCoupling;

static STRUCTURE: [Structural; 2] = matrix::structure(8);
static DECLARATION: Declaration = Declaration {
    kind: "displacement-coupling",
    name: "coupling",
    summary: "Coupling from the neighbours' motion, with their dynamics",
    equation: "y[i] = x[i] + sum(matrix[i,j]*x[j])",
    reference: "S. Devasia, E. Eleftheriou, S. O. R. Moheimani, IEEE Trans. CST 15 (2007) 802-823",
    stage: Stage::Coupling,
    effect: Some(&effects::CROSS_COUPLING),
    phenomena: &[&phenomena::STATIC_COUPLING, &phenomena::ABBE_ERROR],
    inputs: &[Input::EACH_PATH],
    structure: &STRUCTURE,
    parameters: &[Quantity::new(
        "matrix",
        "1",
        "Motion per motion of the neighbour, row by row, zero on the diagonal",
    )
    .per(1)
    .fitted()],
    ..Declaration::PATH
};

impl Component for DisplacementCoupling {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: matrix::entries(structure), states: 0 }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        if parameters.len() != matrix::entries(structure) || coefficients.len() != parameters.len()
        {
            return Err(WRONG_LENGTH);
        }
        matrix::is_square(structure)?;
        matrix::is_hollow(parameters, matrix::axes(structure))?;
        coefficients.copy_from_slice(parameters);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        matrix::product(coefficients, inputs.iter(), inputs, outputs);
    }
}

//! Static coupling from the neighbours' commands.
//!
//! `y_i = x_i + Σ_j K_ij·u_j`
//!
//! * matrix K in position per command, row by row, a row per axis that is moved; its diagonal is
//!   zero. u_j is the command of axis j as it enters the plant.
//! * No state. Up to four axes.
//!
//! Limits: prompt and linear; for the dynamics of the neighbour see `mode-coupling` and
//! `displacement-coupling`.

use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Structural, Violation};

use super::matrix;
use crate::rules::WRONG_LENGTH;
use crate::{effects, phenomena};

/// The component `command-coupling`.
pub struct CommandCoupling;

static STRUCTURE: [Structural; 2] = matrix::structure(4);
static DECLARATION: Declaration = Declaration {
    kind: "command-coupling",
    name: "coupling",
    summary: "Static coupling from the neighbours' commands",
    equation: "y[i] = x[i] + sum(matrix[i,j]*u[j])",
    reference: "S. Devasia, E. Eleftheriou, S. O. R. Moheimani, IEEE Trans. CST 15 (2007) 802-823",
    stage: Stage::Coupling,
    effect: Some(&effects::CROSS_COUPLING),
    phenomena: &[&phenomena::STATIC_COUPLING],
    inputs: &[Input::EACH_PATH, Input::each("command")],
    structure: &STRUCTURE,
    parameters: &[Quantity::new(
        "matrix",
        "{position}/{command}",
        "Motion per command of the neighbour, row by row, zero on the diagonal",
    )
    .per(1)
    .fitted()],
    ..Declaration::PATH
};

impl Component for CommandCoupling {
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
        let (x, u) = inputs.split_at(inputs.len() / 2);
        matrix::product(coefficients, x.iter(), u, outputs);
    }
}

//! Coordination of axes through their Jacobian: from coordinates that sensors read to the motions of
//! the actuators.
//!
//! ```text
//! p = J·θ + p0          the machine
//! θ_r = J⁻¹·(p_r − p0)  becomes the axis' reference
//! θ_m = J⁻¹·(p − p0)    becomes the axis' measured position
//! ```
//!
//! * Control laws behind it so see the coordinated error θ_r − θ_m = J⁻¹·(p_r − p), and feedforward
//!   the motion θ_r.
//! * matrix J in position per motion, row by row: a row per coordinate, a column per axis; entries
//!   that are exactly 0 are structural: the coordinate does not see the axis. offset p0 in position.
//! * Where the blocks of J that couple groups of axes are set to 0, each group works by itself.
//! * J⁻¹ is computed when the values are read, by elimination that prefers the diagonal as pivot
//!   (a tenth of the column's greatest entry is enough), so that structural zeros of a block-triangular
//!   J stay exact zeros. J is refused where it is singular or its condition number (greatest over
//!   least singular value) is above condition_max.
//! * No state, no delay; n axes cost 2n² multiplications.
//!
//! Limits: fixed geometry; 2 to 32 axes.
//!
//! Source: laser beam pointing with four piezo axes, eqs. (14), (18), (19).

use libm::{fabs, hypot, sqrt};
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Structural,
    Violation,
};

use crate::coupling::matrix;
use crate::rules::WRONG_LENGTH;

/// The component `jacobian-coordinator`.
pub struct JacobianCoordinator;

static STRUCTURE: [Structural; 2] = matrix::structure(32);
static DECLARATION: Declaration = Declaration {
    kind: "jacobian-coordinator",
    name: "coordinator",
    summary: "From the coordinates of all sensors to the motions of all axes, through the inverse Jacobian",
    equation: "theta_r = J^-1*(p_r - p0); theta_m = J^-1*(p - p0); J[i,j] = matrix[i,j]; p0[i] = \
               offset[i]",
    reference: "laser beam pointing with four piezo axes, eqs. (14), (18), (19)",
    stage: Stage::Control,
    conversion: Conversion::PositionToMotion,
    inputs: &[Input::EACH_PATH, Input::each("measured")],
    outputs: &[
        Output::PATH,
        Output { name: "reference", published: None },
        Output { name: "measured", published: None },
    ],
    structure: &STRUCTURE,
    parameters: &[
        // {command} is the unit of the motion.
        Quantity::new("matrix", "{position}/{command}", "Jacobian, row by row").per(1).fitted(),
        Quantity::new("offset", "{position}", "Coordinates at zero motion").per(0).fitted(),
        Quantity::new(
            "condition_max",
            "1",
            "Greatest condition number of the Jacobian that is taken",
        )
        .start(1000.0)
        .min(1.0),
    ],
    ..Declaration::PATH
};

impl Component for JacobianCoordinator {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("matrix", &[1.0, 0.02, -0.03, 0.9]),
            ("offset", &[3.0, -2.0]),
            ("condition_max", &[1000.0]),
        ]
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let (n, entries) = (matrix::axes(structure), matrix::entries(structure));
        // The inverse, the offset, and room for the matrix and its rotation.
        Sizes { coefficients: 2 * entries + n, states: 0 }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        matrix::is_square(structure)?;
        let (limit, rest) = parameters.split_last().ok_or(WRONG_LENGTH)?;
        Self::prepare_with(matrix::axes(structure), rest, *limit, coefficients)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        motions(coefficients, inputs, outputs);
    }
}

impl JacobianCoordinator {
    /// Coefficients of `n` axes: of the Jacobian and the offset behind it, with this limit of its condition number.
    ///
    /// # Errors
    /// A Jacobian that cannot be inverted.
    pub(super) fn prepare_with(
        n: usize,
        parameters: &[f64],
        limit: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let entries = n * n;
        if parameters.len() != entries + n || coefficients.len() != 2 * entries + n {
            return Err(WRONG_LENGTH);
        }
        let (jacobian, offset) = parameters.split_at(entries);
        let (inverse, own) = coefficients.split_at_mut(entries);
        let (own_offset, room) = own.split_at_mut(n);
        own_offset.copy_from_slice(offset);
        room.copy_from_slice(jacobian);
        let condition = condition(room, n);
        // Not a number counts as above.
        if condition.is_nan() || condition > limit {
            let rule = "is the condition number of the Jacobian, above condition_max: motions of some \
                        axes cannot be distinguished by the sensors; calibrate with motion that moves each axis separately, or set entries that do not belong there to 0";
            return Err(Violation { quantity: "matrix", index: None, value: condition, rule });
        }
        room.copy_from_slice(jacobian);
        if !invert(room, inverse, n) {
            let rule = "is the determinant of the Jacobian: it cannot be inverted; give a row per \
                        coordinate and a column per axis, none of them all 0";
            return Err(Violation { quantity: "matrix", index: None, value: 0.0, rule });
        }
        Ok(())
    }
}

/// Motions of the references, on the paths and as references, and of the measured positions; whether the lengths fit.
pub(super) fn motions(coefficients: &[f64], inputs: &[f64], outputs: &mut [f64]) -> bool {
    let n = inputs.len() / 2;
    let Some((inverse, offset)) = coefficients.split_at_checked(n * n) else { return false };
    let (Some((wanted, measured)), Some((path, motions))) =
        (inputs.split_at_checked(n), outputs.split_at_mut_checked(n))
    else {
        return false;
    };
    let Some((references, found)) = motions.split_at_mut_checked(n) else { return false };
    for (positions, motions) in [(wanted, &mut *path), (measured, found)] {
        for (motion, row) in motions.iter_mut().zip(inverse.chunks_exact(n.max(1))) {
            let each = row.iter().zip(positions.iter().zip(offset));
            *motion = each.map(|(k, (p, p0))| k * (p - p0)).sum();
        }
    }
    references.copy_from_slice(path);
    true
}

/// Greatest over least singular value of the `n` × `n` matrix `a` (row by row), which is spent:
/// rotations make its columns orthogonal (one-sided Jacobi method, Hestenes). Infinite where it is
/// singular.
pub fn condition(a: &mut [f64], n: usize) -> f64 {
    for _ in 0..60 {
        let mut turned = false;
        for p in 0..n {
            for q in p + 1..n {
                let (mut pp, mut qq, mut pq) = (0.0, 0.0, 0.0);
                for row in a.chunks_exact(n) {
                    pp += row[p] * row[p];
                    qq += row[q] * row[q];
                    pq += row[p] * row[q];
                }
                if fabs(pq) <= 1e-15 * sqrt(pp * qq) {
                    continue;
                }
                turned = true;
                let zeta = (qq - pp) / (2.0 * pq);
                let t = if zeta >= 0.0 { 1.0 } else { -1.0 } / (fabs(zeta) + hypot(1.0, zeta));
                let c = 1.0 / hypot(1.0, t);
                let s = c * t;
                for row in a.chunks_exact_mut(n) {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
            }
        }
        if !turned {
            break;
        }
    }
    let norm = |column: usize| sqrt(a.chunks_exact(n).map(|row| row[column] * row[column]).sum());
    let (mut least, mut greatest) = (f64::INFINITY, 0.0);
    for column in 0..n {
        let value = norm(column);
        if value.is_nan() || value <= 0.0 {
            return f64::INFINITY;
        }
        (least, greatest) = (value.min(least), value.max(greatest));
    }
    greatest / least
}

/// The inverse of `a`, which is spent; false where a pivot is 0.
fn invert(a: &mut [f64], inverse: &mut [f64], n: usize) -> bool {
    for (k, entry) in inverse.iter_mut().enumerate() {
        *entry = f64::from(u8::from(k / n == k % n));
    }
    for k in 0..n {
        let size = |row: usize| fabs(a[row * n + k]);
        let mut pivot = k;
        for row in k + 1..n {
            if size(row) > size(pivot) {
                pivot = row;
            }
        }
        if size(k) >= 0.1 * size(pivot) {
            pivot = k;
        }
        let value = a[pivot * n + k];
        if value == 0.0 {
            return false;
        }
        for column in 0..n {
            a.swap(k * n + column, pivot * n + column);
            inverse.swap(k * n + column, pivot * n + column);
        }
        for column in 0..n {
            a[k * n + column] /= value;
            inverse[k * n + column] /= value;
        }
        for row in (0..n).filter(|row| *row != k) {
            let factor = a[row * n + k];
            if factor == 0.0 {
                continue;
            }
            for column in 0..n {
                a[row * n + column] -= factor * a[k * n + column];
                inverse[row * n + column] -= factor * inverse[k * n + column];
            }
        }
    }
    true
}

#[cfg(test)]
mod tests;

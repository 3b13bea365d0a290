//! What coupling matrices share: their settings, their checks, their product.

use model::{Structural, Violation};

use crate::rules::require;

/// Structural settings of a component with a square matrix over `most` axes at most.
pub(crate) const fn structure(most: usize) -> [Structural; 2] {
    [
        Structural::count("axes", "Number of coupled axes", 2, most),
        Structural::count("entries", "Number of entries of the matrix", 4, most * most),
    ]
}

/// Number of axes of this structure.
pub(crate) fn axes(structure: &[f64]) -> usize {
    structure.first().map_or(0, |n| *n as usize)
}

/// Number of entries of this structure.
pub(crate) fn entries(structure: &[f64]) -> usize {
    structure.get(1).map_or(0, |n| *n as usize)
}

/// Refuses a number of entries that is not the square of the number of axes.
pub(crate) fn is_square(structure: &[f64]) -> Result<(), Violation> {
    let (n, entries) = (axes(structure), entries(structure));
    require(
        n > 0 && entries == n * n,
        "matrix",
        entries as f64,
        "entries: it has as many rows and columns as axes are coupled; give one row per axis",
    )
}

/// Refuses entries on the diagonal.
pub(super) fn is_hollow(matrix: &[f64], n: usize) -> Result<(), Violation> {
    for (at, value) in matrix.iter().enumerate().step_by(n + 1) {
        if *value != 0.0 {
            let rule = "is on the diagonal and would be a gain of the axis itself; set it to 0";
            return Err(Violation { quantity: "matrix", index: Some(at), value: *value, rule });
        }
    }
    Ok(())
}

/// `outputs = offset + matrix·inputs`, row by row.
#[inline]
pub(super) fn product<'a>(
    matrix: &[f64],
    offset: impl Iterator<Item = &'a f64>,
    inputs: &[f64],
    outputs: &mut [f64],
) {
    for ((output, row), offset) in
        outputs.iter_mut().zip(matrix.chunks_exact(inputs.len().max(1))).zip(offset)
    {
        let sum: f64 = row.iter().zip(inputs).map(|(k, x)| k * x).sum();
        *output = offset + sum;
    }
}

//! Normal equations of sensitivities.

use nalgebra::{DMatrix, DVector};

/// Inner product.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four sums at once: the compiler may not reorder one.
    let mut sums = [0.0; 4];
    let (left, right) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = left.remainder().iter().zip(right.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in left.zip(right) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// `JᵀJ`.
pub(crate) fn products(columns: &[Vec<f64>]) -> DMatrix<f64> {
    let n = columns.len();
    let mut all = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let value = dot(&columns[i], &columns[j]);
            all[(i, j)] = value;
            all[(j, i)] = value;
        }
    }
    all
}

/// `JᵀJ·weight` and `−Jᵀr·weight`.
pub(crate) fn normal_equations(
    columns: &[Vec<f64>],
    residual: &[f64],
    weight: f64,
) -> (DMatrix<f64>, DVector<f64>) {
    let gradient = columns.iter().map(|column| -weight * dot(column, residual));
    let gradient = DVector::from_iterator(columns.len(), gradient);
    (products(columns) * weight, gradient)
}

//! Normal equations of sensitivities.

use nalgebra::{DMatrix, DVector};

use crate::thresholds::fit::Thresholds;

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

/// The minimum of `½ sᵀNs − gᵀs` with what would leave its room held at its end.
pub(crate) fn within(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    room: &[(f64, f64)],
) -> Option<DVector<f64>> {
    let n = gradient.len();
    let mut held: Vec<Option<f64>> = vec![None; n];
    let mut step = DVector::zeros(n);
    for _ in 0..Thresholds::BOUND_ROUNDS {
        let free: Vec<usize> = (0..n).filter(|k| held[*k].is_none()).collect();
        let matrix = DMatrix::from_fn(free.len(), free.len(), |i, j| normal[(free[i], free[j])]);
        let right = DVector::from_fn(free.len(), |i, _| {
            let moved = |k: usize| held[k].map_or(0.0, |s| normal[(free[i], k)] * s);
            gradient[free[i]] - (0..n).map(moved).sum::<f64>()
        });
        let solved = matrix.cholesky()?.solve(&right);
        for k in 0..n {
            step[k] = held[k].unwrap_or(0.0);
        }
        for (k, s) in free.iter().zip(solved.iter()) {
            step[*k] = *s;
        }
        let out: Vec<usize> =
            free.into_iter().filter(|k| step[*k] < room[*k].0 || step[*k] > room[*k].1).collect();
        if out.is_empty() {
            break;
        }
        for k in out {
            step[k] = step[k].clamp(room[k].0, room[k].1);
            held[k] = Some(step[k]);
        }
    }
    Some(step)
}

//! The same answers as [`bordered`](super::bordered) where K = L·Lᵀ has a low rank r: everything
//! happens in r × r matrices.
//!
//! ```text
//! (λI + L_KᵀL_K) w = L_Kᵀ(y_K − b1),  f(x) = l(x)·w + b,  α_K = (y_K − b − L_K w)/λ
//! ```

use crate::solve::dense::{Mat, View, add_lower, cholesky, divide, divide_transposed, solve_with};
use crate::solve::gram;
use crate::solve::pivoted::LowRank;

/// A solution on some of the rows.
pub(super) struct Fit {
    pub(super) w: Mat,
    pub(super) bias: f64,
    /// Cholesky factor of λI + LᵀL over the rows.
    factor: Mat,
    /// Lᵀ1 over the rows, with (λI + LᵀL)⁻¹ applied, and n − 1ᵀL of it.
    ones: Mat,
    rest: f64,
}

/// Sums over all rows.
pub(super) struct Sums<'a> {
    pub(super) low: &'a LowRank,
    pub(super) y: &'a [f64],
    lambda: f64,
    gram: Mat,
    /// Lᵀ[y 1]
    sums: Mat,
}

impl<'a> Sums<'a> {
    pub(super) fn new(low: &'a LowRank, y: &'a [f64], lambda: f64) -> Self {
        let l = low.factor();
        let right = Mat::from_fn(y.len(), 2, |i, c| if c == 0 { y[i] } else { 1.0 });
        Self { low, y, lambda, gram: gram(&l, 0.0), sums: l.tr_mul(&right) }
    }

    /// The solution without successive rows.
    pub(super) fn without(&self, part: &std::ops::Range<usize>) -> Option<Fit> {
        let low = self.low.factor();
        let rows = low.rows(part.start, part.len());
        let y = &self.y[part.clone()];
        let (mut gram, mut sums) = (self.gram.clone(), self.sums.clone());
        let right = Mat::from_fn(y.len(), 2, |i, c| if c == 0 { y[i] } else { 1.0 });
        let transposed = rows.transpose();
        add_lower(&mut gram.as_view_mut(), -1.0, &transposed.as_view(), &rows);
        sums.gemm(-1.0, &transposed, &right, 1.0);
        let total: f64 = self.y.iter().sum::<f64>() - y.iter().sum::<f64>();
        fit(gram, sums, self.lambda, (self.y.len() - y.len()) as f64, total)
    }
}

/// The solution on rows with this LᵀL, Lᵀ[y 1], number and sum of outputs.
fn fit(gram: Mat, sums: Mat, lambda: f64, count: f64, total: f64) -> Option<Fit> {
    let mut factor = gram;
    let r = factor.nrows();
    for i in 0..r {
        factor[(i, i)] += lambda;
    }
    cholesky(factor.as_view_mut())?;
    let mut solved = sums.clone();
    solve_with(&factor.as_view(), solved.as_view_mut());
    let dot = |a: usize, b: usize| (0..r).map(|i| sums[(i, a)] * solved[(i, b)]).sum::<f64>();
    let rest = count - dot(1, 1);
    let bias = (total - dot(1, 0)) / rest;
    let w = Mat::from_fn(r, 1, |i, _| solved[(i, 0)] - bias * solved[(i, 1)]);
    let ones = Mat::from_fn(r, 1, |i, _| solved[(i, 1)]);
    Some(Fit { w, bias, factor, ones, rest })
}

impl Fit {
    /// On all rows of `l`.
    pub(super) fn of(l: View<'_>, y: &[f64], lambda: f64) -> Option<Self> {
        let right = Mat::from_fn(y.len(), 2, |i, c| if c == 0 { y[i] } else { 1.0 });
        fit(gram(&l, 0.0), l.tr_mul(&right), lambda, y.len() as f64, y.iter().sum())
    }

    /// `f` at rows of L.
    pub(super) fn values(&self, rows: View<'_>) -> Vec<f64> {
        (rows * &self.w).iter().map(|f| f + self.bias).collect()
    }

    /// α of the rows that were fitted.
    pub(super) fn weights(&self, l: View<'_>, y: &[f64], lambda: f64) -> Vec<f64> {
        self.values(l).iter().zip(y).map(|(f, y)| (y - f) / lambda).collect()
    }

    /// The diagonal of B for the rows that were fitted: of (I − L·(λI + LᵀL)⁻¹·Lᵀ)/λ without what the
    /// bias takes.
    pub(super) fn inverse_diagonal(&self, l: View<'_>, lambda: f64) -> Vec<f64> {
        let mut g = l.transpose();
        divide(&self.factor.as_view(), g.as_view_mut());
        let along = l * &self.ones;
        let diagonal = |i: usize| {
            let square = g.column(i).norm_squared();
            let u = 1.0 - along[(i, 0)];
            (1.0 - square - u * u / self.rest) / lambda
        };
        (0..l.nrows()).map(diagonal).collect()
    }

    /// The weights of the pivots that give the same function.
    pub(super) fn on_pivots(&self, low: &LowRank) -> Vec<f64> {
        let rows = low.rows(&low.pivots);
        let mut beta = self.w.clone();
        divide_transposed(&rows.as_view(), beta.as_view_mut());
        beta.as_slice().to_vec()
    }
}

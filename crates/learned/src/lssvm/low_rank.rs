//! The same answers as [`bordered`](super::bordered) where K = L·Lᵀ has a low rank r: everything
//! happens in r × r matrices.
//!
//! ```text
//! (λI + L_KᵀL_K) w = L_Kᵀ(y_K − b1),  f(x) = l(x)·w + b,  α_K = (y_K − b − L_K w)/λ
//! ```

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, Mat, MatRef, Par};

use crate::solve::pivoted::LowRank;
use crate::solve::{cholesky, gram, solve_with};

/// A solution on some of the rows.
pub(super) struct Fit {
    pub(super) w: Mat<f64>,
    pub(super) bias: f64,
    /// Cholesky factor of λI + LᵀL over the rows.
    factor: Mat<f64>,
    /// Lᵀ1 over the rows, with (λI + LᵀL)⁻¹ applied, and n − 1ᵀL of it.
    ones: Mat<f64>,
    rest: f64,
}

/// Sums over all rows.
pub(super) struct Sums<'a> {
    pub(super) low: &'a LowRank,
    pub(super) y: &'a [f64],
    lambda: f64,
    gram: Mat<f64>,
    /// Lᵀ[y 1]
    sums: Mat<f64>,
}

impl<'a> Sums<'a> {
    pub(super) fn new(low: &'a LowRank, y: &'a [f64], lambda: f64) -> Self {
        let l = low.factor();
        let right = Mat::from_fn(y.len(), 2, |i, c| if c == 0 { y[i] } else { 1.0 });
        let mut sums = Mat::zeros(low.rank(), 2);
        matmul(sums.as_mut(), Accum::Replace, l.transpose(), right.as_ref(), 1.0, Par::Seq);
        Self { low, y, lambda, gram: gram(l, 0.0), sums }
    }

    /// The solution without successive rows.
    pub(super) fn without(&self, part: &std::ops::Range<usize>) -> Option<Fit> {
        let rows = self.low.factor().get(part.clone(), ..);
        let y = &self.y[part.clone()];
        let (mut gram, mut sums) = (self.gram.clone(), self.sums.clone());
        let right = Mat::from_fn(y.len(), 2, |i, c| if c == 0 { y[i] } else { 1.0 });
        triangular::matmul(
            gram.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Add,
            rows.transpose(),
            BlockStructure::Rectangular,
            rows,
            BlockStructure::Rectangular,
            -1.0,
            Par::Seq,
        );
        matmul(sums.as_mut(), Accum::Add, rows.transpose(), right.as_ref(), -1.0, Par::Seq);
        let total: f64 = self.y.iter().sum::<f64>() - y.iter().sum::<f64>();
        fit(gram, sums, self.lambda, (self.y.len() - y.len()) as f64, total)
    }
}

/// The solution on rows with this LᵀL, Lᵀ[y 1], number and sum of outputs.
fn fit(gram: Mat<f64>, sums: Mat<f64>, lambda: f64, count: f64, total: f64) -> Option<Fit> {
    let mut factor = gram;
    let r = factor.nrows();
    for i in 0..r {
        factor[(i, i)] += lambda;
    }
    cholesky(factor.as_mut())?;
    let mut solved = sums.clone();
    solve_with(factor.as_ref(), solved.as_mut());
    let dot = |a: usize, b: usize| (0..r).map(|i| sums[(i, a)] * solved[(i, b)]).sum::<f64>();
    let rest = count - dot(1, 1);
    let bias = (total - dot(1, 0)) / rest;
    let w = Mat::from_fn(r, 1, |i, _| solved[(i, 0)] - bias * solved[(i, 1)]);
    let ones = Mat::from_fn(r, 1, |i, _| solved[(i, 1)]);
    Some(Fit { w, bias, factor, ones, rest })
}

impl Fit {
    /// On all rows of `l`.
    pub(super) fn of(l: MatRef<'_, f64>, y: &[f64], lambda: f64) -> Option<Self> {
        let right = Mat::from_fn(y.len(), 2, |i, c| if c == 0 { y[i] } else { 1.0 });
        let mut sums = Mat::zeros(l.ncols(), 2);
        matmul(sums.as_mut(), Accum::Replace, l.transpose(), right.as_ref(), 1.0, Par::Seq);
        fit(gram(l, 0.0), sums, lambda, y.len() as f64, y.iter().sum())
    }

    /// `f` at rows of L.
    pub(super) fn values(&self, rows: MatRef<'_, f64>) -> Vec<f64> {
        let mut out = Mat::zeros(rows.nrows(), 1);
        matmul(out.as_mut(), Accum::Replace, rows, self.w.as_ref(), 1.0, Par::Seq);
        (0..rows.nrows()).map(|i| out[(i, 0)] + self.bias).collect()
    }

    /// α of the rows that were fitted.
    pub(super) fn weights(&self, l: MatRef<'_, f64>, y: &[f64], lambda: f64) -> Vec<f64> {
        self.values(l).iter().zip(y).map(|(f, y)| (y - f) / lambda).collect()
    }

    /// The diagonal of B for the rows that were fitted: of (I − L·(λI + LᵀL)⁻¹·Lᵀ)/λ without what the
    /// bias takes.
    pub(super) fn inverse_diagonal(&self, l: MatRef<'_, f64>, lambda: f64) -> Vec<f64> {
        let mut g = Mat::zeros(l.ncols(), l.nrows());
        g.copy_from(l.transpose());
        solve_lower_triangular_in_place(self.factor.as_ref(), g.as_mut(), Par::Seq);
        let mut along = Mat::zeros(l.nrows(), 1);
        matmul(along.as_mut(), Accum::Replace, l, self.ones.as_ref(), 1.0, Par::Seq);
        let diagonal = |i: usize| {
            let column = g.col(i);
            let square: f64 = match column.try_as_col_major() {
                Some(column) => column.as_slice().iter().map(|g| g * g).sum(),
                None => 0.0,
            };
            let u = 1.0 - along[(i, 0)];
            (1.0 - square - u * u / self.rest) / lambda
        };
        (0..l.nrows()).map(diagonal).collect()
    }

    /// The weights of the pivots that give the same function.
    pub(super) fn on_pivots(&self, low: &LowRank) -> Vec<f64> {
        let rows = low.rows(&low.pivots);
        let mut beta = self.w.clone();
        solve_upper_triangular_in_place(rows.transpose(), beta.as_mut(), Par::Seq);
        (0..beta.nrows()).map(|i| beta[(i, 0)]).collect()
    }
}

//! Solves `(K + λ·I)·x = r` for two right-hand sides by the route that suits the kernel.
//!
//! * *Preconditioned*: a smooth kernel has a low rank; its pivoted Cholesky factor preconditions
//!   conjugate gradients on the exact matrix, a few iterations are enough.
//! * *Dense*: else Cholesky in place.
//!
//! Both end with the exact residual, from kernels computed anew.

pub(crate) mod kernel;
pub(crate) mod pivoted;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use self::kernel::{Scaled, symmetric_products};
use self::pivoted::LowRank;
use crate::Error;

/// How a system was solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// Conjugate gradients on the exact matrix, preconditioned by a factor of this rank.
    Preconditioned {
        /// Columns of the factor.
        rank: usize,
        /// Iterations.
        iterations: usize,
    },
    /// Cholesky of the whole matrix.
    Dense,
}

/// Two solutions.
pub(crate) struct Solved {
    pub(crate) x: [Vec<f64>; 2],
    pub(crate) route: Route,
}

/// Greatest error of a solution, relative to its length, that conjugate gradients stop at.
const TOLERANCE: f64 = 1e-9;
const MOST_ITERATIONS: usize = 60;
/// Coordinates up to which kernels are computed in every product and never stored.
const MOST_COMPUTED: usize = 16;
/// Greatest diagonal of the remainder of a preconditioner, as a part of λ.
const REMAINDER: f64 = 1e-4;

/// Solves with the kernel matrix of `points`.
///
/// # Errors
/// [`Error::IllPosed`] where the matrix is not positive definite.
pub(crate) fn solve(points: &Scaled, lambda: f64, rhs: [&[f64]; 2]) -> Result<Solved, Error> {
    let n = points.n;
    if n >= 256
        && let Some(low) = LowRank::until(points, REMAINDER * lambda, n / 6)
        && let Some(solved) = preconditioned(points, lambda, rhs, &low)
    {
        return Ok(solved);
    }
    let mut matrix = vec![0.0; n * n];
    points.fill_lower(&mut matrix);
    factorise(&mut matrix, n, lambda)?;
    let mut x = rhs.map(<[f64]>::to_vec);
    for x in &mut x {
        solve_factored(&matrix, n, x);
    }
    refine(points, lambda, rhs, &matrix, &mut x);
    Ok(Solved { x, route: Route::Dense })
}

/// One step of iterative refinement with kernels computed anew.
fn refine(points: &Scaled, lambda: f64, rhs: [&[f64]; 2], factor: &[f64], x: &mut [Vec<f64>; 2]) {
    let products = points.products([&x[0], &x[1]], lambda);
    for ((x, rhs), product) in x.iter_mut().zip(rhs).zip(products) {
        let mut rest: Vec<f64> = rhs.iter().zip(&product).map(|(r, p)| r - p).collect();
        solve_factored(factor, points.n, &mut rest);
        x.iter_mut().zip(&rest).for_each(|(x, d)| *x += d);
    }
}

/// The lower half of `matrix + λ·I` replaced by its Cholesky factor.
pub(crate) fn factorise(matrix: &mut [f64], n: usize, lambda: f64) -> Result<(), Error> {
    for i in 0..n {
        matrix[i * n + i] += lambda;
    }
    let view = MatMut::from_column_major_slice_mut(matrix, n, n);
    cholesky(view).ok_or(Error::IllPosed { samples: n, lambda })
}

/// Cholesky in place of the lower half; `None` where the matrix is not positive definite.
pub(crate) fn cholesky(matrix: MatMut<'_, f64>) -> Option<()> {
    let n = matrix.nrows();
    let params = Default::default();
    let mut memory =
        MemBuffer::new(llt::factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, params));
    let stack = MemStack::new(&mut memory);
    llt::factor::cholesky_in_place(matrix, Default::default(), Par::Seq, stack, params)
        .ok()
        .map(drop)
}

/// `x := (L·Lᵀ)⁻¹·x`.
pub(crate) fn solve_factored(factor: &[f64], n: usize, x: &mut [f64]) {
    let factor = MatRef::from_column_major_slice(factor, n, n);
    solve_with(factor, MatMut::from_column_major_slice_mut(x, n, 1));
}

/// `x := (L·Lᵀ)⁻¹·x`.
pub(crate) fn solve_with(factor: MatRef<'_, f64>, x: MatMut<'_, f64>) {
    let mut x = x;
    let triangular = faer::linalg::triangular_solve::solve_lower_triangular_in_place;
    triangular(factor, x.as_mut(), Par::Seq);
    let transposed = faer::linalg::triangular_solve::solve_upper_triangular_in_place;
    transposed(factor.transpose(), x, Par::Seq);
}

/// (L·Lᵀ + λ·I)⁻¹ by the matrix inversion lemma.
struct Preconditioner<'a> {
    low: MatRef<'a, f64>,
    inner: Mat<f64>,
    lambda: f64,
}

impl<'a> Preconditioner<'a> {
    fn new(low: &'a LowRank, lambda: f64) -> Option<Self> {
        let low = low.factor();
        let inner = gram(low, lambda);
        let mut inner = inner;
        cholesky(inner.as_mut())?;
        Some(Self { low, inner, lambda })
    }

    fn apply(&self, v: &Mat<f64>) -> Mat<f64> {
        let mut inner = Mat::zeros(self.low.ncols(), v.ncols());
        matmul(inner.as_mut(), Accum::Replace, self.low.transpose(), v.as_ref(), 1.0, Par::Seq);
        solve_with(self.inner.as_ref(), inner.as_mut());
        let mut out = v.clone();
        matmul(out.as_mut(), Accum::Add, self.low, inner.as_ref(), -1.0, Par::Seq);
        let factor = 1.0 / self.lambda;
        for column in out.col_iter_mut() {
            column.iter_mut().for_each(|x| *x *= factor);
        }
        out
    }
}

/// The lower half of `LᵀL + λ·I`.
pub(crate) fn gram(low: MatRef<'_, f64>, lambda: f64) -> Mat<f64> {
    use faer::linalg::matmul::triangular::{self, BlockStructure};
    let r = low.ncols();
    let mut inner = Mat::zeros(r, r);
    triangular::matmul(
        inner.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Replace,
        low.transpose(),
        BlockStructure::Rectangular,
        low,
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
    for i in 0..r {
        inner[(i, i)] += lambda;
    }
    inner
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Conjugate gradients for both right-hand sides in step; `None` where they do not converge.
fn preconditioned(points: &Scaled, lambda: f64, rhs: [&[f64]; 2], low: &LowRank) -> Option<Solved> {
    let n = points.n;
    let preconditioner = Preconditioner::new(low, lambda)?;
    let mut product = Mat::zeros(n, 2);
    // Few coordinates: a kernel is computed faster than it is fetched.
    let matrix = (points.d > MOST_COMPUTED).then(|| {
        let mut matrix = vec![0.0; n * n];
        points.fill_lower(&mut matrix);
        matrix
    });
    let multiply = |x: &Mat<f64>, out: &mut Mat<f64>| {
        let (Some(x0), Some(x1)) = (slice(x, 0), slice(x, 1)) else { return };
        let products = match &matrix {
            Some(matrix) => symmetric_products(matrix, n, lambda, [x0, x1]),
            None => points.products([x0, x1], lambda),
        };
        *out = Mat::from_fn(n, 2, |i, c| products[c][i]);
    };
    let rhs = Mat::from_fn(n, 2, |i, c| rhs[c][i]);
    let mut x = preconditioner.apply(&rhs);
    multiply(&x, &mut product);
    let mut rest = &rhs - &product;
    let mut z = preconditioner.apply(&rest);
    let mut direction = z.clone();
    let mut slope = [0, 1].map(|c| inner(&rest, &z, c));
    let mut iterations = 0;
    let converged = |x: &Mat<f64>, rest: &Mat<f64>, c: usize| {
        inner(rest, rest, c).sqrt() <= TOLERANCE * lambda * inner(x, x, c).sqrt()
    };
    // Below this the product's own rounding errors speak.
    let floor = |rest: &Mat<f64>, c: usize| {
        inner(rest, rest, c).sqrt() <= 1e-13 * inner(&rhs, &rhs, c).sqrt()
    };
    while !(0..2).all(|c| converged(&x, &rest, c) || floor(&rest, c)) {
        if iterations == MOST_ITERATIONS {
            return None;
        }
        iterations += 1;
        multiply(&direction, &mut product);
        for c in 0..2 {
            let curvature = inner(&direction, &product, c);
            let step = if curvature > 0.0 { slope[c] / curvature } else { 0.0 };
            for i in 0..n {
                x[(i, c)] += step * direction[(i, c)];
                rest[(i, c)] -= step * product[(i, c)];
            }
        }
        z = preconditioner.apply(&rest);
        for c in 0..2 {
            let new = inner(&rest, &z, c);
            let factor = if slope[c] == 0.0 { 0.0 } else { new / slope[c] };
            slope[c] = new;
            for i in 0..n {
                direction[(i, c)] = z[(i, c)] + factor * direction[(i, c)];
            }
        }
    }
    let x = [0, 1].map(|c| x.col(c).iter().copied().collect());
    Some(Solved { x, route: Route::Preconditioned { rank: low.rank(), iterations } })
}

fn slice(matrix: &Mat<f64>, column: usize) -> Option<&[f64]> {
    matrix.col(column).try_as_col_major().map(|c| c.as_slice())
}

fn inner(a: &Mat<f64>, b: &Mat<f64>, column: usize) -> f64 {
    match (slice(a, column), slice(b, column)) {
        (Some(a), Some(b)) => dot(a, b),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::wave;

    #[test]
    fn both_routes_solve_the_same_system() {
        let (n, d, lambda) = (400, 2, 1e-3);
        let points = Scaled::new(&wave(n * d, 1.1), d, &[0.6; 2]);
        let (y, one) = (wave(n, 0.3), vec![1.0; n]);
        let rhs = [&y[..], &one];
        let low = LowRank::until(&points, 1e-3 * lambda, n).unwrap();
        let a = preconditioned(&points, lambda, rhs, &low).unwrap();
        let mut matrix = vec![0.0; n * n];
        points.fill_lower(&mut matrix);
        factorise(&mut matrix, n, lambda).unwrap();
        for (c, rhs) in rhs.iter().enumerate() {
            let mut x = rhs.to_vec();
            solve_factored(&matrix, n, &mut x);
            let length = dot(&x, &x).sqrt();
            let error = x.iter().zip(&a.x[c]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            assert!(error < 1e-8 * length, "{error} of {length}");
        }
        assert!(matches!(a.route, Route::Preconditioned { iterations, .. } if iterations < 20));
    }
}

//! Solves `(K + λ·I)·x = r` for two right-hand sides by the route that suits the kernel.
//!
//! * *Preconditioned*: a smooth kernel has a low rank; its pivoted Cholesky factor preconditions
//!   conjugate gradients on the exact matrix, a few iterations are enough.
//! * *Dense*: else Cholesky in place.
//!
//! Both end with the exact residual, from kernels computed anew.

pub(crate) mod dense;
pub(crate) mod kernel;
pub(crate) mod pivoted;

use self::dense::{Mat, View, add_lower, cholesky, solve_with, view, view_mut};
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
    cholesky(view_mut(matrix, n, n)).ok_or(Error::IllPosed { samples: n, lambda })
}

/// `x := (L·Lᵀ)⁻¹·x`.
pub(crate) fn solve_factored(factor: &[f64], n: usize, x: &mut [f64]) {
    solve_with(&view(factor, n, n), view_mut(x, n, 1));
}

/// (L·Lᵀ + λ·I)⁻¹ by the matrix inversion lemma.
struct Preconditioner<'a> {
    low: View<'a>,
    inner: Mat,
    lambda: f64,
}

impl<'a> Preconditioner<'a> {
    fn new(low: &'a LowRank, lambda: f64) -> Option<Self> {
        let low = low.factor();
        let mut inner = gram(&low, lambda);
        cholesky(inner.as_view_mut())?;
        Some(Self { low, inner, lambda })
    }

    fn apply(&self, v: &Mat) -> Mat {
        let mut inner = self.low.tr_mul(v);
        solve_with(&self.inner.as_view(), inner.as_view_mut());
        let mut out = v.clone();
        out.gemm(-1.0, &self.low, &inner, 1.0);
        out / self.lambda
    }
}

/// The lower half of `LᵀL + λ·I`.
pub(crate) fn gram(low: &View<'_>, lambda: f64) -> Mat {
    let r = low.ncols();
    let mut inner = Mat::from_diagonal_element(r, r, lambda);
    add_lower(&mut inner.as_view_mut(), 1.0, &low.transpose().as_view(), low);
    inner
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
    let multiply = |x: &Mat, out: &mut Mat| {
        let (x0, x1) = x.as_slice().split_at(n);
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
    let mut slope = [0, 1].map(|c| rest.column(c).dot(&z.column(c)));
    let mut iterations = 0;
    let converged = |x: &Mat, rest: &Mat, c: usize| {
        rest.column(c).norm() <= TOLERANCE * lambda * x.column(c).norm()
    };
    // Below this the product's own rounding errors speak.
    let floor = |rest: &Mat, c: usize| rest.column(c).norm() <= 1e-13 * rhs.column(c).norm();
    while !(0..2).all(|c| converged(&x, &rest, c) || floor(&rest, c)) {
        if iterations == MOST_ITERATIONS {
            return None;
        }
        iterations += 1;
        multiply(&direction, &mut product);
        for (c, slope) in slope.iter().enumerate() {
            let curvature = direction.column(c).dot(&product.column(c));
            let step = if curvature > 0.0 { slope / curvature } else { 0.0 };
            x.column_mut(c).axpy(step, &direction.column(c), 1.0);
            rest.column_mut(c).axpy(-step, &product.column(c), 1.0);
        }
        z = preconditioner.apply(&rest);
        for (c, slope) in slope.iter_mut().enumerate() {
            let new = rest.column(c).dot(&z.column(c));
            let factor = if *slope == 0.0 { 0.0 } else { new / *slope };
            *slope = new;
            direction.column_mut(c).axpy(1.0, &z.column(c), factor);
        }
    }
    let x = [0, 1].map(|c| x.column(c).as_slice().to_vec());
    Some(Solved { x, route: Route::Preconditioned { rank: low.rank(), iterations } })
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
            let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
            let error = x.iter().zip(&a.x[c]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            assert!(error < 1e-8 * length, "{error} of {length}");
        }
        assert!(matches!(a.route, Route::Preconditioned { iterations, .. } if iterations < 20));
    }
}

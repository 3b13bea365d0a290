//! Dense matrices: nalgebra's, whose Cholesky factor, triangular solutions and inverses become products of halves here.
//!
//! ```text
//! [A₁₁    ]   [L₁₁    ] [L₁₁ᵀ L₂₁ᵀ]      L₁₁ = chol(A₁₁),  L₂₁ = A₂₁·L₁₁⁻ᵀ,
//! [A₂₁ A₂₂] = [L₂₁ L₂₂]·[     L₂₂ᵀ]      L₂₂ = chol(A₂₂ − L₂₁·L₂₁ᵀ)
//! ```
//!
//! Nearly all the work is in matrix products, which are fast; one column after the other, as nalgebra's own factors are
//! made, 2000 rows take ten times as long.
//!
//! Source: F. G. Gustavson, IBM J. Res. Dev. 41 (1997) 737-755.

use nalgebra::{DMatrixView, DMatrixViewMut};

/// A matrix.
pub(crate) type Mat = nalgebra::DMatrix<f64>;
/// A part of a matrix, read.
pub(crate) type View<'a> = DMatrixView<'a, f64>;
/// A part of a matrix, changed.
pub(crate) type ViewMut<'a> = DMatrixViewMut<'a, f64>;

/// Columns below which there are no halves.
const LEAST: usize = 32;
/// Columns of a block of which the upper half is computed in vain.
const BLOCK: usize = 128;

/// The matrix whose columns follow each other in `values`.
pub(crate) fn view(values: &[f64], rows: usize, columns: usize) -> View<'_> {
    View::from_slice(values, rows, columns)
}

/// The matrix, to be changed, whose columns follow each other in `values`.
pub(crate) fn view_mut(values: &mut [f64], rows: usize, columns: usize) -> ViewMut<'_> {
    ViewMut::from_slice(values, rows, columns)
}

/// The lower half of `out := out + factor·a·b`.
pub(crate) fn add_lower(out: &mut ViewMut<'_>, factor: f64, a: &View<'_>, b: &View<'_>) {
    let n = out.ncols();
    for from in (0..n).step_by(BLOCK) {
        let width = BLOCK.min(n - from);
        let mut block = out.view_mut((from, from), (n - from, width));
        block.gemm(factor, &a.rows(from, n - from), &b.columns(from, width), 1.0);
    }
}

/// Cholesky factor in place of the lower half; `None` where the matrix is not positive definite.
pub(crate) fn cholesky(mut a: ViewMut<'_>) -> Option<()> {
    let n = a.ncols();
    if n <= LEAST {
        for j in 0..n {
            let (done, mut column) = a.columns_range_pair_mut(0..j, j);
            for k in 0..j {
                let known = done.column(k);
                column.rows_mut(j, n - j).axpy(-known[j], &known.rows(j, n - j), 1.0);
            }
            let square = column[j];
            if !(square > 0.0 && square.is_finite()) {
                return None;
            }
            column[j] = square.sqrt();
            let rest = 1.0 / column[j];
            column.rows_mut(j + 1, n - j - 1).scale_mut(rest);
        }
        return Some(());
    }
    let half = n / 2;
    let (mut left, mut right) = a.columns_range_pair_mut(0..half, half..n);
    cholesky(left.rows_mut(0, half))?;
    let (upper, lower) = left.rows_range_pair_mut(0..half, half..n);
    divide_right(&upper.as_view(), lower);
    let lower = left.rows(half, n - half);
    let mut rest = right.rows_mut(half, n - half);
    add_lower(&mut rest, -1.0, &lower, &lower.transpose().as_view());
    cholesky(rest)
}

/// `b := b·L⁻ᵀ`.
pub(crate) fn divide_right(lower: &View<'_>, mut b: ViewMut<'_>) {
    let n = lower.ncols();
    if n <= LEAST {
        for j in 0..n {
            let (done, mut column) = b.columns_range_pair_mut(0..j, j);
            for k in 0..j {
                column.axpy(-lower[(j, k)], &done.column(k), 1.0);
            }
            column.scale_mut(1.0 / lower[(j, j)]);
        }
        return;
    }
    let half = n / 2;
    let (mut first, mut second) = b.columns_range_pair_mut(0..half, half..n);
    divide_right(&lower.view((0, 0), (half, half)), first.as_view_mut());
    let across = lower.view((half, 0), (n - half, half)).transpose();
    second.gemm(-1.0, &first, &across, 1.0);
    divide_right(&lower.view((half, half), (n - half, n - half)), second);
}

/// `b := L⁻¹·b`.
pub(crate) fn divide(lower: &View<'_>, mut b: ViewMut<'_>) {
    let n = lower.ncols();
    if n <= LEAST {
        for mut x in b.column_iter_mut() {
            for i in 0..n {
                let (mut at, mut below) = x.rows_range_pair_mut(i, i + 1..n);
                at[0] /= lower[(i, i)];
                below.axpy(-at[0], &lower.column(i).rows(i + 1, n - i - 1), 1.0);
            }
        }
        return;
    }
    let half = n / 2;
    let (mut first, mut second) = b.rows_range_pair_mut(0..half, half..n);
    divide(&lower.view((0, 0), (half, half)), first.as_view_mut());
    second.gemm(-1.0, &lower.view((half, 0), (n - half, half)), &first, 1.0);
    divide(&lower.view((half, half), (n - half, n - half)), second);
}

/// `b := L⁻ᵀ·b`.
pub(crate) fn divide_transposed(lower: &View<'_>, mut b: ViewMut<'_>) {
    let n = lower.ncols();
    if n <= LEAST {
        for mut x in b.column_iter_mut() {
            for i in (0..n).rev() {
                let below = lower.column(i).rows(i + 1, n - i - 1).dot(&x.rows(i + 1, n - i - 1));
                x[i] = (x[i] - below) / lower[(i, i)];
            }
        }
        return;
    }
    let half = n / 2;
    let (mut first, mut second) = b.rows_range_pair_mut(0..half, half..n);
    divide_transposed(&lower.view((half, half), (n - half, n - half)), second.as_view_mut());
    let across = lower.view((half, 0), (n - half, half));
    if second.ncols() <= 2 {
        first.gemm_tr(-1.0, &across, &second, 1.0);
    } else {
        first.gemm(-1.0, &across.transpose(), &second, 1.0);
    }
    divide_transposed(&lower.view((0, 0), (half, half)), first);
}

/// `x := (L·Lᵀ)⁻¹·x`.
pub(crate) fn solve_with(factor: &View<'_>, mut x: ViewMut<'_>) {
    divide(factor, x.as_view_mut());
    divide_transposed(factor, x);
}

/// `b := b·L`.
fn multiply_right(mut b: ViewMut<'_>, lower: &View<'_>) {
    let n = lower.ncols();
    if n <= LEAST {
        for j in 0..n {
            let (mut column, rest) = b.columns_range_pair_mut(j, j + 1..n);
            column.scale_mut(lower[(j, j)]);
            for k in j + 1..n {
                column.axpy(lower[(k, j)], &rest.column(k - j - 1), 1.0);
            }
        }
        return;
    }
    let half = n / 2;
    let (mut first, second) = b.columns_range_pair_mut(0..half, half..n);
    multiply_right(first.as_view_mut(), &lower.view((0, 0), (half, half)));
    first.gemm(1.0, &second, &lower.view((half, 0), (n - half, half)), 1.0);
    multiply_right(second, &lower.view((half, half), (n - half, n - half)));
}

/// `b := L·b`.
fn multiply(lower: &View<'_>, mut b: ViewMut<'_>) {
    let n = lower.ncols();
    if n <= LEAST {
        for mut x in b.column_iter_mut() {
            for k in (0..n).rev() {
                let (mut at, mut below) = x.rows_range_pair_mut(k, k + 1..n);
                below.axpy(at[0], &lower.column(k).rows(k + 1, n - k - 1), 1.0);
                at[0] *= lower[(k, k)];
            }
        }
        return;
    }
    let half = n / 2;
    let (first, mut second) = b.rows_range_pair_mut(0..half, half..n);
    multiply(&lower.view((half, half), (n - half, n - half)), second.as_view_mut());
    second.gemm(1.0, &lower.view((half, 0), (n - half, half)), &first, 1.0);
    multiply(&lower.view((0, 0), (half, half)), first);
}

/// `b := Lᵀ·b`.
fn multiply_transposed(lower: &View<'_>, mut b: ViewMut<'_>) {
    let n = lower.ncols();
    if n <= LEAST {
        for mut x in b.column_iter_mut() {
            for i in 0..n {
                x[i] = lower.column(i).rows(i, n - i).dot(&x.rows(i, n - i));
            }
        }
        return;
    }
    let half = n / 2;
    let (mut first, second) = b.rows_range_pair_mut(0..half, half..n);
    multiply_transposed(&lower.view((0, 0), (half, half)), first.as_view_mut());
    let across = lower.view((half, 0), (n - half, half)).transpose();
    first.gemm(1.0, &across, &second, 1.0);
    multiply_transposed(&lower.view((half, half), (n - half, n - half)), second);
}

/// L⁻¹, whose upper half is zero.
pub(crate) fn inverted_lower(lower: &View<'_>) -> Mat {
    fn fill(lower: &View<'_>, mut out: ViewMut<'_>) {
        let n = lower.ncols();
        if n <= LEAST {
            out.fill_with_identity();
            divide(lower, out);
            return;
        }
        let half = n / 2;
        let (mut left, mut right) = out.columns_range_pair_mut(0..half, half..n);
        fill(&lower.view((0, 0), (half, half)), left.rows_mut(0, half));
        fill(&lower.view((half, half), (n - half, n - half)), right.rows_mut(half, n - half));
        let (first, mut across) = left.rows_range_pair_mut(0..half, half..n);
        across.copy_from(&lower.view((half, 0), (n - half, half)));
        multiply_right(across.as_view_mut(), &first.as_view());
        multiply(&right.rows(half, n - half).as_view(), across.as_view_mut());
        across.neg_mut();
    }
    let mut out = Mat::zeros(lower.ncols(), lower.ncols());
    fill(lower, out.as_view_mut());
    out
}

/// The lower half of `(L·Lᵀ)⁻¹`.
pub(crate) fn inverse(factor: &View<'_>) -> Mat {
    fn squared(lower: &View<'_>, mut out: ViewMut<'_>) {
        let n = lower.ncols();
        if n <= LEAST {
            out.gemm_tr(1.0, lower, lower, 0.0);
            return;
        }
        let half = n / 2;
        let across = lower.view((half, 0), (n - half, half));
        let last = lower.view((half, half), (n - half, n - half));
        squared(&lower.view((0, 0), (half, half)), out.view_mut((0, 0), (half, half)));
        squared(&last, out.view_mut((half, half), (n - half, n - half)));
        let mut first = out.view_mut((0, 0), (half, half));
        add_lower(&mut first, 1.0, &across.transpose().as_view(), &across);
        let mut below = out.view_mut((half, 0), (n - half, half));
        below.copy_from(&across);
        multiply_transposed(&last, below);
    }
    let lower = inverted_lower(factor);
    let mut out = Mat::zeros(lower.ncols(), lower.ncols());
    squared(&lower.as_view(), out.as_view_mut());
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::wave;

    /// Sizes on both sides of where there are halves.
    #[test]
    fn factors_solutions_and_inverses_are_those_of_nalgebra() {
        for n in [1, 2, LEAST, LEAST + 1, 3 * LEAST + 5, 2 * BLOCK + 7] {
            let base = Mat::from_vec(n, n, wave(n * n, 1.1));
            let full = &base * base.transpose() + Mat::identity(n, n);
            let theirs = full.clone().cholesky().unwrap();
            let mut factor = full.clone();
            // Of the upper half nothing may be read.
            factor.fill_upper_triangle(f64::NAN, 1);
            cholesky(factor.as_view_mut()).unwrap();
            factor.fill_upper_triangle(0.0, 1);
            let near = |a: &Mat, b: &Mat, what: &str| {
                let error = (a - b).amax() / b.amax();
                assert!(error < 1e-11, "{what}, {n} rows: {error}");
            };
            near(&factor, &theirs.l(), "factor");
            factor.fill_upper_triangle(f64::NAN, 1);
            let lower = factor.as_view();
            for columns in [1, 9] {
                let right = Mat::from_vec(n, columns, wave(n * columns, 0.3));
                let mut x = right.clone();
                solve_with(&lower, x.as_view_mut());
                near(&x, &theirs.solve(&right), "solution");
                let mut x = right.transpose();
                divide_right(&lower, x.as_view_mut());
                near(&(x * theirs.l().transpose()), &right.transpose(), "from the right");
            }
            near(&(inverted_lower(&lower) * theirs.l()), &Mat::identity(n, n), "inverse of L");
            near(&inverse(&lower).lower_triangle(), &theirs.inverse().lower_triangle(), "inverse");
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_factor() {
        for n in [3, 100] {
            let mut matrix = Mat::identity(n, n);
            matrix[(n - 1, n - 1)] = -1.0;
            assert!(cholesky(matrix.as_view_mut()).is_none());
            matrix[(n - 1, n - 1)] = f64::NAN;
            assert!(cholesky(matrix.as_view_mut()).is_none());
        }
    }
}

//! QR factorisation of tall matrices by blocks of columns.

use nalgebra::DMatrix;

/// Columns that are reflected one by one before all others take their reflections at once.
const PANEL: usize = 8;

/// The triangle R of A = Q R, of min(rows, columns) rows; the signs of its rows are arbitrary.
///
/// ```text
/// Qᵀ = … (I − V_2 T_2ᵀ V_2ᵀ) (I − V_1 T_1ᵀ V_1ᵀ), one factor for each panel of columns
/// ```
///
/// With a right-hand side b as the last column of A it holds all that least squares need: the last column of R is then Qᵀ b,
/// and its last entry is ± ‖A x − b‖. Nearly all work is in products of matrices, which are many times as fast as
/// reflections of one column at a time.
///
/// Source: R. Schreiber, C. Van Loan, SIAM J. Sci. Stat. Comput. 10 (1989) 53-57.
#[must_use]
pub fn triangle(mut a: DMatrix<f64>) -> DMatrix<f64> {
    let (rows, columns) = a.shape();
    let rank = rows.min(columns);
    for first in (0..rank).step_by(PANEL) {
        let width = PANEL.min(rank - first);
        let rest = columns - first - width;
        let mut panel = a.view((first, first), (rows - first, width)).into_owned();
        let scales = reflect(&mut panel);
        a.view_mut((first, first), (width, width)).copy_from(&panel.rows(0, width));
        if rest > 0 {
            panel.fill_upper_triangle(0.0, 1);
            panel.fill_diagonal(1.0);
            let transposed = panel.transpose();
            let factor = compact(&(&transposed * &panel), &scales);
            let mut others = a.view_mut((first, first + width), (rows - first, rest));
            let seen = factor.tr_mul(&(transposed * &others));
            others.gemm(-1.0, &panel, &seen, 1.0);
        }
    }
    let mut triangle = a.rows(0, rank).into_owned();
    triangle.fill_lower_triangle(0.0, 1);
    triangle
}

/// Reflects the columns of a panel one after the other. Below the diagonal stand then the vectors v of I − τ v vᵀ, without
/// their first entry, which is 1. Returns τ.
fn reflect(panel: &mut DMatrix<f64>) -> Vec<f64> {
    let mut scales = vec![0.0; panel.ncols()];
    for (k, scale) in scales.iter_mut().enumerate() {
        let (mut done, mut others) = panel.columns_range_pair_mut(k..=k, k + 1..);
        let below = done.nrows() - k - 1;
        let head = done[k];
        let norm = head.hypot(done.rows(k + 1, below).norm());
        // A column of zeros stays as it is.
        if norm == 0.0 {
            continue;
        }
        let diagonal = -norm.copysign(head);
        *scale = (diagonal - head) / diagonal;
        done[k] = diagonal;
        let mut v = done.rows_mut(k + 1, below);
        v.unscale_mut(head - diagonal);
        let v = v.column(0);
        for mut column in others.column_iter_mut() {
            let along = *scale * (column[k] + column.rows(k + 1, below).dot(&v));
            column[k] -= along;
            column.rows_mut(k + 1, below).axpy(-along, &v, 1.0);
        }
    }
    scales
}

/// The triangle T of (I − τ_1 v_1 v_1ᵀ) (I − τ_2 v_2 v_2ᵀ) … = I − V T Vᵀ, from Vᵀ V and τ.
fn compact(products: &DMatrix<f64>, scales: &[f64]) -> DMatrix<f64> {
    let mut factor = DMatrix::zeros(scales.len(), scales.len());
    for (k, scale) in scales.iter().enumerate() {
        let before = factor.view((0, 0), (k, k)) * products.view((0, k), (k, 1)) * -*scale;
        factor.view_mut((0, k), (k, 1)).copy_from(&before);
        factor[(k, k)] = *scale;
    }
    factor
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    /// Against one column at a time, at shapes around a panel's width.
    #[test]
    fn the_triangle_is_that_of_single_reflections() {
        let mut random = SplitMix64::new(3);
        for shape in
            [(1, 1), (40, 7), (40, 8), (40, 15), (40, 16), (57, 17), (90, 50), (20, 33), (33, 33)]
        {
            let a = DMatrix::from_fn(shape.0, shape.1, |_, _| random.normal());
            let (fast, slow) = (triangle(a.clone()), a.qr().r());
            assert_eq!(fast.shape(), slow.shape());
            for (fast, slow) in fast.row_iter().zip(slow.row_iter()) {
                let sign = (fast.dot(&slow)).signum();
                assert!((fast * sign - slow).amax() < 1e-12, "{shape:?}");
            }
        }
    }

    #[test]
    fn columns_of_zeros_and_copies_leave_zeros() {
        let mut random = SplitMix64::new(4);
        let mut a = DMatrix::from_fn(60, 20, |_, _| random.normal());
        let copy = a.column(2).into_owned();
        a.column_mut(5).fill(0.0);
        a.column_mut(18).copy_from(&copy);
        let r = triangle(a.clone());
        assert!((r.tr_mul(&r) - a.tr_mul(&a)).amax() < 1e-12 * a.norm_squared());
        assert!(r[(18, 18)].abs() < 1e-12 && r.column(5).amax() == 0.0);
    }
}

//! Pivoted Cholesky in blocks: K ≈ L·Lᵀ with as few columns as the kernel's smoothness allows.
//!
//! Each round takes the 256 points whose diagonal is explained worst, picks pivots among them one by
//! one as the classical algorithm does, and updates all rows at once. The pivots are not those of
//! the classical algorithm, but each is at least a fifth as good as the best of its round.
//!
//! Reference: H. Harbrecht, M. Peters, R. Schneider, On the low-rank approximation by the pivoted
//! Cholesky decomposition, Appl. Numer. Math. 62 (2012) 428-440.

use super::dense::{Mat, View, divide_right, view, view_mut};
use super::kernel::Scaled;

/// Points that compete in a round.
const POOL: usize = 256;
/// Most pivots of a round.
const MOST: usize = 64;
/// Least diagonal of a pivot, as a part of the greatest one of its round.
const PART: f64 = 0.2;

/// `K ≈ L·Lᵀ`.
#[derive(Clone, Debug)]
pub(crate) struct LowRank {
    /// Column after column, n rows each.
    columns: Vec<f64>,
    n: usize,
    /// The points that were taken, in order: L restricted to them is lower triangular.
    pub(crate) pivots: Vec<usize>,
    /// Greatest diagonal of K − L·Lᵀ.
    pub(crate) worst: f64,
}

impl LowRank {
    /// Goes on until the greatest diagonal of the remainder is at most `tolerance`; `None` where
    /// `most` columns are not enough.
    pub(crate) fn until(points: &Scaled, tolerance: f64, most: usize) -> Option<Self> {
        let low = Self::grow(points, tolerance, most, |low| {
            // The diagonal falls ever slower: as it fell so far, it needs at least so many.
            let needed = low.rank() as f64 * tolerance.ln() / low.worst.min(0.99).ln();
            needed <= most as f64
        });
        (low.worst <= tolerance).then_some(low)
    }

    /// At most `most` columns.
    pub(crate) fn up_to(points: &Scaled, tolerance: f64, most: usize) -> Self {
        Self::grow(points, tolerance, most, |_| true)
    }

    fn grow(points: &Scaled, tolerance: f64, most: usize, goes_on: impl Fn(&Self) -> bool) -> Self {
        let n = points.n;
        let most = most.min(n);
        let mut low = Self {
            columns: Vec::new(),
            n,
            pivots: Vec::new(),
            worst: if n > 0 { 1.0 } else { 0.0 },
        };
        let mut diagonal = vec![1.0; n];
        while low.worst > tolerance && low.rank() < most {
            let least = tolerance.max(PART * low.worst);
            let (new, factor) = low.round(points, &diagonal, least, most - low.rank());
            if new.is_empty() {
                break;
            }
            low.extend(points, &new, &factor, &mut diagonal);
            low.worst = diagonal.iter().copied().fold(0.0, f64::max);
            if !goes_on(&low) {
                break;
            }
        }
        low
    }

    pub(crate) fn rank(&self) -> usize {
        self.pivots.len()
    }

    /// L.
    pub(crate) fn factor(&self) -> View<'_> {
        view(&self.columns, self.n, self.rank())
    }

    /// The rows of L that belong to `points`.
    pub(crate) fn rows(&self, points: &[usize]) -> Mat {
        Mat::from_fn(points.len(), self.rank(), |i, j| self.columns[j * self.n + points[i]])
    }

    /// Picks the pivots of a round; returns them with the Cholesky factor of their remainder.
    fn round(
        &self,
        points: &Scaled,
        diagonal: &[f64],
        least: f64,
        most: usize,
    ) -> (Vec<usize>, Mat) {
        let mut pool: Vec<usize> = (0..self.n).filter(|i| diagonal[*i] >= least).collect();
        let by_diagonal = |a: &usize, b: &usize| diagonal[*b].total_cmp(&diagonal[*a]);
        if pool.len() > POOL {
            pool.select_nth_unstable_by(POOL, by_diagonal);
            pool.truncate(POOL);
        }
        let rows = self.rows(&pool);
        let inputs: Vec<f64> = pool.iter().flat_map(|i| points.point(*i)).copied().collect();
        let few = Scaled::new(&inputs, points.d, &vec![1.0; points.d]);
        let size = pool.len();
        let mut rest: Vec<f64> = pool.iter().map(|i| diagonal[*i]).collect();
        // The classical algorithm on the pool; its factor is kept for the pivots alone.
        let mut taken: Vec<usize> = Vec::new();
        let mut factor: Vec<Vec<f64>> = Vec::new();
        while taken.len() < MOST.min(most) {
            let best = (0..size).max_by(|a, b| rest[*a].total_cmp(&rest[*b]));
            let Some(p) = best.filter(|p| rest[*p] >= least) else { break };
            let mut column = vec![0.0; size];
            few.column(p, &mut column);
            let row = rows.row(p).transpose();
            view_mut(&mut column, size, 1).gemm(-1.0, &rows, &row, 1.0);
            for earlier in &factor {
                let at = earlier[p];
                column.iter_mut().zip(earlier).for_each(|(c, e)| *c -= at * e);
            }
            let root = column[p].max(0.0).sqrt();
            if root * root < 0.5 * least {
                // Rounding has eaten what was left of it.
                rest[p] = 0.0;
                continue;
            }
            for (c, rest) in column.iter_mut().zip(&mut rest) {
                *c /= root;
                *rest -= *c * *c;
            }
            rest[p] = 0.0;
            taken.push(p);
            factor.push(column);
        }
        let entry = |i: usize, j: usize| if i >= j { factor[j][taken[i]] } else { 0.0 };
        let lower = Mat::from_fn(taken.len(), taken.len(), entry);
        (taken.into_iter().map(|p| pool[p]).collect(), lower)
    }

    /// Adds the columns of these pivots.
    fn extend(&mut self, points: &Scaled, new: &[usize], lower: &Mat, diagonal: &mut [f64]) {
        let (n, old) = (self.n, self.rank());
        let rows = self.rows(new);
        let mut columns = vec![0.0; n * new.len()];
        for (column, pivot) in columns.chunks_exact_mut(n).zip(new) {
            points.column(*pivot, column);
        }
        let mut added = view_mut(&mut columns, n, new.len());
        added.gemm(-1.0, &view(&self.columns, n, old), &rows.transpose(), 1.0);
        divide_right(&lower.as_view(), added);
        for column in columns.chunks_exact(n) {
            for (diagonal, l) in diagonal.iter_mut().zip(column) {
                *diagonal -= l * l;
            }
        }
        for pivot in new {
            diagonal[*pivot] = 0.0;
        }
        self.columns.extend_from_slice(&columns);
        self.pivots.extend_from_slice(new);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::wave;

    #[test]
    fn the_remainder_is_as_small_as_asked_everywhere() {
        let (n, d) = (300, 3);
        let points = Scaled::new(&wave(n * d, 1.1), d, &[0.7; 3]);
        let low = LowRank::until(&points, 1e-8, n).unwrap();
        assert!(low.rank() < 250, "{}", low.rank());
        let l = low.factor();
        let mut column = vec![0.0; n];
        for j in 0..n {
            points.column(j, &mut column);
            for i in 0..n {
                let sum: f64 = (0..low.rank()).map(|k| l[(i, k)] * l[(j, k)]).sum();
                assert!((column[i] - sum).abs() < 2e-8, "{i} {j}");
            }
        }
        // On the pivots L is lower triangular.
        let on_pivots = low.rows(&low.pivots);
        for i in 0..low.rank() {
            assert!(on_pivots[(i, i)] > 0.0);
            for j in i + 1..low.rank() {
                assert!(on_pivots[(i, j)].abs() < 1e-6, "{}", on_pivots[(i, j)]);
            }
        }
    }

    #[test]
    fn a_rough_kernel_has_no_low_rank() {
        let points = Scaled::new(&wave(200, 1.1), 1, &[1e6]);
        assert!(LowRank::until(&points, 1e-8, 60).is_none());
    }
}

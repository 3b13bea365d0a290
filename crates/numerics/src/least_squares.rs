//! Linear least squares over long records, with and without the bound x ≥ 0.
//!
//! The tall system is first reduced to the triangular factor R of [A b] by blocks of rows, which
//! changes neither the minimiser nor the residual and squares no condition number. The bounded
//! problem is then solved by Lawson and Hanson's active-set method and its optimality is checked
//! against the Karush–Kuhn–Tucker conditions: an answer that fails them is an error, not a model.

use nalgebra::{DMatrix, DVector};
use ndarray::{Array1, Array2};

use crate::qr::triangle;

/// Rows that are reduced at a time.
const BLOCK: usize = 512;
/// Largest scaled violation of the optimality conditions that counts as zero.
const OPTIMALITY: f64 = 1e-7;
/// Weight of the rows that keep exact ties out of the active-set method, relative to a column of
/// unit length. It moves the solution by about cond(A)²·1e-20.
const TIE_BREAKER: f64 = 1e-10;
/// Columns shorter than this, relative to the longest, carry no information.
const EMPTY_COLUMN: f64 = 1e-12;

/// Why a system has no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoSolution(pub &'static str);

/// The triangular factor of a tall system [A b].
#[derive(Clone, Debug)]
pub struct Reduced {
    columns: usize,
    factor: DMatrix<f64>,
    pending: Vec<f64>,
}

/// A solution of min ‖A x − b‖.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The minimiser.
    pub x: Vec<f64>,
    /// For each unknown that is not at its bound, its variance for residuals of unit variance.
    pub variance: Vec<Option<f64>>,
    /// For each such unknown, the other one it is correlated with most, and that correlation.
    pub partner: Vec<Option<Partner>>,
}

/// The index of another unknown and the correlation with it.
pub type Partner = (usize, f64);

impl Reduced {
    /// An empty system of this many unknowns.
    #[must_use]
    pub fn new(columns: usize) -> Self {
        Self { columns, factor: DMatrix::zeros(0, columns + 1), pending: Vec::new() }
    }

    /// Adds one row: `columns` coefficients, then the right-hand side.
    pub fn push(&mut self, row: impl IntoIterator<Item = f64>) {
        self.pending.extend(row.into_iter().take(self.columns + 1));
        if self.pending.len() >= BLOCK * (self.columns + 1) {
            self.reduce();
        }
    }

    fn reduce(&mut self) {
        let width = self.columns + 1;
        let fresh = self.pending.len() / width;
        if fresh == 0 {
            return;
        }
        let block = DMatrix::from_row_slice(fresh, width, &self.pending[..fresh * width]);
        self.pending.clear();
        let kept = self.factor.nrows();
        let mut stacked = DMatrix::zeros(kept + fresh, width);
        stacked.rows_mut(0, kept).copy_from(&self.factor);
        stacked.rows_mut(kept, fresh).copy_from(&block);
        self.factor = if stacked.nrows() > width { triangle(stacked) } else { stacked };
    }

    /// min ‖A x − b‖ where the first `free` unknowns have any sign and the others are ≥ 0.
    ///
    /// The free ones are eliminated exactly: the rows of R below them are the problem in which each
    /// other column and the right-hand side is orthogonal to theirs.
    ///
    /// # Errors
    /// [`NoSolution`] where the method does not reach a point that is optimal.
    pub fn solve(mut self, free: usize) -> Result<Solution, NoSolution> {
        self.reduce();
        let free = free.min(self.columns);
        if free > 0 {
            self.factor = triangle(core::mem::take(&mut self.factor));
        }
        let (matrix, target) = self.split();
        if !matrix.iter().chain(target.iter()).all(|v| v.is_finite()) {
            return Err(NoSolution("the regressors hold a value that is not finite"));
        }
        let rows = matrix.nrows();
        let first = free.min(rows);
        let lower = matrix.view((first, free), (rows - first, self.columns - free)).into_owned();
        let bounded = bounded(&lower, &target.rows(first, rows - first).into_owned())?;
        let mut x = vec![0.0; free];
        if free > 0 {
            let coupled = matrix.view((0, free), (first, bounded.len()));
            let right = target.rows(0, first) - coupled * DVector::from_column_slice(&bounded);
            let own = matrix.view((0, 0), (first, free)).into_owned();
            let threshold = EMPTY_COLUMN * own.amax();
            let solved = own.svd(true, true).solve(&right, threshold);
            x.copy_from_slice(solved.map_err(NoSolution)?.as_slice());
        }
        x.extend(bounded);
        Ok(finish(&matrix, x))
    }

    fn split(&self) -> (DMatrix<f64>, DVector<f64>) {
        (
            self.factor.columns(0, self.columns).into_owned(),
            self.factor.column(self.columns).into_owned(),
        )
    }
}

/// min ‖A x − b‖ with x ≥ 0, columns without information left at zero.
fn bounded(matrix: &DMatrix<f64>, target: &DVector<f64>) -> Result<Vec<f64>, NoSolution> {
    let lengths: Vec<f64> = matrix.column_iter().map(|c| c.norm()).collect();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let used: Vec<usize> =
        (0..lengths.len()).filter(|&i| lengths[i] > EMPTY_COLUMN * longest).collect();
    let mut x = vec![0.0; lengths.len()];
    if !used.is_empty() {
        let scaled = DMatrix::from_fn(matrix.nrows(), used.len(), |i, j| {
            matrix[(i, used[j])] / lengths[used[j]]
        });
        let solution = lawson_hanson(&scaled, target)?;
        check_optimality(&scaled, target, &solution)?;
        for (&i, value) in used.iter().zip(&solution) {
            x[i] = value / lengths[i];
        }
    }
    Ok(x)
}

/// Runs the active-set method on columns of unit length.
fn lawson_hanson(matrix: &DMatrix<f64>, target: &DVector<f64>) -> Result<Vec<f64>, NoSolution> {
    let (rows, columns) = matrix.shape();
    let scale = target.norm();
    if scale == 0.0 {
        return Ok(vec![0.0; columns]);
    }
    let a = Array2::from_shape_fn((rows + columns, columns), |(i, j)| match i.checked_sub(rows) {
        None => matrix[(i, j)],
        Some(k) => f64::from(u8::from(k == j)) * TIE_BREAKER,
    });
    let b =
        Array1::from_shape_fn(rows + columns, |i| if i < rows { target[i] / scale } else { 0.0 });
    // The solver panics where two unknowns reach zero at exactly the same length of a step. The
    // extra rows keep that from happening; should it happen all the same, it is an error here.
    let outcome = std::panic::catch_unwind(|| nnls::nnls(a.view(), b.view()));
    let (x, _) =
        outcome.map_err(|_| NoSolution("two weights left the active set at the same moment"))?;
    Ok(x.iter().map(|v| v * scale).collect())
}

/// Karush–Kuhn–Tucker: x ≥ 0, gradient zero where x > 0 and not negative where x = 0.
fn check_optimality(
    matrix: &DMatrix<f64>,
    target: &DVector<f64>,
    x: &[f64],
) -> Result<(), NoSolution> {
    let residual = target - matrix * DVector::from_column_slice(x);
    let descent = matrix.tr_mul(&residual);
    let allowed = OPTIMALITY * target.norm();
    let wrong = x.iter().zip(descent.iter()).any(|(&x, &descent)| {
        !x.is_finite() || x < 0.0 || descent > allowed || (x > 0.0 && descent < -allowed)
    });
    if wrong {
        return Err(NoSolution("the answer fails the optimality conditions"));
    }
    Ok(())
}

/// The variances at a solution; an unknown at zero counts as bound.
fn finish(matrix: &DMatrix<f64>, x: Vec<f64>) -> Solution {
    let free: Vec<usize> = (0..x.len()).filter(|&i| x[i] != 0.0).collect();
    let (variance, partner) = spread(matrix, &free);
    Solution { x, variance, partner }
}

/// min ‖A x − b‖ of more rows than columns, which are scaled to length one: x, and the least ‖A x − b‖². `None` where
/// the columns depend on each other or a value is not finite.
#[must_use]
pub fn of_full_rank(mut matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<(Vec<f64>, f64)> {
    let norms = scaled_columns(&mut matrix);
    let width = norms.len();
    let mut both = matrix.insert_column(width, 0.0);
    both.set_column(width, right);
    let r = triangle(both);
    let found =
        r.view((0, 0), (width, width)).solve_upper_triangular(&r.column(width).rows(0, width));
    let solution = found.map(|x| x.component_div(&norms).as_slice().to_vec());
    let finite = solution.filter(|x| x.iter().all(|x| x.is_finite()));
    Some((finite?, r[(width, width)].powi(2)))
}

/// The minimum of `½ sᵀNs − gᵀs` with `low ≤ s ≤ high`, for a positive definite normal matrix N (n × n), a gradient g (n)
/// and the room (low, high) of each coordinate. What would leave its room is held at its end, and the others are solved
/// for again; what is held stays so. `None` where N is not positive definite.
#[must_use]
pub fn within(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    room: &[(f64, f64)],
) -> Option<DVector<f64>> {
    /// Rounds in which coordinates are held.
    const ROUNDS: usize = 4;
    let n = gradient.len();
    let mut held: Vec<Option<f64>> = vec![None; n];
    let mut step = DVector::zeros(n);
    for _ in 0..ROUNDS {
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

/// Divides each column by its length; returns the lengths.
pub fn scaled_columns(matrix: &mut DMatrix<f64>) -> DVector<f64> {
    let norms = DVector::from_iterator(
        matrix.ncols(),
        matrix.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)),
    );
    for (mut column, norm) in matrix.column_iter_mut().zip(&norms) {
        column.unscale_mut(*norm);
    }
    norms
}

/// Diagonal of (JᵀJ)⁻¹ over the columns `free`, and for each the greatest correlation with another.
#[must_use]
pub fn spread(matrix: &DMatrix<f64>, free: &[usize]) -> (Vec<Option<f64>>, Vec<Option<Partner>>) {
    let (mut variance, mut partner) = (vec![None; matrix.ncols()], vec![None; matrix.ncols()]);
    // Columns of unit length: the inverse then does not suffer from different units.
    let columns = matrix.select_columns(free);
    let lengths: Vec<f64> = columns.column_iter().map(|c| c.norm()).collect();
    let scaled = DMatrix::from_fn(columns.nrows(), free.len(), |i, j| columns[(i, j)] / lengths[j]);
    let Some(inverse) = (!free.is_empty()).then(|| scaled.tr_mul(&scaled).try_inverse()).flatten()
    else {
        return (variance, partner);
    };
    for (k, &i) in free.iter().enumerate() {
        let own = inverse[(k, k)];
        variance[i] = Some(own / lengths[k].powi(2)).filter(|v| v.is_finite() && *v >= 0.0);
        partner[i] = (0..free.len())
            .filter(|&other| other != k)
            .map(|other| {
                (free[other], inverse[(k, other)] / (own * inverse[(other, other)]).sqrt())
            })
            .filter(|(_, correlation)| correlation.is_finite())
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    }
    (variance, partner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    fn system(
        seed: u64,
        rows: usize,
        truth: &[f64],
        noise: f64,
    ) -> (Reduced, DMatrix<f64>, DVector<f64>) {
        let mut random = SplitMix64::new(seed);
        let a = DMatrix::from_fn(rows, truth.len(), |_, _| random.normal());
        let b = DVector::from_fn(rows, |i, _| {
            let exact: f64 = truth.iter().enumerate().map(|(j, x)| a[(i, j)] * x).sum();
            exact + noise * random.normal()
        });
        let mut reduced = Reduced::new(truth.len());
        for i in 0..rows {
            reduced.push(a.row(i).iter().copied().chain([b[i]]));
        }
        (reduced, a, b)
    }

    #[test]
    fn blocks_of_rows_give_the_solution_of_all_rows() {
        let truth = [1.0, 0.5, 2.0, 3.0];
        let (reduced, a, b) = system(1, 3 * BLOCK + 7, &truth, 0.1);
        let solution = reduced.solve(0).expect("solvable");
        let direct = a.clone().svd(true, true).solve(&b, 0.0).expect("full rank");
        for (mine, theirs) in solution.x.iter().zip(direct.iter()) {
            assert!((mine - theirs).abs() < 1e-11, "{mine} {theirs}");
        }
    }

    #[test]
    fn variances_are_those_of_the_normal_equations() {
        let (reduced, a, _) = system(2, 900, &[1.0, 0.0, 2.0], 0.01);
        let solution = reduced.solve(0).expect("solvable");
        let free: Vec<usize> = (0..3).filter(|&i| solution.x[i] > 0.0).collect();
        let columns = a.select_columns(&free);
        let inverse = columns.tr_mul(&columns).try_inverse().expect("full rank");
        for (k, &i) in free.iter().enumerate() {
            let variance = solution.variance[i].expect("free");
            assert!((variance / inverse[(k, k)] - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn weights_that_are_zero_are_found_without_noise_and_with_it() {
        for seed in 0..200 {
            let mut random = SplitMix64::new(seed);
            let truth: Vec<f64> = (0..12)
                .map(|_| if random.uniform() < 0.5 { 0.0 } else { random.uniform() })
                .collect();
            for noise in [0.0, 1e-12, 1e-3] {
                let (reduced, ..) = system(seed + 1000, 300, &truth, noise);
                let solution = reduced.solve(0);
                let solution =
                    solution.unwrap_or_else(|e| panic!("seed {seed}, noise {noise}: {e:?}"));
                for (found, expected) in solution.x.iter().zip(&truth) {
                    let error = (found - expected).abs();
                    assert!(error < 1e-9 + noise, "seed {seed}, noise {noise}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn a_column_without_information_gets_no_weight() {
        let mut reduced = Reduced::new(2);
        for k in 0..20 {
            let x = f64::from(k) - 9.5;
            reduced.push([x, 0.0, 3.0 * x]);
        }
        let solution = reduced.solve(0).expect("solvable");
        assert!((solution.x[0] - 3.0).abs() < 1e-12);
        assert_eq!(solution.x[1], 0.0);
        assert_eq!(solution.variance[1], None);
    }

    #[test]
    fn values_that_are_not_finite_are_refused() {
        let mut reduced = Reduced::new(1);
        reduced.push([1.0, 2.0]);
        reduced.push([1.0, f64::NAN]);
        reduced.push([f64::INFINITY, 1.0]);
        assert!(reduced.solve(0).is_err());
    }

    #[test]
    fn what_would_leave_its_room_is_held_at_its_end() {
        let normal = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        let gradient = DVector::from_vec(vec![3.0, 3.0]);
        let all = (f64::MIN, f64::MAX);
        let step = within(&normal, &gradient, &[all, all]).expect("positive definite");
        assert!((step - DVector::from_vec(vec![1.0, 1.0])).norm() < 1e-12);
        // With the first at 0.4 the second is (3 − 0.4)/2.
        let step = within(&normal, &gradient, &[(-1.0, 0.4), all]).expect("positive definite");
        assert!((step - DVector::from_vec(vec![0.4, 1.3])).norm() < 1e-12);
        assert!(within(&-normal, &gradient, &[all, all]).is_none());
    }
}

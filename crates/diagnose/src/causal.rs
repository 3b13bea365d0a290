//! How much of what is left follows from the command: that part is no noise, however little is known of the noise.
//!
//! A regression of the residual r on causal functions x of the command and of the simulated reading predicts each block of
//! rows by the others:
//!
//! ```text
//! caused = mean(r² − (r − xᵀc)²),    c = (XᵀX + λI)⁻¹Xᵀr of the other blocks
//! ```
//!
//! in powers of the noise. Noise predicts nothing: the mean is not above zero then. The functions are the signals
//! themselves, their low-passes, band-passes of the reading (a mode or a damping that is off), triangles over the ranges of
//! both (a curve, a limit) and by direction (a memory). Level and slope of each block are taken out of all of them: slow
//! courses have as few degrees of freedom as the slow functions that would explain them.
//!
//! Source of the idea: cross-validation, M. Stone, J. R. Stat. Soc. B 36 (1974) 111–147.

use std::f64::consts::PI;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use surround::Span;

use crate::candidate::Candidate;
use crate::data_set::DataSet;
use crate::thresholds::belief::Thresholds;

/// The caused part of what the effects of a candidate leave; none where it has no effect, or no record is long enough.
pub(crate) fn left_by(candidate: &Candidate, data: &DataSet, sigma: f64) -> Option<f64> {
    if candidate.picks.is_empty() { None } else { left(data, &candidate.judged.residual, sigma) }
}

/// The caused part, in powers of the noise; 0 where none is seen, none where no record is long enough.
/// `residual` is in standard deviations of the noise, which is `sigma` in SI.
fn left(data: &DataSet, residual: &[f64], sigma: f64) -> Option<f64> {
    let reading: Vec<f64> = data.y.iter().zip(residual).map(|(y, r)| y - sigma * r).collect();
    let signals = Signals { data, span: Span::of(reading.iter().copied()), reading: &reading };
    let zero = || Normal {
        matrix: DMatrix::zeros(FUNCTIONS, FUNCTIONS),
        right: DVector::zeros(FUNCTIONS),
    };
    let mut all = zero();
    let mut folds = [(); Thresholds::CAUSED_FOLDS].map(|()| zero());
    signals.for_each_block(residual, |k, _, functions, own| {
        folds[k % Thresholds::CAUSED_FOLDS]
            .add(&functions.tr_mul(functions), &functions.tr_mul(own));
    });
    folds.iter().for_each(|fold| all.add(&fold.matrix, &fold.right));
    let without: Vec<Option<DVector<f64>>> =
        folds.into_iter().map(|fold| all.solve_without(fold)).collect();
    let (mut gained, mut rows) = ([0.0; 2], [0.0; 2]);
    signals.for_each_block(residual, |k, block, functions, own| {
        let Some(others) = &without[k % Thresholds::CAUSED_FOLDS] else { return };
        let rest = own - functions * others;
        let is_held_out = !data.records.iter().any(|r| r.training.contains(&block.start));
        let count = block.len() as f64;
        // A block that is unlike all others is not predicted, which says nothing of those.
        gained[usize::from(is_held_out)] +=
            (own.norm_squared() - rest.norm_squared()).max(-Thresholds::CAUSED_LOST * count);
        rows[usize::from(is_held_out)] += count;
    });
    let parts = gained.iter().zip(rows).filter(|(_, rows)| *rows > 0.0);
    let parts: Vec<f64> = parts.map(|(gained, rows)| gained / rows).collect();
    (!parts.is_empty()).then(|| (parts.iter().sum::<f64>() / parts.len() as f64).max(0.0))
}

/// Normal equations of some blocks.
struct Normal {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
}

impl Normal {
    fn add(&mut self, matrix: &DMatrix<f64>, right: &DVector<f64>) {
        self.matrix += matrix;
        self.right += right;
    }

    /// The coefficients by all blocks but these.
    fn solve_without(&self, fold: Normal) -> Option<DVector<f64>> {
        let mut matrix = &self.matrix - fold.matrix;
        for k in 0..FUNCTIONS {
            // A function that never moves has no coefficient.
            matrix[(k, k)] += Thresholds::CAUSED_RIDGE * self.matrix[(k, k)] + f64::MIN_POSITIVE;
        }
        matrix.cholesky().map(|factor| factor.solve(&(&self.right - fold.right)))
    }
}

/// What the functions are made of.
struct Signals<'a> {
    data: &'a DataSet,
    /// Simulated reading of each row in SI.
    reading: &'a [f64],
    span: Span,
}

impl Signals<'_> {
    /// Number, rows, functions and residual of each block of each record that has rows enough.
    fn for_each_block(
        &self,
        residual: &[f64],
        mut with: impl FnMut(usize, Range<usize>, &DMatrix<f64>, &DVector<f64>),
    ) {
        let records = self.data.records.iter().map(|r| r.rows.clone());
        for rows in records.filter(|r| r.len() >= Thresholds::CAUSED_ROWS) {
            let mut functions = Functions::new();
            for (k, block) in blocks(&rows).enumerate() {
                let mut values = DMatrix::zeros(FUNCTIONS, block.len());
                for (row, mut column) in block.clone().zip(values.column_iter_mut()) {
                    let command = self.data.command[self.data.row_hit[row] as usize];
                    let (u, y) =
                        (self.data.command_span.unit(command), self.span.unit(self.reading[row]));
                    functions.next(u, y, column.as_mut_slice());
                }
                let mut values = values.transpose();
                values.column_iter_mut().for_each(|mut c| straighten(c.as_mut_slice()));
                let mut own = DVector::from_column_slice(&residual[block.clone()]);
                straighten(own.as_mut_slice());
                with(k, block, &values, &own);
            }
        }
    }
}

/// Blocks of a record.
fn blocks(rows: &Range<usize>) -> impl Iterator<Item = Range<usize>> + use<> {
    let (start, count) = (rows.start, rows.len());
    let number = (count / Thresholds::CAUSED_LONGEST).max(Thresholds::CAUSED_BLOCKS);
    let at = move |k: usize| start + k * count / number;
    (0..number).map(move |k| at(k)..at(k + 1))
}

/// Takes the straight line of least squares out of values.
fn straighten(values: &mut [f64]) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let centre = 0.5 * (n - 1.0);
    let moment: f64 = values.iter().enumerate().map(|(k, v)| (k as f64 - centre) * v).sum();
    let slope = moment / (n * (n * n - 1.0) / 12.0).max(1.0);
    values.iter_mut().enumerate().for_each(|(k, v)| *v -= mean + slope * (k as f64 - centre));
}

/// The two signals with their steps, sizes of steps and low-passes; two values of each band; triangles over both, and by direction.
const FUNCTIONS: usize = 2 * (3 + Thresholds::CAUSED_LOW_PASSES)
    + 2 * Thresholds::CAUSED_BANDS
    + 3 * Thresholds::CAUSED_TRIANGLES;

/// The functions, from the start of a record.
struct Functions {
    /// Time constant of each low-pass in rows, plus 1.
    lags: [f64; Thresholds::CAUSED_LOW_PASSES],
    /// Factors of the input and of the last two values of each band.
    poles: [[f64; 3]; Thresholds::CAUSED_BANDS],
    /// Command and reading of the row before.
    last: Option<[f64; 2]>,
    lows: [[f64; Thresholds::CAUSED_LOW_PASSES]; 2],
    /// Values of each band, of the last two rows.
    bands: [[f64; 2]; Thresholds::CAUSED_BANDS],
    direction: f64,
}

impl Functions {
    fn new() -> Self {
        // Two poles of quality 6, from near Nyquist's frequency down.
        let poles = std::array::from_fn(|k| {
            let angle = 0.9 * PI * 1.5f64.powi(-(k as i32));
            let pole = (-angle / 12.0).exp();
            [1.0 - pole, 2.0 * pole * angle.cos(), pole * pole]
        });
        Self {
            // Time constants of 1, 3, 9 … rows.
            lags: std::array::from_fn(|k| 1.0 + 3.0f64.powi(k as i32)),
            poles,
            last: None,
            lows: [[0.0; Thresholds::CAUSED_LOW_PASSES]; 2],
            bands: [[0.0; 2]; Thresholds::CAUSED_BANDS],
            direction: 0.0,
        }
    }

    /// The functions of the next row.
    fn next(&mut self, u: f64, y: f64, into: &mut [f64]) {
        let last = self.last.unwrap_or([u, y]);
        if self.last.is_none() {
            self.lows = [[u; Thresholds::CAUSED_LOW_PASSES], [y; Thresholds::CAUSED_LOW_PASSES]];
        }
        self.last = Some([u, y]);
        let mut into = into.iter_mut();
        let mut push = |value: f64| *into.next().expect("one place for each function") = value;
        for ((x, before), lows) in [u, y].into_iter().zip(last).zip(&mut self.lows) {
            [x, x - before, (x - before).abs()].into_iter().for_each(&mut push);
            for (low, lag) in lows.iter_mut().zip(&self.lags) {
                *low += (x - *low) / lag;
                push(*low);
            }
        }
        for (band, [of_input, of_one, of_two]) in self.bands.iter_mut().zip(&self.poles) {
            let [one, two] = *band;
            let now = of_input * y + of_one * one - of_two * two;
            *band = [now, one];
            [now, one].into_iter().for_each(&mut push);
        }
        if y != last[1] {
            self.direction = (y - last[1]).signum();
        }
        for k in 0..Thresholds::CAUSED_TRIANGLES {
            let width = 2.0 / (Thresholds::CAUSED_TRIANGLES - 1) as f64;
            let over = (1.0 - (y + 1.0 - k as f64 * width).abs() / width).max(0.0);
            let of_command = (1.0 - (u + 1.0 - k as f64 * width).abs() / width).max(0.0);
            [over, self.direction * over, of_command].into_iter().for_each(&mut push);
        }
    }
}

#[cfg(test)]
mod tests {
    use numerics::random::SplitMix64;

    use super::*;
    use crate::data_set::RecordRows;

    const SEED: u64 = 5;
    const ROWS: usize = 4000;

    /// Nearly normal, of variance 1.
    fn noise(random: &mut SplitMix64) -> f64 {
        (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0
    }

    /// What is found in noise of 1 and what this makes of the command and the row, beside the power of that.
    fn left_of(mut cause: impl FnMut(f64, usize) -> f64) -> (f64, f64) {
        let mut random = SplitMix64::new(SEED);
        let (mut residual, mut power) = (Vec::new(), 0.0);
        let records = (0..3).map(|record| {
            let rate = 0.01 * (1.0 + 2.0 * record as f64);
            let u: Vec<f64> = (0..ROWS)
                .map(|k| (rate * k as f64).sin() + 0.5 * (2.3 * rate * k as f64).cos())
                .collect();
            for (k, u) in u.iter().enumerate() {
                let caused = cause(*u, k);
                power += caused * caused / (3 * ROWS) as f64;
                residual.push(caused + noise(&mut random));
            }
            let y = u.iter().zip(&residual[record * ROWS..]).map(|(u, r)| u + 0.01 * r).collect();
            RecordRows { name: record.to_string(), y, command: u, ..RecordRows::still(ROWS, 0.7) }
        });
        let data = DataSet::new(records.collect(), &[], None);
        (left(&data, &residual, 0.01).unwrap(), power)
    }

    #[test]
    fn noise_and_walks_are_not_caused_and_what_the_command_causes_is() {
        let (found, _) = left_of(|_, _| 0.0);
        assert!(found < 0.01, "{found} of noise, seed {SEED}");
        let mut random = SplitMix64::new(SEED + 1);
        let mut at = 0.0;
        let walk = |_: f64, k: usize| {
            at = if k == 0 { 0.0 } else { at + 0.05 * noise(&mut random) };
            at
        };
        let (found, power) = left_of(walk);
        assert!(found < 0.05 * power, "{found} of a walk of {power}, seed {SEED}");
        let limit = |u: f64, _: usize| (u.abs() - 1.0).max(0.0) * 4.0;
        let (found, power) = left_of(limit);
        assert!(found > 0.6 * power, "{found} of a limit of {power}, seed {SEED}");
        let mut ring = [0.0; 2];
        let mode = |u: f64, k: usize| {
            if k == 0 {
                ring = [0.0; 2];
            }
            let now = 0.05 * u + 1.9 * ring[0] - 0.95 * ring[1];
            ring = [now, ring[0]];
            20.0 * (now - u)
        };
        let (found, power) = left_of(mode);
        assert!(found > 0.6 * power, "{found} of a mode of {power}, seed {SEED}");
    }
}

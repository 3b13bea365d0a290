//! Weights of the plays for given linear parts: non-negative least squares with one free offset per
//! record.
//!
//! minimise Σ_records Σ_rows (y − offset − Σ w_i P_i)² with w_1 ≥ least slope and w_i ≥ 0. The
//! offsets are eliminated by taking the mean of each record's rows from both sides, which is exact.

use crate::error::Error;
use crate::record::{Record, Rows};

use super::least_squares::{Partner, Reduced, Solution};
use super::response::{LinearPart, responses};

/// What is fitted on: everything but the linear parts.
#[derive(Clone, Debug)]
pub(crate) struct Task<'a> {
    /// The records.
    pub(crate) records: &'a [Record],
    /// The rows of each that are fitted on.
    pub(crate) rows: Vec<Rows>,
    /// Sample time in s, of which each record's is a multiple.
    pub(crate) period: f64,
    /// Internal steps per sample.
    pub(crate) substeps: usize,
    /// Thresholds in the command's unit.
    pub(crate) thresholds: Vec<f64>,
    /// Least weight of the first play, in position per command.
    pub(crate) least_slope: f64,
}

/// The best weights for given linear parts.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    /// The linear parts.
    pub(crate) linear: LinearPart,
    /// Weights in position per command.
    pub(crate) weights: Vec<f64>,
    /// Offset of each record in the position's unit.
    pub(crate) offsets: Vec<f64>,
    /// Output less model on the rows fitted on, record after record.
    pub(crate) residual: Vec<f64>,
    /// The fitted's sum of squares.
    pub(crate) sum_of_squares: f64,
    /// Sum of squares of the outputs less their means.
    pub(crate) energy: f64,
    /// Variance of each weight that is not at its bound, for residuals of unit variance.
    pub(crate) variance: Vec<Option<f64>>,
    /// For each such weight, the other one it is correlated with most.
    pub(crate) partner: Vec<Option<Partner>>,
}

impl Task<'_> {
    /// Number of rows that are fitted on.
    pub(crate) fn row_count(&self) -> usize {
        self.rows.iter().map(Rows::len).sum()
    }

    /// The best weights for these linear parts.
    ///
    /// # Errors
    /// [`Error::NoSolution`] and [`Error::Model`].
    pub(crate) fn solve(&self, linear: LinearPart) -> Result<Fitted, Error> {
        let mut columns = Vec::with_capacity(self.records.len());
        for record in self.records {
            let input = record.input();
            let periods = record.periods(self.period);
            columns.push(responses(
                record.rest(),
                input,
                self.period * periods as f64,
                self.substeps * periods,
                &self.thresholds,
                &linear,
            )?);
        }
        let solution = self.reduce(&columns).solve_non_negative()?;
        Ok(self.finish(linear, &columns, solution))
    }

    fn reduce(&self, columns: &[Vec<Vec<f64>>]) -> Reduced {
        let mut reduced = Reduced::new(self.thresholds.len());
        for ((record, rows), columns) in self.records.iter().zip(&self.rows).zip(columns) {
            let means: Vec<f64> = columns.iter().map(|c| mean(rows.of(c))).collect();
            let output = rows.of(record.output());
            let output_mean = mean(output);
            for (at, y) in (rows.first..rows.end).zip(output) {
                let centred = columns.iter().zip(&means).map(|(c, mean)| c[at] - mean);
                let first =
                    columns.first().zip(means.first()).map_or(0.0, |(c, mean)| c[at] - mean);
                // The first weight is the least slope plus an unknown that is not negative.
                let target = y - output_mean - self.least_slope * first;
                reduced.push(centred.chain([target]));
            }
        }
        reduced
    }

    fn finish(&self, linear: LinearPart, columns: &[Vec<Vec<f64>>], solution: Solution) -> Fitted {
        let mut weights = solution.x;
        if let Some(first) = weights.first_mut() {
            *first += self.least_slope;
        }
        let mut residual = Vec::with_capacity(self.row_count());
        let mut offsets = Vec::with_capacity(self.records.len());
        let mut energy = 0.0;
        for ((record, rows), columns) in self.records.iter().zip(&self.rows).zip(columns) {
            let model =
                |at: usize| columns.iter().zip(&weights).map(|(c, w)| c[at] * w).sum::<f64>();
            let start = residual.len();
            let level = mean(rows.of(record.output()));
            energy += rows.of(record.output()).iter().map(|y| (y - level).powi(2)).sum::<f64>();
            let output = (rows.first..rows.end).zip(rows.of(record.output()));
            residual.extend(output.map(|(at, y)| y - model(at)));
            let offset = mean(&residual[start..]);
            residual[start..].iter_mut().for_each(|e| *e -= offset);
            offsets.push(offset);
        }
        let sum_of_squares = residual.iter().map(|e| e * e).sum();
        let (variance, partner) = (solution.variance, solution.partner);
        Fitted { linear, weights, offsets, residual, sum_of_squares, energy, variance, partner }
    }
}

/// Longest correlation that is looked for, in samples.
const LONGEST_CORRELATION: usize = 4096;

/// Mean of the values; 0 for none.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// How many independent residuals a correlated residual of this many samples is worth:
/// N / (1 + 2 Σ ρ_k), the sum running up to the first autocorrelation that is not positive.
///
/// Source: C. J. Geyer, Statistical Science 7 (1992) 473–483 (initial positive sequence).
pub(crate) fn independent_samples(residual: &[f64]) -> f64 {
    let count = residual.len();
    let power: f64 = residual.iter().map(|e| e * e).sum();
    if count < 2 || power == 0.0 {
        return count as f64;
    }
    let mut sum = 1.0;
    for lag in 1..(count / 2).min(LONGEST_CORRELATION) {
        let product: f64 = residual.iter().zip(&residual[lag..]).map(|(a, b)| a * b).sum();
        if product <= 0.0 {
            break;
        }
        sum += 2.0 * product / power;
    }
    (count as f64 / sum).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn independent_samples_of_white_and_of_correlated_noise() {
        let mut random = Random::new(7);
        let white: Vec<f64> = (0..20_000).map(|_| random.normal()).collect();
        assert!(independent_samples(&white) > 0.9 * 20_000.0);
        // First-order noise with ρ = 0.9 is worth N (1−ρ)/(1+ρ).
        let mut state = 0.0;
        let slow: Vec<f64> = white
            .iter()
            .map(|e| {
                state = 0.9 * state + e;
                state
            })
            .collect();
        let expected = 20_000.0 * 0.1 / 1.9;
        let found = independent_samples(&slow);
        assert!((found / expected - 1.0).abs() < 0.3, "seed 7: {found}, expected {expected}");
    }
}

//! The re-tune of a baseline under tolerance: what a gap must survive to be one.

use crate::baseline::Baseline;
use crate::machine::{Drive, Machine};

/// Standard deviations at which a parameter stops.
const LIMIT: f64 = 3.0;
/// Linearisations.
const ITERATIONS: usize = 8;
/// Relative step of the finite differences.
const STEP: f64 = 1e-3;

/// A model after its re-tune.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuned {
    /// With the values that fit best.
    pub model: Baseline,
    /// Root mean square of what is left, in µm.
    pub rms: f64,
}

/// Re-tunes a model to readings: Gauss–Newton steps on `Σ r²/σ² + Σ ((θ − 1)/tolerance)²`, θ the
/// factors of the parameters, within ±3 tolerances.
pub struct Tuner<'a> {
    model: &'a Baseline,
    drives: &'a [Drive],
    period: f64,
    sigma: f64,
    deviations: Vec<f64>,
    /// Sensitivities at the model's own values, which most re-tunes begin with.
    first: Linear,
}

/// Readings and their sensitivities to the factors.
#[derive(Clone)]
struct Linear {
    output: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl<'a> Tuner<'a> {
    /// A tuner of a model on these records, for noise of the standard deviation `sigma` in µm.
    #[must_use]
    pub fn new(model: &'a Baseline, drives: &'a [Drive], period: f64, sigma: f64) -> Self {
        let deviations = model.deviations();
        let mut tuner = Self {
            model,
            drives,
            period,
            sigma,
            deviations,
            first: Linear { output: Vec::new(), columns: Vec::new() },
        };
        tuner.first = tuner.linear(&vec![1.0; tuner.deviations.len()]);
        tuner
    }

    /// Readings of the model with these factors, all records in a row.
    fn output(&self, factors: &[f64]) -> Vec<f64> {
        let machine = Machine::plain(&self.model.scaled(factors), self.period);
        self.drives.iter().flat_map(|drive| machine.run(drive)).collect()
    }

    fn linear(&self, factors: &[f64]) -> Linear {
        let output = self.output(factors);
        let columns = (0..factors.len())
            .map(|i| {
                let mut moved = factors.to_vec();
                moved[i] += STEP;
                let mut column = self.output(&moved);
                column.iter_mut().zip(&output).for_each(|(c, o)| *c = (*c - o) / STEP);
                column
            })
            .collect();
        Linear { output, columns }
    }

    /// Fits the model to readings, all records in a row.
    #[must_use]
    pub fn tune(&self, readings: &[f64]) -> Tuned {
        let mut factors = vec![1.0; self.deviations.len()];
        let mut linear = self.first.clone();
        let mut cost = self.cost(&factors, &linear.output, readings);
        for iteration in 0..ITERATIONS {
            if iteration > 0 {
                linear = self.linear(&factors);
            }
            let target = self.step(&factors, &linear, readings);
            let Some((better, new_cost)) = self.line_search(&factors, &target, cost, readings)
            else {
                break;
            };
            let is_done = new_cost > 0.995 * cost;
            (factors, cost) = (better, new_cost);
            if is_done {
                break;
            }
        }
        let output = self.output(&factors);
        Tuned { model: self.model.scaled(&factors), rms: rms(&output, readings) }
    }

    fn line_search(
        &self,
        from: &[f64],
        to: &[f64],
        cost: f64,
        readings: &[f64],
    ) -> Option<(Vec<f64>, f64)> {
        [1.0, 0.5, 0.2].into_iter().find_map(|part| {
            let trial: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + part * (b - a)).collect();
            let new = self.cost(&trial, &self.output(&trial), readings);
            (new < cost).then_some((trial, new))
        })
    }

    fn cost(&self, factors: &[f64], output: &[f64], readings: &[f64]) -> f64 {
        let prior = factors.iter().zip(&self.deviations).map(|(f, d)| ((f - 1.0) / d).powi(2));
        let fit = output.iter().zip(readings).map(|(o, y)| ((y - o) / self.sigma).powi(2));
        fit.sum::<f64>() + prior.sum::<f64>()
    }

    /// The best factors of the linearised problem within their limits: those that leave them are
    /// fixed there, and the rest is solved again.
    fn step(&self, factors: &[f64], linear: &Linear, readings: &[f64]) -> Vec<f64> {
        let n = factors.len();
        let weight = self.sigma.powi(-2);
        let residual: Vec<f64> = readings.iter().zip(&linear.output).map(|(y, o)| y - o).collect();
        // Around the present factors, in units of the tolerance.
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() * weight;
        let d = &self.deviations;
        let mut matrix = vec![vec![0.0; n]; n];
        let mut right = vec![0.0; n];
        for i in 0..n {
            let offset = (factors[i] - 1.0) / d[i];
            right[i] = d[i] * dot(&linear.columns[i], &residual) - offset;
            for j in 0..=i {
                let value = d[i] * d[j] * dot(&linear.columns[i], &linear.columns[j]);
                matrix[i][j] = value;
                matrix[j][i] = value;
            }
            matrix[i][i] += 1.0;
        }
        let low: Vec<f64> = (0..n).map(|i| -LIMIT - (factors[i] - 1.0) / d[i]).collect();
        let step = bounded(&matrix, &right, &low, 2.0 * LIMIT);
        (0..n).map(|i| factors[i] + d[i] * step[i]).collect()
    }
}

/// Least squares by normal equations within `low ≤ x ≤ low + width`.
fn bounded(matrix: &[Vec<f64>], right: &[f64], low: &[f64], width: f64) -> Vec<f64> {
    let n = right.len();
    let mut fixed: Vec<Option<f64>> = vec![None; n];
    for _ in 0..=n {
        let x = solve_free(matrix, right, &fixed);
        // The one that is furthest outside is fixed; the others may come back by themselves.
        let worst = (0..n)
            .filter(|i| fixed[*i].is_none())
            .map(|i| (i, x[i].clamp(low[i], low[i] + width)))
            .filter(|(i, clamped)| clamped != &x[*i])
            .max_by(|(i, a), (j, b)| (a - x[*i]).abs().total_cmp(&(b - x[*j]).abs()));
        let Some((i, value)) = worst else { return x };
        fixed[i] = Some(value);
    }
    fixed.into_iter().map(Option::unwrap_or_default).collect()
}

/// Solves for the free unknowns by Gauss and Jordan with pivots.
fn solve_free(matrix: &[Vec<f64>], right: &[f64], fixed: &[Option<f64>]) -> Vec<f64> {
    let free: Vec<usize> = (0..right.len()).filter(|i| fixed[*i].is_none()).collect();
    let mut rows: Vec<Vec<f64>> = free
        .iter()
        .map(|&i| {
            let known: f64 =
                fixed.iter().enumerate().filter_map(|(j, x)| x.map(|x| matrix[i][j] * x)).sum();
            let mut row: Vec<f64> = free.iter().map(|&j| matrix[i][j]).collect();
            row.push(right[i] - known);
            row
        })
        .collect();
    let n = rows.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs()));
        rows.swap(k, pivot.unwrap_or(k));
        let base = rows[k].clone();
        for (i, row) in rows.iter_mut().enumerate() {
            if i != k && base[k] != 0.0 {
                let factor = row[k] / base[k];
                row.iter_mut().zip(&base).for_each(|(x, b)| *x -= factor * b);
            }
        }
    }
    let mut x: Vec<f64> = fixed.iter().map(|f| f.unwrap_or_default()).collect();
    for (k, &i) in free.iter().enumerate() {
        x[i] = if rows[k][k] == 0.0 { 0.0 } else { rows[k][n] / rows[k][k] };
    }
    x
}

/// Root mean square of the difference of two signals.
#[must_use]
pub fn rms(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
    (squares.sum::<f64>() / a.len().max(1) as f64).sqrt()
}

/// Root mean square difference with its mean taken out.
#[must_use]
pub(crate) fn spread(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().max(1) as f64;
    let mean = a.iter().zip(b).map(|(a, b)| a - b).sum::<f64>() / n;
    (rms(a, b).powi(2) - mean * mean).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::records::Kind;

    const H: f64 = 2.5e-4;

    fn drives() -> Vec<Drive> {
        let command = |kind: Kind| kind.command(4000, H, 1.0, &mut Random::new(3, &[]));
        [Kind::Multisine, Kind::FallingTriangle, Kind::Staircase]
            .iter()
            .map(|kind| Drive { command: command(*kind), neighbour: vec![0.0; 4000], record: 0 })
            .collect()
    }

    fn readings(machine: &Baseline) -> Vec<f64> {
        drives().iter().flat_map(|drive| Machine::plain(machine, H).run(drive)).collect()
    }

    #[test]
    fn a_machine_within_tolerance_leaves_nothing() {
        for seed in 0..6 {
            let mut random = Random::new(seed, &[]);
            let model = Baseline::draw(&mut random);
            let y = readings(&model.off(&mut random));
            let drives = drives();
            let sigma = 0.01;
            let before = rms(&readings(&model), &y);
            let tuned = Tuner::new(&model, &drives, H, sigma).tune(&y);
            assert!(before > 2.0 * sigma && tuned.rms < 0.15 * sigma, "{before} {}", tuned.rms);
        }
    }

    #[test]
    fn limits_hold() {
        let model = Baseline::draw(&mut Random::new(1, &[]));
        let machine = Baseline { frequency: 1.06 * model.frequency, ..model.clone() };
        let drives = drives();
        let tuned = Tuner::new(&model, &drives, H, 0.01).tune(&readings(&machine));
        let shift = tuned.model.frequency / model.frequency - 1.0;
        assert!((shift - 0.03).abs() < 1e-6, "{shift}");
        assert!(tuned.rms > 0.01);
    }

    #[test]
    fn bounded_least_squares_are_those_of_the_corner() {
        // Minimum of (x − 2)² + (x + y)² with |x| ≤ 1, |y| ≤ 1: x = 1, y = −1.
        let matrix = [vec![2.0, 1.0], vec![1.0, 1.0]];
        assert_eq!(bounded(&matrix, &[2.0, 0.0], &[-1.0, -1.0], 2.0), [1.0, -1.0]);
        let free = bounded(&matrix, &[2.0, 0.0], &[-9.0, -9.0], 18.0);
        assert!((free[0] - 2.0).abs() < 1e-12 && (free[1] + 2.0).abs() < 1e-12);
    }
}

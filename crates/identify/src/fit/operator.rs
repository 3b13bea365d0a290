//! Any method's fit: linear parts and shape searched, weights the best ones for each (variable
//! projection).
//!
//! Where a method puts a static map S behind everything, the map is undone on the measured positions
//! and each row is weighted with the slope of S there, which makes the residual that of the output to
//! first order.
//!
//! Source: G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413–432.

use std::cell::RefCell;

use numerics::least_squares::{Partner, Reduced};
use numerics::levenberg_marquardt::{self, Ending, Minimum, Unknown};

use crate::error::Error;
use crate::methods::{FitContext, Method, Shape};
use crate::observer::Observer;
use crate::record::{Record, Rows};

use super::centred::Centred;
use super::coordinates::{Coordinates, Deviations, Structure, visible};
use super::residual::{independent_samples, mean};
use super::response::{LinearPart, Part, after_hysteresis, before_hysteresis};
use super::swarm::{self, Swarm};

/// The search ends where the sum of squares falls by less than a thousandth of a percent.
const ENDING: Ending = Ending { iterations: 150, tolerance: 1e-7 };
/// The search descends from this many of a method's starts, the best ones.
const STARTS: usize = 2;

/// What is fitted on.
#[derive(Clone, Copy)]
pub(crate) struct Operator<'a> {
    pub(crate) method: &'static dyn Method,
    pub(crate) scene: &'a FitContext,
    pub(crate) records: &'a [Record],
    pub(crate) rows: &'a [Rows],
    pub(crate) period: f64,
    pub(crate) substeps: usize,
}

/// The best weights for linear parts and a shape.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    pub(crate) linear: LinearPart,
    pub(crate) shape: Vec<f64>,
    pub(crate) weights: Vec<f64>,
    /// Offset of each record in the position's unit.
    pub(crate) offsets: Vec<f64>,
    /// Residual of all records, then of the penalty.
    residual: Vec<f64>,
    penalties: usize,
    pub(crate) variance: Vec<Option<f64>>,
    pub(crate) partner: Vec<Option<Partner>>,
}

impl Solved {
    /// One number for all records: the mean of their offsets.
    pub(crate) fn offset(&self) -> f64 {
        mean(&self.offsets)
    }

    /// Residual on the rows fitted on, record after record.
    pub(crate) fn residual(&self) -> &[f64] {
        &self.residual[..self.residual.len() - self.penalties]
    }

    /// Sum of squares of residual and penalty.
    pub(crate) fn cost(&self) -> f64 {
        self.residual.iter().map(|e| e * e).sum()
    }
}

/// A fit with what is known of its parameters.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub(crate) solved: Solved,
    pub(crate) deviations: Deviations,
    /// Standard deviation of each parameter of the shape; `None` at a bound or without effect.
    pub(crate) shape_deviation: Vec<Option<f64>>,
    /// The shape's partner of greatest correlation, by index into the shape.
    pub(crate) shape_partner: Vec<Option<Partner>>,
}

impl Fit {
    /// The fit of a method without a shape.
    pub(crate) fn of(solved: Solved, deviations: Deviations) -> Self {
        Self { solved, deviations, shape_deviation: Vec::new(), shape_partner: Vec::new() }
    }
}

/// How the shape is searched.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Search {
    /// Levenberg–Marquardt from the method's own starts.
    #[default]
    LevenbergMarquardt,
    /// Particle swarm, as the papers do, then Levenberg–Marquardt for the deviations only.
    ParticleSwarm(Swarm),
}

impl Operator<'_> {
    /// The best weights for these linear parts and this shape.
    ///
    /// # Errors
    /// [`Error::NoSolution`] and [`Error::Model`].
    pub(crate) fn solve(&self, linear: LinearPart, shape: &[f64]) -> Result<Solved, Error> {
        let weights = self.method.weights(self.scene);
        let least = self.method.least(self.scene);
        let mut reduced = Reduced::new(weights.names.len());
        let mut parts = Vec::with_capacity(self.records.len());
        let mut count = 0;
        for (record, rows) in self.records.iter().zip(self.rows) {
            let columns = self.columns(record, record.rest(), *rows, &linear, shape)?;
            let part =
                Centred::new(self.method, (self.scene, shape), columns, rows.of(record.output()));
            count += rows.len();
            for k in 0..rows.len() {
                reduced.push(part.row(k, least));
            }
            parts.push(part);
        }
        let scale = (count as f64).sqrt();
        let penalty = self.method.penalty(self.scene);
        for row in &penalty {
            reduced.push(row.iter().map(|v| v * scale).chain([0.0]));
        }
        let solution = reduced.solve(weights.free)?;
        let mut weights = solution.x;
        if let Some(first) = weights.first_mut() {
            *first += least;
        }
        let mut residual = Vec::with_capacity(count + penalty.len());
        let offsets = parts.iter().map(|part| part.leave(&weights, least, &mut residual)).collect();
        let product = |row: &Vec<f64>| row.iter().zip(&weights).map(|(a, x)| a * x).sum::<f64>();
        residual.extend(penalty.iter().map(|row| scale * product(row)));
        Ok(Solved {
            linear,
            shape: shape.to_vec(),
            weights,
            offsets,
            residual,
            penalties: penalty.len(),
            variance: solution.variance,
            partner: solution.partner,
        })
    }

    /// Sum of squares of the positions fitted on less each record's mean.
    pub(crate) fn energy(&self) -> f64 {
        let of = |(record, rows): (&Record, &Rows)| {
            let output = rows.of(record.output());
            let level = mean(output);
            output.iter().map(|y| (y - level).powi(2)).sum::<f64>()
        };
        self.records.iter().zip(self.rows).map(of).sum()
    }

    /// The position at these rows of a record whose machine rested under this command, less the offset.
    ///
    /// # Errors
    /// [`Error::Model`].
    pub(crate) fn position(
        &self,
        solved: &Solved,
        record: &Record,
        rest: f64,
        rows: Rows,
    ) -> Result<Vec<f64>, Error> {
        let columns = self.columns(record, rest, rows, &solved.linear, &solved.shape)?;
        let at = |k: usize| columns.iter().zip(&solved.weights).map(|(c, w)| c[k] * w).sum();
        Ok((0..rows.len()).map(at).collect())
    }

    /// The columns at these rows of a record whose machine rested under this command: one per weight. Row k
    /// is read before its command acts.
    fn columns(
        &self,
        record: &Record,
        rest: f64,
        rows: Rows,
        linear: &LinearPart,
        shape: &[f64],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let step = self.period / self.substeps as f64;
        let mut before = before_hysteresis(linear, step)?;
        let mut bank = self.method.bank(self.scene, shape, step)?;
        let count = self.method.weights(self.scene).names.len();
        let mut after = Vec::with_capacity(count);
        for _ in 0..count {
            after.push(after_hysteresis(linear, step)?);
        }
        let mut row = vec![0.0; count];
        let mut columns = vec![Vec::with_capacity(rows.len()); count];
        // What is behind the last of the rows does not matter.
        let end = rows.end.min(record.len());
        let Some((_, held)) = record.input()[..end].split_last() else { return Ok(columns) };
        bank(before.iter_mut().fold(rest, |signal, part| part.rest(signal)), &mut row);
        for (value, after) in row.iter_mut().zip(&mut after) {
            *value = after.as_mut().map_or(*value, |part| part.rest(*value));
        }
        let mut keep = |at: usize, row: &[f64]| {
            if at >= rows.first {
                columns.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
            }
        };
        keep(0, &row);
        for (k, &command) in held.iter().enumerate() {
            for _ in 0..self.substeps * record.periods(self.period) {
                let signal = before.iter_mut().fold(command, |signal, part| part.step(signal));
                bank(signal, &mut row);
                for (value, after) in row.iter_mut().zip(&mut after) {
                    *value = after.as_mut().map_or(*value, |part| part.step(*value));
                }
            }
            keep(k + 1, &row);
        }
        Ok(columns)
    }

    /// The fit from `known` on: the linear parts of the static model.
    ///
    /// # Errors
    /// [`Error::Stopped`], and those of [`Operator::solve`].
    pub(crate) fn fit(
        &self,
        known: LinearPart,
        longest_delay: f64,
        search: Search,
        observer: &mut dyn Observer,
    ) -> Result<Fit, Error> {
        let shapes = self.method.shape(self.scene);
        let coordinates = self.coordinates(&known, &shapes);
        let observer = RefCell::new(observer);
        let mut best: Option<(f64, Minimum)> = None;
        for start in self.starts(known, search, &coordinates, longest_delay, &observer)? {
            let found = self.descend(&start, search, &coordinates, longest_delay, &observer)?;
            if best.as_ref().is_none_or(|(least, _)| found.0 < *least) {
                best = Some(found);
            }
        }
        let (_, minimum) = best.ok_or(Error::no_solution("the method has no start"))?;
        let (linear, shape) = coordinates.split(&minimum.parameters);
        let solved = self.solve(linear, &shape)?;
        let noise = noise(&solved, minimum.parameters.len());
        let deviation: Vec<Option<f64>> =
            minimum.variance.iter().map(|v| v.map(|v| (v * noise).sqrt())).collect();
        let first = coordinates.first_shape();
        let scaled = deviation[first..].iter().zip(&coordinates.scale);
        let shape_deviation = scaled.map(|(d, scale)| d.map(|d| d * scale)).collect();
        let inside = |p: &Option<Partner>| p.filter(|p| p.0 >= first).map(|(i, c)| (i - first, c));
        Ok(Fit {
            deviations: coordinates.linear.deviations(&solved.linear, &deviation),
            shape_deviation,
            shape_partner: minimum.partner[first..].iter().map(inside).collect(),
            solved,
        })
    }

    fn coordinates(&self, known: &LinearPart, shapes: &[Shape]) -> Both {
        let structure = Structure { lag: known.bandwidth.is_some(), mode: known.mode.is_some() };
        Both {
            linear: Coordinates { structure, period: self.period },
            scale: shapes.iter().map(|s| s.upper - s.lower).collect(),
            shapes: shapes.to_vec(),
        }
    }

    /// Levenberg–Marquardt from one start; the cost at the minimum, and the minimum.
    fn descend(
        &self,
        start: &(LinearPart, Vec<f64>),
        search: Search,
        both: &Both,
        longest_delay: f64,
        observer: &RefCell<&mut dyn Observer>,
    ) -> Result<(f64, Minimum), Error> {
        let unknowns = both.unknowns(start, longest_delay, visible(self.records, self.rows));
        let length = self.solve(start.0, &start.1)?.residual.len();
        let residuals = |p: &[f64]| {
            if observer.borrow().stopped() {
                return Err(Error::Stopped);
            }
            let (linear, shape) = both.split(p);
            // A step to where there is no model is one that does not help.
            Ok(match self.solve(linear, &shape) {
                Ok(solved) => solved.residual,
                Err(_) => vec![f64::INFINITY; length],
            })
        };
        let ending = match search {
            Search::LevenbergMarquardt => ENDING,
            // One step at most: the swarm's answer is wanted, with deviations.
            Search::ParticleSwarm(_) => Ending { iterations: 1, tolerance: f64::INFINITY },
        };
        let report = |i| observer.borrow_mut().progress(self.method.name(), i, ending.iterations);
        let minimum = levenberg_marquardt::minimise(&unknowns, ending, residuals, report)?;
        let (linear, shape) = both.split(&minimum.parameters);
        Ok((self.solve(linear, &shape)?.cost(), minimum))
    }

    /// The best of the method's starts, or the swarm's answer.
    fn starts(
        &self,
        known: LinearPart,
        search: Search,
        both: &Both,
        longest_delay: f64,
        observer: &RefCell<&mut dyn Observer>,
    ) -> Result<Vec<(LinearPart, Vec<f64>)>, Error> {
        let mut ranked = Vec::new();
        for start in self.method.starts(self.scene) {
            ranked.push((self.solve(known, &start)?.cost(), start));
        }
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let best = ranked.into_iter().take(STARTS).map(|(_, start)| (known, start));
        let Search::ParticleSwarm(settings) = search else { return Ok(best.collect()) };
        let Some(start) = best.into_iter().next() else { return Ok(Vec::new()) };
        let unknowns = both.unknowns(&start, longest_delay, visible(self.records, self.rows));
        let cost = |p: &[f64]| {
            let (linear, shape) = both.split(p);
            self.solve(linear, &shape).map_or(f64::INFINITY, |solved| solved.cost())
        };
        let costs = |all: &[Vec<f64>]| swarm::side_by_side(all, settings.threads, cost);
        let (place, _) = swarm::minimise(&unknowns, &settings, costs, |round| {
            observer.borrow_mut().progress(self.method.name(), round, settings.iterations);
            observer.borrow().stopped()
        })?;
        Ok(vec![both.split(&place)])
    }
}

/// Variance of the residual over what one sample of it is worth.
pub(crate) fn noise(solved: &Solved, searched: usize) -> f64 {
    let unknowns = searched + solved.variance.iter().flatten().count();
    let residual = solved.residual();
    let sum: f64 = residual.iter().map(|e| e * e).sum();
    sum / (independent_samples(residual) - unknowns as f64).max(1.0)
}

/// The signal in front of the hysteresis: at rest, then after each internal step.
pub(crate) fn through(parts: &mut [Part], rest: f64, input: &[f64], substeps: usize) -> Vec<f64> {
    let Some((_, held)) = input.split_last() else { return Vec::new() };
    let mut signal = Vec::with_capacity(1 + held.len() * substeps);
    signal.push(parts.iter_mut().fold(rest, |signal, part| part.rest(signal)));
    for &command in held {
        for _ in 0..substeps {
            signal.push(parts.iter_mut().fold(command, |signal, part| part.step(signal)));
        }
    }
    signal
}

/// Coordinates of the linear parts, then the shape in parts of its range.
struct Both {
    linear: Coordinates,
    scale: Vec<f64>,
    shapes: Vec<Shape>,
}

impl Both {
    fn first_shape(&self) -> usize {
        1 + usize::from(self.linear.structure.lag) + 2 * usize::from(self.linear.structure.mode)
    }

    fn unknowns(
        &self,
        (linear, shape): &(LinearPart, Vec<f64>),
        longest_delay: f64,
        visible: (f64, f64),
    ) -> Vec<Unknown> {
        let mut all = self.linear.unknowns(linear, longest_delay, &visible);
        for ((value, s), scale) in shape.iter().zip(&self.shapes).zip(&self.scale) {
            let [start, lower, upper] = [*value, s.lower, s.upper].map(|v| v / scale);
            all.push(Unknown { start, lower, upper });
        }
        all
    }

    fn split(&self, p: &[f64]) -> (LinearPart, Vec<f64>) {
        let shape = p[self.first_shape()..].iter().zip(&self.scale).map(|(p, scale)| p * scale);
        (self.linear.linear(p), shape.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::STATIC;
    use crate::record::Columns;

    /// The columns of plays with these thresholds.
    fn columns(
        input: &[f64],
        substeps: usize,
        thresholds: &[f64],
        linear: LinearPart,
    ) -> Vec<Vec<f64>> {
        let time: Vec<f64> = (0..input.len()).map(|k| k as f64 * 0.1).collect();
        let (name, input_name, output_name) = ("a", "u", "y");
        let all = Columns { name, time: &time, input_name, input, output_name, output: input };
        let records = [Record::new(all).expect("a record")];
        let scene = FitContext {
            command: [0.0, 1.0],
            position: [0.0, 1.0],
            zero: 0.0,
            duration: 1.0,
            thresholds: thresholds.to_vec(),
            levels: 2,
            least_slope: 0.01,
        };
        let rows = [Rows { first: 0, end: input.len() }];
        let (method, scene, period) = (STATIC, &scene, 0.1);
        let operator = Operator { method, scene, records: &records, rows: &rows, period, substeps };
        operator.columns(&records[0], input[0], rows[0], &linear, &[]).expect("runs")
    }

    #[test]
    fn a_row_is_read_before_its_input_acts() {
        let ramp: Vec<f64> = (0..24).map(f64::from).collect();
        let columns = columns(&ramp, 1, &[0.0, 0.5], LinearPart::default());
        assert_eq!(columns[0][..4], [0.0, 0.0, 1.0, 2.0]);
        assert_eq!(columns[1][..4], [0.0, 0.0, 0.5, 1.5]);
    }

    #[test]
    fn at_rest_the_plays_are_on_the_virgin_curve() {
        assert_eq!(columns(&[2.0; 24], 4, &[0.5], LinearPart::default()), [[1.5; 24]]);
    }

    #[test]
    fn delay_shifts_and_substeps_do_not_change_a_static_model() {
        let input: Vec<f64> = (0..200).map(|k| (f64::from(k) * 0.37).sin()).collect();
        let linear = LinearPart { delay: 0.2, ..LinearPart::default() };
        let one = columns(&input, 1, &[0.0, 0.3], linear);
        assert_eq!(one, columns(&input, 4, &[0.0, 0.3], linear));
        assert_eq!(one[0][3..], input[..197]);
    }
}

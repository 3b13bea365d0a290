//! Any method's fit: linear parts and shape searched, weights the best ones for each (variable
//! projection).
//!
//! Where a method puts a static map S behind everything, the map is undone on the measured positions
//! and each row is weighted with the slope of S there, which makes the residual that of the output to
//! first order.
//!
//! Source: G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413–432.

use std::cell::RefCell;

use crate::error::Error;
use crate::methods::{Method, Scene, Shape};
use crate::observer::Observer;
use crate::record::{Record, Rows};

use super::least_squares::{Partner, Reduced};
use super::levenberg_marquardt::{self, Ending, Minimum, Unknown};
use super::linear_part::{Coordinates, Deviations, Structure, visible};
use super::response::{LinearPart, Part, after_hysteresis, before_hysteresis};
use super::swarm::{self, Swarm};
use super::weights::{independent_samples, mean};

/// The search ends where the sum of squares falls by less than a thousandth of a percent.
const ENDING: Ending = Ending { iterations: 150, tolerance: 1e-7 };
/// The search descends from this many of a method's starts, the best ones.
const STARTS: usize = 2;

/// What is fitted on.
#[derive(Clone)]
pub(crate) struct Operator<'a> {
    pub(crate) method: &'static dyn Method,
    pub(crate) scene: &'a Scene,
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
    /// One number for all records: the mean of their offsets.
    pub(crate) offset: f64,
    /// Residual of all records, then of the penalty.
    residual: Vec<f64>,
    penalties: usize,
    pub(crate) variance: Vec<Option<f64>>,
    pub(crate) partner: Vec<Option<Partner>>,
}

impl Solved {
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
        let mut reduced = Reduced::new(weights.names.len());
        let mut parts = Vec::with_capacity(self.records.len());
        let mut count = 0;
        for (record, rows) in self.records.iter().zip(self.rows) {
            let columns = self.columns(record, *rows, &linear, shape)?;
            let part = Centred::new(self, shape, columns, rows.of(record.output()));
            count += rows.len();
            for k in 0..rows.len() {
                reduced.push(part.row(k));
            }
            parts.push(part);
        }
        let scale = (count as f64).sqrt();
        let penalty = self.method.penalty(self.scene);
        for row in &penalty {
            reduced.push(row.iter().map(|v| v * scale).chain([0.0]));
        }
        let solution = reduced.solve(weights.free)?;
        let mut residual = Vec::with_capacity(count + penalty.len());
        for part in &parts {
            residual.extend((0..part.len()).map(|k| part.residual(k, &solution.x)));
        }
        let product = |row: &Vec<f64>| row.iter().zip(&solution.x).map(|(a, x)| a * x).sum::<f64>();
        residual.extend(penalty.iter().map(|row| scale * product(row)));
        let offsets: Vec<f64> = parts.iter().map(|part| part.offset(&solution.x)).collect();
        Ok(Solved {
            linear,
            shape: shape.to_vec(),
            weights: solution.x,
            offset: mean(&offsets),
            residual,
            penalties: penalty.len(),
            variance: solution.variance,
            partner: solution.partner,
        })
    }

    /// The columns at the rows fitted on.
    fn columns(
        &self,
        record: &Record,
        rows: Rows,
        linear: &LinearPart,
        shape: &[f64],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let step = self.period / self.substeps as f64;
        let mut before = before_hysteresis(linear, step)?;
        // What is behind the last row fitted on does not matter.
        let input = &record.input()[..rows.end.min(record.len())];
        let substeps = self.substeps * record.periods(self.period);
        let signal = through(&mut before, record.rest(), input, substeps);
        let mut columns = self.method.columns(self.scene, shape, &signal, step)?;
        for column in &mut columns {
            if let Some(mut mode) = after_hysteresis(linear, step)? {
                for (k, value) in column.iter_mut().enumerate() {
                    *value = if k == 0 { mode.rest(*value) } else { mode.step(*value) };
                }
            }
            let at = |row: usize| column[row * substeps];
            *column = (rows.first..rows.end).map(at).collect();
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

/// The rows of one record, the offset eliminated by taking the weighted mean from both sides.
struct Centred {
    columns: Vec<Vec<f64>>,
    means: Vec<f64>,
    target: Vec<f64>,
    target_mean: f64,
    slope: Vec<f64>,
}

impl Centred {
    fn new(operator: &Operator<'_>, shape: &[f64], columns: Vec<Vec<f64>>, output: &[f64]) -> Self {
        let unmapped = operator.method.unmapped(operator.scene, shape, output);
        let (target, slope) = match unmapped {
            Some(pairs) => pairs.into_iter().unzip(),
            None => (output.to_vec(), vec![1.0; output.len()]),
        };
        let total: f64 = slope.iter().map(|s: &f64| s * s).sum();
        let mean = |values: &[f64]| {
            if operator.method.anchored() {
                return 0.0;
            }
            values.iter().zip(&slope).map(|(v, s)| v * s * s).sum::<f64>() / total
        };
        let means = columns.iter().map(|c| mean(c)).collect();
        let target_mean = mean(&target);
        Self { means, target_mean, columns, target, slope }
    }

    fn len(&self) -> usize {
        self.target.len()
    }

    fn row(&self, k: usize) -> impl Iterator<Item = f64> + '_ {
        let slope = self.slope[k];
        let columns = self.columns.iter().zip(&self.means);
        columns
            .map(move |(c, mean)| slope * (c[k] - mean))
            .chain([slope * (self.target[k] - self.target_mean)])
    }

    fn residual(&self, k: usize, x: &[f64]) -> f64 {
        let columns = self.columns.iter().zip(&self.means).zip(x);
        let model: f64 = columns.map(|((c, mean), x)| (c[k] - mean) * x).sum();
        self.slope[k] * (self.target[k] - self.target_mean - model)
    }

    fn offset(&self, x: &[f64]) -> f64 {
        self.target_mean - self.means.iter().zip(x).map(|(mean, x)| mean * x).sum::<f64>()
    }
}

//! Fits a chain to the training rows: Levenberg-Marquardt under priors, in a box.
//!
//! The data count as `N_eff · ln(Σ r²)`: where the model is structurally wrong the residual is not
//! noise, and the priors of the model's own parameters must not be overruled by its size. N_eff is the
//! number of rows over the correlation length of residuals.

mod broyden;
mod first_order;

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use nalgebra::{DMatrix, DVector};
use numerics::levenberg_marquardt::damped_step;
use rayon::prelude::*;

use self::broyden::correct;
pub(crate) use self::first_order::Linear;
use crate::chain::{Bench, Chain, Horizon};
use crate::data_set::DataSet;
use crate::error::Failed;
use crate::normal::normal_equations;
use crate::nuisance::{Nuisance, Projector, relevant};
use crate::thresholds::fit::Thresholds;

/// What fits are made with.
#[derive(Clone, Copy)]
pub(crate) struct Fitter<'a> {
    pub(crate) data: &'a DataSet,
    /// Standard deviation of the noise.
    pub(crate) sigma: f64,
    /// Counts simulations.
    pub(crate) count: &'a AtomicU64,
    /// Factor of each row of the fit; none: all alike.
    pub(crate) weights: Option<&'a [f64]>,
}

/// A fitted chain.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    /// Coordinates of the parameters.
    pub(crate) theta: Vec<f64>,
    /// Mean square of the training residual over the noise's.
    pub(crate) mean_square: f64,
    /// Standard deviation of each coordinate; `None` where it is at its bound or not seen.
    pub(crate) deviations: Vec<Option<f64>>,
    /// Information about the coordinates: of the training rows, and the priors.
    pub(crate) information: DMatrix<f64>,
}

/// A point and the residual there.
struct Point {
    theta: Vec<f64>,
    residual: Vec<f64>,
    squares: f64,
    cost: f64,
}

/// One chain under way.
struct Work<'a> {
    bench: Bench<'a>,
    fitter: Fitter<'a>,
    projector: Option<(Vec<f64>, Arc<Projector>)>,
    /// Squares above which a fit is not worth sensitivities of its own.
    enough: f64,
}

impl<'a> Fitter<'a> {
    /// Effective number of training rows.
    pub(crate) fn effective(&self) -> f64 {
        let rows: usize = self.data.records.iter().map(|r| r.training.len()).sum();
        (rows as f64 / Thresholds::CORRELATED_ROWS)
            .clamp(Thresholds::LEAST_EFFECTIVE, Thresholds::MOST_EFFECTIVE)
    }

    fn work(self, chain: &'a Chain) -> Work<'a> {
        let bench = Bench::new(chain, self.data, Horizon::Training, self.count);
        Work { bench, fitter: self, projector: None, enough: f64::INFINITY }
    }

    /// Fits from these coordinates, with all sensitivities at each turn's own point in the end.
    ///
    /// # Errors
    /// [`Failed`]: the chain cannot be simulated there.
    pub(crate) fn fit(self, chain: &'a Chain, start: &[f64]) -> Result<Fit, Failed> {
        self.work(chain).fit(start, None, true)
    }

    /// Fits again from what was fitted to other rows or with other weights.
    ///
    /// # Errors
    /// [`Failed`]: the chain cannot be simulated there.
    pub(crate) fn fit_again(self, chain: &'a Chain, start: &[f64]) -> Result<Fit, Failed> {
        self.work(chain).fit(start, None, false)
    }

    /// Fits with all sensitivities at each turn's own point in the end. A chain with an FMU of many parameters begins with
    /// the sensitivities that are known from another chain, and does not get its own where it leaves far more than a mean
    /// square of `best`.
    ///
    /// # Errors
    /// [`Failed`]: the chain cannot be simulated there.
    pub(crate) fn fit_from(
        self,
        chain: &'a Chain,
        start: &[f64],
        (known, best): (&Linear, f64),
    ) -> Result<Fit, Failed> {
        let mut work = self.work(chain);
        if !chain.is_costly() {
            return work.fit(start, None, true);
        }
        work.enough = best * Thresholds::FAR * self.data.fit_rows.len() as f64;
        work.fit(start, Some(known), true)
    }

    /// Fits with the sensitivities that are known from another chain, which are not computed again: near enough to
    /// choose among candidates.
    ///
    /// # Errors
    /// [`Failed`]: the chain cannot be simulated there.
    pub(crate) fn fit_quickly(
        self,
        chain: &'a Chain,
        start: &[f64],
        known: &Linear,
    ) -> Result<Fit, Failed> {
        self.work(chain).fit(start, Some(known), false)
    }
}

impl<'a> Work<'a> {
    fn chain(&self) -> &'a Chain {
        self.bench.chain
    }

    /// What a simulation leaves at the rows of the fit in standard deviations, with the nuisances taken
    /// out: of the kept point, or of one beside it.
    fn left(&mut self, theta: &[f64], aside: bool) -> Result<Vec<f64>, Failed> {
        let chain = self.chain();
        let simulated = if aside { self.bench.beside(theta)? } else { self.bench.keep(theta)? };
        let mut residual = self.fitter.data.fit_residual(simulated);
        let has_none = chain.nuisances.is_empty();
        let values = if has_none { Vec::new() } else { chain.values(theta) };
        let key = relevant(&chain.nuisances, &values);
        let is_current = !chain.nuisances.iter().any(Nuisance::is_of_simulation)
            && self.projector.as_ref().is_some_and(|(of, _)| *of == key);
        if !is_current {
            let projector = Projector::new(&chain.nuisances, values, self.fitter.data, simulated);
            self.projector = Some((key, Arc::new(projector)));
        }
        if let Some((_, projector)) = &self.projector {
            projector.project(&mut residual);
        }
        let scale = 1.0 / self.fitter.sigma;
        residual.iter_mut().for_each(|r| *r *= scale);
        if let Some(weights) = self.fitter.weights {
            residual.iter_mut().zip(weights).for_each(|(r, w)| *r *= w);
        }
        Ok(residual)
    }

    fn point(&self, theta: &[f64], residual: Vec<f64>) -> Result<Point, Failed> {
        let squares: f64 = residual.iter().map(|r| r * r).sum();
        if !squares.is_finite() {
            return Err(Failed);
        }
        let count = residual.len().max(1) as f64;
        let level = (squares / count).max(1e-12).ln();
        let cost = self.fitter.effective() * level + self.chain().prior(theta);
        Ok(Point { theta: theta.to_vec(), residual, squares, cost })
    }

    fn keep(&mut self, theta: &[f64]) -> Result<Point, Failed> {
        let residual = self.left(theta, false)?;
        self.point(theta, residual)
    }

    fn beside(&mut self, theta: &[f64]) -> Result<Point, Failed> {
        let residual = self.left(theta, true)?;
        self.point(theta, residual)
    }

    /// Sensitivities of the residual to some parameters; those that need runs of an FMU side by side.
    fn columns(
        &mut self,
        point: &Point,
        which: impl IntoIterator<Item = usize>,
    ) -> Result<Vec<Vec<f64>>, Failed> {
        let which: Vec<usize> = which.into_iter().collect();
        if self.chain().has_black_box() && which.len() > 1 {
            let copy = || {
                let bench = self.bench.at_kept_point();
                Work {
                    bench,
                    fitter: self.fitter,
                    projector: self.projector.clone(),
                    enough: self.enough,
                }
            };
            let all = which.par_iter().map_init(copy, |work, k| work.column(point, *k));
            return all.collect();
        }
        which.into_iter().map(|k| self.column(point, k)).collect()
    }

    /// Sensitivity of the residual to one parameter by a forward difference.
    fn column(&mut self, point: &Point, k: usize) -> Result<Vec<f64>, Failed> {
        let parameter = &self.chain().parameters[k];
        let (low, high) = (parameter.low, parameter.high);
        let up = point.theta[k] + parameter.step <= high;
        let step = if up { parameter.step } else { -parameter.step };
        let mut moved_by = |step: f64| {
            let mut theta = point.theta.clone();
            theta[k] += step;
            // With the step that the coordinate really made.
            Ok((theta[k] - point.theta[k], self.beside(&theta)?.residual))
        };
        let (step, moved) = match moved_by(step) {
            // An FMU may fail on one side of its own value.
            Err(Failed) if (low..=high).contains(&(point.theta[k] - step)) => moved_by(-step)?,
            done => done?,
        };
        Ok(moved.iter().zip(&point.residual).map(|(a, b)| (a - b) / step).collect())
    }

    /// With all sensitivities computed anew once the cost stands still, where `is_thorough`.
    fn fit(
        &mut self,
        start: &[f64],
        known: Option<&Linear>,
        is_thorough: bool,
    ) -> Result<Fit, Failed> {
        let parameters = &self.chain().parameters;
        let clipped: Vec<f64> =
            start.iter().zip(parameters).map(|(q, p)| q.clamp(p.low, p.high)).collect();
        let base = parameters.iter().take_while(|p| p.is_base).count();
        let all = parameters.len();
        let mut point = self.keep(&clipped)?;
        if let Some(steps) = parameters.iter().position(|p| p.jumps) {
            point = self.settle(point, steps)?;
        }
        let (mut kept, mut columns) = (Vec::new(), vec![Vec::new(); all]);
        if let Some(known) = known {
            let (numbers, shared) = self.known(known);
            for (k, column) in numbers.iter().zip(shared) {
                columns[*k] = column;
            }
            kept = numbers;
        }
        let missing: Vec<usize> = (0..all).filter(|k| !kept.contains(k)).collect();
        self.fill(&point, &missing, &mut columns)?;
        if is_thorough && self.chain().is_costly() {
            let fresh = known.is_none().then_some(point.cost);
            return self.fit_corrected(point, columns, &self.chain().of_fmu(), fresh);
        }
        // What is computed at each turn: the effects' own sensitivities change most.
        let own: Vec<usize> = (base..all).filter(|k| !kept.contains(k)).collect();
        let mut is_fresh = known.is_none();
        let mut damping = 1e-3;
        for _ in 0..Thresholds::ITERATIONS {
            let before = point.cost;
            let next = self.improve(&point, &columns, &mut damping);
            let mut has_stopped = next.is_none();
            if let Some(next) = next {
                point = next;
                self.keep(&point.theta)?;
                has_stopped = before - point.cost < Thresholds::SMALL_FALL;
                is_fresh &= has_stopped;
            }
            if !has_stopped && is_thorough && before - point.cost > Thresholds::LARGE_FALL {
                self.fill(&point, &(0..all).collect::<Vec<_>>(), &mut columns)?;
                is_fresh = true;
            } else if !has_stopped {
                self.fill(&point, &own, &mut columns)?;
            } else if is_thorough && !is_fresh {
                self.fill(&point, &(0..all).collect::<Vec<_>>(), &mut columns)?;
                (is_fresh, damping) = (true, 1e-3);
            } else {
                break;
            }
        }
        Ok(self.fitted(point, &columns))
    }

    fn fitted(&self, point: Point, columns: &[Vec<f64>]) -> Fit {
        let information = self.information(&point, columns);
        let deviations = self.deviations(&point, &information);
        let mean_square = point.squares / point.residual.len().max(1) as f64;
        Fit { theta: point.theta, mean_square, deviations, information }
    }

    /// A thorough fit that makes few runs of an FMU: each step corrects the sensitivities to its parameters by what
    /// the step did and they did not foresee (Broyden 1965), and all are computed anew where that is much, and in
    /// the end. `fresh` is the cost of the point at which they were computed, if that is in this chain.
    fn fit_corrected(
        &mut self,
        mut point: Point,
        mut columns: Vec<Vec<f64>>,
        costly: &[usize],
        mut fresh: Option<f64>,
    ) -> Result<Fit, Failed> {
        let cheap: Vec<usize> = (0..columns.len()).filter(|k| !costly.contains(k)).collect();
        let mut damping = 1e-3;
        for _ in 0..Thresholds::ITERATIONS_CORRECTED {
            let next = self.improve(&point, &columns, &mut damping);
            let mut has_stopped = true;
            if let Some(next) = next {
                self.keep(&next.theta)?;
                has_stopped = point.cost - next.cost < Thresholds::SMALL_FALL;
                let before = std::mem::replace(&mut point, next);
                if !has_stopped {
                    let old: Vec<Vec<f64>> =
                        cheap.iter().map(|k| std::mem::take(&mut columns[*k])).collect();
                    self.fill(&point, &cheap, &mut columns)?;
                    let missed = correct((&before, &point), &mut columns, costly, (&cheap, &old));
                    if missed > Thresholds::CHANGE_MISSED {
                        self.fill(&point, costly, &mut columns)?;
                        fresh = Some(point.cost);
                    }
                }
            }
            if has_stopped {
                let still_holds = |cost: f64| cost - point.cost < Thresholds::STILL_FRESH;
                if fresh.map_or(point.squares > self.enough, still_holds) {
                    break;
                }
                let all: Vec<usize> = (0..columns.len()).collect();
                self.fill(&point, &all, &mut columns)?;
                (fresh, damping) = (Some(point.cost), 1e-3);
            }
        }
        Ok(self.fitted(point, &columns))
    }

    /// Searches the steps of a converter over the range (the parameter `steps`) and their phase (the one
    /// behind) without slopes: rows on the wrong step grow in number with the distance, so that the cost falls
    /// towards the answer from as far as half a step at either end of the range.
    fn settle(&mut self, mut point: Point, steps: usize) -> Result<Point, Failed> {
        /// More steps over the range, and what stays where it is: nothing, its begin, middle or end.
        const WAYS: [(f64, f64); 4] = [(0.0, 1.0), (1.0, 0.0), (1.0, 0.5), (1.0, 1.0)];
        let phase = steps + 1;
        for distance in Thresholds::STEP_DISTANCES {
            let mut still = 0;
            for (more, shift) in WAYS.iter().cycle() {
                let before = point.cost;
                for sign in [distance, -distance] {
                    loop {
                        let mut theta = point.theta.clone();
                        theta[steps] = (theta[steps].exp() + sign * more).max(1.0).ln();
                        theta[phase] += sign * shift;
                        let is_within = |k: usize| {
                            let p = &self.chain().parameters[k];
                            (p.low..=p.high).contains(&theta[k])
                        };
                        if !(is_within(steps) && is_within(phase)) {
                            break;
                        }
                        let next = self.beside(&theta)?;
                        if next.cost >= point.cost - Thresholds::SMALL_FALL {
                            break;
                        }
                        point = next;
                    }
                }
                still = if point.cost < before { 0 } else { still + 1 };
                if still == WAYS.len() {
                    break;
                }
            }
        }
        self.keep(&point.theta.clone())
    }

    fn fill(
        &mut self,
        point: &Point,
        which: &[usize],
        columns: &mut [Vec<f64>],
    ) -> Result<(), Failed> {
        let fresh = self.columns(point, which.iter().copied())?;
        for (k, column) in which.iter().zip(fresh) {
            columns[*k] = column;
        }
        Ok(())
    }

    /// A better point, or nothing.
    fn improve(&mut self, point: &Point, columns: &[Vec<f64>], damping: &mut f64) -> Option<Point> {
        let weight = self.fitter.effective() / point.squares.max(1e-9);
        let (mut normal, mut gradient) = normal_equations(columns, &point.residual, weight);
        for (k, p) in self.chain().parameters.iter().enumerate() {
            normal[(k, k)] += p.prior;
            gradient[k] -= p.prior * point.theta[k];
        }
        for _ in 0..7 {
            let theta = self.step(point, &normal, &gradient, *damping)?;
            match self.beside(&theta) {
                Ok(next) if next.cost < point.cost => {
                    *damping = (*damping * 0.2).max(1e-9);
                    return Some(next);
                }
                _ => *damping = (*damping * 8.0).max(1e-4),
            }
        }
        None
    }

    /// The damped step, with parameters that push against a bound held there.
    fn step(
        &self,
        point: &Point,
        normal: &DMatrix<f64>,
        gradient: &DVector<f64>,
        damping: f64,
    ) -> Option<Vec<f64>> {
        /// Information about a coordinate that the rows do not show.
        const UNSEEN: f64 = 1e-12;
        let parameters = &self.chain().parameters;
        let n = parameters.len();
        let mut held: Vec<bool> = (0..n)
            .map(|k| {
                let (p, q) = (&parameters[k], point.theta[k]);
                (q <= p.low && gradient[k] < 0.0) || (q >= p.high && gradient[k] > 0.0)
            })
            .collect();
        for _ in 0..n {
            let mut theta = point.theta.clone();
            let free: Vec<usize> = (0..n).filter(|k| !held[*k]).collect();
            if free.is_empty() {
                return None;
            }
            let at = |i: usize, j: usize| normal[(free[i], free[j])];
            // What moves nothing stays where it is.
            let floor = |i: usize, j: usize| if i == j { at(i, j).max(UNSEEN) } else { at(i, j) };
            let matrix = DMatrix::from_fn(free.len(), free.len(), floor);
            let slope = DVector::from_fn(free.len(), |i, _| -gradient[free[i]]);
            let step = damped_step(matrix, &slope, damping)?;
            for (i, a) in free.iter().enumerate() {
                // Logarithms move by at most a factor e at once.
                let most = if parameters[*a].log { 1.0 } else { f64::INFINITY };
                theta[*a] += step[i].clamp(-most, most);
            }
            let out: Vec<usize> = free
                .into_iter()
                .filter(|k| theta[*k] < parameters[*k].low || theta[*k] > parameters[*k].high)
                .collect();
            // Those that would leave the box through a bound that they are on already are held.
            let at_bound = |k: &usize| {
                let (p, q) = (&parameters[*k], point.theta[*k]);
                q <= p.low || q >= p.high
            };
            let stuck: Vec<usize> = out.iter().copied().filter(|k| at_bound(k)).collect();
            if stuck.is_empty() {
                let clip = theta.iter().zip(parameters).map(|(q, p)| q.clamp(p.low, p.high));
                return Some(clip.collect());
            }
            stuck.into_iter().for_each(|k| held[k] = true);
        }
        None
    }

    fn information(&self, point: &Point, columns: &[Vec<f64>]) -> DMatrix<f64> {
        let weight = self.fitter.effective() / point.squares.max(1e-9);
        let (mut normal, _) = normal_equations(columns, &point.residual, weight);
        for (k, p) in self.chain().parameters.iter().enumerate() {
            normal[(k, k)] += p.prior;
        }
        normal
    }

    fn deviations(&self, point: &Point, information: &DMatrix<f64>) -> Vec<Option<f64>> {
        let mut normal = information.clone();
        let seen: Vec<bool> = (0..normal.nrows()).map(|k| normal[(k, k)] > 0.0).collect();
        for k in 0..normal.nrows() {
            normal[(k, k)] = normal[(k, k)].mul_add(1.0 + 1e-12, f64::MIN_POSITIVE);
        }
        let inverse = normal.cholesky().map(|c| c.inverse());
        let parameters = &self.chain().parameters;
        (0..parameters.len())
            .map(|k| {
                let is_inside = parameters[k].is_inside(point.theta[k]);
                let variance = inverse.as_ref()?[(k, k)];
                (is_inside && seen[k] && variance.is_finite()).then(|| variance.max(0.0).sqrt())
            })
            .collect()
    }
}

#[cfg(test)]
mod tests;

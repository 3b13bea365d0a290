//! Fits a chain to the training rows: Levenberg-Marquardt under priors, in a box.
//!
//! The data count as `N_eff · ln(Σ r²)`: where the model is structurally wrong the residual is not
//! noise, and the priors of the model's own parameters must not be overruled by its size. N_eff is the
//! number of rows over the correlation length of residuals.

use std::sync::atomic::AtomicU64;

use nalgebra::{DMatrix, DVector};

use crate::chain::{Bench, Chain, Failed, Horizon};
use crate::data_set::DataSet;
use crate::nuisance::Projector;

/// Most iterations.
const ITERATIONS: usize = 12;
/// Iterations after which the columns of the model's own parameters are computed again.
const REFRESH: usize = 4;
/// Fall of the cost below which an iteration ends the fit.
const SMALL: f64 = 0.2;
/// Rows per independent one.
const CORRELATION: f64 = 10.0;

/// What fits are made with.
#[derive(Clone, Copy)]
pub(crate) struct Fitter<'a> {
    pub(crate) data: &'a DataSet,
    /// Standard deviation of the noise.
    pub(crate) sigma: f64,
    /// Counts simulations.
    pub(crate) count: &'a AtomicU64,
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
    projector: Option<(Vec<f64>, Projector)>,
}

impl<'a> Fitter<'a> {
    /// Effective number of training rows.
    pub(crate) fn effective(&self) -> f64 {
        (self.data.fit_rows.len() as f64 / CORRELATION).max(50.0)
    }

    fn work(self, chain: &'a Chain) -> Work<'a> {
        let bench = Bench::new(chain, self.data, Horizon::Training, self.count);
        Work { bench, fitter: self, projector: None }
    }

    /// Fits from these coordinates.
    ///
    /// # Errors
    /// The chain cannot be simulated there.
    pub(crate) fn fit(self, chain: &'a Chain, start: &[f64]) -> Result<Fit, Failed> {
        self.work(chain).fit(start)
    }

    /// Residual at the rows of the fit, in standard deviations, and the sensitivities to all
    /// parameters: the point from which candidates are screened.
    pub(crate) fn linearise(self, chain: &'a Chain, theta: &[f64]) -> Result<Linear, Failed> {
        let mut work = self.work(chain);
        let point = work.keep(theta)?;
        let columns = work.columns(&point, 0..chain.parameters.len())?;
        Ok(Linear { residual: point.residual, columns })
    }

    /// The part of the residual's squares that a candidate would take in the first order: from each
    /// of these starts, with the parameters of `base` (those that come first) moving along.
    pub(crate) fn promise(
        self,
        chain: &'a Chain,
        base: &Linear,
        start: &[f64],
        screened: std::ops::Range<usize>,
    ) -> Result<f64, Failed> {
        let mut work = self.work(chain);
        let point = work.keep(start)?;
        let own = work.columns(&point, screened)?;
        let mut columns = base.columns.clone();
        // A candidate with a term per record changes what is taken out of all columns alike.
        if let (false, Some((_, projector))) = (chain.nuisances.is_empty(), &work.projector) {
            columns.iter_mut().for_each(|column| projector.project(column));
        }
        columns.extend(own);
        let weight = self.effective() / point.squares.max(1.0);
        let (normal, gradient) = normal_equations(&columns, &point.residual, weight);
        let priors = chain.parameters.iter().map(|p| p.prior);
        let mut normal = normal;
        for (k, prior) in priors.take(base.columns.len()).enumerate() {
            normal[(k, k)] += prior + 1e-9;
        }
        for k in 0..normal.nrows() {
            normal[(k, k)] *= 1.0 + 1e-9;
        }
        let Some(solver) = normal.cholesky() else { return Err(Failed) };
        let step = solver.solve(&gradient);
        let left = point.squares - gradient.dot(&step) / weight;
        let before: f64 = base.residual.iter().map(|r| r * r).sum();
        Ok(1.0 - (left / before).max(0.0))
    }
}

/// A chain in the first order about a point.
pub(crate) struct Linear {
    pub(crate) residual: Vec<f64>,
    pub(crate) columns: Vec<Vec<f64>>,
}

/// `JᵀJ·weight` and `−Jᵀr·weight`.
fn normal_equations(
    columns: &[Vec<f64>],
    residual: &[f64],
    weight: f64,
) -> (DMatrix<f64>, DVector<f64>) {
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let n = columns.len();
    let mut normal = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let value = weight * dot(&columns[i], &columns[j]);
            normal[(i, j)] = value;
            normal[(j, i)] = value;
        }
    }
    let gradient = columns.iter().map(|column| -weight * dot(column, residual));
    (normal, DVector::from_iterator(n, gradient))
}

impl<'a> Work<'a> {
    fn chain(&self) -> &'a Chain {
        self.bench.chain
    }

    /// Residual in standard deviations with the nuisances taken out.
    fn finish(&mut self, theta: &[f64], mut residual: Vec<f64>) -> Vec<f64> {
        let chain = self.chain();
        let values: Vec<f64> = if chain.nuisances.is_empty() {
            Vec::new()
        } else {
            chain.parameters.iter().zip(theta).map(|(p, q)| p.value(*q)).collect()
        };
        let is_current =
            self.projector.as_ref().is_some_and(|(of, _)| *of == relevant(chain, &values));
        if !is_current {
            let key = relevant(chain, &values);
            let projector = Projector::new(&chain.nuisances, values, self.fitter.data);
            self.projector = Some((key, projector));
        }
        if let Some((_, projector)) = &self.projector {
            projector.project(&mut residual);
        }
        let scale = 1.0 / self.fitter.sigma;
        residual.iter_mut().for_each(|r| *r *= scale);
        residual
    }

    fn point(&self, theta: &[f64], residual: Vec<f64>) -> Result<Point, Failed> {
        let squares: f64 = residual.iter().map(|r| r * r).sum();
        if !squares.is_finite() {
            return Err(Failed);
        }
        let count = residual.len().max(1) as f64;
        let prior: f64 =
            self.chain().parameters.iter().zip(theta).map(|(p, q)| p.prior * q * q).sum();
        let cost = self.fitter.effective() * (squares / count).max(1e-12).ln() + prior;
        Ok(Point { theta: theta.to_vec(), residual, squares, cost })
    }

    fn keep(&mut self, theta: &[f64]) -> Result<Point, Failed> {
        let residual = self.fitter.data.fit_residual(self.bench.keep(theta)?);
        let residual = self.finish(theta, residual);
        self.point(theta, residual)
    }

    fn beside(&mut self, theta: &[f64]) -> Result<Point, Failed> {
        let residual = self.fitter.data.fit_residual(self.bench.beside(theta)?);
        let residual = self.finish(theta, residual);
        self.point(theta, residual)
    }

    /// Sensitivities of the residual to some parameters by forward differences.
    fn columns(
        &mut self,
        point: &Point,
        which: std::ops::Range<usize>,
    ) -> Result<Vec<Vec<f64>>, Failed> {
        let mut columns = Vec::with_capacity(which.len());
        for k in which {
            let parameter = &self.chain().parameters[k];
            let up = point.theta[k] + parameter.step <= parameter.high;
            let step = if up { parameter.step } else { -parameter.step };
            let mut theta = point.theta.clone();
            theta[k] += step;
            // The step that the coordinate really made.
            let step = theta[k] - point.theta[k];
            let moved = self.beside(&theta)?.residual;
            let column = moved.iter().zip(&point.residual).map(|(a, b)| (a - b) / step);
            columns.push(column.collect());
        }
        Ok(columns)
    }

    fn fit(&mut self, start: &[f64]) -> Result<Fit, Failed> {
        let parameters = &self.chain().parameters;
        let clipped: Vec<f64> =
            start.iter().zip(parameters).map(|(q, p)| q.clamp(p.low, p.high)).collect();
        let base = parameters.iter().take_while(|p| p.is_base).count();
        let all = parameters.len();
        let mut point = self.keep(&clipped)?;
        let mut columns = self.columns(&point, 0..all)?;
        let mut damping = 1e-3;
        for iteration in 1..=ITERATIONS {
            let before = point.cost;
            let Some(next) = self.improve(&point, &columns, &mut damping) else { break };
            point = next;
            self.keep(&point.theta)?;
            let has_stopped = before - point.cost < SMALL;
            let from = if iteration % REFRESH == 0 { 0 } else { base };
            columns.truncate(from);
            let fresh = self.columns(&point, from..all)?;
            columns.extend(fresh);
            if has_stopped {
                break;
            }
        }
        let deviations = self.deviations(&point, &columns);
        let mean_square = point.squares / point.residual.len().max(1) as f64;
        Ok(Fit { theta: point.theta, mean_square, deviations })
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
            let mut matrix = DMatrix::zeros(free.len(), free.len());
            let mut right = DVector::zeros(free.len());
            for (i, a) in free.iter().enumerate() {
                right[i] = gradient[*a];
                for (j, b) in free.iter().enumerate() {
                    matrix[(i, j)] = normal[(*a, *b)];
                }
                matrix[(i, i)] += damping * normal[(*a, *a)].max(1e-12) + 1e-12;
            }
            let step = matrix.cholesky()?.solve(&right);
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

    fn deviations(&self, point: &Point, columns: &[Vec<f64>]) -> Vec<Option<f64>> {
        let weight = self.fitter.effective() / point.squares.max(1e-9);
        let (mut normal, _) = normal_equations(columns, &point.residual, weight);
        for (k, p) in self.chain().parameters.iter().enumerate() {
            normal[(k, k)] += p.prior;
        }
        let seen: Vec<bool> = (0..normal.nrows()).map(|k| normal[(k, k)] > 0.0).collect();
        for k in 0..normal.nrows() {
            normal[(k, k)] = normal[(k, k)].mul_add(1.0 + 1e-12, f64::MIN_POSITIVE);
        }
        let inverse = normal.cholesky().map(|c| c.inverse());
        let parameters = &self.chain().parameters;
        (0..columns.len())
            .map(|k| {
                let (p, q) = (&parameters[k], point.theta[k]);
                let is_inside = q > p.low && q < p.high;
                let variance = inverse.as_ref()?[(k, k)];
                (is_inside && seen[k] && variance.is_finite()).then(|| variance.max(0.0).sqrt())
            })
            .collect()
    }
}

/// The values that nuisances depend on.
fn relevant(chain: &Chain, values: &[f64]) -> Vec<f64> {
    use crate::nuisance::Nuisance;
    chain
        .nuisances
        .iter()
        .filter_map(|n| match n {
            Nuisance::Settling { parameter } | Nuisance::Lines { parameter, .. } => {
                values.get(*parameter).copied()
            }
            Nuisance::Drift { .. } | Nuisance::Knots { .. } => None,
        })
        .collect()
}

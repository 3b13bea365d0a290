//! What the answer leaves on a new record like the logs, as far as these determine it.
//!
//! Held-out rows are near the fitted ones. A new record goes other ways within the same range: here the commands of the
//! logs, mirrored about the middle of their range and reversed in time. The machine is drawn from what the logs leave
//! open:
//!
//! ```text
//! m = s_k + J·δ,   P(k) = probability of the answer or of a rival,   δ ~ N(0, A⁻¹)
//! l = |m − s_answer|²/|m − s_retuned|²
//! ```
//!
//! for simulated outputs s, sensitivities J of the answer, and the information A of its fit, in standard deviations of
//! the noise.

use std::sync::atomic::AtomicU64;

use nalgebra::{DMatrix, DVector};
use numerics::random::SplitMix64;

use crate::belief;
use crate::candidate::Candidate;
use crate::chain::Chain;
use crate::data_set::DataSet;
use crate::fit::Fitter;
use crate::normal::{dot, products};
use crate::outcome::Outcome;
use crate::thresholds::answer::Thresholds;

/// Mean products over the rows of one new record.
struct Course {
    /// `JᵀJ`.
    sensitivities: DMatrix<f64>,
    machines: Vec<Machine>,
}

/// A machine that the logs leave possible, before its parameters are drawn.
struct Machine {
    /// Square and `Jᵀ·` of what the answer misses of it.
    by_answer: (f64, DVector<f64>),
    /// Square and `Jᵀ·` of what the re-tuned model misses of it.
    by_retuned: (f64, DVector<f64>),
}

/// Draws of the part of the gap's power that the answer leaves on a new record; none where no effect is named, or where no
/// model predicts what is named.
pub(crate) fn left(o: &Outcome, seed: u64) -> Vec<f64> {
    let answer = &o.found.last;
    if answer.picks.is_empty() || o.predicted.is_some() {
        return Vec::new();
    }
    let rivals = rivals(o);
    let Some(spread) = spread(answer) else { return Vec::new() };
    let data = [mirrored(&o.task.data), reversed(&o.task.data)];
    let courses: Vec<Course> =
        data.iter().filter_map(|data| Course::new(o, data, &rivals)).collect();
    let named = 1.0 - rivals.iter().map(|(p, _)| p).sum::<f64>();
    let named = named.max(Thresholds::NAMED_LEAST);
    let weights: Vec<f64> = std::iter::once(named).chain(rivals.iter().map(|(p, _)| *p)).collect();
    let total: f64 = weights.iter().sum();
    let mut random = SplitMix64::new(seed);
    let mut draw = |course: &Course| {
        let mut rest = total * random.uniform();
        let at = weights.iter().position(|weight| {
            rest -= weight;
            rest < 0.0
        });
        let normal = DVector::from_fn(spread.ncols(), |_, _| random.normal());
        let step = within(answer, &spread * normal);
        course.machines[at.unwrap_or(0)].left(&course.sensitivities, &step)
    };
    courses.iter().cycle().take(Thresholds::BOOTSTRAP_DRAWS).filter_map(&mut draw).collect()
}

/// The names beside the answer that are in the set of an effect, with their probabilities.
fn rivals(o: &Outcome) -> Vec<(f64, &Candidate)> {
    let last = &o.found.last;
    let mut all = Vec::new();
    for (slot, looked) in o.found.rivals.iter().enumerate().take(last.picks.len()) {
        let beliefs = belief::beliefs(&o.sight(), looked, last);
        let set = belief::set(&beliefs);
        let others =
            beliefs.iter().filter(|b| set.contains(&b.family) && b.family != last.picks[slot].0);
        all.extend(others.filter_map(|b| {
            let best = looked.iter().find(|l| l.family == b.family)?.best.as_ref()?;
            Some((b.probability, best))
        }));
    }
    all
}

/// A root of the covariance of the answer's coordinates; those at a bound stay there.
fn spread(answer: &Candidate) -> Option<DMatrix<f64>> {
    let fit = &answer.fit;
    let n = fit.theta.len();
    let free: Vec<usize> = (0..n).filter(|k| fit.deviations[*k].is_some()).collect();
    let information =
        DMatrix::from_fn(free.len(), free.len(), |i, j| fit.information[(free[i], free[j])]);
    let factor = information.cholesky()?.l().transpose();
    let root = factor.solve_upper_triangular(&DMatrix::identity(free.len(), free.len()))?;
    let mut all = DMatrix::zeros(n, free.len());
    for (i, k) in free.iter().enumerate() {
        all.set_row(*k, &root.row(i));
    }
    Some(all)
}

/// The step, made smaller until all coordinates are within their bounds.
fn within(answer: &Candidate, mut step: DVector<f64>) -> DVector<f64> {
    let mut part = 1.0_f64;
    for ((p, q), d) in answer.chain.parameters.iter().zip(&answer.fit.theta).zip(step.iter()) {
        let room = if *d > 0.0 { p.high - q } else { p.low - q };
        if *d != 0.0 {
            part = part.min((room / d).max(0.0));
        }
    }
    step *= part;
    step
}

impl Machine {
    /// Part of the gap's power that the answer leaves where the parameters are off by `step`.
    fn left(&self, sensitivities: &DMatrix<f64>, step: &DVector<f64>) -> Option<f64> {
        let moved = step.dot(&(sensitivities * step));
        let square =
            |(square, by): &(f64, DVector<f64>)| (square + 2.0 * by.dot(step) + moved).max(0.0);
        let part = square(&self.by_answer) / square(&self.by_retuned);
        part.is_finite().then_some(part)
    }
}

impl Course {
    /// `None` where the answer cannot be simulated there.
    fn new(o: &Outcome, data: &DataSet, rivals: &[(f64, &Candidate)]) -> Option<Self> {
        let count = AtomicU64::new(0);
        let fitter = Fitter { data, sigma: o.sigma, count: &count, weights: None };
        // Of terms of each record's own nothing is known in a new one but the offset.
        let plain = |of: &Candidate| Chain { nuisances: Vec::new(), ..of.chain.clone() };
        let played = |of: &Candidate| fitter.residual(&plain(of), &of.fit.theta).ok();
        let answer = &o.found.last;
        let linear = fitter.linearise(&plain(answer), &answer.fit.theta).ok()?;
        let retuned = played(&o.found.base)?;
        let rows = linear.residual.len().max(1) as f64;
        let machine = |left: &[f64]| {
            let missed = |by: &[f64]| {
                let off: Vec<f64> = by.iter().zip(left).map(|(by, own)| by - own).collect();
                let slopes = linear.columns.iter().map(|column| -dot(column, &off) / rows);
                (dot(&off, &off) / rows, DVector::from_iterator(linear.columns.len(), slopes))
            };
            Machine { by_answer: missed(&linear.residual), by_retuned: missed(&retuned) }
        };
        let others = rivals.iter().map(|(_, rival)| played(rival).map(|left| machine(&left)));
        let machines = std::iter::once(Some(machine(&linear.residual))).chain(others);
        Some(Self {
            machines: machines.collect::<Option<_>>()?,
            sensitivities: products(&linear.columns) / rows,
        })
    }
}

/// The logs with commands mirrored about the middle of their range.
fn mirrored(data: &DataSet) -> DataSet {
    let centre = data.command_span.centre;
    let mut data = silent(data);
    let records = data.records.iter_mut();
    let logged = records.flat_map(|r| r.logged.iter_mut().chain(&mut r.rest));
    data.command.iter_mut().chain(logged).for_each(|u| *u = 2.0 * centre - *u);
    data
}

/// The logs with commands reversed in time.
fn reversed(data: &DataSet) -> DataSet {
    let mut data = silent(data);
    for record in &mut data.records {
        data.command[record.hits.clone()].reverse();
        record.logged.reverse();
        record.rest = None;
    }
    data
}

/// The logs with readings of zero.
fn silent(data: &DataSet) -> DataSet {
    DataSet { y: vec![0.0; data.y.len()], ..data.clone() }
}

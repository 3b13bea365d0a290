//! Which effects are missing: candidates for a slot, screened, fitted and ranked.

mod accept;
mod away;
mod formulas;
mod memo;
mod naming;
mod refine;

use std::sync::atomic::AtomicU64;

use components::effects;
use rayon::prelude::*;

pub(crate) use self::memo::Memo;
use self::memo::Part;
use crate::base::Base;
use crate::candidate::{Candidate, RankedFamily, Why, carried};
use crate::chain::Chain;
use crate::data_set::DataSet;
use crate::error::Failed;
use crate::fit::{Fit, Fitter, Linear};
use crate::formula::{Family, Formula, Slot};
use crate::library::gain;
use crate::score::{Judge, Judged};
use crate::spectrum;
use crate::thresholds::search::Thresholds;

/// The search for one output.
pub(crate) struct Search<'a> {
    pub(crate) base: &'a Base,
    pub(crate) data: &'a DataSet,
    pub(crate) judge: &'a Judge,
    pub(crate) library: &'a [Family],
    pub(crate) sigma: f64,
    /// Mean square over the noise's up to which nothing is left to explain.
    pub(crate) adequate: f64,
    /// What the user calls good enough, in powers of the noise.
    pub(crate) fine: f64,
    pub(crate) count: &'a AtomicU64,
    pub(crate) max_effects: usize,
    /// Whether how the logs are read is known: no effect is named then that imitates another, and not several in a faint gap.
    pub(crate) reading_is_known: bool,
    /// What was made already.
    pub(crate) memo: &'a Memo,
}

impl<'a> Search<'a> {
    pub(crate) fn fitter(&self) -> Fitter<'a> {
        Fitter { data: self.data, sigma: self.sigma, count: self.count, weights: None }
    }

    fn formulas(&self, picks: &[(usize, usize)]) -> Vec<&'a Formula> {
        picks.iter().map(|(family, formula)| &self.library[*family].formulas[*formula]).collect()
    }

    /// The re-tuned model.
    pub(crate) fn retune(&self) -> Result<Candidate, Failed> {
        let chain = self.base.compose(&[]);
        let start = vec![0.0; chain.parameters.len()];
        let fit = self.fitter().fit(&chain, &start)?;
        self.candidate(Vec::new(), chain, fit)
    }

    /// A fitted set of effects, judged.
    pub(crate) fn candidate(
        &self,
        picks: Vec<(usize, usize)>,
        chain: Chain,
        fit: Fit,
    ) -> Result<Candidate, Failed> {
        let judged = self.judge.judge(&chain, &fit.theta, self.data, self.sigma, self.count)?;
        Ok(self.ranked(picks, chain, fit, judged))
    }

    /// A fit that was judged, with its rank.
    fn ranked(
        &self,
        picks: Vec<(usize, usize)>,
        chain: Chain,
        fit: Fit,
        judged: Judged,
    ) -> Candidate {
        let records = self.data.records.len();
        let freedom: usize = self.formulas(&picks).iter().map(|f| f.freedom(records)).sum();
        let rows = self.fitter().effective();
        let level = |m: f64| m.max(1e-12).ln();
        // What is learned on the training rows must hold on the others.
        let training = fit.mean_square + self.judge.taken(&chain, &fit.theta, self.data);
        let data = Thresholds::TRAINING_WEIGHT * level(training)
            + (1.0 - Thresholds::TRAINING_WEIGHT) * level(judged.held_out);
        let rank = rank((rows, data), chain.prior(&fit.theta), freedom);
        Candidate { picks, chain, fit, judged, training, rank, freedom, against: f64::INFINITY }
    }

    /// Coordinates for `chain` that say what `from` says, with the start of a new effect at the end.
    fn carry(&self, from: &Candidate, chain: &Chain, formula: &Formula, start: &[f64]) -> Vec<f64> {
        let own = chain.parameters.len() - formula.parameters.len();
        let origin = chain.origin(&from.chain);
        let mut theta: Vec<f64> =
            origin[..own].iter().map(|k| k.map_or(0.0, |k| from.fit.theta[k])).collect();
        theta.extend(formula.parameters.iter().zip(start).map(|(p, v)| p.coordinate(*v)));
        theta
    }

    /// All families as the next effect beside those of `from`, best first.
    pub(crate) fn expand(&self, from: &Candidate) -> Result<Vec<RankedFamily>, Failed> {
        self.expand_where(from, f64::INFINITY)
    }

    /// All families as the next effect, where one of them promises to leave at most this mean square.
    fn expand_where(&self, from: &Candidate, most: f64) -> Result<Vec<RankedFamily>, Failed> {
        self.once(Part::Expansion, from, || self.expand_anew(from, most))
    }

    fn expand_anew(&self, from: &Candidate, most: f64) -> Result<Vec<RankedFamily>, Failed> {
        let linear = self.fitter().linearise(&from.chain, &from.fit.theta)?;
        let fixed = self.formulas(&from.picks);
        let jobs: Vec<(usize, usize)> = (0..self.library.len())
            .filter(|family| from.picks.iter().all(|(f, _)| f != family))
            .flat_map(|family| (0..self.library[family].formulas.len()).map(move |k| (family, k)))
            .filter(|(family, k)| {
                let formula = &self.library[*family].formulas[*k];
                let says_nothing = formula.is_beside_others && from.picks.is_empty();
                !formula.is_stand_in && !says_nothing
            })
            .collect();
        let peaks = self.peaks(from);
        // One by one, here and below: some take many times as long as others.
        let screened: Vec<(f64, Vec<f64>)> = jobs
            .par_iter()
            .with_max_len(1)
            .map(|job| self.screen(from, &fixed, *job, &linear, &peaks))
            .collect();
        let best_of = |family: usize| {
            let own = jobs.iter().zip(&screened).filter(|((f, _), _)| *f == family);
            own.map(|(_, (promise, _))| *promise).fold(f64::NEG_INFINITY, f64::max)
        };
        let mut families: Vec<(usize, f64)> = (0..self.library.len())
            .filter(|family| from.picks.iter().all(|(f, _)| f != family))
            .map(|family| (family, best_of(family)))
            .collect();
        families.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let greatest = families.first().map_or(0.0, |(_, promise)| *promise);
        if (1.0 - greatest) * from.fit.mean_square > most {
            return Err(Failed);
        }
        let most = if from.picks.is_empty() {
            Thresholds::FAMILIES_FITTED
        } else {
            Thresholds::FAMILIES_FITTED_BESIDE
        };
        let kept: Vec<usize> = families.iter().take(most).map(|(family, _)| *family).collect();
        let to_fit: Vec<usize> = (0..jobs.len())
            .filter(|k| {
                let (family, formula) = jobs[*k];
                let releases = !self.library[family].formulas[formula].releases.is_empty();
                kept.contains(&family) || releases
            })
            .collect();
        // A thorough fit is for what promises most: a formula of which that is not so is taken as it comes.
        let mut fitted: Vec<Option<Candidate>> = to_fit
            .par_iter()
            .with_max_len(1)
            .map(|k| {
                let (promise, start) = &screened[*k];
                let is_promising = *promise > Thresholds::PROMISING * greatest;
                let fit = self.fit_one(from, &fixed, (jobs[*k], start, is_promising), &linear);
                let fit = self.as_hinted(fit.ok()?);
                Some(self.released_elsewhere(fit, (1.0 - promise) * from.fit.mean_square))
            })
            .collect();
        // A resonance that moved by more than its width promises nothing in the first order.
        self.resonance_elsewhere(&mut fitted);
        let mut looked: Vec<RankedFamily> = families
            .iter()
            .map(|(family, screening)| RankedFamily {
                family: *family,
                screening: *screening,
                best: None,
                why: Some(Why::Screened),
            })
            .collect();
        let mut others = Vec::new();
        for (k, candidate) in to_fit.iter().zip(fitted) {
            let Some(entry) = looked.iter_mut().find(|l| l.family == jobs[*k].0) else { continue };
            let Some(candidate) = candidate else {
                entry.why = entry.why.map(|_| Why::Failed);
                continue;
            };
            if entry.best.as_ref().is_none_or(|b| candidate.rank < b.rank) {
                others.extend(entry.best.replace(candidate));
                entry.why = None;
            } else {
                others.push(candidate);
            }
        }
        // A model that is cut at a tap has no place for a gain of the reading.
        let as_gain = match self.base.slots.contains_key(&Slot::AfterMechanics) {
            true => self.left_by(from, &fixed, &gain(), &linear),
            false => f64::INFINITY,
        };
        looked
            .par_iter_mut()
            .with_max_len(1)
            .for_each(|entry| self.hold_against_nulls(from, &fixed, entry, &linear, as_gain));
        sort(&mut looked);
        let best = looked.iter().find_map(|l| l.best.as_ref());
        let known = (&linear, best.map_or(f64::INFINITY, |best| best.fit.mean_square));
        let nearest = looked.par_iter_mut().take(Thresholds::FAMILIES_REFINED).with_max_len(1);
        nearest.for_each(|entry| self.refine_with_plainer(entry, &others, known));
        sort(&mut looked);
        Ok(looked)
    }

    /// Drops a family whose formula is no better than what it becomes without the effect, or than
    /// another gain, which leaves `as_gain`: nearly every formula can imitate one.
    fn hold_against_nulls(
        &self,
        from: &Candidate,
        fixed: &[&Formula],
        entry: &mut RankedFamily,
        linear: &Linear,
        as_gain: f64,
    ) {
        let own = |best: &Candidate| 0.5 * (best.fit.mean_square + best.judged.held_out);
        let Some(mut left) = entry.best.as_ref().map(own) else { return };
        let family = &self.library[entry.family];
        let is_gain = family.effect.name == effects::ACTUATOR_GAIN.name;
        let mut holds = |null: f64, entry: &mut RankedFamily| {
            // What promised far more than it came to was not fitted to its end.
            let is_small = entry
                .best
                .as_ref()
                .is_some_and(|c| c.fit.theta.len() <= Thresholds::MOST_FITTED_ANEW);
            let has_promised =
                (1.0 - entry.screening) * from.fit.mean_square < null / Thresholds::OVER_NULL;
            if null < Thresholds::OVER_NULL * left && has_promised && is_small {
                self.refine(entry, (linear, f64::INFINITY));
                left = entry.best.as_ref().map_or(left, own);
            }
            null >= Thresholds::OVER_NULL * left
        };
        let nulls = || {
            let all = family.nulls.par_iter().with_max_len(1);
            all.map(|null| self.left_by(from, fixed, null, linear)).collect::<Vec<f64>>()
        };
        let is_more = holds(if is_gain { f64::INFINITY } else { as_gain }, entry)
            && nulls().into_iter().all(|null| holds(null, &mut *entry));
        if !is_more {
            (entry.best, entry.why) = (None, Some(Why::AsNull));
        }
    }

    /// What a formula leaves at its best start, the mean of the rows that are fitted and held out.
    fn left_by(
        &self,
        from: &Candidate,
        fixed: &[&Formula],
        formula: &Formula,
        linear: &Linear,
    ) -> f64 {
        let mut with = fixed.to_vec();
        with.push(formula);
        let chain = self.base.compose(&with);
        let left = |start: &Vec<f64>| -> Result<f64, Failed> {
            let theta = self.carry(from, &chain, formula, start);
            let fitter = self.fitter();
            let mut fit = fitter.fit_quickly(&chain, &theta, linear)?;
            // What went far may be on its way still.
            if fit.mean_square < Thresholds::WENT_FAR * from.fit.mean_square {
                fit = fitter.fit_from(&chain, &fit.theta, (linear, f64::INFINITY))?;
            }
            let judged = self.judge.judge(&chain, &fit.theta, self.data, self.sigma, self.count)?;
            Ok(0.5 * (fit.mean_square + judged.held_out))
        };
        let all = formula.starts.par_iter().with_max_len(1).filter_map(|start| left(start).ok());
        all.reduce(|| f64::INFINITY, f64::min)
    }

    /// Frequencies at which what is left answers to what is simulated.
    fn peaks(&self, from: &Candidate) -> Vec<f64> {
        let residual = &from.judged.residual;
        let simulated: Vec<f64> =
            self.data.y.iter().zip(residual).map(|(y, r)| y - self.sigma * r).collect();
        let rows = self.data.records.iter().map(|record| record.training.clone());
        let mut all = spectrum::resonances(&simulated, residual, rows, self.data.sample_time);
        all.extend(self.base.hints.iter().filter_map(|hint| hint.frequency));
        all
    }

    /// First-order promise of a formula and its best start.
    fn screen(
        &self,
        from: &Candidate,
        fixed: &[&Formula],
        (family, number): (usize, usize),
        linear: &Linear,
        peaks: &[f64],
    ) -> (f64, Vec<f64>) {
        let formula = &self.library[family].formulas[number];
        let all = formula.starts_with(peaks);
        let mut with = fixed.to_vec();
        with.push(formula);
        let chain = self.base.compose(&with);
        let starts: Vec<Vec<f64>> =
            all.iter().map(|start| self.carry(from, &chain, formula, start)).collect();
        let promises = self.fitter().promises(&chain, linear, &starts, formula.screened);
        let mut best = (f64::NEG_INFINITY, all.first().cloned().unwrap_or_default());
        for (promise, start) in promises.into_iter().zip(&all) {
            if let Some((promise, to)) = promise
                && promise > best.0
            {
                let mut start = start.clone();
                if formula.starts_at_promise {
                    let first = chain.parameters.len() - start.len();
                    for (k, value) in start.iter_mut().enumerate().take(formula.screened) {
                        let p = &chain.parameters[first + k];
                        *value = p.value(to[first + k].clamp(p.low, p.high));
                    }
                }
                best = (promise, start);
            }
        }
        best
    }

    fn fit_one(
        &self,
        from: &Candidate,
        fixed: &[&Formula],
        ((family, number), start, is_promising): ((usize, usize), &[f64], bool),
        linear: &Linear,
    ) -> Result<Candidate, Failed> {
        let formula = &self.library[family].formulas[number];
        let mut with = fixed.to_vec();
        with.push(formula);
        let chain = self.base.compose(&with);
        let theta = self.carry(from, &chain, formula, start);
        let is_small = theta.len() <= Thresholds::MOST_FITTED_ANEW;
        let fit = match formula.is_fitted_anew && is_promising && is_small {
            true => self.fitter().fit(&chain, &theta)?,
            false => self.fitter().fit_quickly(&chain, &theta, linear)?,
        };
        let mut picks = from.picks.clone();
        picks.push((family, number));
        self.candidate(picks, chain, fit)
    }

    /// The whole set fitted again without the effect number `without`.
    pub(crate) fn refit_without(
        &self,
        from: &Candidate,
        without: usize,
    ) -> Result<Candidate, Failed> {
        let mut picks = from.picks.clone();
        picks.remove(without);
        self.refit(from, picks)
    }

    /// A set of effects of which all are in `from`, fitted from its values.
    fn refit(&self, from: &Candidate, picks: Vec<(usize, usize)>) -> Result<Candidate, Failed> {
        self.once_one(Part::Refit(picks.clone()), from, || {
            let (chain, theta) = self.carried(from, &picks)?;
            let fit = self.fitter().fit(&chain, &theta)?;
            self.candidate(picks, chain, fit)
        })
    }

    /// The chain of a set of effects of which all are in `from`, with its values.
    fn carried(
        &self,
        from: &Candidate,
        picks: &[(usize, usize)],
    ) -> Result<(Chain, Vec<f64>), Failed> {
        carried((self.base, self.library), from, picks).ok_or(Failed)
    }
}

/// Cost of so many rows, of which this is the mean logarithm of what is left, with the penalties of parameters and order.
fn rank((rows, data): (f64, f64), prior: f64, freedom: usize) -> f64 {
    rows * data + prior + freedom as f64 * rows.ln()
}

/// Fitted families by rank, then the others by what they promised.
fn sort(looked: &mut [RankedFamily]) {
    looked.sort_by(|a, b| match (&a.best, &b.best) {
        (Some(x), Some(y)) => x.rank.total_cmp(&y.rank).then(a.family.cmp(&b.family)),
        (Some(_), None) => std::cmp::Ordering::Less,
        (None, Some(_)) => std::cmp::Ordering::Greater,
        (None, None) => b.screening.total_cmp(&a.screening).then(a.family.cmp(&b.family)),
    });
}

#[cfg(test)]
mod test_support;
#[cfg(test)]
mod tests;

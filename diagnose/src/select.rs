//! Which effects are missing: forward search, backward elimination, rivals of each slot.

use std::sync::atomic::AtomicU64;

use rayon::prelude::*;

use crate::base::Base;
use crate::belief::{self, Sight};
use crate::chain::{Chain, Failed};
use crate::data_set::DataSet;
use crate::fit::{Fit, Fitter, Linear};
use crate::library::{Family, Formula};
use crate::score::{Judge, Judged, explained};

/// Families that are fitted after screening.
const FITTED: usize = 7;
/// The same where an effect is found already.
const FITTED_BESIDE: usize = 5;
/// Families whose best formula is fitted thoroughly.
const REFINED: usize = 4;
/// Factor by which a further effect must cut what is left.
const CUT: f64 = 1.5;
/// The same where nothing is left with it, however small it is.
const CUT_TO_NOISE: f64 = 3.0;
/// Score that the effects together must reach.
const EXPLAINED: f64 = 0.6;
/// Part of the held-out gap's power that the effects together must explain.
const POWER: f64 = 0.5;
/// Weight of the training rows in the rank; the rest is that of the held-out ones.
const TRAINING: f64 = 0.5;
/// Part of the power with which a lower score is enough, and that score.
const MOST: f64 = 0.9;
const SOME: f64 = 0.35;
/// Below both limits by this much, a set of effects is not looked at again.
const HOPELESS: f64 = 0.2;
/// The same where the effect is a line in the spectrum.
const LINES: f64 = 0.92;
/// Least part of the gap's power, or of the score, that each further effect must bring.
const FURTHER: (f64, f64) = (0.08, 0.15);
/// Most members that are exchanged once the search stands.
const MOST_SWAPS: usize = 2;
/// Loss of score below which an effect is dropped again.
const DROPPED: f64 = 0.02;

/// A fitted and judged set of effects.
#[derive(Clone)]
pub(crate) struct Candidate {
    /// The effects: family and formula in the library.
    pub(crate) picks: Vec<(usize, usize)>,
    pub(crate) chain: Chain,
    pub(crate) fit: Fit,
    pub(crate) judged: Judged,
    /// Cost of all rows with the penalty of its order; the least is the best.
    pub(crate) rank: f64,
    /// Coefficients of the effects.
    pub(crate) freedom: usize,
}

/// A family that was looked at in a round.
#[derive(Clone)]
pub(crate) struct Looked {
    pub(crate) family: usize,
    pub(crate) screening: f64,
    /// The best formula, where it was fitted.
    pub(crate) best: Option<Candidate>,
}

/// What the search found.
pub(crate) struct Found {
    /// The re-tuned model.
    pub(crate) base: Candidate,
    /// The model with the effects that are named; the re-tuned model where none is.
    pub(crate) last: Candidate,
    /// For each effect of `last`, all families in its place, best first (the effect itself among them).
    pub(crate) rivals: Vec<Vec<Looked>>,
    /// The families of the first round, best first.
    pub(crate) first: Vec<Looked>,
    /// For each effect of `last`, the part of the held-out gap that comes back without it.
    pub(crate) alone: Vec<f64>,
}

/// The search for one output.
pub(crate) struct Search<'a> {
    pub(crate) base: &'a Base,
    pub(crate) data: &'a DataSet,
    pub(crate) judge: &'a Judge,
    pub(crate) library: &'a [Family],
    pub(crate) sigma: f64,
    /// Mean square over the noise's up to which nothing is left to explain.
    pub(crate) adequate: f64,
    pub(crate) count: &'a AtomicU64,
    pub(crate) max_effects: usize,
}

impl<'a> Search<'a> {
    fn fitter(&self) -> Fitter<'a> {
        Fitter { data: self.data, sigma: self.sigma, count: self.count }
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

    fn candidate(
        &self,
        picks: Vec<(usize, usize)>,
        chain: Chain,
        fit: Fit,
    ) -> Result<Candidate, Failed> {
        let judged = self.judge.judge(&chain, &fit.theta, self.data, self.sigma, self.count)?;
        let records = self.data.records.len();
        let freedom: usize = self.formulas(&picks).iter().map(|f| f.freedom(records)).sum();
        let rows = self.fitter().effective();
        let level = |m: f64| m.max(1e-12).ln();
        // What is learned on the training rows must hold on the others.
        let data = TRAINING * level(fit.mean_square) + (1.0 - TRAINING) * level(judged.held_out);
        let prior: f64 =
            chain.parameters.iter().zip(&fit.theta).map(|(p, q)| p.prior * q * q).sum();
        let rank = rows * data + prior + freedom as f64 * rows.ln();
        Ok(Candidate { picks, chain, fit, judged, rank, freedom })
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
    pub(crate) fn expand(&self, from: &Candidate) -> Result<Vec<Looked>, Failed> {
        let linear = self.fitter().linearise(&from.chain, &from.fit.theta)?;
        let fixed = self.formulas(&from.picks);
        let jobs: Vec<(usize, usize)> = (0..self.library.len())
            .filter(|family| from.picks.iter().all(|(f, _)| f != family))
            .flat_map(|family| (0..self.library[family].formulas.len()).map(move |k| (family, k)))
            .collect();
        let screened: Vec<(f64, Vec<f64>)> =
            jobs.par_iter().map(|job| self.screen(from, &fixed, *job, &linear)).collect();
        let best_of = |family: usize| {
            let own = jobs.iter().zip(&screened).filter(|((f, _), _)| *f == family);
            own.map(|(_, (promise, _))| *promise).fold(f64::NEG_INFINITY, f64::max)
        };
        let mut families: Vec<(usize, f64)> = (0..self.library.len())
            .filter(|family| from.picks.iter().all(|(f, _)| f != family))
            .map(|family| (family, best_of(family)))
            .collect();
        families.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let most = if from.picks.is_empty() { FITTED } else { FITTED_BESIDE };
        let kept: Vec<usize> = families.iter().take(most).map(|(family, _)| *family).collect();
        let to_fit: Vec<usize> = (0..jobs.len())
            .filter(|k| {
                let (family, formula) = jobs[*k];
                let releases = !self.library[family].formulas[formula].releases.is_empty();
                kept.contains(&family) || releases
            })
            .collect();
        let fitted: Vec<Option<Candidate>> = to_fit
            .par_iter()
            .map(|k| self.fit_one(from, &fixed, jobs[*k], &screened[*k].1, &linear).ok())
            .collect();
        let mut looked: Vec<Looked> = families
            .iter()
            .map(|(family, screening)| Looked {
                family: *family,
                screening: *screening,
                best: None,
            })
            .collect();
        for (k, candidate) in to_fit.iter().zip(fitted) {
            let Some(candidate) = candidate else { continue };
            let Some(entry) = looked.iter_mut().find(|l| l.family == jobs[*k].0) else { continue };
            if entry.best.as_ref().is_none_or(|b| candidate.rank < b.rank) {
                entry.best = Some(candidate);
            }
        }
        for entry in &mut looked {
            self.hold_against_null(from, &fixed, entry, &linear);
        }
        sort(&mut looked);
        looked.par_iter_mut().take(REFINED).for_each(|entry| self.refine(entry));
        sort(&mut looked);
        Ok(looked)
    }

    /// Fits the best formula of a family again, with sensitivities of its own.
    fn refine(&self, entry: &mut Looked) {
        let Some(best) = &entry.best else { return };
        let refined = self
            .fitter()
            .fit(&best.chain, &best.fit.theta)
            .and_then(|fit| self.candidate(best.picks.clone(), best.chain.clone(), fit));
        if let Ok(refined) = refined
            && refined.rank < best.rank
        {
            entry.best = Some(refined);
        }
    }

    /// Drops a family whose formula is no better than what it becomes without the effect.
    fn hold_against_null(
        &self,
        from: &Candidate,
        fixed: &[&Formula],
        entry: &mut Looked,
        linear: &Linear,
    ) {
        let (Some(null), Some(best)) = (&self.library[entry.family].null, &entry.best) else {
            return;
        };
        let mut with = fixed.to_vec();
        with.push(null);
        let chain = self.base.compose(&with);
        let theta = self.carry(from, &chain, null, &null.starts[0]);
        let fitted = self.fitter().fit_quickly(&chain, &theta, linear).and_then(|fit| {
            let judged = self.judge.judge(&chain, &fit.theta, self.data, self.sigma, self.count)?;
            Ok((fit.mean_square, judged.held_out))
        });
        if let Ok((training, held_out)) = fitted {
            let own = 0.5 * (best.fit.mean_square + best.judged.held_out);
            if 0.5 * (training + held_out) < 1.1 * own {
                entry.best = None;
            }
        }
    }

    /// First-order promise of a formula and its best start.
    fn screen(
        &self,
        from: &Candidate,
        fixed: &[&Formula],
        (family, number): (usize, usize),
        linear: &Linear,
    ) -> (f64, Vec<f64>) {
        let formula = &self.library[family].formulas[number];
        let mut with = fixed.to_vec();
        with.push(formula);
        let chain = self.base.compose(&with);
        let starts: Vec<Vec<f64>> =
            formula.starts.iter().map(|start| self.carry(from, &chain, formula, start)).collect();
        let promises = self.fitter().promises(&chain, linear, &starts, formula.screened);
        let mut best = (f64::NEG_INFINITY, formula.starts.first().cloned().unwrap_or_default());
        for (promise, start) in promises.into_iter().zip(&formula.starts) {
            if let Some(promise) = promise
                && promise > best.0
            {
                best = (promise, start.clone());
            }
        }
        best
    }

    fn fit_one(
        &self,
        from: &Candidate,
        fixed: &[&Formula],
        (family, number): (usize, usize),
        start: &[f64],
        linear: &Linear,
    ) -> Result<Candidate, Failed> {
        let formula = &self.library[family].formulas[number];
        let mut with = fixed.to_vec();
        with.push(formula);
        let chain = self.base.compose(&with);
        let theta = self.carry(from, &chain, formula, start);
        let fit = self.fitter().fit_quickly(&chain, &theta, linear)?;
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
        let formulas = self.formulas(&picks);
        let chain = self.base.compose(&formulas);
        let values = |pick: &(usize, usize)| {
            let at = from.picks.iter().position(|p| p == pick)?;
            let before: usize =
                self.formulas(&from.picks)[..at].iter().map(|f| f.parameters.len()).sum();
            let first = from.chain.parameters.iter().take_while(|p| p.is_base).count() + before;
            let count = self.formulas(&from.picks)[at].parameters.len();
            Some(from.fit.theta[first..first + count].to_vec())
        };
        let mut theta: Vec<f64> = chain
            .parameters
            .iter()
            .take_while(|p| p.is_base)
            .map(|p| {
                let same = from.chain.parameters.iter().position(|o| o.is_base && o.name == p.name);
                same.map_or(0.0, |k| from.fit.theta[k])
            })
            .collect();
        for pick in &picks {
            theta.extend(values(pick).ok_or(Failed)?);
        }
        let fit = self.fitter().fit(&chain, &theta)?;
        self.candidate(picks, chain, fit)
    }

    /// The whole search.
    pub(crate) fn run(&self, base: Candidate) -> Result<Found, Failed> {
        let mut best = base.clone();
        let mut first = Vec::new();
        let mut rivals: Vec<Vec<Looked>> = Vec::new();
        while best.picks.len() < self.max_effects && has_gap(&best, self.adequate) {
            let looked = self.expand(&best)?;
            if first.is_empty() {
                first.clone_from(&looked);
            }
            let Some(next) = looked.iter().find_map(|l| l.best.clone()) else { break };
            if !self.is_worth_it(&base, &best, &next) {
                break;
            }
            rivals.push(looked);
            best = next;
        }
        // Where even all together explain too little, which of them it is is no question.
        let is_hopeless = self.judge.score(&base.judged, &best.judged) < EXPLAINED - HOPELESS
            && explained(&base.judged, &best.judged) < POWER - HOPELESS;
        if is_hopeless {
            let last = base.clone();
            return Ok(Found { base, last, rivals, first, alone: Vec::new() });
        }
        if best.picks.len() > 1 {
            best = self.reconsider(best, &mut rivals)?;
        }
        best = self.eliminate(&base, best, &mut rivals)?;
        let last = self.believed(&base, best, &mut rivals)?;
        let alone = self.alone(&base, &last)?;
        Ok(Found { base, last, rivals, first, alone })
    }

    /// The effects that can be named: those that explain enough together, without those whose name is
    /// too uncertain.
    fn believed(
        &self,
        base: &Candidate,
        mut best: Candidate,
        rivals: &mut Vec<Vec<Looked>>,
    ) -> Result<Candidate, Failed> {
        loop {
            let power = explained(&base.judged, &best.judged);
            let has_lines = self.formulas(&best.picks).iter().any(|f| f.is_line_of_own());
            // A line that is no multiple of the mains is a disturbance only where it is nearly all.
            let least = if has_lines && best.picks.len() == 1 { LINES } else { POWER };
            let reached = self.judge.score(&base.judged, &best.judged);
            // Nearly all of the power is as good as a good score: bands that nothing in the library
            // reaches do not take a name from what does.
            let is_enough = reached >= EXPLAINED || (power >= MOST && reached >= SOME);
            if best.picks.is_empty() || !is_enough || power < least {
                return Ok(base.clone());
            }
            let sight = self.sight(base);
            let trust = |slot: usize| {
                let family = best.picks[slot].0;
                let beliefs = belief::beliefs(&sight, &rivals[slot], &best);
                belief::trust(self.library, &beliefs, family)
            };
            let worst = (0..best.picks.len())
                .map(|slot| (slot, trust(slot)))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            match worst {
                Some((slot, trust)) if trust < belief::TRUSTED => {
                    if best.picks.len() == 1 {
                        return Ok(base.clone());
                    }
                    best = self.refit_without(&best, slot)?;
                    rivals.remove(slot);
                }
                _ => return Ok(best),
            }
        }
    }

    /// What beliefs are formed from.
    fn sight(&self, base: &Candidate) -> Sight {
        Sight { base_excess: (base.judged.held_out - 1.0).max(0.0), adequate: self.adequate }
    }

    /// Whether one more effect is believed.
    fn is_worth_it(&self, base: &Candidate, before: &Candidate, after: &Candidate) -> bool {
        if after.rank >= before.rank {
            return false;
        }
        let (s0, s1) = (
            self.judge.score(&base.judged, &before.judged),
            self.judge.score(&base.judged, &after.judged),
        );
        let paired = self.judge.paired(&before.judged, &after.judged);
        if before.picks.is_empty() {
            return s1 > 0.2 && paired > 3.0;
        }
        let e0 = explained(&base.judged, &before.judged);
        let e1 = explained(&base.judged, &after.judged);
        // Where nothing is left the two effects are the whole of it, however small the second one is;
        // what only takes a part of what is left may repair another formula of the first.
        let left = |c: &Candidate| (0.5 * (c.judged.training + c.judged.held_out) - 1.0).max(1e-3);
        let cut = left(before) / left(after);
        let is_large = e1 - e0 > FURTHER.0 || s1 - s0 > FURTHER.1;
        let is_whole = !has_gap(after, self.adequate) && cut > CUT_TO_NOISE;
        paired > 4.0 && ((is_large && cut > CUT) || is_whole)
    }

    /// Looks at each slot again with the others in place, and takes what is better there.
    fn reconsider(
        &self,
        mut best: Candidate,
        rivals: &mut Vec<Vec<Looked>>,
    ) -> Result<Candidate, Failed> {
        let mut slot = 0;
        let mut swaps = 0;
        while slot < best.picks.len() {
            let rest = self.refit_without(&best, slot)?;
            let looked = self.expand(&rest)?;
            let top = looked.iter().find_map(|l| l.best.clone());
            match top {
                Some(top) if top.rank < best.rank - 1.0 && swaps < MOST_SWAPS => {
                    // The new member stands last; its list goes with it, and the others are new.
                    rivals.remove(slot);
                    rivals.push(looked);
                    let is_same =
                        top.picks.last().map(|p| p.0) == best.picks.get(slot).map(|p| p.0);
                    (best, swaps) = (top, swaps + 1);
                    if is_same && slot + 1 == best.picks.len() {
                        slot += 1;
                    } else {
                        slot = 0;
                    }
                }
                _ => {
                    rivals[slot] = looked;
                    slot += 1;
                }
            }
        }
        Ok(best)
    }

    /// What goes with each effect, given the others.
    fn alone(&self, base: &Candidate, last: &Candidate) -> Result<Vec<f64>, Failed> {
        let whole = explained(&base.judged, &last.judged);
        (0..last.picks.len())
            .map(|slot| {
                if last.picks.len() == 1 {
                    return Ok(whole.max(0.0));
                }
                let less = self.refit_without(last, slot)?;
                Ok((whole - explained(&base.judged, &less.judged)).max(0.0))
            })
            .collect()
    }

    /// Drops effects that the others can do without.
    fn eliminate(
        &self,
        base: &Candidate,
        mut best: Candidate,
        rivals: &mut Vec<Vec<Looked>>,
    ) -> Result<Candidate, Failed> {
        let mut slot = 0;
        while best.picks.len() > 1 && slot < best.picks.len() {
            let less = self.refit_without(&best, slot)?;
            let loss = self.judge.score(&base.judged, &best.judged)
                - self.judge.score(&base.judged, &less.judged);
            let linear =
                explained(&base.judged, &best.judged) - explained(&base.judged, &less.judged);
            if loss < DROPPED && linear < DROPPED {
                best = less;
                rivals.remove(slot);
                slot = 0;
            } else {
                slot += 1;
            }
        }
        Ok(best)
    }
}

/// Whether something is left to explain.
pub(crate) fn has_gap(candidate: &Candidate, adequate: f64) -> bool {
    candidate.judged.held_out.max(candidate.judged.training) > adequate
}

/// Fitted families by rank, then the others by what they promised.
fn sort(looked: &mut [Looked]) {
    looked.sort_by(|a, b| match (&a.best, &b.best) {
        (Some(x), Some(y)) => x.rank.total_cmp(&y.rank).then(a.family.cmp(&b.family)),
        (Some(_), None) => std::cmp::Ordering::Less,
        (None, Some(_)) => std::cmp::Ordering::Greater,
        (None, None) => b.screening.total_cmp(&a.screening).then(a.family.cmp(&b.family)),
    });
}

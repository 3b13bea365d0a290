//! Which effects are believed: forward search, backward elimination, rivals of each slot.

use std::ops::Range;

use rayon::prelude::*;

use super::{Search, rank};
use crate::belief::{self, BeliefContext};
use crate::candidate::{Candidate, Found, RankedFamily, are_several_in_faint_gap, has_gap};
use crate::causal;
use crate::error::Failed;
use crate::fit::Fitter;
use crate::score::{explained, mean_square};
use crate::thresholds::belief::Thresholds;
use crate::thresholds::search;

/// What is left over the noise's power, on training and held-out rows alike.
fn left(c: &Candidate) -> f64 {
    (0.5 * (c.judged.training + c.judged.held_out) - 1.0).max(1e-3)
}

impl Search<'_> {
    /// The whole search.
    pub(crate) fn run(&self, base: Candidate) -> Result<Found, Failed> {
        let mut best = base.clone();
        let mut first = Vec::new();
        let mut rivals: Vec<Vec<RankedFamily>> = Vec::new();
        let mut beyond = None;
        while best.picks.len() < self.max_effects && has_gap(&best, self.adequate) {
            // Without a first one nothing can be said; a further one that cannot be simulated ends no diagnosis.
            let looked = match self.expand(&best) {
                Ok(looked) => looked,
                Err(failed) if best.picks.is_empty() => return Err(failed),
                Err(_) => break,
            };
            if first.is_empty() {
                first.clone_from(&looked);
            }
            let Some(next) = looked.iter().find_map(|l| l.best.clone()) else { break };
            let next = self.away(&base, self.with_best_formulas(next));
            if !self.is_worth_it(&base, &best, &next) {
                beyond = Some(next);
                break;
            }
            rivals.push(looked);
            best = next;
        }
        if best.picks.len() == 1 && self.max_effects > 1 && has_gap(&best, self.adequate) {
            best = self.pair_beside_rivals(&base, best, &first, &mut rivals);
        }
        let mut is_last_resort = false;
        if self.max_effects > 1
            && !self.explains_enough(&base, &best)
            && let Some(pair) = self.pair_as_last_resort(&base, &best, &first, &mut rivals)
        {
            (best, is_last_resort) = (pair, true);
        }
        if self.is_hopeless(&base, &best) {
            return Ok(Found { rivals, first, ..Found::nothing(base) });
        }
        if best.picks.len() > 1 {
            best = self.reconsider(best, &mut rivals);
        }
        let has_several = best.picks.len() > 1 && !is_last_resort;
        best = self.eliminate(&base, best, &mut rivals);
        // A pair that was tried makes no answer of what was none alone.
        if is_last_resort && best.picks.len() == 1 {
            best = base.clone();
        }
        let last = self.believed(&base, best, &mut rivals);
        let (mut last, mut alone) = self.likely(&base, last, &mut rivals);
        let mut faint = Vec::new();
        if self.reading_is_known && are_several_in_faint_gap(&base, &last) {
            (faint, last, alone) = (last.picks, base.clone(), Vec::new());
        }
        if last.picks.is_empty() && has_several {
            (last, alone) = self.first_alone(&base, &first, &mut rivals);
        }
        if let ([_], [looked]) = (&last.picks[..], &mut rivals[..]) {
            self.hold_against_all_rows(&base, &last, looked);
        }
        let goes_on = |next: &Candidate| {
            !last.picks.is_empty()
                && next.picks.len() == last.picks.len() + 1
                && last.picks.iter().all(|pick| next.picks.contains(pick))
        };
        Ok(Found { beyond: beyond.filter(goes_on), base, last, rivals, first, alone, faint })
    }

    /// Whether rivals that fit the fitted rows as well as `own`, and are excluded by the held-out rows alone, are excluded by
    /// all rows: parameters that few rows do not determine predict nothing.
    fn hold_against_all_rows(
        &self,
        base: &Candidate,
        own: &Candidate,
        looked: &mut [RankedFamily],
    ) {
        let is_open = |c: &Candidate| {
            c.picks.len() == 1
                && c.picks[0].0 != own.picks[0].0
                && !c.chain.is_costly()
                && c.training < Thresholds::ALIKE * own.training
                && c.judged.held_out > own.judged.held_out
        };
        let mut open: Vec<&mut Candidate> = looked
            .iter_mut()
            .filter_map(|l| l.best.as_mut().filter(|c| is_open(c)))
            .take(Thresholds::RIVALS_OPEN)
            .collect();
        if open.is_empty() {
            return;
        }
        let Some(complete) = self.data.with_all_rows() else { return };
        let fitter = Fitter { data: &complete, ..self.fitter() };
        let (rows, sight) = (fitter.effective(), self.sight(base));
        let over_all = |c: &Candidate| {
            let fit = fitter.fit_again(&c.chain, &c.fit.theta).ok()?;
            let level = fit.mean_square.max(1e-12).ln();
            Some((fit.mean_square, rank((rows, level), c.chain.prior(&fit.theta), c.freedom)))
        };
        let Some((left, of_own)) = over_all(own) else { return };
        open.par_iter_mut().with_max_len(1).for_each(|c| {
            if let Some((rival, of_rival)) = over_all(c) {
                c.against = belief::against(&sight, rival, left, of_rival - of_own)
                    + Thresholds::NOT_PREDICTED * self.not_predicted(c, own).max(1) as f64;
            }
        });
    }

    /// Records whose held-out rows a rival predicts worse.
    fn not_predicted(&self, rival: &Candidate, own: &Candidate) -> usize {
        let is_worse = |rows: &Range<usize>| {
            let left = |c: &Candidate| mean_square(&c.judged.residual[rows.clone()]);
            left(rival) > Thresholds::ALIKE * left(own)
        };
        self.judge.stretches.iter().filter(|rows| is_worse(rows)).count()
    }

    /// The best single effect as if no other had been looked for beside it: several that cannot be named
    /// together take no name from the one that can be named alone.
    fn first_alone(
        &self,
        base: &Candidate,
        first: &[RankedFamily],
        rivals: &mut Vec<Vec<RankedFamily>>,
    ) -> (Candidate, Vec<f64>) {
        let nothing = (base.clone(), Vec::new());
        let Some(single) = first.iter().find_map(|l| l.best.clone()) else { return nothing };
        if !self.is_worth_it(base, base, &single) || self.is_hopeless(base, &single) {
            return nothing;
        }
        *rivals = vec![first.to_vec()];
        let last = self.believed(base, single, rivals);
        self.likely(base, last, rivals)
    }

    /// The effects without those that are less likely effects than repairs of the others' formulas, and
    /// what goes with each.
    fn likely(
        &self,
        base: &Candidate,
        mut best: Candidate,
        rivals: &mut Vec<Vec<RankedFamily>>,
    ) -> (Candidate, Vec<f64>) {
        loop {
            let alone = self.alone(base, &best);
            if best.picks.len() < 2 {
                return (best, alone);
            }
            let sight = self.sight(base);
            let is_effect = |slot: usize| belief::is_effect(&sight, &best, alone[slot]);
            let all = (0..best.picks.len()).map(|slot| (slot, is_effect(slot)));
            match all.min_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((slot, is_effect)) if is_effect < Thresholds::LIKELY => {
                    let Ok(less) = self.refit_without(&best, slot) else {
                        return (base.clone(), Vec::new());
                    };
                    rivals.remove(slot);
                    best = self.believed(base, less, rivals);
                }
                _ => return (best, alone),
            }
        }
    }

    /// The last effect beside the others in the formulas that suit it best: a formula that was the best
    /// alone imitated a part of what is now explained.
    fn with_best_formulas(&self, mut best: Candidate) -> Candidate {
        for slot in 0..best.picks.len().saturating_sub(1) {
            if !has_gap(&best, self.adequate) {
                break;
            }
            if let Ok(Some(other)) = self.with_another_formula(&best, slot) {
                best = other;
            }
        }
        best
    }

    /// A pair whose first member is not the best single effect: a formula that imitates both, as a lag
    /// does a delay beside something else, leaves no room for the second.
    fn pair_beside_rivals(
        &self,
        base: &Candidate,
        single: Candidate,
        first: &[RankedFamily],
        rivals: &mut Vec<Vec<RankedFamily>>,
    ) -> Candidate {
        let mut best = single.clone();
        // A formula that leaves much imitates nothing: what is missing may be in no library.
        if explained(&base.judged, &single.judged) < Thresholds::CLEAR {
            return best;
        }
        let others = first.iter().filter_map(|l| l.best.as_ref());
        let most = Thresholds::PAIR_NEAR * left(&single);
        let others = others.filter(|c| c.picks[0].0 != single.picks[0].0 && left(c) < most);
        for other in others.take(Thresholds::PAIR_RIVALS) {
            let Ok(looked) = self.expand(other) else { continue };
            let Some(pair) = looked.iter().find_map(|l| l.best.clone()) else { continue };
            if pair.rank < best.rank && self.is_worth_it(base, &single, &pair) {
                best = pair;
                *rivals = vec![first.to_vec(), looked];
            }
        }
        best
    }

    /// The last resort where what was found explains too little: a pair that leaves next to nothing, of which
    /// neither member stands out alone.
    fn pair_as_last_resort(
        &self,
        base: &Candidate,
        found: &Candidate,
        first: &[RankedFamily],
        rivals: &mut Vec<Vec<RankedFamily>>,
    ) -> Option<Candidate> {
        let fitted = first.iter().filter_map(|l| l.best.as_ref());
        // The search went on from the best one.
        let others = fitted.filter(|c| found.picks.first() != c.picks.first());
        let little = Thresholds::NEARLY_NOISE.max(Thresholds::NEARLY_NOTHING * left(base));
        for other in others.take(Thresholds::PAIR_RIVALS) {
            let promised = self.expand_where(other, 1.0 + Thresholds::OUT_OF_REACH * little);
            let Ok(looked) = promised else { continue };
            let Some(pair) = looked.iter().find_map(|l| l.best.clone()) else { continue };
            let pair = self.with_best_formulas(pair);
            if pair.rank < found.rank && left(&pair) < little {
                *rivals = vec![first.to_vec(), looked];
                return Some(pair);
            }
        }
        None
    }

    /// The effects that can be named: those that explain enough together, without those whose name is
    /// too uncertain.
    fn believed(
        &self,
        base: &Candidate,
        mut best: Candidate,
        rivals: &mut Vec<Vec<RankedFamily>>,
    ) -> Candidate {
        let caused = causal::left_by(&best, self.data, self.sigma);
        loop {
            let sight = self.sight(base).with_left(&best, caused);
            if best.picks.is_empty() || !self.explains_enough(base, &best) {
                return base.clone();
            }
            best = self.most_probable(&sight, rivals, best);
            let trust = |slot: usize| {
                let family = best.picks[slot].0;
                if self.reading_is_known && best.imitates(self.library, slot) {
                    return 0.0;
                }
                if best.picks.len() > 1 {
                    let beliefs = belief::beliefs(&sight, &rivals[slot], &best);
                    return belief::trust(self.library, &beliefs, family);
                }
                // Those that leave alike stand in the set together, and what the best of them leaves says
                // whether it is one of them.
                let fitted = rivals[slot].iter().filter_map(|l| l.best.as_ref());
                let alone = fitted.filter(|c| c.picks.len() == 1);
                let top = alone.min_by(|a, b| a.rank.total_cmp(&b.rank)).unwrap_or(&best);
                let beliefs = belief::beliefs(&sight, &rivals[slot], top);
                belief::trust_of_alike(self.library, &beliefs, family)
            };
            let worst = (0..best.picks.len())
                .map(|slot| (slot, trust(slot)))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let is_clear = worst.is_some_and(|(_, trust)| trust >= Thresholds::OF_CLEAR_NAMES)
                && explained(&base.judged, &best.judged) >= Thresholds::POWER_CLEAR;
            let is_known =
                is_clear || belief::formula_is_known(&sight, &best) >= Thresholds::OF_SEVERAL;
            if best.picks.len() > 1 && !is_known {
                return base.clone();
            }
            match worst {
                Some((slot, trust)) if trust < Thresholds::TRUSTED => {
                    if best.picks.len() == 1 {
                        return base.clone();
                    }
                    let Ok(less) = self.refit_without(&best, slot) else { return base.clone() };
                    best = less;
                    rivals.remove(slot);
                }
                _ => return best,
            }
        }
    }

    /// Where even all together explain too little, which of them it is is no question.
    fn is_hopeless(&self, base: &Candidate, best: &Candidate) -> bool {
        !self.is_fitted_well(base, best)
            && self.judge.score(&base.judged, &best.judged)
                < Thresholds::SCORE - Thresholds::HOPELESS
            && explained(&base.judged, &best.judged) < Thresholds::POWER - Thresholds::HOPELESS
    }

    /// Whether the effects together explain so much that they can be named.
    fn explains_enough(&self, base: &Candidate, best: &Candidate) -> bool {
        let power = explained(&base.judged, &best.judged);
        let has_own = self.formulas(&best.picks).iter().any(|f| f.is_of_its_own());
        // A line that is no multiple of the mains, or a course without a formula, is a disturbance only where it is
        // nearly all.
        let is_of_group =
            |(family, _): &(usize, usize)| self.library[*family].effect.group.is_some();
        // The right formula leaves little more than the noise of a faint gap. Within a group the formulas are alike.
        let leaves_little =
            base.judged.held_out < Thresholds::FAINT && !best.picks.iter().any(is_of_group);
        let least = if (has_own && best.picks.len() == 1) || leaves_little {
            Thresholds::POWER_OF_OWN
        } else {
            Thresholds::POWER
        };
        let reached = self.judge.score(&base.judged, &best.judged);
        // Nearly all of the power is as good as a good score: bands that nothing in the library
        // reaches do not take a name from what does.
        let is_enough = reached >= Thresholds::SCORE
            || (power >= Thresholds::POWER_CLEAR && reached >= Thresholds::SCORE_WITH_POWER);
        // Bands in which a faint gap is near the noise take no name from what leaves nothing.
        let is_all = !has_gap(best, self.adequate);
        ((is_enough || is_all) && power >= least) || self.is_fitted_well(base, best)
    }

    /// Whether the rows that are held out do not show the gap and the fitted ones do, nearly all of it goes
    /// there with few coefficients, and nothing is lost on the others. An effect that only acts on the
    /// largest or fastest commands needs no second record of them.
    fn is_fitted_well(&self, base: &Candidate, with: &Candidate) -> bool {
        let (before, after) = (&base.judged, &with.judged);
        let is_seen_there = before.held_out <= self.adequate && before.training > self.adequate;
        let gone = 1.0 - (after.training - 1.0).max(0.0) / (before.training - 1.0).max(0.1);
        let is_plain = with.freedom <= Thresholds::FITTED_WELL.1 * with.picks.len()
            && self.formulas(&with.picks).iter().all(|f| f.nuisance.is_none());
        is_seen_there
            && is_plain
            && gone >= Thresholds::FITTED_WELL.0
            && after.held_out <= before.held_out
    }

    /// What beliefs are formed from.
    pub(super) fn sight(&self, base: &Candidate) -> BeliefContext<'_> {
        BeliefContext::new(self.library, base, self.adequate, self.fine)
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
            // Most of the power on rows that no fit has seen needs no count of blocks: few steps may
            // be all that shows the effect.
            let power = explained(&base.judged, &after.judged);
            let is_clear = (s1 >= Thresholds::SCORE && power >= Thresholds::CLEAR)
                || (s1 >= Thresholds::SCORE_WITH_POWER
                    && power >= Thresholds::POWER_CLEAR
                    && paired > Thresholds::BLOCKS_WITH_POWER);
            return (s1 > Thresholds::FIRST.0 && paired > Thresholds::FIRST.1)
                || is_clear
                || self.is_fitted_well(base, after);
        }
        let e0 = explained(&base.judged, &before.judged);
        let e1 = explained(&base.judged, &after.judged);
        // Where nothing is left the two effects are the whole of it, however small the second one is;
        // what only takes a part of what is left may repair another formula of the first.
        let cut = left(before) / left(after);
        let is_large = e1 - e0 > Thresholds::FURTHER.0 || s1 - s0 > Thresholds::FURTHER.1;
        let leaves_nothing = !has_gap(after, self.adequate) && cut > Thresholds::CUT_TO_NOISE;
        // Nor does that need a count of blocks where it is most of what was left.
        let is_clear =
            leaves_nothing && explained(&before.judged, &after.judged) >= Thresholds::CLEAR;
        let is_sharp = cut > Thresholds::CUT_SHARPLY && left(after) < Thresholds::NEARLY_NOISE;
        let is_rest = before.picks.len() > 1
            && cut > Thresholds::CUT_TO_NOISE
            && explained(&before.judged, &after.judged) >= Thresholds::THIRD_TAKES;
        is_clear
            || (paired > Thresholds::BLOCKS_FURTHER
                && ((is_large && cut > Thresholds::CUT) || leaves_nothing || is_sharp || is_rest))
    }

    /// Looks at each slot again with the others in place, and takes what is better there.
    fn reconsider(&self, mut best: Candidate, rivals: &mut Vec<Vec<RankedFamily>>) -> Candidate {
        let mut slot = 0;
        let mut swaps = 0;
        while slot < best.picks.len() {
            let rest = self.refit_without(&best, slot);
            let Ok(looked) = rest.and_then(|rest| self.expand(&rest)) else {
                slot += 1;
                continue;
            };
            let top = looked.iter().find_map(|l| l.best.clone());
            match top {
                Some(top)
                    if top.rank < best.rank - search::Thresholds::RANK_BETTER
                        && swaps < Thresholds::MOST_SWAPS =>
                {
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
        best
    }

    /// What goes with each effect, given the others.
    pub(super) fn alone(&self, base: &Candidate, last: &Candidate) -> Vec<f64> {
        let complete = explained(&base.judged, &last.judged);
        let part = |slot: usize| {
            if last.picks.len() == 1 {
                return complete.max(0.0);
            }
            // What cannot be simulated without it explains nothing without it.
            let less = self.refit_without(last, slot);
            let rest = less.map_or(0.0, |less| explained(&base.judged, &less.judged));
            (complete - rest).max(0.0)
        };
        (0..last.picks.len()).map(part).collect()
    }

    /// Drops effects that the others can do without.
    fn eliminate(
        &self,
        base: &Candidate,
        mut best: Candidate,
        rivals: &mut Vec<Vec<RankedFamily>>,
    ) -> Candidate {
        let mut slot = 0;
        while best.picks.len() > 1 && slot < best.picks.len() {
            let Ok(less) = self.refit_without(&best, slot) else {
                slot += 1;
                continue;
            };
            let loss = self.judge.score(&base.judged, &best.judged)
                - self.judge.score(&base.judged, &less.judged);
            let power = |c: &Candidate| explained(&base.judged, &c.judged);
            if loss < Thresholds::DROPPED && power(&best) - power(&less) < Thresholds::DROPPED {
                best = less;
                rivals.remove(slot);
                slot = 0;
            } else {
                slot += 1;
            }
        }
        best
    }
}

#[cfg(test)]
mod search_tests;
#[cfg(test)]
mod tests;

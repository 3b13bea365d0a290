//! Other formulas for an effect that stands.

use rayon::prelude::*;

use super::Search;
use super::memo::Part;
use crate::candidate::{Candidate, RankedFamily};
use crate::error::Failed;
use crate::thresholds::fit::Thresholds;
use crate::thresholds::search;

impl Search<'_> {
    /// These effects with the best other formula of the family of effect `slot`, where that is better.
    pub(crate) fn with_another_formula(
        &self,
        from: &Candidate,
        slot: usize,
    ) -> Result<Option<Candidate>, Failed> {
        let gave = self.once(Part::Formula(slot), from, || {
            let other = self.with_another_formula_anew(from, slot)?;
            let looked =
                |best| RankedFamily { family: 0, screening: 0.0, best: Some(best), why: None };
            Ok(other.into_iter().map(looked).collect())
        })?;
        Ok(gave.into_iter().find_map(|looked| looked.best))
    }

    fn with_another_formula_anew(
        &self,
        from: &Candidate,
        slot: usize,
    ) -> Result<Option<Candidate>, Failed> {
        let (family, own) = from.picks[slot];
        let formulas = &self.library[family].formulas;
        let others: Vec<usize> =
            (0..formulas.len()).filter(|k| *k != own && !formulas[*k].is_stand_in).collect();
        if others.is_empty() {
            return Ok(None);
        }
        // The others as they are beside it: alone they would take its part, and not find back.
        let mut rest = from.clone();
        rest.picks.remove(slot);
        (rest.chain, rest.fit.theta) = self.carried(from, &rest.picks)?;
        let fixed = self.formulas(&rest.picks);
        let linear = self.fitter().linearise(&rest.chain, &rest.fit.theta)?;
        let fitted = others.par_iter().with_max_len(1).map(|k| {
            let (_, start) = self.screen(&rest, &fixed, (family, *k), &linear, &[]);
            self.fit_one(&rest, &fixed, ((family, *k), &start, true), &linear).ok()
        });
        let fitted: Vec<Option<Candidate>> = fitted.collect();
        let best = fitted.into_iter().flatten().min_by(|a, b| a.rank.total_cmp(&b.rank));
        let Some(best) = best else { return Ok(None) };
        // What leaves far more is not fitted to its end where that is costly.
        if best.chain.is_costly() && best.fit.mean_square > Thresholds::FAR * from.fit.mean_square {
            return Ok(None);
        }
        let mut picks = from.picks.clone();
        picks[slot] = *best.picks.last().unwrap_or(&picks[slot]);
        let better = self
            .refit(&best, picks)
            .ok()
            .filter(|c| c.rank < from.rank - search::Thresholds::RANK_BETTER);
        Ok(better)
    }

    /// These effects with another formula (number `number` of its family) for the effect `slot`.
    pub(crate) fn exchange(
        &self,
        from: &Candidate,
        slot: usize,
        number: usize,
    ) -> Result<Candidate, Failed> {
        let job = (from.picks[slot].0, number);
        let rest = self.refit_without(from, slot)?;
        let fixed = self.formulas(&rest.picks);
        let linear = self.fitter().linearise(&rest.chain, &rest.fit.theta)?;
        let (_, start) = self.screen(&rest, &fixed, job, &linear, &[]);
        let quick = self.fit_one(&rest, &fixed, (job, &start, true), &linear)?;
        let fit = self.fitter().fit(&quick.chain, &quick.fit.theta)?;
        self.candidate(quick.picks, quick.chain, fit)
    }
}

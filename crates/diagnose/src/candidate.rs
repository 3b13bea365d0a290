//! Sets of effects, fitted and judged, and what is found with them.

use std::ops::Range;

use crate::base::Base;
use crate::base::compose::LATE;
use crate::chain::Chain;
use crate::fit::Fit;
use crate::formula::Family;
use crate::score::Judged;
use crate::thresholds::belief::Thresholds;
use crate::thresholds::search;

/// A fitted and judged set of effects.
#[derive(Clone)]
pub(crate) struct Candidate {
    /// The effects: family and formula in the library.
    pub(crate) picks: Vec<(usize, usize)>,
    pub(crate) chain: Chain,
    pub(crate) fit: Fit,
    pub(crate) judged: Judged,
    /// Mean square of the fit with what its nuisances take of the noise.
    pub(crate) training: f64,
    /// Cost of all rows with the penalty of its order; the least is the best.
    pub(crate) rank: f64,
    /// Coefficients of the effects.
    pub(crate) freedom: usize,
    /// Logarithm of the odds against it beside the effect that is named, where both are fitted to all rows; infinite
    /// where that was not looked at.
    pub(crate) against: f64,
}

impl Candidate {
    /// Seconds by which each reading is late within its row, where the model's readings may be.
    pub(crate) fn late(&self) -> Option<f64> {
        self.chain.own(LATE).map(|k| self.chain.parameters[k].value(self.fit.theta[k]))
    }

    /// Places of the parameters of effect number `slot` in the chain.
    pub(crate) fn own(&self, library: &[Family], slot: usize) -> Range<usize> {
        let count = |(family, k): (usize, usize)| library[family].formulas[k].parameters.len();
        let base = self.chain.parameters.iter().take_while(|p| p.is_base).count();
        let first = base + self.picks[..slot].iter().map(|pick| count(*pick)).sum::<usize>();
        first..first + count(self.picks[slot])
    }

    /// By how much the name of effect number `slot` is less likely as it imitates another.
    pub(crate) fn doubt(&self, library: &[Family], slot: usize) -> f64 {
        if self.imitates(library, slot) { Thresholds::AT_BOUND } else { 1.0 }
    }

    /// Whether the formula of effect number `slot` imitates another effect: its fit ends at a bound of the effect.
    pub(crate) fn imitates(&self, library: &[Family], slot: usize) -> bool {
        let (family, k) = self.picks[slot];
        let is_at_bound = |at: usize| !self.chain.parameters[at].is_inside(self.fit.theta[at]);
        library[family].formulas[k].ends_inside && self.own(library, slot).any(is_at_bound)
    }
}

/// A family that was looked at in a round.
#[derive(Clone)]
pub(crate) struct RankedFamily {
    pub(crate) family: usize,
    pub(crate) screening: f64,
    /// The best formula, where it was fitted.
    pub(crate) best: Option<Candidate>,
    /// Why there is none.
    pub(crate) why: Option<Why>,
}

/// Why a family that was screened has no formula in the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Why {
    /// Others promised more.
    Screened,
    /// None of its formulas could be simulated.
    Failed,
    /// What it becomes without the effect, or another gain of the output, explains as much.
    AsNull,
    /// Its fit ends at a bound.
    AtBound,
}

impl Why {
    /// In words.
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Screened => "not fitted: others promised more",
            Self::Failed => "its formulas could not be simulated beside the model",
            Self::AsNull => "explains no more than without the effect or than another gain",
            Self::AtBound => "not named: its fit ends at a bound of what the effect can be",
        }
    }
}

/// What the search found.
pub(crate) struct Found {
    /// The re-tuned model.
    pub(crate) base: Candidate,
    /// The model with the effects that are named; the re-tuned model where none is.
    pub(crate) last: Candidate,
    /// For each effect of `last`, all families in its place, best first (the effect itself among them).
    pub(crate) rivals: Vec<Vec<RankedFamily>>,
    /// The families of the first round, best first.
    pub(crate) first: Vec<RankedFamily>,
    /// For each effect of `last`, the part of the held-out gap that comes back without it.
    pub(crate) alone: Vec<f64>,
    /// The effects of `last` with the best further one, which is not named.
    pub(crate) beyond: Option<Candidate>,
    /// Several effects that explain a faint gap together, which are not named.
    pub(crate) faint: Vec<(usize, usize)>,
}

impl Found {
    /// Where nothing is looked for.
    pub(crate) fn nothing(base: Candidate) -> Self {
        let last = base.clone();
        let (rivals, first, alone, faint) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { base, last, rivals, first, alone, beyond: None, faint }
    }

    /// Changes all candidates that were fitted.
    pub(crate) fn each(&mut self, mut change: impl FnMut(&mut Candidate)) {
        change(&mut self.base);
        change(&mut self.last);
        let looked = self.rivals.iter_mut().flatten().chain(&mut self.first);
        let fitted = looked.filter_map(|l| l.best.as_mut());
        fitted.chain(&mut self.beyond).for_each(change);
    }
}

/// Whether something is left to explain. Without an effect one record is enough to show it, as far as slow noise does not
/// differ from record to record: the effect may not come again in the others, as a drift, or not be driven there.
pub(crate) fn has_gap(candidate: &Candidate, adequate: f64) -> bool {
    let Judged { held_out, training, records, .. } = &candidate.judged;
    let of_record = 1.0 + search::Thresholds::RECORD_ALONE * (adequate - 1.0);
    let is_shown_by_one = candidate.picks.is_empty() && records.iter().any(|r| *r > of_record);
    held_out.max(*training) > adequate || is_shown_by_one
}

/// Whether there are several effects in a gap that is so small over the noise that a second one cannot be told from what
/// the formula of a first one leaves.
pub(crate) fn are_several_in_faint_gap(base: &Candidate, with: &Candidate) -> bool {
    let gap = base.judged.held_out.max(base.judged.training);
    with.picks.len() > 1 && gap < Thresholds::FAINT
}

/// The chain of a model with a set of effects of which all are in `from`, with its values.
pub(crate) fn carried(
    (base, library): (&Base, &[Family]),
    from: &Candidate,
    picks: &[(usize, usize)],
) -> Option<(Chain, Vec<f64>)> {
    let formula = |(family, number): &(usize, usize)| &library[*family].formulas[*number];
    let chain = base.compose(&picks.iter().map(formula).collect::<Vec<_>>());
    let values = |pick: &(usize, usize)| {
        let slot = from.picks.iter().position(|p| p == pick)?;
        from.fit.theta.get(from.own(library, slot))
    };
    let of_base = chain
        .parameters
        .iter()
        .take_while(|p| p.is_base)
        .map(|p| from.chain.own(&p.name).map_or(0.0, |k| from.fit.theta[k]));
    let mut theta: Vec<f64> = of_base.collect();
    for pick in picks {
        theta.extend(values(pick)?);
    }
    Some((chain, theta))
}

//! A set of effects, fitted and judged.

use std::ops::Range;

use crate::base::compose::LATE;
use crate::chain::Chain;
use crate::fit::Fit;
use crate::formula::Family;
use crate::score::Judged;
use crate::thresholds::belief::Thresholds;

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
        let mut all = self.chain.parameters.iter().zip(&self.fit.theta);
        all.find(|(p, _)| p.is_base && p.name == LATE).map(|(p, q)| p.value(*q))
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

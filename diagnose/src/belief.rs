//! How sure a name is: probabilities of rivals, and of none of them.

use crate::library::Family;
use crate::outcome::Outcome;
use crate::select::{Candidate, Looked};

/// Probability that the set must reach.
pub(crate) const SET: f64 = 0.95;

/// How much the odds of a rival fall with what it leaves: odds = times^−SHARPNESS.
const SHARPNESS: f64 = 3.0;
/// How much the logarithm of the odds falls with each coefficient more, among those that leave alike: a
/// formula that can imitate many others says little when it fits no better.
const ORDER: f64 = 1.2;
/// Formulas leave alike up to this factor.
const ALIKE: f64 = 1.25;
/// Share below which neither the name nor its group is given.
pub(crate) const TRUSTED: f64 = 0.5;
/// Probability that the cause is in the library below which no name is given.
const KNOWN: f64 = 0.5;
/// Probability that the cause is in the library where nothing is left.
const LIBRARY: f64 = 0.985;
/// Part of the gap that is left where the cause is as likely in the library as not, and how fast that
/// changes; from the benchmark.
const LEFT_OF_UNKNOWN: f64 = 0.12;
const STEEPNESS: f64 = 1.2;
/// Excess over the noise that is told from none.
const SEEN: f64 = 0.02;

/// One name for a slot.
#[derive(Clone, Debug)]
pub(crate) struct Belief {
    pub(crate) family: usize,
    pub(crate) probability: f64,
}

/// What beliefs are formed from beside the candidates.
#[derive(Clone, Copy)]
pub(crate) struct Sight {
    /// Held-out mean square of the re-tuned model over the noise's, less 1.
    pub(crate) base_excess: f64,
    /// Mean square over the noise's up to which nothing is left.
    pub(crate) adequate: f64,
}

impl Sight {
    /// With this re-tuned model.
    pub(crate) fn new(base: &Candidate, adequate: f64) -> Self {
        Self { base_excess: (base.judged.held_out - 1.0).max(0.0), adequate }
    }

    pub(crate) fn of(outcome: &Outcome) -> Self {
        Self::new(&outcome.found.base, outcome.adequate)
    }
}

/// Probabilities of the families for one slot, largest first; the rest to 1 is 'none of these'.
pub(crate) fn beliefs(sight: &Sight, looked: &[Looked], own: &Candidate) -> Vec<Belief> {
    let fitted: Vec<(usize, &Candidate)> =
        looked.iter().filter_map(|l| Some((l.family, l.best.as_ref()?))).collect();
    let Some(best) = fitted.iter().map(|(_, c)| *c).min_by(|a, b| a.rank.total_cmp(&b.rank)) else {
        return Vec::new();
    };
    let times = |c: &Candidate| ((excess(c) + SEEN) / (excess(best) + SEEN)).max(1.0);
    let simplest =
        fitted.iter().filter(|(_, c)| times(c) < ALIKE).map(|(_, c)| c.freedom).min().unwrap_or(0);
    let weights: Vec<f64> = fitted
        .iter()
        .map(|(_, c)| {
            // The right name leaves a small part of the gap where its formula is not the machine's: what
            // counts is how many times more a rival leaves, as far as the noise lets one see it.
            let nominal = 0.5 * (c.rank - best.rank).max(0.0);
            let order = if times(c) < ALIKE { ORDER * (c.freedom - simplest) as f64 } else { 0.0 };
            (-(SHARPNESS * times(c).ln()).min(nominal) - order).exp()
        })
        .collect();
    let total: f64 = weights.iter().sum();
    let known = known(sight, own);
    let mut all: Vec<Belief> = fitted
        .iter()
        .zip(weights)
        .map(|((family, _), w)| Belief { family: *family, probability: known * w / total })
        .collect();
    all.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.family.cmp(&b.family)));
    all
}

/// What is left over the noise's power, on training and held-out rows alike.
fn excess(c: &Candidate) -> f64 {
    (0.5 * (c.fit.mean_square + c.judged.held_out) - 1.0).max(0.0)
}

/// Probability that the cause is in the library at all: the more is left over what the noise alone may
/// leave, and the larger a part of the gap that is, the less.
fn known(sight: &Sight, own: &Candidate) -> f64 {
    let left = (excess(own) - (sight.adequate - 1.0)).max(0.0) / sight.base_excess.max(0.1);
    LIBRARY / (1.0 + (left / LEFT_OF_UNKNOWN).powf(STEEPNESS))
}

/// How far a name can be trusted: its share among the candidates, or that of its group where the group
/// is what the data can tell; 0 where the cause is most likely none of them.
pub(crate) fn trust(library: &[Family], beliefs: &[Belief], family: usize) -> f64 {
    let known: f64 = beliefs.iter().map(|b| b.probability).sum();
    if known < KNOWN {
        return 0.0;
    }
    let group = library[family].effect.group;
    let is_with = |b: &&Belief| {
        b.family == family || (group.is_some() && library[b.family].effect.group == group)
    };
    beliefs.iter().filter(is_with).map(|b| b.probability).sum::<f64>() / known
}

/// The smallest set of names that reaches 0.95 of what is known, most probable first.
pub(crate) fn set(beliefs: &[Belief]) -> Vec<usize> {
    let known: f64 = beliefs.iter().map(|b| b.probability).sum();
    let mut sum = 0.0;
    let mut set = Vec::new();
    for belief in beliefs {
        set.push(belief.family);
        sum += belief.probability;
        if sum >= SET * known {
            break;
        }
    }
    set
}

#[cfg(test)]
mod tests;

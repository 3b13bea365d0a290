//! How sure a name is: probabilities of rivals, and of none of them.

use crate::library::Family;
use crate::outcome::Outcome;
use crate::select::{Candidate, Looked};

/// Probability that the set must reach.
pub(crate) const SET: f64 = 0.95;

/// How much the odds of a rival fall with what it leaves: odds = times^−SHARPNESS. From the benchmark: with 3, names
/// of 30 to 70 % were right in 86 of 89 cases whose effect was in the library.
const SHARPNESS: f64 = 6.0;
/// How much the logarithm of the odds falls with each coefficient more, among those that leave alike: a
/// formula that can imitate many others says little when it fits no better.
const ORDER: f64 = 1.6;
/// Formulas leave alike up to this factor.
const ALIKE: f64 = 1.25;
/// Trust below which neither the name nor its group is given.
pub(crate) const TRUSTED: f64 = 0.5;
/// Probability that the cause is in the library where nothing is left; from the benchmark.
const LIBRARY: f64 = 0.97;
/// The same where the name is one of a group: what looks like the others of its group in a log, looks like
/// many things that are in no library.
const LIBRARY_OF_GROUPS: f64 = 0.87;
/// Part of the gap that is left where the cause is as likely in the library as not, and how fast that
/// changes; from the benchmark.
const LEFT_OF_UNKNOWN: f64 = 0.12;
const STEEPNESS: f64 = 1.2;
/// Part of the noise's power that the right formula may leave unseen.
const SEEN: f64 = 0.01;
/// Part of the gap that a further effect takes away where it is as likely an effect as a repair of the
/// others' formulas.
const REPAIR: f64 = 0.01;
/// The same for how many times what is left at last it takes away.
const REPAIRED: f64 = 30.0;

/// One name for a slot.
#[derive(Clone, Debug)]
pub(crate) struct Belief {
    pub(crate) family: usize,
    pub(crate) probability: f64,
    /// What it leaves over the noise, in powers of the noise.
    pub(crate) left: f64,
}

/// What beliefs are formed from beside the candidates.
#[derive(Clone, Copy)]
pub(crate) struct Sight<'a> {
    pub(crate) library: &'a [Family],
    /// Held-out mean square of the re-tuned model over the noise's, less 1.
    pub(crate) base_excess: f64,
    /// Mean square over the noise's up to which nothing is left.
    pub(crate) adequate: f64,
    /// What the user calls good enough, in powers of the noise: less of a difference tells no names apart.
    pub(crate) fine: f64,
}

impl<'a> Sight<'a> {
    /// With this re-tuned model.
    pub(crate) fn new(library: &'a [Family], base: &Candidate, adequate: f64, fine: f64) -> Self {
        Self { library, base_excess: (base.judged.held_out - 1.0).max(0.0), adequate, fine }
    }

    pub(crate) fn of(outcome: &'a Outcome) -> Self {
        Self::new(&outcome.library, &outcome.found.base, outcome.adequate, outcome.fine)
    }
}

/// Probability that the cause is in the library where this name leaves nothing.
fn prior(library: &[Family], family: usize) -> f64 {
    if library[family].effect.group.is_some() { LIBRARY_OF_GROUPS } else { LIBRARY }
}

/// Probabilities of the families for one slot, largest first; the rest to 1 is 'none of these'.
pub(crate) fn beliefs(sight: &Sight<'_>, looked: &[Looked], own: &Candidate) -> Vec<Belief> {
    let fitted: Vec<(usize, &Candidate)> =
        looked.iter().filter_map(|l| Some((l.family, l.best.as_ref()?))).collect();
    let Some(best) = fitted.iter().map(|(_, c)| *c).min_by(|a, b| a.rank.total_cmp(&b.rank)) else {
        return Vec::new();
    };
    // The noise is the same in all of them: by how much one leaves more than the best is known far better
    // than how far either is above the noise.
    let seen = excess(best) + SEEN + sight.fine;
    let times = |c: &Candidate| 1.0 + (left(c) - left(best)).max(0.0) / seen;
    // Rows that no fit has seen must not tell them apart either.
    let held_out = |c: &Candidate| (c.judged.held_out - 1.0).max(0.0) + SEEN + sight.fine;
    let least = fitted.iter().map(|(_, c)| held_out(c)).fold(f64::INFINITY, f64::min);
    let is_alike = |c: &Candidate| {
        times(c) < ALIKE && (held_out(c) < ALIKE * least || held_out(c) < sight.adequate - 1.0)
    };
    let simplest =
        fitted.iter().filter(|(_, c)| is_alike(c)).map(|(_, c)| c.freedom).min().unwrap_or(0);
    let weights: Vec<f64> = fitted
        .iter()
        .map(|(_, c)| {
            // The right name leaves a small part of the gap where its formula is not the machine's: what
            // counts is how many times more a rival leaves, as far as the noise lets one see it.
            let nominal = 0.5 * (c.rank - best.rank).max(0.0);
            let order = if is_alike(c) { ORDER * (c.freedom - simplest) as f64 } else { 0.0 };
            (-(SHARPNESS * times(c).ln()).min(nominal) - order).exp()
        })
        .collect();
    let total: f64 = weights.iter().sum();
    // None of these is as likely as it is beside each of the names, weighted by their shares.
    let prior: f64 =
        fitted.iter().zip(&weights).map(|((f, _), w)| prior(sight.library, *f) * w / total).sum();
    let known = prior * formula_is_known(sight, own);
    let mut all: Vec<Belief> = fitted
        .iter()
        .zip(weights)
        .map(|((family, c), w)| Belief {
            family: *family,
            probability: known * w / total,
            left: excess(c) + SEEN + sight.fine,
        })
        .collect();
    all.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.family.cmp(&b.family)));
    all
}

/// What is left in powers of the noise, on training and held-out rows alike.
fn left(c: &Candidate) -> f64 {
    0.5 * (c.training + c.judged.held_out)
}

/// How far that is above the noise.
fn excess(c: &Candidate) -> f64 {
    (left(c) - 1.0).max(0.0)
}

/// How likely a formula of the library leaves so much: the more is left over what the noise alone may
/// leave, and the larger a part of the gap that is, the less.
pub(crate) fn formula_is_known(sight: &Sight<'_>, own: &Candidate) -> f64 {
    let left = (excess(own) - (sight.adequate - 1.0)).max(0.0) / sight.base_excess.max(0.1);
    1.0 / (1.0 + (left / LEFT_OF_UNKNOWN).powf(STEEPNESS))
}

/// How likely one of several effects is one, and no repair of what the others' formulas leave: `alone` is
/// the part of the gap that comes back without it. A repair takes a small part of the gap, and does not
/// fit it much better than the formula that it repairs.
pub(crate) fn is_effect(sight: &Sight<'_>, own: &Candidate, alone: f64) -> f64 {
    let times = alone * sight.base_excess / (excess(own) + SEEN);
    let odds = (alone / REPAIR).powf(STEEPNESS) + (times / REPAIRED).powf(STEEPNESS);
    odds / (1.0 + odds)
}

/// How far a name can be trusted by what it leaves: its probability, or that of its group where the group
/// is what the data can tell, over what it would have if nothing were left.
pub(crate) fn trust(library: &[Family], beliefs: &[Belief], family: usize) -> f64 {
    trust_with(library, beliefs, family, |_| false)
}

/// The trust in a single effect and all names that leave alike: one of them is the answer, and the set says so.
pub(crate) fn trust_of_alike(library: &[Family], beliefs: &[Belief], family: usize) -> f64 {
    let own = beliefs.iter().find(|b| b.family == family).map_or(0.0, |b| b.left);
    let is_alike = |b: &Belief| b.left < ALIKE * own && own < ALIKE * b.left;
    trust_with(library, beliefs, family, is_alike)
}

fn trust_with(
    library: &[Family],
    beliefs: &[Belief],
    family: usize,
    is_alike: impl Fn(&Belief) -> bool,
) -> f64 {
    let group = library[family].effect.group;
    let is_with = |b: &&Belief| {
        let is_of_group = group.is_some() && library[b.family].effect.group == group;
        b.family == family || is_of_group || is_alike(b)
    };
    let sum: f64 = beliefs.iter().map(|b| b.probability).sum();
    let most: f64 = beliefs.iter().map(|b| prior(library, b.family) * b.probability).sum();
    if most <= 0.0 {
        return 0.0;
    }
    beliefs.iter().filter(is_with).map(|b| b.probability).sum::<f64>() * sum / most
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

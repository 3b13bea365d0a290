//! How sure a name is: probabilities of rivals, and of none of them.

use crate::candidate::{Candidate, RankedFamily};
use crate::formula::Family;
use crate::thresholds::belief::Thresholds;

/// One name for a slot.
#[derive(Clone, Debug)]
pub(crate) struct Belief {
    pub(crate) family: usize,
    pub(crate) probability: f64,
    /// What the belief leaves over the noise, in powers of the noise.
    pub(crate) left: f64,
}

/// What beliefs are formed from beside the candidates.
#[derive(Clone, Copy)]
pub(crate) struct BeliefContext<'a> {
    pub(crate) library: &'a [Family],
    /// Held-out mean square of the re-tuned model over the noise's, less 1.
    pub(crate) base_excess: f64,
    /// Mean square over the noise's up to which nothing is left.
    pub(crate) adequate: f64,
    /// What the user calls good enough, in powers of the noise: less of a difference tells no names apart.
    pub(crate) fine: f64,
    /// What is left and follows from the command, in powers of the noise: it is no noise.
    pub(crate) caused: f64,
    /// Power of the noise over that by which residuals are measured.
    pub(crate) noise: f64,
}

impl<'a> BeliefContext<'a> {
    /// With this re-tuned model.
    pub(crate) fn new(library: &'a [Family], base: &Candidate, adequate: f64, fine: f64) -> Self {
        let base_excess = (base.judged.held_out - 1.0).max(0.0);
        Self { library, base_excess, adequate, fine, caused: 0.0, noise: 1.0 }
    }

    /// With what a name leaves: what does not follow from the command and is as large in fitted as in held-out rows is noise,
    /// within what is not known of its size.
    pub(crate) fn with_left(self, by: &Candidate, caused: Option<f64>) -> Self {
        let Some(caused) = caused else { return self };
        let more = by.training.min(by.judged.held_out) - caused - 1.0;
        Self { caused, noise: 1.0 + more.clamp(0.0, (self.adequate - 1.0).max(0.0)), ..self }
    }

    /// How far a mean square is above the noise, and what the noise and the user let nobody see.
    fn over(&self, left: f64) -> f64 {
        (left - self.noise).max(0.0) + Thresholds::UNSEEN + self.fine
    }
}

/// Probability that the cause is in the library where this name leaves nothing.
fn prior(library: &[Family], family: usize) -> f64 {
    if library[family].effect.group.is_some() {
        Thresholds::LIBRARY_OF_GROUPS
    } else {
        Thresholds::LIBRARY
    }
}

/// Probabilities of the families for one slot, largest first; the rest to 1 is 'none of these'.
pub(crate) fn beliefs(
    sight: &BeliefContext<'_>,
    looked: &[RankedFamily],
    own: &Candidate,
) -> Vec<Belief> {
    let fitted: Vec<(usize, &Candidate)> =
        looked.iter().filter_map(|l| Some((l.family, l.best.as_ref()?))).collect();
    let Some(best) = fitted.iter().map(|(_, c)| *c).min_by(|a, b| a.rank.total_cmp(&b.rank)) else {
        return Vec::new();
    };
    // The noise is the same in all of them: by how much one leaves more than the best is known far better
    // than how far either is above the noise.
    let times = |c: &Candidate| times(sight, left(c), left(best));
    // Rows that no fit has seen must not tell them apart either.
    let held_out = |c: &Candidate| sight.over(c.judged.held_out);
    let least = fitted.iter().map(|(_, c)| held_out(c)).fold(f64::INFINITY, f64::min);
    let is_alike = |c: &Candidate| {
        times(c) < Thresholds::ALIKE
            && (held_out(c) < Thresholds::ALIKE * least || held_out(c) < sight.adequate - 1.0)
    };
    let simplest =
        fitted.iter().filter(|(_, c)| is_alike(c)).map(|(_, c)| c.freedom).min().unwrap_or(0);
    let weights: Vec<f64> = fitted
        .iter()
        .map(|(_, c)| {
            // The right name leaves a small part of the gap where its formula is not the machine's: what
            // counts is how many times more a rival leaves, as far as the noise lets one see it.
            let order = |than: usize| Thresholds::ORDER * c.freedom.saturating_sub(than) as f64;
            let alike = if is_alike(c) { order(simplest) } else { 0.0 };
            let apart = apart(times(c), c.rank - best.rank) + alike;
            // A prediction that is off says little where other parameters fit all rows as well.
            (-apart.min(c.against + order(own.freedom))).exp()
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
            left: sight.over(left(c)),
        })
        .collect();
    all.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.family.cmp(&b.family)));
    all
}

/// What is left in powers of the noise, on training and held-out rows alike.
fn left(c: &Candidate) -> f64 {
    0.5 * (c.training + c.judged.held_out)
}

/// Logarithm of the odds against formulas that leave `rival` and not `own`, mean squares of fits to the same rows, whose
/// ranks are that far apart.
pub(crate) fn against(sight: &BeliefContext<'_>, rival: f64, own: f64, ranks: f64) -> f64 {
    apart(times(sight, rival, own), ranks)
}

/// How many times more than `own` the mean square `rival` leaves, as far as the noise lets one see it.
fn times(sight: &BeliefContext<'_>, rival: f64, own: f64) -> f64 {
    1.0 + (rival - own).max(0.0) / sight.over(own)
}

/// Logarithm of the odds against what leaves so many times more, no more than ranks that far apart say.
fn apart(times: f64, ranks: f64) -> f64 {
    (Thresholds::SHARPNESS * times.ln()).min(0.5 * ranks.max(0.0))
}

/// How far that is above the noise.
fn excess(c: &Candidate) -> f64 {
    (left(c) - 1.0).max(0.0)
}

/// How likely a formula of the library leaves so much: the more is left over what the noise alone may
/// leave, and the larger a part of the gap that is, the less.
pub(crate) fn formula_is_known(sight: &BeliefContext<'_>, own: &Candidate) -> f64 {
    let caused = (sight.caused - sight.fine).max(0.0);
    let left = (excess(own) - (sight.adequate - 1.0)).max(caused) / sight.base_excess.max(0.1);
    1.0 / (1.0 + (left / Thresholds::LEFT_OF_UNKNOWN).powf(Thresholds::STEEPNESS))
}

/// How likely one of several effects is one, and no repair of what the others' formulas leave: `alone` is
/// the part of the gap that comes back without it. A repair takes a small part of the gap, and does not
/// fit it much better than the formula that it repairs.
pub(crate) fn is_effect(sight: &BeliefContext<'_>, own: &Candidate, alone: f64) -> f64 {
    let times = alone * sight.base_excess / (excess(own) + Thresholds::UNSEEN);
    let odds = (alone / Thresholds::REPAIR).powf(Thresholds::STEEPNESS)
        + (times / Thresholds::REPAIRED).powf(Thresholds::STEEPNESS);
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
    let is_alike =
        |b: &Belief| b.left < Thresholds::ALIKE * own && own < Thresholds::ALIKE * b.left;
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
        if sum >= Thresholds::SET * known {
            break;
        }
    }
    set
}

#[cfg(test)]
mod tests;

//! How sure a name is: probabilities of rivals, and of none of them.

use crate::outcome::Outcome;
use crate::score::explained;
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
/// Excess over the noise that is told from none.
const SEEN: f64 = 0.02;

/// One name for a slot.
#[derive(Clone, Debug)]
pub(crate) struct Belief {
    pub(crate) family: usize,
    pub(crate) probability: f64,
}

/// Probabilities of the families for one slot, largest first; the rest to 1 is 'none of these'.
pub(crate) fn beliefs(outcome: &Outcome, looked: &[Looked], own: &Candidate) -> Vec<Belief> {
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
    let known = known(outcome, own);
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

/// Probability that the cause is in the library at all, from what the effects explain.
fn known(outcome: &Outcome, own: &Candidate) -> f64 {
    let base = &outcome.found.base.judged;
    let score = outcome.judge.score(base, &own.judged);
    let power = explained(base, &own.judged);
    let level = score.max(0.5 * (score + power));
    1.0 / (1.0 + (-(level - 0.65) / 0.06).exp())
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

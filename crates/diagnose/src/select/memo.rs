//! What the parts of a search gave, so that none is made twice: a search that is made anew with another noise, or
//! comes to the same effects on another way, goes on from there.

use std::sync::{Mutex, PoisonError};

use super::Search;
use crate::candidate::{Candidate, RankedFamily};
use crate::error::Failed;
use crate::fit::Fit;
use crate::thresholds::search::Thresholds;

/// A part of the search.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// All families as the next effect.
    Expansion,
    /// The fit with these effects only.
    Refit(Vec<(usize, usize)>),
    /// Another formula for the effect of this number.
    Formula(usize),
    /// Another start for the last effect.
    Away,
}

/// One that was made.
struct KeptPart {
    part: Part,
    from: Candidate,
    sigma: f64,
    gave: Vec<RankedFamily>,
}

/// What was made, the oldest first.
#[derive(Default)]
pub(crate) struct Memo {
    all: Mutex<Vec<KeptPart>>,
}

impl Search<'_> {
    /// What a part of the search gives from here: as it was made before, or made now.
    pub(super) fn once(
        &self,
        part: Part,
        from: &Candidate,
        make: impl FnOnce() -> Result<Vec<RankedFamily>, Failed>,
    ) -> Result<Vec<RankedFamily>, Failed> {
        let lock = || self.memo.all.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock()
            .iter()
            .find(|kept| kept.part == part && self.is_same(kept, from))
            .map(|kept| (kept.gave.clone(), kept.sigma));
        if let Some((gave, sigma)) = known {
            return Ok(gave.into_iter().map(|looked| self.rescaled(looked, sigma)).collect());
        }
        let gave = make()?;
        let mut all = lock();
        if all.len() >= Thresholds::PARTS_KEPT {
            all.remove(0);
        }
        all.push(KeptPart { part, from: from.clone(), sigma: self.sigma, gave: gave.clone() });
        Ok(gave)
    }

    /// The one candidate that a part of the search gives from here.
    pub(super) fn once_one(
        &self,
        part: Part,
        from: &Candidate,
        make: impl FnOnce() -> Result<Candidate, Failed>,
    ) -> Result<Candidate, Failed> {
        let gave = self.once(part, from, || {
            let best = Some(make()?);
            Ok(vec![RankedFamily { family: 0, screening: 0.0, best, why: None }])
        })?;
        gave.into_iter().find_map(|looked| looked.best).ok_or(Failed)
    }

    fn is_same(&self, kept: &KeptPart, from: &Candidate) -> bool {
        let square = |c: &Candidate, sigma: f64| c.fit.mean_square * sigma * sigma;
        let (a, b) = (square(&kept.from, kept.sigma), square(from, self.sigma));
        kept.from.picks == from.picks && (a - b).abs() <= Thresholds::PARTS_SAME * a.max(b)
    }

    /// A family in standard deviations of this search's noise.
    fn rescaled(&self, mut looked: RankedFamily, sigma: f64) -> RankedFamily {
        if sigma.to_bits() != self.sigma.to_bits() {
            looked.best = looked.best.map(|best| self.in_units(best, self.sigma / sigma));
        }
        looked
    }

    /// A fit over a noise that is 1/`ratio` of this search's, judged by this search.
    pub(crate) fn judged_again(&self, c: Candidate, ratio: f64) -> Result<Candidate, Failed> {
        let fit = Fit { mean_square: c.fit.mean_square / (ratio * ratio), ..c.fit };
        self.candidate(c.picks, c.chain, fit)
    }

    /// A candidate whose figures are over a noise that is 1/`ratio` of this search's.
    pub(crate) fn in_units(&self, c: Candidate, ratio: f64) -> Candidate {
        let residual = c.judged.residual.iter().map(|r| r / ratio).collect();
        let fit = Fit { mean_square: c.fit.mean_square / (ratio * ratio), ..c.fit };
        let judged = self.judge.figures(residual, self.data);
        Candidate { against: c.against, ..self.ranked(c.picks, c.chain, fit, judged) }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use crate::select::Search;
    use crate::select::test_support::{Synthetic, close, listed, names};

    #[test]
    fn no_part_is_computed_twice_and_each_is_given_in_the_noise_of_its_search() {
        let synthetic =
            Synthetic::new(&[(3, 10.0), (5, 8.0)], &[&[(3, 1.0)], &[(5, 1.0)], &[(7, 1.0)]]);
        let (search, base) = (synthetic.search(), synthetic.retuned());
        let first = search.expand(&base).unwrap();
        let count = || synthetic.count.load(Ordering::Relaxed);
        let before = count();
        let again = search.expand(&base).unwrap();
        assert_eq!((listed(&first), count()), (listed(&again), before));
        // Half the noise: four times the figures, and the same fits.
        let quieter = Search { sigma: 0.5, ..synthetic.search() };
        let quieter = Search { memo: search.memo, ..quieter };
        let same = quieter.in_units(base.clone(), 0.5);
        close(same.judged.held_out, 4.0 * base.judged.held_out, 1e-9);
        let scaled = quieter.expand(&same).unwrap();
        assert_eq!((listed(&first), count()), (listed(&scaled), before));
        let best = |looked: &[crate::select::RankedFamily]| looked[0].best.clone().unwrap();
        assert_eq!(best(&first).fit.theta, best(&scaled).fit.theta);
        close(best(&scaled).fit.mean_square, 4.0 * best(&first).fit.mean_square, 1e-9);
        close(best(&scaled).judged.held_out, 4.0 * best(&first).judged.held_out, 1e-9);
        let judged = quieter.judged_again(base.clone(), 0.5).unwrap();
        close(judged.judged.held_out, same.judged.held_out, 1e-9 * same.judged.held_out);
        close(judged.rank, same.rank, 1e-6);
        let before = count();
        // From other effects it is another part.
        let pair = search.expand(&best(&first)).unwrap();
        assert!(count() > before);
        assert_eq!(names(pair[0].best.as_ref().unwrap()), [0, 1]);
    }
}

//! Fits to the end.

use super::Search;
use crate::candidate::{Candidate, RankedFamily};
use crate::fit::Linear;
use crate::thresholds::search::Thresholds;

impl Search<'_> {
    /// Fits the best formula of a family again, with sensitivities of its own; with those that are known and the mean
    /// square that the best family leaves.
    pub(super) fn refine(&self, entry: &mut RankedFamily, known: (&Linear, f64)) {
        let Some(best) = &entry.best else { return };
        let refined = self
            .fitter()
            .fit_from(&best.chain, &best.fit.theta, known)
            .and_then(|fit| self.candidate(best.picks.clone(), best.chain.clone(), fit));
        if let Ok(refined) = refined
            && refined.rank < best.rank
        {
            entry.best = Some(refined);
        }
    }

    /// Fits the best formula of a family and the best plainer one of these others to the end: the better one stays.
    pub(super) fn refine_with_plainer(
        &self,
        entry: &mut RankedFamily,
        others: &[Candidate],
        known: (&Linear, f64),
    ) {
        let plainer = plainer(entry, others).cloned();
        self.refine(entry, known);
        let Some(plainer) = plainer else { return };
        let mut other = RankedFamily { best: Some(plainer), ..*entry };
        self.refine(&mut other, known);
        let rank = |entry: &RankedFamily| entry.best.as_ref().map_or(f64::INFINITY, |c| c.rank);
        if rank(&other) < rank(entry) {
            entry.best = other.best;
        }
    }
}

/// The best other formula of a family that has fewer coefficients and is little behind: fitted to the end, the further
/// coefficients may turn out to have made good what its quick fit lacked.
pub(super) fn plainer<'a>(entry: &RankedFamily, others: &'a [Candidate]) -> Option<&'a Candidate> {
    let best = entry.best.as_ref()?;
    let is_near = |c: &&Candidate| {
        c.picks.last().map(|pick| pick.0) == Some(entry.family)
            && c.freedom < best.freedom
            && c.rank < best.rank + Thresholds::PLAINER
    };
    others.iter().filter(is_near).min_by(|a, b| a.rank.total_cmp(&b.rank))
}

//! Which of the rivals of each effect is named.

use super::Search;
use crate::belief::{self, BeliefContext};
use crate::candidate::{Candidate, Found, RankedFamily};
use crate::causal;

impl Search<'_> {
    /// Each effect gives way to the most probable of its rivals beside the others: of those that leave alike the one
    /// with fewer coefficients.
    pub(super) fn most_probable(
        &self,
        sight: &BeliefContext<'_>,
        rivals: &mut Vec<Vec<RankedFamily>>,
        mut best: Candidate,
    ) -> Candidate {
        for slot in (0..best.picks.len().min(rivals.len())).rev() {
            let looked = &rivals[slot];
            let first = belief::beliefs(sight, looked, &best).first().map(|b| b.family);
            let rival = looked.iter().find(|l| first.is_some_and(|f| f == l.family));
            let mut others = best.picks.clone();
            let own = others.remove(slot);
            // Rivals that were looked at beside an effect which was dropped or exchanged since still have that one.
            let is_beside =
                |c: &&Candidate| c.picks.split_last().is_some_and(|(_, with)| *with == others[..]);
            let Some(rival) = rival.and_then(|l| l.best.as_ref()).filter(is_beside) else {
                continue;
            };
            if rival.picks.last().is_some_and(|pick| pick.0 != own.0) {
                best = rival.clone();
                let looked = rivals.remove(slot);
                rivals.push(looked);
            }
        }
        best
    }

    /// Names the most probable one once the noise is known better.
    pub(crate) fn name_again(&self, found: &mut Found) {
        let last = found.last.clone();
        let before = last.picks.clone();
        let caused = causal::left_by(&last, self.data, self.sigma);
        let sight = self.sight(&found.base).with_left(&last, caused);
        found.last = self.most_probable(&sight, &mut found.rivals, last);
        if found.alone.len() == 1 || found.last.picks != before {
            found.alone = self.alone(&found.base, &found.last);
        }
    }
}

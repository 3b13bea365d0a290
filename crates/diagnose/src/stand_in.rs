//! Another formula of an effect for a blueprint, where no component does what the best one does.

use std::sync::atomic::AtomicU64;

use crate::candidate::Candidate;
use crate::formula::Formula;
use crate::left_out::stays_out;
use crate::outcome::Outcome;
use crate::score::explained;
use crate::select::{Memo, Search};
use crate::thresholds::repair::Thresholds;

/// The effects of an outcome with formulas that `is_written` takes, where a family has one that takes
/// away enough; what was exchanged, one sentence each.
pub(crate) fn stand_in(
    o: &Outcome,
    is_written: &dyn Fn(&str, &Formula, &[f64]) -> bool,
) -> (Candidate, Vec<String>) {
    let (count, memo) = (AtomicU64::new(0), Memo::default());
    let search = Search {
        base: &o.task.base,
        data: &o.task.data,
        judge: &o.judge,
        library: &o.library,
        sigma: o.sigma,
        adequate: o.adequate,
        fine: o.fine,
        count: &count,
        max_effects: 0,
        reading_is_known: false,
        memo: &memo,
    };
    let mut last = o.found.last.clone();
    let mut notes = Vec::new();
    for pick in o.found.last.picks.clone() {
        let Some(slot) = last.picks.iter().position(|p| *p == pick) else { continue };
        let family = &o.library[pick.0];
        let (effect, best) = (family.effect.name, &family.formulas[pick.1]);
        let is_own = best.pieces.is_empty() && best.force.is_none();
        if (is_own && (!best.releases.is_empty() || best.joint_mode.is_some()))
            || o.effects(&last).nth(slot).is_some_and(|(.., own)| is_written(effect, best, &own))
        {
            continue;
        }
        let goes = |c: &Candidate| explained(&o.found.base.judged, &c.judged);
        // With no effect left it is the re-tuned model, which the search has fitted more than once.
        let without = match last.picks.as_slice() {
            [_] => Ok(o.found.base.clone()),
            _ => search.refit_without(&last, slot),
        };
        let Ok(without) = without else { continue };
        // A disturbance of each record's own is no part of a model; its terms stay in the fit.
        if best.pieces.is_empty() && best.force.is_none() {
            continue;
        }
        let others = family.formulas.iter().enumerate().filter(|(_, f)| {
            let first = f.starts.first().map_or(&[][..], Vec::as_slice);
            // The model's own parameters are written in any case.
            let is_own = f.pieces.is_empty() && f.force.is_none() && !f.releases.is_empty();
            is_own || is_written(effect, f, first)
        });
        let fitted = others.filter_map(|(number, formula)| {
            Some((formula, search.exchange(&last, slot, number).ok()?))
        });
        let stand_in = fitted
            .max_by(|a, b| goes(&a.1).total_cmp(&goes(&b.1)))
            .filter(|(_, other)| goes(other) > goes(&without) + Thresholds::STAND_IN_WORTH);
        if let Some((formula, other)) = stand_in {
            notes.push(format!(
                "{effect} is written as {}, as no component does what was found ({}): {:.0} % of the gap's power is removed in place of {:.0} %",
                formula.name,
                best.name,
                100.0 * goes(&other),
                100.0 * goes(&last)
            ));
            last = other;
        } else {
            // Values that were fitted beside an effect are wrong without it.
            notes.push(stays_out(effect, best));
            last = without;
        }
    }
    (last, notes)
}

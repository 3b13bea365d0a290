//! A second search, where the answer of the first cannot stand.

use std::sync::atomic::AtomicU64;

use super::{Base, Run, Scale};
use crate::candidate::are_several_in_faint_gap;
use crate::error::Error;
use crate::formula::Formula;
use crate::nuisance::Nuisance;
use crate::outcome::Outcome;
use crate::request::Request;
use crate::select::Memo;
use crate::setting::simulated_span;
use crate::thresholds::base::Thresholds as BaseThresholds;

/// The answer once how the logs are read is known: no effect is named whose fit ends at a bound of what it can be, as it imitates
/// another, and not several in a faint gap.
///
/// # Errors
/// [`Error::Model`]: the model cannot be simulated over the logs.
pub(crate) fn with_known_reading(
    mut o: Outcome,
    request: &Request,
    count: &AtomicU64,
) -> Result<Outcome, Error> {
    let last = &o.found.last;
    let are_several = are_several_in_faint_gap(&o.found.base, last);
    if !are_several && !(0..last.picks.len()).any(|slot| last.imitates(&o.library, slot)) {
        return Ok(o);
    }
    o.task.reading_is_known = true;
    let otherwise = std::mem::take(&mut o.otherwise);
    let again = Run { request, count, memo: &Memo::default() }.again(o)?;
    Ok(Outcome { otherwise, ..again })
}

/// Whether a free course is named that is none of each record's own, and that predicts no complete record: a drift that returns
/// with the command is no drift.
pub(super) fn drifts_alike(o: &Outcome) -> bool {
    let has_course = o.formulas(&o.found.last).any(is_course);
    has_course
        && o.task.data.records.len() >= BaseThresholds::COURSE_RECORDS
        && !o.judge.has_own_course(&o.found.last.chain)
        && o.second.as_ref().is_some_and(|second| !second.agrees)
}

/// Whether a formula is a free course.
fn is_course(formula: &Formula) -> bool {
    formula.nuisance.as_ref().is_some_and(Nuisance::is_free_course)
}

impl Run<'_> {
    /// The answer without free courses, which explain the held-out rows and no complete record.
    pub(super) fn without_courses(&self, mut o: Outcome) -> Result<Outcome, Error> {
        for family in &mut o.library {
            family.formulas.retain(|f| !is_course(f));
        }
        o.library.retain(|f| !f.formulas.is_empty());
        o.task.warnings.push(format!(
            "{}: a drift would explain the held-out rows, but not a record that is left out of the fit as a whole: it is \
             not named",
            o.task.output
        ));
        self.again(o)
    }

    /// The answer that a new search gives.
    fn again(&self, o: Outcome) -> Result<Outcome, Error> {
        let Outcome { task, library, judge, sigma, adequate, fine, given, found, .. } = o;
        let scale = Scale { judge, sigma, sure: adequate, adequate, fine };
        let position = simulated_span(&found.base, &task.data, self.count);
        let position = position.unwrap_or(task.data.output_span);
        let base = Base { retuned: found.base, given, scale, position };
        let searched = self.search_among(&task, library, base)?;
        let (task, believed) = self.belief(task, searched);
        Ok(self.repair(task, believed))
    }
}

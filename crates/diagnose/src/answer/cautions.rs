//! What the reader must know before trusting an answer.

use crate::gap::Verdict;
use crate::outcome::Outcome;
use crate::thresholds::answer::Thresholds;

/// The cautions of one output, one sentence each.
pub(super) fn cautions(o: &Outcome) -> Vec<String> {
    let mut all = Vec::new();
    let noise = &o.task.noise;
    if let Some(periods) = noise.periods
        && periods > Thresholds::PERIODS_MORE * noise.sigma
    {
        all.push(format!(
            "{}: from period to period the reading changes by {periods:.3e} {}, {:.1} times the noise that is used: something is not driven by the command, or drifts",
            o.task.output, o.task.unit, periods / noise.sigma
        ));
    }
    if let Some(second) = o.second.as_ref().filter(|second| !second.agrees) {
        all.push(format!(
            "{}: of the records as a whole, left out one after the other, only {:.0} % of the gap's power is removed: what was fitted to one kind of record does not hold for another",
            o.task.output,
            100.0 * second.fraction
        ));
    }
    if noise.source == "second differences"
        && o.verdict == Verdict::Unknown
        && o.found.base.judged.held_out < Thresholds::GAP_SMALL * o.adequate
    {
        all.push(format!(
            "{}: the noise was estimated from the logs, which is a lower bound; the gap is small against it: give --rest or --noise before you believe it",
            o.task.output
        ));
    }
    all.extend(own_offsets(o));
    if o.task.base.parameters.iter().all(|p| !p.has_tolerance) {
        all.push(format!(
            "{}: no parameter of the model has a tolerance, only the output's gain: an error of a parameter can look like an effect; give tolerances in the blueprint or with --tune",
            o.task.output
        ));
    }
    all
}

/// What a user gets who lays the repaired model over a log as it stands, where that is clearly more than the shrink
/// says, whose records may each have an offset of its own.
fn own_offsets(o: &Outcome) -> Option<String> {
    let has_effects = !o.found.last.picks.is_empty();
    let offset = o.offset.filter(|_| has_effects)?;
    let (left, factor) = (o.sigma * o.with_effects().held_out.max(0.0).sqrt(), o.task.factor);
    (offset.as_it_stands.1 > Thresholds::OWN_OFFSETS * left).then(|| {
        format!(
            "{}: each record has its own offset, which no model predicts: over a log as recorded the error of the repaired model is {:.3e} {}, without the offset of the record {:.3e} {}",
            o.task.output,
            offset.as_it_stands.1 / factor,
            o.task.unit,
            left / factor,
            o.task.unit
        )
    })
}

//! Outputs of one black box, looked at again: a mode or a parameter of its own that one of them shows is where the search
//! in the others starts.

use std::sync::atomic::AtomicU64;

use super::{cost, shown};
use crate::base::Hint;
use crate::candidate::has_gap;
use crate::course;
use crate::outcome::Outcome;
use crate::request::Request;
use crate::task::Task;

/// Diagnoses the outputs of which something is left once more, from what the others show; `fresh` are their tasks before
/// any was diagnosed. The answer that leaves less, for as many parameters as it needs, stays: the first one, too, where the
/// second search cannot be made.
pub(crate) fn with_hints_of_others(
    outcomes: &mut [Outcome],
    fresh: &[Option<Task>],
    request: &Request,
    count: &AtomicU64,
) {
    let hints: Vec<Option<Hint>> = outcomes.iter().map(hint).collect();
    for (member, old) in outcomes.iter_mut().enumerate() {
        let others = hints.iter().enumerate().filter(|(owner, _)| *owner != member);
        let others: Vec<Hint> = others.filter_map(|(_, hint)| hint.clone()).collect();
        let Some(task) = fresh.get(member).and_then(Option::as_ref) else { continue };
        if others.is_empty() || !is_box(old) || !has_gap(&old.found.last, old.adequate) {
            continue;
        }
        let mut task = task.clone();
        task.base.hints = others;
        if let Ok(again) = course::settled(task, request, count)
            && cost(&again) < cost(old)
        {
            *old = again;
        }
    }
}

fn is_box(o: &Outcome) -> bool {
    !o.task.base.black_boxes().is_empty()
}

/// What an output of a black box shows of the box itself.
fn hint(o: &Outcome) -> Option<Hint> {
    let frequency = o.effects(&o.found.last).find_map(|(_, formula, values)| {
        let at = formula.parameters.iter().position(|p| p.name == "frequency" && p.unit == "Hz")?;
        Some(values[at])
    });
    shown(o, frequency).filter(|_| is_box(o))
}

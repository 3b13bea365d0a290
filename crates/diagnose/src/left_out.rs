//! What a repaired model leaves out, in sentences.

use crate::formula::Formula;

/// Why an effect is no part of a repaired model.
pub(crate) fn stays_out(effect: &str, formula: &Formula) -> String {
    let why = if formula.nuisance.is_some() {
        "a disturbance whose phase or course differs from record to record, which no model predicts"
    } else if effect == "clock_offset" {
        "it lies between two clocks and not in the machine"
    } else if effect == "initial_state" {
        "it belongs to the start of each record and not to the machine"
    } else {
        "there is no block or component of this formula"
    };
    format!("{effect} ({}) stays out of the repaired model: {why}", formula.name)
}

/// What of an effect that is written is no part of a repaired model.
pub(crate) fn part_stays_out(effect: &str, formula: &Formula) -> Option<String> {
    formula.nuisance.as_ref().map(|_| {
        format!(
            "{effect} ({}) is written with the part that is the same in each record; the part whose phase differs from record to record is not in the repaired model",
            formula.name
        )
    })
}

//! Names and units of the axes of an identified plant, and one plant of several axes.

use anyhow::{Context, bail};
use data::{AxisBlueprint, Blueprint, CheckedBlueprint, Log, SignalBlueprint};

use crate::results::identify::AxisResult;

/// A name that every tool takes: letters, digits and `_`, a letter first.
pub(crate) fn identifier(text: &str) -> String {
    let mut name: String =
        text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    // `position[1]` is position_1.
    name.truncate(name.trim_end_matches('_').len());
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name.insert_str(0, "model_");
    }
    name
}

/// The unit of a column: the log's own, else the usual one, which is noted.
pub(super) fn unit(
    logs: &[Log],
    column: &str,
    usual: &str,
    notes: &mut Vec<String>,
) -> anyhow::Result<String> {
    let mut found: Option<String> = None;
    for log in logs {
        let Some(unit) = &log.require(column)?.unit else { continue };
        found.get_or_insert_with(|| unit.text.clone());
    }
    Ok(found.unwrap_or_else(|| usual_unit(column, usual, notes)))
}

/// The usual unit for a column that has none, which is noted.
pub(crate) fn usual_unit(column: &str, usual: &str, notes: &mut Vec<String>) -> String {
    notes.push(format!(
        "column {column} has no unit, taken as {usual}; say another with --unit {column}=UNIT"
    ));
    usual.to_owned()
}

/// The short name of axis `k`'s variable for a column: none for one that is named as the variable of the FMU will be,
/// `command[1]`.
pub(crate) fn short_name(column: &str, variable: &str, k: usize) -> String {
    if column == format!("{variable}[{}]", k + 1) { String::new() } else { identifier(column) }
}

/// Axis `k` of columns with their units.
pub(super) fn axis(
    k: usize,
    (input, command_unit): (&str, &str),
    (output, position_unit): (&str, &str),
) -> AxisBlueprint {
    let signal = |column: &str, variable: &str, unit: &str| {
        SignalBlueprint::of_unit(unit).named(&short_name(column, variable, k))
    };
    AxisBlueprint {
        command: signal(input, "command", command_unit),
        position: signal(output, "position", position_unit),
        ..AxisBlueprint::new(&identifier(output), command_unit, position_unit)
    }
}

/// One blueprint with the axes of all.
pub(super) fn join(axes: &[AxisResult]) -> anyhow::Result<CheckedBlueprint> {
    let first = axes.first().context("there is no axis; give --input and --output")?;
    let period = |axis: &AxisResult| axis.identification.plant.spec().period;
    // The finest step serves all: an axis that needs fewer steps in a sample of the log does not mind more.
    let finest = axes.iter().min_by(|a, b| period(a).total_cmp(&period(b))).unwrap_or(first);
    let mut complete: Blueprint = first.identification.plant.blueprint().clone();
    complete.step.clone_from(&finest.identification.plant.blueprint().step);
    for axis in axes {
        let ratio = period(axis) / period(finest);
        if (ratio - ratio.round()).abs() > 1e-9 * ratio {
            bail!(
                "axis {} was identified with the step {}, axis {} with {}: one plant has one step; \
                 identify them from logs of one sample rate",
                finest.name,
                step(finest),
                axis.name,
                step(axis)
            );
        }
    }
    for axis in &axes[1..] {
        let other = axis.identification.plant.blueprint();
        complete.axes.extend(other.axes.iter().cloned());
        complete.tables.extend(other.tables.clone());
    }
    Ok(complete.check(learned::COMPONENTS)?)
}

/// Internal step of an axis' plant, as text.
fn step(axis: &AxisResult) -> String {
    format!("{} s", axis.identification.plant.spec().period)
}

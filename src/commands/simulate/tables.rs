//! Logs and references as the tables that drive a run.

use anyhow::bail;
use cosim::{Fmu, Points, Signal, Signals};
use data::Log;
use modeldescription::description::Unit;

use crate::fmus;

/// The communication points of a loop over a reference.
pub(crate) fn points(
    log: &Log,
    controller: &Fmu,
    step: Option<f64>,
    stop: Option<f64>,
) -> anyhow::Result<Points<'static>> {
    let time = log.time();
    let (Some(&start), Some(&last)) = (time.first(), time.last()) else {
        bail!("{}: the reference has no rows", log.origin());
    };
    let experiment = controller.description().default_experiment.as_ref();
    let own = experiment.and_then(|e| e.step_size).unwrap_or(f64::INFINITY);
    let rows = time.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    // A reference on the controller's own grid, but for rounding, is that grid.
    let near = if (rows - own).abs() <= 1e-6 * own { own } else { rows.min(own) };
    let step = step.unwrap_or(near);
    if !(step.is_finite() && step > 0.0) {
        bail!("the step of the loop is not known: give it with --step S");
    }
    if stop.is_none() {
        can_be_seconds(log, own.min(step))?;
    }
    Ok(Points::uniform(start, stop.unwrap_or(last), step)?)
}

/// Whether the times of a table, whose end is that of the run, can be in seconds: how many steps of `step`
/// seconds lie between two rows.
pub(crate) fn can_be_seconds(log: &Log, step: f64) -> anyhow::Result<()> {
    match data::inner_steps::check_rows(log.time(), step) {
        Ok(()) => Ok(()),
        Err(what) => bail!("{}: {what}", log.origin()),
    }
}

/// The units of a table's columns, where they are known.
pub(crate) fn units(table: &Signals<'_>) -> Vec<(String, Unit)> {
    let known = |column: &Signal<'_>| Some((column.name.clone(), column.unit.clone()?));
    table.columns.iter().filter_map(known).collect()
}

/// The records of a log as input tables.
pub(crate) fn signals(log: &Log) -> Vec<Signals<'_>> {
    let table = |rows: std::ops::Range<usize>| Signals {
        time: &log.time()[rows.clone()],
        columns: log
            .columns()
            .iter()
            .map(|column| Signal {
                name: column.name.clone(),
                unit: column.unit.as_ref().map(|unit| fmus::fmi_unit(&unit.text, &unit.unit)),
                values: &column.values[rows.clone()],
            })
            .collect(),
    };
    log.records().iter().map(|record| table(record.rows.clone())).collect()
}

//! Taps: a column that reads the command behind the amplifier cuts the path in two.
//!
//! ```text
//! command ─▶ timing, amplifier ─▶ monitor          one task: what does the monitor read?
//!                                 monitor ─▶ actuator … sensor ─▶ output      and another one
//! ```
//!
//! What is missing before the tap shows in its own column and cannot hide behind the rest.

use data::Log;

use crate::base::Base;
use crate::error::Error;
use crate::port::Port;
use crate::request::Request;
use crate::task::{Task, assemble, correlation};
use crate::thresholds::base::Thresholds;

/// The column of a monitor of this input: by its name, in the input's unit, and like the command.
pub(crate) fn monitor(request: &Request, input: &Port) -> Option<String> {
    let first = request.logs.first()?;
    let own = first.column(input.column(&request.names, first)?)?;
    let columns = first.columns().iter().filter(|c| {
        let name = c.name.to_lowercase();
        let is_named =
            name.contains("monitor") || name.starts_with("mon_") || name.ends_with("_mon");
        let is_command = c.unit.as_ref().is_some_and(|u| u.unit.exponents == input.si.exponents);
        let is_everywhere =
            request.logs.iter().chain(&request.holdout).all(|l: &Log| l.column(&c.name).is_some());
        is_named && is_command && is_everywhere && c.name != own.name
    });
    let to_si = |c: &data::Column| -> Vec<f64> {
        let unit = c.unit.as_ref().map_or(input.si, |u| u.unit);
        c.values.iter().map(|v| unit.to_si(*v)).collect()
    };
    let command = to_si(own);
    columns
        .filter(|c| {
            let values = to_si(c);
            correlation(&values, &command) > Thresholds::MONITOR_LIKE
                && (slope(&values, &command) - 1.0).abs() < Thresholds::MONITOR_SCALE
        })
        .map(|c| c.name.clone())
        .next()
}

/// Slope of the straight line of `y` over `x`.
fn slope(y: &[f64], x: &[f64]) -> f64 {
    let n = x.len().min(y.len()).max(1) as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let xy: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    let xx: f64 = x.iter().map(|x| (x - mx).powi(2)).sum();
    if xx > 0.0 { xy / xx } else { 0.0 }
}

/// Adds a column with what a reading says of the step before it: row k of a command acts until row
/// k + 1, where the monitor reads it.
fn advance(log: &mut Log, monitor: &str, name: &str) -> Result<(), Error> {
    let column = log.require(monitor)?;
    let unit = column.unit.as_ref().map(|u| u.text.clone());
    let mut values = column.values.clone();
    for record in log.records() {
        let rows = record.rows.clone();
        values.copy_within(rows.start + 1..rows.end, rows.start);
    }
    log.add_column(name, unit.as_deref(), values)?;
    Ok(())
}

/// The two tasks of an output whose command is read at `monitor`.
pub(crate) fn cut(
    request: &Request,
    (inputs, outputs): (&[Port], &[Port]),
    index: usize,
    base: &Base,
    step: Option<f64>,
    monitor: &str,
) -> Result<[Task; 2], Error> {
    let input = &inputs[index];
    if base.reads_command() {
        return Err(Error::Model {
            model: input.label().to_owned(),
            message: format!(
                "is read by a component behind the column {monitor}, at which the model would be cut; \
                 leave that column out of the logs, or pack the blueprint (piezoloop pack) and \
                 diagnose the FMU"
            ),
        });
    }
    let tap = Port { name: monitor.to_owned(), alias: None, ..input.clone() };
    let mut read = outputs.to_vec();
    read[index] = tap.clone();
    let before = assemble(request, inputs, &read, index, index, base.before_actuator(), step)?;
    let acting = format!("{monitor} as it acts");
    let mut advanced = request.clone();
    for log in advanced.logs.iter_mut().chain(&mut advanced.holdout) {
        advance(log, monitor, &acting)?;
    }
    let mut driven = inputs.to_vec();
    driven[index] = Port { name: acting, ..tap };
    let base = base.behind_actuator();
    let mut behind = assemble(&advanced, &driven, outputs, index, index, base, step)?;
    behind.input = input.label().to_owned();
    behind.warnings.push(format!(
        "{}: the model is cut at the column {monitor}: what is before the actuator is judged by that column, what is behind it is driven by it",
        behind.output
    ));
    Ok([before, behind])
}

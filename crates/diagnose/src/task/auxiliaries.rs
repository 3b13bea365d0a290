//! Columns of the logs beside the path that is looked at.

use data::Log;
use model::Unit;

use super::correlation;
use crate::error::Error;
use crate::port::Port;
use crate::request::Request;
use crate::thresholds::base::Thresholds;

/// A column that is no input or output of the path that is looked at.
pub(super) struct AuxColumn {
    pub(super) column: String,
    pub(super) is_command: bool,
}

impl AuxColumn {
    pub(super) fn values(&self, log: &Log) -> Result<Vec<f64>, Error> {
        let column = log.require(&self.column)?;
        let unit = column.unit.as_ref().map_or(Unit::ONE, |u| u.unit);
        Ok(column.values.iter().map(|v| unit.to_si(*v)).collect())
    }
}

/// Columns that are in all logs and move: neighbours' commands, and temperatures.
pub(super) fn auxiliaries(
    request: &Request,
    inputs: &[Port],
    outputs: &[Port],
    input: usize,
) -> Vec<AuxColumn> {
    let Some(first) = request.logs.first() else { return Vec::new() };
    let logs = || request.logs.iter().chain(&request.holdout);
    let own = inputs[input].column(&request.names, first).unwrap_or_default();
    let used = |name: &str| {
        name == own || outputs.iter().any(|p| p.column(&request.names, first) == Some(name))
    };
    let command = first.column(own).map(|c| c.values.as_slice()).unwrap_or_default();
    first
        .columns()
        .iter()
        .filter(|c| !used(&c.name) && logs().all(|log| log.column(&c.name).is_some()))
        .filter_map(|c| {
            let moves = c.values.windows(2).any(|w| w[0] != w[1]);
            let of_input = inputs
                .iter()
                .enumerate()
                .any(|(k, p)| k != input && p.column(&request.names, first) == Some(&c.name));
            let is_command = of_input
                || looks_like_command(&c.name, c.unit.as_ref().map(|u| u.unit), &inputs[input]);
            let is_warmth = c.unit.as_ref().is_some_and(|u| u.unit.exponents == KELVIN)
                || c.name.to_lowercase().contains("temp");
            let apart = correlation(&c.values, command).abs() < Thresholds::AUXILIARY_ALIKE;
            (moves && apart && (is_command || is_warmth))
                .then(|| AuxColumn { column: c.name.clone(), is_command })
        })
        .collect()
}

const KELVIN: [i8; 8] = [0, 0, 0, 0, 1, 0, 0, 0];

/// `u2`, `u_z`, `command[2]`, or anything in the unit of the command that is no monitor of it.
fn looks_like_command(name: &str, unit: Option<Unit>, input: &Port) -> bool {
    let lower = name.to_lowercase();
    if ["monitor", "mon", "ref", "des", "err", "sens", "meas"].iter().any(|w| lower.contains(w)) {
        return false;
    }
    let by_name = lower.starts_with("command")
        || lower.starts_with("cmd")
        || lower
            .strip_prefix('u')
            .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit() || c == '_'));
    by_name || unit.is_some_and(|u| u.exponents == input.si.exponents && u.exponents != [0; 8])
}

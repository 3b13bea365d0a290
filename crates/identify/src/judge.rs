//! The fit of a plant to a record, in simulation mode: the plant is built from its blueprint, starts
//! at rest under the record's first input
//! (or the one it rested under before) and never sees the measured output.

use data::CheckedBlueprint;
use serde::Serialize;

use crate::error::Error;
use crate::record::{Record, Rows};
use crate::settings::range;

/// Agreement of a simulation with a record over some rows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// The rows, counted from 0, the end excluded.
    pub rows: Rows,
    /// The one constant that was added to the simulation: the mean of output less simulation over
    /// these rows.
    pub offset: f64,
    /// Root mean square of output less simulation less offset, in the position's unit.
    pub rmse: f64,
    /// Greatest less least output.
    pub range: f64,
    /// `rmse / range`.
    pub nrmse: f64,
    /// Largest absolute value of output less simulation less offset.
    pub max: f64,
}

/// The simulated position at each row of `record`, before any offset is added.
///
/// # Errors
/// [`Error::Model`] where the plant is not of one axis, or leaves its range.
pub fn simulate(plant: &CheckedBlueprint, record: &Record) -> Result<Vec<f64>, Error> {
    let time = |row: usize| record.time(row);
    let mut positions = simulate_axes(plant, &[record.input()], &[record.rest()], time)?;
    Ok(positions.pop().unwrap_or_default())
}

/// The simulated position of each axis at each row, under the command of each axis, from rest under `rest`
/// at the first row; `time` in s by row.
///
/// # Errors
/// [`Error::Model`] where the plant has fewer axes, or leaves its range.
pub fn simulate_axes<C: AsRef<[f64]>>(
    plant: &CheckedBlueprint,
    commands: &[C],
    rest: &[f64],
    time: impl Fn(usize) -> f64,
) -> Result<Vec<Vec<f64>>, Error> {
    let mut system = plant.build();
    let name = plant.blueprint().name.clone();
    let model = |message: String| Error::Model { name: name.clone(), message };
    let find = |variable: &str, axis: usize| {
        let variable = format!("{variable}[{}]", axis + 1);
        system.variables().find(&variable).ok_or_else(|| {
            model(format!(
                "has no variable \"{variable}\"; only plants can be simulated from a log"
            ))
        })
    };
    let axes = (0..commands.len())
        .map(|axis| Ok((find("command", axis)?, find("position", axis)?)))
        .collect::<Result<Vec<_>, Error>>()?;
    let rows = commands.iter().map(|u| u.as_ref().len()).min().unwrap_or(0);
    let mut positions = vec![Vec::with_capacity(rows); axes.len()];
    for row in 0..rows {
        for (((command, _), u), rest) in axes.iter().zip(commands).zip(rest) {
            let held = if row == 0 { *rest } else { u.as_ref()[row - 1] };
            system.set(*command, held).map_err(|e| model(system.explain_set(&e)))?;
        }
        let moved = match row {
            0 => system.initialise(time(0)),
            _ => system.advance(time(row)).map(|_| ()),
        };
        moved.map_err(|e| model(system.explain(&e)))?;
        for ((_, position), all) in axes.iter().zip(&mut positions) {
            all.push(system.get(*position).unwrap_or(f64::NAN));
        }
    }
    Ok(positions)
}

/// Compares a simulation with the output over these rows. One constant offset is fitted to them.
#[must_use]
pub fn compare(output: &[f64], simulation: &[f64], rows: Rows) -> Figures {
    let (output, simulation) = (rows.of(output), rows.of(simulation));
    let count = output.len().min(simulation.len()).max(1) as f64;
    let errors = || output.iter().zip(simulation).map(|(y, s)| y - s);
    let offset = errors().sum::<f64>() / count;
    let rmse = (errors().map(|e| (e - offset).powi(2)).sum::<f64>() / count).sqrt();
    let max = errors().map(|e| (e - offset).abs()).fold(0.0, f64::max);
    let range = range(output);
    Figures { rows, offset, rmse, range, nrmse: rmse / range, max }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_offset_is_taken_out_and_stated() {
        let output = [9.0, 1.0, 2.0, 3.0, 2.0, 9.0];
        let simulation = [0.0, -1.5, -0.5, 0.5, -0.5, 0.0];
        let figures = compare(&output, &simulation, Rows { first: 1, end: 5 });
        assert_eq!(
            (figures.offset, figures.rmse, figures.max, figures.range),
            (2.5, 0.0, 0.0, 2.0)
        );
        let simulation = [0.0, -1.5, 0.5, 0.5, -1.5, 0.0];
        let figures = compare(&output, &simulation, Rows { first: 1, end: 5 });
        assert_eq!(figures.offset, 2.5);
        assert!((figures.rmse - 0.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(figures.max, 1.0);
        assert_eq!(figures.nrmse, figures.rmse / 2.0);
    }
}

//! Results of Dymola and OpenModelica: MATLAB 4 with a list of names and two tables.
//!
//! Source: Dymola User Manual, "Result files", and OpenModelica's `simulation_result_mat4.cpp`.
//! `Aclass` says whether rows or columns are times, `name` and `description` name the variables,
//! `dataInfo` says of each its table (0: time) and its signed column there; `data_1` holds
//! parameters, `data_2` what moves.

use super::super::broken;
use super::super::budget::Budget;
use super::v4::Matrix;
use crate::log::group::{Found, Group, Raw, Refusal};

/// The variables of a result; `None` where the file is none.
pub(super) fn read(matrices: &[Matrix], budget: &mut Budget) -> Result<Option<Found>, Refusal> {
    let of = |name: &str| matrices.iter().find(|matrix| matrix.name == name);
    let Some((class, names, info, table)) = of("Aclass")
        .zip(of("name"))
        .zip(of("dataInfo"))
        .zip(of("data_2"))
        .map(|(((class, names), info), table)| (class, names, info, table))
    else {
        return Ok(None);
    };
    let class = class.lines();
    let is_transposed = class.get(3).is_some_and(|order| order.starts_with("binTrans"));
    let texts = |matrix: &Matrix| if is_transposed { matrix.standing() } else { matrix.lines() };
    let (names, descriptions) = (texts(names), of("description").map(texts).unwrap_or_default());
    let count = if is_transposed { info.columns } else { info.rows };
    let entry = |variable: usize, at: usize| -> Option<i64> {
        let (row, column) = if is_transposed { (at, variable) } else { (variable, at) };
        let is_there = row < info.rows && column < info.columns;
        let value = is_there.then(|| info.values.get(column * info.rows + row)).flatten();
        value.map(|value| *value as i64)
    };
    let (rows, width) = match is_transposed {
        true => (table.columns, table.rows),
        false => (table.rows, table.columns),
    };
    let mut group = Group::new("result", Vec::new());
    let mut constants = 0_usize;
    for (variable, name) in names.iter().enumerate().take(count) {
        let (Some(of_table), Some(place)) = (entry(variable, 0), entry(variable, 1)) else {
            continue;
        };
        let is_time = of_table == 0 || name.eq_ignore_ascii_case("time");
        if of_table == 1 {
            constants += 1;
            continue;
        }
        let column = usize::try_from(place.unsigned_abs()).ok().and_then(|at| at.checked_sub(1));
        let Some(column) = column.filter(|column| *column < width) else {
            let what = format!("{name} is column {place} of a table of {width}");
            return Err(broken("a result of Dymola", what));
        };
        budget.column(rows as u64)?;
        let sign = if place < 0 { -1.0 } else { 1.0 };
        let value = |row: usize| match is_transposed {
            true => table.values[row * width + column],
            false => table.values[column * rows + row],
        };
        let values = (0..rows).map(|row| sign * value(row)).collect();
        let unit = descriptions.get(variable).and_then(|text| unit_of(text));
        match is_time {
            true => group.columns.insert(0, Raw::new("time", Some("s".into()), values)),
            false => group.columns.push(Raw::new(name, unit, values)),
        }
    }
    let mut notes = vec!["is a result of Dymola or OpenModelica".to_owned()];
    if constants > 0 {
        notes.push(format!("left out: {constants} parameters and constants"));
    }
    Ok(Some(Found { groups: vec![group], notes }))
}

/// The unit at the end of a description, as in `Position of the mass [m]` or `[mm|m]`.
fn unit_of(description: &str) -> Option<String> {
    let (_, unit) = description.trim_end().strip_suffix(']')?.rsplit_once('[')?;
    // Dymola: the unit of the values, then that of its display; type words in front of both.
    let unit = unit.split('|').next().unwrap_or(unit).trim();
    let unit = unit.strip_prefix(":#").map_or(unit, |_| "");
    Some(unit.to_owned()).filter(|unit| !unit.is_empty())
}

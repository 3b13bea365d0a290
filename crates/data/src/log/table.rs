//! Rows of a file on their way into a [`Log`].

use std::collections::BTreeSet;

use super::header::{Head, Role, SECOND};
use super::lines::Lines;
use super::notes::{LeftOut, Remarks};
use super::{Column, Log, Record, cell};
use crate::{Problem, Problems};

/// Problems that are listed; the rest is counted.
const MOST_PROBLEMS: usize = 20;

/// Where a row stands in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Line of a text, from 1.
    Line(usize),
    /// Row of a table without lines, from 1.
    Row(usize),
}

impl Place {
    fn of(self, problem: Problem) -> Problem {
        match self {
            Self::Line(line) => problem.line(line),
            Self::Row(row) => problem.row(row),
        }
    }
}

/// The rows that were read so far.
pub(super) struct Table<'a> {
    origin: &'a str,
    heads: Vec<Head>,
    rate: f64,
    /// Columns that are not read, by position; empty where all are.
    skipped: Vec<bool>,
    /// Values of all columns, those that are no signals too.
    values: Vec<Vec<f64>>,
    time: Vec<f64>,
    lines: Lines,
    records: Vec<Record>,
    seen: BTreeSet<i64>,
    problems: Vec<Problem>,
    omitted: usize,
    /// Record and time of the last row, good or bad.
    last: Option<(i64, f64)>,
    /// Position of the columns of time (or row numbers) and of records.
    time_at: Option<usize>,
    record_at: Option<usize>,
    cells: Vec<f64>,
}

impl<'a> Table<'a> {
    pub(super) fn new(origin: &'a str, heads: Vec<Head>, rate: Option<f64>) -> Self {
        let at = |wanted: fn(&Role) -> bool| heads.iter().position(|head| wanted(&head.role));
        let skipped: Vec<bool> =
            heads.iter().map(|head| matches!(head.role, Role::LeftOut(_))).collect();
        Self {
            origin,
            rate: rate.unwrap_or(1.0),
            skipped: if skipped.contains(&true) { skipped } else { Vec::new() },
            values: vec![Vec::new(); heads.len()],
            time: Vec::new(),
            lines: Lines::default(),
            records: Vec::new(),
            seen: BTreeSet::new(),
            problems: Vec::new(),
            omitted: 0,
            last: None,
            time_at: at(|role| matches!(role, Role::Time(_) | Role::Index)),
            record_at: at(|role| *role == Role::Record),
            cells: Vec::with_capacity(heads.len()),
            heads,
        }
    }

    /// Notes a problem; it is only put together while there is room.
    fn note(&mut self, problem: impl FnOnce(&Self) -> Problem) {
        if self.problems.len() < MOST_PROBLEMS {
            let problem = problem(self);
            self.problems.push(problem);
        } else {
            self.omitted += 1;
        }
    }

    fn is_skipped(&self, column: usize) -> bool {
        self.skipped.get(column) == Some(&true)
    }

    fn name(&self, column: usize) -> &str {
        self.heads.get(column).map_or("", |head| head.name.as_str())
    }

    /// Takes a row of text.
    pub(super) fn row<'c>(&mut self, row: impl ExactSizeIterator<Item = &'c [u8]>, place: Place) {
        if row.len() != self.heads.len() {
            let found = row.len();
            self.note(|table| table.ragged(found, place));
            return;
        }
        self.cells.clear();
        let mut is_good = true;
        for (column, bytes) in row.enumerate() {
            if self.is_skipped(column) {
                self.cells.push(0.0);
                continue;
            }
            let number = cell::parse(bytes).unwrap_or_else(|(rule, way_out)| {
                is_good = false;
                self.note(|table| {
                    let problem = place.of(Problem::new(table.origin, rule, way_out));
                    let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]);
                    problem.at(table.name(column)).value(format!("\"{shown}\""))
                });
                f64::NAN
            });
            self.cells.push(number);
        }
        self.keep(is_good, place);
    }

    /// Takes a row of numbers, as many as there are columns.
    pub(super) fn numbers(&mut self, row: impl Iterator<Item = f64>, place: Place) {
        self.cells.clear();
        self.cells.extend(row);
        let mut is_good = true;
        for column in 0..self.cells.len() {
            if self.is_skipped(column) {
                continue;
            }
            if let Err((rule, way_out)) = cell::check(self.cells[column]) {
                is_good = false;
                self.note(|table| {
                    let problem = place.of(Problem::new(table.origin, rule, way_out));
                    problem.at(table.name(column)).value(table.cells[column])
                });
                self.cells[column] = f64::NAN;
            }
        }
        self.keep(is_good, place);
    }

    /// Keeps the row in `cells`, unless it is wrong.
    fn keep(&mut self, is_good: bool, place: Place) {
        let Some((record, time)) = self.place(place) else { return };
        if !is_good {
            return;
        }
        match self.records.last_mut() {
            Some(open) if open.id == record => open.rows.end += 1,
            _ => {
                let start = self.time.len();
                self.records.push(Record { id: record, rows: start..start + 1 });
            }
        }
        self.time.push(time);
        self.lines.push(self.time.len() - 1, place);
        for (at, (column, cell)) in self.values.iter_mut().zip(&self.cells).enumerate() {
            if self.skipped.get(at) != Some(&true) {
                column.push(*cell);
            }
        }
    }

    fn ragged(&self, found: usize, place: Place) -> Problem {
        let wanted = self.heads.len();
        let way_out = if found == 2 * wanted || found == 2 * wanted - 1 {
            "if the numbers have decimal commas, save the file with decimal points"
        } else {
            "give each row as many cells as the header has names; look for a line that was cut off"
        };
        let rule = format!("the row has {found} cells, the header {wanted}");
        place.of(Problem::new(self.origin, rule, way_out))
    }

    /// Record and time of the row in `cells`; `None` where they are wrong, which is noted.
    fn place(&mut self, place: Place) -> Option<(i64, f64)> {
        let record = match self.record_at.and_then(|at| self.cells.get(at).copied()) {
            Some(number) => self.whole(number, self.record_at.unwrap_or(0), place)?,
            None => 0,
        };
        let is_new = self.last.is_none_or(|(last, _)| last != record);
        if is_new && !self.seen.insert(record) {
            self.note(|table| {
                let way_out = "keep the rows of a record together, or number it differently";
                let name = table.record_at.map_or("record", |at| table.name(at));
                let problem = Problem::new(table.origin, "the record appeared before", way_out);
                place.of(problem).at(name).value(record)
            });
        }
        let time = self.time_of(is_new, place)?;
        let last = self.last.replace((record, time)).filter(|_| !is_new).map(|(_, last)| last);
        if let Some(last) = last.filter(|last| time <= *last) {
            self.note(|table| table.not_growing(last, time, place));
            return None;
        }
        Some((record, time))
    }

    /// Time in s of the row in `cells`; NaN cells were reported before.
    fn time_of(&mut self, is_new: bool, place: Place) -> Option<f64> {
        let Some(at) = self.time_at else {
            let start = if is_new { self.time.len() } else { self.records.last()?.rows.start };
            return Some((self.time.len() - start) as f64 / self.rate);
        };
        let cell = self.cells.get(at).copied().filter(|cell| !cell.is_nan())?;
        match &self.heads.get(at)?.role {
            Role::Time(unit) => unit.convert(cell, &SECOND),
            _ => Some(self.whole(cell, at, place)? as f64 / self.rate),
        }
    }

    /// A cell that must be a whole number.
    fn whole(&mut self, cell: f64, column: usize, place: Place) -> Option<i64> {
        const EXACT: f64 = 9_007_199_254_740_992.0;
        if cell.is_nan() {
            return None;
        }
        if cell.fract() == 0.0 && cell.abs() <= EXACT {
            return Some(cell as i64);
        }
        self.note(|table| {
            let is_record = table.record_at == Some(column);
            let (rule, way_out) = if is_record {
                ("a record has a whole number", "number the records 0, 1, 2, …")
            } else {
                (
                    "a sample rate was given, so this column must count rows in whole numbers",
                    "leave out --rate where the column holds times",
                )
            };
            let problem = place.of(Problem::new(table.origin, rule, way_out));
            problem.at(table.name(column)).value(cell)
        });
        None
    }

    fn not_growing(&self, last: f64, time: f64, place: Place) -> Problem {
        let name = self.time_at.map_or("time", |at| self.name(at));
        let (rule, way_out) = if time == last {
            ("the time is that of the row before".to_string(), "remove one of the two rows")
        } else if self.record_at.is_none() {
            let rule = format!("time goes back from {last} s");
            (rule, "if a new record begins here, add a column record: 0, 0, …, 1, 1, …")
        } else {
            let rule = format!("time goes back from {last} s inside a record");
            (rule, "sort the rows, or give the new record its own number")
        };
        place.of(Problem::new(self.origin, rule, way_out)).at(name).value(format!("{time} s"))
    }

    /// The log, or everything that is wrong with the rows.
    pub(super) fn finish(self) -> Result<Log, Problems> {
        if !self.problems.is_empty() {
            return Err(Problems::new(self.problems).with_omitted(self.omitted));
        }
        if self.time.is_empty() {
            let way_out = "give at least one row below the header";
            return Err(Problem::new(self.origin, "has no rows of data", way_out).into());
        }
        let left_out = self.heads.iter().filter_map(|head| match &head.role {
            Role::LeftOut(why) => Some(LeftOut::new(&head.name, why)),
            _ => None,
        });
        let remarks = Remarks { notes: Vec::new(), left_out: left_out.collect() };
        let columns = self.heads.into_iter().zip(self.values);
        let columns = columns.filter(|(head, _)| head.role == Role::Signal);
        let columns = columns.map(|(head, values)| {
            let Head { name, unit, description, .. } = head;
            Column { name, unit, description, values }
        });
        Ok(Log {
            origin: self.origin.into(),
            time: self.time,
            lines: self.lines,
            columns: columns.collect(),
            records: self.records,
            is_numbered: self.record_at.is_some(),
            rounded: Vec::new(),
            remarks,
        })
    }
}

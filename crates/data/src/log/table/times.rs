//! Which record a row belongs to, and its time.

use super::super::header::Role;
use super::super::lines::Place;
use super::super::repeats;
use super::super::ticks::EXACT;
use super::super::units::SECOND;
use super::Table;
use crate::Problem;

/// The times of rows that have none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::log) struct Grid {
    /// In Hz.
    pub(in crate::log) rate: f64,
    /// Time of the first row, in s.
    pub(in crate::log) start: f64,
}

impl Grid {
    pub(in crate::log) fn at_rate(rate: Option<f64>) -> Self {
        Self { rate: rate.unwrap_or(1.0), start: 0.0 }
    }

    pub(super) fn at(self, row: f64) -> f64 {
        let after = row / self.rate;
        // Decimals as a reader would give: -0.02 + 7/1000 is the double -0.013.
        let integer = (self.start * self.rate).round();
        if (integer - self.start * self.rate).abs() < 1e-9 * integer.abs() {
            (integer + row) / self.rate
        } else {
            self.start + after
        }
    }
}

impl Table<'_> {
    /// Record and time of the row in `cells`, and whether it has the time of the row before; `None` where they are
    /// wrong, which is noted.
    pub(super) fn place(&mut self, place: Place) -> Option<(i64, f64, bool)> {
        let record = match self.record_at.and_then(|at| self.cells.get(at).copied()) {
            Some(number) => self.integer(number, self.record_at.unwrap_or(0), place)?,
            None => self.part,
        };
        let is_new = self.last.is_none_or(|(last, _)| last != record);
        if is_new && !self.seen.insert(record) {
            self.note(|table| {
                let way_out = "keep the rows of a record together, or number it differently";
                let name = table.record_at.map_or("record", |at| table.name(at));
                let problem = Problem::new(table.origin, "the record appeared before", way_out);
                place.locate(problem).at(name).value(record)
            });
        }
        let time = self.time_of(is_new)?;
        let last = self.last.replace((record, time)).filter(|_| !is_new).map(|(_, last)| last);
        if let Some(last) = last.filter(|last| time < *last) {
            self.note(|table| table.not_growing(last, time, place));
            return None;
        }
        Some((record, time, last == Some(time)))
    }

    /// Time in s of the row in `cells`; NaN cells were reported before.
    fn time_of(&mut self, is_new: bool) -> Option<f64> {
        let count = |table: &Self| {
            let start = if is_new { table.time.len() } else { table.records.last()?.rows.start };
            Some(table.grid.at((table.time.len() - start) as f64))
        };
        let Some(at) = self.time_at else { return count(self) };
        let cell = self.cells.get(at).copied();
        match &self.heads.get(at)?.role {
            Role::Time(unit) => {
                let cell = cell.filter(|cell| !cell.is_nan())?;
                // Division by a whole number gives the decimals that a text would have.
                if self.ticks > 0.0 { Some(cell / self.ticks) } else { unit.convert(cell, &SECOND) }
            }
            Role::Instant(_) => cell.filter(|cell| !cell.is_nan()),
            // Whether it counts rows is known at the end.
            _ => count(self),
        }
    }

    /// Times of rows by a column that counts them; `None`, and why, where it does not.
    pub(super) fn count_rows(&mut self) -> Option<String> {
        let at = self
            .time_at
            .filter(|at| self.heads.get(*at).is_some_and(|head| head.role == Role::Index))?;
        let counters = self.values.get(at)?;
        if self.records.iter().all(|record| repeats::counts(&counters[record.rows.clone()])) {
            for (time, counter) in self.time.iter_mut().zip(counters) {
                *time = self.grid.at(*counter);
            }
            return None;
        }
        Some(format!(
            "\"{}\" does not count rows: it is left out, and times are made from the sample rate, {} Hz",
            self.name(at),
            self.grid.rate
        ))
    }

    /// The number of a record.
    fn integer(&mut self, cell: f64, column: usize, place: Place) -> Option<i64> {
        if cell.is_nan() {
            return None;
        }
        if cell.fract() == 0.0 && cell.abs() <= EXACT {
            return Some(cell as i64);
        }
        self.note(|table| {
            let (rule, way_out) = ("a record has a whole number", "number the records 0, 1, 2, …");
            let problem = place.locate(Problem::new(table.origin, rule, way_out));
            problem.at(table.name(column)).value(cell)
        });
        None
    }

    fn not_growing(&self, last: f64, time: f64, place: Place) -> Problem {
        let name = self.time_at.map_or("time", |at| self.name(at));
        let (rule, way_out) = if self.record_at.is_none() {
            let rule = format!("time goes back from {last} s");
            (rule, "if a new record begins here, add a column record: 0, 0, …, 1, 1, …")
        } else {
            let rule = format!("time goes back from {last} s inside a record");
            (rule, "sort the rows, or give the new record its own number")
        };
        place.locate(Problem::new(self.origin, rule, way_out)).at(name).value(format!("{time} s"))
    }
}

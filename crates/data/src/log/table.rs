//! Rows of a file on their way into a [`Log`].

mod times;

use std::collections::BTreeSet;

pub(super) use self::times::Grid;
use super::header::{Head, Role};
use super::lines::{Lines, Place};
use super::notes::{LeftOut, Remarks};
use super::repeats::{self, Repeats};
use super::text::Since;
use super::ticks::{self, Base};
use super::{Column, Log, Record, cell};
use crate::{Problem, Problems, counted};

/// Problems that are listed; the rest is counted.
const MOST_PROBLEMS: usize = 20;

/// The rows that were read so far.
pub(super) struct Table<'a> {
    origin: &'a str,
    heads: Vec<Head>,
    grid: Grid,
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
    /// Whether numbers have decimal commas.
    has_commas: bool,
    /// Number of the part of the file, where it has several and no column of records.
    part: i64,
    since: Since,
    /// What is taken off all times, in their unit.
    base: Base,
    /// Ticks of a second, where something is taken off.
    ticks: f64,
    repeats: Repeats,
    /// Rows with a remark behind their last cell.
    remarks: usize,
}

impl<'a> Table<'a> {
    pub(super) fn new(origin: &'a str, heads: Vec<Head>, grid: Grid) -> Self {
        let at = |wanted: fn(&Role) -> bool| heads.iter().position(|head| wanted(&head.role));
        let skipped: Vec<bool> = heads
            .iter()
            .map(|head| matches!(head.role, Role::LeftOut(_) | Role::Instant(_)))
            .collect();
        Self {
            origin,
            grid,
            skipped: if skipped.contains(&true) { skipped } else { Vec::new() },
            values: vec![Vec::new(); heads.len()],
            time: Vec::new(),
            lines: Lines::default(),
            records: Vec::new(),
            seen: BTreeSet::new(),
            problems: Vec::new(),
            omitted: 0,
            last: None,
            time_at: at(|role| matches!(role, Role::Time(_) | Role::Instant(_) | Role::Index)),
            record_at: at(|role| *role == Role::Record),
            cells: Vec::with_capacity(heads.len()),
            heads,
            has_commas: false,
            part: 0,
            since: Since::default(),
            base: Base::default(),
            ticks: 0.0,
            repeats: Repeats::default(),
            remarks: 0,
        }
    }

    /// Numbers have decimal commas from here on.
    pub(super) fn with_commas(mut self, has_commas: bool) -> Self {
        self.has_commas = has_commas;
        self
    }

    /// All times are given without this number.
    pub(super) fn with_base(mut self, base: Base) -> Self {
        self.take_off(base);
        self
    }

    fn take_off(&mut self, base: Base) {
        self.base = base;
        if let Some(Role::Time(unit)) = self.time_at.and_then(|at| Some(&self.heads.get(at)?.role))
            && !base.is_none()
            && (1.0 / unit.factor).round() >= 1.0
        {
            self.ticks = (1.0 / unit.factor).round();
        }
    }

    /// The column of numbers that are times, and what is taken off them if the first row has this cell there.
    pub(super) fn begin_times<'c>(
        &mut self,
        cell: impl FnOnce(usize) -> Option<&'c [u8]>,
    ) -> Option<(usize, Base)> {
        let at = self.time_at?;
        if !matches!(self.heads.get(at)?.role, Role::Time(_)) {
            return None;
        }
        if self.last.is_none() && self.base.is_none() {
            self.take_off(cell(at).and_then(ticks::integer).map(Base::of).unwrap_or_default());
        }
        (!self.base.is_none()).then_some((at, self.base))
    }

    /// The number of columns, where each row of them is numbers with decimal points.
    pub(super) fn plain_columns(&self) -> Option<usize> {
        (self.skipped.is_empty() && !self.has_commas).then_some(self.heads.len())
    }

    /// The times of rows that have none.
    pub(super) fn grid(&self) -> Grid {
        self.grid
    }

    /// Begins a new part of the file with a grid of its own; one that goes on in time is the same record.
    pub(super) fn begin_part(&mut self, grid: Grid) {
        let has_times = !matches!(
            self.time_at.and_then(|at| self.heads.get(at)),
            None | Some(Head { role: Role::Index, .. })
        );
        let (rows, rate) = (self.records.last().map_or(0, |open| open.rows.len()), self.grid.rate);
        let goes_on =
            grid.rate == rate && (grid.start - self.grid.at(rows as f64)).abs() * rate < 0.01;
        if has_times || !goes_on {
            self.part += 1;
            self.grid = grid;
        }
    }

    /// Leaves a column of signals out, and says why.
    pub(super) fn leave_out(&mut self, column: usize, why: String) {
        if let Some(head) = self.heads.get_mut(column)
            && head.role == Role::Signal
        {
            head.role = Role::LeftOut(why);
        }
    }

    /// Notes that a further part of the file, which begins at `place`, has other names than the first.
    pub(super) fn other_names(&mut self, names: &[String], cells: &[&[u8]], place: Place) {
        let names = names.join(", ");
        let cells: Vec<_> = cells.iter().map(|cell| String::from_utf8_lossy(cell)).collect();
        let cells: String = cells.join(", ").chars().take(200).collect();
        self.note(|table| {
            let rule =
                format!("a part begins with other columns, {cells}, than the first, {names}");
            place.locate(Problem::new(table.origin, rule, "save the parts to files of their own"))
        });
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
    pub(super) fn row<'c>(
        &mut self,
        row: impl ExactSizeIterator<Item = &'c [u8]> + Clone,
        place: Place,
    ) {
        if row.len() != self.heads.len() {
            return self.other_length(row, place);
        }
        self.cells_of(row, place);
    }

    /// A row of another length: cells of columns that are not read may be missing or follow.
    fn other_length<'c>(
        &mut self,
        row: impl ExactSizeIterator<Item = &'c [u8]> + Clone,
        place: Place,
    ) {
        let (found, wanted) = (row.len(), self.heads.len());
        let missing = found < wanted && (found..wanted).all(|at| self.is_skipped(at));
        // A remark behind the last cell, where the header has none.
        let is_loose = !self.skipped.is_empty() || self.part > 0;
        let behind: Vec<&[u8]> = row.clone().skip(wanted).collect();
        let extra = found > wanted
            && (behind.iter().all(|cell| cell.is_empty())
                || is_loose && behind.iter().all(|cell| cell::parse(cell).is_err()));
        if !missing && !extra {
            self.note(|table| table.ragged(found, place));
            return;
        }
        self.remarks += usize::from(behind.iter().any(|cell| !cell.is_empty()));
        let mut cells: Vec<&[u8]> = row.take(wanted).collect();
        cells.resize(wanted, &[]);
        self.cells_of(cells.into_iter(), place);
    }

    fn cells_of<'c>(&mut self, mut row: impl Iterator<Item = &'c [u8]> + Clone, place: Place) {
        self.cells.clear();
        let mut is_good = true;
        let base = self.begin_times(|at| row.clone().nth(at));
        for (column, cell) in row.clone().enumerate() {
            if self.is_skipped(column) {
                self.cells.push(0.0);
                continue;
            }
            let number = match self.has_commas {
                true => cell::parse_with_comma(cell),
                false => cell::parse(cell),
            };
            let number = match base.filter(|(at, _)| *at == column) {
                Some((_, base)) => base.cell(cell),
                None => number,
            };
            let number = number.unwrap_or_else(|(rule, way_out)| {
                // What is no counter of rows is not needed: the rate says the times.
                if self.heads.get(column).is_some_and(|head| head.role == Role::Index) {
                    return f64::NAN;
                }
                is_good = false;
                self.note(|table| {
                    let problem = place.locate(Problem::new(table.origin, rule, way_out));
                    let shown = String::from_utf8_lossy(&cell[..cell.len().min(200)]);
                    problem.at(table.name(column)).value(format!("\"{shown}\""))
                });
                f64::NAN
            });
            self.cells.push(number);
        }
        if let Some((at, Role::Instant(day))) =
            self.time_at.and_then(|at| Some((at, &self.heads.get(at)?.role)))
        {
            let day = *day;
            let day = day.and_then(|day| row.clone().nth(day));
            let cell = row.nth(at).unwrap_or_default();
            self.cells[at] = self.since.seconds(cell, day).unwrap_or_else(|| {
                is_good = false;
                self.note(|table| {
                    let rule = "is no date or clock time as in the first row";
                    let problem =
                        Problem::new(table.origin, rule, "write it as in 2026-11-25 03:00:00.001");
                    let shown = String::from_utf8_lossy(&cell[..cell.len().min(200)]);
                    place.locate(problem).at(table.name(at)).value(format!("\"{shown}\""))
                });
                f64::NAN
            });
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
                    let problem = place.locate(Problem::new(table.origin, rule, way_out));
                    problem.at(table.name(column)).value(table.cells[column])
                });
                self.cells[column] = f64::NAN;
            }
        }
        self.keep(is_good, place);
    }

    /// Keeps the row in `cells`, unless it is wrong.
    fn keep(&mut self, is_good: bool, place: Place) {
        let Some((record, time, is_jump)) = self.place(place) else { return };
        if !is_good {
            return;
        }
        if is_jump && self.records.last().is_some_and(|open| open.id == record) {
            return self.jump(time, place);
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

    /// The row in `cells` has the time of the row before, and takes its place.
    fn jump(&mut self, time: f64, place: Place) {
        let Some(last) = self.time.len().checked_sub(1) else { return };
        let is_read = |at: usize| self.skipped.get(at) != Some(&true) && self.time_at != Some(at);
        let starts = self.records.last().map_or(0, |open| open.rows.start);
        let was_held = last > starts
            && (0..self.values.len()).filter(|at| is_read(*at)).all(|at| {
                let values = &self.values[at];
                values[last] == values[last - 1]
            });
        let is_third = self.repeats.last == Some(last);
        self.repeats.rows += 1;
        self.repeats.held += usize::from(was_held);
        self.repeats.third += usize::from(is_third);
        self.repeats.last = Some(last);
        self.repeats.first.get_or_insert((place, time));
        self.lines.push(last, place);
        for (at, (column, cell)) in self.values.iter_mut().zip(&self.cells).enumerate() {
            if self.skipped.get(at) != Some(&true) {
                column[last] = *cell;
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
        place.locate(Problem::new(self.origin, rule, way_out))
    }

    /// The log, or everything that is wrong with the rows.
    pub(super) fn finish(mut self) -> Result<Log, Problems> {
        if !self.problems.is_empty() {
            return Err(Problems::new(self.problems).with_omitted(self.omitted));
        }
        if self.time.is_empty() {
            let way_out = "give at least one row below the header";
            return Err(Problem::new(self.origin, "has no rows of data", way_out).into());
        }
        let mut notes: Vec<String> =
            self.count_rows().into_iter().chain(self.repeats.note()).collect();
        if let Some((place, time)) =
            self.repeats.first.filter(|_| self.repeats.are_too_many(self.time.len()))
        {
            let rows = self.time.len() + self.repeats.rows;
            let rule = format!(
                "the time is that of the row before, as in {} of {rows} rows: times are written with too few digits",
                self.repeats.rows
            );
            let problem =
                place.locate(Problem::new(self.origin, rule, "give the sample rate: --rate HZ"));
            let name = self.time_at.map_or("time", |at| self.name(at));
            return Err(problem.at(name).value(format!("{time} s")).into());
        }
        if self.remarks > 0 {
            notes.push(format!(
                "remarks behind the last cell are skipped, in {}",
                counted(self.remarks, "row")
            ));
        }
        let is_stated = self
            .time_at
            .and_then(|at| self.heads.get(at))
            .is_none_or(|head| head.unit.is_some() || !matches!(head.role, Role::Time(_)));
        let doubts = self.records.iter().filter_map(|record| {
            repeats::doubt(&self.time[record.rows.clone()], is_stated, self.base.value())
        });
        notes.extend(doubts.take(1));
        if !self.base.is_none() {
            let unit = self.time_at.and_then(|at| self.heads.get(at)?.unit.as_ref());
            let unit = unit.map_or("s", |unit| unit.text.as_str());
            notes.push(format!(
                "times are those after the first row, at {} {unit}: a double has too few digits for both",
                self.base
            ));
        }
        let left_out = self.heads.iter().filter_map(|head| match &head.role {
            Role::LeftOut(why) if !why.is_empty() => Some(LeftOut::new(&head.name, why)),
            _ => None,
        });
        let remarks = Remarks { notes, left_out: left_out.collect(), ..Remarks::default() };
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
            names: Default::default(),
            is_numbered: self.record_at.is_some() || self.part > 0,
            rounded: Vec::new(),
            remarks,
        })
    }
}

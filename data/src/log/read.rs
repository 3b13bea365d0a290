//! From CSV to a [`Log`].

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use csv::ByteRecord;

use super::dataset::{self, Dataset};
use super::header::{Context, Head, Role, SECOND};
use super::{Column, Log, ReadOptions, Record, cell};
use crate::{Problem, Problems};

/// Problems that are listed; the rest is counted.
const MOST_PROBLEMS: usize = 20;
/// Bytes within which the header must end.
const LONGEST_HEADER: usize = 1 << 20;

pub(super) fn file(path: &Path, options: &ReadOptions) -> Result<Log, Problems> {
    let origin = path.display().to_string();
    let unreadable = |error: std::io::Error| {
        let rule = format!("cannot be read: {error}");
        Problems::from(Problem::new(&origin, rule, "check the name and the permissions"))
    };
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().is_ok_and(|found| found.is_dir()) {
        let problem = Problem::new(&origin, "is a folder", "give the name of a file in it");
        return Err(problem.into());
    }
    let datasets = dataset::beside(path)?;
    let bytes = BufReader::with_capacity(LONGEST_HEADER, file);
    read(bytes, &origin, options, &datasets)
}

pub(super) fn text(bytes: &[u8], origin: &str, options: &ReadOptions) -> Result<Log, Problems> {
    read(bytes, origin, options, &[])
}

fn read(
    mut bytes: impl BufRead,
    origin: &str,
    options: &ReadOptions,
    datasets: &[Dataset],
) -> Result<Log, Problems> {
    if let Some(rate) = options.rate.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
        let problem = Problem::new(origin, "is no sample rate", "give a positive number of Hz");
        return Err(problem.at("--rate").value(rate).into());
    }
    check_is_text(&mut bytes, origin)?;
    let mut rows = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
    let mut row = ByteRecord::new();
    let broken = |error: csv::Error| {
        let rule = format!("cannot be read: {error}");
        Problems::from(Problem::new(origin, rule, "check the disk or the connection"))
    };
    if !rows.read_byte_record(&mut row).map_err(broken)? {
        let way_out = "give a header row and data rows";
        return Err(Problem::new(origin, "is empty", way_out).into());
    }
    let line = line_of(&row);
    let cells = header_cells(&row, origin, line)?;
    let context = Context { file: origin, line, options, datasets };
    let (heads, problems) = context.heads(&cells);
    let mut table = Table::new(origin, heads, context.rate());
    // Without a place for each cell, the rows mean nothing.
    if !problems.is_empty() {
        return Err(Problems::new(problems));
    }
    while rows.read_byte_record(&mut row).map_err(broken)? {
        table.row(&row);
    }
    table.finish()
}

/// Refuses what is no text before a parser makes nonsense of it.
fn check_is_text(bytes: &mut impl BufRead, origin: &str) -> Result<(), Problems> {
    let refuse = |rule: &str| {
        Err(Problem::new(origin, rule, "save the log as CSV in UTF-8, with commas").into())
    };
    let head = match bytes.fill_buf() {
        Ok(head) => &head[..head.len().min(LONGEST_HEADER)],
        Err(error) => return refuse(&format!("cannot be read: {error}")),
    };
    match head {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => return refuse("is text in UTF-16"),
        [b'P', b'K', 3, 4, ..] => return refuse("is a zip archive or a workbook"),
        [b'M', b'D', b'F', b' ', ..] => return refuse("is a measurement file in MDF"),
        _ => {}
    }
    if head.contains(&0) {
        return refuse("is no text but binary data");
    }
    if head.len() == LONGEST_HEADER && !head.contains(&b'\n') && !head.contains(&b'\r') {
        return refuse("has no line end in its first mebibyte");
    }
    Ok(())
}

fn line_of(row: &ByteRecord) -> usize {
    row.position().map_or(0, |position| usize::try_from(position.line()).unwrap_or(0))
}

/// The header's cells as texts.
fn header_cells(row: &ByteRecord, origin: &str, line: usize) -> Result<Vec<String>, Problems> {
    let refuse = |rule: &str, way_out: &str| {
        Err(Problems::from(Problem::new(origin, rule, way_out).line(line)))
    };
    let Ok(cells) = row
        .iter()
        .map(|cell| str::from_utf8(cell).map(str::to_string))
        .collect::<Result<Vec<_>, _>>()
    else {
        return refuse("the header is no UTF-8", "save the file as UTF-8");
    };
    let way_out = "save the file with commas between cells and decimal points";
    if let [only] = cells.as_slice() {
        if only.contains(';') {
            return refuse("the columns are separated by semicolons", way_out);
        }
        if only.contains('\t') {
            return refuse("the columns are separated by tabs", way_out);
        }
    }
    if cells.iter().all(|cell| cell::parse(cell.as_bytes()).is_ok()) {
        let way_out = "put a first line with the names of the columns, as in time,u,y";
        return refuse("has no header: the first line holds numbers", way_out);
    }
    Ok(cells)
}

/// The rows that were read so far.
struct Table<'a> {
    origin: &'a str,
    heads: Vec<Head>,
    rate: f64,
    /// Values of all columns, those that are no signals too.
    values: Vec<Vec<f64>>,
    time: Vec<f64>,
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
    fn new(origin: &'a str, heads: Vec<Head>, rate: Option<f64>) -> Self {
        let at = |wanted: fn(&Role) -> bool| heads.iter().position(|head| wanted(&head.role));
        Self {
            origin,
            rate: rate.unwrap_or(1.0),
            values: vec![Vec::new(); heads.len()],
            time: Vec::new(),
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

    fn name(&self, column: usize) -> &str {
        self.heads.get(column).map_or("", |head| head.name.as_str())
    }

    fn row(&mut self, row: &ByteRecord) {
        let line = line_of(row);
        if row.len() != self.heads.len() {
            self.note(|table| table.ragged(row, line));
            return;
        }
        self.cells.clear();
        let mut is_good = true;
        for (column, bytes) in row.iter().enumerate() {
            let number = cell::parse(bytes).unwrap_or_else(|(rule, way_out)| {
                is_good = false;
                self.note(|table| {
                    let problem = Problem::new(table.origin, rule, way_out).line(line);
                    let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]);
                    problem.at(table.name(column)).value(format!("\"{shown}\""))
                });
                f64::NAN
            });
            self.cells.push(number);
        }
        let Some((record, time)) = self.place(line) else { return };
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
        for (column, cell) in self.values.iter_mut().zip(&self.cells) {
            column.push(*cell);
        }
    }

    fn ragged(&self, row: &ByteRecord, line: usize) -> Problem {
        let (found, wanted) = (row.len(), self.heads.len());
        let way_out = if found == 2 * wanted || found == 2 * wanted - 1 {
            "if the numbers have decimal commas, save the file with decimal points"
        } else {
            "give each row as many cells as the header has names; look for a line that was cut off"
        };
        let rule = format!("the row has {found} cells, the header {wanted}");
        Problem::new(self.origin, rule, way_out).line(line)
    }

    /// Record and time of the row in `cells`; `None` where they are wrong, which is noted.
    fn place(&mut self, line: usize) -> Option<(i64, f64)> {
        let record = match self.record_at.and_then(|at| self.cells.get(at).copied()) {
            Some(number) => self.whole(number, self.record_at.unwrap_or(0), line)?,
            None => 0,
        };
        let is_new = self.last.is_none_or(|(last, _)| last != record);
        if is_new && !self.seen.insert(record) {
            self.note(|table| {
                let way_out = "keep the rows of a record together, or number it differently";
                let name = table.record_at.map_or("record", |at| table.name(at));
                Problem::new(table.origin, "the record appeared before", way_out)
                    .line(line)
                    .at(name)
                    .value(record)
            });
        }
        let time = self.time_of(is_new, line)?;
        let last = self.last.replace((record, time)).filter(|_| !is_new).map(|(_, last)| last);
        if let Some(last) = last.filter(|last| time <= *last) {
            self.note(|table| table.not_growing(last, time, line));
            return None;
        }
        Some((record, time))
    }

    /// Time in s of the row in `cells`; NaN cells were reported before.
    fn time_of(&mut self, is_new: bool, line: usize) -> Option<f64> {
        let Some(at) = self.time_at else {
            let start = if is_new { self.time.len() } else { self.records.last()?.rows.start };
            return Some((self.time.len() - start) as f64 / self.rate);
        };
        let cell = self.cells.get(at).copied().filter(|cell| !cell.is_nan())?;
        match self.heads.get(at)?.role {
            Role::Time(unit) => unit.convert(cell, &SECOND),
            _ => Some(self.whole(cell, at, line)? as f64 / self.rate),
        }
    }

    /// A cell that must be a whole number.
    fn whole(&mut self, cell: f64, column: usize, line: usize) -> Option<i64> {
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
            let problem = Problem::new(table.origin, rule, way_out).line(line);
            problem.at(table.name(column)).value(cell)
        });
        None
    }

    fn not_growing(&self, last: f64, time: f64, line: usize) -> Problem {
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
        Problem::new(self.origin, rule, way_out).line(line).at(name).value(format!("{time} s"))
    }

    fn finish(self) -> Result<Log, Problems> {
        if !self.problems.is_empty() {
            return Err(Problems::new(self.problems).with_omitted(self.omitted));
        }
        if self.time.is_empty() {
            let way_out = "give at least one row below the header";
            return Err(Problem::new(self.origin, "has no rows of data", way_out).into());
        }
        let columns = self.heads.into_iter().zip(self.values);
        let columns = columns.filter(|(head, _)| head.role == Role::Signal);
        let columns = columns.map(|(head, values)| {
            let Head { name, unit, description, .. } = head;
            Column { name, unit, description, values }
        });
        Ok(Log {
            origin: self.origin.into(),
            time: self.time,
            columns: columns.collect(),
            records: self.records,
            is_numbered: self.record_at.is_some(),
        })
    }
}

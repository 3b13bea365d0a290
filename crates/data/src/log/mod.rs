//! Logs: measured or simulated time series with units, in records.
//!
//! Row k of a log: the inputs u_k act from t_k until t_{k+1} (zero-order hold); the outputs y_k are
//! read at t_k, before u_k acts.
//!
//! Files of other programs are read where the feature `formats` is on ([`Log::FORMATS`]); `docs/files.md` says what of them,
//! and through what.
//!
//! A text is CSV: UTF-8, commas, decimal points, one header row. `time` in s grows strictly inside
//! a record; a column `record` (or `realization`) of whole numbers separates records, and time may
//! start again there. Units come, the first that is found, from the caller's list
//! ([`ReadOptions::units`]), the header (`y [um]`), a file `<name>.dataset.toml` beside the log, or a
//! file `dataset.toml` in its folder:
//!
//! ```toml
//! rate = 200                                  # Hz; for logs without a column of time
//! time = { column = "t", unit = "ms" }        # default: column "time" in s
//!
//! [columns]
//! y = { unit = "um", description = "Position of the stage" }
//! ```
//!
//! Logs are also written as Parquet (feature `parquet`) and as MF4.

mod cell;
mod dataset;
#[cfg(feature = "formats")]
mod formats;
#[cfg(not(feature = "formats"))]
#[path = "no_formats.rs"]
mod formats;
mod group;
mod header;
mod header_cell;
mod join;
mod lines;
mod mf4;
mod names;
mod notes;
#[cfg(feature = "parquet")]
mod parquet;
mod quality;
mod repeats;
mod rounded;
mod rows;
mod table;
mod text;
mod ticks;
mod time_column;
mod units;
mod write;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use model::Unit;

use lines::{Lines, Place};

pub use dataset::sidecar_of;
#[cfg(feature = "formats")]
pub use formats::Format;
pub use join::Resample;
pub use mf4::{Mf4About, Mf4Writer};
pub use notes::LeftOut;
#[cfg(feature = "parquet")]
pub use parquet::ParquetLogWriter;
pub(crate) use quality::median;
pub use quality::{Finding, Quality};
pub use rounded::Rounded;
pub use rows::SampleTime;
pub use write::{ColumnHeader, LogWriter, UnitPlace, check_sidecar, renew_sidecar, write_sidecar};

use crate::{Problem, Problems, nearest};

/// Measured or simulated time series.
#[derive(Clone, Debug)]
pub struct Log {
    /// File, for messages.
    origin: String,
    time: Vec<f64>,
    lines: Lines,
    columns: Vec<Column>,
    names: names::Names,
    records: Vec<Record>,
    /// Whether the records are numbered in the file.
    is_numbered: bool,
    rounded: Vec<Rounded>,
    remarks: notes::Remarks,
}

/// Logs are equal where they hold the same; the lines on which it stands do not count.
impl PartialEq for Log {
    fn eq(&self, other: &Self) -> bool {
        self.origin == other.origin
            && self.time == other.time
            && self.columns == other.columns
            && self.records == other.records
            && self.is_numbered == other.is_numbered
    }
}

/// One signal of a [`Log`].
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name, as in `y` or `position[1]`.
    pub name: String,
    /// Unit; `None` where nothing says it: then it is the unit of the variable it belongs to.
    pub unit: Option<ColumnUnit>,
    /// One sentence; may be empty.
    pub description: String,
    /// One value per row, each finite.
    pub values: Vec<f64>,
}

/// A unit as text and as factor and exponents.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnUnit {
    /// As it was given, as in `um`.
    pub text: String,
    /// Factor, offset and exponents, to compute with.
    pub unit: Unit,
}

/// Rows that were recorded in one go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Record {
    /// The record's number in the column `record`; 0 where there is none.
    pub id: i64,
    /// The record's rows, from 0.
    pub rows: Range<usize>,
}

/// What a caller says about a file that is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Sample rate in Hz, for logs without a column of time or with a column of row numbers.
    pub rate: Option<f64>,
    /// The column of time, before what a dataset names.
    pub time: Option<String>,
    /// Units by column, as texts; they go before those of the file.
    pub units: BTreeMap<String, String>,
    /// Which group of a measurement file (MDF, TDMS) or which length of arrays (MAT, npz) is the
    /// log, where there are several.
    pub group: Option<String>,
    /// Most bytes of memory that the numbers of a binary file may take; `None`: 256 MiB, or 100 times
    /// the file's size where that is more.
    pub memory: Option<u64>,
    /// Names of the columns, with units as in `y [um]`, for texts without a header; they replace those of one.
    pub columns: Vec<String>,
    /// Onto which uniform times the log is brought; groups with different times are joined so.
    pub resample: Option<Resample>,
}

/// Sample rates in Hz, and sample times in s, that can be meant; with others the times of long logs are not finite.
const RATES: std::ops::RangeInclusive<f64> = 1e-12..=1e12;
const GIVE_A_RATE: &str = "give a number of Hz from 1e-12 to 1e12";

impl ReadOptions {
    fn check(&self, origin: &str) -> Result<(), Problems> {
        match self.rate.filter(|rate| !RATES.contains(rate)) {
            Some(rate) => {
                let problem = Problem::new(origin, "is no sample rate", GIVE_A_RATE);
                Err(problem.at("--rate").value(rate).into())
            }
            None => Ok(()),
        }
    }

    /// Takes a unit as a command line gives it, `y=um`.
    ///
    /// # Errors
    /// The text has no `=`, a side is empty, or the unit is none.
    pub fn add_unit(&mut self, assignment: &str) -> Result<(), Problems> {
        let problem = |rule: String| {
            let way_out = "write COLUMN=UNIT, as in y=um";
            Problems::from(Problem::new("--unit", rule, way_out).value(assignment))
        };
        let (column, unit) = assignment
            .split_once('=')
            .map(|(column, unit)| (column.trim(), unit.trim()))
            .filter(|(column, unit)| !column.is_empty() && !unit.is_empty())
            .ok_or_else(|| problem("is no assignment of a unit to a column".into()))?;
        ColumnUnit::parse(unit).map_err(|error| problem(error.to_string()))?;
        self.units.insert(column.into(), unit.into());
        Ok(())
    }
}

impl Log {
    /// Every format that is no text, in the order in which a file's first bytes are held against them.
    #[cfg(feature = "formats")]
    pub const FORMATS: &'static [Format] = formats::FORMATS;

    /// Reads a file. Times that were rounded when they were written are taken as those of a uniform grid,
    /// see [`rounded`](Self::rounded).
    ///
    /// # Errors
    /// Every [`Problem`] of the file, up to 20, and how many more there are.
    pub fn read(path: &Path, options: &ReadOptions) -> Result<Self, Problems> {
        files::note_read(path);
        text::file(path, options)?.resolved_by(options)
    }

    /// Reads a text, with nothing beside it; `origin` is what messages call it.
    ///
    /// # Errors
    /// Every [`Problem`] of the text, up to 20, and how many more there are.
    pub fn parse(bytes: &[u8], origin: &str, options: &ReadOptions) -> Result<Self, Problems> {
        text::text(bytes, origin, options)?.resolved_by(options)
    }

    /// With rounded times mended, and on uniform times where these are asked for.
    fn resolved_by(self, options: &ReadOptions) -> Result<Self, Problems> {
        let mut log = self.with_times_on_grids();
        if let Some(group) = options.group.as_ref().filter(|_| !log.remarks.is_chosen) {
            let note = format!("--group {group} has no effect: a file of this kind has no groups");
            log.remarks.notes.push(note);
        }
        match options.resample.filter(|_| !log.remarks.is_joined) {
            Some(resample) => log.resampled(resample, options.memory),
            None => Ok(log),
        }
    }

    /// A log of one record with these times in s and no columns yet; `origin` is what messages call
    /// it.
    ///
    /// # Errors
    /// The times do not grow strictly or are not finite; the first place.
    pub fn new(origin: &str, time: Vec<f64>) -> Result<Self, Problems> {
        let rows = 0..time.len();
        Self::of_records(origin, time, vec![Record { id: 0, rows }], false)
    }

    /// A log of several records, each with its number and its length, and no columns yet.
    ///
    /// # Errors
    /// The times do not grow strictly inside a record or are not finite, the lengths do not add up, or a number
    /// is used twice.
    pub fn with_records(
        origin: &str,
        time: Vec<f64>,
        records: &[(i64, usize)],
    ) -> Result<Self, Problems> {
        let mut start = 0usize;
        let ranges = records.iter().map(|(id, length)| {
            let rows = start..start.saturating_add(*length);
            start = rows.end;
            Record { id: *id, rows }
        });
        let ranges: Vec<Record> = ranges.collect();
        if start != time.len() {
            let rule =
                format!("the records have {start} rows together, the log has {}", time.len());
            return Err(Problem::new(origin, rule, "give each row one record").into());
        }
        for (index, record) in ranges.iter().enumerate() {
            if ranges[..index].iter().any(|other| other.id == record.id) {
                let rule = format!("two records have the number {}", record.id);
                return Err(Problem::new(origin, rule, "number each differently").into());
            }
        }
        Self::of_records(origin, time, ranges, true)
    }

    fn of_records(
        origin: &str,
        time: Vec<f64>,
        records: Vec<Record>,
        is_numbered: bool,
    ) -> Result<Self, Problems> {
        for rows in records.iter().map(|record| record.rows.clone()) {
            let mut last = f64::NEG_INFINITY;
            for (time, row) in time[rows.clone()].iter().zip(rows.start + 1..) {
                if !(time.is_finite() && *time > last) {
                    let rule = format!("row {row}: time must be finite and grow strictly");
                    let way_out = "sort the rows, or begin a new record";
                    return Err(Problem::new(origin, rule, way_out).at("time").value(time).into());
                }
                last = *time;
            }
        }
        let (lines, columns) = (Lines::default(), Vec::new());
        let (rounded, remarks) = (Vec::new(), notes::Remarks::default());
        let origin = origin.into();
        let names = names::Names::default();
        Ok(Self { origin, time, lines, columns, names, records, is_numbered, rounded, remarks })
    }

    /// The name, or one like it that this log can still take: names of others' variables may hold line
    /// ends, be called `time`, or end with what is read as a unit.
    #[must_use]
    pub fn free_name(&self, name: &str) -> String {
        let name = header::writable(name);
        if self.column(&name).is_none() {
            return name;
        }
        let numbered = (2_usize..).map(|number| format!("{name}_{number}"));
        numbered.into_iter().find(|name| self.column(name).is_none()).unwrap_or(name)
    }

    /// Adds a column at the end.
    ///
    /// # Errors
    /// Another length than the log, a value that is not finite, a name that exists or that no log
    /// can hold, or a unit that is none.
    pub fn add_column(
        &mut self,
        name: &str,
        unit: Option<&str>,
        values: Vec<f64>,
    ) -> Result<(), Problems> {
        let problem = |rule: String, way_out: &str| {
            Err(Problem::new(&self.origin, rule, way_out).at(name).into())
        };
        if let Err((rule, way_out)) = header::check_name(name) {
            return problem(rule, way_out);
        }
        if header::is_reserved(name) || self.column(name).is_some() {
            return problem("the log has a column of this name".into(), "choose another name");
        }
        if values.len() != self.len() {
            let rule = format!("has {} values, the log has {} rows", values.len(), self.len());
            return problem(rule, "give one value per row");
        }
        if let Some(row) = values.iter().position(|value| !value.is_finite()) {
            let rule = format!("row {}: {} is not a finite number", row + 1, values[row]);
            return problem(rule, "leave the row out");
        }
        let unit = match unit.map(ColumnUnit::parse).transpose() {
            Ok(unit) => unit,
            Err(error) => return problem(format!("unit: {error}"), "write it as in um or V"),
        };
        let description = String::new();
        self.names.added(name, self.columns.len());
        self.columns.push(Column { name: name.into(), unit, description, values });
        Ok(())
    }

    /// Puts other values in a column's place, record by record: `of` gets times in s and values. A column that is not there is
    /// none to change.
    pub fn replace(&mut self, name: &str, of: impl Fn(&[f64], &[f64]) -> Vec<f64>) {
        let Some(column) = self.columns.iter_mut().find(|column| column.name == name) else {
            return;
        };
        for rows in self.records.iter().map(|record| record.rows.clone()) {
            let others = of(&self.time[rows.clone()], &column.values[rows.clone()]);
            column.values[rows].iter_mut().zip(others).for_each(|(own, other)| *own = other);
        }
    }

    /// File or other origin, for messages.
    #[must_use]
    pub fn origin(&self) -> &str {
        &self.origin
    }
    /// Where row `row` (from 0) stands in its file: `log.csv:12`, or `log.mat: row 11`.
    #[must_use]
    pub fn place_of(&self, row: usize) -> String {
        match self.lines.at(row) {
            Some(Place::Line(line)) => format!("{}:{line}", self.origin),
            Some(Place::Row(number)) => format!("{}: row {number}", self.origin),
            None => format!("{}: row {}", self.origin, row + 1),
        }
    }
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }
    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }
    /// Time of each row in s.
    #[must_use]
    pub fn time(&self) -> &[f64] {
        &self.time
    }
    /// The signals in the order of the file, without `time` and `record`.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }
    /// The records, in the order of their rows.
    #[must_use]
    pub fn records(&self) -> &[Record] {
        &self.records
    }
    /// The signal of this name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.get(self.names.place(&self.columns, name)?)
    }

    /// The signal of this name, or what is there instead.
    ///
    /// # Errors
    /// There is none, or it cannot be used; the message says why, or lists those that there are.
    pub fn require(&self, name: &str) -> Result<&Column, Problems> {
        self.column(name).ok_or_else(|| {
            if let Some(problem) = self.reason_left_out(name) {
                return problem.into();
            }
            let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
            let near = nearest(name, names.iter().copied())
                .map_or_else(String::new, |near| format!("did you mean \"{near}\"? "));
            let way_out = format!("{near}the columns are {}", names.join(", "));
            Problem::new(&self.origin, "is no column of this log", way_out).at(name).into()
        })
    }

    /// The values of a signal in the unit `target`; a signal without a unit is taken to be in
    /// `target` already.
    ///
    /// # Errors
    /// There is no such signal, `target` is no unit, or the signal's unit does not convert to it.
    pub fn convert(&self, name: &str, target: &str) -> Result<Vec<f64>, Problems> {
        let column = self.require(name)?;
        let Some(own) = &column.unit else { return Ok(column.values.clone()) };
        let problem = |rule: String, way_out: String| {
            Problems::from(Problem::new(&self.origin, rule, way_out).at(name))
        };
        let unit = ColumnUnit::parse(target)
            .map(|target| target.unit)
            .map_err(|error| problem(format!("\"{target}\": {error}"), String::new()))?;
        let values = column.values.iter().map(|value| own.unit.convert(*value, &unit));
        values.collect::<Option<Vec<f64>>>().ok_or_else(|| {
            let rule = format!("is in {}, which does not convert to {target}", own.text);
            problem(rule, format!("choose another column, or say its unit: --unit {name}=…"))
        })
    }

    /// Writes the file `path` and its companion with the units, each whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path, units: UnitPlace) -> Result<(), Problems> {
        write::log(self, path, units)
    }
}

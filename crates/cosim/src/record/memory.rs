//! A record in memory.

use std::io;
use std::ops::Range;

use super::{Column, Recorder};

/// All rows, column by column. Memory is taken at the beginning of a record, not in the run. What
/// the methods show is complete when the record has ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    time: Vec<f64>,
    series: Vec<Series>,
    records: Vec<Range<usize>>,
    /// Rows that are not in the columns yet, each with its time first: writing a row to one place
    /// takes less time than to as many as there are columns.
    rows: Vec<f64>,
}

/// One recorded variable and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name and unit.
    pub column: Column,
    /// One value per row.
    pub values: Vec<f64>,
}

/// Rows that are spread out to the columns at once: few enough to stay in the processor's cache.
const ROWS_AT_ONCE: usize = 256;
/// Memory taken in advance is limited: a run may end long before its stop time.
const MOST_ROWS_AHEAD: usize = 1 << 24;

impl Memory {
    /// An empty record.
    pub fn new() -> Self {
        Memory::default()
    }

    /// Times of the rows in s, of all records one after the other.
    pub fn time(&self) -> &[f64] {
        &self.time
    }

    /// The recorded variables.
    pub fn series(&self) -> &[Series] {
        &self.series
    }

    /// The values of a variable by its name in the record.
    pub fn values(&self, name: &str) -> Option<&[f64]> {
        let found = self.series.iter().find(|series| series.column.name == name);
        found.map(|series| series.values.as_slice())
    }

    /// The rows of each record.
    pub fn records(&self) -> &[Range<usize>] {
        &self.records
    }
}

impl Memory {
    /// Moves the rows to the columns.
    #[cold]
    fn spread(&mut self) {
        let width = 1 + self.series.len();
        let column = |place: usize| self.rows.iter().skip(place).step_by(width).copied();
        self.time.extend(column(0));
        for (place, series) in (1..).zip(&mut self.series) {
            series.values.extend(column(place));
        }
        if let Some(record) = self.records.last_mut() {
            record.end = self.time.len();
        }
        self.rows.clear();
    }
}

impl Recorder for Memory {
    fn begin(&mut self, _record: usize, columns: &[Column], rows: usize) -> io::Result<()> {
        if self.series.is_empty() {
            let series = |column: &Column| Series { column: column.clone(), values: Vec::new() };
            self.series = columns.iter().map(series).collect();
        }
        let ahead = rows.min(MOST_ROWS_AHEAD);
        self.time.reserve(ahead);
        self.series.iter_mut().for_each(|series| series.values.reserve(ahead));
        self.records.push(self.time.len()..self.time.len());
        self.rows.reserve(ROWS_AT_ONCE * (1 + columns.len()));
        Ok(())
    }

    #[inline]
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        if self.rows.len() + 1 + values.len() > self.rows.capacity() {
            self.spread();
        }
        self.rows.push(time);
        self.rows.extend_from_slice(values);
        Ok(())
    }

    fn end(&mut self) -> io::Result<()> {
        self.spread();
        Ok(())
    }
}

//! A record in memory.

use std::io;
use std::ops::Range;

use super::{Column, Recorder};

/// All rows, column by column. Memory is taken at the beginning of a record, not in the run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    time: Vec<f64>,
    series: Vec<Series>,
    records: Vec<Range<usize>>,
}

/// One recorded variable and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name and unit.
    pub column: Column,
    /// One value per row.
    pub values: Vec<f64>,
}

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
        Ok(())
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.time.push(time);
        for (series, value) in self.series.iter_mut().zip(values) {
            series.values.push(*value);
        }
        if let Some(record) = self.records.last_mut() {
            record.end = self.time.len();
        }
        Ok(())
    }
}

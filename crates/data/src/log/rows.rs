//! Rows of a log: sample time, selections.

use std::ops::Range;

use super::{Log, Record};
use crate::{Problem, Problems};

/// The sample time of a record whose rows are equally spaced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleTime {
    /// Time of the first row in s.
    pub start: f64,
    /// Sample time in s.
    pub period: f64,
    /// Greatest distance of a row from `start + k·period`, as a part of the period.
    pub jitter: f64,
}

impl SampleTime {
    /// Jitter that is usually allowed, as a part of the period. Times that were written with six
    /// digits lie up to 5e-6 s away from theirs at 1 s to 10 s, which is 3.2 % of a period at 6.4 kHz;
    /// a lost sample is at least half a period away from any grid.
    pub const TOLERANCE: f64 = 0.05;
}

impl Log {
    /// The sample time of a record, where each row lies within `tolerance` periods of a uniform
    /// grid. A period that is a whole number of Hz, or has few digits, within that tolerance is
    /// given exactly.
    ///
    /// # Errors
    /// The record has fewer than two rows, or its first row off the grid.
    pub fn sample_time(&self, record: &Record, tolerance: f64) -> Result<SampleTime, Problems> {
        let time = self.time.get(record.rows.clone()).unwrap_or_default();
        let (Some(first), Some(last)) = (time.first(), time.last()) else {
            return Err(self.of_record(record, "has no rows", "choose another one"));
        };
        if time.len() < 2 {
            let rule = "has one row, which has no sample time";
            return Err(self.of_record(record, rule, "choose a longer one"));
        }
        let mean = (last - first) / (time.len() - 1) as f64;
        let exact = 1.0 / (1.0 / mean).round();
        let short = format!("{mean:.11e}").parse().unwrap_or(mean);
        // The rounder candidates go first; the mean of the record itself is the last one.
        let mut best = (f64::INFINITY, 0, mean);
        for period in [exact, short, mean].into_iter().filter(|period| period.is_finite()) {
            let (jitter, row) = jitter(time, *first, period);
            if jitter <= tolerance {
                return Ok(SampleTime { start: *first, period, jitter });
            }
            if jitter < best.0 {
                best = (jitter, row, period);
            }
        }
        let (jitter, row, period) = best;
        let rule = format!(
            "is not sampled uniformly: row {} is at {} s and should be at {} s, {:.1} % of a sample \
             time of {period} s away",
            record.rows.start + row + 1,
            time.get(row).copied().unwrap_or_default(),
            first + row as f64 * period,
            100.0 * jitter,
        );
        let way_out = "split the record where rows are lost; where times were written with too few \
                       digits, remove their column and give the sample rate: --rate HZ";
        Err(self.of_record(record, &rule, way_out))
    }

    fn of_record(&self, record: &Record, rule: &str, way_out: &str) -> Problems {
        Problem::new(&self.origin, rule, way_out).at(format!("record {}", record.id)).into()
    }

    /// The rows of a record from time `from` on and before time `until`, both in s.
    #[must_use]
    pub fn rows_between(&self, record: &Record, from: f64, until: f64) -> Range<usize> {
        let time = self.time.get(record.rows.clone()).unwrap_or_default();
        let start = record.rows.start;
        let first = time.partition_point(|time| *time < from);
        let end = time.partition_point(|time| *time < until).max(first);
        start + first..start + end
    }

    /// The rows of a record before time `at` (in s), and those from it on.
    #[must_use]
    pub fn split_at(&self, record: &Record, at: f64) -> (Range<usize>, Range<usize>) {
        let before = self.rows_between(record, f64::NEG_INFINITY, at);
        (before.clone(), before.end..record.rows.end)
    }

    /// The part of the log with these rows (from 0); rows that do not exist are left out.
    #[must_use]
    pub fn select(&self, rows: Range<usize>) -> Self {
        let end = rows.end.min(self.len());
        let rows = rows.start.min(end)..end;
        let records = self.records.iter().filter_map(|record| {
            let start = record.rows.start.max(rows.start);
            let end = record.rows.end.min(rows.end);
            let rows = start.checked_sub(rows.start)?..end.checked_sub(rows.start)?;
            (!rows.is_empty()).then_some(Record { id: record.id, rows })
        });
        let columns = self.columns.iter().map(|column| super::Column {
            name: column.name.clone(),
            unit: column.unit.clone(),
            description: column.description.clone(),
            values: column.values[rows.clone()].to_vec(),
        });
        Self {
            origin: self.origin.clone(),
            time: self.time[rows.clone()].to_vec(),
            lines: self.lines.from(rows.start),
            columns: columns.collect(),
            names: self.names.clone(),
            records: records.collect(),
            is_numbered: self.is_numbered,
            rounded: self.rounded.clone(),
            remarks: self.remarks.clone(),
        }
    }
}

/// Greatest distance of a time from the grid, in periods, and its row.
fn jitter(time: &[f64], start: f64, period: f64) -> (f64, usize) {
    let mut worst = (0.0, 0);
    for (row, time) in time.iter().enumerate() {
        let distance = ((time - start) / period - row as f64).abs();
        if distance > worst.0 {
            worst = (distance, row);
        }
    }
    worst
}

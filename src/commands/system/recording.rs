//! Where the rows of a run go: the record's file, the progress bar, and what its page draws.

use std::io;
use std::path::Path;

use cosim::{RecordFile, Recorder};

use crate::{progress, records};

/// The recorded variables of a run, for its page: all rows, or of a long run every `stride`-th.
#[derive(Default)]
pub(crate) struct Drawn {
    pub(crate) columns: Vec<cosim::record::Column>,
    pub(crate) time: Vec<f64>,
    /// One list for each column.
    pub(crate) values: Vec<Vec<f64>>,
    pub(crate) stride: usize,
    rows: usize,
}

impl Drawn {
    /// The greatest number of values that are kept.
    const MOST: usize = 4_000_000;

    fn begin(&mut self, columns: &[cosim::record::Column]) {
        let values = vec![Vec::new(); columns.len()];
        *self = Drawn { columns: columns.to_vec(), values, stride: 1, ..Drawn::default() };
    }

    fn row(&mut self, time: f64, values: &[f64]) {
        if self.rows.is_multiple_of(self.stride) {
            if self.time.len() * self.values.len() >= Self::MOST {
                self.thin();
            }
            // After thinning this row may be one of those that are left out.
            if self.rows.is_multiple_of(self.stride) {
                self.time.push(time);
                self.values.iter_mut().zip(values).for_each(|(all, value)| all.push(*value));
            }
        }
        self.rows += 1;
    }

    /// Leaves every second row out.
    fn thin(&mut self) {
        for all in self.values.iter_mut().chain([&mut self.time]) {
            *all = all.iter().step_by(2).copied().collect();
        }
        self.stride *= 2;
    }
}

/// Writes rows to the file, and moves the progress bar.
pub(super) struct Recording<'a> {
    pub(super) file: Option<(RecordFile, &'a Path)>,
    /// The columns as they are called in the file, and what is to be said of their names.
    pub(super) columns: Vec<cosim::record::Column>,
    pub(super) notes: Vec<String>,
    pub(super) bar: progress::Rows,
    pub(super) rows: usize,
    /// Where a page was asked for.
    pub(super) drawn: Option<Drawn>,
}

impl Recorder for Recording<'_> {
    fn begin(
        &mut self,
        record: usize,
        columns: &[cosim::record::Column],
        rows: usize,
    ) -> io::Result<()> {
        if let Some(drawn) = &mut self.drawn {
            drawn.begin(columns);
        }
        let Some((file, out)) = &mut self.file else { return Ok(()) };
        let (columns, notes) = records::readable(columns, out).map_err(io::Error::other)?;
        file.begin(record, &columns, rows)?;
        (self.columns, self.notes) = (columns, notes);
        Ok(())
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.rows += 1;
        self.bar.row(time, values)?;
        if let Some(drawn) = &mut self.drawn {
            drawn.row(time, values);
        }
        self.file.as_mut().map_or(Ok(()), |(file, _)| file.row(time, values))
    }

    fn end(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), |(file, _)| file.end())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_is_drawn_by_every_nth_row() {
        let column = |name: &str| cosim::record::Column { name: name.into(), unit: None };
        let mut drawn = Drawn::default();
        drawn.begin(&[column("a"), column("b")]);
        let rows = 3 * Drawn::MOST / 2;
        for k in 0..rows {
            drawn.row(k as f64, &[2.0 * k as f64, -(k as f64)]);
        }
        assert_eq!(drawn.stride, 4);
        assert_eq!(drawn.time.len(), rows.div_ceil(4));
        assert!(drawn.time.iter().enumerate().all(|(k, t)| *t == 4.0 * k as f64));
        assert!(drawn.time.iter().zip(&drawn.values[0]).all(|(t, a)| *a == 2.0 * t));
        assert!(drawn.time.iter().zip(&drawn.values[1]).all(|(t, b)| *b == -t));
    }
}

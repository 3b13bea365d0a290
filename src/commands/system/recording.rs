//! Where the rows of a run go: the record's file, the progress bar, and the page.

use std::io;
use std::path::Path;

use cosim::{RecordFile, Recorder};

use crate::results::system::Drawn;
use crate::{progress, records};

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

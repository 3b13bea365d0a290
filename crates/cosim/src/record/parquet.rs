//! A record as Apache Parquet file.

use std::io;
use std::path::{Path, PathBuf};

use data::{AtomicFile, ParquetLogWriter};

use super::{Column, Recorder};

/// A Parquet file: a column of doubles for `time`, `record` and each recorded variable, not
/// compressed; units are key-value metadata, `unit:position[1]` = `um`. It appears whole or not at
/// all, see [`CsvFile`](super::CsvFile); memory does not grow.
pub struct ParquetFile {
    /// Absent until the columns are known.
    writer: Option<ParquetLogWriter>,
    /// `record` and the values of a row.
    row: Vec<f64>,
    record: usize,
    path: PathBuf,
}

impl ParquetFile {
    /// Begins the file that will be at `path`.
    pub fn create(path: &Path) -> io::Result<Self> {
        // Tells now, not after the run, whether the folder can be written.
        drop(AtomicFile::create(path)?);
        Ok(ParquetFile { writer: None, row: Vec::new(), record: 0, path: path.to_path_buf() })
    }

    fn open(&self, columns: &[Column]) -> io::Result<ParquetLogWriter> {
        let columns = columns.iter().map(|column| (column.name.as_str(), column.unit.as_deref()));
        let columns: Vec<_> = std::iter::once(("record", None)).chain(columns).collect();
        ParquetLogWriter::create(&self.path, &columns, &[])
    }

    /// Gives the file its name, in place of a file that has it.
    pub fn finish(mut self) -> io::Result<()> {
        let writer = match self.writer.take() {
            Some(writer) => writer,
            None => self.open(&[])?,
        };
        writer.finish()
    }
}

impl Recorder for ParquetFile {
    fn begin(&mut self, record: usize, columns: &[Column], _: usize) -> io::Result<()> {
        self.record = record;
        if self.writer.is_none() {
            self.writer = Some(self.open(columns)?);
        }
        Ok(())
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        self.row.clear();
        self.row.push(self.record as f64);
        self.row.extend_from_slice(values);
        writer.row(time, &self.row)
    }
}

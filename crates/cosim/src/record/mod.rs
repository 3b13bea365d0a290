//! Recorders: what a run leaves behind.
//!
//! A row holds what a [log](crate#rows) holds: outputs as they are at t_k, inputs as they act from
//! t_k until t_{k+1}.

mod csv;
mod file;
mod memory;
mod numpy;
#[cfg(feature = "parquet")]
mod parquet;

pub use csv::{CsvFile, CsvRecorder};
pub use file::RecordFile;
pub use memory::{Memory, Series};
pub use numpy::{NpyFile, NpzFile};
#[cfg(feature = "parquet")]
pub use parquet::ParquetFile;

use std::io;

/// One recorded variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The column's name in the record.
    pub name: String,
    /// The column's unit, if it has one.
    pub unit: Option<String>,
}

/// Receives the rows of a run. The order of calls: (`begin`, `row`…, `end`) for each record.
///
/// `end` is called after an error too, so that a recorder can keep what there is.
pub trait Recorder {
    /// A record begins; `rows` is how many rows it will have if it runs to its end.
    fn begin(&mut self, record: usize, columns: &[Column], rows: usize) -> io::Result<()>;

    /// One row; `values` in the order of the columns.
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()>;

    /// The record ends.
    fn end(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Records nothing.
impl Recorder for () {
    fn begin(&mut self, _: usize, _: &[Column], _: usize) -> io::Result<()> {
        Ok(())
    }

    fn row(&mut self, _: f64, _: &[f64]) -> io::Result<()> {
        Ok(())
    }
}

/// Two recorders side by side, such as one for a file and one for a progress bar.
impl<A: Recorder + ?Sized, B: Recorder + ?Sized> Recorder for (&mut A, &mut B) {
    fn begin(&mut self, record: usize, columns: &[Column], rows: usize) -> io::Result<()> {
        self.0.begin(record, columns, rows)?;
        self.1.begin(record, columns, rows)
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.0.row(time, values)?;
        self.1.row(time, values)
    }

    fn end(&mut self) -> io::Result<()> {
        self.0.end()?;
        self.1.end()
    }
}

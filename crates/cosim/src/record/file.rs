//! A record as a file of any kind.

use std::io;
use std::path::Path;

use super::{Column, CsvFile, NpyFile, NpzFile, Recorder};

/// A record on disk; its kind follows from the name's ending.
pub enum RecordFile {
    /// `.csv`.
    Csv(CsvFile),
    /// `.npy`.
    Npy(NpyFile),
    /// `.npz`.
    Npz(NpzFile),
    /// `.parquet`.
    #[cfg(feature = "parquet")]
    Parquet(Box<super::ParquetFile>),
}

impl RecordFile {
    /// Begins the file that will be at `path`.
    ///
    /// # Errors
    /// An ending that is none of these, or a folder that cannot be written.
    pub fn create(path: &Path) -> io::Result<Self> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("csv") => CsvFile::create(path).map(RecordFile::Csv),
            Some("npy") => NpyFile::create(path).map(RecordFile::Npy),
            Some("npz") => NpzFile::create(path).map(RecordFile::Npz),
            #[cfg(feature = "parquet")]
            Some("parquet") => {
                super::ParquetFile::create(path).map(Box::new).map(RecordFile::Parquet)
            }
            _ => Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                format!(
                    "{}: records are written as .csv, .npy, .npz{}",
                    path.display(),
                    if cfg!(feature = "parquet") { " or .parquet" } else { "" }
                ),
            )),
        }
    }

    /// Gives the file its name, in place of a file that has it. Call it after a failed run too, to
    /// keep the record so far.
    pub fn finish(self) -> io::Result<()> {
        match self {
            RecordFile::Csv(file) => file.finish(),
            RecordFile::Npy(file) => file.finish(),
            RecordFile::Npz(file) => file.finish(),
            #[cfg(feature = "parquet")]
            RecordFile::Parquet(file) => file.finish(),
        }
    }

    fn recorder(&mut self) -> &mut dyn Recorder {
        match self {
            RecordFile::Csv(file) => file,
            RecordFile::Npy(file) => file,
            RecordFile::Npz(file) => file,
            #[cfg(feature = "parquet")]
            RecordFile::Parquet(file) => &mut **file,
        }
    }
}

impl Recorder for RecordFile {
    fn begin(&mut self, record: usize, columns: &[Column], rows: usize) -> io::Result<()> {
        self.recorder().begin(record, columns, rows)
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.recorder().row(time, values)
    }

    fn end(&mut self) -> io::Result<()> {
        self.recorder().end()
    }
}

//! From a journal to a log file.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use data::{
    AtomicFile, ColumnHeader, ColumnUnit, LogWriter, Mf4About, Mf4Writer, ParquetLogWriter,
    UnitPlace,
};

use super::journal::{About, JournalError, JournalReader};

/// Kind of a log file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.csv`, with the units in `NAME.dataset.toml` and the provenance in `NAME.about.json`.
    Csv,
    /// `.parquet`, with units and provenance in its metadata.
    Parquet,
    /// `.mf4`, ASAM MDF 4.10, with units and provenance in its comments.
    Mf4,
}

impl Format {
    /// The format that the name of a file asks for.
    ///
    /// # Errors
    /// It is none of these.
    pub fn of(path: &Path) -> Result<Self, String> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("csv") => Ok(Format::Csv),
            Some("parquet") => Ok(Format::Parquet),
            Some("mf4") => Ok(Format::Mf4),
            _ => Err(format!(
                "{}: records are written as .parquet, .csv or .mf4; choose one of these extensions",
                path.display()
            )),
        }
    }
}

/// What was converted.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Converted {
    /// The log.
    pub file: PathBuf,
    /// Rows of the record.
    pub rows: u64,
    /// Bytes behind the last whole block of the journal, of a write that was cut off.
    pub cut_off_bytes: u64,
}

/// A journal that does not become a log.
#[derive(Debug, thiserror::Error)]
pub enum ConvertError {
    /// The journal.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The log.
    #[error(transparent)]
    Log(#[from] data::Problems),
    /// The log.
    #[error("{}: cannot be written: {error}; check the folder, its permissions and the free space", path.display())]
    Io {
        /// File.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
}

/// Writes the rows of a journal, as far as they go, to a log file. `more` is added to its
/// provenance.
///
/// # Errors
/// The journal cannot be read, or the log cannot be written.
pub fn convert(
    journal: &Path,
    file: &Path,
    format: Format,
    more: &serde_json::Map<String, serde_json::Value>,
) -> Result<Converted, ConvertError> {
    let rows = count(journal)?;
    let mut reader = JournalReader::open(journal)?;
    let mut about = reader.about().clone();
    about.provenance.extend(more.clone());
    let beside = file.with_extension("about.json");
    if format == Format::Csv {
        let is_ours = || {
            let mut there = String::new();
            let found = File::open(&beside).map(|file| file.take(files::LONGEST_TEXT));
            let read = found.and_then(|mut file| file.read_to_string(&mut there));
            read.is_ok() && there.contains("\"tool\": \"piezoloop")
        };
        let may = files::check_beside(&beside, is_ours);
        may.map_err(|error| ConvertError::Io { path: beside.clone(), error })?;
    }
    let mut sink = Sink::create(file, format, &about, rows)?;
    let width = about.columns.len();
    while let Some(block) = reader.block()? {
        for row in block.chunks_exact(width) {
            sink.row(row).map_err(|error| error.at(file))?;
        }
    }
    sink.finish().map_err(|error| error.at(file))?;
    if format == Format::Csv {
        let text = serde_json::to_vec_pretty(&about.provenance).map_err(io::Error::from);
        let written = text.and_then(|text| AtomicFile::write_all_of(&beside, &text));
        written.map_err(|error| ConvertError::Io { path: beside, error })?;
    }
    Ok(Converted { file: file.to_owned(), rows, cut_off_bytes: reader.broken() })
}

/// How many whole rows a journal has.
fn count(journal: &Path) -> Result<u64, JournalError> {
    let mut reader = JournalReader::open(journal)?;
    let width = reader.about().columns.len().max(1);
    let mut rows = 0;
    while let Some(block) = reader.block()? {
        rows += (block.len() / width) as u64;
    }
    Ok(rows)
}

/// A log file of any kind that is written.
enum Sink {
    Csv(LogWriter),
    Parquet(Box<ParquetLogWriter>),
    Mf4(Mf4Writer),
}

/// An error of a file whose name is not known yet.
enum SinkError {
    Log(data::Problems),
    Io(io::Error),
}

impl SinkError {
    fn at(self, path: &Path) -> ConvertError {
        match self {
            SinkError::Log(problems) => ConvertError::Log(problems),
            SinkError::Io(error) => ConvertError::Io { path: path.to_owned(), error },
        }
    }
}

impl From<io::Error> for SinkError {
    fn from(error: io::Error) -> Self {
        SinkError::Io(error)
    }
}

impl From<data::Problems> for SinkError {
    fn from(problems: data::Problems) -> Self {
        SinkError::Log(problems)
    }
}

impl Sink {
    fn create(path: &Path, format: Format, about: &About, rows: u64) -> Result<Self, ConvertError> {
        let failed = |error| ConvertError::Io { path: path.to_owned(), error };
        let header = |column: &crate::cycle::Column| ColumnHeader {
            name: column.name.clone(),
            // A unit that is none of ours stays out; its text is in the journal.
            unit: column.unit.as_deref().and_then(|unit| ColumnUnit::parse(unit).ok()),
            description: column.description.clone(),
        };
        let columns: Vec<ColumnHeader> = about.columns.iter().skip(1).map(header).collect();
        let properties: Vec<(String, String)> = about
            .provenance
            .iter()
            .map(|(key, value)| {
                let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                (key.clone(), text)
            })
            .collect();
        Ok(match format {
            Format::Csv => Sink::Csv(LogWriter::create(path, &columns, false, UnitPlace::Sidecar)?),
            Format::Parquet => {
                let columns = about.columns.iter().skip(1);
                let columns: Vec<_> =
                    columns.map(|column| (column.name.as_str(), column.unit.as_deref())).collect();
                let writer = ParquetLogWriter::create(path, &columns, &properties);
                Sink::Parquet(Box::new(writer.map_err(failed)?))
            }
            Format::Mf4 => {
                let start = about.provenance.get("start_ns").and_then(serde_json::Value::as_u64);
                let about = Mf4About {
                    start_ns: start.unwrap_or(0),
                    comment: "Record of a bench run".to_owned(),
                    properties,
                };
                Sink::Mf4(Mf4Writer::create(path, &columns, rows, &about).map_err(failed)?)
            }
        })
    }

    fn row(&mut self, row: &[f64]) -> Result<(), SinkError> {
        let Some((time, values)) = row.split_first() else { return Ok(()) };
        match self {
            Sink::Csv(file) => Ok(file.row(0, *time, values)?),
            Sink::Parquet(file) => Ok(file.row(*time, values)?),
            Sink::Mf4(file) => Ok(file.row(*time, values)?),
        }
    }

    fn finish(self) -> Result<(), SinkError> {
        match self {
            Sink::Csv(file) => Ok(file.finish()?),
            Sink::Parquet(file) => Ok(file.finish()?),
            Sink::Mf4(file) => Ok(file.finish()?),
        }
    }
}

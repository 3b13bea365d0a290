//! Logs written as Apache Parquet: `time`, then the signals, all of them doubles; units are key-value
//! metadata, `unit:position[1]` = `um`.

use std::io;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::AtomicFile;

/// Rows of a row group; so many are kept in memory.
const GROUP: usize = 1 << 16;
/// Before the name of a column: its unit.
const UNIT: &str = "unit:";

/// Writes a Parquet log row by row; it appears when [`finish`](Self::finish) is called, whole.
pub struct ParquetLogWriter {
    writer: SerializedFileWriter<AtomicFile>,
    columns: Vec<Vec<f64>>,
}

impl std::fmt::Debug for ParquetLogWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ParquetLogWriter").finish_non_exhaustive()
    }
}

impl ParquetLogWriter {
    /// Begins the file `path` with time and these columns, each with its unit; `metadata` are further
    /// keys and values.
    ///
    /// # Errors
    /// The folder cannot be written, or two columns have one name.
    pub fn create(
        path: &Path,
        columns: &[(&str, Option<&str>)],
        metadata: &[(String, String)],
    ) -> io::Result<Self> {
        let names = std::iter::once("time").chain(columns.iter().map(|(name, _)| *name));
        let fields = names
            .map(|name| {
                let field = Type::primitive_type_builder(name, Physical::DOUBLE);
                field.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
            })
            .collect::<Result<Vec<_>, _>>()
            .map_err(system)?;
        let count = fields.len();
        let schema = Type::group_type_builder("log").with_fields(fields).build();
        let units = columns.iter().filter_map(|(name, unit)| {
            Some(KeyValue::new(format!("{UNIT}{name}"), (*unit)?.to_owned()))
        });
        let more = metadata.iter().map(|(key, value)| KeyValue::new(key.clone(), value.clone()));
        let time = std::iter::once(KeyValue::new(format!("{UNIT}time"), "s".to_owned()));
        let properties = WriterProperties::builder()
            .set_dictionary_enabled(false)
            .set_statistics_enabled(EnabledStatistics::None)
            .set_key_value_metadata(Some(time.chain(units).chain(more).collect()))
            .build();
        let file = AtomicFile::create(path)?;
        let schema = Arc::new(schema.map_err(system)?);
        let writer = SerializedFileWriter::new(file, schema, Arc::new(properties));
        let writer = writer.map_err(system)?;
        Ok(ParquetLogWriter { writer, columns: vec![Vec::new(); count] })
    }

    /// Adds a row: time in s, one value per column.
    ///
    /// # Errors
    /// The wrong number of values, or the disk is full.
    pub fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        if values.len() + 1 != self.columns.len() {
            let text = format!("{} values for {} columns", values.len(), self.columns.len() - 1);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        let row = std::iter::once(&time).chain(values);
        self.columns.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
        if self.columns[0].len() >= GROUP { self.write_group() } else { Ok(()) }
    }

    fn write_group(&mut self) -> io::Result<()> {
        if self.columns[0].is_empty() {
            return Ok(());
        }
        let mut group = self.writer.next_row_group().map_err(system)?;
        for values in &mut self.columns {
            let Some(mut column) = group.next_column().map_err(system)? else { break };
            let typed = column.typed::<DoubleType>();
            typed.write_batch(values, None, None).map_err(system)?;
            column.close().map_err(system)?;
            values.clear();
        }
        group.close().map_err(system)?;
        Ok(())
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// The disk is full; nothing remains then.
    pub fn finish(mut self) -> io::Result<()> {
        self.write_group()?;
        self.writer.into_inner().map_err(system)?.commit()
    }
}

/// The error of the system behind one of Parquet, as of a full disk.
fn system(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(inner) => match inner.downcast::<io::Error>() {
            Ok(own) => *own,
            Err(other) => io::Error::other(other),
        },
        other => io::Error::other(other),
    }
}

#[cfg(all(test, feature = "formats"))]
mod tests {
    use super::*;
    use crate::{Log, ReadOptions};

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.parquet");
        let columns = [("position[1]", Some("um")), ("bench.state", None)];
        let more = [("about".to_owned(), "{}".to_owned())];
        let mut writer = ParquetLogWriter::create(&path, &columns, &more).unwrap();
        for k in 0..70_000 {
            writer.row(f64::from(k) * 0.1, &[f64::from(k).sin(), 2.0]).unwrap();
        }
        assert!(writer.row(1e9, &[1.0]).is_err());
        writer.finish().unwrap();
        let log = Log::read(&path, &ReadOptions::default()).unwrap();
        assert_eq!((log.len(), log.columns().len(), log.records().len()), (70_000, 2, 1));
        let column = log.column("position[1]").unwrap();
        assert_eq!(column.unit.as_ref().unwrap().text, "um");
        assert_eq!(column.values[69_999], 69_999f64.sin());
        assert_eq!(log.time()[3], 3.0 * 0.1);
    }
}

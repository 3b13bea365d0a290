//! A record as Apache Parquet file.

use std::io::{self, BufWriter};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use tempfile::NamedTempFile;

use super::whole::Whole;
use super::{Column, Recorder};

/// Rows of a row group; so many are kept in memory.
const GROUP: usize = 1 << 16;

/// A Parquet file: a column of doubles for `time`, `record` and each recorded variable, not
/// compressed; units are key-value metadata, `unit:position[1]` = `um`. It appears whole or not at
/// all, see [`CsvFile`](super::CsvFile); memory does not grow.
pub struct ParquetFile {
    writer: Option<SerializedFileWriter<BufWriter<NamedTempFile>>>,
    columns: Vec<Vec<f64>>,
    record: usize,
    path: Whole,
}

impl ParquetFile {
    /// Begins the file that will be at `path`.
    pub fn create(path: &Path) -> io::Result<Self> {
        let path = Whole::new(path);
        // Tells now, not after the run, whether the folder can be written.
        drop(path.temporary()?);
        Ok(ParquetFile { writer: None, columns: Vec::new(), record: 0, path })
    }

    fn open(&mut self, columns: &[Column]) -> io::Result<()> {
        let names = ["time", "record"].into_iter();
        let names = names.chain(columns.iter().map(|column| column.name.as_str()));
        let fields = names
            .map(|name| {
                let field = Type::primitive_type_builder(name, Physical::DOUBLE);
                field.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
            })
            .collect::<Result<Vec<_>, _>>()
            .map_err(io::Error::other)?;
        self.columns = vec![Vec::new(); fields.len()];
        let schema = Type::group_type_builder("run").with_fields(fields).build();
        let schema = schema.map_err(io::Error::other)?;
        let units = columns.iter().filter_map(|column| {
            let unit = column.unit.clone()?;
            Some(KeyValue::new(format!("unit:{}", column.name), unit))
        });
        let time = std::iter::once(KeyValue::new("unit:time".to_owned(), "s".to_owned()));
        let properties = WriterProperties::builder()
            .set_dictionary_enabled(false)
            .set_statistics_enabled(EnabledStatistics::None)
            .set_key_value_metadata(Some(time.chain(units).collect()))
            .build();
        let out = BufWriter::new(self.path.temporary()?);
        let writer = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties));
        self.writer = Some(writer.map_err(io::Error::other)?);
        Ok(())
    }

    fn write_group(&mut self) -> io::Result<()> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        if self.columns.first().is_none_or(Vec::is_empty) {
            return Ok(());
        }
        let mut group = writer.next_row_group().map_err(io::Error::other)?;
        for values in &mut self.columns {
            let Some(mut column) = group.next_column().map_err(io::Error::other)? else { break };
            let typed = column.typed::<DoubleType>();
            typed.write_batch(values, None, None).map_err(io::Error::other)?;
            column.close().map_err(io::Error::other)?;
            values.clear();
        }
        group.close().map_err(io::Error::other)?;
        Ok(())
    }

    /// Gives the file its name, in place of a file that has it.
    pub fn finish(mut self) -> io::Result<()> {
        if self.writer.is_none() {
            self.open(&[])?;
        }
        self.write_group()?;
        let Some(writer) = self.writer else { return Ok(()) };
        let out = writer.into_inner().map_err(io::Error::other)?;
        self.path.persist(out.into_inner().map_err(io::IntoInnerError::into_error)?)
    }
}

impl Recorder for ParquetFile {
    fn begin(&mut self, record: usize, columns: &[Column], _: usize) -> io::Result<()> {
        self.record = record;
        match self.writer {
            Some(_) => Ok(()),
            None => self.open(columns),
        }
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        let row = [time, self.record as f64].into_iter().chain(values.iter().copied());
        self.columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        match self.columns.first() {
            Some(time) if time.len() >= GROUP => self.write_group(),
            _ => Ok(()),
        }
    }
}

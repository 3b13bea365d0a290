//! The results of a sweep as Apache Parquet: a column `run`, what varied, what came out.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use data::AtomicFile;
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::Field;
use parquet::schema::types::Type;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::row::{Cell, Column, ColumnKind, Row};

/// Rows of a row group: fixed, so that a file follows from its rows.
const GROUP: usize = 1 << 16;
/// Key of what a file says about its sweep.
const KEY: &str = "piezoloop.sweep";

/// What a table says about its sweep.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// Hash of the plan, all its files, and the tool.
    pub fingerprint: String,
    /// Runs of the whole sweep.
    pub runs: u64,
    /// The first run of this table.
    pub first: u64,
    /// Behind its last run.
    pub end: u64,
    /// The plan.
    pub plan: String,
    /// The tool and its version.
    pub tool: String,
    /// The columns behind `run`: what varied, what came out, and `error`.
    pub columns: Vec<Column>,
    /// How many of them are what varied.
    pub varied: usize,
}

/// Rows and what they belong to.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The sweep.
    pub about: About,
    /// One row per run, in the order of the runs.
    pub rows: Vec<Row>,
}

impl Table {
    /// Writes the table; the file appears whole.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let file = AtomicFile::create(path).map_err(|error| Error::written(path, error))?;
        let file = self
            .write_to(file)
            .map_err(|error| Error::written(path, std::io::Error::other(error)))?;
        file.commit().map_err(|error| Error::written(path, error))
    }

    fn write_to(&self, file: AtomicFile) -> Result<AtomicFile, ParquetError> {
        let field = |name: &str, kind: ColumnKind, repetition: Repetition| {
            let (physical, logical) = match kind {
                ColumnKind::Real => (Physical::DOUBLE, None),
                ColumnKind::Integer => (Physical::INT64, None),
                ColumnKind::Truth => (Physical::BOOLEAN, None),
                ColumnKind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            };
            let builder = Type::primitive_type_builder(name, physical).with_logical_type(logical);
            builder.with_repetition(repetition).build().map(Arc::new)
        };
        let mut fields = vec![field("run", ColumnKind::Integer, Repetition::REQUIRED)?];
        for column in &self.about.columns {
            fields.push(field(&column.name, column.kind, Repetition::OPTIONAL)?);
        }
        let schema = Type::group_type_builder("sweep").with_fields(fields).build()?;
        let units = self.about.columns.iter().filter_map(|column| {
            Some(KeyValue::new(format!("unit:{}", column.name), column.unit.clone()?))
        });
        let about = serde_json::to_string(&self.about)
            .map_err(|error| ParquetError::External(Box::new(error)))?;
        let pairs = std::iter::once(KeyValue::new(KEY.to_owned(), about)).chain(units).collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_dictionary_enabled(false)
            .set_statistics_enabled(EnabledStatistics::None)
            .set_key_value_metadata(Some(pairs))
            .build();
        let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
        for rows in self.rows.chunks(GROUP) {
            let mut group = writer.next_row_group()?;
            let mut at = 0;
            while let Some(mut column) = group.next_column()? {
                match at {
                    0 => {
                        let runs: Vec<i64> = rows.iter().map(|row| row.run as i64).collect();
                        if let ColumnWriter::Int64ColumnWriter(typed) = column.untyped() {
                            typed.write_batch(&runs, None, None)?;
                        }
                    }
                    at => write_column(column.untyped(), rows, at - 1)?,
                }
                column.close()?;
                at += 1;
            }
            group.close()?;
        }
        writer.into_inner()
    }

    /// Reads a table that [`write`](Self::write) wrote.
    ///
    /// # Errors
    /// The file cannot be read, or is none of a sweep.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let file = File::open(path).map_err(|error| Error::read(path, error))?;
        let way_out = "give a .parquet that `piezoloop sweep` wrote";
        let refuse = |error: ParquetError| {
            Error::file(path, format!("is no table of a sweep: {error}"), way_out)
        };
        let reader = SerializedFileReader::new(file).map_err(refuse)?;
        let pairs = reader.metadata().file_metadata().key_value_metadata();
        let about =
            pairs.and_then(|pairs| pairs.iter().find(|pair| pair.key == KEY)?.value.clone());
        let about: Option<About> = about.and_then(|text| serde_json::from_str(&text).ok());
        let about =
            about.ok_or_else(|| Error::file(path, "says nothing about a sweep", way_out))?;
        let mut rows = Vec::new();
        for record in reader.get_row_iter(None).map_err(refuse)? {
            let mut fields = record.map_err(refuse)?.into_columns().into_iter();
            let run = match fields.next() {
                Some((_, Field::Long(run))) => run as u64,
                _ => return Err(Error::file(path, "has no column `run`", way_out)),
            };
            rows.push(Row { run, cells: fields.map(|(_, field)| cell(field)).collect() });
        }
        Ok(Table { about, rows })
    }

    /// Puts the parts of a sweep together: the bytes of the table that one process would have
    /// written.
    ///
    /// # Errors
    /// Parts of different sweeps, runs that are missing or doubled.
    pub fn merge(parts: Vec<(PathBuf, Table)>) -> Result<Table, Error> {
        let refuse =
            |rule: String, way_out: &str| Err(Error::Merge { rule, way_out: way_out.to_owned() });
        let mut parts = parts;
        parts.sort_by_key(|(_, table)| table.about.first);
        let Some((first, about)) =
            parts.first().map(|(path, table)| (path.clone(), table.about.clone()))
        else {
            return refuse("there is nothing to merge".to_owned(), "give the tables of all shards");
        };
        let mut rows = Vec::with_capacity(about.runs as usize);
        for (path, table) in parts {
            if table.about.fingerprint != about.fingerprint {
                let rule =
                    format!("{} and {} are of different sweeps", first.display(), path.display());
                return refuse(rule, "merge tables of one plan, made by one version of the tool");
            }
            let end = rows.len() as u64;
            if table.about.first != end {
                let is_missing = table.about.first > end;
                let (from, to) = (end.min(table.about.first), end.max(table.about.first));
                let what = if is_missing { "are missing" } else { "are in two tables" };
                let rule =
                    format!("{}: runs {from} to {} {what}", path.display(), to.saturating_sub(1));
                return refuse(rule, "give each shard once: --shard 1/N to N/N");
            }
            rows.extend(table.rows);
            let complete = rows.len() as u64 == table.about.end
                && rows[end as usize..].iter().zip(end..).all(|(row, run)| row.run == run);
            if !complete {
                let rule = "does not hold the runs that it says";
                return Err(Error::file(&path, rule, "run this shard again"));
            }
        }
        if rows.len() as u64 != about.runs {
            let rule = format!("runs {} to {} are missing", rows.len(), about.runs - 1);
            return refuse(rule, "give each shard once: --shard 1/N to N/N");
        }
        let end = about.runs;
        Ok(Table { about: About { first: 0, end, ..about }, rows })
    }
}

fn write_column(
    writer: &mut ColumnWriter<'_>,
    rows: &[Row],
    at: usize,
) -> Result<(), ParquetError> {
    let cells = || rows.iter().map(|row| row.cells.get(at).unwrap_or(&Cell::Missing));
    let levels: Vec<i16> = cells().map(|cell| i16::from(*cell != Cell::Missing)).collect();
    match writer {
        ColumnWriter::DoubleColumnWriter(typed) => {
            let values: Vec<f64> = cells().filter_map(Cell::number).collect();
            typed.write_batch(&values, Some(&levels), None)?;
        }
        ColumnWriter::Int64ColumnWriter(typed) => {
            let value = |cell: &Cell| match cell {
                Cell::Integer(value) => Some(*value),
                _ => None,
            };
            let values: Vec<i64> = cells().filter_map(value).collect();
            typed.write_batch(&values, Some(&levels), None)?;
        }
        ColumnWriter::BoolColumnWriter(typed) => {
            let value = |cell: &Cell| match cell {
                Cell::Truth(value) => Some(*value),
                _ => None,
            };
            let values: Vec<bool> = cells().filter_map(value).collect();
            typed.write_batch(&values, Some(&levels), None)?;
        }
        ColumnWriter::ByteArrayColumnWriter(typed) => {
            let value = |cell: &Cell| match cell {
                Cell::Text(text) => Some(ByteArray::from(text.as_str())),
                _ => None,
            };
            let values: Vec<ByteArray> = cells().filter_map(value).collect();
            typed.write_batch(&values, Some(&levels), None)?;
        }
        _ => return Err(ParquetError::General("a column of another type".to_owned())),
    }
    Ok(())
}

fn cell(field: Field) -> Cell {
    match field {
        Field::Double(value) => Cell::Real(value),
        Field::Long(value) => Cell::Integer(value),
        Field::Bool(value) => Cell::Truth(value),
        Field::Str(text) => Cell::Text(text),
        _ => Cell::Missing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(first: u64, end: u64) -> Table {
        let columns = vec![
            Column::new("x", ColumnKind::Real, Some("um")),
            Column::new("n", ColumnKind::Integer, None),
            Column::new("on", ColumnKind::Truth, None),
            Column::new("error", ColumnKind::Text, None),
        ];
        let about = About {
            fingerprint: "f".into(),
            runs: 10,
            first,
            end,
            plan: "runs = 10".into(),
            tool: "piezoloop".into(),
            columns,
            varied: 1,
        };
        let row = |run: u64| {
            let failed = run % 4 == 3;
            let real = if failed { Cell::Missing } else { Cell::Real(0.1 * run as f64) };
            let text = if failed { Cell::Text("it \"broke\"".into()) } else { Cell::Missing };
            Row { run, cells: vec![real, Cell::Integer(-(run as i64)), Cell::Truth(failed), text] }
        };
        Table { about, rows: (first..end).map(row).collect() }
    }

    fn parts(cuts: &[(u64, u64)]) -> Vec<(PathBuf, Table)> {
        let part =
            |(first, end): &(u64, u64)| (format!("{first}.parquet").into(), table(*first, *end));
        cuts.iter().map(part).collect()
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.parquet");
        for part in [table(0, 10), table(3, 4), table(0, 0)] {
            part.write(&path).unwrap();
            assert_eq!(Table::read(&path).unwrap(), part);
        }
        std::fs::write(&path, "no").unwrap();
        assert!(Table::read(&path).unwrap_err().to_string().contains("no table of a sweep"));
    }

    #[test]
    fn merged_parts_have_the_bytes_of_the_complete_table() {
        let folder = tempfile::tempdir().unwrap();
        let (complete, merged) = (folder.path().join("w"), folder.path().join("m"));
        table(0, 10).write(&complete).unwrap();
        Table::merge(parts(&[(6, 10), (0, 6)])).unwrap().write(&merged).unwrap();
        assert_eq!(std::fs::read(complete).unwrap(), std::fs::read(merged).unwrap());
    }

    #[test]
    fn parts_that_are_incomplete_are_refused() {
        let message = |cuts: &[(u64, u64)]| Table::merge(parts(cuts)).unwrap_err().to_string();
        assert!(message(&[(0, 4), (6, 10)]).contains("runs 4 to 5 are missing"));
        assert!(message(&[(0, 6), (4, 10)]).contains("runs 4 to 5 are in two tables"));
        assert!(message(&[(0, 6)]).contains("runs 6 to 9 are missing"));
        assert!(message(&[]).contains("nothing to merge"));
        let mut torn = parts(&[(0, 10)]);
        torn[0].1.rows.pop();
        assert!(Table::merge(torn).unwrap_err().to_string().contains("run this shard again"));
        let mut other = parts(&[(0, 4), (4, 10)]);
        other[1].1.about.fingerprint = "g".into();
        assert!(Table::merge(other).unwrap_err().to_string().contains("different sweeps"));
    }
}

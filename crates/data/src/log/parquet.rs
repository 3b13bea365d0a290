//! Logs written as Apache Parquet: `time`, then the signals, all of them doubles; units are key-value
//! metadata, `unit:position[1]` = `um`.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::WholeFile;

/// Rows of a row group; up to three times as many are kept in memory.
const GROUP: usize = 1 << 16;
/// Before the name of a column: its unit.
const UNIT: &str = "unit:";

/// Writes a Parquet log row by row; it appears when [`finish`](Self::finish) is called, whole.
///
/// From the second row group on, groups are written by a thread of their own.
pub struct ParquetLogWriter {
    out: Out,
    columns: Columns,
}

type Columns = Vec<Vec<f64>>;
type Writer = SerializedFileWriter<WholeFile>;

/// Where row groups go.
enum Out {
    Here(Box<Writer>),
    Behind(Behind),
    /// Writing failed.
    Failed,
}

/// A thread that writes row groups.
struct Behind {
    /// None: no more groups come.
    groups: Option<SyncSender<Columns>>,
    /// Columns that are written, emptied.
    back: Receiver<Columns>,
    thread: Option<JoinHandle<io::Result<Writer>>>,
}

impl Behind {
    fn start(writer: Box<Writer>) -> Out {
        let (groups, taken) = sync_channel::<Columns>(1);
        let (written, back) = sync_channel(2);
        // A thread that does not start must not take the writer with it: it is handed over afterwards.
        let (hand_over, handed) = sync_channel::<Box<Writer>>(1);
        let work = move || {
            let mut writer = *handed.recv().map_err(io::Error::other)?;
            while let Ok(mut columns) = taken.recv() {
                write_group(&mut writer, &mut columns)?;
                // Nobody wants them at the end.
                let _ = written.try_send(columns);
            }
            Ok(writer)
        };
        let Ok(thread) = thread::Builder::new().name("record".into()).spawn(work) else {
            return Out::Here(writer);
        };
        match hand_over.send(writer) {
            Ok(()) => Out::Behind(Self { groups: Some(groups), back, thread: Some(thread) }),
            Err(unsent) => Out::Here(unsent.0),
        }
    }

    /// Gives a full group to the thread, and takes empty columns for the next one.
    fn send(&mut self, columns: &mut Columns) -> io::Result<()> {
        let empty = self.back.try_recv().unwrap_or_else(|_| vec![Vec::new(); columns.len()]);
        let full = std::mem::replace(columns, empty);
        let is_taken = self.groups.as_ref().is_some_and(|groups| groups.send(full).is_ok());
        if is_taken { Ok(()) } else { self.end().map(drop) }
    }

    /// What the thread leaves, when all is written.
    fn end(&mut self) -> io::Result<Writer> {
        drop(self.groups.take());
        let gone = || io::Error::other("the thread that writes the record has ended");
        let thread = self.thread.take().ok_or_else(gone)?;
        thread.join().map_err(|_| gone())?
    }
}

impl Drop for Behind {
    fn drop(&mut self) {
        // The temporary file is gone when this returns.
        let _ = self.end();
    }
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
        let file = WholeFile::create(path)?;
        let schema = Arc::new(schema.map_err(system)?);
        let writer = SerializedFileWriter::new(file, schema, Arc::new(properties));
        let writer = writer.map_err(system)?;
        let out = Out::Here(Box::new(writer));
        Ok(ParquetLogWriter { out, columns: vec![Vec::new(); count] })
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
        if self.columns[0].len() >= GROUP { self.pass_on() } else { Ok(()) }
    }

    /// Passes a full group on; the first one begins the thread.
    fn pass_on(&mut self) -> io::Result<()> {
        self.out = match std::mem::replace(&mut self.out, Out::Failed) {
            Out::Here(writer) => Behind::start(writer),
            other => other,
        };
        let outcome = match &mut self.out {
            Out::Here(writer) => write_group(writer, &mut self.columns),
            Out::Behind(behind) => behind.send(&mut self.columns),
            Out::Failed => Err(io::Error::other("the record could not be written")),
        };
        if outcome.is_err() {
            self.out = Out::Failed;
        }
        outcome
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// The disk is full; nothing remains then.
    pub fn finish(mut self) -> io::Result<()> {
        let mut writer = match self.out {
            Out::Here(writer) => *writer,
            Out::Behind(mut behind) => behind.end()?,
            Out::Failed => return Err(io::Error::other("the record could not be written")),
        };
        write_group(&mut writer, &mut self.columns)?;
        writer.into_inner().map_err(system)?.commit()
    }
}

/// Writes the columns as a row group, and empties them.
fn write_group(writer: &mut Writer, columns: &mut Columns) -> io::Result<()> {
    if columns[0].is_empty() {
        return Ok(());
    }
    let mut group = writer.next_row_group().map_err(system)?;
    for values in columns {
        let Some(mut column) = group.next_column().map_err(system)? else { break };
        let typed = column.typed::<DoubleType>();
        typed.write_batch(values, None, None).map_err(system)?;
        column.close().map_err(system)?;
        values.clear();
    }
    group.close().map_err(system)?;
    Ok(())
}

/// What the system said, where it was that: a full disk is one.
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
        for k in 0..400_000 {
            writer.row(f64::from(k) * 0.1, &[f64::from(k).sin(), 2.0]).unwrap();
        }
        assert!(writer.row(1e9, &[1.0]).is_err());
        writer.finish().unwrap();
        let log = Log::read(&path, &ReadOptions::default()).unwrap();
        assert_eq!((log.len(), log.columns().len(), log.records().len()), (400_000, 2, 1));
        let column = log.column("position[1]").unwrap();
        assert_eq!(column.unit.as_ref().unwrap().text, "um");
        // Several row groups, in their order.
        assert!(column.values.iter().zip(0..).all(|(value, k)| *value == f64::from(k).sin()));
        assert_eq!(log.time()[3], 3.0 * 0.1);
    }

    #[test]
    fn what_is_not_finished_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.parquet");
        let mut writer = ParquetLogWriter::create(&path, &[("y", None)], &[]).unwrap();
        for k in 0..200_000 {
            writer.row(f64::from(k), &[0.0]).unwrap();
        }
        drop(writer);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    /// By the row that meets it or by a later one, with its own words.
    #[test]
    fn an_error_of_the_thread_is_told() {
        let mut behind = match Behind::start(Box::new(writer())) {
            Out::Behind(behind) => behind,
            _ => panic!("no thread"),
        };
        let error = (0..100).find_map(|_| {
            // Columns of other lengths cannot be a group.
            behind.send(&mut vec![vec![0.0; 10], vec![0.0; 9]]).err()
        });
        assert!(error.is_some_and(|error| !error.to_string().contains("thread")));
    }

    fn writer() -> Writer {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.parquet");
        match ParquetLogWriter::create(&path, &[("y", None)], &[]).unwrap().out {
            Out::Here(writer) => *writer,
            _ => panic!("no writer"),
        }
    }
}

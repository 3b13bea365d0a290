//! A record as a CSV file.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use data::{AtomicFile, push_number};

use super::{Column, Recorder};

/// Characters of the longest number, `-2.2250738585072014e-308`, and its comma.
const LONGEST_CELL: usize = 25;

/// Writes rows as they come: UTF-8, comma, decimal point, one header row; memory does not grow.
///
/// Numbers are the shortest that read back to the same bits. The header carries the names alone,
/// as fmpy and others want them, or `name [unit]` after [`CsvRecorder::with_units`]. Several
/// records need [`CsvRecorder::with_record_column`], which tells them apart.
pub struct CsvRecorder<W: Write> {
    out: W,
    units: bool,
    record_column: bool,
    header_written: bool,
    record: usize,
    line: String,
}

impl<W: Write> CsvRecorder<W> {
    /// Writes to `out`, which should be buffered.
    pub fn new(out: W) -> Self {
        let (units, record_column, header_written) = (false, false, false);
        CsvRecorder { out, units, record_column, header_written, record: 0, line: String::new() }
    }

    /// Puts units into the header: `position[1] [um]`.
    pub fn with_units(mut self) -> Self {
        self.units = true;
        self
    }

    /// Writes the number of the record into a column `record` after `time`.
    pub fn with_record_column(mut self) -> Self {
        self.record_column = true;
        self
    }

    /// The writer, with everything written to it.
    pub fn into_inner(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }

    fn header(&mut self, columns: &[Column]) -> io::Result<()> {
        self.out.write_all(if self.units { b"time [s]" } else { b"time" })?;
        if self.record_column {
            self.out.write_all(b",record")?;
        }
        for column in columns {
            let text = match &column.unit {
                Some(unit) if self.units => format!("{} [{unit}]", column.name),
                _ => column.name.clone(),
            };
            write!(self.out, ",{}", quoted(&text))?;
        }
        self.out.write_all(b"\n")
    }
}

impl<W: Write> Recorder for CsvRecorder<W> {
    fn begin(&mut self, record: usize, columns: &[Column], _rows: usize) -> io::Result<()> {
        self.record = record;
        self.line.clear();
        self.line.reserve(LONGEST_CELL * (columns.len() + 2));
        if !self.header_written {
            self.header_written = true;
            self.header(columns)?;
        }
        Ok(())
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.line.clear();
        push_number(&mut self.line, time);
        if self.record_column {
            let _ = write!(self.line, ",{}", self.record);
        }
        for value in values {
            self.line.push(',');
            push_number(&mut self.line, *value);
        }
        self.line.push('\n');
        self.out.write_all(self.line.as_bytes())
    }

    fn end(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// A CSV file that appears whole: rows go to a temporary file beside it, which takes its name by
/// [`CsvFile::finish`]. Call that after a failed run too, to keep the record so far; dropped
/// without it, nothing stays behind.
pub struct CsvFile {
    rows: CsvRecorder<AtomicFile>,
}

impl CsvFile {
    /// Begins the file that will be at `path`.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(CsvFile { rows: CsvRecorder::new(AtomicFile::create(path)?) })
    }

    /// See [`CsvRecorder::with_units`].
    pub fn with_units(mut self) -> Self {
        self.rows = self.rows.with_units();
        self
    }

    /// See [`CsvRecorder::with_record_column`].
    pub fn with_record_column(mut self) -> Self {
        self.rows = self.rows.with_record_column();
        self
    }

    /// Gives the file its name, in place of a file that has it.
    pub fn finish(self) -> io::Result<()> {
        self.rows.into_inner()?.commit()
    }
}

impl Recorder for CsvFile {
    fn begin(&mut self, record: usize, columns: &[Column], rows: usize) -> io::Result<()> {
        self.rows.begin(record, columns, rows)
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.rows.row(time, values)
    }

    fn end(&mut self) -> io::Result<()> {
        self.rows.end()
    }
}

/// Quotes a name that holds a comma, a quote or a line break (RFC 4180).
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> Vec<Column> {
        let column = |name: &str, unit: Option<&str>| Column {
            name: name.to_owned(),
            unit: unit.map(str::to_owned),
        };
        vec![column("position[1]", Some("um")), column("a,\"b\"", None)]
    }

    fn written(mut recorder: CsvRecorder<Vec<u8>>) -> String {
        recorder.begin(0, &columns(), 2).unwrap();
        recorder.row(0.0, &[0.1 + 0.2, -1e-300]).unwrap();
        recorder.end().unwrap();
        recorder.begin(1, &columns(), 1).unwrap();
        recorder.row(1e-9, &[1.0, f64::NAN]).unwrap();
        String::from_utf8(recorder.into_inner().unwrap()).unwrap()
    }

    #[test]
    fn names_only_by_default() {
        let text = written(CsvRecorder::new(Vec::new()));
        let expected =
            "time,position[1],\"a,\"\"b\"\"\"\n0,0.30000000000000004,-1e-300\n1e-9,1,NaN\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn units_and_record_numbers_on_demand() {
        let text = written(CsvRecorder::new(Vec::new()).with_units().with_record_column());
        assert!(text.starts_with("time [s],record,position[1] [um],"), "{text}");
        assert!(text.ends_with("\n1e-9,1,1,NaN\n"), "{text}");
    }

    #[test]
    fn a_file_appears_complete_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        let begun = || {
            let mut file = CsvFile::create(&path).unwrap();
            file.begin(0, &columns(), 1).unwrap();
            file.row(0.5, &[1.0, 2.0]).unwrap();
            file.end().unwrap();
            file
        };
        drop(begun());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        begun().finish().unwrap();
        begun().finish().unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.ends_with("\n0.5,1,2\n"), "{text}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

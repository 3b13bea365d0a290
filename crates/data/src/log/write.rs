//! From a [`Log`] to CSV that this program and fmpy read.
//!
//! fmpy splits the header at commas and takes the rest as names, so names stand alone there and the
//! units go into a companion file (`run.dataset.toml` beside `run.csv`), where the reader finds them.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use super::{ColumnUnit, Log, dataset, header};
use crate::toml_text::{key, quoted};
use crate::{AtomicFile, Problem, Problems, push_number};

/// Where the units of a log are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UnitPlace {
    /// In a companion file, `<name>.dataset.toml`: fmpy finds plain names in the log.
    #[default]
    Sidecar,
    /// In the header, `y [um]`: one file, but fmpy takes the unit as part of the name.
    Header,
    /// Nowhere; a companion file that exists is left alone.
    Nowhere,
}

/// Name, unit and sentence of a column that is going to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColumnHeader {
    /// Name, as in `position[1]`.
    pub name: String,
    /// Unit; `None` for none.
    pub unit: Option<ColumnUnit>,
    /// One sentence; may be empty.
    pub description: String,
}

/// Writes a log row by row; the file appears when [`finish`](Self::finish) is called, whole, and
/// not at all before.
#[derive(Debug)]
pub struct LogWriter {
    origin: String,
    file: AtomicFile,
    sidecar: Option<AtomicFile>,
    names: Vec<String>,
    is_numbered: bool,
    rows: usize,
    last: Option<(i64, f64)>,
    line: String,
}

impl LogWriter {
    /// Begins the file `path` with these columns. With `is_numbered` there is a column `record`.
    ///
    /// # Errors
    /// A name that no reader takes or that stands twice, or the file cannot be written.
    pub fn create(
        path: &Path,
        columns: &[ColumnHeader],
        is_numbered: bool,
        units: UnitPlace,
    ) -> Result<Self, Problems> {
        let origin = path.display().to_string();
        check_names(&origin, columns)?;
        let unwritable =
            |path: &Path, error: &io::Error| Problems::from(Problem::unwritable(path, error));
        let mut file = AtomicFile::create(path).map_err(|error| unwritable(path, &error))?;
        let head = header_line(columns, is_numbered, units);
        file.write_all(head.as_bytes()).map_err(|error| unwritable(path, &error))?;
        let sidecar = match units {
            UnitPlace::Sidecar => begin_sidecar(path, columns)
                .map_err(|error| unwritable(&dataset::sidecar_of(path), &error))?,
            UnitPlace::Header | UnitPlace::Nowhere => None,
        };
        let names = columns.iter().map(|column| column.name.clone()).collect();
        let (rows, last, line) = (0, None, String::new());
        Ok(Self { origin, file, sidecar, names, is_numbered, rows, last, line })
    }

    /// Adds a row of the record `record` (0 where records are not numbered) at `time` in s, with one
    /// value per column.
    ///
    /// # Errors
    /// The wrong number of values, one that is not finite, a time that does not grow in its record,
    /// or the disk is full.
    pub fn row(&mut self, record: i64, time: f64, values: &[f64]) -> Result<(), Problems> {
        let number = self.rows + 1;
        let refuse = |place: &str, value: f64, rule: String, way_out: &str| {
            let problem = Problem::new(&self.origin, format!("row {number}: {rule}"), way_out);
            Err(problem.at(place).value(value).into())
        };
        if values.len() != self.names.len() {
            let rule = format!("{} values, but {} columns", values.len(), self.names.len());
            return refuse("", time, rule, "give one value per column");
        }
        let last = self.last.filter(|(last, _)| *last == record || !self.is_numbered);
        if !time.is_finite() || last.is_some_and(|(_, last)| time <= last) {
            let rule = "time must be finite and grow strictly".to_string();
            return refuse("time", time, rule, "sort the rows, or begin a new record");
        }
        if let Some((name, value)) = self.names.iter().zip(values).find(|(_, v)| !v.is_finite()) {
            let rule = "is not a finite number, which no reader of logs takes".to_string();
            return refuse(name, *value, rule, "look where the run left its range");
        }
        self.line.clear();
        push_number(&mut self.line, time);
        if self.is_numbered {
            let _ = write!(self.line, ",{record}");
        }
        for value in values {
            self.line.push(',');
            push_number(&mut self.line, *value);
        }
        self.line.push('\n');
        self.file.write_all(self.line.as_bytes()).map_err(|error| failed(&self.origin, &error))?;
        self.rows += 1;
        self.last = Some((record, time));
        Ok(())
    }

    /// Gives the file its name, and the companion with the units before it.
    ///
    /// # Errors
    /// The disk is full or the folder is gone; nothing remains of the log then.
    pub fn finish(mut self) -> Result<(), Problems> {
        let origin = std::mem::take(&mut self.origin);
        let sidecar = self.sidecar.take().map_or(Ok(()), AtomicFile::commit);
        sidecar.and_then(|()| self.file.commit()).map_err(|error| failed(&origin, &error))
    }
}

fn failed(origin: &str, error: &io::Error) -> Problems {
    Problem::new(origin, format!("cannot be written: {error}"), "check the space on the disk")
        .into()
}

fn check_names(origin: &str, columns: &[ColumnHeader]) -> Result<(), Problems> {
    let mut names = HashSet::new();
    for column in columns {
        let name = &column.name;
        let problem =
            |rule: String, way_out: &str| Err(Problem::new(origin, rule, way_out).at(name).into());
        if let Err((rule, way_out)) = header::check_name(name) {
            return problem(rule, way_out);
        }
        if header::is_reserved(name) || !names.insert(name.as_str()) {
            return problem("is the name of two columns".into(), "give each its own");
        }
    }
    Ok(())
}

fn header_line(columns: &[ColumnHeader], is_numbered: bool, units: UnitPlace) -> String {
    let mut line = String::from("time");
    if is_numbered {
        line.push_str(",record");
    }
    for column in columns {
        line.push(',');
        let mut cell = column.name.clone();
        if let (UnitPlace::Header, Some(unit)) = (units, &column.unit) {
            let _ = write!(cell, " [{}]", unit.text);
        }
        // RFC 4180.
        if cell.contains([',', '"']) {
            cell = format!("\"{}\"", cell.replace('"', "\"\""));
        }
        line.push_str(&cell);
    }
    line.push('\n');
    line
}

/// Brings the companion of a record that has its units inside up to date, where an earlier log of this name has
/// left one of ours; it would be taken for the new one's.
///
/// # Errors
/// It cannot be written.
pub fn renew_sidecar(path: &Path, columns: &[ColumnHeader]) -> io::Result<()> {
    let sidecar = dataset::sidecar_of(path);
    if !sidecar.is_file() || keep_foreign(&sidecar).is_err() {
        return Ok(());
    }
    AtomicFile::write_all_of(&sidecar, sidecar_text(columns).as_bytes())
}

/// Writes the companion of a record that holds no units, where there are any or an earlier log has left one.
///
/// # Errors
/// It cannot be written, or one of another hand is there.
pub fn write_sidecar(path: &Path, columns: &[ColumnHeader]) -> io::Result<()> {
    let is_empty = |column: &ColumnHeader| column.unit.is_none() && column.description.is_empty();
    if columns.iter().all(is_empty) && !dataset::sidecar_of(path).exists() {
        return Ok(());
    }
    begin_sidecar(path, columns)?.map_or(Ok(()), AtomicFile::commit)
}

/// Whether the companion of a log can be written; checked before the work.
///
/// # Errors
/// One is there that this program did not write, or that this call reads.
pub fn check_sidecar(path: &Path) -> io::Result<()> {
    let sidecar = dataset::sidecar_of(path);
    if is_pipe(path) || !sidecar.exists() {
        return Ok(());
    }
    may_replace(&sidecar)?;
    AtomicFile::create(&sidecar).map(drop)
}

/// A pipe or a device has nothing beside it.
fn is_pipe(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|found| !found.is_file())
}

fn may_replace(sidecar: &Path) -> io::Result<()> {
    files::check_beside(sidecar, || true)?;
    keep_foreign(sidecar)
}

/// Begins the companion; none where one that says the same is there: it may describe what is read.
fn begin_sidecar(path: &Path, columns: &[ColumnHeader]) -> io::Result<Option<AtomicFile>> {
    let (sidecar, text) = (dataset::sidecar_of(path), sidecar_text(columns));
    if is_pipe(path) {
        return Ok(None);
    }
    if std::fs::read_to_string(&sidecar).is_ok_and(|there| there == text) {
        files::note_written(&sidecar);
        return Ok(None);
    }
    may_replace(&sidecar)?;
    let mut file = AtomicFile::create(&sidecar)?;
    file.write_all(text.as_bytes())?;
    Ok(Some(file))
}

/// Refuses to replace a companion that was not written here: it says of another log what nobody can
/// restore.
fn keep_foreign(path: &Path) -> io::Result<()> {
    let Ok(found) = std::fs::metadata(path) else { return Ok(()) };
    let is_ours = |line: &str| line.ends_with(" }") && line.contains(" = { ");
    let text = if found.is_file() { std::fs::read_to_string(path) } else { Ok(String::new()) };
    match text.as_deref().map(|text| text.strip_prefix(SIDECAR_HEAD)) {
        Ok(Some(columns)) if columns.lines().all(is_ours) => Ok(()),
        _ => Err(io::Error::new(
            io::ErrorKind::AlreadyExists,
            "describes a log and was not written by this program; give the output another name",
        )),
    }
}

/// How every companion that is written begins.
const SIDECAR_HEAD: &str = "time = { column = \"time\", unit = \"s\" }\n\n[columns]\n";

fn sidecar_text(columns: &[ColumnHeader]) -> String {
    let mut text = String::from(SIDECAR_HEAD);
    for ColumnHeader { name, unit, description } in columns {
        let mut items = Vec::new();
        if let Some(unit) = unit {
            items.push(format!("unit = {}", quoted(&unit.text)));
        }
        if !description.is_empty() {
            items.push(format!("description = {}", quoted(description)));
        }
        if !items.is_empty() {
            let _ = writeln!(text, "{} = {{ {} }}", key(name), items.join(", "));
        }
    }
    text
}

pub(super) fn log(log: &Log, path: &Path, units: UnitPlace) -> Result<(), Problems> {
    let columns = log.columns.iter().map(|column| ColumnHeader {
        name: column.name.clone(),
        unit: column.unit.clone(),
        description: column.description.clone(),
    });
    let columns: Vec<ColumnHeader> = columns.collect();
    let mut writer = LogWriter::create(path, &columns, log.is_numbered, units)?;
    let mut values = Vec::with_capacity(columns.len());
    for record in &log.records {
        for row in record.rows.clone() {
            values.clear();
            values.extend(log.columns.iter().filter_map(|column| column.values.get(row)));
            let Some(time) = log.time.get(row) else { continue };
            writer.row(record.id, *time, &values)?;
        }
    }
    writer.finish()
}

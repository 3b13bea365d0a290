//! Runs in files: each variable under a name that every format holds and every reader gives back.

use std::path::Path;

use anyhow::Context;
use cosim::record::Column;
use cosim::{Memory, RecordFile, Recorder};
use data::{ColumnHeader, ColumnUnit, Log, UnitPlace};

/// The columns under names that logs can hold, and what is to be said of those that are called otherwise.
pub(crate) fn readable(
    columns: &[Column],
    out: &Path,
) -> anyhow::Result<(Vec<Column>, Vec<String>)> {
    let mut log = Log::new(&out.display().to_string(), vec![0.0])?;
    let (mut named, mut notes) = (Vec::with_capacity(columns.len()), Vec::new());
    for column in columns {
        let name = log.free_name(&column.name);
        if name != column.name {
            notes.push(format!(
                "{}: variable `{}` is column `{name}`, a name that logs can hold",
                out.display(),
                column.name.escape_debug()
            ));
        }
        log.add_column(&name, None, vec![0.0])?;
        named.push(Column { name, unit: column.unit.clone() });
    }
    Ok((named, notes))
}

/// Writes a run as a log, in the format that the file's ending says, else as CSV; what is to be said of it.
pub(crate) fn keep(memory: &Memory, out: &Path) -> anyhow::Result<Vec<String>> {
    let columns: Vec<Column> = memory.series().iter().map(|series| series.column.clone()).collect();
    let (columns, notes) = readable(&columns, out)?;
    let ending = out.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let is_array = matches!(ending.as_deref(), Some("npy" | "npz" | "parquet"));
    if is_array {
        write(memory, &columns, out)
            .with_context(|| format!("{} cannot be written", out.display()))?;
        return Ok(notes);
    }
    let lengths: Vec<(i64, usize)> =
        memory.records().iter().zip(0..).map(|(rows, id)| (id, rows.len())).collect();
    let origin = out.display().to_string();
    let time = memory.time().to_vec();
    let mut log = match lengths.len() {
        0 | 1 => Log::new(&origin, time)?,
        _ => Log::with_records(&origin, time, &lengths)?,
    };
    for (column, series) in columns.iter().zip(memory.series()) {
        let unit = column.unit.as_deref().filter(|unit| model::Unit::parse(unit).is_ok());
        log.add_column(&column.name, unit, series.values.clone())?;
    }
    log.write(out, UnitPlace::Sidecar)?;
    Ok(notes)
}

fn write(memory: &Memory, columns: &[Column], out: &Path) -> std::io::Result<()> {
    let mut file = RecordFile::create(out)?;
    let mut row = Vec::with_capacity(columns.len());
    for (record, rows) in memory.records().iter().enumerate() {
        file.begin(record, columns, rows.len())?;
        for at in rows.clone() {
            row.clear();
            row.extend(memory.series().iter().map(|series| series.values[at]));
            file.row(memory.time()[at], &row)?;
        }
        file.end()?;
    }
    file.finish()?;
    renew(columns, out)
}

/// Whether what stands beside a record of this name can be replaced. To be asked when the logs are read, which
/// the same file may describe.
pub(crate) fn can_keep_beside(out: &Path) -> anyhow::Result<()> {
    let beside = out.with_extension("dataset.toml");
    data::check_sidecar(out).with_context(|| format!("{} cannot be written", beside.display()))
}

/// What stands beside a record of this name is that of the new one: units, which only Parquet has inside.
pub(crate) fn renew(columns: &[Column], out: &Path) -> std::io::Result<()> {
    let header = |column: &Column| ColumnHeader {
        name: column.name.clone(),
        unit: column.unit.as_deref().and_then(|unit| ColumnUnit::parse(unit).ok()),
        description: String::new(),
    };
    let columns: Vec<ColumnHeader> = columns.iter().map(header).collect();
    match cli::ends_in(out, "parquet") {
        true => data::renew_sidecar(out, &columns),
        false => data::write_sidecar(out, &columns),
    }
}

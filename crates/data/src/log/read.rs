//! From a file to a [`Log`]: CSV here, other formats in [`super::formats`].

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use csv::ByteRecord;

use super::dataset::{self, Dataset};
use super::header::Context;
use super::table::{Place, Table};
use super::{Log, ReadOptions, cell, formats};
use crate::{Problem, Problems};

/// Bytes within which the header must end.
const LONGEST_HEADER: usize = 1 << 20;

pub(super) fn file(path: &Path, options: &ReadOptions) -> Result<Log, Problems> {
    let origin = path.display().to_string();
    let unreadable = |error: std::io::Error| {
        let rule = format!("cannot be read: {error}");
        Problems::from(Problem::new(&origin, rule, "check the name and the permissions"))
    };
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().is_ok_and(|found| found.is_dir()) {
        let problem = Problem::new(&origin, "is a folder", "give the name of a file in it");
        return Err(problem.into());
    }
    let datasets = dataset::beside(path)?;
    let mut bytes = BufReader::with_capacity(LONGEST_HEADER, file);
    let start = bytes.fill_buf().map_err(unreadable)?;
    if let Some(format) = formats::Format::of(path, start) {
        return format.read(path, &origin, options, &datasets);
    }
    read(bytes, &origin, options, &datasets)
}

pub(super) fn text(bytes: &[u8], origin: &str, options: &ReadOptions) -> Result<Log, Problems> {
    read(bytes, origin, options, &[])
}

fn read(
    mut bytes: impl BufRead,
    origin: &str,
    options: &ReadOptions,
    datasets: &[Dataset],
) -> Result<Log, Problems> {
    options.check(origin)?;
    check_is_text(&mut bytes, origin)?;
    let mut rows = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
    let mut row = ByteRecord::new();
    let broken = |error: csv::Error| {
        let rule = format!("cannot be read: {error}");
        Problems::from(Problem::new(origin, rule, "check the disk or the connection"))
    };
    if !rows.read_byte_record(&mut row).map_err(broken)? {
        let way_out = "give a header row and data rows";
        return Err(Problem::new(origin, "is empty", way_out).into());
    }
    let line = line_of(&row);
    let cells = header_cells(&row, origin, line)?;
    let context = Context { file: origin, line: Some(line), options, datasets };
    let (heads, problems) = context.heads(&cells);
    let mut table = Table::new(origin, heads, context.rate());
    // Without a place for each cell, the rows mean nothing.
    if !problems.is_empty() {
        return Err(Problems::new(problems));
    }
    while rows.read_byte_record(&mut row).map_err(broken)? {
        let line = Place::Line(line_of(&row));
        table.row(row.iter(), line);
    }
    table.finish()
}

/// Refuses what is no text before a parser makes nonsense of it.
fn check_is_text(bytes: &mut impl BufRead, origin: &str) -> Result<(), Problems> {
    let refuse = |rule: &str| {
        Err(Problem::new(origin, rule, "save the log as CSV in UTF-8, with commas").into())
    };
    let head = match bytes.fill_buf() {
        Ok(head) => &head[..head.len().min(LONGEST_HEADER)],
        Err(error) => return refuse(&format!("cannot be read: {error}")),
    };
    match head {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => return refuse("is text in UTF-16"),
        [b'P', b'K', 3, 4, ..] => return refuse("is a zip archive or a workbook"),
        _ => {}
    }
    if head.contains(&0) {
        return refuse("is no text but binary data");
    }
    if head.len() == LONGEST_HEADER && !head.contains(&b'\n') && !head.contains(&b'\r') {
        return refuse("has no line end in its first mebibyte");
    }
    Ok(())
}

fn line_of(row: &ByteRecord) -> usize {
    row.position().map_or(0, |position| usize::try_from(position.line()).unwrap_or(0))
}

/// The header's cells as texts.
fn header_cells(row: &ByteRecord, origin: &str, line: usize) -> Result<Vec<String>, Problems> {
    let refuse = |rule: &str, way_out: &str| {
        Err(Problems::from(Problem::new(origin, rule, way_out).line(line)))
    };
    let Ok(cells) = row
        .iter()
        .map(|cell| str::from_utf8(cell).map(str::to_string))
        .collect::<Result<Vec<_>, _>>()
    else {
        return refuse("the header is no UTF-8", "save the file as UTF-8");
    };
    let way_out = "save the file with commas between cells and decimal points";
    if let [only] = cells.as_slice() {
        if only.contains(';') {
            return refuse("the columns are separated by semicolons", way_out);
        }
        if only.contains('\t') {
            return refuse("the columns are separated by tabs", way_out);
        }
    }
    if cells.iter().all(|cell| cell::parse(cell.as_bytes()).is_ok()) {
        let way_out = "put a first line with the names of the columns, as in time,u,y";
        return refuse("has no header: the first line holds numbers", way_out);
    }
    Ok(cells)
}

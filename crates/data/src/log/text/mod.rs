//! From a text to a [`Log`]: plain CSV at once, other texts by their [`Layout`]; other formats in [`super::formats`].

mod cells;
mod decode;
mod ends;
mod instant;
mod layout;
mod numbers;
mod pairs;
mod preamble;
mod rows;

use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use csv::ByteRecord;

pub(super) use cells::Kind;
pub(super) use instant::Since;
pub(super) use layout::Layout;

use cells::Dialect;
use ends::Ends;
use rows::{Rows, csv_rows};

use super::dataset::{self, Dataset};
use super::header::Context;
use super::header_cell::split;
use super::{Log, ReadOptions, cell, formats, time_column};
use crate::{Problem, Problems};

/// Bytes within which the table must begin.
const LONGEST_HEADER: usize = 1 << 20;
/// Bytes that are read at a time.
const BUFFER: usize = 1 << 16;

pub(super) fn file(path: &Path, options: &ReadOptions) -> Result<Log, Problems> {
    let origin = path.display().to_string();
    let unreadable = |error: std::io::Error| {
        let rule = format!("cannot be read: {error}");
        Problems::from(Problem::new(&origin, rule, "check the name and the permissions"))
    };
    let mut file = File::open(path).map_err(unreadable)?;
    if file.metadata().is_ok_and(|found| found.is_dir()) {
        let problem = Problem::new(&origin, "is a folder", "give the name of a file in it");
        return Err(problem.into());
    }
    let datasets = {
        let most = options.memory.unwrap_or(0).max(files::LONGEST_TEXT);
        dataset::beside(path, most)?
    };
    let head = head_of(&mut file).map_err(unreadable)?;
    if let Some(format) = formats::Format::of(path, &head) {
        drop(head);
        return format.read(path, &origin, options, &datasets);
    }
    read(head, file, &origin, options, &datasets)
}

pub(super) fn text(bytes: &[u8], origin: &str, options: &ReadOptions) -> Result<Log, Problems> {
    let (head, rest) = bytes.split_at(bytes.len().min(LONGEST_HEADER));
    read(head.to_vec(), rest, origin, options, &[])
}

fn head_of(bytes: &mut impl Read) -> std::io::Result<Vec<u8>> {
    let mut head = Vec::new();
    bytes.take(LONGEST_HEADER as u64).read_to_end(&mut head)?;
    Ok(head)
}

/// What is known of a file that is read.
struct Source<'a> {
    origin: &'a str,
    options: &'a ReadOptions,
    datasets: &'a [Dataset],
}

impl Source<'_> {
    fn problem(&self, rule: impl Into<String>, way_out: &str) -> Problem {
        Problem::new(self.origin, rule, way_out)
    }

    fn broken(&self, error: impl std::fmt::Display) -> Problems {
        self.problem(format!("cannot be read: {error}"), "check the disk or the connection").into()
    }

    fn context<'c>(&'c self, line: usize, layout: Option<&'c Layout>) -> Context<'c> {
        let Self { origin, options, datasets } = *self;
        Context { file: origin, line: Some(line), options, datasets, layout }
    }
}

/// Reads a text that begins with `head`, of which `rest` is the rest.
fn read(
    mut head: Vec<u8>,
    rest: impl Read,
    origin: &str,
    options: &ReadOptions,
    datasets: &[Dataset],
) -> Result<Log, Problems> {
    options.check(origin)?;
    let source = Source { origin, options, datasets };
    let mut notes = Vec::new();
    let mut rest: Box<dyn Read + '_> = Box::new(rest);
    if let Some(is_big) = decode::is_utf16(&head) {
        rest = Box::new(decode::Utf16::new(Cursor::new(head).chain(rest), is_big));
        head = head_of(&mut rest).map_err(|error| source.broken(error))?;
        notes.push("is text in UTF-16".to_owned());
    }
    if head.starts_with(b"\xef\xbb\xbf") {
        head.drain(..3);
    }
    check_is_text(&head, &source)?;
    let mut log = match plain_header(&head) {
        Some(cells) if options.columns.is_empty() => {
            let ends = Ends::of(&head);
            let mut rows = csv_rows(Dialect::PLAIN, &head[..]);
            let mut row = ByteRecord::new();
            rows.read_byte_record(&mut row).map_err(|error| source.broken(error))?;
            // Blank lines count as lines where line feeds are counted.
            let blank = match ends {
                Ends::CarriageReturn => head.iter().take_while(|byte| **byte == b'\r').count(),
                _ => 0,
            };
            let line = blank + ends.line(&row, rows.position());
            let mut end = usize::try_from(rows.position().byte()).unwrap_or(head.len());
            end += usize::from(head.get(end) == Some(&b'\n'));
            let above = match ends {
                Ends::CarriageReturn => line,
                _ => head[..end].iter().filter(|byte| **byte == b'\n').count(),
            };
            head.drain(..end);
            let rows = Cursor::new(head).chain(rest);
            Rows::begin(&cells, &source, line, None)?.csv(rows, &source, ends, above)
        }
        _ => laid_out(head, rest, &source, &mut notes),
    }?;
    log.remarks.notes.splice(..0, notes);
    Ok(log)
}

/// The names of a plain CSV: a row of names, and below it one with as many numbers.
fn plain_header(head: &[u8]) -> Option<Vec<String>> {
    let mut rows = csv_rows(Dialect::PLAIN, head);
    let mut row = ByteRecord::new();
    let names = rows.read_byte_record(&mut row).ok()?.then(|| cells_of(&row))?;
    let is_name = |(at, name): (usize, &String)| {
        cell::parse(name.trim().as_bytes()).is_err() && (at == 0 || !name.trim().is_empty())
    };
    let mut marks = names.iter().map(|name| name.trim_start().as_bytes());
    // Names of variables that our records hold may look like numbers or comments.
    let is_own = names.first().is_some_and(|name| split(name).0 == "time")
        && names.iter().all(|name| !name.trim().is_empty());
    if !is_own
        && (!names.iter().enumerate().all(is_name)
            || marks.any(|name| cells::comment(name).is_some()))
    {
        return None;
    }
    let has_row = rows.read_byte_record(&mut row).ok()?;
    let are_numbers = row.len() == names.len() && row.iter().all(|cell| cell::parse(cell).is_ok());
    (has_row && are_numbers && !time_column::has_several(&names)).then_some(names)
}

/// A text with anything before its table, or with other cells than CSV has.
fn laid_out(
    head: Vec<u8>,
    rest: impl Read,
    source: &Source<'_>,
    notes: &mut Vec<String>,
) -> Result<Log, Problems> {
    let Some(mut layout) = Layout::find(&head) else {
        let (rule, way_out) = match head.trim_ascii() {
            [] => ("is empty", "give a header row and data rows"),
            _ => ("has no rows of data", "give at least one row of numbers below the header"),
        };
        return Err(source.problem(rule, way_out).into());
    };
    if !head.is_ascii() && std::str::from_utf8(&head[..layout.start.min(head.len())]).is_err() {
        notes.push("the text above the table is no UTF-8, it is read as Latin-1".into());
    }
    name_columns(&mut layout, source)?;
    notes.append(&mut layout.notes);
    let line = layout.line;
    let ends = Ends::of(&head[layout.start..]);
    let bytes = Cursor::new(head[layout.start..].to_vec()).chain(rest);
    if time_column::has_several(&layout.header) {
        return pairs::read(bytes, &layout, source);
    }
    let table = Rows::begin(&layout.header, source, layout.header_line, Some(&layout))?;
    match layout.dialect.separator {
        b' ' => table.words(BufReader::with_capacity(BUFFER, bytes), source, line),
        _ => table.csv(bytes, source, ends, line - 1),
    }
}

/// The names that the caller gives, or that somebody has to give.
fn name_columns(layout: &mut Layout, source: &Source<'_>) -> Result<(), Problems> {
    let given = &source.options.columns;
    let count = layout.kinds.len();
    if given.is_empty() {
        if layout.has_names {
            return Ok(());
        }
        let rule = "has no header: the first line holds numbers";
        let names = match (count, layout.may_begin_with_times()) {
            (1, _) => "y --rate HZ".to_owned(),
            (_, true) => example(count, "time", 1),
            (_, false) => example(count, "y1", 2) + " --rate HZ",
        };
        let way_out = format!("say the names: --columns {names}; or put them into a first line");
        return Err(source.problem(rule, &way_out).line(layout.line).into());
    }
    if given.len() != count {
        let rule = format!("--columns has {} names, a row {count} cells", given.len());
        return Err(source.problem(rule, "give one name for each cell").line(layout.line).into());
    }
    if layout.has_names {
        let note = format!("the names of line {} are replaced by those given", layout.header_line);
        layout.notes.push(note);
    }
    layout.header.clone_from(given);
    Ok(())
}

/// Names of so many columns: the first one's, and `y2`, … from this number on.
fn example(count: usize, first: &str, from: usize) -> String {
    let others = (from..from + count - 1).map(|at| format!("y{at}"));
    let names = std::iter::once(first.to_owned()).chain(others);
    names.take(6).collect::<Vec<_>>().join(",") + if count > 6 { ",…" } else { "" }
}

/// Refuses what is no text before a parser makes nonsense of it.
fn check_is_text(head: &[u8], source: &Source<'_>) -> Result<(), Problems> {
    let refuse =
        |rule: &str| Err(source.problem(rule, "save the log as CSV in UTF-8, with commas").into());
    let is_zip = head.starts_with(b"PK\x03\x04");
    let model = match () {
        () if is_zip && source.origin.to_lowercase().ends_with(".fmu") => Some("is an FMU, no log"),
        () if head.starts_with(b"piezoloop = ") => Some("is a blueprint, no log"),
        () => None,
    };
    if let Some(rule) = model {
        let way_out = "give measured data; a model is given with --model or as the first argument";
        return Err(source.problem(rule, way_out).into());
    }
    if is_zip {
        return refuse("is a zip archive or a workbook");
    }
    if head.contains(&0) {
        return refuse("is no text but binary data");
    }
    if head.len() == LONGEST_HEADER && !head.contains(&b'\n') && !head.contains(&b'\r') {
        return refuse("has no line end in its first mebibyte");
    }
    Ok(())
}

fn cells_of(row: &ByteRecord) -> Vec<String> {
    row.iter().map(decode::text).collect()
}

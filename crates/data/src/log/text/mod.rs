//! From a text to a [`Log`]: plain CSV at once, other texts by their [`Layout`]; other formats in [`super::formats`].

mod cells;
mod decode;
mod ends;
mod instant;
mod layout;
mod numbers;
mod pairs;
mod preamble;

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::Path;

use csv::{ByteRecord, Reader, ReaderBuilder};

pub(super) use cells::Kind;
pub(super) use instant::Since;
pub(super) use layout::Layout;

use cells::{Dialect, blanks};
use ends::Ends;
use preamble::Preamble;

use super::dataset::{self, Dataset};
use super::header::{Context, Header, Role};
use super::header_cell::split;
use super::lines::Place;
use super::table::{Grid, Table};
use super::{ColumnUnit, Log, ReadOptions, cell, formats, time_column};
use crate::{Problem, Problems, counted};

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
            table(&cells, &source, line, None)?.csv(rows, &source, ends, above)
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
        return Err(if head.trim_ascii().is_empty() {
            source.problem("is empty", "give a header row and data rows").into()
        } else {
            source
                .problem("has no rows of data", "give at least one row of numbers below the header")
                .into()
        });
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
    let table = table(&layout.header, source, layout.header_line, Some(&layout))?;
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
        layout
            .notes
            .push(format!("the names of line {} are replaced by those given", layout.header_line));
    }
    layout.header.clone_from(given);
    Ok(())
}

/// Whether a cell repeats this name of a column, whose unit may have stood in a row of its own.
fn is_name_of(name: &str, cell: &[u8]) -> bool {
    let cell = decode::text(cell);
    name.strip_prefix(cell.trim()).is_some_and(|rest| rest.is_empty() || rest.starts_with(" ["))
}

/// Names of so many columns: the first one's, and `y2`, … from this number on.
fn example(count: usize, first: &str, from: usize) -> String {
    let others = (from..from + count - 1).map(|at| format!("y{at}"));
    let names = std::iter::once(first.to_owned()).chain(others);
    names.take(6).collect::<Vec<_>>().join(",") + if count > 6 { ",…" } else { "" }
}

/// The table that these names begin.
fn table<'a>(
    cells: &[String],
    source: &Source<'a>,
    line: usize,
    layout: Option<&Layout>,
) -> Result<Rows<'a>, Problems> {
    let context = source.context(line, layout);
    let Header { heads, problems, notes } = context.heads(cells);
    // Without a place for each cell, the rows mean nothing.
    if !problems.is_empty() {
        return Err(Problems::new(problems));
    }
    let has_time = heads.iter().any(|head| matches!(head.role, Role::Time(_) | Role::Instant(_)));
    if let Some(key) = layout.and_then(|layout| layout.preamble.apart.as_deref())
        && !has_time
        && source.options.rate.is_none()
    {
        let rule = format!("\"{key}\" differs between the channels, which have no column of time");
        let way_out = "save it with a column of time for each channel (LabVIEW: X Value (Time) Columns \
                       \"One column per channel\"), or give one rate: --rate HZ";
        return Err(source.problem(rule, way_out).into());
    }
    let start = layout.and_then(|layout| layout.preamble.start).unwrap_or(0.0);
    let grid = Grid { start, ..Grid::at_rate(context.rate()) };
    let has_commas = layout.is_some_and(|layout| layout.dialect.has_commas);
    Ok(Rows {
        table: Table::new(source.origin, heads, grid).with_commas(has_commas),
        notes,
        dialect: layout.map_or(Dialect::PLAIN, |layout| layout.dialect),
        names: cells.to_vec(),
        comments: 0,
        units: layout.map_or_else(Vec::new, |layout| layout.preamble.units.clone()),
        without_units: 0,
        part: None,
    })
}

/// A further part of the table, of which the head is read.
struct Part {
    head: Preamble,
    /// Where it begins.
    place: Place,
    /// Whether the line of names is next.
    has_ended: bool,
}

/// The rows of a text on their way into a table.
struct Rows<'a> {
    table: Table<'a>,
    notes: Vec<String>,
    dialect: Dialect,
    /// The header's cells.
    names: Vec<String>,
    /// Lines between the rows that were comments.
    comments: usize,
    /// Cells of the row of units above the first part.
    units: Vec<String>,
    /// Further parts that say none.
    without_units: usize,
    /// What stands above a further part of the table, while it is read.
    part: Option<Part>,
}

impl Rows<'_> {
    /// Reads rows as CSV; `before` lines stand above the first one.
    fn csv(
        mut self,
        mut bytes: impl Read,
        source: &Source<'_>,
        ends: Ends,
        mut before: usize,
    ) -> Result<Log, Problems> {
        let mut rest = Vec::new();
        if ends != Ends::CarriageReturn {
            let separator = self.dialect.separator;
            (rest, before) = numbers::read(&mut bytes, separator, &mut self.table, before)
                .map_err(|error| source.broken(error))?;
        }
        let bytes = Cursor::new(rest).chain(bytes).chain(ends.behind());
        let mut rows = csv_rows(self.dialect, bytes);
        let mut row = ByteRecord::new();
        while rows.read_byte_record(&mut row).map_err(|error| source.broken(error))? {
            let place = Place::Line(before + ends.line(&row, rows.position()));
            // A line of blanks, or of separators where nothing is between them.
            if self.names.len() > 1
                && row[0].trim_ascii().is_empty()
                && row.iter().all(|cell| cell.trim_ascii().is_empty())
            {
                continue;
            }
            if self.part.is_some() || may_be_none(row.get(0).unwrap_or_default()) {
                let cells: Vec<&[u8]> = row.iter().collect();
                if self.is_between(&cells, place) {
                    continue;
                }
            }
            self.table.row(row.iter(), place);
        }
        self.finish()
    }

    /// Reads rows of words with blanks between them; the first one stands in line `line`.
    fn words(
        mut self,
        mut bytes: impl BufRead,
        source: &Source<'_>,
        line: usize,
    ) -> Result<Log, Problems> {
        let mut text = Vec::new();
        for line in line.. {
            text.clear();
            if bytes.read_until(b'\n', &mut text).map_err(|error| source.broken(error))? == 0 {
                break;
            }
            let cells: Vec<&[u8]> = blanks(&text).collect();
            let Some(first) = cells.first() else { continue };
            let place = Place::Line(line);
            if (self.part.is_some() || may_be_none(first)) && self.is_between(&cells, place) {
                continue;
            }
            self.table.row(cells.into_iter(), place);
        }
        self.finish()
    }

    /// Whether a line is no row but a comment, or part of a header that comes again.
    fn is_between(&mut self, cells: &[&[u8]], place: Place) -> bool {
        let first = cells.first().copied().unwrap_or_default();
        let is_row = cells.len() > 1
            && cells.iter().filter(|cell| self.dialect.kind(cell).is_value()).count() * 2
                > cells.len();
        if is_row && self.part.is_none() {
            return false;
        }
        if cells::comment(first).is_some() {
            self.comments += 1;
            return true;
        }
        // LabVIEW writes such a head before each part that it appends.
        if first == b"Channels" {
            self.part = Some(Part { head: Preamble::default(), place, has_ended: false });
        }
        // A recorder that appends to its file may write the header again.
        if self.part.is_none() && cells.len() > 1 && self.is_header(cells) {
            let grid = self.table.grid();
            self.table.begin_part(grid);
            return true;
        }
        let Some(part) = &mut self.part else { return false };
        let line = cells.join(&self.dialect.separator);
        let is_header = cells.iter().zip(&self.names).all(|(cell, name)| {
            let cell = decode::text(cell);
            cell.trim().is_empty() || name.starts_with(cell.trim())
        }) && cells.len() > 1;
        part.head.line(&line, self.dialect);
        let has_ended = std::mem::replace(&mut part.has_ended, first.starts_with(b"***End"));
        if is_header {
            self.begin_part();
        } else if has_ended {
            // Its rows would be read as lines of a head.
            let part = self.part.take();
            self.table.other_names(&self.names, cells, part.map_or(place, |part| part.place));
        }
        true
    }

    /// Begins a further part, whose head is read.
    fn begin_part(&mut self) {
        let Some(Part { head, place, .. }) = self.part.take() else { return };
        let grid = Grid { start: head.start.unwrap_or(0.0), ..Grid::at_rate(head.rate) };
        self.table.begin_part(grid);
        if head.units.iter().all(String::is_empty) {
            self.without_units += usize::from(self.units.iter().any(|unit| !unit.is_empty()));
            return;
        }
        for at in 0..self.units.len().max(head.units.len()) {
            let [first, other] = [&self.units, &head.units]
                .map(|units| units.get(at).map_or("", |unit| unit.trim()));
            // The key stands before them.
            if !is_same_unit(first, other) {
                self.table.leave_out(at + 1, other_unit(first, other, place));
            }
        }
    }

    /// Whether these are the header's cells, all of them.
    fn is_header(&self, cells: &[&[u8]]) -> bool {
        let names = self.names.iter().rev().skip_while(|name| name.trim().is_empty());
        let cells = cells.iter().rev().skip_while(|cell| cell.trim_ascii().is_empty());
        let is_name = |(name, cell): (&String, &&[u8])| is_name_of(name.trim(), cell);
        names.clone().count() == cells.clone().count() && names.zip(cells).all(is_name)
    }

    fn finish(self) -> Result<Log, Problems> {
        let mut log = self.table.finish()?;
        let mut notes = self.notes;
        if self.comments > 0 {
            notes.push(format!(
                "comments between the rows are skipped: {}",
                counted(self.comments, "line")
            ));
        }
        if self.without_units > 0 {
            let parts = counted(self.without_units, "further part");
            notes.push(format!("no units are said in {parts}: they are those of the first part"));
        }
        if log.records().len() > 1
            && log.is_numbered
            && self.part.is_none()
            && log.records()[0].id == 0
        {
            notes.push(format!(
                "has {} parts with a header each, which are records",
                log.records().len()
            ));
        }
        log.remarks.notes.splice(..0, notes);
        Ok(log)
    }
}

/// Whether two texts mean the same unit.
fn is_same_unit(left: &str, right: &str) -> bool {
    let unit = |text| ColumnUnit::parse(text).ok().map(|unit| unit.unit);
    left == right || unit(left).is_some_and(|left| Some(left) == unit(right))
}

/// Why a column is left out whose unit is another one in a further part.
fn other_unit(first: &str, other: &str, place: Place) -> String {
    let name =
        |unit: &str| if unit.is_empty() { "no unit".to_owned() } else { format!("\"{unit}\"") };
    format!(
        "has {} in the first part and {} in that of {place}; save the parts to files of their own",
        name(first),
        name(other)
    )
}

/// Whether a line that begins with this cell may be another thing than a row; asked of each row.
fn may_be_none(cell: &[u8]) -> bool {
    let first = cell.iter().find(|byte| !byte.is_ascii_whitespace());
    first.is_some_and(|byte| !matches!(byte, b'0'..=b'9' | b'-' | b'+' | b'.'))
}

fn csv_rows<R: Read>(dialect: Dialect, bytes: R) -> Reader<R> {
    ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(dialect.separator)
        .buffer_capacity(BUFFER)
        .from_reader(bytes)
}

/// Refuses what is no text before a parser makes nonsense of it.
fn check_is_text(head: &[u8], source: &Source<'_>) -> Result<(), Problems> {
    let refuse =
        |rule: &str| Err(source.problem(rule, "save the log as CSV in UTF-8, with commas").into());
    if let [b'P', b'K', 3, 4, ..] = head {
        if source.origin.to_lowercase().ends_with(".fmu") {
            let rule = "is an FMU, no log";
            return Err(source
                .problem(
                    rule,
                    "give measured data; a model is given with --model or as the first argument",
                )
                .into());
        }
        return refuse("is a zip archive or a workbook");
    }
    if head.starts_with(b"piezoloop = ") {
        let rule = "is a blueprint, no log";
        return Err(source
            .problem(
                rule,
                "give measured data; a model is given with --model or as the first argument",
            )
            .into());
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

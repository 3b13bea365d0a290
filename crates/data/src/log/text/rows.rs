//! The rows of a text on their way into a table, with what stands between them: comments, further headers and heads.

use std::io::{BufRead, Cursor, Read};

use csv::{ByteRecord, Reader, ReaderBuilder};

use super::cells::{self, Dialect, blanks};
use super::ends::Ends;
use super::layout::Layout;
use super::preamble::Preamble;
use super::{BUFFER, Source, decode, numbers};
use crate::log::header::{Header, Role};
use crate::log::lines::Place;
use crate::log::table::{Grid, Table};
use crate::log::{ColumnUnit, Log};
use crate::{Problems, counted};

/// A further part of the table, of which the head is read.
struct Part {
    head: Preamble,
    /// Where it begins.
    place: Place,
    /// Whether the line of names is next.
    has_ended: bool,
}

/// The rows of a text on their way into a table.
pub(super) struct Rows<'a> {
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

impl<'a> Rows<'a> {
    /// The table that these names begin, without rows.
    pub(super) fn begin(
        cells: &[String],
        source: &Source<'a>,
        line: usize,
        layout: Option<&Layout>,
    ) -> Result<Self, Problems> {
        let context = source.context(line, layout);
        let Header { heads, problems, notes } = context.heads(cells);
        // Without a place for each cell, the rows mean nothing.
        if !problems.is_empty() {
            return Err(Problems::new(problems));
        }
        let has_time =
            heads.iter().any(|head| matches!(head.role, Role::Time(_) | Role::Instant(_)));
        if let Some(key) = layout.and_then(|layout| layout.preamble.apart.as_deref())
            && !has_time
            && source.options.rate.is_none()
        {
            let rule =
                format!("\"{key}\" differs between the channels, which have no column of time");
            let way_out = "save it with a column of time for each channel (LabVIEW: X Value (Time) Columns \
                           \"One column per channel\"), or give one rate: --rate HZ";
            return Err(source.problem(rule, way_out).into());
        }
        let start = layout.and_then(|layout| layout.preamble.start).unwrap_or(0.0);
        let grid = Grid { start, ..Grid::at_rate(context.rate()) };
        let has_commas = layout.is_some_and(|layout| layout.dialect.has_commas);
        Ok(Self {
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

    /// Reads rows as CSV; `before` lines stand above the first one.
    pub(super) fn csv(
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
    pub(super) fn words(
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

/// Whether a cell repeats this name of a column, whose unit may have stood in a row of its own.
pub(super) fn is_name_of(name: &str, cell: &[u8]) -> bool {
    let cell = decode::text(cell);
    name.strip_prefix(cell.trim()).is_some_and(|rest| rest.is_empty() || rest.starts_with(" ["))
}

/// Whether two texts mean the same unit.
pub(super) fn is_same_unit(left: &str, right: &str) -> bool {
    let unit = |text| ColumnUnit::parse(text).ok().map(|unit| unit.unit);
    left == right || unit(left).is_some_and(|left| Some(left) == unit(right))
}

/// Why a column is left out whose unit is another one in a further part.
pub(super) fn other_unit(first: &str, other: &str, place: Place) -> String {
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

/// A parser of these rows.
pub(super) fn csv_rows<R: Read>(dialect: Dialect, bytes: R) -> Reader<R> {
    ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(dialect.separator)
        .buffer_capacity(BUFFER)
        .from_reader(bytes)
}

//! Where the table of a text begins, and what stands above it.
//!
//! The first row of numbers is looked for; what stands above it is a preamble, names and units. No maker's
//! format is known by its name.

use super::cells::{Dialect, Kind, comment};
use super::decode;
use super::instant::Instant;
use super::preamble::Preamble;
use crate::log::header_cell::{split, split_unit};
use crate::log::{ColumnUnit, cell, time_column};

/// Lines that are looked at.
const MOST_LINES: usize = 2000;
/// Rows from which samples are taken.
const MOST_SAMPLES: usize = 100;
/// Lines above the table that may hold names and units.
const MOST_ABOVE: usize = 6;

/// How a text is read.
#[derive(Debug)]
pub(in super::super) struct Layout {
    pub(super) dialect: Dialect,
    /// Byte of the text at which the first row begins, and its line from 1.
    pub(super) start: usize,
    pub(super) line: usize,
    /// Line of the names, or of the first row where there are none.
    pub(super) header_line: usize,
    /// Name and unit of each cell of a row, as in `y [um]`; a cell without a name is empty in all rows.
    pub(super) header: Vec<String>,
    /// Whether the names were found, or created for lack of them.
    pub(super) has_names: bool,
    pub(in super::super) kinds: Vec<Kind>,
    /// A cell of each column.
    pub(in super::super) samples: Vec<String>,
    /// Whether the first column counts rows.
    pub(in super::super) is_counter: bool,
    /// Whether the first column grows from row to row.
    grows: bool,
    pub(in super::super) preamble: Preamble,
    pub(super) notes: Vec<String>,
}

/// A line that is not blank.
struct Line<'a> {
    number: usize,
    start: usize,
    bytes: &'a [u8],
}

fn lines(head: &[u8]) -> Vec<Line<'_>> {
    let end = if head.contains(&b'\n') { b'\n' } else { b'\r' };
    let mut start = 0;
    let all = head.split(|byte| *byte == end).zip(1..).map(|(bytes, number)| {
        let line = Line { number, start, bytes };
        start += bytes.len() + 1;
        line
    });
    all.filter(|line| !line.bytes.trim_ascii().is_empty()).take(MOST_LINES).collect()
}

/// Rows of numbers that follow each other: their lines, by position.
struct Run {
    first: usize,
    end: usize,
    cells: usize,
    score: usize,
}

/// The longest run of a dialect: lines with as many cells, in which numbers stay numbers.
fn longest(lines: &[Line<'_>], dialect: Dialect) -> Option<Run> {
    let mut best: Option<Run> = None;
    let mut open: Option<(Run, Vec<Kind>)> = None;
    for (at, line) in lines.iter().enumerate() {
        if comment(line.bytes).is_some() {
            continue;
        }
        let kinds: Vec<Kind> =
            dialect.split(line.bytes).iter().map(|cell| dialect.kind(cell)).collect();
        let values = kinds.iter().filter(|kind| kind.is_value()).count();
        let texts = kinds.iter().filter(|kind| **kind == Kind::Text).count();
        let score = (2 * values).saturating_sub(texts);
        let goes_on = open.as_ref().is_some_and(|(_, before)| {
            before.len() == kinds.len()
                && before.iter().zip(&kinds).all(|(a, b)| {
                    *a == Kind::Empty || *b == Kind::Empty || a.is_value() == b.is_value()
                })
        });
        match &mut open {
            Some((run, _)) if goes_on && values > 0 => {
                run.end = at + 1;
                run.score += score;
            }
            _ => {
                open = (values > 0)
                    .then(|| (Run { first: at, end: at + 1, cells: kinds.len(), score }, kinds));
            }
        }
        if let Some((run, _)) = &open
            && best.as_ref().is_none_or(|best| run.score > best.score)
        {
            best = Some(Run { ..*run });
        }
    }
    best
}

/// How well a run is a table: that a line just above it has as many cells speaks for the dialect.
fn weight(lines: &[Line<'_>], dialect: Dialect, run: &Run) -> usize {
    let above = lines[..run.first].iter().rev().take(3);
    let has_header = above.into_iter().any(|line| {
        let cells = dialect.split(comment(line.bytes).unwrap_or(line.bytes));
        let values = cells.iter().filter(|cell| dialect.kind(cell).is_value()).count();
        // LabVIEW's names end with one of remarks, which rows need not have.
        let is_longer = cells.last().is_some_and(|cell| is_remark(&decode::text(cell)));
        cells.len() - usize::from(is_longer && cells.len() > run.cells) == run.cells
            && 2 * values < run.cells
    });
    if has_header && run.cells > 1 { 5 * run.score } else { run.score }
}

impl Layout {
    /// The table of a text that begins like this; `None` where no line holds numbers.
    pub(super) fn find(head: &[u8]) -> Option<Self> {
        let lines = lines(head);
        let mut found: Option<(Dialect, Run, usize)> = None;
        for dialect in Dialect::ALL {
            let Some(run) = longest(&lines, dialect) else { continue };
            // Without one, decimal commas would only make texts of numbers with decimal points.
            let is_written = lines[run.first..run.end].iter().any(|l| l.bytes.contains(&b','));
            if dialect.has_commas && !is_written {
                continue;
            }
            let weight = weight(&lines, dialect, &run);
            if found.as_ref().is_none_or(|(_, _, best)| weight > *best) {
                found = Some((dialect, run, weight));
            }
        }
        let (dialect, mut run, _) = found?;
        let cells = |line: &Line<'_>| -> Vec<String> {
            let bytes = comment(line.bytes).unwrap_or(line.bytes);
            dialect.split(bytes).iter().map(|cell| decode::text(cell)).collect()
        };
        let kinds_of = |line: &Line<'_>| -> Vec<Kind> {
            dialect.split(line.bytes).iter().map(|cell| dialect.kind(cell)).collect()
        };
        let mut rows: Vec<Vec<Kind>> = lines[run.first..run.end].iter().map(kinds_of).collect();
        run.first += keys(&rows);
        rows.drain(..keys(&rows));
        let column = |at: usize| {
            let mut seen =
                rows.iter().filter_map(|row| row.get(at)).filter(|kind| **kind != Kind::Empty);
            seen.next().copied().unwrap_or(Kind::Empty)
        };
        let kinds: Vec<Kind> = (0..run.cells).map(column).collect();
        // A row with a word among its numbers, or a remark behind them, belongs to the table: the reader says what is
        // wrong with it.
        let used: Vec<usize> = (0..run.cells).filter(|at| kinds[*at].is_value()).collect();
        while let Some(before) = run.first.checked_sub(1) {
            let above = &lines[before];
            let row = kinds_of(above);
            let good =
                used.iter().filter(|at| row.get(**at).is_some_and(|kind| kind.is_value())).count();
            // Keys of a preamble, as in `"BlockSize",1000,1000`, where rows have no such cell.
            let is_keyed = kinds.first() == Some(&Kind::Empty) && is_key(&row);
            if is_keyed
                || comment(above.bytes).is_some()
                || 2 * good <= used.len()
                || row.len() < used.len()
            {
                break;
            }
            run.first = before;
        }
        let some = run.first..run.end.min(run.first + MOST_SAMPLES);
        let some: Vec<Vec<String>> = lines[some].iter().map(cells).collect();
        let sample = |at: usize| {
            let mut cells = some.iter().filter_map(|row| row.get(at));
            cells.find(|cell| !cell.is_empty()).cloned().unwrap_or_default()
        };
        let first = &lines[run.first];
        let mut layout = Self {
            dialect,
            start: first.start,
            line: first.number,
            header_line: first.number,
            header: Vec::new(),
            has_names: true,
            samples: (0..run.cells).map(sample).collect(),
            is_counter: counts(&lines[run.first..run.end], dialect),
            grows: grows(&lines[run.first..run.end], dialect, 0),
            kinds,
            preamble: Preamble::default(),
            notes: dialect.describe().into_iter().collect(),
        };
        layout.head(&lines, &run, &cells);
        Some(layout)
    }

    /// Names, units and what the preamble says.
    fn head(&mut self, lines: &[Line<'_>], run: &Run, cells: &dyn Fn(&Line<'_>) -> Vec<String>) {
        let used: Vec<usize> = (0..run.cells).filter(|at| self.kinds[*at] != Kind::Empty).collect();
        let is_mark = |line: &Line<'_>| {
            let text = decode::text(comment(line.bytes).unwrap_or(line.bytes));
            if comment(line.bytes).is_some() && (text.contains('=') || text.contains(": ")) {
                return true;
            }
            let text = text.trim_matches(|c: char| !c.is_alphanumeric());
            text.is_empty()
                || text.eq_ignore_ascii_case("end_header")
                || text.eq_ignore_ascii_case("end_of_header")
        };
        let above: Vec<(&Line<'_>, Vec<String>)> = lines[..run.first]
            .iter()
            .rev()
            .take(MOST_ABOVE)
            .filter(|line| !is_mark(line))
            .map(|line| (line, cells(line)))
            .collect();
        let values = |row: &[String]| -> usize {
            used.iter()
                .filter(|at| row.get(**at).is_some_and(|cell| cell.parse::<f64>().is_ok()))
                .count()
        };
        // The cells that a row has for the columns in use, without the empty ones at its end.
        let wide =
            |row: &[String]| row.iter().rposition(|cell| !cell.is_empty()).map_or(0, |at| at + 1);
        let last = used.last().map_or(0, |at| at + 1);
        let is_head =
            |row: &[String]| wide(row) > 0 && row.len() >= used.len() && values(row) < used.len();
        let is_units = |row: &[String]| {
            let used = used.iter().filter_map(|at| row.get(*at)).filter(|cell| !cell.is_empty());
            let (units, all) = used.fold((0, 0), |(units, all), cell| {
                (units + usize::from(ColumnUnit::parse(cell).is_ok() || cell == "S"), all + 1)
            });
            let has_time = row.iter().any(|cell| {
                time_column::of_name(cell).is_some() && ColumnUnit::parse(cell).is_err()
            });
            all > 0 && 10 * units >= 6 * all && !has_time
        };
        let texts = |row: &[String]| {
            is_head(row)
                && wide(row) <= run.cells.max(last) + 1
                && values(row) <= used.len() / 2 + 1
        };
        // Where the first cell of a row is empty, names may stand behind a key.
        let mut all = Preamble::default();
        lines[..run.first].iter().for_each(|line| all.line(line.bytes, self.dialect));
        let is_keyed = self.kinds.first() == Some(&Kind::Empty) && !all.names.is_empty();
        let (mut names, mut units) = (None, None);
        match above.as_slice() {
            _ if is_keyed => {}
            [(first, units_row), (second, names_row), ..]
                if is_units(units_row) && texts(names_row) && !is_units(names_row) =>
            {
                (names, units) = (Some((*second, names_row)), Some((*first, units_row)));
            }
            [(_, _), (second, units_row), (third, names_row), ..]
                if is_units(units_row)
                    && texts(names_row)
                    && units_row.len() == names_row.len()
                    && wide(units_row) >= last =>
            {
                (names, units) = (Some((*third, names_row)), Some((*second, units_row)));
            }
            [(first, names_row), ..] if is_head(names_row) => names = Some((*first, names_row)),
            _ => {}
        }
        let head_lines = [names, units].into_iter().flatten().map(|(line, _)| line.number).min();
        let until = head_lines.unwrap_or(self.line);
        for line in lines.iter().filter(|line| line.number < until) {
            self.preamble.line(line.bytes, self.dialect);
        }
        if let (Some((_, names)), Some((_, units))) = (names, units) {
            self.preamble.columns(names, units, self.dialect);
        }
        let (mut row, mut unit_row) = (Vec::new(), Vec::new());
        if let Some((line, names)) = names {
            self.header_line = line.number;
            row.clone_from(names);
            unit_row = match units {
                Some((_, units)) => units.clone(),
                None => self.units_of_keys(names),
            };
        } else if let Some(built) = self.keyed(lines, run) {
            (row, unit_row) = built;
        } else {
            self.has_names = false;
        }
        self.note_places(
            head_lines,
            names.map(|(line, _)| line.number),
            units.map(|(line, _)| line.number),
        );
        self.columns(row, &unit_row);
    }

    /// Units that stand behind a key above names without units, one for each signal, as in `Vertical Units,V,um`.
    fn units_of_keys(&mut self, names: &[String]) -> Vec<String> {
        let is_signal = |at: &usize| {
            let name = names.get(*at).map_or("", String::as_str);
            let is_time = time_column::of_name(name).is_some();
            self.kinds[*at] == Kind::Number && !is_time
        };
        let signals: Vec<usize> = (0..self.kinds.len()).filter(is_signal).collect();
        let units = self.preamble.units.iter().filter(|unit| !unit.is_empty());
        let units: Vec<&String> = units.filter(|unit| ColumnUnit::parse(unit).is_ok()).collect();
        let has_own = |at: &usize| {
            let name = names.get(*at).map_or("", String::as_str);
            split(name).1.is_some() || split_unit(name).is_some()
        };
        if units.len() != signals.len() || signals.iter().any(has_own) {
            return Vec::new();
        }
        let mut row = vec![String::new(); self.kinds.len()];
        for (at, unit) in signals.iter().zip(&units) {
            row[*at].clone_from(unit);
        }
        if !units.is_empty() {
            self.notes.push("units are those of the preamble".into());
        }
        row
    }

    /// Names that stand behind a key above the table or beside its first rows.
    fn keyed(&mut self, lines: &[Line<'_>], run: &Run) -> Option<(Vec<String>, Vec<String>)> {
        let numbers: Vec<usize> = (0..run.cells).filter(|at| self.kinds[*at].is_value()).collect();
        let first = *numbers.first()?;
        if self.kinds.contains(&Kind::Text) {
            for line in &lines[run.first..run.end.min(run.first + 100)] {
                let cells = self.dialect.split(line.bytes);
                let keys = cells[..first.min(cells.len())].join(&self.dialect.separator);
                self.preamble.line(&keys, self.dialect);
            }
        }
        let fill = |list: &[String], shift: usize| {
            let mut row = vec![String::new(); run.cells];
            for (at, text) in numbers[shift..].iter().zip(list) {
                row[*at].clone_from(text);
            }
            row
        };
        let names: Vec<String> = self
            .preamble
            .names
            .iter()
            .filter(|name| !name.is_empty())
            .take(numbers.len())
            .cloned()
            .collect();
        let units: Vec<String> = self.preamble.units.iter().take(numbers.len()).cloned().collect();
        let shift = numbers.len().checked_sub(names.len())?;
        match (names.len(), shift) {
            (0, _) => return None,
            (_, 0) => {}
            (1, 1) if self.kinds.contains(&Kind::Text) && names[0].parse::<f64>().is_ok() => {
                return None;
            }
            (_, 1) if grows(&lines[run.first..run.end], self.dialect, numbers[0]) => {
                let mut row = fill(&names, 1);
                row[numbers[0]] = "time".into();
                self.notes
                    .push(format!("column {} is taken as the time: it grows", numbers[0] + 1));
                return Some((row, fill(&units, 1)));
            }
            _ => return None,
        }
        Some((fill(&names, 0), fill(&units, 0)))
    }

    /// Notes where names, units and the preamble stand.
    fn note_places(&mut self, head: Option<usize>, names: Option<usize>, units: Option<usize>) {
        let above = head.unwrap_or(self.line);
        if above > 1 {
            self.notes.push(match above - 1 {
                1 => "line 1 is a preamble".to_owned(),
                lines => format!("lines 1 to {lines} are a preamble"),
            });
        }
        match (names, units) {
            (Some(names), Some(units)) => {
                self.notes.push(format!("names are in line {names}, units in line {units}"));
            }
            (Some(names), None) if names > 1 => {
                self.notes.push(format!("names are in line {names}"))
            }
            _ => {}
        }
    }

    /// Header cells: a name with its unit for each cell of a row.
    fn columns(&mut self, mut row: Vec<String>, units: &[String]) {
        let cells = self.kinds.len();
        // Names without a column: of remarks and of keys whose values stand in the row of units.
        while row.len() > cells && row.last().is_some_and(|name| name.is_empty() || is_remark(name))
        {
            row.pop();
        }
        for at in 0..cells.max(row.len()) {
            let name = row.get(at).map_or("", |name| name.trim());
            let own = units.get(at).map_or("", |unit| unit.trim());
            let own = own.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).unwrap_or(own);
            let own = own.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(own);
            // The row of units may say what it is: `unit,V,um`.
            let is_title = at == 0
                && ["unit", "units", "einheit", "einheiten"]
                    .iter()
                    .any(|word| own.trim_end_matches(':').eq_ignore_ascii_case(word));
            let own = if is_title { "" } else { own };
            let is_key = !units.is_empty() && own.parse::<f64>().is_ok();
            let is_used = self.kinds.get(at).is_none_or(|kind| *kind != Kind::Empty);
            self.header.push(match (is_used, own) {
                (false, _) if is_key || is_remark(name) => String::new(),
                (_, "") => name.to_owned(),
                (true, unit) if !is_key => format!("{name} [{unit}]"),
                _ => name.to_owned(),
            });
        }
    }

    /// Whether a column of texts is one of words beside others of numbers; a decimal comma or a gap is an error.
    pub(in super::super) fn may_leave_out(&self, at: usize) -> bool {
        let sample = self.samples.get(at).map_or("", String::as_str);
        let numbers = self.kinds.iter().filter(|kind| **kind == Kind::Number).count();
        let has_instants = self.kinds.contains(&Kind::Instant);
        let is_word =
            cell::parse(sample.as_bytes()).is_err_and(|(rule, _)| rule == cell::NO_NUMBER);
        is_word && (numbers > 1 || numbers == 1 && has_instants)
    }

    /// Whether the first cells, of which there are several, may be times: dates, or numbers that grow.
    pub(super) fn may_begin_with_times(&self) -> bool {
        self.kinds.first() == Some(&Kind::Instant) || self.grows
    }

    /// Whether the cell of a column is a date without a time of day.
    pub(in super::super) fn is_day(&self, at: usize) -> bool {
        let sample = self.samples.get(at).and_then(|sample| Instant::parse(sample));
        matches!(sample, Some(Instant::Date(_)))
    }

    /// Whether the cell of a column is a time of day without a date.
    pub(in super::super) fn is_clock(&self, at: usize) -> bool {
        let sample = self.samples.get(at).and_then(|sample| Instant::parse(sample));
        matches!(sample, Some(Instant::Clock(_)))
    }
}

fn is_remark(name: &str) -> bool {
    ["comment", "comments", "remark", "notes"].iter().any(|word| name.eq_ignore_ascii_case(word))
}

/// Whether the numbers of a column grow from row to row.
fn grows(rows: &[Line<'_>], dialect: Dialect, at: usize) -> bool {
    let values = rows.iter().map(|line| {
        let cells = dialect.split(line.bytes);
        let cell = cells.get(at).map(|cell| decode::text(cell)).unwrap_or_default();
        cell.replace(',', ".").parse::<f64>().unwrap_or(f64::NAN)
    });
    let values: Vec<f64> = values.collect();
    values.len() > 1 && values.windows(2).all(|pair| pair[0] < pair[1])
}

/// Whether a row is a key with its values beside it.
fn is_key(row: &[Kind]) -> bool {
    matches!(row, [Kind::Text, value, ..] if value.is_value())
}

/// The first rows of a run that are no rows of the table: keys whose values stand in the table's own columns, while the
/// rows below have nothing where the key stands. Keys beside the rows have their values in columns of their own.
fn keys(rows: &[Vec<Kind>]) -> usize {
    let Some(last) = rows.last() else { return 0 };
    let is_keyed = |row: &Vec<Kind>| is_key(row) && last.first() == Some(&Kind::Empty);
    let count = rows.iter().take_while(|row| is_keyed(row)).count();
    let are_below = rows[..count].iter().all(|row| {
        row.iter().zip(last).all(|(above, below)| !above.is_value() || below.is_value())
    });
    if are_below { count } else { 0 }
}

/// Whether the first cells are whole numbers that follow each other.
fn counts(rows: &[Line<'_>], dialect: Dialect) -> bool {
    let first = |line: &Line<'_>| {
        let cells = dialect.split(line.bytes);
        cells.first().and_then(|cell| std::str::from_utf8(cell).ok()?.parse::<i64>().ok())
    };
    let numbers: Vec<Option<i64>> = rows.iter().map(first).collect();
    numbers.len() > 1
        && numbers.windows(2).all(|pair| match (pair[0], pair[1]) {
            (Some(a), Some(b)) => a.checked_add(1) == Some(b),
            _ => false,
        })
}

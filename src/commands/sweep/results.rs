//! What came out of a sweep, in figures.

use std::io::{self, Write};
use std::path::PathBuf;

use cli::Answer;
use report::{Section, Table as Rows};
use serde::Serialize;
use sweep::{Cell, ColumnKind, Table};

/// What was run.
#[derive(Serialize)]
pub(super) struct Swept {
    table: PathBuf,
    /// Runs of the whole sweep, the first of this table, behind its last.
    runs: u64,
    first: u64,
    end: u64,
    /// Runs of this call, threads and seconds that it took; the others were there.
    fresh: usize,
    threads: usize,
    seconds: f64,
    runs_per_second: Option<f64>,
    pub(super) failed: usize,
    first_failure: Option<Failure>,
    figures: Vec<Figure>,
    words: Vec<Words>,
    notes: Vec<String>,
}

/// A run that failed.
#[derive(Serialize)]
struct Failure {
    run: u64,
    error: String,
}

/// How a column of numbers is distributed.
#[derive(Serialize)]
struct Figure {
    name: String,
    unit: Option<String>,
    median: f64,
    percent_5: f64,
    percent_95: f64,
    max: f64,
    /// The run that has the greatest.
    max_run: u64,
}

/// How often each text of a column comes.
#[derive(Serialize)]
struct Words {
    name: String,
    counts: Vec<(String, usize)>,
}

/// Different texts of a column beyond which they are not counted.
const MOST_WORDS: usize = 12;
/// Characters beyond which a text is no word.
const LONGEST_WORD: usize = 60;

impl Swept {
    /// The figures of a table.
    pub(super) fn of(table: &Table, path: PathBuf, notes: Vec<String>) -> Self {
        let about = &table.about;
        let last = about.columns.len().saturating_sub(1);
        let text = |cell: Option<&Cell>| match cell {
            Some(Cell::Text(text)) => Some(text.clone()),
            _ => None,
        };
        let failures = || {
            table.rows.iter().filter_map(|row| {
                let error = text(row.cells.get(last))?;
                Some(Failure { run: row.run, error })
            })
        };
        let (mut figures, mut words) = (Vec::new(), Vec::new());
        for (at, column) in about.columns.iter().enumerate().take(last) {
            match column.kind {
                ColumnKind::Real | ColumnKind::Integer => figures.extend(figure(table, at)),
                ColumnKind::Text | ColumnKind::Truth => words.extend(counted(table, at)),
            }
        }
        Swept {
            table: path,
            runs: about.runs,
            first: about.first,
            end: about.end,
            fresh: 0,
            threads: 0,
            seconds: 0.0,
            runs_per_second: None,
            failed: failures().count(),
            first_failure: failures().next(),
            figures,
            words,
            notes,
        }
    }

    /// The answer in one sentence, on this figure.
    pub(super) fn sentence(&self, figure: Option<&str>) -> String {
        let count = self.end - self.first;
        let failed = match self.failed {
            0 => String::new(),
            failed => format!(", of which {failed} failed"),
        };
        let found = self.figures.iter().find(|known| Some(known.name.as_str()) == figure);
        let described = found.map_or_else(String::new, |figure| {
            let unit = figure.unit.as_deref().unwrap_or_default();
            format!(
                ": {} has a median of {} {unit}, stays below {} {unit} in 95 % of them, and is {} {unit} \
                 at most, in run {}",
                figure.name,
                short(figure.median),
                short(figure.percent_95),
                short(figure.max),
                figure.max_run
            )
        });
        format!("{count} runs{failed}{described}.")
    }

    /// The figures as a section of a page.
    pub(super) fn section(&self) -> Section {
        let headings = ["figure", "unit", "5 %", "median", "95 %", "greatest", "in run"];
        let mut rows = Rows::new("Varied values, and figures of the runs", headings);
        for figure in &self.figures {
            let mut row: Vec<report::Value> = vec![figure.name.clone().into()];
            row.push(figure.unit.clone().unwrap_or_default().into());
            let numbers = [figure.percent_5, figure.median, figure.percent_95, figure.max];
            row.extend(numbers.map(|number| report::Value::from(short(number))));
            row.push(figure.max_run.into());
            rows = rows.row(row);
        }
        let mut section = Section::new("Figures").table(rows);
        if let Some(Failure { run, error }) = &self.first_failure {
            let text = format!("{} runs failed; the first is run {run}: {error}", self.failed);
            section = section.paragraph(text);
        }
        for words in &self.words {
            let counts: Vec<String> =
                words.counts.iter().map(|(word, count)| format!("{word} {count}")).collect();
            section = section.paragraph(format!("{}: {}.", words.name, counts.join(", ")));
        }
        section
    }

    /// Notes how long the runs of this call took.
    pub(super) fn took(&mut self, fresh: usize, threads: usize, seconds: f64) {
        (self.fresh, self.threads, self.seconds) = (fresh, threads, seconds);
        self.runs_per_second = (seconds > 0.0 && fresh > 0).then(|| fresh as f64 / seconds);
    }
}

fn figure(table: &Table, at: usize) -> Option<Figure> {
    let column = table.about.columns.get(at)?;
    let cells = table.rows.iter().filter_map(|row| Some((row.cells.get(at)?.number()?, row.run)));
    let mut values: Vec<(f64, u64)> = cells.filter(|(value, _)| value.is_finite()).collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let &(max, max_run) = values.last()?;
    let quantile = |part: f64| values[(part * (values.len() - 1) as f64).round() as usize].0;
    Some(Figure {
        name: column.name.clone(),
        unit: column.unit.clone(),
        median: quantile(0.5),
        percent_5: quantile(0.05),
        percent_95: quantile(0.95),
        max,
        max_run,
    })
}

fn counted(table: &Table, at: usize) -> Option<Words> {
    let mut counts = std::collections::BTreeMap::new();
    for row in &table.rows {
        let word = match row.cells.get(at) {
            Some(Cell::Text(text)) => text.clone(),
            Some(Cell::Truth(truth)) => truth.to_string(),
            _ => continue,
        };
        *counts.entry(word).or_insert(0) += 1;
    }
    let is_short = counts.keys().all(|word| word.chars().count() <= LONGEST_WORD);
    let few = !counts.is_empty() && counts.len() <= MOST_WORDS && is_short;
    let name = table.about.columns.get(at)?.name.clone();
    few.then(|| Words { name, counts: counts.into_iter().collect() })
}

impl Answer for Swept {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for note in &self.notes {
            writeln!(out, "note: {note}")?;
        }
        let count = self.end - self.first;
        match self.end - self.first == self.runs {
            true => write!(out, "{count} runs")?,
            false => write!(
                out,
                "runs {} to {} of {}",
                self.first,
                self.end.saturating_sub(1),
                self.runs
            )?,
        }
        if let Some(rate) = self.runs_per_second {
            write!(
                out,
                "; {} now, on {} in {:.1} s, {rate:.1} runs/s",
                self.fresh,
                data::counted(self.threads, "thread"),
                self.seconds
            )?;
        }
        writeln!(out)?;
        if let Some(Failure { run, error }) = &self.first_failure {
            writeln!(out, "{} failed, the first is run {run}: {error}", self.failed)?;
        }
        if !self.figures.is_empty() {
            let head = ["5 %", "median", "95 %", "greatest"];
            let [a, b, c, d] = head;
            writeln!(out, "  {:40} {a:>11} {b:>11} {c:>11} {d:>11}  in run", "")?;
        }
        for figure in &self.figures {
            let unit = figure.unit.as_deref().map(|unit| format!(" [{unit}]")).unwrap_or_default();
            writeln!(
                out,
                "  {:40} {:>11} {:>11} {:>11} {:>11}  {}",
                format!("{}{unit}", figure.name),
                short(figure.percent_5),
                short(figure.median),
                short(figure.percent_95),
                short(figure.max),
                figure.max_run
            )?;
        }
        for words in &self.words {
            let counts: Vec<String> =
                words.counts.iter().map(|(word, count)| format!("{word} {count}")).collect();
            writeln!(out, "  {}: {}", words.name, counts.join(", "))?;
        }
        writeln!(out, "{}: written", self.table.display())
    }

    fn exit_code(&self) -> u8 {
        u8::from(self.failed > 0)
    }
}

/// Four significant digits.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e5).contains(&size) => {
            let digits = (3 - size.log10().floor() as i32).max(0) as usize;
            format!("{value:.digits$}")
        }
        _ => format!("{value:.3e}"),
    }
}

//! Descriptions of logs in files beside them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{GIVE_A_RATE, RATES};
use crate::nearest::did_you_mean;
use crate::toml_text::{self, Lines, shown};
use crate::{Problem, Problems};

/// A `dataset.toml`, or the companion of one log.
#[derive(Debug, Default)]
pub(super) struct Dataset {
    pub(super) file: String,
    /// Whether it is the companion of one log.
    pub(super) is_sidecar: bool,
    /// Sample rate in Hz.
    pub(super) rate: Option<f64>,
    pub(super) time_column: Option<String>,
    pub(super) time_unit: Option<String>,
    pub(super) columns: BTreeMap<String, About>,
}

/// The description of a column.
#[derive(Debug, Default)]
pub(super) struct About {
    pub(super) line: usize,
    pub(super) unit: Option<String>,
    pub(super) description: String,
}

/// The companion of a log: `run.dataset.toml` for `run.csv`.
#[must_use]
pub fn sidecar_of(path: &Path) -> PathBuf {
    path.with_extension("dataset.toml")
}

/// The companion of the log and the dataset of its folder, those that exist.
///
/// # Errors
/// One is broken, or is longer than `longest` bytes.
pub(super) fn beside(path: &Path, longest: u64) -> Result<Vec<Dataset>, Problems> {
    let mut found = Vec::new();
    for (path, is_sidecar) in
        [(sidecar_of(path), true), (path.with_file_name("dataset.toml"), false)]
    {
        let text = match files::read_text_within(&path, longest) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
            Err(error) if error.kind() == std::io::ErrorKind::FileTooLarge => {
                let rule = format!("cannot be read: {error}, which is more than describes a log");
                let way_out = "describe fewer columns, or allow more with --log-memory MB";
                return Err(Problem::new(path.display().to_string(), rule, way_out).into());
            }
            Err(error) => {
                let rule = format!("cannot be read: {error}");
                let file = path.display().to_string();
                return Err(Problem::new(file, rule, "correct it or move it away").into());
            }
        };
        found.push(parse(&text, &path.display().to_string(), is_sidecar)?);
    }
    Ok(found)
}

pub(super) fn parse(text: &str, file: &str, is_sidecar: bool) -> Result<Dataset, Problems> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let document = toml_text::parse(text, file)?;
    let dataset = Dataset { file: file.into(), is_sidecar, ..Dataset::default() };
    let mut reader = Reader { lines: Lines::new(text), dataset, problems: Vec::new() };
    reader.document(document.get_ref());
    if reader.problems.is_empty() {
        Ok(reader.dataset)
    } else {
        Err(Problems::new(reader.problems))
    }
}

struct Reader {
    lines: Lines,
    dataset: Dataset,
    problems: Vec<Problem>,
}

type Key<'a, 'i> = &'a Spanned<std::borrow::Cow<'i, str>>;

impl Reader {
    fn report(&mut self, key: Key<'_, '_>, value: &str, rule: &str, way_out: impl Into<String>) {
        let line = self.lines.at(key.span().start);
        let problem = Problem::new(&self.dataset.file, rule, way_out);
        self.problems.push(problem.line(line).at(key.get_ref().as_ref()).value(value));
    }

    fn unknown(&mut self, key: Key<'_, '_>, known: &[&str]) {
        let near = did_you_mean(key.get_ref(), known.iter().copied());
        self.report(key, "", "is no key here", format!("{near}known are {}", known.join(", ")));
    }

    fn document(&mut self, table: &DeTable<'_>) {
        for (key, value) in table.iter() {
            let value = value.get_ref();
            match key.get_ref().as_ref() {
                "rate" => self.rate(key, value),
                "time" => {
                    for (key, value) in self.entries(key, value) {
                        match key.get_ref().as_ref() {
                            "column" => self.dataset.time_column = self.text(key, value),
                            "unit" => self.dataset.time_unit = self.text(key, value),
                            _ => self.unknown(key, &["column", "unit"]),
                        }
                    }
                }
                "columns" => {
                    for (key, value) in self.entries(key, value) {
                        let about = self.about(key, value);
                        self.dataset.columns.insert(key.get_ref().to_string(), about);
                    }
                }
                _ => self.unknown(key, &["rate", "time", "columns"]),
            }
        }
    }

    fn rate(&mut self, key: Key<'_, '_>, value: &DeValue<'_>) {
        match toml_text::number(value) {
            Some(rate) if RATES.contains(&rate) => self.dataset.rate = Some(rate),
            _ => self.report(key, &shown(value), "is no sample rate", GIVE_A_RATE),
        }
    }

    fn about(&mut self, key: Key<'_, '_>, value: &DeValue<'_>) -> About {
        let mut about = About { line: self.lines.at(key.span().start), ..About::default() };
        for (key, value) in self.entries(key, value) {
            match key.get_ref().as_ref() {
                "unit" => about.unit = self.text(key, value),
                "description" => about.description = self.text(key, value).unwrap_or_default(),
                _ => self.unknown(key, &["unit", "description"]),
            }
        }
        about
    }

    /// The entries of a value that must be a table.
    fn entries<'a, 'i>(
        &mut self,
        key: Key<'_, '_>,
        value: &'a DeValue<'i>,
    ) -> Vec<(Key<'a, 'i>, &'a DeValue<'i>)> {
        let Some(table) = value.as_table() else {
            let way_out = "write it as in y = { unit = \"um\" }";
            self.report(key, &shown(value), "must be a table", way_out);
            return Vec::new();
        };
        table.iter().map(|(key, value)| (key, value.get_ref())).collect()
    }

    fn text(&mut self, key: Key<'_, '_>, value: &DeValue<'_>) -> Option<String> {
        if value.as_str().is_none() {
            self.report(key, &shown(value), "must be a text", "put it in quotation marks");
        }
        value.as_str().map(str::to_string)
    }
}

//! What is wrong with a file, in full: place, value, rule and the way out.

use std::fmt;

/// One thing that is wrong.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problem {
    /// File, as it was given, or another name of the text's origin.
    pub file: String,
    /// Line, from 1; `None` where the problem is the whole file's.
    pub line: Option<usize>,
    /// Row of data, from 1, in a file that has no lines.
    pub row: Option<usize>,
    /// Key or column, as in `axis[1].hysteresis.w[3]`; empty where there is none.
    pub place: String,
    /// The value as it was given; empty where there is none.
    pub value: String,
    /// The rule that is broken.
    pub rule: String,
    /// What to do about it.
    pub way_out: String,
}

impl Problem {
    /// A problem of `file`: the rule that is broken and the way out.
    #[must_use]
    pub fn new(
        file: impl Into<String>,
        rule: impl Into<String>,
        way_out: impl Into<String>,
    ) -> Self {
        Self { file: file.into(), rule: rule.into(), way_out: way_out.into(), ..Self::default() }
    }
    /// The file `path` cannot be written.
    pub(crate) fn unwritable(path: &std::path::Path, error: &std::io::Error) -> Self {
        // What our own rules refuse says itself what to do.
        let is_of_system = error.raw_os_error().is_some();
        let way_out = if is_of_system { "check the folder and its permissions" } else { "" };
        Self::new(path.display().to_string(), format!("cannot be written: {error}"), way_out)
    }
    /// On this line, from 1.
    #[must_use]
    pub fn line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }
    /// In this row of data, from 1.
    #[must_use]
    pub fn row(mut self, row: usize) -> Self {
        self.row = Some(row);
        self
    }
    /// At this key or in this column.
    #[must_use]
    pub fn at(mut self, place: impl Into<String>) -> Self {
        self.place = place.into();
        self
    }
    /// With this value; a long one is shortened.
    #[must_use]
    pub fn value(mut self, value: impl fmt::Display) -> Self {
        self.value = shortened(&value.to_string());
        self
    }
}

/// At most 60 characters of `text`, control characters shown as escapes.
fn shortened(text: &str) -> String {
    const MOST: usize = 60;
    let mut short: String = text.chars().take(MOST).collect();
    if short.chars().any(char::is_control) {
        let shown = |c: char| if c.is_control() { c.escape_debug().to_string() } else { c.into() };
        short = short.chars().map(shown).collect();
    }
    if text.chars().nth(MOST).is_some() {
        short.push('…');
    }
    short
}

impl fmt::Display for Problem {
    /// `plant.toml:12: axis[1].hysteresis.w[3] = -1: must be at least 0 um/V; give …`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        f.write_str(": ")?;
        if let Some(row) = self.row {
            write!(f, "row {row}: ")?;
        }
        match (self.place.is_empty(), self.value.is_empty()) {
            (true, true) => {}
            (true, false) => write!(f, "{}: ", self.value)?,
            (false, true) => write!(f, "{}: ", self.place)?,
            (false, false) => write!(f, "{} = {}: ", self.place, self.value)?,
        }
        f.write_str(&self.rule)?;
        if !self.way_out.is_empty() {
            write!(f, "; {}", self.way_out)?;
        }
        Ok(())
    }
}

/// Everything that is wrong with a file, in the order of its lines.
#[derive(Clone, Debug, Default, PartialEq, Eq, thiserror::Error)]
pub struct Problems {
    list: Vec<Problem>,
    omitted: usize,
}

impl Problems {
    /// These problems, sorted by line or row; those without come last.
    #[must_use]
    pub fn new(mut list: Vec<Problem>) -> Self {
        list.sort_by_key(|problem| problem.line.or(problem.row).unwrap_or(usize::MAX));
        Self { list, omitted: 0 }
    }
    /// Says that `omitted` further problems were found and not kept.
    #[must_use]
    pub fn with_omitted(mut self, omitted: usize) -> Self {
        self.omitted = omitted;
        self
    }
    /// The problems.
    #[must_use]
    pub fn as_slice(&self) -> &[Problem] {
        &self.list
    }
    /// How many more there are.
    #[must_use]
    pub fn omitted(&self) -> usize {
        self.omitted
    }
}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Self {
        Self::new(vec![problem])
    }
}

impl IntoIterator for Problems {
    type Item = Problem;
    type IntoIter = std::vec::IntoIter<Problem>;
    fn into_iter(self) -> Self::IntoIter {
        self.list.into_iter()
    }
}

impl fmt::Display for Problems {
    /// One line per problem.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.list.iter().enumerate() {
            if index > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{problem}")?;
        }
        if self.omitted > 0 {
            write!(f, "\n… and {} more", self.omitted)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shows_file_line_place_value_rule_and_way_out() {
        let problem = Problem::new("plant.toml", "must be at least 0 um/V", "give a larger weight")
            .line(12)
            .at("axis[1].hysteresis.w[3]")
            .value(-1);
        assert_eq!(
            problem.to_string(),
            "plant.toml:12: axis[1].hysteresis.w[3] = -1: must be at least 0 um/V; give a larger weight"
        );
    }

    #[test]
    fn shortens_long_and_escapes_unprintable_values() {
        assert_eq!(shortened("a\u{0}b"), "a\\0b");
        assert_eq!(shortened(&"x".repeat(100)).chars().count(), 61);
    }

    #[test]
    fn sorts_by_line_and_counts_what_was_left_out() {
        let problems = Problems::new(vec![
            Problem::new("f", "last", ""),
            Problem::new("f", "second", "").line(9),
            Problem::new("f", "first", "").line(2),
        ])
        .with_omitted(4);
        assert_eq!(problems.to_string(), "f:2: first\nf:9: second\nf: last\n… and 4 more");
    }
}

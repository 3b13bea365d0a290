//! Line numbers of a text, and TOML errors that name them.

use crate::{Problem, Problems};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The byte at which each line of a text starts.
pub(crate) struct Lines(Vec<usize>);

impl Lines {
    pub(crate) fn new(text: &str) -> Self {
        let behind = text.match_indices('\n').map(|(at, _)| at + 1);
        Self(std::iter::once(0).chain(behind).collect())
    }

    /// The line, from 1, that holds this byte.
    pub(crate) fn at(&self, byte: usize) -> usize {
        self.0.partition_point(|start| *start <= byte)
    }
}

/// Places that are no TOML and are reported one by one.
const MOST_REPORTED: usize = 3;

/// A text as TOML.
///
/// # Errors
/// The places that are no TOML: the first [`MOST_REPORTED`], and how many more there are.
pub(crate) fn parse<'i>(text: &'i str, file: &str) -> Result<Spanned<DeTable<'i>>, Problems> {
    let (document, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return Ok(document);
    }
    let lines = Lines::new(text);
    let report = |error: &toml::de::Error| {
        let rule = format!("is not valid TOML: {}", error.message());
        let mut problem = Problem::new(file, rule, "correct this line");
        problem.line = error.span().map(|span| lines.at(span.start));
        problem
    };
    let mut problems: Vec<Problem> = errors.iter().take(MOST_REPORTED).map(report).collect();
    if errors.len() > MOST_REPORTED {
        let rule = format!("is not valid TOML in {} further places", errors.len() - MOST_REPORTED);
        problems.push(Problem::new(file, rule, "is this the file that you meant?"));
    }
    Err(Problems::new(problems))
}

/// A number, whether it is written with a point or without.
pub(crate) fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(n) => i128::from_str_radix(n.as_str(), n.radix()).ok().map(|n| n as f64),
        DeValue::Float(x) => x.as_str().parse().ok(),
        _ => None,
    }
}

/// A value as a message shows it.
pub(crate) fn shown(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("{text:?}"),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(truth) => truth.to_string(),
        DeValue::Datetime(date) => date.to_string(),
        DeValue::Array(_) => "[…]".into(),
        DeValue::Table(_) => "{…}".into(),
    }
}

/// A basic TOML string: one line, whatever the text holds.
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len() + 2);
    quoted.push('"');
    for c in text.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            '\n' => quoted.push_str("\\n"),
            '\t' => quoted.push_str("\\t"),
            '\r' => quoted.push_str("\\r"),
            c if c.is_control() => quoted.push_str(&format!("\\u{:04X}", u32::from(c))),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// A TOML key: bare where it can be.
pub(crate) fn key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(bare) { name.into() } else { quoted(name) }
}

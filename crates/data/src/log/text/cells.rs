//! One line of a text as cells.

use std::borrow::Cow;

use super::instant::Instant;
use crate::log::cell;

/// How the cells of a row are separated and how numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dialect {
    /// The byte between cells; a blank stands for any number of blanks and tabs.
    pub(super) separator: u8,
    /// Whether numbers have decimal commas.
    pub(super) has_commas: bool,
}

impl Dialect {
    pub(super) const PLAIN: Self = Self { separator: b',', has_commas: false };
    /// Those that are tried; of equally good ones the first is taken.
    pub(super) const ALL: [Self; 8] = [
        Self::PLAIN,
        Self { separator: b';', has_commas: false },
        Self { separator: b';', has_commas: true },
        Self { separator: b'\t', has_commas: false },
        Self { separator: b'\t', has_commas: true },
        Self { separator: b' ', has_commas: false },
        Self { separator: b' ', has_commas: true },
        Self { separator: b'|', has_commas: false },
    ];

    /// What is special about it, for notes.
    pub(super) fn describe(self) -> Option<String> {
        let separator = match self.separator {
            b',' => return None,
            b';' => "semicolons",
            b'\t' => "tabs",
            b' ' => "blanks",
            _ => "bars",
        };
        let commas = if self.has_commas { ", numbers have decimal commas" } else { "" };
        Some(format!("cells are separated by {separator}{commas}"))
    }

    /// The cells of a line, without blanks at their ends and without quotation marks.
    pub(super) fn split<'a>(self, line: &'a [u8]) -> Vec<Cow<'a, [u8]>> {
        let line = line.trim_ascii_end();
        if self.separator == b' ' {
            return blanks(line).map(Cow::Borrowed).collect();
        }
        let mut cells = Vec::new();
        let (mut start, mut is_quoted) = (0, false);
        for (at, byte) in line.iter().enumerate() {
            match byte {
                b'"' => is_quoted = !is_quoted,
                byte if *byte == self.separator && !is_quoted => {
                    cells.push(unquoted(&line[start..at]));
                    start = at + 1;
                }
                _ => {}
            }
        }
        cells.push(unquoted(&line[start..]));
        cells
    }

    /// What a cell holds.
    pub(super) fn kind(self, bytes: &[u8]) -> Kind {
        let bytes = bytes.trim_ascii();
        if bytes.is_empty() {
            return Kind::Empty;
        }
        let Ok(text) = std::str::from_utf8(bytes) else { return Kind::Text };
        let is_number = match self.has_commas {
            true => cell::parse_with_comma(bytes).is_ok(),
            false => text.parse::<f64>().is_ok() || cell::parse(bytes).is_ok(),
        };
        match () {
            () if is_number => Kind::Number,
            () if Instant::parse(text).is_some() => Kind::Instant,
            () => Kind::Text,
        }
    }
}

/// The words of a line.
pub(super) fn blanks(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|byte| matches!(byte, b' ' | b'\t' | b'\r' | b'\n')).filter(|word| !word.is_empty())
}

fn unquoted(cell: &[u8]) -> Cow<'_, [u8]> {
    let cell = cell.trim_ascii();
    let Some(inside) = cell.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\"")) else {
        return Cow::Borrowed(cell);
    };
    match inside.windows(2).any(|pair| pair == b"\"\"") {
        true => Cow::Owned(String::from_utf8_lossy(inside).replace("\"\"", "\"").into_bytes()),
        false => Cow::Borrowed(inside.trim_ascii()),
    }
}

/// What a cell holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Kind {
    Empty,
    Number,
    /// A date or a clock time.
    Instant,
    Text,
}

impl Kind {
    pub(super) fn is_value(self) -> bool {
        matches!(self, Self::Number | Self::Instant)
    }
}

/// The text behind the mark of a comment; `None` for what is none.
pub(super) fn comment(line: &[u8]) -> Option<&[u8]> {
    match line.trim_ascii_start() {
        [b'#' | b'%', rest @ ..] | [b'/', b'/', rest @ ..] => Some(rest),
        [b';', rest @ ..]
            if rest.trim_ascii_start().first().is_some_and(u8::is_ascii_alphabetic) =>
        {
            Some(rest)
        }
        _ => None,
    }
}

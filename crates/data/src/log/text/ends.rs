//! By what lines end, and so in which line a row of the CSV reader stands.
//!
//! That reader counts line feeds, and gives the place at which it begins to look for a row: before the line feed
//! of the row above where lines end with CR LF, and before blank lines.

use csv::{ByteRecord, Position};

/// By what the lines of a text end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    LineFeed,
    Both,
    CarriageReturn,
}

impl Ends {
    /// Of a text that begins like this.
    pub(super) fn of(head: &[u8]) -> Self {
        match head.iter().position(|byte| *byte == b'\n') {
            Some(at) if at > 0 && head[at - 1] == b'\r' => Self::Both,
            None if head.contains(&b'\r') => Self::CarriageReturn,
            _ => Self::LineFeed,
        }
    }

    /// What is read behind a text, whose last row may have no line feed.
    pub(super) fn behind(self) -> &'static [u8] {
        match self {
            Self::LineFeed => b"\n",
            Self::Both | Self::CarriageReturn => b"",
        }
    }

    /// The line, from 1, in which a row begins that the reader has read up to `to`.
    pub(super) fn line(self, row: &ByteRecord, to: &Position) -> usize {
        let from = row.position().map_or(0, Position::line);
        let end = match self {
            Self::LineFeed => to.line().saturating_sub(1),
            // That of this row is not read yet.
            Self::Both => to.line(),
            Self::CarriageReturn => to.record(),
        };
        // Blank lines above it, or line feeds in quotation marks.
        let inside = match to.line().saturating_sub(from) {
            0 | 1 => 0,
            _ => row.as_slice().iter().filter(|byte| **byte == b'\n').count(),
        };
        let line = match self {
            Self::CarriageReturn => end,
            _ => from.max(end.saturating_sub(inside as u64)),
        };
        usize::try_from(line).unwrap_or(0)
    }
}

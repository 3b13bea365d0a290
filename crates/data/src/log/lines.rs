//! Where the rows of a log stand in their file.

use std::fmt;

use crate::Problem;

/// Where a row stands in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Line of a text, from 1.
    Line(usize),
    /// Row of a table without lines, from 1.
    Row(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Row(row) => write!(f, "row {row}"),
        }
    }
}

impl Place {
    /// The problem, with this place.
    pub(super) fn locate(self, problem: Problem) -> Problem {
        match self {
            Self::Line(line) => problem.line(line),
            Self::Row(row) => problem.row(row),
        }
    }
}

/// A place per row, kept where it is not the one behind the place of the row before.
#[derive(Clone, Debug, Default)]
pub(super) struct Lines {
    /// Rows, and where they stand.
    jumps: Vec<(usize, Place)>,
}

impl Lines {
    /// Row `row` stands at `place`; rows come in order.
    pub(super) fn push(&mut self, row: usize, place: Place) {
        if self.at(row) != Some(place) {
            self.jumps.push((row, place));
        }
    }

    /// Where a row stands, `None` where the log comes from no file.
    pub(super) fn at(&self, row: usize) -> Option<Place> {
        let behind = self.jumps.partition_point(|(first, _)| *first <= row);
        let (first, place) = self.jumps.get(behind.checked_sub(1)?)?;
        Some(match place {
            Place::Line(line) => Place::Line(line + row - first),
            Place::Row(number) => Place::Row(number + row - first),
        })
    }

    /// The places of the rows from `start` on.
    pub(super) fn from(&self, start: usize) -> Self {
        let first = self.at(start).map(|place| (0, place));
        let behind = self.jumps.iter().filter(|(row, _)| *row > start);
        Self {
            jumps: first.into_iter().chain(behind.map(|(row, at)| (row - start, *at))).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_only_the_jumps() {
        let mut lines = Lines::default();
        for (row, line) in [2, 3, 4, 7, 8, 20].into_iter().enumerate() {
            lines.push(row, Place::Line(line));
        }
        assert_eq!(lines.jumps.len(), 3);
        assert_eq!(lines.at(2), Some(Place::Line(4)));
        assert_eq!(lines.at(4), Some(Place::Line(8)));
        assert_eq!(lines.at(5), Some(Place::Line(20)));
        let tail = lines.from(4);
        assert_eq!((tail.at(0), tail.at(1)), (Some(Place::Line(8)), Some(Place::Line(20))));
        assert_eq!(Lines::default().at(0), None);
    }
}

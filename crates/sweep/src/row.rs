//! The row of a run.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What a run leaves: one cell per column of the sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Number of the run, from 0.
    pub run: u64,
    /// The row's cells, in the order of the columns.
    pub cells: Vec<Cell>,
}

/// A value in a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cell {
    /// There is none: the run failed before, or has no such result.
    Missing,
    /// A real number.
    Real(f64),
    /// A whole number.
    #[serde(rename = "Whole")]
    Integer(i64),
    /// True or false.
    Truth(bool),
    /// A text.
    Text(String),
}

/// The value as an option of a command takes it; nothing where there is none.
impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cell::Missing => Ok(()),
            Cell::Real(value) => value.fmt(f),
            Cell::Integer(value) => value.fmt(f),
            Cell::Truth(value) => value.fmt(f),
            Cell::Text(text) => text.fmt(f),
        }
    }
}

/// Name, kind and unit of a column.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Name.
    pub name: String,
    /// What its cells hold.
    pub kind: ColumnKind,
    /// Unit, where there is one.
    pub unit: Option<String>,
}

/// What the cells of a column hold, or nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ColumnKind {
    /// Real numbers.
    Real,
    /// Whole numbers.
    #[serde(rename = "Whole")]
    Integer,
    /// Truth values.
    Truth,
    /// Texts.
    Text,
}

impl Column {
    /// A column.
    pub fn new(name: impl Into<String>, kind: ColumnKind, unit: Option<&str>) -> Self {
        Column { name: name.into(), kind, unit: unit.map(str::to_owned) }
    }
}

impl Cell {
    /// The kind of column it belongs to; none for a missing one.
    #[must_use]
    pub fn kind(&self) -> Option<ColumnKind> {
        match self {
            Cell::Missing => None,
            Cell::Real(_) => Some(ColumnKind::Real),
            Cell::Integer(_) => Some(ColumnKind::Integer),
            Cell::Truth(_) => Some(ColumnKind::Truth),
            Cell::Text(_) => Some(ColumnKind::Text),
        }
    }

    /// The number in it, if it is one.
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        match self {
            Cell::Real(value) => Some(*value),
            Cell::Integer(value) => Some(*value as f64),
            _ => None,
        }
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Cell::Real(value)
    }
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Self {
        value.map_or(Cell::Missing, Cell::Real)
    }
}

impl From<&str> for Cell {
    fn from(value: &str) -> Self {
        Cell::Text(value.to_owned())
    }
}

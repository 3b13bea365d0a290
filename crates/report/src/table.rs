//! Tables.

use serde::{Deserialize, Serialize};

use crate::value::Value;

/// A table with a caption, one heading per column and rows of values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// What the table shows.
    pub caption: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows. A row that is too short is shown with dashes; what is too long is shown too.
    pub rows: Vec<Vec<Value>>,
}

/// One column of a [`Table`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// The heading.
    pub heading: String,
    /// The unit of all values of the column; empty for none.
    pub unit: String,
    /// Decimals of every number of the column; `None`: four significant digits each.
    pub decimals: Option<usize>,
}

impl Column {
    /// A column without a unit.
    pub fn new(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), unit: String::new(), decimals: None }
    }

    /// Sets the unit of the column's values.
    #[must_use]
    pub fn unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = unit.into();
        self
    }

    /// Shows every number with this many decimals.
    #[must_use]
    pub fn decimals(mut self, decimals: usize) -> Self {
        self.decimals = Some(decimals);
        self
    }
}

impl From<&str> for Column {
    fn from(heading: &str) -> Self {
        Self::new(heading)
    }
}

impl Table {
    /// A table without rows.
    pub fn new<C: Into<Column>>(
        caption: impl Into<String>,
        columns: impl IntoIterator<Item = C>,
    ) -> Self {
        Self {
            caption: caption.into(),
            columns: columns.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
        }
    }

    /// Appends a row.
    #[must_use]
    pub fn row<V: Into<Value>>(mut self, cells: impl IntoIterator<Item = V>) -> Self {
        self.rows.push(cells.into_iter().map(Into::into).collect());
        self
    }
}

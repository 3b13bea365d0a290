//! Tables of numbers that a component runs on: too many to be variables.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// Rows of numbers, shared by all that use them.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    columns: usize,
    values: Arc<[f64]>,
}

impl Table {
    /// Rows of `columns` numbers, one after the other.
    ///
    /// # Errors
    /// The numbers do not fill rows.
    pub fn new(columns: usize, values: Vec<f64>) -> Result<Self, String> {
        if columns == 0 || values.is_empty() || !values.len().is_multiple_of(columns) {
            let count = values.len();
            return Err(alloc::format!("{count} numbers do not fill rows of {columns}"));
        }
        Ok(Self { columns, values: values.into() })
    }

    /// Numbers in a row.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns
    }

    /// All numbers, row after row.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

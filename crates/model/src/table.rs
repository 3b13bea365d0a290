//! Tables of numbers that a component runs on: too many to be variables.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::Deref;

use crate::Component;

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

/// A component: one of the registry, or one that runs a table and is shared by the systems that were
/// built from it.
#[derive(Clone)]
pub enum ComponentRef {
    /// Of the registry.
    Static(&'static dyn Component),
    /// With its own table.
    Shared(Arc<dyn Component>),
}

impl ComponentRef {
    /// A component with its own table.
    #[must_use]
    pub fn shared(component: impl Component + 'static) -> Self {
        Self::Shared(Arc::new(component))
    }
}

impl From<&'static dyn Component> for ComponentRef {
    fn from(component: &'static dyn Component) -> Self {
        Self::Static(component)
    }
}

impl Deref for ComponentRef {
    type Target = dyn Component;

    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        match self {
            Self::Static(component) => *component,
            Self::Shared(component) => &**component,
        }
    }
}

//! Columns by name: a log may have many thousands.

use std::collections::HashMap;
use std::sync::OnceLock;

use super::Column;

/// Places of the columns by their names, created when a column is asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Names(OnceLock<HashMap<String, usize>>);

impl Names {
    /// The place of a name among these columns.
    pub(super) fn place(&self, columns: &[Column], name: &str) -> Option<usize> {
        let places = self.0.get_or_init(|| {
            let named = columns.iter().enumerate().rev();
            named.map(|(place, column)| (column.name.clone(), place)).collect()
        });
        places.get(name).copied()
    }

    /// A column of this name has been added at this place.
    pub(super) fn added(&mut self, name: &str, place: usize) {
        if let Some(places) = self.0.get_mut() {
            places.entry(name.to_owned()).or_insert(place);
        }
    }
}

//! What was recognised in a file, and what a reader did about it: nothing is dropped or assumed in silence.

use super::Log;
use crate::Problem;

/// A column that the file has and the log has not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Name of the column.
    pub name: String,
    /// Why it cannot be used, as in `holds texts`; behind `;` what to do about it.
    pub why: String,
}

impl LeftOut {
    /// A column that cannot be used, and why.
    pub(super) fn new(name: impl Into<String>, why: impl Into<String>) -> Self {
        Self { name: name.into(), why: why.into() }
    }
}

/// Remarks on a log, beside its values.
#[derive(Clone, Debug, Default)]
pub(super) struct Remarks {
    /// Sentences about the file: what was recognised, assumed, skipped.
    pub(super) notes: Vec<String>,
    pub(super) left_out: Vec<LeftOut>,
    /// Whether it was joined of several groups, on uniform times.
    pub(super) is_joined: bool,
    /// Whether `--group` chose among its groups.
    pub(super) is_chosen: bool,
}

impl Log {
    /// What was recognised in the file, assumed, skipped and left out, a sentence each with the file's name
    /// before it; nothing for a plain log.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let Remarks { notes, left_out, .. } = &self.remarks;
        let left_out = left_out.iter().map(|column| {
            format!("{}: column \"{}\" is left out: it {}", self.origin, column.name, column.why)
        });
        let message = notes.iter().map(|note| format!("{}: {note}", self.origin));
        message.chain(left_out).chain(self.note_on_times()).collect()
    }

    /// The columns of the file that cannot be used; they are no error until somebody asks for one.
    #[must_use]
    pub fn left_out(&self) -> &[LeftOut] {
        &self.remarks.left_out
    }

    /// Why there is no column of this name although the file has one.
    pub(super) fn reason_left_out(&self, name: &str) -> Option<Problem> {
        let column = self.remarks.left_out.iter().find(|column| column.name == name)?;
        let (rule, way_out) = column.why.split_once("; ").unwrap_or((&column.why, ""));
        Some(Problem::new(&self.origin, format!("cannot be used: it {rule}"), way_out).at(name))
    }
}

//! Files of other programs, in a build without their readers: only refused.

use std::path::Path;

use super::dataset::Dataset;
use super::{Log, ReadOptions};
use crate::{Problem, Problems};

/// What is no text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Format;

impl Format {
    /// Whether a file that begins like this is no text: it has a byte 0, and is not UTF-16.
    pub(super) fn of(_: &Path, start: &[u8]) -> Option<Self> {
        let is_utf_16 = start.starts_with(&[0xff, 0xfe]) || start.starts_with(&[0xfe, 0xff]);
        (!is_utf_16 && start.contains(&0)).then_some(Self)
    }

    /// Refuses the file.
    pub(super) fn read(
        self,
        _: &Path,
        origin: &str,
        _: &ReadOptions,
        _: &[Dataset],
    ) -> Result<Log, Problems> {
        let rule = "is no text, and this build reads texts only";
        Err(Problem::new(origin, rule, "save it as CSV, or build with the feature formats").into())
    }
}

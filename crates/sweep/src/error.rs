//! What goes wrong in a sweep.

use std::io;
use std::path::{Path, PathBuf};

use data::Problems;
use thiserror::Error;

/// A sweep that cannot be planned, run or put together.
#[derive(Debug, Error)]
pub enum Error {
    /// Everything that is wrong with a plan, with its lines.
    #[error(transparent)]
    Plan(#[from] Problems),
    /// A file cannot be read or written.
    #[error("{}: cannot be {what}: {error}; check the folder, its permissions and the free space", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// `read` or `written`.
        what: &'static str,
        /// What the system says.
        error: io::Error,
    },
    /// A file that does not hold what it should.
    #[error("{}: {rule}; {way_out}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        rule: String,
        /// What to do.
        way_out: String,
    },
    /// Tables that are no whole.
    #[error("{rule}; {way_out}")]
    Merge {
        /// What is missing or doubled.
        rule: String,
        /// What to do.
        way_out: String,
    },
}

impl Error {
    pub(crate) fn read(path: &Path, error: impl Into<io::Error>) -> Self {
        Error::Io { path: path.to_owned(), what: "read", error: error.into() }
    }

    pub(crate) fn written(path: &Path, error: impl Into<io::Error>) -> Self {
        Error::Io { path: path.to_owned(), what: "written", error: error.into() }
    }

    pub(crate) fn file(path: &Path, rule: impl Into<String>, way_out: impl Into<String>) -> Self {
        Error::File { path: path.to_owned(), rule: rule.into(), way_out: way_out.into() }
    }
}

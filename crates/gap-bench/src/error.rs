//! Why a benchmark cannot be run.

use std::io;
use std::path::{Path, PathBuf};

/// Why a benchmark cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or folder.
    #[error("{}: {source}; check the folder and the space on the disk", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What went wrong.
        source: io::Error,
    },
    /// A file whose content makes no sense.
    #[error("{}: {message}; delete it, and the case is made again", path.display())]
    Content {
        /// Which.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// The folder holds another benchmark.
    #[error(
        "{}: this folder holds a benchmark with {found}, asked for is one with {asked}; choose another folder with -o, or delete this one",
        path.display()
    )]
    OtherPlan {
        /// The folder.
        path: PathBuf,
        /// What the path holds.
        found: String,
        /// What was asked for.
        asked: String,
    },
    /// A selection of cases that makes no sense.
    #[error("--cases {text}: {message}")]
    Selection {
        /// As it was given.
        text: String,
        /// Rule and way out.
        message: String,
    },
    /// A folder of measured machines, or one of them, that makes no sense.
    #[error("{}: {message}", path.display())]
    Machine {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// A log cannot be written.
    #[error(transparent)]
    Data(#[from] data::Problems),
    /// The page cannot be written.
    #[error(transparent)]
    Report(#[from] report::ReportError),
    /// The threads cannot be started.
    #[error("{0} threads cannot be started; ask for fewer with --threads")]
    Threads(usize),
}

/// Names the file of an error.
pub(crate) fn at<T>(path: &Path, result: io::Result<T>) -> Result<T, Error> {
    result.map_err(|source| Error::File { path: path.to_path_buf(), source })
}

//! Why a diagnosis cannot be made.

use std::path::PathBuf;

/// Why a simulation of a candidate has no result: parameters that are none, or numbers that overflow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Failed;

/// Why a diagnosis cannot be made. Every message says what, where, and the way out.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Logs or names with problems, all of them.
    #[error(transparent)]
    Data(#[from] data::Problems),
    /// An FMU that does not open, load or run.
    #[error(transparent)]
    Fmu(#[from] cosim::Error),
    /// An FMU that failed over a record.
    #[error("{record}: {cause}; {row} of {rows} rows had been run until then")]
    Run {
        /// Name of the record.
        record: String,
        /// Rows until then.
        row: usize,
        /// All its rows.
        rows: usize,
        /// What happened, when.
        cause: Box<cosim::RunError>,
    },
    /// A value of an option that makes no sense.
    #[error("{option} {value}: {message}")]
    Option {
        /// The option.
        option: &'static str,
        /// The option's value.
        value: String,
        /// Rule and way out.
        message: String,
    },
    /// The model cannot be used as it is.
    #[error("{model}: {message}")]
    Model {
        /// Name of the model.
        model: String,
        /// Rule and way out.
        message: String,
    },
    /// A blueprint whose axes cannot be looked at one by one.
    #[error(
        "{model}: {reason}; pack it (piezoloop pack) and diagnose the FMU, whose inputs all act"
    )]
    Joined {
        /// Name of the model.
        model: String,
        /// What joins them, and why that cannot be inverted.
        reason: String,
    },
    /// A log cannot be used as it is.
    #[error("{log}: {message}")]
    Log {
        /// Name of the log.
        log: String,
        /// Rule and way out.
        message: String,
    },
    /// The repaired model cannot be written.
    #[error("{}: {message}", file.display())]
    Repair {
        /// The file.
        file: PathBuf,
        /// Rule and way out.
        message: String,
    },
    /// The page cannot be written.
    #[error(transparent)]
    Report(#[from] report::ReportError),
    /// The threads cannot be started.
    #[error("{0} threads cannot be started; ask for fewer with --threads")]
    Threads(usize),
}

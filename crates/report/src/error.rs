//! What can go wrong when a report is written.

use std::path::PathBuf;

/// Errors of rendering and writing a report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A file could not be written; nothing was left behind.
    #[error("{path}: cannot write the report: {source}")]
    Write {
        /// The file that was asked for.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// An input file could not be read for its fingerprint.
    #[error("{path}: cannot read the file for its SHA-256: {source}")]
    Read {
        /// The file that was asked for.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The context could not be written as JSON, or JSON is not a report.
    #[error("not a report in JSON ({schema}): {source}", schema = crate::SCHEMA)]
    Json {
        /// What the JSON library said, with line and column.
        #[from]
        source: serde_json::Error,
    },
    /// The JSON is a report of another schema.
    #[error("the report's schema is `{found}`, this version reads `{expected}`; write it again with this version", expected = crate::SCHEMA)]
    Schema {
        /// The schema that the file names.
        found: String,
    },
    /// The page's template could not be rendered.
    #[error("the page's template failed: {source}")]
    Template {
        /// What the template engine said.
        #[from]
        source: minijinja::Error,
    },
}

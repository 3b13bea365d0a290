//! What is wrong with an SSP.

use crate::package::PackageError;
use crate::problem::{Problem, Severity};
use crate::xml::XmlError;

/// Why an SSP cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SspError {
    /// The archive cannot be opened or written.
    #[error(transparent)]
    Package(#[from] PackageError),
    /// The archive has no SSD.
    #[error(
        "{path}: there is no {ssd} at the root of the archive; an SSP holds its system there",
        path = path.display(), ssd = super::SYSTEM_STRUCTURE
    )]
    NoStructure {
        /// The archive.
        path: std::path::PathBuf,
    },
    /// What is wrong, all of it.
    #[error("{}", list(.0))]
    Problems(Vec<Problem>),
    /// A text that XML cannot carry.
    #[error(
        "<{element}> {attribute}: the character U+{character:04X} cannot stand in XML; remove it"
    )]
    Character {
        /// Name of the element.
        element: String,
        /// Name of the attribute.
        attribute: String,
        /// Number of the character.
        character: u32,
    },
}

fn list(problems: &[Problem]) -> String {
    problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n")
}

/// The schema whose rules a file must keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Structure,
    Values,
    Mapping,
    Dictionary,
}

impl Format {
    pub(super) fn section(self) -> &'static str {
        match self {
            Format::Structure => "SSP 1.0, SystemStructureDescription",
            Format::Values => "SSP 1.0, SystemStructureParameterValues",
            Format::Mapping => "SSP 1.0, SystemStructureParameterMapping",
            Format::Dictionary => "SSP 1.0, SystemStructureSignalDictionary",
        }
    }

    pub(super) fn root(self) -> &'static str {
        match self {
            Format::Structure => "SystemStructureDescription",
            Format::Values => "ParameterSet",
            Format::Mapping => "ParameterMapping",
            Format::Dictionary => "SignalDictionary",
        }
    }

    pub(super) fn namespace(self) -> String {
        let name = match self {
            Format::Structure => "SystemStructureDescription",
            Format::Values => "SystemStructureParameterValues",
            Format::Mapping => "SystemStructureParameterMapping",
            Format::Dictionary => "SystemStructureSignalDictionary",
        };
        format!("http://ssp-standard.org/SSP1/{name}")
    }
}

/// A problem of a file of an SSP.
pub(super) fn problem(format: Format, file: &str, line: u32, found: String) -> Problem {
    Problem {
        severity: Severity::Error,
        file: file.to_owned(),
        line: (line > 0).then_some(line),
        section: format.section(),
        found,
        rule: String::new(),
        way_out: String::new(),
        unreadable: false,
    }
}

/// A file that is no XML.
pub(super) fn no_xml(format: Format, file: &str, error: &XmlError) -> Problem {
    problem(format, file, error.line().unwrap_or(0), error.to_string())
        .rule("it must be XML that can be read safely")
        .way_out("correct the file, or export it again with the tool it comes from")
}

//! Every problem of an FMU, against the letter of FMI 2.0.5 or 3.0.2.

mod binary;
mod distribution;
mod functions;
mod names;
mod references;
mod root;
mod structure;
mod types;
mod units;
mod variables;

use std::path::Path;

pub use functions::required_functions;

use crate::description::{FmiVersion, Line, ModelDescription};
use crate::package::{Limits, PackageError};
use crate::problem::{MODEL_DESCRIPTION, Problem, Topic};
use crate::read::{self, ParseError};
use crate::xml::{XmlError, XmlLimits};

/// All problems of an FMU: its archive or folder, its model description, its binaries. Nothing is
/// unpacked and no code of the FMU runs.
///
/// # Errors
/// If the file or folder itself cannot be read.
pub fn check(path: impl AsRef<Path>) -> Result<Vec<Problem>, PackageError> {
    distribution::check(path.as_ref(), &Limits::default())
}

/// All problems of a `modelDescription.xml`.
pub fn check_description(xml: &[u8]) -> Vec<Problem> {
    read_and_check(xml, &XmlLimits::default()).1
}

/// The description, if there is one at all, and all its problems, in the order of the file.
pub(crate) fn read_and_check(
    xml: &[u8],
    limits: &XmlLimits,
) -> (Option<ModelDescription>, Vec<Problem>) {
    match read::read(xml, limits) {
        Ok((description, mut problems)) => {
            problems.extend(check_model(&description));
            // What could not be read is reported as such, not as missing.
            problems.sort_by_key(|problem| problem.line);
            problems.dedup();
            (Some(description), problems)
        }
        Err(error) => (None, vec![not_readable(&error)]),
    }
}

/// All problems of a description that was read or made.
pub fn check_model(description: &ModelDescription) -> Vec<Problem> {
    let mut checker =
        Checker { description, version: description.fmi_version, problems: Vec::new() };
    root::check(&mut checker);
    units::check(&mut checker);
    types::check(&mut checker);
    names::check(&mut checker);
    variables::check(&mut checker);
    references::check(&mut checker);
    structure::check(&mut checker);
    checker.problems
}

/// The description under examination and what was found so far.
struct Checker<'a> {
    description: &'a ModelDescription,
    version: FmiVersion,
    problems: Vec<Problem>,
}

impl Checker<'_> {
    /// Reports what the standard forbids.
    fn error(
        &mut self,
        topic: Topic,
        line: Line,
        found: String,
        rule: impl Into<String>,
        way_out: impl Into<String>,
    ) {
        let problem = Problem::in_xml(self.version, topic, line.0, found);
        self.problems.push(problem.rule(rule).way_out(way_out));
    }

    /// Reports what is allowed but causes trouble.
    fn warning(
        &mut self,
        topic: Topic,
        line: Line,
        found: String,
        rule: impl Into<String>,
        way_out: impl Into<String>,
    ) {
        let problem = Problem::in_xml(self.version, topic, line.0, found);
        self.problems.push(problem.rule(rule).way_out(way_out).warning());
    }
}

fn not_readable(error: &ParseError) -> Problem {
    let (line, topic) = match error {
        ParseError::Xml(error) => (line_of(error), Topic::Document),
        ParseError::Root { line, .. } | ParseError::Version { line, .. } => (*line, Topic::Root),
        ParseError::Unreadable(_) => (0, Topic::Root),
    };
    let found = match error {
        ParseError::Xml(error) => error.to_string(),
        other => other.to_string().trim_start_matches(MODEL_DESCRIPTION).to_owned(),
    };
    let found = found.trim_start_matches(|c: char| c == ':' || c == ' ' || c.is_ascii_digit());
    Problem::in_xml(FmiVersion::V2, topic, line, found.to_owned())
        .rule("the file must be a well-formed model description of FMI 2.0 or 3.0")
        .way_out("nothing further was checked; repair this first")
}

fn line_of(error: &XmlError) -> u32 {
    match error {
        XmlError::TooLarge { .. } => 0,
        XmlError::NotUtf8 { line, .. }
        | XmlError::DocumentType { line }
        | XmlError::NotWellFormed { line, .. }
        | XmlError::Limit { line, .. } => *line,
    }
}

/// Items whose key appeared before, with the key's first item.
fn repeated<'a, T, K: std::hash::Hash + Eq>(
    items: impl IntoIterator<Item = &'a T>,
    key: impl Fn(&'a T) -> K,
) -> Vec<(&'a T, &'a T)> {
    let mut first = std::collections::HashMap::new();
    let mut repeated = Vec::new();
    for item in items {
        match first.entry(key(item)) {
            std::collections::hash_map::Entry::Vacant(entry) => {
                entry.insert(item);
            }
            std::collections::hash_map::Entry::Occupied(entry) => {
                repeated.push((item, *entry.get()));
            }
        }
    }
    repeated
}

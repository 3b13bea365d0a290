//! Every problem of an FMU, against the letter of FMI 2.0.5 or 3.0.2.

mod binary;
mod content;
mod distribution;
mod functions;
mod names;
mod references;
mod root;
mod sources;
mod structure;
mod types;
mod units;
mod variables;

use std::collections::HashMap;
use std::hash::Hash;
use std::path::Path;

pub use functions::required_functions;

use crate::description::{FmiVersion, Line, ModelDescription, TypeDefinition, Unit};
use crate::package::{Limits, PackageError, Platform};
use crate::problem::{Problem, Topic};
use crate::read::{self, ParseError};
use crate::variable::{Properties, Variable};
use crate::xml::XmlLimits;

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
            problems.sort_by_key(|problem| problem.line);
            problems.dedup();
            (Some(description), problems)
        }
        Err(error) => (None, vec![not_readable(&error)]),
    }
}

/// All problems of a description that was read or made.
pub fn check_model(description: &ModelDescription) -> Vec<Problem> {
    let mut checker = Checker::new(description);
    root::check(&mut checker);
    units::check(&mut checker);
    types::check(&mut checker);
    names::check(&mut checker);
    variables::check(&mut checker);
    references::check(&mut checker);
    structure::check(&mut checker);
    checker.problems
}

/// What is wrong with a shared library that should serve an FMU of this description on a platform: a
/// sentence each, with the rule and the way out. No code of the library runs.
pub fn check_library(
    library: &[u8],
    platform: Platform,
    description: &ModelDescription,
) -> Vec<String> {
    let faults = binary::faults(library, platform, &required_functions(description));
    faults.into_iter().map(|(found, rule, way)| format!("{found}; {rule}: {way}")).collect()
}

/// The description under examination and what was found so far.
struct Checker<'a> {
    description: &'a ModelDescription,
    version: FmiVersion,
    problems: Vec<Problem>,
    /// By value reference, in 3.0; the first where several have the same.
    by_reference: HashMap<u32, &'a Variable>,
    types: HashMap<&'a str, &'a TypeDefinition>,
    units: HashMap<&'a str, &'a Unit>,
}

impl<'a> Checker<'a> {
    fn new(description: &'a ModelDescription) -> Self {
        Checker {
            description,
            version: description.fmi_version,
            problems: Vec::new(),
            by_reference: first_by(&description.variables, |variable| variable.value_reference),
            types: first_by(&description.types, |definition| definition.name.as_str()),
            units: first_by(&description.units, |unit| unit.name.as_str()),
        }
    }

    /// [`ModelDescription::referenced`], quick for large descriptions.
    fn referenced(&self, reference: u32) -> Option<&'a Variable> {
        match self.version {
            FmiVersion::V2 => self.description.referenced(reference),
            FmiVersion::V3 => self.by_reference.get(&reference).copied(),
        }
    }

    /// [`ModelDescription::declared_type`], quick for large descriptions.
    fn declared_type(&self, variable: &Variable) -> Option<&'a TypeDefinition> {
        self.types.get(variable.declared_type.as_deref()?).copied()
    }

    /// [`ModelDescription::properties`], quick for large descriptions.
    fn properties(&self, variable: &Variable) -> Properties {
        match self.declared_type(variable) {
            Some(definition) => variable.properties.or(&definition.properties),
            None => variable.properties.clone(),
        }
    }

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

/// A file of which nothing is known but that it is no description.
fn not_readable(error: &ParseError) -> Problem {
    let (topic, line, found) = match error {
        ParseError::Xml(error) => (Topic::Document, error.line(), error.to_string()),
        ParseError::Root { line, found } => {
            (Topic::Root, Some(*line), format!("the root element is <{found}>"))
        }
        ParseError::Version { line, found } => {
            (Topic::Root, Some(*line), format!("fmiVersion=\"{found}\""))
        }
        ParseError::Unreadable(_) => (Topic::Root, None, error.to_string()),
    };
    Problem::in_xml(FmiVersion::V2, topic, line.unwrap_or(0), found)
        .rule("the file must be a well-formed <fmiModelDescription> of FMI 2.0 or 3.0")
        .way_out("repair this first; nothing further was checked")
}

/// The first item of each key.
fn first_by<'a, T, K: Hash + Eq>(items: &'a [T], key: impl Fn(&'a T) -> K) -> HashMap<K, &'a T> {
    let mut first = HashMap::with_capacity(items.len());
    for item in items {
        first.entry(key(item)).or_insert(item);
    }
    first
}

/// Items whose key appeared before, with the key's first item.
fn repeated<'a, T, K: Hash + Eq>(items: &'a [T], key: impl Fn(&'a T) -> K) -> Vec<(&'a T, &'a T)> {
    let first = first_by(items, &key);
    let again = |item: &'a T| {
        let first = *first.get(&key(item))?;
        (!std::ptr::eq(first, item)).then_some((item, first))
    };
    items.iter().filter_map(again).collect()
}

//! `<ModelStructure>`: the right unknowns, each with dependencies on knowns only.

use std::collections::HashSet;

use super::Checker;
use crate::description::{FmiVersion, Line, ModelDescription};
use crate::problem::Topic;
use crate::structure::{DependencyKind, Unknown};
use crate::variable::{Causality, Initial, Variability, Variable};

pub(super) fn check(checker: &mut Checker<'_>) {
    let description = checker.description;
    let structure = &description.structure;
    let states = states(checker);
    let names = ListNames::of(checker.version);
    outputs(checker, names.outputs);
    derivatives(checker, names.derivatives);
    clocked_states(checker);
    event_indicators(checker);
    initial_unknowns(checker, names.initial_unknowns, &states);
    let lists = [
        (names.outputs, &structure.outputs, false),
        (names.derivatives, &structure.derivatives, false),
        ("ClockedState", &structure.clocked_states, false),
        (names.initial_unknowns, &structure.initial_unknowns, true),
        ("EventIndicator", &structure.event_indicators, false),
    ];
    for (name, unknowns, at_initialisation) in lists {
        let list = List { name, at_initialisation, states: &states };
        existing_and_unique(checker, name, unknowns);
        for unknown in unknowns {
            dependencies(checker, &list, unknown);
            kinds(checker, &list, unknown);
        }
    }
}

/// What the lists are called.
struct ListNames {
    outputs: &'static str,
    derivatives: &'static str,
    initial_unknowns: &'static str,
}

impl ListNames {
    fn of(version: FmiVersion) -> Self {
        match version {
            FmiVersion::V2 => ListNames {
                outputs: "Outputs",
                derivatives: "Derivatives",
                initial_unknowns: "InitialUnknowns",
            },
            FmiVersion::V3 => ListNames {
                outputs: "Output",
                derivatives: "ContinuousStateDerivative",
                initial_unknowns: "InitialUnknown",
            },
        }
    }
}

/// References of the continuous states: what the listed derivatives are derivatives of.
fn states(checker: &Checker<'_>) -> HashSet<u32> {
    let derivatives = checker.description.structure.derivatives.iter();
    derivatives.filter_map(|u| checker.referenced(u.variable)?.derivative).collect()
}

/// The variables of a description with the references by which the structure means them.
fn referenced_variables(description: &ModelDescription) -> impl Iterator<Item = (u32, &Variable)> {
    let variables = description.variables.iter().enumerate();
    variables.filter_map(|(position, v)| Some((description.reference_to(position)?, v)))
}

fn report(checker: &mut Checker<'_>, line: Line, found: String, rule: &str, way_out: &str) {
    checker.error(Topic::Structure, line, found, rule, way_out);
}

/// `variable "y" (index 3)`.
fn named(checker: &Checker<'_>, reference: u32) -> String {
    let kind = match checker.version {
        FmiVersion::V2 => "index",
        FmiVersion::V3 => "valueReference",
    };
    match checker.referenced(reference) {
        Some(variable) => format!("\"{}\" ({kind} {reference})", variable.name),
        None => format!("{kind} {reference}"),
    }
}

fn existing_and_unique(checker: &mut Checker<'_>, list: &str, unknowns: &[Unknown]) {
    let mut seen = HashSet::new();
    for unknown in unknowns {
        let name = named(checker, unknown.variable);
        if checker.referenced(unknown.variable).is_none() {
            let found = format!("{list} has {name}");
            let rule = match checker.version {
                FmiVersion::V2 => "the index is the position of a variable, counted from 1",
                FmiVersion::V3 => "the value reference is that of a variable",
            };
            report(checker, unknown.line, found, rule, "correct it");
        } else if !seen.insert(unknown.variable) {
            let found = format!("{list} has {name} twice");
            report(checker, unknown.line, found, "duplicates are not allowed", "remove one");
        }
    }
}

/// Exactly the variables with causality output.
fn outputs(checker: &mut Checker<'_>, list: &str) {
    let description = checker.description;
    let listed: HashSet<u32> = description.structure.outputs.iter().map(|u| u.variable).collect();
    for (reference, variable) in referenced_variables(description) {
        if variable.causality == Causality::Output && !listed.contains(&reference) {
            let found = format!("{list} lacks {}", named(checker, reference));
            let rule = "every variable with causality output must be listed";
            report(checker, variable.line, found, rule, "add it");
        }
    }
    for unknown in &description.structure.outputs {
        let Some(variable) = checker.referenced(unknown.variable) else { continue };
        if variable.causality != Causality::Output {
            let found = format!(
                "{list} has {} of causality {}",
                named(checker, unknown.variable),
                variable.causality
            );
            let rule = "only variables with causality output are listed";
            report(checker, unknown.line, found, rule, "remove it");
        }
    }
}

/// Continuous floats that name their state.
fn derivatives(checker: &mut Checker<'_>, list: &str) {
    let description = checker.description;
    for unknown in &description.structure.derivatives {
        let Some(variable) = checker.referenced(unknown.variable) else { continue };
        let is_continuous = variable.variability(checker.version) == Variability::Continuous;
        if variable.derivative.is_none() || !variable.data_type.is_float() || !is_continuous {
            let found = format!("{list} has {}", named(checker, unknown.variable));
            let rule =
                "it must be a continuous floating point variable with the attribute derivative";
            report(checker, unknown.line, found, rule, "correct the variable or remove it");
        }
    }
}

fn clocked_states(checker: &mut Checker<'_>) {
    let description = checker.description;
    for unknown in &description.structure.clocked_states {
        let Some(variable) = checker.referenced(unknown.variable) else { continue };
        if variable.previous.is_none() || variable.clocks.is_empty() {
            let found = format!("ClockedState has {}", named(checker, unknown.variable));
            let rule = "it must have the attributes previous and clocks";
            report(checker, unknown.line, found, rule, "add them or remove it");
        }
    }
}

fn event_indicators(checker: &mut Checker<'_>) {
    let description = checker.description;
    for unknown in &description.structure.event_indicators {
        let Some(variable) = checker.referenced(unknown.variable) else { continue };
        let is_continuous = variable.variability(checker.version) == Variability::Continuous;
        if !variable.data_type.is_float() || !is_continuous {
            let found = format!("EventIndicator has {}", named(checker, unknown.variable));
            let rule = "it must be a continuous floating point variable";
            report(checker, unknown.line, found, rule, "correct the variable or remove it");
        }
    }
}

/// Why a variable must be among the initial unknowns, if it must.
fn why_initial_unknown(
    version: FmiVersion,
    reference: u32,
    variable: &Variable,
    states: &HashSet<u32>,
    derivatives: &HashSet<u32>,
) -> Option<&'static str> {
    let computed = matches!(variable.initial(version), Some(Initial::Approx | Initial::Calculated));
    match variable.causality {
        Causality::CalculatedParameter => Some("it is a calculated parameter"),
        _ if !computed => None,
        Causality::Output if variable.clocks.is_empty() => {
            Some("it is an output with initial approx or calculated")
        }
        _ if states.contains(&reference) => Some("it is a state with initial approx or calculated"),
        _ if derivatives.contains(&reference) => {
            Some("it is the derivative of a state, with initial approx or calculated")
        }
        _ => None,
    }
}

/// Exactly the variables that initialisation computes; in 2.0 in the order of the variables.
fn initial_unknowns(checker: &mut Checker<'_>, list: &str, states: &HashSet<u32>) {
    let description = checker.description;
    let structure = &description.structure;
    let derivatives: HashSet<u32> = structure.derivatives.iter().map(|u| u.variable).collect();
    let listed: HashSet<u32> = structure.initial_unknowns.iter().map(|u| u.variable).collect();
    let mut expected = HashSet::new();
    for (reference, variable) in referenced_variables(description) {
        let why = why_initial_unknown(checker.version, reference, variable, states, &derivatives);
        let Some(why) = why else { continue };
        expected.insert(reference);
        if !listed.contains(&reference) {
            let found = format!("{list} lacks {}", named(checker, reference));
            let rule = format!("{why}, so it must be listed");
            report(checker, variable.line, found, &rule, "add it");
        }
    }
    for unknown in &structure.initial_unknowns {
        let Some(variable) = checker.referenced(unknown.variable) else { continue };
        // Clocked variables are listed as the FMU likes (3.0).
        if !expected.contains(&unknown.variable) && variable.clocks.is_empty() {
            let initial = variable.initial(checker.version).map_or("none", Initial::name);
            let found = format!(
                "{list} has {} of causality {} and initial {initial}",
                named(checker, unknown.variable),
                variable.causality
            );
            let rule = "listed are outputs, states and derivatives with initial approx or \
                        calculated, and calculated parameters, and nothing else";
            report(checker, unknown.line, found, rule, "remove it");
        }
    }
    if checker.version == FmiVersion::V2 {
        ascending(checker, list);
    }
}

fn ascending(checker: &mut Checker<'_>, list: &str) {
    for pair in checker.description.structure.initial_unknowns.windows(2) {
        let [before, after] = pair else { continue };
        if after.variable < before.variable {
            let found =
                format!("{list} has index {} after index {}", after.variable, before.variable);
            let rule = "the list must be in the order of the variables";
            report(checker, after.line, found, rule, "sort it");
        }
    }
}

/// The list an unknown stands in.
struct List<'a> {
    name: &'static str,
    at_initialisation: bool,
    states: &'a HashSet<u32>,
}

impl List<'_> {
    /// Whether an unknown of this list may depend on the variable.
    fn is_known(&self, version: FmiVersion, reference: u32, variable: &Variable) -> bool {
        match variable.causality {
            Causality::Input | Causality::Independent => true,
            _ if self.at_initialisation => variable.initial(version) == Some(Initial::Exact),
            Causality::Parameter | Causality::StructuralParameter => version == FmiVersion::V3,
            _ => self.states.contains(&reference) || variable.previous.is_some(),
        }
    }

    fn knowns(&self, version: FmiVersion) -> &'static str {
        match (self.at_initialisation, version) {
            (true, _) => {
                "at initialisation, knowns are inputs, variables with initial exact and the \
                 independent variable"
            }
            (false, FmiVersion::V2) => {
                "knowns are inputs, continuous states and the independent variable; what depends on \
                 parameters only is listed in InitialUnknowns"
            }
            (false, FmiVersion::V3) => {
                "knowns are inputs, parameters, states and the independent variable"
            }
        }
    }
}

fn dependencies(checker: &mut Checker<'_>, list: &List<'_>, unknown: &Unknown) {
    let Some(dependencies) = &unknown.dependencies else { return };
    let version = checker.version;
    let subject = format!("{}: {}", list.name, named(checker, unknown.variable));
    let mut seen = HashSet::new();
    let mut previous = 0;
    for &dependency in dependencies {
        let found = format!("{subject} depends on {}", named(checker, dependency));
        match checker.referenced(dependency) {
            None => {
                let rule = "there is no such variable";
                report(checker, unknown.line, found, rule, "correct the dependencies");
            }
            Some(_) if !seen.insert(dependency) => {
                let found = format!("{found} twice");
                report(checker, unknown.line, found, "each known is listed once", "remove one");
            }
            Some(variable) if !list.is_known(version, dependency, variable) => {
                let found = format!("{found}, a variable of causality {}", variable.causality);
                let rule = list.knowns(version);
                report(checker, unknown.line, found, rule, "remove it from the dependencies");
            }
            Some(_) if version == FmiVersion::V2 && dependency < previous => {
                let found = format!("{subject} depends on index {dependency} after {previous}");
                let rule = "indices must be in ascending order";
                report(checker, unknown.line, found, rule, "sort the dependencies");
            }
            Some(_) => {}
        }
        previous = dependency;
    }
}

fn kinds(checker: &mut Checker<'_>, list: &List<'_>, unknown: &Unknown) {
    let Some(kinds) = &unknown.dependency_kinds else { return };
    let subject = format!("{}: {}", list.name, named(checker, unknown.variable));
    match &unknown.dependencies {
        None => {
            let found = format!("{subject} has dependenciesKind without dependencies");
            report(checker, unknown.line, found, "both must be present", "add dependencies");
        }
        Some(dependencies) if dependencies.len() != kinds.len() => {
            let found = format!(
                "{subject} has {} dependencies and {} kinds",
                dependencies.len(),
                kinds.len()
            );
            report(checker, unknown.line, found, "there must be as many", "correct the lists");
        }
        Some(_) => {}
    }
    let variable = checker.referenced(unknown.variable);
    let is_float = variable.is_none_or(|variable| variable.data_type.is_float());
    for kind in kinds {
        let rule = match kind {
            DependencyKind::Dependent => continue,
            _ if !is_float => "other kinds than dependent are for floating point variables only",
            DependencyKind::Constant => continue,
            _ if list.at_initialisation => {
                "at initialisation, the kinds are dependent and constant only"
            }
            _ => continue,
        };
        let found = format!("{subject} has dependenciesKind {kind}");
        report(checker, unknown.line, found, rule, "use dependent");
        break;
    }
}

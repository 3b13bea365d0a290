//! Value references, aliases and derivatives: variables that refer to each other.

use std::collections::{BTreeMap, HashSet};

use super::variables::subject;
use super::{Checker, repeated};
use crate::description::FmiVersion;
use crate::problem::Topic;
use crate::variable::{Causality, DataType, Initial, Variability, Variable};

pub(super) fn check(checker: &mut Checker<'_>) {
    match checker.version {
        FmiVersion::V2 => aliases(checker),
        FmiVersion::V3 => unique_references(checker),
    }
    derivatives(checker);
    previous_values(checker);
}

fn unique_references(checker: &mut Checker<'_>) {
    let variables = &checker.description.variables;
    for (again, first) in repeated(variables, |variable| variable.value_reference) {
        checker.error(
            Topic::Variables,
            again.line,
            format!(
                "{} has the value reference {} of \"{}\" (line {})",
                subject(again),
                again.value_reference,
                first.name,
                first.line.0
            ),
            "value references must be unique",
            "give it another one, or make it an <Alias>",
        );
    }
}

/// Variables of one base type with one value reference are aliases (2.0); enumerations are integers.
fn aliases(checker: &mut Checker<'_>) {
    let mut sets: BTreeMap<(u32, &str), Vec<&Variable>> = BTreeMap::new();
    for variable in &checker.description.variables {
        let base = match variable.data_type {
            DataType::Enumeration => DataType::Int32.name(),
            other => other.name(),
        };
        sets.entry((variable.value_reference, base)).or_default().push(variable);
    }
    for set in sets.values().filter(|set| set.len() > 1) {
        alias_set(checker, set);
    }
}

fn alias_set(checker: &mut Checker<'_>, set: &[&Variable]) {
    let Some((first, others)) = set.split_first() else { return };
    for other in others {
        for (what, rule, way_out) in alias_faults(checker, first, other) {
            report_alias(checker, first, other, &what, rule, way_out);
        }
    }
    let settable = set.iter().filter(|variable| is_settable(variable) && !is_constant(variable));
    for variable in settable.skip(1) {
        let rule =
            "at most one of several aliases may be an input, a parameter or have a start value";
        let way_out = "give it another value reference, or make it local without start value";
        report_alias(checker, first, variable, "can be set, too", rule, way_out);
    }
}

fn report_alias(
    checker: &mut Checker<'_>,
    first: &Variable,
    variable: &Variable,
    what: &str,
    rule: &str,
    way_out: &str,
) {
    let found = format!(
        "{} shares the value reference {} with \"{}\" (line {}) and {what}",
        subject(variable),
        variable.value_reference,
        first.name,
        first.line.0
    );
    checker.error(Topic::Variables, variable.line, found, rule, way_out);
}

/// What keeps two variables from being aliases: what was found, the rule, the way out.
fn alias_faults(
    checker: &Checker<'_>,
    first: &Variable,
    other: &Variable,
) -> Vec<(String, &'static str, &'static str)> {
    let (own, firsts) = (checker.properties(other), checker.properties(first));
    let mut faults = Vec::new();
    if own.unit != firsts.unit {
        let name = |unit: Option<String>| unit.unwrap_or_else(|| "none".to_owned());
        let what = format!("has the unit {}, not {}", name(own.unit), name(firsts.unit));
        faults.push((what, "aliases must have the same unit", "correct one unit"));
    }
    let relative = |relative: Option<bool>| relative.unwrap_or(false);
    if relative(own.relative_quantity) != relative(firsts.relative_quantity) {
        let what = "has another relativeQuantity".to_owned();
        faults.push((what, "aliases must have the same relativeQuantity", "correct one"));
    }
    match (is_constant(first), is_constant(other)) {
        (true, true) if first.start != other.start => {
            let what = "has another start value".to_owned();
            faults.push((what, "constant aliases must have the same start value", "correct one"));
        }
        (a, b) if a != b => {
            let what = "one of the two is constant".to_owned();
            let rule = "either all or none of the aliases must be constant";
            faults.push((what, rule, "separate them"));
        }
        _ => {}
    }
    faults
}

fn is_constant(variable: &Variable) -> bool {
    variable.variability(FmiVersion::V2) == Variability::Constant
}

/// Whether the importer may set the variable before or during a run.
fn is_settable(variable: &Variable) -> bool {
    let initial = variable.initial(FmiVersion::V2);
    matches!(variable.causality, Causality::Parameter | Causality::Input)
        || matches!(initial, Some(Initial::Exact | Initial::Approx))
}

fn derivatives(checker: &mut Checker<'_>) {
    let description = checker.description;
    let mut states = HashSet::new();
    for variable in &description.variables {
        let Some(reference) = variable.derivative else { continue };
        let rule = match checker.referenced(reference) {
            None if checker.version == FmiVersion::V2 => {
                "there is no variable at that position (counted from 1)"
            }
            None => "there is no variable with that value reference",
            Some(state) if std::ptr::eq(state, variable) => "a variable is not its own derivative",
            Some(state) if !state.data_type.is_float() => {
                "only floating point variables have derivatives"
            }
            Some(state) => {
                states.insert(state.name.as_str());
                continue;
            }
        };
        let found = format!("{} has derivative=\"{reference}\"", subject(variable));
        let way_out = "refer to the variable it is the derivative of, or remove the attribute";
        checker.error(Topic::Variables, variable.line, found, rule, way_out);
    }
    for variable in description.variables.iter().filter(|v| v.reinit.is_some()) {
        if !states.contains(variable.name.as_str()) {
            let found = format!("{} states reinit", subject(variable));
            let rule = "only continuous states may: variables whose derivative is there";
            let way_out = "remove the attribute";
            checker.error(Topic::Variables, variable.line, found, rule, way_out);
        }
    }
}

/// `previous` (3.0): clocked, discrete, of the same type, not itself, not an input.
fn previous_values(checker: &mut Checker<'_>) {
    let description = checker.description;
    for variable in &description.variables {
        let Some(reference) = variable.previous else { continue };
        let is_discrete = |v: &Variable| v.variability(FmiVersion::V3) == Variability::Discrete;
        let fits = checker.referenced(reference).is_some_and(|previous| {
            !std::ptr::eq(previous, variable)
                && previous.data_type == variable.data_type
                && is_discrete(previous)
                && previous.causality != Causality::Input
        });
        if !fits || variable.clocks.is_empty() || !is_discrete(variable) {
            let found = format!("{} has previous=\"{reference}\"", subject(variable));
            let rule = "a clocked discrete variable refers to another discrete variable of its type \
                        that is no input";
            checker.error(Topic::Variables, variable.line, found, rule, "correct the reference");
        }
    }
}

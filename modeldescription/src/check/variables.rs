//! `<ModelVariables>`: each variable by itself.

use super::{Checker, types};
use crate::description::FmiVersion;
use crate::problem::Topic;
use crate::variable::{
    Causality, DataType, Dimension, Initial, Number, Properties, Start, Variability, Variable,
    allowed_initials,
};

pub(super) fn check(checker: &mut Checker<'_>) {
    let description = checker.description;
    for variable in &description.variables {
        let properties = checker.properties(variable);
        role(checker, variable);
        start_presence(checker, variable);
        declared_type(checker, variable);
        let subject = subject(variable);
        types::shared(
            checker,
            Topic::Variables,
            variable.line,
            &subject,
            &own(variable, &properties),
        );
        start_values(checker, variable, &properties);
        attributes_of_some(checker, variable);
        for alias in &variable.aliases {
            let subject = format!("alias \"{}\"", alias.name);
            let (display, unit) = (alias.display_unit.as_deref(), properties.unit.as_deref());
            types::display_unit(checker, Topic::Variables, variable.line, &subject, display, unit);
        }
        dimensions(checker, variable);
        clock(checker, variable, &properties);
    }
    independent(checker);
}

pub(super) fn subject(variable: &Variable) -> String {
    format!("variable \"{}\"", variable.name)
}

/// What the variable itself states, completed by its type where rules join two attributes.
fn own(variable: &Variable, all: &Properties) -> Properties {
    let own = &variable.properties;
    let bounded = own.min.is_some() || own.max.is_some();
    Properties {
        unit: own.unit.clone().or_else(|| own.display_unit.as_ref().and(all.unit.clone())),
        display_unit: own.display_unit.clone(),
        min: all.min.filter(|_| bounded),
        max: all.max.filter(|_| bounded),
        nominal: own.nominal,
        ..Properties::default()
    }
}

fn error(checker: &mut Checker<'_>, variable: &Variable, what: &str, rule: &str, way_out: &str) {
    let found = format!("{} {what}", subject(variable));
    checker.error(Topic::Variables, variable.line, found, rule, way_out);
}

/// Causality, variability and initial.
fn role(checker: &mut Checker<'_>, variable: &Variable) {
    let version = checker.version;
    let causality = variable.causality;
    let variability = variable.variability(version);
    let by_default = match variable.stated_variability {
        Some(_) => "",
        None => " (the default)",
    };
    if variability == Variability::Continuous && !variable.data_type.is_float() {
        let element = variable.data_type.element(version).unwrap_or(variable.data_type.name());
        let what = format!("of type {element} has variability=\"continuous\"{by_default}");
        let way_out = "state variability=\"discrete\", \"tunable\", \"fixed\" or \"constant\"";
        error(checker, variable, &what, "only floating point variables are continuous", way_out);
    }
    let Some(allowed) = allowed_initials(causality, variability) else {
        let what =
            format!("has causality=\"{causality}\" and variability=\"{variability}\"{by_default}");
        let rule = format!("causality {causality} allows variability {}", variabilities(causality));
        error(checker, variable, &what, &rule, "correct one of them");
        return;
    };
    initial(checker, variable, allowed);
}

/// The variabilities that a causality allows.
fn variabilities(causality: Causality) -> String {
    let allowed = Variability::ALL.iter().filter(|v| allowed_initials(causality, **v).is_some());
    allowed.map(|variability| variability.name()).collect::<Vec<_>>().join(", ")
}

fn initial(checker: &mut Checker<'_>, variable: &Variable, allowed: &[Initial]) {
    let Some(stated) = variable.stated_initial else { return };
    let what = format!("has initial=\"{stated}\"");
    let never = match checker.version {
        FmiVersion::V2 => matches!(variable.causality, Causality::Input | Causality::Independent),
        FmiVersion::V3 => variable.causality == Causality::Independent,
    };
    if never {
        let rule = format!("causality {} must not state initial", variable.causality);
        error(checker, variable, &what, &rule, "remove the attribute");
    } else if !allowed.contains(&stated) {
        let names: Vec<&str> = allowed.iter().map(|initial| initial.name()).collect();
        let rule = format!(
            "causality {} with variability {} allows initial {}",
            variable.causality,
            variable.variability(checker.version),
            names.join(", ")
        );
        error(checker, variable, &what, &rule, "correct or remove the attribute");
    }
}

/// Whether a start value must, may or must not be there.
fn start_presence(checker: &mut Checker<'_>, variable: &Variable) {
    if variable.data_type == DataType::Clock {
        return;
    }
    let version = checker.version;
    let initial = variable.stated_initial.or_else(|| variable.initial(version));
    let because = match (variable.causality, variable.variability(version), initial) {
        (Causality::Independent, ..) => "causality independent",
        (Causality::Input, ..) => "causality input",
        (Causality::Parameter, ..) => "causality parameter",
        (Causality::StructuralParameter, ..) => "causality structuralParameter",
        (_, Variability::Constant, _) => "variability constant",
        (_, _, Some(Initial::Exact)) => "initial exact",
        (_, _, Some(Initial::Approx)) => "initial approx",
        (_, _, Some(Initial::Calculated)) => "initial calculated",
        (_, _, None) => return,
    };
    let forbidden = matches!(because, "causality independent" | "initial calculated");
    match (&variable.start, forbidden) {
        (Some(_), true) => {
            let rule = format!("{because} must have no start value");
            error(checker, variable, "has a start value", &rule, "remove it, or correct initial");
        }
        (None, false) => {
            let rule = format!("{because} must have a start value");
            error(checker, variable, "has no start value", &rule, "add it");
        }
        _ => {}
    }
}

fn declared_type(checker: &mut Checker<'_>, variable: &Variable) {
    let description = checker.description;
    let Some(name) = &variable.declared_type else {
        if variable.data_type == DataType::Enumeration {
            let rule = "an enumeration must name the type that has its items";
            error(checker, variable, "has no declaredType", rule, "add it");
        }
        return;
    };
    let what = format!("has declaredType=\"{name}\"");
    match checker.declared_type(variable) {
        None => {
            let rule = "the type must be defined in <TypeDefinitions>";
            error(checker, variable, &what, rule, "define it or correct its name");
        }
        Some(definition) if definition.data_type != variable.data_type => {
            let element = |data_type: DataType| {
                data_type.element(description.fmi_version).unwrap_or(data_type.name())
            };
            let rule = format!(
                "the type is of {}, the variable of {}",
                element(definition.data_type),
                element(variable.data_type)
            );
            error(checker, variable, &what, &rule, "choose a type of the same kind");
        }
        Some(_) => {}
    }
}

/// Number of start values, bounds, items.
fn start_values(checker: &mut Checker<'_>, variable: &Variable, properties: &Properties) {
    let Some(start) = &variable.start else { return };
    let count = start.len();
    match size(checker, variable) {
        None if count != 1 => {
            let what = format!("has {count} start values");
            error(checker, variable, &what, "a scalar has one", "give one value");
        }
        Some(size) if count != 1 && u64::try_from(count) != Ok(size) => {
            let what = format!("has {count} start values");
            let rule = format!("an array of {size} elements has {size} of them, or one for all");
            error(checker, variable, &what, &rule, "correct their number");
        }
        _ => {}
    }
    let (min, max) = (properties.min, properties.max);
    for value in start.numbers().unwrap_or_default() {
        let below = min.is_some_and(|min| less(value, min));
        let above = max.is_some_and(|max| less(max, value));
        if below || above {
            let what = format!("has start=\"{}\"", value.as_f64());
            let bound =
                |bound: Option<Number>| bound.map_or("…".to_owned(), |b| b.as_f64().to_string());
            let rule = format!("it must lie from {} to {}", bound(min), bound(max));
            error(checker, variable, &what, &rule, "correct the start value or the bounds");
            break;
        }
    }
    item(checker, variable, start);
}

fn less(a: Number, b: Number) -> bool {
    match (a, b) {
        (Number::Integer(a), Number::Integer(b)) => a < b,
        _ => a.as_f64() < b.as_f64(),
    }
}

/// Number of start values an array has; None for scalars. Sizes that cannot be resolved are reported
/// at the dimension, so that any number will do here.
fn size(checker: &Checker<'_>, variable: &Variable) -> Option<u64> {
    if variable.dimensions.is_empty() {
        return None;
    }
    let of_dimension = |dimension: &Dimension| match dimension {
        Dimension::Size(size) => Some(*size),
        Dimension::Parameter(reference) => match &checker.referenced(*reference)?.start {
            Some(Start::Integer(values)) => u64::try_from(*values.first()?).ok(),
            _ => None,
        },
    };
    let count = u64::try_from(variable.start.as_ref()?.len()).ok();
    let product = variable
        .dimensions
        .iter()
        .try_fold(1_u64, |product, dimension| product.checked_mul(of_dimension(dimension)?));
    product.or(count)
}

/// The start value of an enumeration must be one of the items.
fn item(checker: &mut Checker<'_>, variable: &Variable, start: &Start) {
    let (Some(definition), Start::Integer(values)) = (checker.declared_type(variable), start)
    else {
        return;
    };
    if variable.data_type != DataType::Enumeration || definition.items.is_empty() {
        return;
    }
    let known = |value: i128| definition.items.iter().any(|item| i128::from(item.value) == value);
    if let Some(value) = values.iter().copied().find(|value| !known(*value)) {
        let what = format!("has start=\"{value}\"");
        let rule = format!("it must be the value of an item of \"{}\"", definition.name);
        error(checker, variable, &what, &rule, "choose one of the items");
    }
}

/// Attributes that only some variables may have.
fn attributes_of_some(checker: &mut Checker<'_>, variable: &Variable) {
    let multiple = variable.can_handle_multiple_set_per_time_instant;
    if multiple.is_some() && variable.causality != Causality::Input {
        let what = "states canHandleMultipleSetPerTimeInstant";
        error(checker, variable, what, "only inputs may", "remove the attribute");
    }
    if variable.intermediate_update == Some(true) && variable.causality == Causality::Parameter {
        let what = "has intermediateUpdate=\"true\"";
        error(checker, variable, what, "parameters must not", "remove the attribute");
    }
}

fn dimensions(checker: &mut Checker<'_>, variable: &Variable) {
    if variable.causality == Causality::StructuralParameter && !variable.dimensions.is_empty() {
        let rule = "a structural parameter is a scalar";
        error(checker, variable, "has dimensions", rule, "remove them");
    }
    for dimension in &variable.dimensions {
        let reference = match dimension {
            Dimension::Size(0) => {
                let rule = "the size of a dimension must be positive";
                error(checker, variable, "has a dimension of size 0", rule, "correct it");
                continue;
            }
            Dimension::Size(_) => continue,
            Dimension::Parameter(reference) => *reference,
        };
        let size = checker.referenced(reference);
        let is_size = size.is_some_and(|size| {
            let start = match &size.start {
                Some(Start::Integer(values)) => values.first().copied().unwrap_or(0),
                _ => 0,
            };
            size.causality == Causality::StructuralParameter
                && size.data_type == DataType::UInt64
                && start > 0
        });
        if !is_size {
            let what = format!("has a dimension with valueReference=\"{reference}\"");
            let rule =
                "it must be a structural parameter of type UInt64 with a positive start value";
            error(checker, variable, &what, rule, "correct the reference or that variable");
        }
    }
}

const INTERVALS: [&str; 6] = ["constant", "fixed", "tunable", "changing", "countdown", "triggered"];

fn clock(checker: &mut Checker<'_>, variable: &Variable, properties: &Properties) {
    if variable.data_type == DataType::Clock {
        let stated = properties.clock.as_ref().and_then(|c| c.interval_variability.as_deref());
        if !stated.is_some_and(|interval| INTERVALS.contains(&interval)) {
            let what = format!("has intervalVariability=\"{}\"", stated.unwrap_or_default());
            let rule = format!("a clock must have one of {}", INTERVALS.join(", "));
            error(checker, variable, &what, &rule, "correct it");
        }
        let allowed = [Causality::Input, Causality::Output, Causality::Local];
        if !allowed.contains(&variable.causality) {
            let what = format!("has causality=\"{}\"", variable.causality);
            error(checker, variable, &what, "a clock is input, output or local", "correct it");
        }
    }
    for reference in &variable.clocks {
        let known = checker.referenced(*reference);
        if !known.is_some_and(|known| known.data_type == DataType::Clock) {
            let what = format!("has clocks=\"{reference}\"");
            let rule = "it must list value references of clocks";
            error(checker, variable, &what, rule, "correct the reference");
        }
    }
}

/// At most (2.0) or exactly (3.0) one independent variable, and that a float.
fn independent(checker: &mut Checker<'_>) {
    let description = checker.description;
    let is_independent = |v: &&Variable| v.causality == Causality::Independent;
    let mut independents = description.variables.iter().filter(is_independent);
    let first = independents.next();
    for variable in independents {
        let rule = "at most one variable may be";
        error(checker, variable, "is a second independent variable", rule, "make it local");
    }
    match (first, checker.version) {
        (Some(variable), _) if !variable.data_type.is_float() => {
            let what = format!("is independent and of type {}", variable.data_type);
            let rule = "the independent variable must be a floating point variable";
            error(checker, variable, &what, rule, "correct its type");
        }
        (None, FmiVersion::V3) => checker.error(
            Topic::Variables,
            description.line,
            "no variable has causality=\"independent\"".to_owned(),
            "exactly one variable must be independent",
            "add the variable time",
        ),
        _ => {}
    }
}

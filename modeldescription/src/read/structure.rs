//! Reads `<ModelStructure>`.

use super::values::{Attributes, Context, parse_integer};
use crate::description::{FmiVersion, Line};
use crate::structure::{DependencyKind, ModelStructure, Unknown};

pub(super) fn structure(context: &mut Context, at: Attributes<'_>) -> ModelStructure {
    match context.version {
        FmiVersion::V2 => structure_2(context, at),
        FmiVersion::V3 => structure_3(context, at),
    }
}

/// In 2.0, lists of `<Unknown index="…">`.
fn structure_2(context: &mut Context, at: Attributes<'_>) -> ModelStructure {
    context.expect(at, &[], &["Outputs", "Derivatives", "InitialUnknowns"]);
    let mut read = ModelStructure { line: Line(at.element.line), ..ModelStructure::default() };
    for element in &at.element.children {
        let list = match element.name.as_str() {
            "Outputs" => &mut read.outputs,
            "Derivatives" => &mut read.derivatives,
            "InitialUnknowns" => &mut read.initial_unknowns,
            _ => continue,
        };
        let at = Attributes { element, topic: at.topic };
        context.expect(at, &[], &["Unknown*"]);
        context.expect_some(at);
        for child in element.children.iter().filter(|child| child.name == "Unknown") {
            list.push(unknown(context, Attributes { element: child, topic: at.topic }, "index"));
        }
    }
    read
}

/// In 3.0, elements with a value reference, without lists around them.
fn structure_3(context: &mut Context, at: Attributes<'_>) -> ModelStructure {
    let children = [
        "Output*",
        "ContinuousStateDerivative*",
        "ClockedState*",
        "InitialUnknown*",
        "EventIndicator*",
    ];
    context.expect(at, &[], &children);
    let mut read = ModelStructure { line: Line(at.element.line), ..ModelStructure::default() };
    for element in &at.element.children {
        let list = match element.name.as_str() {
            "Output" => &mut read.outputs,
            "ContinuousStateDerivative" => &mut read.derivatives,
            "ClockedState" => &mut read.clocked_states,
            "InitialUnknown" => &mut read.initial_unknowns,
            "EventIndicator" => &mut read.event_indicators,
            _ => continue,
        };
        list.push(unknown(context, Attributes { element, topic: at.topic }, "valueReference"));
    }
    read
}

fn unknown(context: &mut Context, at: Attributes<'_>, reference: &str) -> Unknown {
    let children: &[&str] = match context.version {
        FmiVersion::V2 => &[],
        FmiVersion::V3 => &["Annotations"],
    };
    context.expect(at, &[reference, "dependencies", "dependenciesKind"], children);
    Unknown {
        variable: context.required_integer(at, reference),
        dependencies: context.list(at, "dependencies", "unsigned integers", parse_integer),
        dependency_kinds: context.list(
            at,
            "dependenciesKind",
            "dependent, constant, fixed, tunable, discrete",
            DependencyKind::from_name,
        ),
        line: Line(at.element.line),
    }
}

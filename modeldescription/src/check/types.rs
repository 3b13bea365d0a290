//! `<TypeDefinitions>`, and the attributes that types and variables share.

use std::collections::HashMap;

use super::{Checker, repeated};
use crate::description::{FmiVersion, Line, TypeDefinition};
use crate::problem::Topic;
use crate::variable::{DataType, Properties};

pub(super) fn check(checker: &mut Checker<'_>) {
    let description = checker.description;
    for (again, first) in repeated(&description.types, |definition| definition.name.as_str()) {
        checker.error(
            Topic::Types,
            again.line,
            format!("type \"{}\" is defined twice, first at line {}", again.name, first.line.0),
            "names of types must be unique",
            "remove one",
        );
    }
    let variables: HashMap<&str, Line> =
        description.variables.iter().map(|v| (v.name.as_str(), v.line)).collect();
    for definition in &description.types {
        if let Some(line) = variables.get(definition.name.as_str()) {
            checker.error(
                Topic::Types,
                definition.line,
                format!(
                    "type \"{}\" has the name of the variable at line {}",
                    definition.name, line.0
                ),
                "names of types must differ from all names of variables",
                "rename the type",
            );
        }
        let subject = format!("type \"{}\"", definition.name);
        shared(checker, Topic::Types, definition.line, &subject, &definition.properties);
        if definition.data_type == DataType::Enumeration {
            items(checker, definition);
        }
    }
}

fn items(checker: &mut Checker<'_>, definition: &TypeDefinition) {
    let mut error = |found: String, rule: &str| {
        let found = format!("enumeration \"{}\" {found}", definition.name);
        checker.error(Topic::Types, definition.line, found, rule, "correct the items");
    };
    if definition.items.is_empty() {
        error("has no items".to_owned(), "at least one <Item> is required");
    }
    for (again, _) in repeated(&definition.items, |item| item.name.as_str()) {
        error(format!("has the item \"{}\" twice", again.name), "names must be unique");
    }
    for (again, first) in repeated(&definition.items, |item| item.value) {
        let found = format!("gives {} to \"{}\" and \"{}\"", again.value, first.name, again.name);
        error(found, "values must be unique");
    }
}

/// Unit, display unit, bounds and nominal value of a type or a variable; `properties` are its own.
pub(super) fn shared(
    checker: &mut Checker<'_>,
    topic: Topic,
    line: Line,
    subject: &str,
    properties: &Properties,
) {
    unit(checker, topic, line, subject, properties);
    if let (Some(min), Some(max)) = (properties.min, properties.max)
        && min.as_f64() > max.as_f64()
    {
        checker.error(
            topic,
            line,
            format!("{subject} has min=\"{}\" and max=\"{}\"", min.as_f64(), max.as_f64()),
            "min must not exceed max",
            "exchange or correct them",
        );
    }
    if let Some(nominal) = properties.nominal.filter(|nominal| nominal.is_nan() || *nominal <= 0.0)
    {
        let found = format!("{subject} has nominal=\"{nominal}\"");
        let rule = "the nominal value must be positive";
        let way_out = "give the typical magnitude of the values";
        match checker.version {
            FmiVersion::V2 => checker.error(topic, line, found, rule, way_out),
            FmiVersion::V3 => checker.warning(topic, line, found, rule, way_out),
        }
    }
}

fn unit(
    checker: &mut Checker<'_>,
    topic: Topic,
    line: Line,
    subject: &str,
    properties: &Properties,
) {
    let unit = properties.unit.as_deref();
    let defined = unit.and_then(|name| checker.units.get(name).copied());
    if let (Some(name), None) = (unit, defined) {
        checker.error(
            topic,
            line,
            format!("{subject} has unit=\"{name}\""),
            "the unit must be defined in <UnitDefinitions>",
            "define it or correct its name",
        );
    }
    display_unit(checker, topic, line, subject, properties.display_unit.as_deref(), unit);
}

/// The display unit must be one of the unit's.
pub(super) fn display_unit(
    checker: &mut Checker<'_>,
    topic: Topic,
    line: Line,
    subject: &str,
    display_unit: Option<&str>,
    unit: Option<&str>,
) {
    let Some(display) = display_unit else { return };
    let found = format!("{subject} has displayUnit=\"{display}\"");
    let Some(unit) = unit else {
        let rule = "a display unit needs a unit";
        checker.error(topic, line, found, rule, "give the unit or remove the display unit");
        return;
    };
    let defined = checker.units.get(unit).copied();
    let known = defined.is_some_and(|u| u.display_units.iter().any(|d| d.name == display));
    // FMI 2.0 lets a unit be shown in itself only if it is listed, and most importers insist.
    if defined.is_some() && !known {
        checker.error(
            topic,
            line,
            found,
            format!("it must be a <DisplayUnit> of the unit \"{unit}\""),
            "define it there or correct its name",
        );
    }
}

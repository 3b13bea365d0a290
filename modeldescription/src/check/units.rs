//! `<UnitDefinitions>`.

use super::{Checker, repeated};
use crate::description::{DisplayUnit, Line, Unit};
use crate::problem::Topic;

pub(super) fn check(checker: &mut Checker<'_>) {
    let units = &checker.description.units;
    for (again, first) in repeated(units, |unit| unit.name.as_str()) {
        checker.error(
            Topic::Units,
            again.line,
            format!("unit \"{}\" is defined twice, first at line {}", again.name, first.line.0),
            "names of units must be unique",
            "remove one",
        );
    }
    for unit in units {
        one(checker, unit);
    }
}

fn one(checker: &mut Checker<'_>, unit: &Unit) {
    if unit.name.is_empty() {
        let found = "a unit has an empty name".to_owned();
        checker.error(Topic::Units, unit.line, found, "variables refer to its name", "name it");
    }
    if let Some(base) = &unit.base {
        let found = format!("unit \"{}\"", unit.name);
        conversion(checker, unit.line, &found, base.factor, base.offset);
    }
    for (again, _) in repeated(&unit.display_units, |display| display.name.as_str()) {
        checker.error(
            Topic::Units,
            again.line,
            format!("display unit \"{}\" of \"{}\" is defined twice", again.name, unit.name),
            "names of display units must be unique within their unit",
            "remove one",
        );
    }
    for display in &unit.display_units {
        display_unit(checker, unit, display);
    }
}

fn display_unit(checker: &mut Checker<'_>, unit: &Unit, display: &DisplayUnit) {
    let found = format!("display unit \"{}\" of \"{}\"", display.name, unit.name);
    conversion(checker, display.line, &found, display.factor, display.offset);
    if display.inverse && display.offset != 0.0 {
        checker.error(
            Topic::Units,
            display.line,
            format!("{found} has inverse=\"true\" and offset=\"{}\"", display.offset),
            "inverse is allowed without an offset only",
            "remove one of them",
        );
    }
}

fn conversion(checker: &mut Checker<'_>, line: Line, found: &str, factor: f64, offset: f64) {
    if factor == 0.0 || !factor.is_finite() {
        checker.error(
            Topic::Units,
            line,
            format!("{found} has factor=\"{factor}\""),
            "values could not be converted back",
            "give a finite factor other than 0",
        );
    }
    if !offset.is_finite() {
        let found = format!("{found} has offset=\"{offset}\"");
        checker.error(Topic::Units, line, found, "the offset must be finite", "correct it");
    }
}

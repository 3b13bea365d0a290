//! What all parts of the check share: the blueprint, the components, and the problems so far.

use std::collections::BTreeSet;

use model::{Registry, Unit};

use super::origin::Place;
use super::{Blueprint, Value, measure};
use crate::Problem;

/// The check of a blueprint as far as it has come.
pub(super) struct Checker<'a> {
    pub(super) blueprint: &'a Blueprint,
    pub(super) registry: Registry,
    pub(super) problems: Vec<Problem>,
    /// Keys that have a problem.
    keys: BTreeSet<String>,
}

impl<'a> Checker<'a> {
    /// The check begins with the problems that were found while reading.
    pub(super) fn new(blueprint: &'a Blueprint, registry: Registry) -> Self {
        let mut checker = Self { blueprint, registry, problems: Vec::new(), keys: BTreeSet::new() };
        for (key, problem) in &blueprint.origin.problems {
            checker.keys.insert(key.clone());
            let mut problem = problem.clone();
            problem.place = shown_place(blueprint, registry, key);
            checker.problems.push(problem);
        }
        checker
    }

    /// Adds a problem.
    pub(super) fn report(
        &mut self,
        place: &Place,
        value: &str,
        rule: impl Into<String>,
        way_out: impl Into<String>,
    ) {
        let origin = &self.blueprint.origin;
        let mut problem = Problem::new(origin.name(), rule, way_out).at(&place.shown).value(value);
        problem.line = origin.line(&place.key);
        self.problems.push(problem);
        self.keys.insert(place.key.clone());
    }

    /// Whether this very key has a problem already.
    pub(super) fn is_spoilt(&self, key: &str) -> bool {
        self.keys.contains(key)
    }

    /// Whether any key has one.
    pub(super) fn has_problems(&self) -> bool {
        !self.problems.is_empty()
    }

    /// One finite number in `unit`; problems are reported.
    pub(super) fn number(&mut self, place: &Place, value: &Value, unit: &str) -> Option<f64> {
        if self.is_spoilt(&place.key) {
            return None;
        }
        let number = match value {
            Value::Number(number) => *number,
            Value::Text(text) => {
                // A unit of the axis that cannot be read has been reported at the axis.
                let target = Unit::parse(unit).ok()?;
                match measure::in_unit(text, &target, unit) {
                    Ok(number) => number,
                    Err((rule, way_out)) => {
                        self.report(place, &format!("{text:?}"), rule, way_out);
                        return None;
                    }
                }
            }
            Value::List(items) => {
                let shown = format!("{} values", items.len());
                let rule = "must be one value, not a list";
                self.report(place, &shown, rule, "leave out the brackets");
                return None;
            }
        };
        if number.is_finite() {
            return Some(number);
        }
        let way_out = format!("give a finite number in {unit}");
        self.report(place, &number.to_string(), "is not a finite number", way_out);
        None
    }

    /// Whether `value` is from `min` to `max`; a problem is reported.
    pub(super) fn is_within(
        &mut self,
        place: &Place,
        value: f64,
        (min, max): (f64, f64),
        unit: &str,
    ) -> bool {
        let (rule, way_out) = if value < min {
            (format!("must be at least {}", measure::shown(min, unit)), "give a greater value")
        } else if value > max {
            (format!("must be at most {}", measure::shown(max, unit)), "give a smaller value")
        } else {
            return true;
        };
        self.report(place, &measure::shown(value, unit), rule, way_out);
        false
    }

    /// Checks that a name may stand in an FMI variable name. A name that is not given is none.
    pub(super) fn check_name(&mut self, place: &Place, name: &str) {
        if self.is_spoilt(&place.key) {
            return;
        }
        let mut letters = name.chars();
        let starts_well = letters.next().is_some_and(|c| c.is_ascii_alphabetic());
        if starts_well && letters.all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return;
        }
        let way_out = "use the letters A to Z and a to z, digits and _ only, a letter first";
        self.report(place, &format!("{name:?}"), "is no name that FMI tools accept", way_out);
    }
}

/// A key path with the component's name, which reading alone does not know where it is the default.
fn shown_place(blueprint: &Blueprint, registry: Registry, key: &str) -> String {
    for (axis, a) in blueprint.axes.iter().zip(1..) {
        for (given, c) in axis.components.iter().zip(1..) {
            let Some(rest) = key.strip_prefix(&format!("axis[{a}].component[{c}].")) else {
                continue;
            };
            let declared = registry.iter().map(|component| component.declaration());
            let default = declared.filter(|d| d.kind == given.kind).map(|d| d.name).next();
            let name = Some(given.name.as_str()).filter(|name| !name.is_empty()).or(default);
            if let Some(name) = name {
                return format!("axis[{a}].{name}.{rest}");
            }
        }
    }
    for (coupling, k) in blueprint.couplings.iter().zip(1..) {
        let given = &coupling.component;
        if let Some(rest) = key.strip_prefix(&format!("coupling[{k}]."))
            && !given.name.is_empty()
        {
            return format!("coupling.{}.{rest}", given.name);
        }
    }
    key.to_string()
}

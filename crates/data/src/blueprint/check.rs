//! The check of a [`Blueprint`]: all problems, or a specification.

use std::collections::BTreeSet;

use model::{NodeSpec, Registry, SystemSpec, Unit};

use super::origin::Place;
use super::{Blueprint, CheckedBlueprint, Value, build, frame, measure};
use crate::{Problem, Problems};

/// Cells (8 bytes each) that a model may have: 128 MiB.
pub(super) const MOST_CELLS: usize = 1 << 24;

pub(super) fn check(
    blueprint: &Blueprint,
    registry: Registry,
) -> Result<CheckedBlueprint, Problems> {
    let mut checker = Checker { blueprint, registry, problems: Vec::new(), keys: BTreeSet::new() };
    for (key, problem) in &blueprint.origin.problems {
        checker.keys.insert(key.clone());
        let mut problem = problem.clone();
        problem.place = shown_place(blueprint, registry, key);
        checker.problems.push(problem);
    }
    let draft = frame::draft(&mut checker);
    let system = build::system(&mut checker, &draft);
    match system {
        Some(system) if checker.problems.is_empty() => Ok(CheckedBlueprint {
            blueprint: blueprint.clone(),
            spec: super::Spec(draft.spec),
            system,
        }),
        _ => Err(Problems::new(checker.problems)),
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

/// What is known of a blueprint while it is checked. Values that are wrong are replaced by harmless
/// ones, so that the rest can be checked too.
pub(super) struct Draft {
    pub(super) spec: SystemSpec,
    pub(super) axes: Vec<DraftAxis>,
    /// For each coupling of the specification: its place, and whether its values are those of the
    /// file.
    pub(super) couplings: Vec<(Place, bool)>,
}

/// Beside an axis of the specification.
#[derive(Default)]
pub(super) struct DraftAxis {
    /// For each component of the specification: its place in the file, and whether its values are
    /// those of the file.
    pub(super) components: Vec<(Place, bool)>,
    /// For each of these components, the unit that `{position}` stands for.
    pub(super) position_units: Vec<String>,
    /// Whether components are missing because their type is unknown.
    pub(super) has_gaps: bool,
}

/// A component of the draft.
pub(super) struct DraftNode {
    pub(super) node: NodeSpec,
    pub(super) is_clean: bool,
}

pub(super) struct Checker<'a> {
    pub(super) blueprint: &'a Blueprint,
    pub(super) registry: Registry,
    pub(super) problems: Vec<Problem>,
    /// Keys that have a problem.
    keys: BTreeSet<String>,
}

impl Checker<'_> {
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
                self.report(
                    place,
                    &shown,
                    "must be one value, not a list",
                    "leave out the brackets",
                );
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
}

//! The check of the components of an axis.

use model::{
    AxisSpec, Component, ComponentRef, Declaration, NodeSpec, Quantity, Shape, Within, unit_on_axis,
};

use super::checker::Checker;
use super::draft::{DraftAxis, DraftNode};
use super::origin::Place;
use super::{AxisBlueprint, ComponentBlueprint, TABLE, Value, measure, structure};
use crate::nearest::did_you_mean;

/// Keys of a component that are not quantities.
const KEYS: [&str; 6] = ["type", "name", "record", "enabled", "tolerance", "note"];

pub(super) fn chain<'a>(
    checker: &mut Checker<'_>,
    axis: &AxisBlueprint,
    place: &Place,
    spec: &mut AxisSpec,
    draft: &mut DraftAxis,
    position_unit_at: impl Fn(usize) -> &'a String,
) {
    for (given, number) in axis.components.iter().zip(1..) {
        spec.position_unit.clone_from(position_unit_at(number - 1));
        let key = place.child("component").item(number);
        if !given.name.is_empty() {
            checker.check_name(&key.child("name"), &given.name);
        }
        let Some(component) = find(checker, given, &key) else {
            draft.has_gaps = true;
            continue;
        };
        let declaration = component.declaration();
        if declaration.is_coupling() {
            draft.has_gaps = true;
            let way_out = "put it in a [[coupling]] section";
            let kind = format!("{:?}", given.kind);
            checker.report(&key.child("type"), &kind, "is no part of one axis", way_out);
            continue;
        }
        let mut name =
            if given.name.is_empty() { declaration.name } else { &given.name }.to_string();
        let place = key.shown_as(place, &name);
        if spec.components.iter().any(|other| other.name == name) {
            let way_out = "give each component of an axis its own, as in name = \"mode2\"";
            let shown = format!("{name:?}");
            let rule = "is the name of another component";
            checker.report(&place.child("name"), &shown, rule, way_out);
            // The rest is checked under a name that no file can give.
            name = format!("{name}#{number}");
        }
        let drafted = Member { given, declaration, place: &place, axis: spec }
            .draft(checker, component, name);
        spec.components.push(drafted.node);
        draft.components.push((place, drafted.is_clean));
        draft.position_units.push(spec.position_unit.clone());
    }
}

/// The component of the registry that is meant.
pub(super) fn find(
    checker: &mut Checker<'_>,
    given: &ComponentBlueprint,
    place: &Place,
) -> Option<&'static dyn Component> {
    let key = place.child("type");
    let registry = checker.registry;
    let found = registry.iter().find(|c| c.declaration().kind == given.kind);
    if found.is_none() && !checker.is_spoilt(&key.key) {
        let kinds: Vec<&str> = registry.iter().map(|c| c.declaration().kind).collect();
        let known = format!("known types are {}", kinds.join(", "));
        if given.kind.is_empty() {
            checker.report(&key, "", "is missing: a component has a type", known);
        } else {
            let near = did_you_mean(&given.kind, kinds.iter().copied());
            let rule = "is no type of component";
            checker.report(&key, &format!("{:?}", given.kind), rule, format!("{near}{known}"));
        }
    }
    found.copied()
}

/// A component as it is given, its declaration, and where it stands.
pub(super) struct Member<'a> {
    pub(super) given: &'a ComponentBlueprint,
    pub(super) declaration: &'static Declaration,
    pub(super) place: &'a Place,
    pub(super) axis: &'a AxisSpec,
}

impl Member<'_> {
    pub(super) fn draft(
        &self,
        checker: &mut Checker<'_>,
        component: &'static dyn Component,
        name: String,
    ) -> DraftNode {
        let before = checker.problems.len();
        self.check_keys(checker, component.takes_table());
        self.check_tolerances(checker);
        let counts = structure::counts(checker, self.given, self.declaration, self.place);
        let lengths = |index| counts.get(index).copied().flatten();
        let structure: Vec<f64> = counts
            .iter()
            .zip(self.declaration.structure)
            .map(|(count, setting)| count.unwrap_or(setting.start.unwrap_or(setting.min)))
            .collect();
        let mut values = Vec::new();
        for (index, quantity) in self.declaration.parameters.iter().enumerate() {
            let length = self.declaration.length(index, &structure);
            let wanted = match quantity.shape {
                Shape::Scalar => Some(1),
                Shape::Array(by) => lengths(by).map(|_| length),
            };
            let found = self.values_of(checker, quantity, wanted);
            let harmless = quantity.start.unwrap_or(0.0).max(quantity.min).min(quantity.max);
            values.extend((0..length).map(|k| found.get(k).copied().flatten().unwrap_or(harmless)));
        }
        let is_complete = counts.iter().all(Option::is_some);
        let component = self.with_table(checker, component, &structure, is_complete);
        let node = NodeSpec { component, name, structure, values, enabled: self.given.enabled };
        let is_clean = checker.problems.len() == before && !self.was_spoilt(checker);
        DraftNode { node, is_clean }
    }

    /// The component with its table, where it runs one and the structure is known.
    fn with_table(
        &self,
        checker: &mut Checker<'_>,
        component: &'static dyn Component,
        structure: &[f64],
        is_complete: bool,
    ) -> ComponentRef {
        let place = self.place.child(TABLE);
        if !component.takes_table() || checker.is_spoilt(&place.key) {
            return component.into();
        }
        let Some(Value::Text(name)) = self.given.get(TABLE) else {
            let way_out = "give the file of its learned table, as in \"hysteresis.npy\"";
            checker.report(&place, "", "is missing: this component runs a table", way_out);
            return component.into();
        };
        let shown = format!("{name:?}");
        let refusal = match checker.blueprint.table(name) {
            Ok(_) if !is_complete => return component.into(),
            Ok(table) => match component.with_table(structure, &table) {
                Ok(loaded) => return loaded,
                Err(text) => text,
            },
            Err((rule, way_out)) => format!("{rule}; {way_out}"),
        };
        let (rule, way_out) = refusal.rsplit_once("; ").unwrap_or((&refusal, ""));
        checker.report(&place, &shown, rule, way_out);
        component.into()
    }

    /// Whether a key of this component was wrong already when the file was read.
    fn was_spoilt(&self, checker: &Checker<'_>) -> bool {
        let mine = |key: &str| {
            key.strip_prefix(self.place.key.as_str()).is_some_and(|rest| rest.starts_with('.'))
        };
        checker.blueprint.origin.problems.iter().any(|(key, _)| mine(key))
    }

    /// Names of all structural settings and parameters.
    fn names(&self) -> Vec<&'static str> {
        let settings = self.declaration.structure.iter().map(|s| s.name);
        settings.chain(self.declaration.parameters.iter().map(|q| q.name)).collect()
    }

    fn check_keys(&self, checker: &mut Checker<'_>, takes_table: bool) {
        let mut known = self.names();
        known.extend(takes_table.then_some(TABLE));
        for (name, _) in &self.given.values {
            if known.contains(&name.as_str()) {
                continue;
            }
            let all = || known.iter().copied().chain(KEYS);
            let near = did_you_mean(name, all());
            let rule = format!("is no key of {}", self.declaration.kind);
            let way_out = format!("{near}known are {}", all().collect::<Vec<_>>().join(", "));
            checker.report(&self.place.child(name), "", rule, way_out);
        }
    }

    fn check_tolerances(&self, checker: &mut Checker<'_>) {
        let known: Vec<&str> = self.declaration.parameters.iter().map(|q| q.name).collect();
        for (name, relative) in &self.given.tolerance {
            let place = self.place.child("tolerance").child(name);
            if !known.contains(&name.as_str()) {
                let near = did_you_mean(name, known.iter().copied());
                let rule = format!("is no parameter of {}", self.declaration.kind);
                let way_out = format!("{near}parameters are {}", known.join(", "));
                checker.report(&place, "", rule, way_out);
            } else if !(relative.is_finite() && *relative >= 0.0) {
                let way_out = "give a relative standard deviation, as in 0.05";
                let rule = "must be finite and at least 0";
                checker.report(&place, &relative.to_string(), rule, way_out);
            }
        }
    }

    /// The values of a parameter, `None` for each that is wrong. `wanted` is how many there must
    /// be, `None` where that is not known.
    fn values_of(
        &self,
        checker: &mut Checker<'_>,
        quantity: &'static Quantity,
        wanted: Option<usize>,
    ) -> Vec<Option<f64>> {
        let place = self.place.child(quantity.name);
        if checker.is_spoilt(&place.key) {
            return Vec::new();
        }
        let unit = self.unit(quantity);
        let Some(value) = self.given.get(quantity.name) else {
            if quantity.start.is_none() && wanted != Some(0) {
                let rule = format!("is missing: {}", quantity.description);
                checker.report(&place, "", rule, format!("give it in {unit}"));
            }
            return Vec::new();
        };
        match (quantity.shape, value) {
            (Shape::Scalar, value) => vec![self.one(checker, quantity, &place, value, &unit)],
            (Shape::Array(by), Value::List(items)) => {
                self.check_length(checker, &place, items.len(), wanted, by);
                let items = items.iter().zip(1..);
                items
                    .map(|(item, k)| self.one(checker, quantity, &place.item(k), item, &unit))
                    .collect()
            }
            (Shape::Array(_), _) => {
                let way_out = "put the values in brackets, as in [0.1, 0.2]";
                checker.report(&place, "", "must be a list", way_out);
                Vec::new()
            }
        }
    }

    fn check_length(
        &self,
        checker: &mut Checker<'_>,
        place: &Place,
        found: usize,
        wanted: Option<usize>,
        setting: usize,
    ) {
        let Some(wanted) = wanted.filter(|wanted| *wanted != found) else { return };
        let name = self.declaration.structure.get(setting).map_or("", |s| s.name);
        let rule = format!("must have {wanted} values, as many as {name} and the other lists say");
        let way_out = format!("give {wanted} values here, or correct the others");
        checker.report(place, &format!("{found} values"), rule, way_out);
    }

    /// One number of a parameter.
    fn one(
        &self,
        checker: &mut Checker<'_>,
        quantity: &Quantity,
        place: &Place,
        value: &Value,
        unit: &str,
    ) -> Option<f64> {
        let number = checker.number(place, value, unit)?;
        let bounds = (quantity.min, quantity.max);
        // Bounds by structural settings are the component's to check.
        let (low, high) = self.axis.command_range;
        if quantity.within == Within::Commands && !(low..=high).contains(&number) {
            let [low, high, found] = [low, high, number].map(|value| measure::shown(value, unit));
            let rule = format!("is no command of this axis, which are {low} to {high}");
            let way_out = "give one of these, or widen min and max of the axis' command";
            checker.report(place, &found, rule, way_out);
            return None;
        }
        checker.is_within(place, number, bounds, unit).then_some(number)
    }

    /// The unit of a quantity on this axis.
    pub(super) fn unit(&self, quantity: &Quantity) -> String {
        unit_on_axis(quantity.unit, &self.axis.command_unit, &self.axis.position_unit)
    }
}

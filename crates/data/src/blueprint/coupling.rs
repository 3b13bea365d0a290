//! The check of what goes beyond an axis by itself: couplings, and inputs that components ask for.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use model::{
    AxisSpec, Connections, Conversion, CouplingSpec, DEMANDED_INPUTS, InputSpec, Kind, NodeSpec,
    Stage, SystemSpec, unit_on_axis,
};

use super::checker::Checker;
use super::component::{self, Member};
use super::origin::Place;
use super::{
    AxisBlueprint, CheckedBlueprint, ComponentBlueprint, CouplingBlueprint, SignalBlueprint, Value,
    signal,
};
use crate::nearest::did_you_mean;

impl CheckedBlueprint {
    /// The groups of axes that enabled couplings join, as indices from 0 in rising order.
    #[must_use]
    pub fn coupled_axes(&self) -> Vec<Vec<usize>> {
        let mut sets: Vec<Vec<usize>> = Vec::new();
        for coupling in self.spec().connections.couplings.iter().filter(|c| c.node.enabled) {
            let mut joined = coupling.axes.clone();
            let (touched, apart): (Vec<_>, Vec<_>) =
                sets.into_iter().partition(|set| set.iter().any(|axis| joined.contains(axis)));
            joined.extend(touched.into_iter().flatten());
            joined.sort_unstable();
            joined.dedup();
            sets = apart;
            sets.push(joined);
        }
        sets.sort();
        sets
    }

    /// The number of components of an axis in front of a coupling that acts on it.
    #[must_use]
    pub fn before_coupling(&self, coupling: &CouplingSpec, axis: usize) -> usize {
        self.spec().axes.get(axis).map_or(0, |axis| place_on(axis, coupling))
    }

    /// The units that `{command}` and `{position}` stand for in a coupling.
    #[must_use]
    pub fn coupling_units(&self, coupling: &CouplingSpec) -> [String; 2] {
        units(self.spec(), coupling)
    }
}

/// The number of components of an axis in front of a coupling that acts on it.
fn place_on(axis: &AxisSpec, coupling: &CouplingSpec) -> usize {
    let is_last = |node: &NodeSpec| match &coupling.after {
        Some(name) => node.name == *name,
        None => node.component.declaration().stage <= Stage::Mechanics,
    };
    axis.components.iter().rposition(is_last).map_or(0, |at| at + 1)
}

/// Whether motions stand on one side of it and positions on the other.
fn converts(conversion: Conversion) -> bool {
    matches!(conversion, Conversion::MotionToPosition | Conversion::PositionToMotion)
}

/// The unit of an axis' motion, where the blueprint gives one.
pub(super) fn motion_unit(
    checker: &mut Checker<'_>,
    axis: &AxisBlueprint,
    place: &Place,
) -> Option<String> {
    let place = place.child("motion");
    if axis.motion == SignalBlueprint::default() {
        return None;
    }
    signal::forbid(checker, &place, &axis.motion, &["name", "min", "max", "start"]);
    Some(signal::unit(checker, &place, &axis.motion))
}

/// The number of components in front of the optics, or the coordinator, of this axis; all where there
/// are none.
pub(super) fn optics_at(checker: &Checker<'_>, axis: &AxisBlueprint, name: &str) -> usize {
    let declared = |kind: &str| {
        let mut all = checker.registry.iter().map(|component| component.declaration());
        all.find(|declaration| declaration.kind == kind)
    };
    let turns = |coupling: &&CouplingBlueprint| {
        coupling.axes.iter().any(|other| other == name)
            && declared(&coupling.component.kind).is_some_and(|d| converts(d.conversion))
    };
    let optics = checker.blueprint.couplings.iter().find(turns);
    if optics.is_none() && axis.motion == SignalBlueprint::default() {
        return usize::MAX;
    }
    // Where optics are announced and not found, the rest is read as if they stood in their usual place.
    let after = optics.map_or("", |optics| &optics.after);
    let is_plant = checker.blueprint.kind == Kind::Plant;
    let is_last = |component: &ComponentBlueprint| {
        let declaration = declared(&component.kind);
        if after.is_empty() {
            return is_plant && declaration.is_some_and(|d| d.stage <= Stage::Mechanics);
        }
        let name = if component.name.is_empty() {
            declaration.map_or("", |d| d.name)
        } else {
            &component.name
        };
        name == after
    };
    // A component that is named and not there is reported at the coupling.
    let absent = if after.is_empty() { 0 } else { axis.components.len() };
    axis.components.iter().rposition(is_last).map_or(absent, |at| at + 1)
}

/// Adds the given inputs of an axis that its components ask for.
pub(super) fn axis_inputs(
    checker: &mut Checker<'_>,
    axis: &AxisBlueprint,
    place: &Place,
    spec: &AxisSpec,
    number: usize,
    aliases: &mut BTreeSet<String>,
    inputs: &mut Vec<InputSpec>,
) {
    for (key, signal) in [("force", &axis.force), ("disturbance", &axis.disturbance)] {
        let at = (format!("{key}[{number}]"), &*spec.position_unit);
        input(checker, &place.child(key), signal, key, at, aliases, inputs);
    }
}

/// Adds the given inputs of the model that its components ask for.
pub(super) fn system_inputs(
    checker: &mut Checker<'_>,
    aliases: &mut BTreeSet<String>,
    inputs: &mut Vec<InputSpec>,
) {
    let signal = &checker.blueprint.temperature;
    let (place, at) = (Place::new("temperature"), ("temperature".to_string(), "1"));
    input(checker, &place, signal, "temperature", at, aliases, inputs);
}

fn input(
    checker: &mut Checker<'_>,
    place: &Place,
    signal: &SignalBlueprint,
    name: &str,
    (variable, position): (String, &str),
    aliases: &mut BTreeSet<String>,
    inputs: &mut Vec<InputSpec>,
) {
    let demanded = DEMANDED_INPUTS.iter().find(|demanded| demanded.name == name);
    let (Some(demanded), false) = (demanded, *signal == SignalBlueprint::default()) else { return };
    if refused_in_controller(checker, place) {
        return;
    }
    signal::forbid(checker, place, signal, &["min", "max"]);
    let usual = unit_on_axis(demanded.unit, "1", position);
    let mut signal = signal.clone();
    if signal.unit.is_empty() {
        signal.unit.clone_from(&usual);
    }
    let unit = signal::unit(checker, place, &signal);
    let (Ok(parsed), Ok(own)) = (model::Unit::parse(&unit), model::Unit::parse(&usual)) else {
        return;
    };
    if !parsed.is_compatible(&own) {
        let rule = format!("does not measure the same as {usual}");
        let way_out = format!("give a unit that converts to {usual}");
        checker.report(&place.child("unit"), &format!("{unit:?}"), rule, way_out);
        return;
    }
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    let start = match signal.start {
        Some(_) => signal::start(checker, place, &signal, free, &unit),
        None => own.convert(demanded.start, &parsed).unwrap_or(demanded.start),
    };
    let alias = signal::alias(checker, place, &signal, aliases);
    inputs.push(InputSpec { variable, alias, unit, start });
}

fn refused_in_controller(checker: &mut Checker<'_>, place: &Place) -> bool {
    let is_controller = checker.blueprint.kind == Kind::Controller;
    if is_controller {
        checker.report(place, "", "belongs to a plant", "leave it out of a controller");
    }
    is_controller
}

/// Checks all couplings and adds them to `connections`; the places of those that were added, and
/// whether their values are those of the file.
pub(super) fn all(
    checker: &mut Checker<'_>,
    axes: &[AxisSpec],
    connections: &mut Connections,
) -> Vec<(Place, bool)> {
    let mut places = Vec::new();
    let blueprint = checker.blueprint;
    for (given, number) in blueprint.couplings.iter().zip(1..) {
        let key = Place::new("coupling").item(number);
        if let Some((coupling, place, is_clean)) = one(checker, axes, connections, given, &key) {
            connections.couplings.push(coupling);
            places.push((place, is_clean));
        }
    }
    places
}

fn one(
    checker: &mut Checker<'_>,
    axes: &[AxisSpec],
    connections: &Connections,
    given: &CouplingBlueprint,
    key: &Place,
) -> Option<(CouplingSpec, Place, bool)> {
    let component = component::find(checker, &given.component, key)?;
    let declaration = component.declaration();
    if !declaration.is_coupling() {
        let (kind, way_out) = (&given.component.kind, "put it in an [[axis.component]] section");
        checker.report(&key.child("type"), &format!("{kind:?}"), "couples no axes", way_out);
        return None;
    }
    let coordinates = declaration.conversion == Conversion::PositionToMotion;
    if !coordinates && refused_in_controller(checker, key) {
        return None;
    }
    if coordinates && checker.blueprint.kind == Kind::Plant {
        checker.report(key, "", "belongs to a controller", "leave it out of a plant");
        return None;
    }
    let own = &given.component.name;
    if !own.is_empty() {
        checker.check_name(&key.child("name"), own);
    }
    let name = if own.is_empty() { declaration.name } else { own }.to_string();
    let place = key.clone().shown_as(&Place::new("coupling"), &name);
    if connections.couplings.iter().any(|other| other.node.name == name) {
        let way_out = "give each coupling its own, as in name = \"optics\"";
        let shown = format!("{name:?}");
        checker.report(&place.child("name"), &shown, "is the name of another coupling", way_out);
        return None;
    }
    let range = declaration.least_axes()..=declaration.most_axes();
    let numbers = axes_of(checker, axes, given, &place, range)?;
    let after = (!given.after.is_empty()).then(|| given.after.clone());
    let place_of_after = place.child("after");
    for axis in numbers.iter().filter_map(|number| axes.get(*number)) {
        let names: Vec<&str> = axis.components.iter().map(|node| node.name.as_str()).collect();
        if !after.as_deref().is_none_or(|name| names.contains(&name)) {
            let rule = format!("axis {} has no such component", axis.name);
            let way_out = format!("name one that every coupled axis has, of {}", names.join(", "));
            checker.report(&place_of_after, &format!("{:?}", given.after), rule, way_out);
            return None;
        }
    }
    let given = flat(checker, &given.component, &place, numbers.len());
    let mut coupling = CouplingSpec {
        node: model::NodeSpec {
            component: component.into(),
            name: name.clone(),
            structure: Vec::new(),
            values: Vec::new(),
            enabled: true,
        },
        axes: numbers,
        after,
    };
    let [command_unit, position_unit] = units_of(axes, connections, &coupling);
    let frame = AxisSpec { command_unit, position_unit, ..axes[coupling.axes[0]].clone() };
    let member = Member { given: &given, declaration, place: &place, axis: &frame };
    let drafted = member.draft(checker, component, name);
    coupling.node = drafted.node;
    Some((coupling, place, drafted.is_clean))
}

/// The indices of the axes that a coupling names; `None` where that is wrong.
fn axes_of(
    checker: &mut Checker<'_>,
    axes: &[AxisSpec],
    given: &CouplingBlueprint,
    place: &Place,
    range: RangeInclusive<usize>,
) -> Option<Vec<usize>> {
    let key = place.child("axes");
    if checker.is_spoilt(&key.key) {
        return None;
    }
    let mut numbers: Vec<usize> = Vec::new();
    let before = checker.problems.len();
    for (name, item) in given.axes.iter().zip(1..) {
        let found = axes.iter().position(|axis| axis.name == *name);
        let shown = format!("{name:?}");
        match found {
            None => {
                let known: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).collect();
                let near = did_you_mean(name, known.iter().copied());
                let way_out = format!("{near}axes are {}", known.join(", "));
                checker.report(&key.item(item), &shown, "is no axis of this model", way_out);
            }
            Some(number) if numbers.contains(&number) => {
                checker.report(&key.item(item), &shown, "is named twice", "name each axis once");
            }
            Some(number) => numbers.push(number),
        }
    }
    if checker.problems.len() > before {
        return None;
    }
    if !range.contains(&numbers.len()) {
        let rule = format!("must be {} to {} axes", range.start(), range.end());
        let shown = numbers.len().to_string();
        checker.report(&key, &shown, rule, "name the axes that it couples, as in [\"Y\", \"Z\"]");
        return None;
    }
    Some(numbers)
}

/// The component with the rows of its matrices joined, and the number of axes as a setting.
fn flat(
    checker: &mut Checker<'_>,
    given: &ComponentBlueprint,
    place: &Place,
    axes: usize,
) -> ComponentBlueprint {
    let mut flat = given.clone();
    for (name, value) in &mut flat.values {
        let Value::List(rows) = value else { continue };
        if !rows.iter().any(|row| matches!(row, Value::List(_))) {
            continue;
        }
        let mut all = Vec::new();
        for (row, number) in rows.iter().zip(1..) {
            match row {
                Value::List(items) if items.len() == axes => all.extend(items.iter().cloned()),
                _ => {
                    let rule = format!("must be a row of {axes} values, one per axis");
                    let place = place.child(name).item(number);
                    checker.report(&place, "", rule, "write [[0, 0.01], [0.02, 0]], row by row");
                }
            }
        }
        *value = Value::List(all);
    }
    flat.set("axes", axes as f64);
    flat
}

/// The units that `{command}` and `{position}` stand for in a coupling.
pub(super) fn units(spec: &SystemSpec, coupling: &CouplingSpec) -> [String; 2] {
    units_of(&spec.axes, &spec.connections, coupling)
}

fn units_of(axes: &[AxisSpec], connections: &Connections, coupling: &CouplingSpec) -> [String; 2] {
    let Some(&first) = coupling.axes.first() else { return Default::default() };
    let (command, position) = (&axes[first].command_unit, &axes[first].position_unit);
    let motion = connections.motion_units.get(first).cloned().flatten();
    let motion = motion.unwrap_or_else(|| position.clone());
    if converts(coupling.node.component.declaration().conversion) {
        return [motion, position.clone()];
    }
    // Couplings at one place act in the order in which they are given.
    let couplings = &connections.couplings;
    let number = couplings.iter().position(|c| c.node.name == coupling.node.name);
    let own = (place_on(&axes[first], coupling), number.unwrap_or(couplings.len()));
    let is_behind = couplings.iter().enumerate().any(|(k, c)| {
        let converts = converts(c.node.component.declaration().conversion);
        converts && c.axes.contains(&first) && (place_on(&axes[first], c), k) < own
    });
    [command.clone(), if is_behind { position.clone() } else { motion }]
}

//! The check of everything but the components: names, step, axes, signals.

use std::collections::BTreeSet;

use model::{AxisSpec, Connections, Kind, SystemSpec};

use super::checker::Checker;
use super::draft::{Draft, DraftAxis};
use super::origin::Place;
use super::{AxisBlueprint, SignalBlueprint, component, connection, coupling, signal};

pub(super) fn draft(checker: &mut Checker<'_>) -> Draft {
    let blueprint = checker.blueprint;
    checker.check_name(&Place::new("name"), &blueprint.name);
    let period = step(checker);
    let mut aliases = BTreeSet::new();
    let mut names = BTreeSet::new();
    let mut axes = Vec::new();
    let mut specs = Vec::new();
    let mut connections = Connections::default();
    if blueprint.axes.is_empty() && !checker.is_spoilt("axis") {
        let place = Place::new("axis");
        checker.report(&place, "", "a model has at least one axis", "add an [[axis]] section");
    }
    for (axis, number) in blueprint.axes.iter().zip(1..) {
        let place = Place::new("axis").item(number);
        let (mut spec, mut draft) = axis_frame(checker, axis, &place, &mut aliases);
        if spec.name.is_empty() {
            spec.name = format!("axis{number}");
        }
        if !names.insert(spec.name.clone()) {
            let name = format!("{:?}", spec.name);
            let way_out = "give each axis its own name";
            checker.report(&place.child("name"), &name, "is the name of another axis", way_out);
        }
        let motion = coupling::motion_unit(checker, axis, &place);
        let optics = coupling::optics_at(checker, axis, &spec.name);
        let own = spec.position_unit.clone();
        let motions = motion.clone().unwrap_or_else(|| own.clone());
        let is_plant = checker.blueprint.kind == Kind::Plant;
        let unit_at = |index: usize| if (index < optics) == is_plant { &motions } else { &own };
        component::chain(checker, axis, &place, &mut spec, &mut draft, unit_at);
        spec.position_unit.clone_from(&own);
        connections.motion_units.push(motion);
        let inputs = &mut connections.inputs;
        coupling::axis_inputs(checker, axis, &place, &spec, number, &mut aliases, inputs);
        specs.push(spec);
        axes.push(draft);
    }
    coupling::system_inputs(checker, &mut aliases, &mut connections.inputs);
    let couplings = coupling::all(checker, &specs, &mut connections);
    connection::all(checker, &specs, &mut connections.ports);
    if couplings.len() < blueprint.couplings.len() {
        axes.iter_mut().for_each(|axis| axis.has_gaps = true);
    }
    let (name, kind) = (blueprint.name.clone(), blueprint.kind);
    Draft { spec: SystemSpec { name, kind, period, axes: specs, connections }, axes, couplings }
}

/// Shortest internal step in s.
const LEAST_STEP: f64 = 1e-9;

/// The internal step in s, or a harmless one.
fn step(checker: &mut Checker<'_>) -> f64 {
    let place = Place::new("step");
    let value = &checker.blueprint.step;
    match checker.number(&place, value, "s") {
        Some(step) if step >= LEAST_STEP => step,
        Some(step) => {
            let (value, rule) = if step > 0.0 {
                (format!("{step:e} s"), "is shorter than 1 ns, with which a run would not end")
            } else {
                (format!("{step} s"), "is no internal step")
            };
            let way_out = "give a positive time, as in 20e-6 or \"20 us\"";
            checker.report(&place, &value, rule, way_out);
            1e-3
        }
        None => 1e-3,
    }
}

fn axis_frame(
    checker: &mut Checker<'_>,
    axis: &AxisBlueprint,
    place: &Place,
    aliases: &mut BTreeSet<String>,
) -> (AxisSpec, DraftAxis) {
    if !axis.name.is_empty() {
        checker.check_name(&place.child("name"), &axis.name);
    }
    let is_plant = checker.blueprint.kind == Kind::Plant;
    let [command, position] = ["command", "position"].map(|key| place.child(key));
    let [reference, measured] = ["reference", "measured"].map(|key| place.child(key));
    let command_unit = signal::unit(checker, &command, &axis.command);
    let position_unit = signal::unit(checker, &position, &axis.position);
    signal::forbid(checker, &position, &axis.position, &["start"]);
    let range = signal::bounds(checker, &command, &axis.command, &command_unit);
    let position_range = signal::bounds(checker, &position, &axis.position, &position_unit);
    let start = if is_plant {
        for (place, signal) in [(&reference, &axis.reference), (&measured, &axis.measured)] {
            if *signal != SignalBlueprint::default() {
                let way_out = "leave it out; a plant has command and position";
                checker.report(place, "", "belongs to a controller", way_out);
            }
        }
        signal::start(checker, &command, &axis.command, range, &command_unit)
    } else {
        signal::forbid(checker, &command, &axis.command, &["start"]);
        signal::forbid(checker, &position, &axis.position, &["name"]);
        signal::forbid(checker, &reference, &axis.reference, &["unit", "min", "max"]);
        signal::forbid(checker, &measured, &axis.measured, &["unit", "min", "max", "start"]);
        signal::start(checker, &reference, &axis.reference, position_range, &position_unit)
    };
    let named = if is_plant {
        vec![(&command, &axis.command), (&position, &axis.position)]
    } else {
        vec![(&reference, &axis.reference), (&measured, &axis.measured), (&command, &axis.command)]
    };
    let aliases = named
        .into_iter()
        .map(|(place, signal)| signal::alias(checker, place, signal, aliases))
        .collect();
    let spec = AxisSpec {
        name: axis.name.clone(),
        command_unit,
        position_unit,
        command_range: range,
        position_range,
        start,
        aliases,
        components: Vec::new(),
    };
    (spec, DraftAxis::default())
}

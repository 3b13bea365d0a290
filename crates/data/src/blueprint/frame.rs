//! The check of everything around the components: names, step, axes, signals.

use std::collections::BTreeSet;

use model::{AxisSpec, Connections, Kind, SystemSpec, Unit};

use super::check::{Checker, Draft, DraftAxis};
use super::origin::Place;
use super::{AxisBlueprint, SignalBlueprint, component, connection, coupling};

/// Short names that a log or a model uses otherwise.
const TAKEN: [&str; 4] = ["time", "record", "realization", "enable"];

/// Stands for a unit that is missing or wrong.
const NO_UNIT: &str = "?";

pub(super) fn draft(checker: &mut Checker<'_>) -> Draft {
    let blueprint = checker.blueprint;
    is_name(checker, &Place::new("name"), &blueprint.name);
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

/// Checks that a name may stand in an FMI variable name. A name that is not given is none.
pub(super) fn is_name(checker: &mut Checker<'_>, place: &Place, name: &str) {
    if checker.is_spoilt(&place.key) {
        return;
    }
    let mut letters = name.chars();
    let starts_well = letters.next().is_some_and(|c| c.is_ascii_alphabetic());
    if starts_well && letters.all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return;
    }
    let way_out = "use the letters A to Z and a to z, digits and _ only, a letter first";
    checker.report(place, &format!("{name:?}"), "is no name that FMI tools accept", way_out);
}

fn axis_frame(
    checker: &mut Checker<'_>,
    axis: &AxisBlueprint,
    place: &Place,
    aliases: &mut BTreeSet<String>,
) -> (AxisSpec, DraftAxis) {
    if !axis.name.is_empty() {
        is_name(checker, &place.child("name"), &axis.name);
    }
    let is_plant = checker.blueprint.kind == Kind::Plant;
    let [command, position] = ["command", "position"].map(|key| place.child(key));
    let [reference, measured] = ["reference", "measured"].map(|key| place.child(key));
    let command_unit = unit(checker, &command, &axis.command);
    let position_unit = unit(checker, &position, &axis.position);
    forbid(checker, &position, &axis.position, &["start"]);
    let range = bounds(checker, &command, &axis.command, &command_unit);
    let position_range = bounds(checker, &position, &axis.position, &position_unit);
    let start = if is_plant {
        for (place, signal) in [(&reference, &axis.reference), (&measured, &axis.measured)] {
            if *signal != SignalBlueprint::default() {
                let way_out = "leave it out; a plant has command and position";
                checker.report(place, "", "belongs to a controller", way_out);
            }
        }
        start(checker, &command, &axis.command, range, &command_unit)
    } else {
        forbid(checker, &command, &axis.command, &["start"]);
        forbid(checker, &position, &axis.position, &["name"]);
        forbid(checker, &reference, &axis.reference, &["unit", "min", "max"]);
        forbid(checker, &measured, &axis.measured, &["unit", "min", "max", "start"]);
        start(checker, &reference, &axis.reference, position_range, &position_unit)
    };
    let named = if is_plant {
        vec![(&command, &axis.command), (&position, &axis.position)]
    } else {
        vec![(&reference, &axis.reference), (&measured, &axis.measured), (&command, &axis.command)]
    };
    let aliases =
        named.into_iter().map(|(place, signal)| alias(checker, place, signal, aliases)).collect();
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

/// The unit of a signal, or a text that is none where it is missing or wrong: nothing is said then about
/// values with units on this axis.
pub(super) fn unit(checker: &mut Checker<'_>, place: &Place, signal: &SignalBlueprint) -> String {
    let key = place.child("unit");
    if checker.is_spoilt(&place.key) || checker.is_spoilt(&key.key) {
        return NO_UNIT.into();
    }
    if signal.unit.is_empty() {
        let way_out = "write for example unit = \"um\"; \"1\" where it has none";
        checker.report(&key, "", "is missing: the values of this axis have a unit", way_out);
        return NO_UNIT.into();
    }
    if let Err(error) = Unit::parse(&signal.unit) {
        let way_out = "write it as in um, V, urad or mm/m";
        checker.report(&key, &format!("{:?}", signal.unit), error.to_string(), way_out);
        return NO_UNIT.into();
    }
    signal.unit.clone()
}

/// Reports the keys of a signal that mean nothing there.
pub(super) fn forbid(
    checker: &mut Checker<'_>,
    place: &Place,
    signal: &SignalBlueprint,
    keys: &[&str],
) {
    for key in keys {
        let is_given = match *key {
            "name" => !signal.name.is_empty(),
            "unit" => !signal.unit.is_empty(),
            "min" => signal.min.is_some(),
            "max" => signal.max.is_some(),
            _ => signal.start.is_some(),
        };
        if is_given {
            let way_out = match *key {
                "start" => "leave it out; a plant has it at command, a controller at reference",
                "min" | "max" => "leave it out; bounds belong to command and position",
                "unit" => "leave it out; the unit is that of position",
                _ => "leave it out; a controller names reference, measured and command",
            };
            checker.report(&place.child(key), "", "means nothing here", way_out);
        }
    }
}

fn bounds(
    checker: &mut Checker<'_>,
    place: &Place,
    signal: &SignalBlueprint,
    unit: &str,
) -> (f64, f64) {
    let mut bound = |key, value: &Option<super::Value>, free: f64| match value {
        Some(super::Value::Number(number)) if *number == free => free,
        Some(value) => checker.number(&place.child(key), value, unit).unwrap_or(free),
        None => free,
    };
    let min = bound("min", &signal.min, f64::NEG_INFINITY);
    let max = bound("max", &signal.max, f64::INFINITY);
    if min <= max {
        return (min, max);
    }
    let rule = format!("must be at least min = {min} {unit}");
    checker.report(&place.child("max"), &format!("{max} {unit}"), rule, "exchange min and max");
    (f64::NEG_INFINITY, f64::INFINITY)
}

/// The start of a signal, or a harmless value.
pub(super) fn start(
    checker: &mut Checker<'_>,
    place: &Place,
    signal: &SignalBlueprint,
    range: (f64, f64),
    unit: &str,
) -> f64 {
    let place = place.child("start");
    let harmless = 0.0_f64.max(range.0).min(range.1);
    let Some(given) = &signal.start else {
        if !(range.0..=range.1).contains(&0.0) {
            let rule = format!(
                "is missing, and its default 0 is outside {} to {} {unit}",
                range.0, range.1
            );
            checker.report(&place, "", rule, "give a start inside the bounds");
        }
        return harmless;
    };
    match checker.number(&place, given, unit) {
        Some(value) if checker.is_within(&place, value, range, unit) => value,
        _ => harmless,
    }
}

/// The short name of a signal.
pub(super) fn alias(
    checker: &mut Checker<'_>,
    place: &Place,
    signal: &SignalBlueprint,
    aliases: &mut BTreeSet<String>,
) -> Option<String> {
    if signal.name.is_empty() {
        return None;
    }
    let place = place.child("name");
    is_name(checker, &place, &signal.name);
    let shown = format!("{:?}", signal.name);
    if TAKEN.contains(&signal.name.as_str()) {
        let rule = format!("is taken: logs and models use {}", TAKEN.join(", "));
        checker.report(&place, &shown, rule, "choose another short name");
    } else if !aliases.insert(signal.name.clone()) {
        let way_out = "give each input and output its own, as in u1 and u2";
        checker.report(&place, &shown, "is the short name of another signal", way_out);
    }
    Some(signal.name.clone())
}

//! The check of one signal: unit, bounds, start and short name.

use std::collections::BTreeSet;

use model::Unit;

use super::checker::Checker;
use super::origin::Place;
use super::{SignalBlueprint, Value};

/// Short names that a log or a model uses otherwise.
const TAKEN: [&str; 4] = ["time", "record", "realization", "enable"];

/// Stands for a unit that is missing or wrong.
const NO_UNIT: &str = "?";

/// The unit of a signal, or a text that is none where it is missing or wrong: nothing is reported then about
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

/// The bounds of a signal, or none where they are wrong.
pub(super) fn bounds(
    checker: &mut Checker<'_>,
    place: &Place,
    signal: &SignalBlueprint,
    unit: &str,
) -> (f64, f64) {
    let mut bound = |key, value: &Option<Value>, free: f64| match value {
        Some(Value::Number(number)) if *number == free => free,
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
    checker.check_name(&place, &signal.name);
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

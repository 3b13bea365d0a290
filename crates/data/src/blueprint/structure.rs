//! The check of structural settings: given, counted from the lists, or by default.

use model::{Declaration, Quantity, Shape, Structural};

use super::checker::Checker;
use super::origin::Place;
use super::{ComponentBlueprint, Value};

/// The structural settings of a component in the order of its declaration; `None` for each that is
/// missing or wrong.
pub(super) fn counts(
    checker: &mut Checker<'_>,
    given: &ComponentBlueprint,
    declaration: &'static Declaration,
    place: &Place,
) -> Vec<Option<f64>> {
    let settings = declaration.structure.iter().enumerate();
    let counts = settings.map(|(index, setting)| {
        let parameters = declaration.parameters.iter();
        let lists: Vec<_> = parameters.filter(|q| q.shape == Shape::Array(index)).collect();
        count(checker, given, place, setting, &lists)
    });
    counts.collect()
}

/// One setting; `lists` are the parameters whose length it is.
fn count(
    checker: &mut Checker<'_>,
    given: &ComponentBlueprint,
    component: &Place,
    setting: &'static Structural,
    lists: &[&'static Quantity],
) -> Option<f64> {
    let place = component.child(setting.name);
    if let Some(value) = given.get(setting.name) {
        let number = checker.number(&place, value, setting.unit)?;
        if setting.integer && number.fract() != 0.0 {
            let way_out = "give a whole number";
            checker.report(&place, &number.to_string(), "must be a whole number", way_out);
            return None;
        }
        let bounds = (setting.min, setting.max);
        return checker.is_within(&place, number, bounds, setting.unit).then_some(number);
    }
    if checker.is_spoilt(&place.key) {
        return None;
    }
    let first = lists.iter().find_map(|list| match given.get(list.name) {
        Some(Value::List(items)) => Some((list.name, items.len() as f64)),
        _ => None,
    });
    if let Some((name, length)) = first {
        if length >= setting.min && length <= setting.max {
            return Some(length);
        }
        let rule = format!(
            "{} is the length of this list and must be from {} to {}",
            setting.name, setting.min, setting.max
        );
        let shown = format!("{length} values");
        checker.report(&component.child(name), &shown, rule, "shorten or lengthen the list");
        return None;
    }
    // Where a list that must be given is missing, that is reported, and says enough.
    let list_is_missing = lists.iter().any(|list| list.start.is_none());
    if setting.start.is_none() && !list_is_missing {
        let rule = format!("is missing: {}", setting.description);
        checker.report(&place, "", rule, format!("give it in {}", setting.unit));
    }
    setting.start
}

//! The check of structural settings: given, counted from the lists, or by default.

use model::{Shape, Structural};

use super::Value;
use super::check::Checker;
use super::component::Member;

/// The structural settings of a component in the order of its declaration; `None` for each that is
/// missing or wrong.
pub(super) fn counts(checker: &mut Checker<'_>, member: &Member<'_>) -> Vec<Option<f64>> {
    let settings = member.declaration.structure.iter().enumerate();
    settings.map(|(index, setting)| one(checker, member, index, setting)).collect()
}

fn one(
    checker: &mut Checker<'_>,
    member: &Member<'_>,
    index: usize,
    setting: &'static Structural,
) -> Option<f64> {
    let place = member.place.child(setting.name);
    if let Some(value) = member.given.get(setting.name) {
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
    if let Some((name, length)) = first_list(member, index) {
        let length = length as f64;
        if length >= setting.min && length <= setting.max {
            return Some(length);
        }
        let rule = format!(
            "{} is the length of this list and must be from {} to {}",
            setting.name, setting.min, setting.max
        );
        let shown = format!("{length} values");
        checker.report(&member.place.child(name), &shown, rule, "shorten or lengthen the list");
        return None;
    }
    // Where a list that must be given is missing, that is reported, and says enough.
    let list_is_missing = lists(member, index).any(|(_, start)| start.is_none());
    if setting.start.is_none() && !list_is_missing {
        let rule = format!("is missing: {}", setting.description);
        checker.report(&place, "", rule, format!("give it in {}", setting.unit));
    }
    setting.start
}

/// Parameters whose length is this setting: name and default.
fn lists(member: &Member<'_>, index: usize) -> impl Iterator<Item = (&'static str, Option<f64>)> {
    let parameters = member.declaration.parameters.iter();
    parameters.filter(move |q| q.shape == Shape::Array(index)).map(|q| (q.name, q.start))
}

/// The first list that is given, with its length.
fn first_list(member: &Member<'_>, index: usize) -> Option<(&'static str, usize)> {
    lists(member, index).find_map(|(name, _)| match member.given.get(name) {
        Some(Value::List(items)) => Some((name, items.len())),
        _ => None,
    })
}

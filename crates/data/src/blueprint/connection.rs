//! The check of the connections of ports.

use model::{AxisSpec, PortSpec};

use super::checker::Checker;
use super::origin::Place;
use crate::nearest::did_you_mean;

/// Adds the connections whose words are right; whether port and signal are there and measure the
/// same is checked by the build.
pub(super) fn all(checker: &mut Checker<'_>, axes: &[AxisSpec], ports: &mut Vec<PortSpec>) {
    let blueprint = checker.blueprint;
    for (given, number) in blueprint.connections.iter().zip(1..) {
        let place = Place::new("connection").item(number);
        let to = words::<3>(checker, axes, &place.child("to"), &given.to, "Z.load.force");
        let from = words::<2>(checker, axes, &place.child("from"), &given.from, "Y.displacement");
        if let (Some((axis, [_, component, port])), Some((from, [_, signal]))) = (to, from) {
            let [component, port, signal] = [component, port, signal].map(String::from);
            ports.push(PortSpec { axis, component, port, from, signal });
        }
    }
}

/// The words between the points of a name, and the axis that the first one names.
fn words<'a, const N: usize>(
    checker: &mut Checker<'_>,
    axes: &[AxisSpec],
    place: &Place,
    name: &'a str,
    example: &str,
) -> Option<(usize, [&'a str; N])> {
    if checker.is_spoilt(&place.key) {
        return None;
    }
    let shown = format!("{name:?}");
    let words: Vec<&str> = name.split('.').collect();
    let Ok(words) = <[&str; N]>::try_from(words) else {
        let rule = if name.is_empty() { "is missing" } else { "is no name of this kind" };
        let way_out = format!("write {N} words with points between, as in \"{example}\"");
        checker.report(place, &shown, rule, way_out);
        return None;
    };
    let axis = words.first().and_then(|word| axes.iter().position(|axis| axis.name == **word));
    if axis.is_none() {
        let names = || axes.iter().map(|axis| axis.name.as_str());
        let near = did_you_mean(words.first().copied().unwrap_or_default(), names());
        let all: Vec<&str> = names().collect();
        let way_out = format!("{near}axes are {}", all.join(", "));
        checker.report(place, &shown, "names no axis", way_out);
    }
    Some((axis?, words))
}

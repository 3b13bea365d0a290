//! What stands in for hardware that a paper does not describe, and which figures rest on it.

use data::{Blueprint, ComponentBlueprint, Value};

/// A part of the rig that is assumed.
pub(crate) struct StandIn {
    pub(crate) axes: Vec<String>,
    pub(crate) component: String,
    pub(crate) values: String,
    /// What the rig says of it.
    pub(crate) note: String,
}

/// The parts of a rig whose notes say that they are assumed, matched or not in the paper.
pub(crate) fn of(rig: &Blueprint) -> Vec<StandIn> {
    let mut all: Vec<StandIn> = Vec::new();
    let axes =
        rig.axes.iter().flat_map(|axis| axis.components.iter().map(move |c| (Some(axis), c)));
    let couplings = rig.couplings.iter().map(|coupling| (None, &coupling.component));
    for (axis, component) in axes.chain(couplings) {
        if !is_assumed(&component.note) {
            continue;
        }
        let axis = axis.map_or("all", |axis| axis.name.as_str());
        let name = if component.name.is_empty() { &component.kind } else { &component.name };
        let values = values(component);
        let known = all.iter_mut().find(|one| {
            one.component == *name && one.values == values && one.note == component.note
        });
        match known {
            Some(one) => one.axes.push(axis.to_owned()),
            None => all.push(StandIn {
                axes: vec![axis.to_owned()],
                component: name.clone(),
                values,
                note: component.note.clone(),
            }),
        }
    }
    all
}

fn is_assumed(note: &str) -> bool {
    ["assumed", "matched", "not in the paper", "only"].iter().any(|word| note.contains(word))
}

/// The values of a component that do not merely number something.
fn values(component: &ComponentBlueprint) -> String {
    let described = component.values.iter().filter(|(name, _)| name != "seed" && name != "longest");
    described
        .map(|(name, value)| format!("{} = {}", name.replace('_', " "), text(value)))
        .collect::<Vec<_>>()
        .join("; ")
}

fn text(value: &Value) -> String {
    match value {
        Value::Number(number) => report::format_number(*number, 5),
        Value::Text(text) => text.clone(),
        Value::List(items) if items.len() > 4 => format!("{} values", items.len()),
        Value::List(items) => items.iter().map(text).collect::<Vec<_>>().join(", "),
    }
}

/// Words of a figure's name, and the assumed parts on which it rests most.
type Rest = (&'static [&'static str], &'static str);

const P0: [Rest; 6] = [
    (&["beyond", "learning"], "noise, hum and floor of the detectors; drift"),
    (&["system 1", "system 2"], "delay, driver; order of the low-pass"),
    (&["system 3", "system 4"], "hysteresis, creep; delay, order of the low-pass"),
    (&["calibrated"], "the detectors' pincushion, the coupling of the mirrors"),
    (&["with D", "without D", "frequency-varying"], "order of the low-pass, creep, driver"),
    (&["H"], "hysteresis, noise"),
];
const P1: [Rest; 3] = [
    (&["beyond", "learning"], "sensor noise; converter"),
    (&["PID"], "order of the low-pass; damping of the mode; unit of the printed gains"),
    (&[""], "hysteresis, creep, order of the low-pass; signals C, F, G"),
];
const P2: [Rest; 2] =
    [(&["beyond"], "sensor noise (0.025 um)"), (&[""], "hysteresis, creep; the test signals")];
const P3: [Rest; 3] = [
    (&["PI alone", "closed loop"], "the mode (what the printed PI allows), gauge"),
    (&["open loop"], "hysteresis, creep, noise of the gauge; preview"),
    (&[""], "hysteresis, creep, noise of the gauge"),
];
const P4: [Rest; 3] = [
    (&["beyond"], "sensor noise (3 nm), creep"),
    (&["printed"], "control period of 50 us; damping of the modes"),
    (&[""], "hysteresis family, damping of the modes, lags; span of the ellipse; period of 50 us"),
];

/// What a figure of a paper rests on most.
pub(crate) fn rests_on(paper_id: &str, what: &str) -> &'static str {
    let table: &[Rest] = match paper_id {
        "P0" => &P0,
        "P1" => &P1,
        "P2" => &P2,
        "P3" => &P3,
        "P4" => &P4,
        _ => &[],
    };
    let hit = |words: &[&str]| words.iter().any(|word| what.contains(word));
    table.iter().find(|(words, _)| hit(words)).map_or("", |(_, rest)| rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines;

    #[test]
    fn every_machine_says_what_is_assumed() {
        for name in [machines::P0, machines::P1, machines::P2, machines::P3, machines::P4] {
            let rig = rigs::find(name).expect("a rig");
            let blueprint = Blueprint::parse(rig.blueprint, name).expect("a blueprint");
            let all = of(&blueprint);
            assert!(all.iter().any(|one| one.component == "creep"), "{name}: creep");
            assert!(all.iter().any(|one| one.component == "hysteresis"), "{name}: hysteresis");
        }
    }
}

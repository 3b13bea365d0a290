//! The blueprint with the effects in place.

use data::{Blueprint, ComponentBlueprint, Value};

use crate::block::Block;
use crate::library::Piece;
use crate::outcome::Outcome;
use crate::select::Candidate;

/// What a repair could not write, one sentence each.
pub(crate) type Gaps = Vec<String>;

/// Writes the re-tuned values and the effects of one axis (from 1) into a blueprint.
pub(crate) fn repair(o: &Outcome, axis: usize, blueprint: &mut Blueprint) -> Gaps {
    let mut gaps = Vec::new();
    let last = &o.found.last;
    let Some(target) = blueprint.axes.get_mut(axis - 1) else { return gaps };
    let spec_of = o.problem.base.components.clone();
    retune(o, last, target, &spec_of);
    let base = last.chain.parameters.iter().take_while(|p| p.is_base).count();
    let mut first = base;
    let mut inserts: Vec<(usize, ComponentBlueprint)> = Vec::new();
    for (family, number) in &last.picks {
        let effect = o.library[*family].effect.name;
        let formula = &o.library[*family].formulas[*number];
        let values: Vec<f64> = (first..first + formula.parameters.len())
            .map(|k| last.chain.parameters[k].value(last.fit.theta[k]))
            .collect();
        first += formula.parameters.len();
        let mut at = 0;
        let mut is_written = !formula.releases.is_empty();
        for piece in &formula.pieces {
            let own = &values[at..at + piece.count];
            at += piece.count;
            let node = o.problem.base.slots.get(&piece.slot).copied().unwrap_or(0);
            let place = spec_of.get(node).copied().unwrap_or(target.components.len());
            if let Some(components) = components(o, piece, own) {
                is_written = true;
                for component in components {
                    inserts.push((place, component.note(&format!("{effect}, found by diagnosis"))));
                }
            }
        }
        if !is_written {
            gaps.push(format!(
                "{effect} ({}): there is no component of this formula that could be written; take the values from the JSON",
                formula.name
            ));
        }
    }
    // From the back, so that places stay right.
    inserts.sort_by_key(|(place, _)| *place);
    for (place, component) in inserts.into_iter().rev() {
        let component = with_free_name(component, target);
        target.components.insert(place.min(target.components.len()), component);
    }
    gaps
}

/// A name that the axis does not have yet.
fn with_free_name(
    mut component: ComponentBlueprint,
    axis: &data::AxisBlueprint,
) -> ComponentBlueprint {
    let declared = components::find(&component.kind).map_or("effect", |c| c.declaration().name);
    let taken = |name: &str| {
        axis.components.iter().any(|c| {
            let own = components::find(&c.kind).map_or("", |c| c.declaration().name);
            c.name == name || (c.name.is_empty() && own == name)
        })
    };
    let mut name = format!("found_{declared}");
    let mut number = 2;
    while taken(&name) {
        name = format!("found_{declared}_{number}");
        number += 1;
    }
    component.name = name;
    component
}

/// Re-tuned and released parameters, and the output's gain in the actuator.
fn retune(o: &Outcome, last: &Candidate, axis: &mut data::AxisBlueprint, spec_of: &[usize]) {
    let base = &o.problem.base;
    for (node, place) in spec_of.iter().enumerate() {
        let Some(crate::chain::Node::Component(component)) = base.nodes.get(node) else { continue };
        let Some(target) = axis.components.get_mut(*place) else { continue };
        let mut values = component.values.clone();
        for p in base.parameters.iter().filter(|p| p.node == node) {
            let at = last.chain.parameters.iter().position(|c| c.is_base && c.name == p.name);
            let Some(at) = at else { continue };
            for (index, deviation) in &p.indices {
                values[*index] += deviation * last.fit.theta[at];
            }
        }
        let declaration = component.component.declaration();
        let gain = last.chain.parameters.iter().position(|p| p.is_base && p.name == "output.gain");
        let factor = gain.map_or(1.0, |k| 1.0 + base.gain_tolerance * last.fit.theta[k]);
        let mut at = 0;
        for (k, quantity) in declaration.parameters.iter().enumerate() {
            let length = declaration.length(k, &component.structure);
            let units = (o.problem.command_unit.as_str(), o.problem.unit.as_str());
            let text = model::unit_on_axis(quantity.unit, units.0, units.1);
            let unit = model::Unit::parse(&text).unwrap_or(model::Unit::ONE);
            let is_gain = node == base.actuator && matches!(quantity.name, "w" | "gain");
            let scale = if is_gain { factor } else { 1.0 };
            let old = &component.values[at..at + length];
            let new = &values[at..at + length];
            if scale != 1.0 || old.iter().zip(new).any(|(a, b)| a != b) {
                let own: Vec<f64> = new.iter().map(|v| unit.from_si(scale * v)).collect();
                let value = if matches!(quantity.shape, model::Shape::Scalar) {
                    Value::Number(own[0])
                } else {
                    Value::from(own)
                };
                target.set(quantity.name, value);
            }
            at += length;
        }
    }
}

/// The components that do what a block does with these values, where there are any.
fn components(o: &Outcome, piece: &Piece, p: &[f64]) -> Option<Vec<ComponentBlueprint>> {
    let new = ComponentBlueprint::new;
    let (u, y) = (o.problem.command_factor, o.problem.factor);
    let step = o.problem.data.step;
    let is_sensor = piece.slot == crate::library::Slot::Reading;
    let span = o.problem.data.command_span;
    let far = 10.0 * (span.half + span.centre.abs());
    let one = |c: ComponentBlueprint| Some(vec![c]);
    match (&piece.block, p) {
        (Block::Delay, &[delay]) => {
            let longest = ((2.0 * delay / step).ceil() + 1.0) * step;
            one(new("delay").value("longest", longest).value("delay", delay))
        }
        (Block::Lag(order), &[bandwidth]) => {
            let kind = if is_sensor { "sensor-lag" } else { "amplifier-lag" };
            Some(vec![new(kind).value("bandwidth", bandwidth); *order])
        }
        (Block::Lag2, &[frequency, damping]) => {
            let kind = if is_sensor { "sensor-second-order" } else { "amplifier-second-order" };
            one(new(kind).value("frequency", frequency).value("damping", damping))
        }
        (Block::Slew, &[rate]) => one(new("amplifier-slew").value("rate", rate / u)),
        (Block::ClampHigh, &[high]) => {
            one(new("amplifier-clamp").value("low", -far / u).value("high", high / u))
        }
        (Block::ClampLow, &[low]) => {
            one(new("amplifier-clamp").value("low", low / u).value("high", far / u))
        }
        (Block::ClampBoth(s), &[half]) => one(new("amplifier-clamp")
            .value("low", (s.centre - half) / u)
            .value("high", (s.centre + half) / u)),
        (Block::Gain, &[gain]) => one(new("sensor-scale").value("gain", 1.0 + gain)),
        (Block::PoleZero, &[pole, damping, ratio, zero_damping]) => one(new("collocated-mode")
            .value("frequency", pole)
            .value("damping", damping)
            .value("zero_frequency", pole * ratio)
            .value("zero_damping", zero_damping)),
        // 1 − g + g·M is a pair of poles and zeros with the static gain 1.
        (Block::ParallelMode, &[gain, frequency, damping]) if gain < 1.0 => {
            let root = (1.0 - gain).sqrt();
            one(new("collocated-mode")
                .value("frequency", frequency)
                .value("damping", damping)
                .value("zero_frequency", frequency / root)
                .value("zero_damping", damping * root))
        }
        (Block::Backlash, &[half]) => one(new("backlash").value("width", 2.0 * half / y)),
        (Block::Polynomial { span, order: 3 }, &[square, cubic]) => one(new("sensor-polynomial")
            .value("quadratic", square)
            .value("cubic", cubic)
            .value("centre", span.centre / y)
            .value("half_range", span.half / y)),
        (Block::FeedThrough { scale, time }, &[value, rate]) => one(new("crosstalk")
            .value("gain", value / scale * u / y)
            .value("rate_gain", rate * time / scale * u / y)),
        (block, p) => creep(block, p).and_then(one),
    }
}

/// Every formula of creep is a sum of elements.
fn creep(block: &Block, p: &[f64]) -> Option<ComponentBlueprint> {
    let mut elements = block.elements(p)?;
    elements.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (share, time): (Vec<f64>, Vec<f64>) = elements.into_iter().unzip();
    Some(
        ComponentBlueprint::new("kelvin-voigt-creep")
            .value("share", share)
            .value("time_constant", time),
    )
}

//! The blueprint with the effects in place.

mod handed;
mod joint;
mod parts;
mod plays;
mod zones;

use components::effects;
use components::sensor::SENSOR_SCALE;
use data::{AxisBlueprint, Blueprint, ComponentBlueprint, Value};
use model::{Component, Declaration, Effect, Extension, Stage};
use surround::Block;

pub(crate) use self::handed::judged_as_written;
pub(crate) use self::joint::write as write_joint;
use self::plays::Plays;
use crate::base::compose::GAIN;
use crate::base::{Base, Part};
use crate::candidate::Candidate;
use crate::chain::Chain;
use crate::formula::{Formula, Piece, Slot};
use crate::left_out::{part_stays_out, stays_out};
use crate::outcome::Outcome;
use crate::score::Judged;
use crate::stand_in::stand_in;
use crate::thresholds::repair::Thresholds;

/// One change of an axis.
#[derive(Clone)]
enum Change {
    /// A component before the one that had this number.
    Insert { place: usize, slot: Slot, component: ComponentBlueprint },
    /// Another component in the place of the one that had this number.
    Replace { place: usize, component: ComponentBlueprint },
}

/// Writes the re-tuned values and the effects of one axis (from 1) into a blueprint; what stays out
/// of it, one sentence each, and what the repaired axis leaves of the logs, where it can be run alone.
pub(crate) fn repair(
    o: &Outcome,
    axis: usize,
    blueprint: &mut Blueprint,
) -> (Vec<String>, Option<Judged>) {
    let given_blueprint = blueprint.clone();
    let Some(axis_given) = blueprint.axes.get(axis - 1).cloned() else { return (Vec::new(), None) };
    let is_written = |effect: &str, formula: &Formula, values: &[f64]| {
        write(o, &o.found.last, effect, formula, values, (&axis_given, &axis_given)).is_some()
    };
    let (last, mut notes) = stand_in(o, &is_written);
    let last = &last;
    if o.noise_ratio.is_some() {
        notes.push(format!("{}: noise is no part of a repaired model", effects::SENSOR_NOISE.name));
    }
    retune(&o.task.base, (&last.chain, &last.fit.theta), o, (blueprint, axis));
    let given = blueprint.clone();
    let mut changes: Vec<Change> = Vec::new();
    for (effect, formula, values) in o.effects(last) {
        // What changes the actuator or a mode builds on what was changed there before.
        let axis_now = &apply(&given, axis, &changes).axes[axis - 1].clone();
        let Some(own) = write(o, last, effect, formula, &values, (&given.axes[axis - 1], axis_now))
        else {
            if formula.releases.is_empty() && formula.joint_mode.is_none() {
                notes.push(stays_out(effect, formula));
            }
            continue;
        };
        let mut tried = changes.clone();
        tried.retain(|c| !own.iter().any(|o| is_same_place(c, o)));
        tried.extend(own);
        match apply(&given, axis, &tried).check(components::COMPONENTS) {
            Ok(_) => {
                notes.extend(part_stays_out(effect, formula));
                changes = tried;
            }
            Err(problems) => notes.push(format!(
                "{effect} ({}) stays out of the repaired blueprint, whose components do not take these values: {problems}",
                formula.name
            )),
        }
    }
    let gain = output_gain(&o.task.base, (&last.chain, &last.fit.theta));
    if has_gain_behind(&o.task.base) && gain != 1.0 {
        let scale = ComponentBlueprint::new(SENSOR_SCALE.declaration().kind);
        let component = scale.value("gain", gain).note("the re-tuned gain");
        let place = given.axes[axis - 1].components.len();
        changes.push(Change::Insert { place, slot: Slot::Reading, component });
    }
    if let Some(steps) = o.task.steps {
        let span = o.task.data.output_span;
        let (slot, block) = (Slot::Reading, Block::Rounding { half: span.half }.into());
        let piece = Piece { slot, block, takes: vec![0, 1], aux: 0, of_command: false };
        let values = [2.0 * span.half / steps.size, steps.phase];
        let note = format!("{}, seen in the readings", effects::SENSOR_QUANTISATION.name);
        let place = given.axes[axis - 1].components.len();
        let found = parts::components(o, &piece, &values).unwrap_or_default();
        changes.extend(found.into_iter().map(|component| Change::Insert {
            place,
            slot,
            component: component.note(&note),
        }));
    }
    *blueprint = apply(&given, axis, &changes);
    let judged = handed::settle(o, last, (axis, &axis_given), blueprint);
    let base = &o.found.base;
    let is_worse = |j: &Judged| j.held_out > base.judged.held_out && !last.picks.is_empty();
    if !judged.as_ref().is_some_and(is_worse) {
        let given = (axis, &axis_given);
        let (note, judged) = handed::level(o, last, given, blueprint, judged.as_ref());
        notes.extend(note);
        return (notes, judged);
    }
    *blueprint = given_blueprint;
    retune(&o.task.base, (&base.chain, &base.fit.theta), o, (blueprint, axis));
    let (note, _) = handed::level(o, base, (axis, &axis_given), blueprint, Some(&base.judged));
    notes.extend(note);
    notes.push(
        "the effects stay out of the repaired blueprint: with what components can do in their place \
         it would be further from the logs than without"
            .to_owned(),
    );
    (notes, Some(base.judged.clone()))
}

/// Effects that are linear dynamics: what a model that was identified from the same logs may lack, whatever the machine is.
const LINEAR: [&Effect; 4] = [
    &effects::EXTRA_MODE,
    &effects::AMPLIFIER_BANDWIDTH,
    &effects::SENSOR_BANDWIDTH,
    &effects::DELAY,
];

/// Whether an effect of this name is linear dynamics (a mode, a lag, a delay), which a model that was identified from the
/// same logs may lack.
#[must_use]
pub fn is_linear(effect: &str) -> bool {
    LINEAR.iter().any(|linear| linear.name == effect)
}

/// Writes the re-tuned values and the linear dynamics that were found in one axis (from 1) into a blueprint; whether there
/// are any.
pub(crate) fn linear_parts(o: &Outcome, axis: usize, blueprint: &mut Blueprint) -> bool {
    let last = &o.found.last;
    retune(&o.task.base, (&last.chain, &last.fit.theta), o, (blueprint, axis));
    let given = blueprint.clone();
    let (mut changes, mut has_any) = (Vec::new(), false);
    let all = o.effects(last);
    for (effect, formula, values) in all.filter(|(effect, ..)| is_linear(effect)) {
        let axis_now = &apply(&given, axis, &changes).axes[axis - 1].clone();
        let axes = (&given.axes[axis - 1], axis_now);
        let own = first_mode(o, formula, &values)
            .or_else(|| write(o, last, effect, formula, &values, axes));
        has_any |= own.is_some() || !formula.releases.is_empty();
        changes.extend(own.unwrap_or_default());
    }
    *blueprint = apply(&given, axis, &changes);
    has_any && blueprint.clone().check(components::COMPONENTS).is_ok()
}

/// The mode of a machine whose model has none: nearly all of the motion goes through it.
fn first_mode(o: &Outcome, formula: &Formula, values: &[f64]) -> Option<Vec<Change>> {
    let block = formula.pieces.first()?.block.effect()?;
    let (Block::ParallelMode, &[gain, frequency, damping]) = (block, values) else { return None };
    let is_all = o.task.base.mode.is_none() && (gain - 1.0).abs() < Thresholds::ALL_THROUGH_MODE;
    let component = ComponentBlueprint::new("mode");
    let component = component.value("frequency", frequency).value("damping", damping);
    let place = o.task.base.components.iter().map(|at| at.place + 1).max().unwrap_or(0);
    is_all.then(|| vec![Change::Insert { place, slot: Slot::BeforeMechanics, component }])
}

fn is_same_place(a: &Change, b: &Change) -> bool {
    match (a, b) {
        (Change::Replace { place: a, .. }, Change::Replace { place: b, .. }) => a == b,
        _ => false,
    }
}

/// The blueprint with these changes of one axis.
fn apply(given: &Blueprint, axis: usize, changes: &[Change]) -> Blueprint {
    let mut blueprint = given.clone();
    let Some(target) = blueprint.axes.get_mut(axis - 1) else { return blueprint };
    let mut inserts = Vec::new();
    for change in changes {
        match change {
            Change::Replace { place, component } => {
                if let Some(old) = target.components.get_mut(*place) {
                    *old = component.clone();
                }
            }
            Change::Insert { place, slot, component } => {
                inserts.push((*place, *slot, component.clone()));
            }
        }
    }
    inserts.sort_by_key(|(place, slot, _)| (*place, *slot));
    for (count, (place, _, component)) in inserts.into_iter().enumerate() {
        let component = with_free_name(component, target);
        target.components.insert((place + count).min(target.components.len()), component);
    }
    blueprint
}

/// The changes that make an effect; none where nothing in the registry does what it does.
fn write(
    o: &Outcome,
    last: &Candidate,
    effect: &str,
    formula: &Formula,
    values: &[f64],
    (given, now): (&AxisBlueprint, &AxisBlueprint),
) -> Option<Vec<Change>> {
    let base = &o.task.base;
    let note = format!("{effect}, found by diagnosis");
    let place_of =
        |node: usize| base.components.get(node).map_or(given.components.len(), |at| at.place);
    if let Some(force) = formula.force {
        let place = place_of(base.mode?);
        let old = now.components.get(place_now(given, now, place)?)?;
        // Another force has the mode: no component holds two.
        if old.kind != given.components.get(place)?.kind {
            return None;
        }
        let component = parts::forced(o.task.factor, force, values, old)?.note(&note);
        return Some(vec![Change::Replace { place, component }]);
    }
    let mut all = Vec::new();
    for piece in &formula.pieces {
        let own: Vec<f64> = piece.takes.iter().map(|k| values[*k]).collect();
        let own = &own[..];
        let node = base.slots.get(&piece.slot).copied().unwrap_or(0);
        let actuator = place_of(base.actuator);
        let old = place_now(given, now, actuator).and_then(|at| now.components.get(at));
        let bent = old.and_then(|old| zones::bent(o, last, piece, own, old));
        let plays = || actuator_with(o, last, piece.block.effect()?, own, old?);
        // In front of couplings no component is a gain: the actuator has it.
        let gain = match piece.block.effect() {
            Some(Block::Gain) if base.part == Part::Motion => own.first().copied(),
            _ => None,
        };
        let scaled_up = || Some(scaled(old?, 1.0 + gain?));
        if let Some(component) = bent.or_else(plays).or_else(scaled_up) {
            all.push(Change::Replace { place: actuator, component: component.note(&note) });
            continue;
        }
        for component in parts::components(o, piece, own)? {
            // Couplings stand behind the last component of the mechanics and what is before them.
            let is_in_front =
                components::find(&component.kind)?.declaration().stage <= Stage::Mechanics;
            let is_elsewhere = match base.part {
                // What stands behind the coupling comes after the mechanics.
                Part::Axis | Part::Front(_) => {
                    base.joint().is_some() && piece.slot >= Slot::AfterMechanics && is_in_front
                }
                Part::Motion => !is_in_front,
                Part::Reading(_) => is_in_front,
            };
            if is_elsewhere {
                return None;
            }
            let component = component.note(&note);
            all.push(Change::Insert { place: place_of(node), slot: piece.slot, component });
        }
    }
    (!all.is_empty()).then_some(all)
}

/// Where the component that had this number is now: components have unique names.
fn place_now(given: &AxisBlueprint, now: &AxisBlueprint, place: usize) -> Option<usize> {
    let inserted = now.components.len() - given.components.len();
    let old = given.components.get(place)?;
    let same = |c: &ComponentBlueprint| c.kind == old.kind && c.name == old.name;
    let range = place..=place + inserted;
    range.clone().find(|k| now.components.get(*k).is_some_and(same)).or_else(|| range.last())
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => Some(*number),
        _ => None,
    }
}

/// A component whose positions are larger by a factor.
fn scaled(old: &ComponentBlueprint, factor: f64) -> ComponentBlueprint {
    let mut component = old.clone();
    let declaration = components::find(&old.kind).map(|kind| kind.declaration());
    for quantity in declaration.map_or(&[][..], |d| d.parameters) {
        let value = match old.get(quantity.name).filter(|_| quantity.unit.starts_with("{position}"))
        {
            Some(Value::List(all)) => all
                .iter()
                .map(|v| number(v).map(|v| factor * v))
                .collect::<Option<Vec<f64>>>()
                .map(Value::from),
            Some(one) => number(one).map(|v| Value::Number(factor * v)),
            None => None,
        };
        if let Some(value) = value {
            component.set(quantity.name, value);
        }
    }
    component
}

/// What is declared of the component that this one becomes with an extension.
fn extended(old: &ComponentBlueprint, by: Extension) -> Option<&'static Declaration> {
    Some(components::find(&old.kind)?.extended(by)?.declaration())
}

/// The actuator with plays of its own, or as another operator of its plays.
fn actuator_with(
    o: &Outcome,
    last: &Candidate,
    block: &Block,
    p: &[f64],
    old: &ComponentBlueprint,
) -> Option<ComponentBlueprint> {
    let u = o.task.command_factor;
    let plays = Plays::of(old)?;
    let mut component = match block {
        Block::Plays { r, slope } => {
            let (linear, weights) = p.split_at(usize::from(*slope));
            let weight = weight_of(o, last);
            let sum: f64 = weights.iter().sum();
            let mut all = plays;
            all.add(0.0, weight(linear.first().copied().unwrap_or(0.0) - sum));
            r.iter().zip(weights).for_each(|(r, w)| all.add(r / u, weight(*w)));
            let command: Vec<f64> = o.task.data.command.iter().map(|v| v / u).collect();
            all.rising(&command);
            all.written(extended(old, Extension::Plays)?)?
        }
        Block::Operator { component: operator, .. } => {
            let declaration = operator.component().declaration();
            let mut component = plays.written(declaration)?;
            for (free, value) in operator.missing().free.iter().zip(p) {
                let quantity = declaration.parameters.iter().find(|q| q.name == free.quantity)?;
                let units = (o.task.command_unit.as_str(), o.task.unit.as_str());
                let text = model::unit_on_axis(quantity.unit, units.0, units.1);
                let unit = model::Unit::parse(&text).unwrap_or(model::Unit::ONE);
                component.set(free.quantity, unit.from_si(*value));
            }
            component
        }
        Block::SkewedPlays { .. } | Block::GeneralisedPlay(_) => {
            skewed(o, last, block, p, (plays, old))?
        }
        _ => return None,
    };
    take_place(&mut component, old);
    Some(component)
}

/// Fitted weights of plays as a blueprint has them: with the re-tuned gain of the output, in the axis' units.
fn weight_of(o: &Outcome, last: &Candidate) -> impl Fn(f64) -> f64 + use<> {
    let factor = gain_in_front(&o.task.base, (&last.chain, &last.fit.theta));
    let (u, y) = (o.task.command_factor, o.task.factor);
    move |w| factor * w * u / y
}

/// Plays beside which others are wider at one end of the range.
fn skewed(
    o: &Outcome,
    last: &Candidate,
    block: &Block,
    p: &[f64],
    (mut plays, old): (Plays, &ComponentBlueprint),
) -> Option<ComponentBlueprint> {
    let (u, weight) = (o.task.command_factor, weight_of(o, last));
    let (span, skew, [wide, width, growth, curvature]) = match (block, p) {
        (Block::SkewedPlays { r, span }, weights) => {
            let of = |(r, w): (&f64, &f64)| (r / u, weight(*w));
            (span, r.iter().zip(weights).map(of).collect(), [0.0; 4])
        }
        (Block::GeneralisedPlay(span), &[w, width, growth, curvature]) => {
            (span, Vec::new(), [weight(w), width, growth, curvature])
        }
        _ => return None,
    };
    skew.iter().for_each(|(r, _)| plays.add(*r, 0.0));
    let skew_of = |r: f64| skew.iter().filter(|(own, _)| *own == r).map(|(_, v)| v).sum::<f64>();
    let skew: Vec<f64> = plays.pairs.iter().map(|(r, _)| skew_of(*r)).collect();
    Some(
        plays
            .written(extended(old, Extension::Skew)?)?
            .value("skew", skew)
            .value("play_weight", wide)
            .value("width", width)
            .value("width_growth", growth)
            .value("width_curvature", curvature)
            .value("centre", span.centre / u)
            .value("half_range", span.half / u),
    )
}

/// Name and offset of the actuator that another one takes the place of.
fn take_place(component: &mut ComponentBlueprint, old: &ComponentBlueprint) {
    component.name.clone_from(&old.name);
    if let Some(offset) = old.get("offset") {
        component.set("offset", offset.clone());
    }
}

/// The re-tuned factor of the output.
fn output_gain(base: &Base, (chain, theta): (&Chain, &[f64])) -> f64 {
    chain.own(GAIN).map_or(1.0, |k| 1.0 + base.gain_tolerance * theta[k])
}

/// Whether the gain of the output is the sensor's: a reading has no actuator, and one in front of a coupling moves other
/// readings, too.
fn has_gain_behind(base: &Base) -> bool {
    base.joint().is_some() || matches!(base.part, Part::Reading(_))
}

/// The re-tuned factor of the output where the actuator has it, or 1.
fn gain_in_front(base: &Base, fitted: (&Chain, &[f64])) -> f64 {
    if has_gain_behind(base) { 1.0 } else { output_gain(base, fitted) }
}

/// A name that the axis does not have yet.
fn with_free_name(mut component: ComponentBlueprint, axis: &AxisBlueprint) -> ComponentBlueprint {
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
fn retune(
    base: &Base,
    fitted: (&Chain, &[f64]),
    o: &Outcome,
    (blueprint, axis): (&mut Blueprint, usize),
) {
    let (chain, theta) = fitted;
    for (node, standing) in base.components.iter().enumerate() {
        let Some(crate::chain::Node::Component(component)) = base.nodes.get(node) else { continue };
        let target = match standing.coupling {
            Some(k) => blueprint.couplings.get_mut(k).map(|coupling| &mut coupling.component),
            None => blueprint
                .axes
                .get_mut(axis - 1)
                .and_then(|axis| axis.components.get_mut(standing.place)),
        };
        let Some(target) = target else { continue };
        let mut values = component.values.clone();
        for p in base.parameters.iter().filter(|p| p.node == node) {
            let Some(at) = chain.own(&p.name) else { continue };
            for (index, deviation) in &p.indices {
                values[*index] += deviation * theta[at];
            }
        }
        let declaration = component.component.declaration();
        let factor = gain_in_front(base, fitted);
        let mut at = 0;
        for (k, quantity) in declaration.parameters.iter().enumerate() {
            let length = declaration.length(k, &component.structure);
            let units = (o.task.command_unit.as_str(), o.task.unit.as_str());
            let text = model::unit_on_axis(quantity.unit, units.0, units.1);
            let unit = model::Unit::parse(&text).unwrap_or(model::Unit::ONE);
            // A factor of the position is one of everything that an actuator gives in positions.
            let is_gain = node == base.actuator && quantity.unit.starts_with("{position}");
            let scale = if is_gain { factor } else { 1.0 };
            let old = &component.values[at..at + length];
            let new = &values[at..at + length];
            // As numbers, for those that are built anew from them.
            let is_read = node == base.actuator || base.mode == Some(node);
            if is_read || scale != 1.0 || old.iter().zip(new).any(|(a, b)| a != b) {
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

//! The model that is handed back, tuned and judged as it is written.
//!
//! A component does not always do to the letter what a fitted formula did. What is promised is
//! therefore what the written axis leaves of the logs, and its values are those that fit them.

use std::sync::atomic::AtomicU64;

use components::COMPONENTS;
use components::sensor::SENSOR_SCALE;
use data::{AxisBlueprint, Blueprint, ComponentBlueprint, Value};
use model::Component;

use super::retune;
use crate::base::compose::LATE;
use crate::base::{Base, Part};
use crate::candidate::Candidate;
use crate::chain::Chain;
use crate::fit::Fitter;
use crate::formula::{Formula, Slot};
use crate::offset;
use crate::outcome::Outcome;
use crate::request::{Deviation, Tolerance};
use crate::score::Judged;
use crate::thresholds::repair::Thresholds;

/// The quantity of a component that shifts its positions.
const OFFSET: &str = "offset";

/// What the axes do that a coupling joins with a written one.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Others {
    /// What was found.
    AsFound,
    /// What is written.
    AsWritten,
}

/// The written axis under the logs.
struct Written<'a> {
    o: &'a Outcome,
    base: Base,
    chain: Chain,
    start: Vec<f64>,
    count: &'a AtomicU64,
}

/// Tunes the written axis where it misses what was found, and says what it leaves; none where the axis
/// cannot be run by itself.
pub(super) fn settle(
    o: &Outcome,
    last: &Candidate,
    (axis, given): (usize, &AxisBlueprint),
    blueprint: &mut Blueprint,
) -> Option<Judged> {
    if is_cut(&o.task.base) {
        return None;
    }
    let count = AtomicU64::new(0);
    let read = |blueprint: &Blueprint| {
        Written::new(o, last, blueprint, (axis, given), Others::AsFound, &count)
    };
    let written = read(blueprint)?;
    let judged = written.judge(&written.start)?;
    if judged.training <= Thresholds::WRITTEN_OFF * last.judged.training {
        return Some(judged);
    }
    let better = written.tuned().and_then(|theta| {
        let mut tuned = blueprint.clone();
        retune(&written.base, (&written.chain, &theta), o, (&mut tuned, axis));
        // As it is written, with what a component may round or refuse.
        let again = read(&tuned)?;
        Some((again.judge(&again.start)?, tuned))
    });
    match better {
        Some((fitted, tuned))
            if fitted.training < judged.training && fitted.held_out < judged.held_out =>
        {
            *blueprint = tuned;
            Some(fitted)
        }
        _ => Some(judged),
    }
}

/// Gives a written axis, which left so much without it, the offset that all records share: in its actuator, or in the sensor
/// behind all. What could not be done, in a sentence, and what the axis leaves with it.
pub(super) fn level(
    o: &Outcome,
    last: &Candidate,
    axis: (usize, &AxisBlueprint),
    blueprint: &mut Blueprint,
    without: Option<&Judged>,
) -> (Option<String>, Option<Judged>) {
    let shared = o.offset.map_or(0.0, |offset| offset.shared);
    if shared == 0.0 {
        return (None, without.cloned());
    }
    let at = |is_behind| {
        let levelled = levelled(o, last, axis, is_behind, blueprint)?;
        Some((judge(o, last, axis, &levelled)?, levelled))
    };
    let is_less = |a: &Judged, b: &Judged| a.training < Thresholds::OFFSET_BEHIND * b.training;
    // In front of a coupling it moves other readings, too.
    let front = if o.task.base.joint().is_some() { None } else { at(false) };
    // In front of a curved part an offset moves its working point: behind all, where less is left with it.
    let is_good = front.as_ref().is_some_and(|(j, _)| without.is_none_or(|w| !is_less(w, j)));
    let behind = if is_good { None } else { at(true) };
    let behind = behind.filter(|(j, _)| front.as_ref().is_none_or(|(front, _)| is_less(j, front)));
    match behind.or(front) {
        Some((judged, levelled)) => {
            *blueprint = levelled;
            (None, Some(judged))
        }
        None => {
            let note = format!(
                "the offset that all records share, {:.4} {} of {}, stays out of the repaired blueprint",
                shared / o.task.factor,
                o.task.unit,
                o.task.output
            );
            (Some(note), without.cloned())
        }
    }
}

/// What an axis that a coupling joins with others leaves of the logs in a blueprint in which all are written; none where it
/// cannot be run.
pub(crate) fn judged_as_written(
    o: &Outcome,
    given: &Blueprint,
    blueprint: &Blueprint,
) -> Option<Judged> {
    o.task.base.joint()?;
    let axis = (o.task.axis, given.axes.get(o.task.axis - 1)?);
    let count = AtomicU64::new(0);
    let written = Written::new(o, &o.found.last, blueprint, axis, Others::AsWritten, &count)?;
    written.judge(&written.start)
}

/// What a written axis leaves of the logs; none where it cannot be run by itself.
fn judge(
    o: &Outcome,
    last: &Candidate,
    axis: (usize, &AxisBlueprint),
    blueprint: &Blueprint,
) -> Option<Judged> {
    let count = AtomicU64::new(0);
    let written = Written::new(o, last, blueprint, axis, Others::AsFound, &count)?;
    written.judge(&written.start)
}

/// The blueprint with that offset, in the actuator or behind all; none where the axis has no place for it or cannot be run by
/// itself.
fn levelled(
    o: &Outcome,
    last: &Candidate,
    (axis, given): (usize, &AxisBlueprint),
    is_behind: bool,
    blueprint: &Blueprint,
) -> Option<Blueprint> {
    let base = &o.task.base;
    if is_cut(base) {
        return None;
    }
    let count = AtomicU64::new(0);
    let left = |blueprint: &Blueprint| {
        let written = Written::new(o, last, blueprint, (axis, given), Others::AsFound, &count)?;
        offset::left(&o.task.data, (&written.chain, &written.start), 0.0, &count)
    };
    let mut levelled = blueprint.clone();
    let own = &mut levelled.axes.get_mut(axis - 1)?.components;
    let place = base.components.get(base.actuator).map(|at| at.place);
    let name = place.and_then(|at| given.components.get(at)).map(|actuator| &actuator.name);
    let actuator = own.iter().position(|c| Some(&c.name) == name);
    let at = match actuator.filter(|at| has_offset(&own[*at]) && !is_behind) {
        Some(at) => at,
        None if base.part == Part::Motion => return None,
        // Beside the re-tuned gain.
        None if own
            .last()
            .is_some_and(|c| is_scale(c) && !given.components.iter().any(|g| is_same(g, c))) =>
        {
            own.len() - 1
        }
        None => {
            let scale = ComponentBlueprint::new(SENSOR_SCALE.declaration().kind);
            let scale = scale.value("gain", 1.0).note("the offset that all records share");
            let scale = super::with_free_name(scale, &levelled.axes[axis - 1]);
            levelled.axes[axis - 1].components.push(scale);
            levelled.axes[axis - 1].components.len() - 1
        }
    };
    let start = levelled.axes[axis - 1].components[at].get(OFFSET).and_then(super::number);
    // What a unit of it gives at the output: known once it was moved.
    let (mut value, mut slope, mut before) = (0.0, 1.0, left(&levelled)?);
    for _ in 0..Thresholds::OFFSET_TURNS {
        let step = before / slope;
        value += step;
        let offset = start.unwrap_or(0.0) + value / o.task.factor;
        levelled.axes[axis - 1].components[at].set(OFFSET, Value::Number(offset));
        let after = left(&levelled)?;
        if after.abs() < Thresholds::OFFSET_SMALL * o.sigma {
            return Some(levelled);
        }
        let moved = (before - after) / step;
        slope = if moved.is_finite() && moved != 0.0 { moved } else { slope };
        before = after;
    }
    None
}

fn is_scale(component: &ComponentBlueprint) -> bool {
    component.kind == SENSOR_SCALE.declaration().kind
}

/// Whether a component has a quantity that shifts its positions.
fn has_offset(component: &ComponentBlueprint) -> bool {
    let declaration = components::find(&component.kind).map(|kind| kind.declaration());
    let is_offset = |q: &model::Quantity| q.name == OFFSET && q.unit == "{position}";
    declaration.is_some_and(|d| d.parameters.iter().any(is_offset))
}

/// Whether it is cut at a tap, and so only a part of the axis.
fn is_cut(base: &Base) -> bool {
    let is_reading = matches!(base.part, Part::Reading(_));
    !is_reading && Slot::ALL.iter().any(|slot| !base.slots.contains_key(slot))
}

impl<'a> Written<'a> {
    fn new(
        o: &'a Outcome,
        last: &Candidate,
        blueprint: &Blueprint,
        (axis, given): (usize, &AxisBlueprint),
        others: Others,
        count: &'a AtomicU64,
    ) -> Option<Self> {
        let checked = blueprint.clone().check(COMPONENTS).ok()?;
        let now = checked.blueprint().axes.get(axis - 1)?;
        let tolerances: Vec<Tolerance> = now
            .components
            .iter()
            .filter(|c| !given.components.iter().any(|own| is_same(own, c)))
            .map(|c| Tolerance {
                name: format!("axis[{axis}].{}.*", c.name),
                deviation: Deviation::Relative(Thresholds::WRITTEN_DEVIATION),
            })
            .collect();
        let gain = o.task.base.gain_tolerance;
        let base = Base::white(&checked, (axis, o.task.base.part), &tolerances, gain).ok()?;
        let base = Base { late: o.task.base.late, ..base };
        // Other axes may not be written yet.
        let base = match o.task.base.joint() {
            Some(joint) if others == Others::AsFound => base.with_fronts(&joint.fronts()),
            _ => base,
        };
        // What each record has of its own is no part of the model and is taken out as before.
        let (disturbances, values) = disturbances(o, last);
        let chain = base.compose(&disturbances);
        let own = chain.parameters.len() - values.len();
        let mut start: Vec<f64> = std::iter::repeat_n(0.0, own).chain(values).collect();
        // When readings are taken is no part of a blueprint, and is what it was found to be.
        if let (Some(at), Some(late)) = (chain.own(LATE), last.late()) {
            start[at] = late;
        }
        Some(Self { o, base, chain, start, count })
    }

    fn judge(&self, theta: &[f64]) -> Option<Judged> {
        let data = &self.o.task.data;
        self.o.judge.judge(&self.chain, theta, data, self.o.sigma, self.count).ok()
    }

    fn tuned(&self) -> Option<Vec<f64>> {
        let data = &self.o.task.data;
        let fitter = Fitter { data, sigma: self.o.sigma, count: self.count, weights: None };
        fitter.fit(&self.chain, &self.start).ok().map(|fit| fit.theta)
    }
}

fn is_same(a: &ComponentBlueprint, b: &ComponentBlueprint) -> bool {
    a.kind == b.kind && a.name == b.name
}

/// The formulas of a candidate that only have terms of each record's own, and their coordinates.
fn disturbances<'a>(o: &'a Outcome, last: &Candidate) -> (Vec<&'a Formula>, Vec<f64>) {
    let (mut formulas, mut values) = (Vec::new(), Vec::new());
    for (slot, formula) in o.formulas(last).enumerate() {
        if formula.nuisance.is_some() && formula.pieces.is_empty() && formula.force.is_none() {
            formulas.push(formula);
            values.extend(&last.fit.theta[last.own(&o.library, slot)]);
        }
    }
    (formulas, values)
}

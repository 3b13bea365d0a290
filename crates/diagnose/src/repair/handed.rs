//! The model that is handed back, tuned and judged as it is written.
//!
//! A component does not always do to the letter what a fitted formula did. What is promised is
//! therefore what the written axis leaves of the logs, and its values are those that fit them.

use std::sync::atomic::AtomicU64;

use components::COMPONENTS;
use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint};

use super::retune;
use crate::base::Base;
use crate::chain::Chain;
use crate::fit::Fitter;
use crate::library::{Formula, Slot};
use crate::outcome::Outcome;
use crate::request::{Deviation, Tolerance};
use crate::score::Judged;
use crate::select::Candidate;

/// Mean square over that of the fitted formulas above which the written axis is tuned again.
const OFF: f64 = 1.02;
/// How far values of components that were found may be tuned again, relative (1 σ).
const FOUND: f64 = 0.2;

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
    // What is cut at a tap is only a part of the axis.
    if Slot::ALL.iter().any(|slot| !o.problem.base.slots.contains_key(slot)) {
        return None;
    }
    let count = AtomicU64::new(0);
    let read = |blueprint: &Blueprint| {
        let checked = blueprint.clone().check(COMPONENTS).ok()?;
        Written::new(o, last, &checked, (axis, given), &count)
    };
    let written = read(blueprint)?;
    let judged = written.judge(&written.start)?;
    if judged.training <= OFF * last.judged.training {
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

impl<'a> Written<'a> {
    fn new(
        o: &'a Outcome,
        last: &Candidate,
        checked: &CheckedBlueprint,
        (axis, given): (usize, &AxisBlueprint),
        count: &'a AtomicU64,
    ) -> Option<Self> {
        let now = checked.blueprint().axes.get(axis - 1)?;
        let tolerances: Vec<Tolerance> = now
            .components
            .iter()
            .filter(|c| !given.components.iter().any(|own| is_same(own, c)))
            .map(|c| Tolerance {
                name: format!("axis[{axis}].{}.*", c.name),
                deviation: Deviation::Relative(FOUND),
            })
            .collect();
        let gain = o.problem.base.gain_tolerance;
        let base = Base::white(checked, axis, &tolerances, gain).ok()?;
        // What each record has of its own is no part of the model and is taken out as before.
        let (disturbances, values) = disturbances(o, last);
        let chain = base.compose(&disturbances);
        let own = chain.parameters.len() - values.len();
        let start = std::iter::repeat_n(0.0, own).chain(values).collect();
        Some(Self { o, base, chain, start, count })
    }

    fn judge(&self, theta: &[f64]) -> Option<Judged> {
        let data = &self.o.problem.data;
        self.o.judge.judge(&self.chain, theta, data, self.o.sigma, self.count).ok()
    }

    fn tuned(&self) -> Option<Vec<f64>> {
        let data = &self.o.problem.data;
        let fitter = Fitter { data, sigma: self.o.sigma, count: self.count, weights: None };
        fitter.fit(&self.chain, &self.start).ok().map(|fit| fit.theta)
    }
}

fn is_same(a: &ComponentBlueprint, b: &ComponentBlueprint) -> bool {
    a.kind == b.kind && a.name == b.name
}

/// The formulas of a candidate that only have terms of each record's own, and their coordinates.
fn disturbances<'a>(o: &'a Outcome, last: &Candidate) -> (Vec<&'a Formula>, Vec<f64>) {
    let mut first = last.chain.parameters.iter().take_while(|p| p.is_base).count();
    let (mut formulas, mut values) = (Vec::new(), Vec::new());
    for (family, number) in &last.picks {
        let formula = &o.library[*family].formulas[*number];
        let range = first..first + formula.parameters.len();
        first = range.end;
        if formula.nuisance.is_some() && formula.pieces.is_empty() && formula.force.is_none() {
            formulas.push(formula);
            values.extend(&last.fit.theta[range]);
        }
    }
    (formulas, values)
}

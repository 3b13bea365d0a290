//! The usual step: one hit with held inputs, and that of one axis, whose signal goes from node to node.

use alloc::vec::Vec;

use super::{ALWAYS_ON, Past, Plan, System, Wire};
use crate::Tick;

/// The ends of a chain with one input, one output, and nodes that each turn the signal of the one
/// before into one signal.
#[derive(Clone, Copy)]
pub(super) struct Straight {
    input: Wire,
    output: Wire,
}

/// A node `y = gain·u + offset` of such a chain.
#[derive(Clone, Copy)]
pub(super) struct Affine {
    /// Cell of the gain; the offset's follows.
    gain: usize,
    /// Cell of y.
    output: usize,
}

/// What became of [`System::quick_step`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quick {
    /// The step is done.
    Done,
    /// The step is done, and an output is not finite.
    Broken,
    /// Nothing is done: it takes [`System::advance_noted`].
    Other,
}

impl Plan {
    /// The ends, if this is such a chain.
    pub(super) fn straight_chain(&self) -> Option<Straight> {
        let ([input], [output]) = (&self.inputs[..], &self.outputs[..]) else { return None };
        let mut signal = input.signal;
        for node in &self.nodes {
            let wiring = &node.wiring;
            if wiring.signals() != [signal] || wiring.outputs.len != 1 {
                return None;
            }
            signal = wiring.outputs.start;
        }
        let is_straight = signal == output.signal && !self.reads_back;
        is_straight.then_some(Straight { input: *input, output: *output })
    }

    /// The nodes, if this is such a chain, each is a gain and an offset, and none can be switched off.
    pub(super) fn affine_chain(&self) -> Vec<Affine> {
        let each = self.nodes.iter().map(|node| {
            let wiring = &node.wiring;
            let is_affine = node.component.is_affine() && node.enabled == ALWAYS_ON;
            (is_affine && (wiring.coefficients.len, wiring.state.len) == (2, 0))
                .then_some(Affine { gain: wiring.coefficients.start, output: wiring.outputs.start })
        });
        let all: Option<Vec<Affine>> = each.collect();
        all.filter(|_| self.straight.is_some()).unwrap_or_default()
    }
}

impl System {
    /// Whether it is one chain of gains and offsets only.
    #[inline(always)]
    #[must_use]
    pub fn is_affine(&self) -> bool {
        !self.plan.affine.is_empty()
    }

    /// Does what [`advance_noted`](Self::advance_noted) does with held inputs, if the chain is one of gains and
    /// offsets only, the step has no hit or one, and the output is a finite number; else it says `false`, and
    /// `advance_noted` does the step. It calls nothing and cannot panic.
    #[inline(always)]
    pub fn affine_step(&mut self, time: f64, from: f64, past: &mut Past) -> bool {
        let (limit, next) = self.reach_of(time);
        if next > limit {
            past.note_idle();
            return true;
        }
        let System { plan, context, .. } = self;
        let is_one = limit - next < 0.5 * plan.period;
        let Some(Straight { input, output }) = &plan.straight else { return false };
        let cells = &mut context.cells[..];
        let &mut [u, before, ..] = cells else { return false };
        if !is_one || context.dirty || plan.affine.is_empty() {
            return false;
        }
        let mut signal = input.unit.to_si(u);
        if let Some(cell) = cells.get_mut(input.signal) {
            *cell = signal;
        }
        for node in &plan.affine {
            let Some(&[gain, offset]) = cells.get(node.gain..).and_then(<[f64]>::first_chunk)
            else {
                return false;
            };
            signal = gain * signal + offset;
            let Some(cell) = cells.get_mut(node.output) else { return false };
            *cell = signal;
        }
        let value = output.unit.from_si(signal);
        let is_finite = value.abs() <= f64::MAX;
        if let ([_, y, ..], true) = (cells, is_finite) {
            *y = value;
            past.note_step(context.index, from, &[]);
            past.note_values(u, before);
            context.index = context.index.wrapping_add(1);
        }
        is_finite
    }

    /// Does what [`advance_noted`](Self::advance_noted) does with held inputs, if the step has no hit
    /// or one hit. If the chain is straight too, the signal stays in a register from input to output,
    /// and the loops over axes fall away.
    #[inline(always)]
    pub fn quick_step(&mut self, time: f64, from: f64, past: &mut Past) -> Quick {
        let (limit, next) = self.reach_of(time);
        if next > limit {
            past.note_idle();
            return Quick::Done;
        }
        let System { plan, context, .. } = self;
        let period = plan.period;
        // Nearer to the hit after the next one, the loop decides; it does for what is not finite too.
        let is_one = limit - next < 0.5 * period;
        if !is_one || context.dirty {
            return Quick::Other;
        }
        let Some(Straight { input, output }) = &plan.straight else {
            return self.one_hit(next, from, past);
        };
        let [u, y, ..] = &mut context.cells[..] else { return Quick::Other };
        past.note_step(context.index, from, &[]);
        past.note_values(*u, *y);
        let mut signal = input.unit.to_si(*u);
        let cells = &mut context.cells[..];
        cells[input.signal] = signal;
        plan.note_state(cells, past);
        context.index += 1;
        let tick = Tick { index: context.index, time: next, period };
        for node in &plan.nodes {
            signal = node.step_straight(cells, &tick, signal);
        }
        let value = output.unit.from_si(signal);
        // The variables begin with the input and the output.
        cells[1] = value;
        if value.abs() <= f64::MAX { Quick::Done } else { Quick::Broken }
    }

    /// The hit at the time `next`, of a chain of any form.
    #[inline(always)]
    fn one_hit(&mut self, next: f64, from: f64, past: &mut Past) -> Quick {
        let System { plan, context, .. } = self;
        let cells = &mut context.cells[..];
        past.note_step(context.index, from, &[]);
        plan.begin(cells, past);
        context.index += 1;
        plan.step(cells, &Tick { index: context.index, time: next, period: plan.period });
        if plan.show(cells, &mut past.outputs) { Quick::Done } else { Quick::Broken }
    }
}

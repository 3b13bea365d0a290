//! How the present outputs came about, so that it can be done again with other values.

use alloc::vec::Vec;
use core::ops::Range;

use super::{StepError, System};
use crate::Context;

/// What the last step of a [`System`] that had a hit began with, or that it is at rest: enough to
/// compute the present outputs, and those one hit before, once more.
///
/// [`System::advance_noted`] notes it; after each [`System::initialise`] it is
/// [`System::note_rest`] that does.
#[derive(Clone, Debug, PartialEq)]
pub struct Past {
    last: Last,
    /// Number of the last hit before the step.
    index: u64,
    /// Communication point at which the step began, in s.
    from: f64,
    /// An input had a slope in the step.
    sloped: bool,
    /// Values of the inputs in the step.
    pub(super) inputs: Vec<f64>,
    /// Values of the outputs before the step.
    pub(super) outputs: Vec<f64>,
    /// Slopes of the inputs in the step; of no meaning where none had one.
    slopes: Vec<f64>,
    /// State before the step, and the signals where one of them is read back.
    pub(super) state: Vec<f64>,
}

/// Where the present outputs come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Last {
    /// The state of rest; no step was done yet.
    Rest,
    /// The step that was noted.
    Step,
    /// An earlier step: the last one had no hit, so that nothing was computed.
    Idle,
}

impl Past {
    /// Whether the outputs are those at rest.
    #[must_use]
    pub fn is_rest(&self) -> bool {
        self.last == Last::Rest
    }

    /// Takes over everything of `other`, without allocating where the sizes agree.
    pub fn copy_from(&mut self, other: &Self) {
        (self.last, self.sloped) = (other.last, other.sloped);
        (self.index, self.from) = (other.index, other.from);
        self.inputs.clone_from(&other.inputs);
        self.outputs.clone_from(&other.outputs);
        self.slopes.clone_from(&other.slopes);
        self.state.clone_from(&other.state);
    }

    /// Length of [`to_bytes`](Self::to_bytes).
    #[must_use]
    pub fn byte_len(&self) -> usize {
        2 + 8 * (2 + self.numbers().count())
    }

    /// The past as bytes, little endian.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.byte_len());
        bytes.extend_from_slice(&[self.last as u8, u8::from(self.sloped)]);
        bytes.extend_from_slice(&self.index.to_le_bytes());
        for number in core::iter::once(&self.from).chain(self.numbers()) {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        bytes
    }

    fn numbers(&self) -> impl Iterator<Item = &f64> {
        self.inputs.iter().chain(&self.outputs).chain(&self.slopes).chain(&self.state)
    }

    /// A past of the same system as `self` from bytes; `None` where they are none of it.
    #[must_use]
    pub fn with_bytes(&self, bytes: &[u8]) -> Option<Self> {
        if bytes.len() != self.byte_len() {
            return None;
        }
        let ([last, sloped], tail) = bytes.split_first_chunk()?;
        let last = [Last::Rest, Last::Step, Last::Idle].get(usize::from(*last)).copied()?;
        let mut words =
            tail.chunks_exact(8).map(|word| <[u8; 8]>::try_from(word).unwrap_or_default());
        let index = u64::from_le_bytes(words.next()?);
        let mut numbers = words.map(f64::from_le_bytes);
        let from = numbers.next()?;
        let mut take = |count| numbers.by_ref().take(count).collect();
        let inputs = take(self.inputs.len());
        let outputs = take(self.outputs.len());
        let slopes = take(self.slopes.len());
        let state = take(self.state.len());
        Some(Self { last, index, from, sloped: *sloped != 0, inputs, outputs, slopes, state })
    }

    /// Notes that the step that follows has a hit, and the slopes; inputs without one here are held.
    #[inline(always)]
    pub(super) fn note_step(&mut self, index: u64, from: f64, slopes: &[f64]) {
        (self.last, self.index, self.from) = (Last::Step, index, from);
        self.sloped = !slopes.is_empty();
        if self.sloped {
            self.note_slopes(slopes);
        }
    }

    /// Notes the values of the only input and the only output.
    #[inline(always)]
    pub(super) fn note_values(&mut self, input: f64, output: f64) {
        if let ([u], [y]) = (&mut self.inputs[..], &mut self.outputs[..]) {
            (*u, *y) = (input, output);
        }
    }

    #[cold]
    fn note_slopes(&mut self, slopes: &[f64]) {
        let count = slopes.len().min(self.slopes.len());
        let (sloped, held) = self.slopes.split_at_mut(count);
        sloped.copy_from_slice(&slopes[..count]);
        held.fill(0.0);
    }

    /// Notes that a step had no hit.
    #[inline]
    pub(super) fn note_idle(&mut self) {
        self.last = Last::Idle;
    }
}

impl System {
    /// The past of a system that is at rest under its present inputs.
    #[must_use]
    pub fn past(&self) -> Past {
        let zeros = |count| alloc::vec![0.0; count];
        let (inputs, outputs) = self.shown();
        Past {
            last: Last::Rest,
            index: 0,
            from: 0.0,
            sloped: false,
            inputs: inputs.to_vec(),
            outputs: outputs.to_vec(),
            slopes: zeros(inputs.len()),
            state: zeros(self.noted().len()),
        }
    }

    /// Notes that the outputs are those at rest under the present inputs.
    pub fn note_rest(&self, past: &mut Past) {
        (past.last, past.index, past.from, past.sloped) = (Last::Rest, 0, 0.0, false);
        past.slopes.fill(0.0);
        past.state.fill(0.0);
        let (inputs, outputs) = self.shown();
        past.inputs.copy_from_slice(inputs);
        past.outputs.copy_from_slice(outputs);
    }

    /// The values of inputs and of outputs.
    #[inline]
    fn shown(&self) -> (&[f64], &[f64]) {
        let (inputs, rest) = self.context.cells.split_at(self.plan.inputs.len());
        (inputs, &rest[..self.plan.outputs.len()])
    }

    /// Where the context has what a step begins with: the state, and the signals where one of them is
    /// read back, but not the scratch behind them.
    #[inline]
    fn noted(&self) -> Range<usize> {
        let blocks = self.plan.blocks;
        let end = self.context.cells.len() - self.plan.widest;
        blocks[1]..if self.plan.reads_back { end } else { blocks[2] }
    }

    /// Computes in `scratch` the present outputs once more from `past`, after `change` has changed
    /// the values of inputs, and at rest of parameters, there. In a step the parameters are those it
    /// was done with, at rest the present ones.
    pub(super) fn again(
        &mut self,
        scratch: &mut Context,
        past: &Past,
        change: impl FnOnce(&mut [f64]),
    ) -> Result<(), StepError> {
        scratch.copy_from(&self.context);
        scratch.cells[..past.inputs.len()].copy_from_slice(&past.inputs);
        change(&mut scratch.cells[..self.plan.blocks[0]]);
        match past.last {
            Last::Rest => {
                let start = self.context.start;
                self.with(scratch, |system| system.initialise(start))
            }
            Last::Step => self.repeat(scratch, past, self.time()),
            Last::Idle => Ok(()),
        }
    }

    /// Computes in `scratch` the outputs at the hit before the present one; `false` where there was
    /// none, for then the system is at rest.
    pub(super) fn one_hit_before(
        &mut self,
        scratch: &mut Context,
        past: &Past,
    ) -> Result<bool, StepError> {
        let Some(before) = self.context.index.checked_sub(1) else { return Ok(false) };
        scratch.copy_from(&self.context);
        let (inputs, rest) = scratch.cells.split_at_mut(past.inputs.len());
        inputs.copy_from_slice(&past.inputs);
        rest[..past.outputs.len()].copy_from_slice(&past.outputs);
        if past.index < before {
            let time = self.context.start + before as f64 * self.plan.period;
            self.repeat(scratch, past, time)?;
        }
        Ok(true)
    }

    /// Does the step that was noted once more in `scratch`, up to this time.
    fn repeat(&mut self, scratch: &mut Context, past: &Past, to: f64) -> Result<(), StepError> {
        scratch.index = past.index;
        scratch.cells[self.noted()].copy_from_slice(&past.state);
        // The coefficients are still those of the step.
        scratch.dirty = false;
        let slopes = if past.sloped { &past.slopes[..] } else { &[] };
        self.with(scratch, |system| system.advance_along(to, past.from, slopes).map(|_| ()))
    }

    /// Runs with another context.
    fn with<T>(&mut self, context: &mut Context, run: impl FnOnce(&mut Self) -> T) -> T {
        core::mem::swap(&mut self.context, context);
        let done = run(self);
        core::mem::swap(&mut self.context, context);
        done
    }
}

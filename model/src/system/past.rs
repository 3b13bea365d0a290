//! How the present outputs came about, so that it can be done again with other values.

use alloc::vec::Vec;
use core::ops::Range;

use super::{StepError, System};
use crate::Context;

/// What the last step of a [`System`] began with, or that it is at rest: enough to compute the
/// present outputs once more with other values of the inputs.
///
/// Whoever wants that notes it before each step ([`System::note_step`]) and after each
/// [`System::initialise`] ([`System::note_rest`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Past {
    /// The outputs are those at rest, and not yet those of a step.
    rest: bool,
    /// Number of the last hit before the step.
    index: u64,
    /// Communication point at which the step began, in s.
    from: f64,
    /// Values of the inputs, in the order of the plan.
    inputs: Vec<f64>,
    /// An input had a slope in the step.
    sloped: bool,
    /// Slopes of the inputs in the step, by value reference; of no meaning where none had one.
    slopes: Vec<f64>,
    /// State and signals before the step.
    arena: Vec<f64>,
}

impl Past {
    /// Whether the outputs are those at rest.
    #[must_use]
    pub fn is_rest(&self) -> bool {
        self.rest
    }

    /// Takes over everything of `other`, without allocating where the sizes agree.
    pub fn copy_from(&mut self, other: &Self) {
        (self.rest, self.sloped) = (other.rest, other.sloped);
        (self.index, self.from) = (other.index, other.from);
        self.inputs.clone_from(&other.inputs);
        self.slopes.clone_from(&other.slopes);
        self.arena.clone_from(&other.arena);
    }

    /// Length of [`to_bytes`](Self::to_bytes).
    #[must_use]
    pub fn byte_len(&self) -> usize {
        2 + 8 * (2 + self.inputs.len() + self.slopes.len() + self.arena.len())
    }

    /// The past as bytes, little endian.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.byte_len());
        bytes.extend_from_slice(&[u8::from(self.rest), u8::from(self.sloped)]);
        bytes.extend_from_slice(&self.index.to_le_bytes());
        let numbers = self.inputs.iter().chain(&self.slopes).chain(&self.arena);
        for number in core::iter::once(&self.from).chain(numbers) {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        bytes
    }

    /// A past of the same system as `self` from bytes; `None` where their number is another.
    #[must_use]
    pub fn with_bytes(&self, bytes: &[u8]) -> Option<Self> {
        if bytes.len() != self.byte_len() {
            return None;
        }
        let ([rest, sloped], tail) = bytes.split_first_chunk()?;
        let (rest, sloped) = (*rest != 0, *sloped != 0);
        let mut words =
            tail.chunks_exact(8).map(|word| <[u8; 8]>::try_from(word).unwrap_or_default());
        let index = u64::from_le_bytes(words.next()?);
        let mut numbers = words.map(f64::from_le_bytes);
        let from = numbers.next()?;
        let mut take = |count| numbers.by_ref().take(count).collect();
        let inputs = take(self.inputs.len());
        let slopes = take(self.slopes.len());
        let arena = take(self.arena.len());
        Some(Self { rest, index, from, inputs, sloped, slopes, arena })
    }
}

impl System {
    /// The past of a system that is at rest under its present inputs.
    #[must_use]
    pub fn past(&self) -> Past {
        let plan = &self.plan;
        let inputs = plan.inputs.iter().map(|wire| self.context.cells[wire.variable]).collect();
        let width = plan.inputs.iter().map(|wire| wire.variable + 1).max().unwrap_or(0);
        let (slopes, arena) = (alloc::vec![0.0; width], alloc::vec![0.0; self.arena().len()]);
        Past { rest: true, index: 0, from: 0.0, inputs, sloped: false, slopes, arena }
    }

    /// Notes that the outputs are those at rest under the present inputs.
    pub fn note_rest(&self, past: &mut Past) {
        (past.rest, past.index, past.from, past.sloped) = (true, 0, 0.0, false);
        past.slopes.fill(0.0);
        past.arena.fill(0.0);
        self.note_inputs(past);
    }

    /// Notes what the next step begins with; to be called directly before
    /// [`advance`](Self::advance) or [`advance_along`](Self::advance_along), with the arguments of
    /// the latter. Inputs without a slope here are held. It allocates nothing.
    #[inline]
    pub fn note_step(&self, past: &mut Past, from: f64, slopes: &[f64]) {
        (past.rest, past.index, past.from) = (false, self.context.index, from);
        past.sloped = !slopes.is_empty();
        if past.sloped {
            let count = slopes.len().min(past.slopes.len());
            let (sloped, held) = past.slopes.split_at_mut(count);
            sloped.copy_from_slice(&slopes[..count]);
            held.fill(0.0);
        }
        self.note_inputs(past);
        past.arena.copy_from_slice(&self.context.cells[self.arena()]);
    }

    /// Where the context has state and signals: behind them is scratch.
    #[inline]
    fn arena(&self) -> Range<usize> {
        self.plan.blocks[1]..self.context.cells.len() - self.plan.widest
    }

    #[inline]
    fn note_inputs(&self, past: &mut Past) {
        for (input, wire) in past.inputs.iter_mut().zip(&self.plan.inputs) {
            *input = self.context.cells[wire.variable];
        }
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
        let blocks = self.plan.blocks;
        for (input, wire) in past.inputs.iter().zip(&self.plan.inputs) {
            scratch.cells[wire.variable] = *input;
        }
        change(&mut scratch.cells[..blocks[0]]);
        let (start, end) = (self.context.start, self.time());
        if !past.rest {
            scratch.index = past.index;
            scratch.cells[self.arena()].copy_from_slice(&past.arena);
            // The coefficients are still those of the step.
            scratch.dirty = false;
        }
        core::mem::swap(&mut self.context, scratch);
        let done = if past.rest {
            self.initialise(start)
        } else if past.sloped {
            self.advance_along(end, past.from, &past.slopes).map(|_| ())
        } else {
            self.advance(end).map(|_| ())
        };
        core::mem::swap(&mut self.context, scratch);
        done
    }
}

//! Where an instance of a component finds its cells.

use alloc::vec::Vec;
use core::ops::Range;

use crate::MAX_PORTS;

/// Input ports that an instance holds in place.
pub(crate) const FEW_PORTS: usize = 8;

/// Where an instance of a component finds its cells: coefficients, state and signals stand in this
/// order.
#[derive(Clone)]
pub struct Wiring {
    pub(crate) coefficients: Span,
    pub(crate) state: Span,
    /// Signals read by its input ports, as many as `input_count`, where they are few.
    pub(crate) inputs: [usize; FEW_PORTS],
    /// Signals read by its input ports, where they are more.
    pub(crate) many_inputs: Vec<usize>,
    pub(crate) input_count: usize,
    /// Signals written by its output ports.
    pub(crate) outputs: Span,
}

/// Some cells in a row.
#[derive(Clone, Copy)]
pub(crate) struct Span {
    pub(crate) start: usize,
    pub(crate) len: usize,
}

impl Span {
    pub(crate) fn range(self) -> Range<usize> {
        self.start..self.start + self.len
    }
}

impl From<Range<usize>> for Span {
    fn from(range: Range<usize>) -> Self {
        Self { start: range.start, len: range.len() }
    }
}

impl Wiring {
    /// Hands the slices of an instance - coefficients, state, inputs, outputs - to a component.
    #[inline(always)]
    pub(crate) fn apply(
        &self,
        cells: &mut [f64],
        component: impl FnOnce(&[f64], &mut [f64], &[f64], &mut [f64]),
    ) {
        if self.input_count == 1 {
            let input = [cells[self.inputs[0]]];
            let (coefficients, state, outputs) = self.cut(cells);
            component(coefficients, state, &input, outputs);
            return;
        }
        if self.input_count > FEW_PORTS {
            let mut inputs = [0.0; MAX_PORTS];
            let inputs = &mut inputs[..self.input_count.min(MAX_PORTS)];
            for (input, signal) in inputs.iter_mut().zip(&self.many_inputs) {
                *input = cells[*signal];
            }
            let (coefficients, state, outputs) = self.cut(cells);
            component(coefficients, state, inputs, outputs);
            return;
        }
        let mut inputs = [0.0; FEW_PORTS];
        let inputs = &mut inputs[..self.input_count];
        for (input, signal) in inputs.iter_mut().zip(&self.inputs) {
            *input = cells[*signal];
        }
        let (coefficients, state, outputs) = self.cut(cells);
        component(coefficients, state, inputs, outputs);
    }

    /// Hands the slices of an instance with one input, whose signal is given, to a component, and
    /// returns the signal of its one output.
    #[inline(always)]
    pub(crate) fn apply_straight(
        &self,
        cells: &mut [f64],
        input: f64,
        component: impl FnOnce(&[f64], &mut [f64], &[f64], &mut [f64]),
    ) -> f64 {
        let mut output = [0.0];
        let (front, state) = cells.split_at_mut(self.state.start);
        let coefficients = &front[self.coefficients.start..][..self.coefficients.len];
        component(coefficients, &mut state[..self.state.len], &[input], &mut output);
        let [output] = output;
        cells[self.outputs.start] = output;
        output
    }

    /// The signals that the input ports read.
    pub(crate) fn signals(&self) -> &[usize] {
        if self.many_inputs.is_empty() {
            &self.inputs[..self.input_count.min(FEW_PORTS)]
        } else {
            &self.many_inputs
        }
    }

    /// The signals that the input ports read, to be connected.
    pub(crate) fn signals_mut(&mut self) -> &mut [usize] {
        if self.many_inputs.is_empty() {
            &mut self.inputs[..self.input_count.min(FEW_PORTS)]
        } else {
            &mut self.many_inputs
        }
    }

    #[inline(always)]
    fn cut<'a>(&self, cells: &'a mut [f64]) -> (&'a [f64], &'a mut [f64], &'a mut [f64]) {
        let (cells, outputs) = cells.split_at_mut(self.outputs.start);
        let (cells, state) = cells.split_at_mut(self.state.start);
        let coefficients = &cells[self.coefficients.start..][..self.coefficients.len];
        (coefficients, &mut state[..self.state.len], &mut outputs[..self.outputs.len])
    }
}

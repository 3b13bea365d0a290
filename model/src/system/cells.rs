//! The blocks of a context while components run.

use super::{Node, Plan};
use crate::{MAX_PORTS, Tick};

/// Values, coefficients, state and signals, cut once per call.
pub(super) struct Cells<'a> {
    values: &'a [f64],
    coefficients: &'a [f64],
    state: &'a mut [f64],
    signals: &'a mut [f64],
}

impl<'a> Cells<'a> {
    /// The blocks of these cells, beginning where `blocks` says.
    #[inline(always)]
    pub(super) fn of(cells: &'a mut [f64], blocks: [usize; 3]) -> Self {
        let (values, rest) = cells.split_at_mut(blocks[0]);
        let (coefficients, rest) = rest.split_at_mut(blocks[1] - blocks[0]);
        let (state, signals) = rest.split_at_mut(blocks[2] - blocks[1]);
        Self { values, coefficients, state, signals }
    }

    /// Feeds the signals of the inputs with their values.
    #[inline(always)]
    pub(super) fn read_inputs(&mut self, plan: &Plan) {
        for (wire, value) in plan.inputs.iter().zip(self.values) {
            self.signals[wire.signal] = wire.unit.to_si(*value);
        }
    }

    /// As [`read_inputs`](Self::read_inputs), `elapsed` seconds along the slopes.
    pub(super) fn move_inputs(&mut self, plan: &Plan, slopes: &[f64], elapsed: f64) {
        for ((wire, value), slope) in plan.inputs.iter().zip(self.values).zip(slopes) {
            self.signals[wire.signal] = wire.unit.to_si(value + slope * elapsed);
        }
    }

    /// Puts every node at rest once, in the order of the path.
    pub(super) fn rest(&mut self, plan: &Plan) {
        for node in &plan.nodes {
            self.call(node, |node, coefficients, state, inputs, outputs| {
                node.component.rest(coefficients, inputs, state, outputs);
            });
        }
    }

    /// Steps a node.
    #[inline(always)]
    pub(super) fn step(&mut self, node: &Node, tick: Tick) {
        self.call(node, |node, coefficients, state, inputs, outputs| {
            node.component.step(coefficients, state, tick, inputs, outputs);
        });
    }

    /// Sets the outputs of all nodes to zero, so that rest does not depend on what was before.
    pub(super) fn forget_outputs(&mut self, plan: &Plan) {
        for node in &plan.nodes {
            self.signals[node.outputs.clone()].fill(0.0);
        }
    }

    /// FNV-1a over the bits of all signals.
    pub(super) fn fingerprint(&self) -> u64 {
        let mix = |hash: u64, x: &f64| (hash ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3);
        self.signals.iter().fold(0xcbf2_9ce4_8422_2325, mix)
    }

    /// Calls a node with its slices; switched off, its paths pass unchanged.
    #[inline(always)]
    fn call(
        &mut self,
        node: &Node,
        component: impl FnOnce(&Node, &[f64], &mut [f64], &[f64], &mut [f64]),
    ) {
        if node.enabled.is_some_and(|at| self.values[at] == 0.0) {
            for (output, input) in node.outputs.clone().zip(node.inputs).take(node.paths) {
                self.signals[output] = self.signals[input];
            }
            return;
        }
        let coefficients = &self.coefficients[node.coefficients.clone()];
        let state = &mut self.state[node.state.clone()];
        if let (1, [input, ..]) = (node.input_count, node.inputs) {
            let inputs = [self.signals[input]];
            let outputs = &mut self.signals[node.outputs.clone()];
            component(node, coefficients, state, &inputs, outputs);
            return;
        }
        let mut inputs = [0.0; MAX_PORTS];
        let inputs = &mut inputs[..node.input_count];
        for (input, signal) in inputs.iter_mut().zip(&node.inputs) {
            *input = self.signals[*signal];
        }
        component(node, coefficients, state, inputs, &mut self.signals[node.outputs.clone()]);
    }
}

/// A seed as the component sees it: mixed with the component's place (`axis[2].noise`), so that two
/// of them never draw the same numbers, whatever their seeds. A number from 1 to 2.
pub(super) fn own_seed(seed: f64, place: &str) -> f64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in seed.to_bits().to_le_bytes().into_iter().chain(place.bytes()) {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    // Two rounds of mixing spread the last bytes over all bits.
    hash = (hash ^ (hash >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    hash = (hash ^ (hash >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    f64::from_bits(0x3ff0_0000_0000_0000 | (hash ^ (hash >> 32)) >> 12)
}

#[cfg(test)]
mod tests {
    use super::own_seed;

    #[test]
    fn seeds_differ_by_value_and_by_place() {
        let places = ["axis[1].noise", "axis[2].noise", "axis[1].floor", "axis[12].noise"];
        let seeds = [0.0, -0.0, 1.0, 2.0, 1e300];
        let all: alloc::vec::Vec<f64> =
            places.iter().flat_map(|p| seeds.map(|s| own_seed(s, p))).collect();
        for (n, one) in all.iter().enumerate() {
            assert!((1.0..2.0).contains(one));
            assert!(!all[..n].contains(one), "{n}");
        }
        assert_eq!(own_seed(3.0, "axis[1].noise"), own_seed(3.0, "axis[1].noise"));
    }
}

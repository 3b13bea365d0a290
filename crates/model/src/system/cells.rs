//! The cells of a context while components run.

use super::{Node, Past, Plan, Wire};
use crate::{Tick, fnv_64};

impl Plan {
    /// Feeds the signals of the inputs with their values.
    #[inline]
    pub(super) fn read_inputs(&self, cells: &mut [f64]) {
        for (input, wire) in self.inputs.iter().enumerate() {
            cells[wire.signal] = wire.unit.to_si(cells[input]);
        }
    }

    /// Feeds the signals of the inputs with their values, and notes the values and the state.
    #[inline(always)]
    pub(super) fn begin(&self, cells: &mut [f64], past: &mut Past) {
        self.note_state(cells, past);
        let (values, rest) = cells.split_at_mut(self.blocks[0]);
        for ((value, wire), noted) in values.iter().zip(&self.inputs).zip(&mut past.inputs) {
            *noted = *value;
            rest[wire.signal - self.blocks[0]] = wire.unit.to_si(*value);
        }
    }

    /// Shows the signals as values of the outputs, and notes what these were before where there is
    /// room for it. Whether all of them are finite numbers.
    #[inline(always)]
    pub(super) fn show(&self, cells: &mut [f64], noted: &mut [f64]) -> bool {
        let (values, rest) = cells.split_at_mut(self.blocks[0]);
        let values = &mut values[self.inputs.len()..];
        // Zero times a number is zero, of whatever sign, unless the number is not finite.
        let mut zero = 0.0;
        let mut show = |value: &mut f64, wire: &Wire| {
            *value = wire.unit.from_si(rest[wire.signal - self.blocks[0]]);
            zero += 0.0 * *value;
        };
        if noted.len() == self.outputs.len() {
            for ((value, wire), noted) in values.iter_mut().zip(&self.outputs).zip(noted) {
                *noted = *value;
                show(value, wire);
            }
        } else {
            values.iter_mut().zip(&self.outputs).for_each(|(value, wire)| show(value, wire));
        }
        zero == 0.0
    }

    /// Notes the state.
    #[inline(always)]
    pub(super) fn note_state(&self, cells: &[f64], past: &mut Past) {
        if !past.state.is_empty() {
            // The signals, which may be part of it, follow the state.
            let state = &cells[self.blocks[1]..][..past.state.len()];
            copy(&mut past.state, state);
        }
    }

    /// Feeds the signals of the inputs with their values `elapsed` seconds along the slopes.
    pub(super) fn move_inputs(&self, cells: &mut [f64], slopes: &[f64], elapsed: f64) {
        for ((input, wire), slope) in self.inputs.iter().enumerate().zip(slopes) {
            cells[wire.signal] = wire.unit.to_si(cells[input] + slope * elapsed);
        }
    }

    /// Puts every node at rest once, in the order of the path.
    pub(super) fn rest(&self, cells: &mut [f64]) {
        for node in &self.nodes {
            if node.is_off(cells) {
                node.pass(cells);
                continue;
            }
            node.wiring.apply(cells, |coefficients, state, inputs, outputs| {
                node.component.rest(coefficients, inputs, state, outputs);
            });
        }
    }

    /// Steps every node, in the order of the path.
    #[inline(always)]
    pub(super) fn step(&self, cells: &mut [f64], tick: &Tick) {
        for node in &self.nodes {
            if node.is_off(cells) {
                node.pass(cells);
            } else {
                node.component.step_within(&node.wiring, cells, tick);
            }
        }
    }

    /// Steps every node up to the last hit at or before `limit`; returns its number. Inputs move
    /// along their slopes from the time at which `elapsed` is zero.
    #[inline(never)]
    pub(super) fn steps(
        &self,
        cells: &mut [f64],
        (mut index, limit): (u64, f64),
        at: impl Fn(u64) -> f64,
        elapsed: impl Fn(f64) -> f64,
        slopes: &[f64],
    ) -> u64 {
        let mut next = at(index + 1);
        while next <= limit {
            if !slopes.is_empty() {
                self.move_inputs(cells, slopes, elapsed(at(index)));
            }
            index += 1;
            self.step(cells, &Tick { index, time: next, period: self.period });
            next = at(index + 1);
        }
        index
    }

    /// Sets the outputs of all nodes to zero, so that rest does not depend on what was before.
    pub(super) fn forget_outputs(&self, cells: &mut [f64]) {
        for node in &self.nodes {
            cells[node.wiring.outputs.range()].fill(0.0);
        }
    }

    /// FNV-1a over the bits of all signals.
    pub(super) fn fingerprint(&self, cells: &[f64]) -> u64 {
        fnv_64(cells[self.blocks[2]..].iter().map(|x| x.to_bits()))
    }
}

impl Node {
    #[inline(always)]
    fn is_off(&self, cells: &[f64]) -> bool {
        // Zero of whatever sign has no other bit than that of the sign.
        cells.get(self.enabled).is_some_and(|enabled| enabled.to_bits() << 1 == 0)
    }

    /// One hit within a straight chain; returns the signal behind it.
    #[inline(always)]
    pub(super) fn step_straight(&self, cells: &mut [f64], tick: &Tick, signal: f64) -> f64 {
        if self.is_off(cells) {
            self.pass(cells);
            return signal;
        }
        self.component.step_straight(&self.wiring, cells, tick, signal)
    }

    /// Switched off, its paths pass unchanged.
    #[inline(never)]
    fn pass(&self, cells: &mut [f64]) {
        let outputs = self.wiring.outputs.range();
        for (output, input) in outputs.zip(self.wiring.signals()).take(self.paths) {
            cells[output] = cells[*input];
        }
    }
}

/// Copies a slice into one of the same length, without a call where it has at most one number.
#[inline(always)]
pub(super) fn copy(to: &mut [f64], from: &[f64]) {
    match (to, from) {
        ([], []) => {}
        ([to], [from]) => *to = *from,
        (to, from) => to.copy_from_slice(from),
    }
}

/// A seed as the component sees it: mixed with the component's place (`axis[2].noise`), so that two
/// of them never draw the same numbers, whatever their seeds. A number from 1 to 2.
pub(super) fn own_seed(seed: f64, place: &str) -> f64 {
    let mut hash = fnv_64(seed.to_bits().to_le_bytes().into_iter().chain(place.bytes()));
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

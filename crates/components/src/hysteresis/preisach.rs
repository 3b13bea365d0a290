//! Discrete Preisach hysteresis with a step that costs the same for any number of relays.
//!
//! ```text
//! y = offset + Σ_{j ≤ i} mu_ij·γ_ij,   γ_ij = 1 once u ≥ t_i, 0 once u < t_j, else unchanged
//! t_k = low + k·(high − low)/N,   k = 1 … N
//! ```
//!
//! * mu in position, ≥ 0: the N(N+1)/2 weights of the relays row by row, (1,1), (2,1), (2,2),
//!   (3,1)…; low, high in command: the range that the N levels divide.
//! * What the relays remember are the command's extrema that no larger one has wiped out. They are
//!   kept as a stack, each with the output at its time. A rise from the minimum of level b to level
//!   a adds `T(a, b) = Σ_{i ≤ a, j > b} mu_ij`, a fall from a to b takes it away; T is a table made
//!   once. So a step is one difference of two numbers, apart from the wiping, which removes each
//!   extremum once: O(1) on average, and the output returns to the same bits at a return point.
//! * State: the stack. At rest: all relays off, then moved monotonically to the command.
//!
//! Limits: independent of rate; the output has stairs of one level's height; relays that are
//! symmetric about zero (off = −1) are this model with other weights and offset.
//!
//! Source: I. D. Mayergoyz, Mathematical Models of Hysteresis and Their Applications, Elsevier
//! 2003, ch. 1 (the table is the Everett function).

use libm::{floor, sqrt};
use model::{
    Component, Conversion, Declaration, Inverse, Quantity, Sizes, Stage, Structural, Tick,
    Violation,
};

use super::prandtl_ishlinskii::OFFSET;
use crate::rules::{WRONG_LENGTH, require, require_at};
use crate::{effects, phenomena};

/// The component `preisach`.
pub struct Preisach;

static DECLARATION: Declaration = Declaration {
    kind: "preisach",
    name: "hysteresis",
    summary: "Discrete Preisach hysteresis: weighted relays, in constant time per step",
    equation: "y = offset + sum(mu[i,j]*relay[i,j]), j <= i; a relay is on once u >= t[i] and off \
               once u < t[j]; t[k] = low + k*(high - low)/N",
    reference: "I. D. Mayergoyz, Mathematical Models of Hysteresis and Their Applications, 2003",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::HYSTERESIS),
    phenomena: &[&phenomena::HYSTERESIS],
    structure: &STRUCTURE,
    parameters: &PARAMETERS,
    ..Declaration::PATH
};

/// Structure of the Preisach model.
pub(super) const STRUCTURE: [Structural; 1] =
    [Structural::count("relays", "Number of relays, N*(N + 1)/2", 1, 32_896)];

/// Parameters of the Preisach model.
pub(super) const PARAMETERS: [Quantity; 4] = [
    Quantity::new("mu", "{position}", "Weight of each relay, row by row").min(0.0).per(0).fitted(),
    Quantity::new("low", "{command}", "Command below which all relays are off"),
    Quantity::new("high", "{command}", "Command from which on all relays are on"),
    OFFSET,
];

/// Number of levels of this many relays; their triangle may be incomplete.
fn levels(relays: usize) -> usize {
    floor((sqrt(8.0 * relays as f64 + 1.0) - 1.0) / 2.0) as usize
}

/// Fills T(a, b), a row of length N + 1 for each a, from the weights.
fn accumulate(mu: &[f64], levels: usize, table: &mut [f64]) {
    let width = levels + 1;
    let mut done: &[f64] = &[];
    let mut rest = table;
    for a in 0..width {
        let Some((row, next)) = core::mem::take(&mut rest).split_at_mut_checked(width) else {
            return;
        };
        row.fill(0.0);
        // Row a of the weights holds j = 1 … a; summed from the end it gives the new part of T(a,
        // b).
        let weights = mu.get(a * a.saturating_sub(1) / 2..a * (a + 1) / 2).unwrap_or_default();
        let mut sum = 0.0;
        for b in (0..a).rev() {
            sum += weights.get(b).copied().unwrap_or(0.0);
            row[b] = sum + done.get(b).copied().unwrap_or(0.0);
        }
        (done, rest) = (row, next);
    }
}

/// `low | levels per command | offset | table`.
pub(super) struct Parts<'a> {
    pub(super) low: f64,
    pub(super) per_command: f64,
    pub(super) offset: f64,
    table: &'a [f64],
    pub(super) levels: usize,
}

impl Parts<'_> {
    pub(super) fn new(coefficients: &[f64], states: usize) -> Option<Parts<'_>> {
        let (&[low, per_command, offset], table) = coefficients.split_first_chunk::<3>()?;
        Some(Parts { low, per_command, offset, table, levels: (states / 2).checked_sub(3)? })
    }

    /// How many thresholds the command has reached.
    fn level(&self, u: f64) -> f64 {
        // A cast saturates: the level is from 0 to N for any command.
        let level = floor((u - self.low) * self.per_command) as usize;
        level.min(self.levels) as f64
    }

    fn sum(&self, upper: f64, lower: f64) -> f64 {
        let at = upper as usize * (self.levels + 1) + lower as usize;
        self.table.get(at).copied().unwrap_or(0.0)
    }
}

/// The stack of extrema: `depth | unused | (level, output) …`. Even entries are minima, the first
/// one the level 0 with all relays off; odd ones are maxima; the last one is the present command.
pub(super) struct Stack<'a> {
    depth: &'a mut f64,
    entries: &'a mut [[f64; 2]],
}

impl Stack<'_> {
    pub(super) fn new(state: &mut [f64]) -> Option<Stack<'_>> {
        let (head, entries) = state.split_first_chunk_mut::<2>()?;
        let (entries, _) = entries.as_chunks_mut::<2>();
        let [depth, _] = head;
        Some(Stack { depth, entries })
    }

    /// Where the stack would end at a level, and the relays' sum there.
    #[inline]
    fn find(&self, level: f64, parts: &Parts<'_>) -> (usize, f64) {
        let mut top = (*self.depth as usize).min(self.entries.len().saturating_sub(1));
        let entry = |i: usize| self.entries.get(i).copied().unwrap_or_default();
        let [present, output] = entry(top);
        if level == present {
            return (top, output);
        }
        let rising = level > present;
        if rising == top.is_multiple_of(2) {
            top += 1;
        }
        // An extremum that is reached again wipes out itself and the one behind it.
        let wiped = |extremum: f64| if rising { level >= extremum } else { level <= extremum };
        while top >= 2 && wiped(entry(top - 2)[0]) && !(rising && top < 3) {
            top -= 2;
        }
        let output = match top.checked_sub(1).map(entry) {
            None => 0.0,
            Some([from, output]) if rising => output + parts.sum(level, from),
            Some([from, output]) => output - parts.sum(from, level),
        };
        (top, output)
    }

    /// The relays' sum at a level; the stack stays.
    pub(super) fn peek(&self, level: f64, parts: &Parts<'_>) -> f64 {
        self.find(level, parts).1
    }

    /// The present level.
    pub(super) fn level(&self) -> f64 {
        self.entries.get(*self.depth as usize).map_or(0.0, |[level, _]| *level)
    }

    /// Moves to a level and returns the relays' sum.
    #[inline]
    pub(super) fn advance(&mut self, level: f64, parts: &Parts<'_>) -> f64 {
        let (top, output) = self.find(level, parts);
        if let Some(entry) = self.entries.get_mut(top) {
            *entry = [level, output];
        }
        *self.depth = top as f64;
        output
    }
}

impl Component for Preisach {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("mu", &[0.5, 1.0, 0.2, 0.1, 0.3, 0.7]),
            ("low", &[-20.0]),
            ("high", &[120.0]),
            ("offset", &[0.3]),
        ]
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::iteration("inverse-preisach")] }
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let levels = levels(DECLARATION.length(0, structure));
        // Nested extrema have different levels, so there are at most N + 1, and the base.
        Sizes { coefficients: 3 + (levels + 1) * (levels + 1), states: 2 + 2 * (levels + 2) }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (Some((mu, &[low, high, offset])), Some((head, table))) =
            (parameters.split_last_chunk::<3>(), coefficients.split_first_chunk_mut::<3>())
        else {
            return Err(WRONG_LENGTH);
        };
        let levels = levels(mu.len());
        require(
            levels * (levels + 1) / 2 == mu.len(),
            "mu",
            mu.len() as f64,
            "the number of weights is not N*(N + 1)/2 (1, 3, 6, 10, … 7260); give a whole triangle",
        )?;
        for (index, weight) in mu.iter().enumerate() {
            require_at(*weight >= 0.0, "mu", index, *weight, "weights are zero or positive")?;
        }
        require(low < high, "low", low, "must be below high")?;
        *head = [low, levels as f64 / (high - low), offset];
        accumulate(mu, levels, table);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [y]) = (inputs, outputs) else { return };
        let Some(parts) = Parts::new(coefficients, state.len()) else { return };
        state.fill(0.0);
        let Some(mut stack) = Stack::new(state) else { return };
        *y = parts.offset + stack.advance(parts.level(u), &parts);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[u], [y]) = (inputs, outputs) else { return };
        let Some(parts) = Parts::new(coefficients, state.len()) else { return };
        let Some(mut stack) = Stack::new(state) else { return };
        *y = parts.offset + stack.advance(parts.level(u), &parts);
    }
}

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use super::*;
    use crate::testing::{Instance, Random};

    /// Every relay by itself.
    struct Relays {
        on: Vec<bool>,
        mu: Vec<f64>,
        levels: usize,
    }

    impl Relays {
        fn step(&mut self, level: usize) -> f64 {
            let mut sum = 0.0;
            let mut at = 0;
            for i in 1..=self.levels {
                for j in 1..=i {
                    if level >= i {
                        self.on[at] = true;
                    } else if level < j {
                        self.on[at] = false;
                    }
                    sum += if self.on[at] { self.mu[at] } else { 0.0 };
                    at += 1;
                }
            }
            sum
        }
    }

    fn both(levels: usize, seed: u64) -> (Instance, Relays) {
        let count = levels * (levels + 1) / 2;
        let mu = Random::new(seed).signal(0.0, 1.0, count);
        let p: Vec<f64> = mu.iter().copied().chain([-20.0, 120.0, 3.0]).collect();
        let model = Instance::new(&Preisach, &[count as f64], &p, 1e-3).unwrap();
        (model, Relays { on: vec![false; count], mu, levels })
    }

    #[test]
    fn is_the_sum_of_its_relays() {
        for (levels, seed) in [(1, 1), (2, 2), (5, 3), (13, 4), (40, 5)] {
            let (mut model, mut relays) = both(levels, seed);
            let width = 140.0 / levels as f64;
            let level = |u: f64| (((u + 20.0) / width).floor().max(0.0) as usize).min(levels);
            let mut random = Random::new(seed);
            let mut u = 30.0;
            let start = relays.step(level(u));
            assert!((model.rest(&[u]) - 3.0 - start).abs() < 1e-10);
            for k in 0..3000 {
                // Jumps, and walks that go deep into minor loops.
                u = if k % 50 == 0 {
                    random.between(-40.0, 140.0)
                } else {
                    u + random.between(-9.0, 9.0)
                };
                let expected = 3.0 + relays.step(level(u));
                let found = model.step(&[u]);
                assert!(
                    (found - expected).abs() < 1e-10,
                    "{levels} levels, {u}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn the_deepest_nest_of_extrema_fits() {
        let (mut model, mut relays) = both(20, 6);
        model.rest(&[-30.0]);
        let width = 7.0;
        for k in 0..20 {
            // 20, 0+, 19, 1, 18, 2, …: each excursion one level smaller than the last.
            let level = if k % 2 == 0 { 20 - k / 2 } else { k / 2 + 1 };
            let u = -20.0 + (level as f64 + 0.5) * width;
            assert!((model.step(&[u]) - 3.0 - relays.step(level)).abs() < 1e-10, "{level}");
        }
        assert_eq!(model.step(&[130.0]) - 3.0, model.rest(&[130.0]) - 3.0);
    }

    #[test]
    fn returns_to_the_same_bits_at_a_return_point() {
        let (mut model, _) = both(40, 7);
        model.rest(&[0.0]);
        for u in [110.0, 5.0, 80.0] {
            model.step(&[u]);
        }
        let before = model.step(&[80.0]);
        for u in [30.0, 60.0, 41.0, 55.0, 20.0, 79.0] {
            model.step(&[u]);
        }
        assert_eq!(model.step(&[80.0]).to_bits(), before.to_bits());
    }

    #[test]
    fn incomplete_triangles_are_refused() {
        let p = [1.0, 1.0, 0.0, 1.0, 0.0];
        let error = Instance::new(&Preisach, &[2.0], &p, 1e-3).err();
        assert_eq!(error.map(|v| (v.quantity, v.value)), Some(("mu", 2.0)));
    }

    #[test]
    fn a_range_without_width_and_negative_weights_are_refused() {
        let refused = |p: [f64; 4]| {
            Instance::new(&Preisach, &[1.0], &p, 1e-3).err().map(|v| (v.quantity, v.value))
        };
        assert_eq!(refused([1.0, 5.0, 5.0, 0.0]), Some(("low", 5.0)));
        assert_eq!(refused([1.0, 6.0, 5.0, 0.0]), Some(("low", 6.0)));
        assert_eq!(refused([-1.0, 0.0, 5.0, 0.0]), Some(("mu", -1.0)));
        assert_eq!(refused([0.0, 0.0, 5.0, 0.0]), None);
    }

    #[test]
    fn memory_is_that_of_the_table_and_of_the_deepest_stack() {
        // 3 levels: 4 x 4 sums behind 3 numbers; at most 5 extrema behind 2 numbers.
        let sizes = Preisach.sizes(&[6.0], 1e-3);
        assert_eq!((sizes.coefficients, sizes.states), (19, 12));
    }
}

//! The inverse of a discrete Preisach model, found by bisection over its levels.
//!
//! The inverse carries a copy of the forward model. The output rises with the level, so at each step
//! `⌈lg₂(N + 1)⌉` looks at the table find the two levels around the wanted position; the nearer one
//! is taken, the present one where both are as near, and the copy makes that step itself. The
//! command is the middle of the level: `low + (level + ½)·(high − low)/N`.
//!
//! Error: the model has stairs, and only their heights can be reached. Within the range that the
//! relays reach, the position is off by at most half a stair, which is at most half of the greatest
//! sum of a row or a column of the weights; beyond it the inverse gives the nearest end. While a
//! position is held, a step back over a reversal may come nearer still: the error never grows, and
//! the command comes to rest.
//!
//! * Parameters, structure and state: those of [`Preisach`]. At rest: on the virgin curve.
//!
//! Source: R. V. Iyer, X. Tan, P. S. Krishnaprasad, IEEE Transactions on Automatic Control 50
//! (2005) 798–810.

use model::{Component, Conversion, Declaration, Sizes, Stage, Tick, Violation};

use super::preisach::{PARAMETERS, Parts, Preisach, STRUCTURE, Stack};

/// The component `inverse-preisach`.
pub struct InversePreisach;

static DECLARATION: Declaration = Declaration {
    kind: "inverse-preisach",
    name: "feedforward",
    summary: "Inverse of a discrete Preisach model, by bisection over its levels",
    equation: "|preisach(u) - y| is least; u = low + (level + 1/2)*(high - low)/N",
    reference: "R. V. Iyer, X. Tan, P. S. Krishnaprasad, IEEE Trans. Automatic Control 50 (2005) \
                798-810",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    structure: &STRUCTURE,
    parameters: &PARAMETERS,
    ..Declaration::PATH
};

/// The level whose output is nearest to the wanted sum of the relays.
fn nearest(stack: &Stack<'_>, parts: &Parts<'_>, wanted: f64) -> f64 {
    // The output reaches the wanted one at `above`, not yet at `below`.
    let (mut below, mut above) = (0, parts.levels);
    if stack.peek(0.0, parts) >= wanted {
        above = 0;
    }
    while above > below + 1 {
        let middle = below + (above - below) / 2;
        if stack.peek(middle as f64, parts) >= wanted {
            above = middle;
        } else {
            below = middle;
        }
    }
    let error = |level: usize| (stack.peek(level as f64, parts) - wanted).abs();
    let best = if error(below) < error(above) { below } else { above };
    let present = stack.level();
    if (stack.peek(present, parts) - wanted).abs() <= error(best) { present } else { best as f64 }
}

impl InversePreisach {
    fn move_to(coefficients: &[f64], state: &mut [f64], y: f64) -> Option<f64> {
        let parts = Parts::new(coefficients, state.len())?;
        let mut stack = Stack::new(state)?;
        let level = nearest(&stack, &parts, y - parts.offset);
        stack.advance(level, &parts);
        Some(parts.low + (level + 0.5) / parts.per_command)
    }
}

impl Component for InversePreisach {
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

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        Preisach.sizes(structure, period)
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        Preisach.prepare(structure, parameters, period, coefficients)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[y], [u]) = (inputs, outputs) else { return };
        state.fill(0.0);
        if let Some(command) = Self::move_to(coefficients, state, y) {
            *u = command;
        }
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[y], [u]) = (inputs, outputs) else { return };
        if let Some(command) = Self::move_to(coefficients, state, y) {
            *u = command;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;
    use crate::testing::{Instance, Random};

    /// Weights of N levels, and the greatest sum of a row or a column.
    fn weights(levels: usize, seed: u64) -> (Vec<f64>, f64) {
        let mu = Random::new(seed).signal(0.0, 1.0, levels * (levels + 1) / 2);
        let (mut rows, mut columns) = (std::vec![0.0; levels], std::vec![0.0; levels]);
        let places = (0..levels).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for ((i, j), w) in places.zip(&mu) {
            rows[i] += w;
            columns[j] += w;
        }
        let most = rows.iter().chain(&columns).fold(0.0, |a: f64, b| a.max(*b));
        (mu, most)
    }

    #[test]
    fn the_inverse_before_the_machine_is_off_by_half_a_stair_at_most() {
        for (levels, seed) in [(1, 1), (2, 2), (7, 3), (40, 4), (120, 5)] {
            let (mu, stair) = weights(levels, seed);
            let range: f64 = mu.iter().sum();
            let p: Vec<f64> = mu.iter().copied().chain([-20.0, 120.0, 3.0]).collect();
            let count = [mu.len() as f64];
            let mut machine = Instance::new(&Preisach, &count, &p, 1e-3).unwrap();
            let mut inverse = Instance::new(&InversePreisach, &count, &p, 1e-3).unwrap();
            let bound = 0.5 * stair * (1.0 + 1e-12) + 1e-9 * range;
            let first = 3.0 + 0.4 * range;
            assert!((machine.rest(&[inverse.rest(&[first])]) - first).abs() <= bound);
            for y in Random::new(seed).signal(3.0, 3.0 + range, 3000) {
                let found = machine.step(&[inverse.step(&[y])]);
                assert!((found - y).abs() <= bound, "{levels} levels: {found} {y} {bound}");
            }
        }
    }

    #[test]
    fn a_held_position_is_never_left_again_and_the_ends_are_reached() {
        let (mu, _) = weights(20, 9);
        let range: f64 = mu.iter().sum();
        let p: Vec<f64> = mu.iter().copied().chain([0.0, 100.0, 0.0]).collect();
        let mut inverse = Instance::new(&InversePreisach, &[210.0], &p, 1e-3).unwrap();
        let mut machine = Instance::new(&Preisach, &[210.0], &p, 1e-3).unwrap();
        machine.rest(&[inverse.rest(&[0.0])]);
        for y in Random::new(2).signal(0.0, range, 200) {
            let mut error = f64::INFINITY;
            let mut command = f64::NAN;
            for k in 0..40 {
                let u = inverse.step(&[y]);
                let now = (machine.step(&[u]) - y).abs();
                assert!(now <= error + 1e-12 * range, "step {k} to {y}: {now} after {error}");
                assert!(k < 30 || u == command, "{y} is not held");
                (error, command) = (now, u);
            }
        }
        assert_eq!(inverse.step(&[2.0 * range]), 102.5);
        assert_eq!(inverse.step(&[-range]), 2.5);
    }

    #[test]
    fn of_commands_that_give_the_same_position_the_present_one_stays() {
        // One relay alone, on from 40 V and off below 10 V: between them the position says nothing.
        let p = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 40.0, 0.0];
        let mut inverse = Instance::new(&InversePreisach, &[10.0], &p, 1e-3).unwrap();
        assert_eq!(inverse.rest(&[0.0]), 5.0);
        assert_eq!([inverse.step(&[0.0]), inverse.step(&[1.0])], [5.0, 45.0]);
        assert_eq!([inverse.step(&[1.0]), inverse.step(&[1.0])], [45.0, 45.0]);
        assert_eq!([inverse.step(&[0.0]), inverse.step(&[0.0])], [5.0, 5.0]);
    }
}

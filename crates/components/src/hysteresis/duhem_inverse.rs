//! The inverses of the Duhem and the Dahl model, solved at each step.
//!
//! `forward(u) = y` for the command u, with the exact step of the model; see
//! [`numeric_inverse`](super::numeric_inverse) for the method. The models have no rate, so the
//! command is exact to 1e-12 of its range: the position to 1e-12 of the range times the steepest
//! slope.
//!
//! Limits: a branch must rise right after a reversal: `2·initial > slope` (Duhem),
//! `gain·length > 2·height` (Dahl).

use model::{Conversion, Declaration, Stage, Violation};

use super::dahl::{Dahl, PARAMETERS as D};
use super::duhem::{Duhem, Law, PARAMETERS as P};
use super::numeric_inverse::{Forward, NumericInverse, Rates};
use super::rate_dependent_play::{COMMAND_MAX, COMMAND_MIN};
use crate::rules::{WRONG_LENGTH, require};

/// The component `inverse-duhem`.
pub static INVERSE_DUHEM: NumericInverse<Duhem> =
    NumericInverse { forward: &Duhem, declaration: &DUHEM };

/// The component `inverse-dahl`.
pub static INVERSE_DAHL: NumericInverse<Dahl> =
    NumericInverse { forward: &Dahl, declaration: &DAHL };

static DUHEM: Declaration = Declaration {
    kind: "inverse-duhem",
    name: "feedforward",
    summary: "Inverse of a Duhem model, solved at each step",
    equation: "duhem(u) = y",
    reference: "B. D. Coleman, M. L. Hodgdon, Int. J. Eng. Sci. 24 (1986) 897-919 (the model)",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    parameters: &[P[0], P[1], P[2], P[3], COMMAND_MIN, COMMAND_MAX],
    ..Declaration::PATH
};

static DAHL: Declaration = Declaration {
    kind: "inverse-dahl",
    summary: "Inverse of a Dahl model, solved at each step",
    equation: "dahl(u) = y",
    reference: "P. R. Dahl, Aerospace Corp. TOR-0158(3107-18)-1, 1968 (the model)",
    parameters: &[D[0], D[1], D[2], D[3], COMMAND_MIN, COMMAND_MAX],
    ..DUHEM
};

/// Position after one step, for both models.
fn frozen(coefficients: &[f64], state: &[f64], u: f64) -> f64 {
    Law::of(coefficients).map_or(0.0, |law| law.frozen(state, u))
}

impl Forward for Duhem {
    fn frozen(&self, coefficients: &[f64], state: &[f64], _rates: Rates, u: f64) -> f64 {
        frozen(coefficients, state, u)
    }

    fn mean_slope(&self, coefficients: &[f64], _limits: [f64; 2]) -> f64 {
        Law::of(coefficients).map_or(1.0, |law| law.slope)
    }

    fn check(&self, _structure: &[f64], parameters: &[f64], _: [f64; 2]) -> Result<(), Violation> {
        let &[slope, initial, decay, offset] = parameters else { return Err(WRONG_LENGTH) };
        let law = Law::of(&[slope, (slope - initial) / decay, decay, offset]);
        require(
            law.is_some_and(|law| law.least_slope() > 0.0),
            "initial",
            initial,
            "the position falls while the command rises right after a reversal, so that a position \
             has several commands and the model no inverse: 2*initial must be above slope, and \
             slope above zero",
        )
    }
}

impl Forward for Dahl {
    fn frozen(&self, coefficients: &[f64], state: &[f64], _rates: Rates, u: f64) -> f64 {
        frozen(coefficients, state, u)
    }

    fn mean_slope(&self, coefficients: &[f64], _limits: [f64; 2]) -> f64 {
        Law::of(coefficients).map_or(1.0, |law| law.slope)
    }

    fn check(&self, _structure: &[f64], parameters: &[f64], _: [f64; 2]) -> Result<(), Violation> {
        let &[gain, height, length, offset] = parameters else { return Err(WRONG_LENGTH) };
        let law = Law::of(&[gain, height, 1.0 / length, offset]);
        require(
            law.is_some_and(|law| law.least_slope() > 0.0),
            "gain",
            gain,
            "the position falls while the command rises right after a reversal, so that a position \
             has several commands and the model no inverse: gain*length must be above 2*height",
        )
    }
}

#[cfg(test)]
mod tests {
    use model::Component;

    use super::*;
    use crate::testing::{Instance, Random};

    /// The command is within 1e-12 of its range of 250, so the position within that times the
    /// steepest slope, 0.1.
    const BOUND: f64 = 2.0 * 250e-12 * 0.1;

    fn round_trip(forward: &'static dyn Component, inverse: &'static dyn Component, p: &[f64]) {
        let mut machine = Instance::new(forward, &[], p, 1e-4).unwrap();
        let p = [p, &[-100.0, 150.0]].concat();
        let mut inverse = Instance::new(inverse, &[], &p, 1e-4).unwrap();
        assert!((machine.rest(&[inverse.rest(&[2.0])]) - 2.0).abs() < BOUND);
        for y in Random::new(4).signal(-3.0, 7.0, 3000) {
            let found = machine.step(&[inverse.step(&[y])]);
            assert!((found - y).abs() < BOUND, "{p:?}: {found} {y}");
        }
    }

    #[test]
    fn the_inverse_before_the_machine_gives_the_wanted_position() {
        for p in [[0.06, 0.04, 0.05, 0.3], [0.06, 0.031, 0.2, -0.1], [0.06, 0.08, 0.05, 0.0]] {
            round_trip(&Duhem, &INVERSE_DUHEM, &p);
        }
        for p in [[0.06, 0.4, 20.0, 0.3], [0.06, 0.1, 5.0, 0.0], [0.06, 0.0, 5.0, 0.0]] {
            round_trip(&Dahl, &INVERSE_DAHL, &p);
        }
    }

    #[test]
    fn branches_that_fall_have_no_inverse() {
        let refused = |component: &'static dyn Component, p: &[f64]| {
            let p = [p, &[-50.0, 150.0]].concat();
            Instance::new(component, &[], &p, 1e-3).err().map(|v| v.quantity)
        };
        assert_eq!(refused(&INVERSE_DUHEM, &[0.06, 0.03, 0.05, 0.3]), Some("initial"));
        assert_eq!(refused(&INVERSE_DAHL, &[0.06, 0.7, 20.0, 0.3]), Some("gain"));
    }
}

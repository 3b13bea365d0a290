//! The inverse of a Bouc–Wen model, solved at each step.
//!
//! `forward(u) = y` for the command u, with the exact step of [`BoucWen`]; see
//! [`numeric_inverse`](super::numeric_inverse) for the method and its error. The model has no rate,
//! so the inverse is exact to 1e-12 of the command range.
//!
//! Limits: the loop must not curl over at its ends; `alpha` is checked.

use model::{Conversion, Declaration, Quantity, Stage};

use super::bouc_wen::{BoucWen, PARAMETERS as P};
use super::numeric_inverse::NumericInverse;
use super::rate_dependent_play::{COMMAND_MAX, COMMAND_MIN};

/// The component `inverse-bouc-wen`.
pub static INVERSE_BOUC_WEN: NumericInverse<BoucWen> =
    NumericInverse { forward: &BoucWen, declaration: &DECLARATION };

const PARAMETERS: &[Quantity] =
    &[P[0], P[1], P[2], P[3], P[4], P[5], P[6], COMMAND_MIN, COMMAND_MAX];

static DECLARATION: Declaration = Declaration {
    kind: "inverse-bouc-wen",
    name: "feedforward",
    summary: "Inverse of a Bouc-Wen model, solved at each step",
    equation: "offset + gain*u - h(u) = y",
    reference: "M. Rakotondrabe, IEEE Trans. Automation Science and Engineering 8 (2011) 428-431",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    parameters: PARAMETERS,
    ..Declaration::PATH
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn the_inverse_before_the_machine_gives_the_wanted_position() {
        for (delta, exponent) in [(0.0, 1.0), (0.004, 1.0), (0.0, 2.0)] {
            let p = [0.06, 0.2, 0.02, 0.01, delta, exponent, 0.3];
            let mut forward = Instance::new(&BoucWen, &[], &p, 1e-4).unwrap();
            let p = [&p[..], &[-50.0, 150.0]].concat();
            let mut inverse = Instance::new(&INVERSE_BOUC_WEN, &[], &p, 1e-4).unwrap();
            assert!((forward.rest(&[inverse.rest(&[2.0])]) - 2.0).abs() < 1e-9);
            for y in Random::new(4).signal(0.0, 6.0, 500) {
                assert!((forward.step(&[inverse.step(&[y])]) - y).abs() < 1e-9 * 6.0);
            }
        }
    }

    #[test]
    fn a_loop_that_curls_over_has_no_inverse() {
        let p = [24.373, 0.1947, 3.3626, -2.8526, 0.0, 1.0, 0.0, 0.0, 10.0];
        let error = Instance::new(&INVERSE_BOUC_WEN, &[], &p, 1e-3).err();
        assert_eq!(error.map(|v| v.quantity), Some("alpha"));
    }
}

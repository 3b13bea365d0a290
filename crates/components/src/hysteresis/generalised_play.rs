//! Generalised (asymmetric, saturating) play hysteresis.
//!
//! ```text
//! y = offset + Σ w_i F_i,   F_i ← max(γ_l(u) − r_i, min(γ_r(u) + r_i, F_i))
//! γ(u) = a0·tanh(a1·u + a2) + a3,   one for the rising side (left) and one for the falling (right)
//! ```
//!
//! * a0, a3 in command, a1 in 1/command, a2 without unit; γ_l ≤ γ_r over the working range. Equal
//!   envelopes give symmetric saturation, different ones an asymmetric loop.
//! * A play between two envelopes is a play between the envelopes themselves followed by an
//!   ordinary one: F_i = P_{r_i}[s] with `s ← max(γ_l(u), min(γ_r(u), s))`. So two hyperbolic
//!   tangents serve all plays, and the inverse is exact: `u = γ_l⁻¹(s)` while s rises, `γ_r⁻¹(s)`
//!   while it falls, and s from the closed-form inverse of the plays.
//! * State: s, and one number per play.
//!
//! Limits: independent of rate. Where γ_l > γ_r the output follows γ_l. The inverse is a right
//! inverse: applied before the machine it gives the wanted position, as long as that lies within
//! the envelopes; beyond them the command is the one that comes within 1e-9 of the envelope.
//!
//! Source: M. Al Janaideh, S. Rakheja, C.-Y. Su, IEEE/ASME Transactions on Mechatronics 16 (2011)
//! 734–744.

use libm::{atanh, tanh};
use model::{Component, Conversion, Declaration, Inverse, Quantity, Sizes, Stage, Tick, Violation};

use super::play::{Plays, between, invert};
use super::prandtl_ishlinskii::{OFFSET, R, STRUCTURE, W, check_invertible, check_plays};
use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `generalised-play`.
pub struct GeneralisedPlay;

/// The component `inverse-generalised-play`, given by the forward model's parameters.
pub struct InverseGeneralisedPlay;

const PARAMETERS: &[Quantity] = &[
    R,
    W,
    OFFSET,
    Quantity::new("left_a0", "{command}", "Rising envelope, height").min(0.0).fitted(),
    Quantity::new("left_a1", "1/{command}", "Rising envelope, steepness").min(0.0).fitted(),
    Quantity::new("left_a2", "1", "Rising envelope, shift inside").start(0.0).fitted(),
    Quantity::new("left_a3", "{command}", "Rising envelope, shift outside").start(0.0).fitted(),
    Quantity::new("right_a0", "{command}", "Falling envelope, height").min(0.0).fitted(),
    Quantity::new("right_a1", "1/{command}", "Falling envelope, steepness").min(0.0).fitted(),
    Quantity::new("right_a2", "1", "Falling envelope, shift inside").start(0.0).fitted(),
    Quantity::new("right_a3", "{command}", "Falling envelope, shift outside").start(0.0).fitted(),
];

static DECLARATION: Declaration = Declaration {
    kind: "generalised-play",
    name: "hysteresis",
    summary: "Asymmetric, saturating hysteresis: plays between hyperbolic-tangent envelopes",
    equation: "y = offset + sum(w[i]*F[i]); F[i] = max(left(u) - r[i], min(right(u) + r[i], \
               F[i])); left(u) = a0*tanh(a1*u + a2) + a3",
    reference: "M. Al Janaideh, S. Rakheja, C.-Y. Su, IEEE/ASME Trans. Mechatronics 16 (2011) \
                734-744",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::ASYMMETRY),
    phenomena: &[&phenomena::ASYMMETRIC_HYSTERESIS],
    structure: STRUCTURE,
    parameters: PARAMETERS,
    ..Declaration::PATH
};

static INVERSE: Declaration = Declaration {
    kind: "inverse-generalised-play",
    name: "feedforward",
    summary: "Exact right inverse of a generalised-play model, given by its parameters",
    equation: "s = inverse plays of (y - offset); u = left^-1(s) while s rises, right^-1(s) while \
               it falls",
    reference: "M. Al Janaideh, S. Rakheja, C.-Y. Su, IEEE/ASME Trans. Mechatronics 16 (2011) \
                734-744",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    structure: STRUCTURE,
    parameters: PARAMETERS,
    ..Declaration::PATH
};

/// One envelope.
#[derive(Clone, Copy)]
struct Envelope([f64; 4]);

impl Envelope {
    fn value(self, u: f64) -> f64 {
        let [a0, a1, a2, a3] = self.0;
        a0 * tanh(a1 * u + a2) + a3
    }

    fn inverse(self, value: f64) -> f64 {
        let [a0, a1, a2, a3] = self.0;
        let most = 1.0 - 1e-9;
        (atanh(between(-most, most, (value - a3) / a0)) - a2) / a1
    }
}

struct Parts<'a> {
    plays: Plays<'a>,
    offset: f64,
    left: Envelope,
    right: Envelope,
}

impl Parts<'_> {
    /// The play between the envelopes that never moved, at command 0.
    fn virgin(&self) -> f64 {
        between(self.left.value(0.0), self.right.value(0.0), 0.0)
    }
}

/// Coefficients and parameters are laid out alike: `r | w | offset | left | right`.
fn parts(values: &[f64]) -> Option<Parts<'_>> {
    let (arrays, &[offset, a, b, c, d, e, f, g, h]) = values.split_last_chunk::<9>()?;
    let (r, w) = arrays.split_at(arrays.len() / 2);
    let (left, right) = (Envelope([a, b, c, d]), Envelope([e, f, g, h]));
    Some(Parts { plays: Plays { r, w }, offset, left, right })
}

fn check(parameters: &[f64]) -> Result<Parts<'_>, Violation> {
    let parts = parts(parameters).ok_or(WRONG_LENGTH)?;
    check_plays(parts.plays)?;
    let rule = "an envelope rises with the command; give a value above 0";
    for (envelope, height, steepness) in
        [(parts.left, "left_a0", "left_a1"), (parts.right, "right_a0", "right_a1")]
    {
        require(envelope.0[0] > 0.0, height, envelope.0[0], rule)?;
        require(envelope.0[1] > 0.0, steepness, envelope.0[1], rule)?;
    }
    Ok(parts)
}

fn sizes(structure: &[f64]) -> Sizes {
    let plays = DECLARATION.length(0, structure);
    Sizes { coefficients: 2 * plays + 9, states: plays + 2 }
}

impl Component for GeneralisedPlay {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("r", &[0.0, 8.0, 20.0]),
            ("w", &[0.05, 0.02, 0.01]),
            ("offset", &[0.3]),
            ("left_a0", &[180.0]),
            ("left_a1", &[0.006]),
            ("left_a2", &[-0.05]),
            ("left_a3", &[2.0]),
            ("right_a0", &[200.0]),
            ("right_a1", &[0.0055]),
            ("right_a2", &[0.02]),
            ("right_a3", &[3.0]),
        ]
    }

    fn plays(&self, _structure: &[f64], parameters: &[f64], each: &mut dyn FnMut(f64, f64)) {
        let Some((arrays, &[_, left, steep_left, _, _, right, steep_right, _, _])) =
            parameters.split_last_chunk::<9>()
        else {
            return;
        };
        let (r, w) = arrays.split_at(arrays.len() / 2);
        // Where the envelopes are steepest.
        Plays { r, w }.behind(0.5 * (left * steep_left + right * steep_right), each);
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::closed_form("inverse-generalised-play")] }
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        sizes(structure)
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        check(parameters)?;
        kept(parameters, coefficients)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [y], [s, _, plays @ ..]) = (inputs, outputs, state) else { return };
        let Some(parts) = parts(coefficients) else { return };
        *s = between(parts.left.value(u), parts.right.value(u), parts.virgin());
        *y = parts.offset + parts.plays.rest(*s, plays);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[u], [y], [s, _, plays @ ..]) = (inputs, outputs, state) else { return };
        let Some(parts) = parts(coefficients) else { return };
        *s = between(parts.left.value(u), parts.right.value(u), *s);
        *y = parts.offset + parts.plays.step(*s, plays);
    }
}

impl Component for InverseGeneralisedPlay {
    fn declaration(&self) -> &'static Declaration {
        &INVERSE
    }

    fn example(&self) -> model::Example {
        GeneralisedPlay.example()
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        sizes(structure)
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let forward = check(parameters)?.plays;
        check_invertible(forward)?;
        kept(parameters, coefficients)?;
        let (r, rest) = coefficients.split_at_mut(forward.r.len());
        let (w, _) = rest.split_at_mut(forward.w.len());
        invert(forward.r, forward.w, r, w);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[y], [u], [s, held, plays @ ..]) = (inputs, outputs, state) else { return };
        let Some(parts) = parts(coefficients) else { return };
        let next = parts.plays.rest(y - parts.offset, plays);
        *held = command(&parts, parts.virgin(), next, 0.0);
        (*s, *u) = (next, *held);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[y], [u], [s, held, plays @ ..]) = (inputs, outputs, state) else { return };
        let Some(parts) = parts(coefficients) else { return };
        let next = parts.plays.step(y - parts.offset, plays);
        *held = command(&parts, *s, next, *held);
        (*s, *u) = (next, *held);
    }
}

/// The command that moves the play between the envelopes from `last` to `next`.
fn command(parts: &Parts<'_>, last: f64, next: f64, held: f64) -> f64 {
    if next > last {
        parts.left.inverse(next)
    } else if next < last {
        parts.right.inverse(next)
    } else {
        held
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, Random};

    const R3: [f64; 3] = [0.0, 8.0, 20.0];
    const W3: [f64; 3] = [0.02, 0.01, 0.03];

    fn parameters(left: [f64; 4], right: [f64; 4]) -> std::vec::Vec<f64> {
        [&R3[..], &W3, &[0.3], &left, &right].concat()
    }

    fn asymmetric() -> std::vec::Vec<f64> {
        parameters([180.0, 0.006, -0.05, 2.0], [200.0, 0.0055, 0.02, 3.0])
    }

    #[test]
    fn is_the_play_between_envelopes_of_the_literature() {
        let p = asymmetric();
        let mut model = Instance::new(&GeneralisedPlay, &[3.0], &p, 1e-4).unwrap();
        model.rest(&[0.0]);
        let (left, right) =
            (Envelope([180.0, 0.006, -0.05, 2.0]), Envelope([200.0, 0.0055, 0.02, 3.0]));
        let mut f = [0.0f64; 3];
        for u in Random::new(6).signal(-120.0, 120.0, 3000) {
            let (low, high) = (left.value(u), right.value(u));
            assert!(low <= high, "the envelopes cross at {u}");
            let mut y = 0.3;
            for i in 0..3 {
                f[i] = (low - R3[i]).max((high + R3[i]).min(f[i]));
                y += W3[i] * f[i];
            }
            assert!((model.step(&[u]) - y).abs() < 1e-12);
        }
    }

    #[test]
    fn a_play_between_envelopes_that_leave_out_zero_begins_at_the_nearer_one() {
        // At 0 it rests on that envelope; a small way back lies within the gap and does not move it.
        for (bottom, top, u, play) in [(40.0, 60.0, -10.0, 40.0), (-60.0, -40.0, 10.0, -40.0_f64)] {
            let p = parameters([180.0, 0.006, 0.0, bottom], [180.0, 0.006, 0.0, top]);
            let mut model = Instance::new(&GeneralisedPlay, &[3.0], &p, 1e-4).unwrap();
            let sum: f64 = R3.iter().zip(W3).map(|(r, w)| w * (play.abs() - r)).sum();
            let expected = 0.3 + play.signum() * sum;
            let found = model.rest(&[u]);
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn the_inverse_before_the_machine_gives_the_wanted_position() {
        let p = asymmetric();
        let mut forward = Instance::new(&GeneralisedPlay, &[3.0], &p, 1e-4).unwrap();
        let mut inverse = Instance::new(&InverseGeneralisedPlay, &[3.0], &p, 1e-4).unwrap();
        let mut random = Random::new(12);
        for _ in 0..50 {
            let mut y = random.between(-3.0, 3.0);
            assert!((forward.rest(&[inverse.rest(&[y])]) - y).abs() < 1e-9 * 6.0);
            for _ in 0..200 {
                y = random.between(-3.0, 3.0);
                assert!((forward.step(&[inverse.step(&[y])]) - y).abs() < 1e-9 * 6.0);
            }
            let held = inverse.step(&[y]);
            assert_eq!(inverse.step(&[y]), held, "a held position holds the command");
        }
    }

    #[test]
    fn positions_beyond_the_envelopes_give_finite_commands() {
        let mut inverse =
            Instance::new(&InverseGeneralisedPlay, &[3.0], &asymmetric(), 1e-4).unwrap();
        assert!(inverse.rest(&[1e6]).is_finite());
        assert!(inverse.step(&[-1e6]).is_finite());
    }
}

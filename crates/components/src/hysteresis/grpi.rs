//! The generalised rate-dependent Prandtl–Ishlinskii model (GRPI) of the elliptical-cutting paper.
//!
//! ```text
//! y = offset + Σ w_i P_i,   P_i ← max(h_l − r_i, min(h_r + r_i, P_i))
//! h_l = a1·u + a2·|u̇|,   h_r = b1·u + b2·|u̇|
//! ```
//!
//! * r, w as in `prandtl-ishlinskii`; a1, b1 without unit: slopes of the rising and the falling
//!   envelope; a2, b2 in s: their shift with the command's rate (a2 < 0 and b2 > 0 widen the loop).
//!   u̇ is the backward difference as in `rate`, 0 at rest.
//! * State: one number per play, the five of `rate`.
//!
//! Limits: where h_l − r_i > h_r + r_i the play follows h_l − r_i.
//!
//! Source: C. Zhang et al., Compound Control of Trajectory Errors in a Non-Resonant Piezo-Actuated
//! Elliptical Vibration Cutting Device, eq. (13).

use libm::fabs;
use model::{
    Component, Conversion, Declaration, Fit, Inverse, Quantity, Scale, Search, Sizes, Stage, Tick,
    Violation,
};

use super::numeric_inverse::{Forward, NumericInverse, Rates, mean_slope};
use super::play::{Plays, between};
use super::prandtl_ishlinskii::{OFFSET, R, STRUCTURE, W, check_invertible, check_plays};
use super::rate;
use super::rate_dependent_play::{COMMAND_MAX, COMMAND_MIN};
use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `grpi`.
pub struct Grpi;

/// The component `inverse-grpi`.
pub static INVERSE: NumericInverse<Grpi> =
    NumericInverse { forward: &Grpi, declaration: &INVERSE_DECLARATION };

const A1: Quantity =
    Quantity::new("a1", "1", "Slope of the rising envelope").start(1.0).min(0.0).fitted();
const A2: Quantity =
    Quantity::new("a2", "s", "Shift of the rising envelope with the rate").start(0.0).fitted();
const B1: Quantity =
    Quantity::new("b1", "1", "Slope of the falling envelope").start(1.0).min(0.0).fitted();
const B2: Quantity =
    Quantity::new("b2", "s", "Shift of the falling envelope with the rate").start(0.0).fitted();

static DECLARATION: Declaration = Declaration {
    kind: "grpi",
    name: "hysteresis",
    summary: "Generalised rate-dependent Prandtl-Ishlinskii hysteresis",
    equation: "y = offset + sum(w[i]*P[i]); P[i] = max(hl - r[i], min(hr + r[i], P[i])); hl = \
               a1*u + a2*|u'|; hr = b1*u + b2*|u'|",
    reference: "C. Zhang et al., Compound Control of Trajectory Errors in a Non-Resonant \
                Piezo-Actuated Elliptical Vibration Cutting Device, eq. (13)",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::RATE_DEPENDENCE),
    phenomena: &[&phenomena::RATE_DEPENDENT_HYSTERESIS],
    structure: STRUCTURE,
    parameters: &[R, W, OFFSET, A1, A2, B1, B2],
    ..Declaration::PATH
};

static INVERSE_DECLARATION: Declaration = Declaration {
    kind: "inverse-grpi",
    name: "feedforward",
    summary: "Inverse of a grpi model, solved at each step",
    equation: "forward(u) = y, with u' = y'/(mean slope of the largest loop)",
    reference: "C. Zhang et al., Compound Control of Trajectory Errors in a Non-Resonant \
                Piezo-Actuated Elliptical Vibration Cutting Device, eq. (13)",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    structure: STRUCTURE,
    parameters: &[R, W, OFFSET, A1, A2, B1, B2, COMMAND_MIN, COMMAND_MAX],
    ..Declaration::PATH
};

/// `r | w | offset | a1 | a2 | b1 | b2` (parameters), and 1/T behind them (coefficients).
struct Parts<'a> {
    plays: Plays<'a>,
    offset: f64,
    envelopes: [f64; 4],
    per_period: f64,
}

fn split(coefficients: &[f64]) -> Option<Parts<'_>> {
    let (arrays, &[offset, a1, a2, b1, b2, per_period]) = coefficients.split_last_chunk::<6>()?;
    let (r, w) = arrays.split_at(arrays.len() / 2);
    Some(Parts { plays: Plays { r, w }, offset, envelopes: [a1, a2, b1, b2], per_period })
}

impl Parts<'_> {
    /// The rising and the falling envelope.
    fn envelopes(&self, u: f64, rate: f64) -> (f64, f64) {
        let [a1, a2, b1, b2] = self.envelopes;
        (a1 * u + a2 * fabs(rate), b1 * u + b2 * fabs(rate))
    }

    fn step(&self, u: f64, rate: f64, state: &mut [f64]) -> f64 {
        let (left, right) = self.envelopes(u, rate);
        let mut y = self.offset;
        for ((p, r), w) in state.iter_mut().zip(self.plays.r).zip(self.plays.w) {
            *p = between(left - r, right + r, *p);
            y += w * *p;
        }
        y
    }
}

/// A common factor of both slopes is one of all thresholds, so `a1` is 1 and `b1` relative to it.
static FIT: Fit = Fit {
    summary: "Generalised rate-dependent Prandtl-Ishlinskii: envelopes with own slopes and rates",
    powers: &[],
    search: &[
        Search { name: "a2", scale: Scale::Growth, start: 0.0, lower: -1.0, upper: 1.0 },
        Search { name: "b1", scale: Scale::Own, start: 1.0, lower: 0.8, upper: 1.25 },
        Search { name: "b2", scale: Scale::Growth, start: 0.0, lower: -1.0, upper: 1.0 },
    ],
    starts: &[&[-0.0, 1.0, 0.0], &[-1e-4, 1.0, 1e-4], &[-1e-3, 1.0, 1e-3], &[-1e-2, 1.0, 1e-2]],
};

impl Component for Grpi {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("r", &[0.0, 12.0]),
            ("w", &[0.05, 0.01]),
            ("offset", &[0.3]),
            ("a1", &[1.02]),
            ("a2", &[-1e-05]),
            ("b1", &[0.99]),
            ("b2", &[2e-05]),
        ]
    }

    fn plays(&self, _structure: &[f64], parameters: &[f64], each: &mut dyn FnMut(f64, f64)) {
        let Some((arrays, &[_, a1, _, b1, _])) = parameters.split_last_chunk::<5>() else { return };
        let (r, w) = arrays.split_at(arrays.len() / 2);
        Plays { r, w }.behind(0.5 * (a1 + b1), each);
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::iteration("inverse-grpi")] }
    }

    fn fit(&self) -> Option<&'static Fit> {
        Some(&FIT)
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let plays = DECLARATION.length(0, structure);
        Sizes { coefficients: 2 * plays + 6, states: plays + rate::STATES }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (Some((arrays, &[_, a1, _, b1, _])), Some((per_period, inner))) =
            (parameters.split_last_chunk::<5>(), coefficients.split_last_mut())
        else {
            return Err(WRONG_LENGTH);
        };
        let (r, w) = arrays.split_at(arrays.len() / 2);
        check_plays(Plays { r, w })?;
        let rule = "an envelope rises with the command; give a value above 0, usually near 1";
        require(a1 > 0.0, "a1", a1, rule)?;
        require(b1 > 0.0, "b1", b1, rule)?;
        kept(parameters, inner)?;
        *per_period = 1.0 / period;
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some(parts), &[u], Some((plays, memory)), [y]) = (
            split(coefficients),
            inputs,
            state.split_last_chunk_mut::<{ rate::STATES }>(),
            outputs,
        ) else {
            return;
        };
        *memory = rate::rest(u);
        plays.fill(0.0);
        *y = parts.step(u, 0.0, plays);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some(parts), &[u], Some((plays, memory)), [y]) = (
            split(coefficients),
            inputs,
            state.split_last_chunk_mut::<{ rate::STATES }>(),
            outputs,
        ) else {
            return;
        };
        rate::update(memory, u, parts.per_period);
        *y = parts.step(u, memory[1], plays);
    }
}

impl Forward for Grpi {
    fn frozen(&self, coefficients: &[f64], state: &[f64], [rate, _]: Rates, u: f64) -> f64 {
        let Some(parts) = split(coefficients) else { return 0.0 };
        let (left, right) = parts.envelopes(u, rate);
        let terms = state.iter().zip(parts.plays.r).zip(parts.plays.w);
        terms.fold(parts.offset, |y, ((p, r), w)| y + w * between(left - r, right + r, *p))
    }

    fn mean_slope(&self, coefficients: &[f64], limits: [f64; 2]) -> f64 {
        split(coefficients).map_or(1.0, |parts| mean_slope(parts.plays, 0.0, limits))
    }

    fn check(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _limits: [f64; 2],
    ) -> Result<(), Violation> {
        let Some((arrays, _)) = parameters.split_last_chunk::<5>() else {
            return Err(WRONG_LENGTH);
        };
        let (r, w) = arrays.split_at(arrays.len() / 2);
        check_invertible(Plays { r, w })
    }
}

#[cfg(test)]
mod tests {
    use super::super::PrandtlIshlinskii;
    use super::*;
    use crate::testing::{Instance, Random};

    const PLAIN: [f64; 7] = [0.0, 8.0, 20.0, 0.05, 0.02, 0.01, 0.3];

    #[test]
    fn with_neutral_envelopes_it_is_the_static_model() {
        let signal = Random::new(3).signal(-60.0, 120.0, 500);
        let p = [&PLAIN[..], &[1.0, 0.0, 1.0, 0.0]].concat();
        let with = Instance::new(&Grpi, &[3.0], &p, 1e-4).unwrap().response(5.0, &signal);
        let plain = Instance::new(&PrandtlIshlinskii, &[3.0], &PLAIN, 1e-4);
        for (a, b) in with.iter().zip(plain.unwrap().response(5.0, &signal)) {
            assert!((a - b).abs() < 1e-13);
        }
    }

    #[test]
    fn the_inverse_leaves_a_fraction_of_the_rate_terms_effect() {
        let period = 1e-5;
        let wanted =
            |n: u32| 4.0 - 3.0 * (core::f64::consts::TAU * 50.0 * period * f64::from(n)).cos();
        let rms = |rate: f64| {
            let p = [&PLAIN[..], &[1.02, -1e-4, 0.99, 1.5e-4]].concat();
            let inverse = [&PLAIN[..], &[1.02, -rate, 0.99, 1.5 * rate]].concat();
            let mut forward = Instance::new(&Grpi, &[3.0], &p, period).unwrap();
            let p = [&inverse[..], &[-50.0, 150.0]].concat();
            let mut inverse = Instance::new(&INVERSE, &[3.0], &p, period).unwrap();
            assert!((forward.rest(&[inverse.rest(&[1.0])]) - 1.0).abs() < 1e-9);
            let errors = (1..6000).map(|n| forward.step(&[inverse.step(&[wanted(n)])]) - wanted(n));
            (errors.skip(1000).map(|e| e * e).sum::<f64>() / 5000.0).sqrt()
        };
        let (with, without) = (rms(1e-4), rms(0.0));
        assert!(without > 0.02, "the rate term must act: {without}");
        assert!(with < 0.2 * without, "{with} of {without}");
    }

    #[test]
    fn envelopes_that_do_not_rise_are_refused() {
        let refused = |a1: f64, b1: f64| {
            let p = [&PLAIN[..], &[a1, 0.0, b1, 0.0]].concat();
            Instance::new(&Grpi, &[3.0], &p, 1e-4).err().map(|v| v.quantity)
        };
        assert_eq!((refused(0.0, 1.0), refused(1.0, 0.0)), (Some("a1"), Some("b1")));
        assert_eq!(refused(0.5, 0.5), None);
    }
}

//! The dynamic Prandtl–Ishlinskii model of the elliptical-cutting paper: weights that follow the
//! command's rate and acceleration, in four segments.
//!
//! ```text
//! y = offset + Σ (w_i + φ) P_{r_i}[u],   φ = alpha_s·u̇ + beta_s·ü
//! s = 1: u̇ ≥ 0, ü ≥ 0   2: u̇ ≥ 0, ü < 0   3: u̇ < 0, ü ≤ 0   4: u̇ < 0, ü > 0
//! ```
//!
//! * r, w as in `prandtl-ishlinskii`; alpha in position·s per command², beta in position·s² per
//!   command²: φ is a weight. (The paper prints its numbers without a unit, and no reading of them
//!   in SI units gives its figures: they have to be identified again.)
//! * u̇ and ü are backward differences as in `rate`, 0 at rest.
//! * State: one number per play, the five of `rate`, φ.
//!
//! Limits: a kink in the command makes one sample of ü of the size of the kink in u̇ over the step,
//! and noise makes more: for short steps beta needs smooth commands, and the command that an exact
//! inverse gives is not (it has a kink wherever a play starts to move). φ jumps where the segment
//! changes unless alpha_1 = alpha_2, alpha_3 = alpha_4, beta_1 = beta_4 and beta_2 = beta_3.
//! Nothing keeps w_i + φ positive.
//!
//! The inverse takes u̇ and ü from the wanted position (see `numeric_inverse`). The plays do not
//! depend on rates, so what it leaves at each step is `|φ(u̇, ü) − φ(estimates)|·|Σ P_{r_i}[u]|`, at
//! any frequency, as long as w_i + φ > 0 and the command is within its limits.
//!
//! Source: C. Zhang et al., Compound Control of Trajectory Errors in a Non-Resonant Piezo-Actuated
//! Elliptical Vibration Cutting Device, eqs. (3) and (4).

use model::{
    Component, Conversion, Declaration, Inverse, Quantity, Sizes, Stage, Structural, Tick,
    Violation,
};

use super::numeric_inverse::{Forward, NumericInverse, Rates, mean_slope};
use super::play::{Drive, Plays, Threshold, play};
use super::prandtl_ishlinskii::{OFFSET, PLAYS, R, W, check_invertible, check_plays};
use super::rate;
use super::rate_dependent_play::{COMMAND_MAX, COMMAND_MIN};
use crate::rules::{WRONG_LENGTH, kept};
use crate::{effects, phenomena};

/// The component `dynamic-prandtl-ishlinskii`.
pub struct DynamicPrandtlIshlinskii;

/// The component `inverse-dynamic-prandtl-ishlinskii`.
pub static INVERSE: NumericInverse<DynamicPrandtlIshlinskii> =
    NumericInverse { forward: &DynamicPrandtlIshlinskii, declaration: &INVERSE_DECLARATION };

const STRUCTURE: &[Structural] =
    &[PLAYS, Structural::count("segments", "Number of segments of the loop, four", 4, 4)];
const ALPHA: Quantity = Quantity::new(
    "alpha",
    "{position}.s/{command}/{command}",
    "Change of every weight with the command's rate, per segment",
)
.per(1)
.fitted();
const BETA: Quantity = Quantity::new(
    "beta",
    "{position}.s2/{command}/{command}",
    "Change of every weight with the command's acceleration, per segment",
)
.per(1)
.fitted();

static DECLARATION: Declaration = Declaration {
    kind: "dynamic-prandtl-ishlinskii",
    name: "hysteresis",
    summary: "Prandtl-Ishlinskii hysteresis whose weights follow the command's rate in segments",
    equation: "y = offset + sum((w[i] + phi)*P[i]); phi = alpha[s]*u' + beta[s]*u''; segment s by \
               the signs of u' and u''",
    reference: "C. Zhang et al., Compound Control of Trajectory Errors in a Non-Resonant \
                Piezo-Actuated Elliptical Vibration Cutting Device, eqs. (3)-(4)",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::RATE_DEPENDENCE),
    phenomena: &[&phenomena::RATE_DEPENDENT_HYSTERESIS],
    structure: STRUCTURE,
    parameters: &[R, W, ALPHA, BETA, OFFSET],
    ..Declaration::PATH
};

static INVERSE_DECLARATION: Declaration = Declaration {
    kind: "inverse-dynamic-prandtl-ishlinskii",
    name: "feedforward",
    summary: "Inverse of a dynamic Prandtl-Ishlinskii model, solved at each step",
    equation: "forward(u) = y, with u' = y'/(mean slope of the largest loop) and u'' alike",
    reference: "C. Zhang et al., Compound Control of Trajectory Errors in a Non-Resonant \
                Piezo-Actuated Elliptical Vibration Cutting Device, eqs. (14)-(17)",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    structure: STRUCTURE,
    parameters: &[R, W, ALPHA, BETA, OFFSET, COMMAND_MIN, COMMAND_MAX],
    ..Declaration::PATH
};

/// `r | w | alpha | beta | offset` (parameters), and 1/T behind them (coefficients).
struct Parts<'a> {
    plays: Plays<'a>,
    alpha: [f64; 4],
    beta: [f64; 4],
    offset: f64,
    per_period: f64,
}

fn split(coefficients: &[f64]) -> Option<Parts<'_>> {
    let (rest, &[offset, per_period]) = coefficients.split_last_chunk::<2>()?;
    let (rest, &beta) = rest.split_last_chunk::<4>()?;
    let (arrays, &alpha) = rest.split_last_chunk::<4>()?;
    let (r, w) = arrays.split_at(arrays.len() / 2);
    Some(Parts { plays: Plays { r, w }, alpha, beta, offset, per_period })
}

impl Parts<'_> {
    /// φ for this rate and acceleration.
    fn weight(&self, rate: f64, acceleration: f64) -> f64 {
        let [a1, a2, a3, a4] = self.alpha;
        let [b1, b2, b3, b4] = self.beta;
        let (alpha, beta) = match (rate >= 0.0, acceleration) {
            (true, a) if a >= 0.0 => (a1, b1),
            (true, _) => (a2, b2),
            (false, a) if a <= 0.0 => (a3, b3),
            (false, _) => (a4, b4),
        };
        alpha * rate + beta * acceleration
    }
}

fn plays_of(parameters: &[f64]) -> Option<Plays<'_>> {
    let arrays = parameters.get(..parameters.len().checked_sub(9)?)?;
    let (r, w) = arrays.split_at(arrays.len() / 2);
    Some(Plays { r, w })
}

impl Component for DynamicPrandtlIshlinskii {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("r", &[0.0, 12.0]),
            ("w", &[0.05, 0.01]),
            ("alpha", &[-1e-08, -1e-08, 1e-08, 1e-08]),
            ("beta", &[1e-13, 1e-13, 1e-13, 1e-13]),
            ("offset", &[0.3]),
        ]
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::iteration("inverse-dynamic-prandtl-ishlinskii")] }
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let plays = DECLARATION.length(0, structure);
        Sizes { coefficients: 2 * plays + 10, states: plays + rate::STATES + 1 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        check_plays(plays_of(parameters).ok_or(WRONG_LENGTH)?)?;
        let Some((per_period, inner)) = coefficients.split_last_mut() else {
            return Err(WRONG_LENGTH);
        };
        kept(parameters, inner)?;
        *per_period = 1.0 / period;
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some(parts), &[u], Some((plays, [memory @ .., phi])), [y]) = (
            split(coefficients),
            inputs,
            state.split_last_chunk_mut::<{ rate::STATES + 1 }>(),
            outputs,
        ) else {
            return;
        };
        (*memory, *phi) = (rate::rest(u), 0.0);
        *y = parts.offset + parts.plays.rest(u, plays);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some(parts), &[u], Some((plays, [memory @ .., phi])), [y]) = (
            split(coefficients),
            inputs,
            state.split_last_chunk_mut::<{ rate::STATES + 1 }>(),
            outputs,
        ) else {
            return;
        };
        if let Some(acceleration) = rate::step(memory, u, parts.per_period) {
            *phi = parts.weight(memory[1], acceleration);
        }
        let sum = parts.plays.step(u, plays);
        *y = parts.offset + sum + *phi * plays.iter().sum::<f64>();
    }
}

impl Forward for DynamicPrandtlIshlinskii {
    fn frozen(&self, coefficients: &[f64], state: &[f64], rates: Rates, u: f64) -> f64 {
        let Some(parts) = split(coefficients) else { return 0.0 };
        let phi = parts.weight(rates[0], rates[1]);
        let terms = state.iter().zip(parts.plays.r).zip(parts.plays.w);
        terms.fold(parts.offset, |y, ((p, r), w)| y + (w + phi) * play(Drive(u), Threshold(*r), *p))
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
        check_invertible(plays_of(parameters).ok_or(WRONG_LENGTH)?)
    }
}

#[cfg(test)]
mod tests {
    use super::super::PrandtlIshlinskii;
    use super::*;
    use crate::testing::{Instance, Random};

    const R3: [f64; 3] = [0.0, 8.0, 20.0];
    const W3: [f64; 3] = [0.05, 0.02, 0.01];

    fn parameters(alpha: [f64; 4], beta: [f64; 4]) -> std::vec::Vec<f64> {
        [&R3[..], &W3, &alpha, &beta, &[0.3]].concat()
    }

    #[test]
    fn without_alpha_and_beta_it_is_the_static_model() {
        let signal = Random::new(3).signal(-60.0, 120.0, 500);
        let p = parameters([0.0; 4], [0.0; 4]);
        let with = Instance::new(&DynamicPrandtlIshlinskii, &[3.0, 4.0], &p, 1e-4);
        let p = [&R3[..], &W3, &[0.3]].concat();
        let plain = Instance::new(&PrandtlIshlinskii, &[3.0], &p, 1e-4);
        let plain = plain.unwrap().response(5.0, &signal);
        for (a, b) in with.unwrap().response(5.0, &signal).iter().zip(plain) {
            assert!((a - b).abs() < 1e-13);
        }
    }

    #[test]
    fn at_rest_it_stays() {
        let p = parameters([1.0, 2.0, 3.0, 4.0], [0.1, 0.2, 0.3, 0.4]);
        let mut model = Instance::new(&DynamicPrandtlIshlinskii, &[3.0, 4.0], &p, 1e-3).unwrap();
        let plays = 0.05 * 12.0 + 0.02 * 4.0;
        assert!((model.rest(&[12.0]) - (0.3 + plays)).abs() < 1e-13);
        assert!((model.step(&[12.0]) - (0.3 + plays)).abs() < 1e-13);
    }

    #[test]
    fn each_segment_has_its_own_coefficients() {
        let period = 0.5;
        let (alpha, beta) = ([1.0, 2.0, 3.0, 4.0], [0.1, 0.2, 0.3, 0.4]);
        let p = parameters(alpha, beta);
        let mut model = Instance::new(&DynamicPrandtlIshlinskii, &[3.0, 4.0], &p, period).unwrap();
        model.rest(&[0.0]);
        // Rates 2, 3, 1, −1, −4, −2 and accelerations 4, 2, −4, −4, −6, 4.
        let commands = [1.0, 2.5, 3.0, 2.5, 0.5, -0.5];
        let segments = [1usize, 1, 2, 3, 3, 4];
        let (mut last, mut last_rate) = (0.0, 0.0);
        let mut plays = [0.0; 3];
        for (u, segment) in commands.iter().zip(segments) {
            let rate = (u - last) / period;
            let acceleration = (rate - last_rate) / period;
            (last, last_rate) = (*u, rate);
            let phi = alpha[segment - 1] * rate + beta[segment - 1] * acceleration;
            let mut y = 0.3;
            for i in 0..3 {
                plays[i] = play(Drive(*u), Threshold(R3[i]), plays[i]);
                y += (W3[i] + phi) * plays[i];
            }
            assert!((model.step(&[*u]) - y).abs() < 1e-12, "segment {segment}");
        }
    }

    #[test]
    fn the_inverse_leaves_a_fraction_of_the_rate_terms_effect() {
        let period = 1e-5;
        let wanted =
            |n: u32| 4.0 - 3.0 * (core::f64::consts::TAU * 50.0 * period * f64::from(n)).cos();
        let rms = |alpha: [f64; 4], beta: [f64; 4]| {
            let p = parameters([-2e-7, -2e-7, 2e-7, 2e-7], [0.0; 4]);
            let forward = &DynamicPrandtlIshlinskii;
            let mut forward = Instance::new(forward, &[3.0, 4.0], &p, period).unwrap();
            let p = [&parameters(alpha, beta)[..], &[-50.0, 150.0]].concat();
            let mut inverse = Instance::new(&INVERSE, &[3.0, 4.0], &p, period).unwrap();
            assert!((forward.rest(&[inverse.rest(&[1.0])]) - 1.0).abs() < 1e-9);
            let errors = (1..6000).map(|n| forward.step(&[inverse.step(&[wanted(n)])]) - wanted(n));
            (errors.skip(1000).map(|e| e * e).sum::<f64>() / 5000.0).sqrt()
        };
        let with = rms([-2e-7, -2e-7, 2e-7, 2e-7], [0.0; 4]);
        let without = rms([0.0; 4], [0.0; 4]);
        assert!(without > 0.02, "the rate terms must act: {without}");
        assert!(with < 0.2 * without, "{with} of {without}");
    }

    #[test]
    fn the_inverse_leaves_the_change_of_phi_times_the_plays_at_every_frequency() {
        let (alpha, beta) = ([-2e-7, -3e-7, 2e-7, 1e-7], [1e-11, -1e-11, 2e-11, -2e-11]);
        let plain = parameters(alpha, beta);
        let limits = [-50.0, 150.0];
        let slope = mean_slope(Plays { r: &R3, w: &W3 }, 0.0, limits);
        for frequency in [0.1, 1.0, 10.0, 50.0, 100.0, 200.0] {
            let period = 1e-3 / frequency;
            let wanted = |n: u32| 4.0 - 3.0 * (core::f64::consts::TAU * 1e-3 * f64::from(n)).cos();
            let forward = &DynamicPrandtlIshlinskii;
            let mut forward = Instance::new(forward, &[3.0, 4.0], &plain, period).unwrap();
            let p = [&plain[..], &limits].concat();
            let mut inverse = Instance::new(&INVERSE, &[3.0, 4.0], &p, period).unwrap();
            let mut plays = [0.0; 3];
            let first = inverse.rest(&[wanted(0)]);
            forward.rest(&[first]);
            for (play_i, r) in plays.iter_mut().zip(R3) {
                *play_i = play(Drive(first), Threshold(r), 0.0);
            }
            let model = Parts {
                plays: Plays { r: &R3, w: &W3 },
                alpha,
                beta,
                offset: 0.3,
                per_period: 1.0 / period,
            };
            let (mut last, mut last_rate, mut estimated) = (first, 0.0, 0.0);
            for n in 1..3000 {
                let u = inverse.step(&[wanted(n)]);
                let left = forward.step(&[u]) - wanted(n);
                let rate = (u - last) / period;
                let estimate = (wanted(n) - wanted(n - 1)) / period / slope;
                let phi = model.weight(rate, (rate - last_rate) / period);
                let taken = model.weight(estimate, (estimate - estimated) / period);
                (last, last_rate, estimated) = (u, rate, estimate);
                for (play_i, r) in plays.iter_mut().zip(R3) {
                    *play_i = play(Drive(u), Threshold(r), *play_i);
                }
                let expected = (phi - taken) * plays.iter().sum::<f64>();
                assert!((left - expected).abs() < 1e-9, "{frequency} Hz: {left} {expected}");
            }
        }
    }
}

//! Rate-dependent Prandtl–Ishlinskii hysteresis: plays whose thresholds grow with the rate.
//!
//! ```text
//! y = offset + gain·u + Σ w_i F_i
//! F_i ← max(u − ρ_i, min(u + ρ_i, F_i)),   ρ_i = r_i + rate·|u̇|
//! ```
//!
//! * r, w as in `prandtl-ishlinskii`; gain in position per command: a part without memory; rate in
//!   s: growth of every threshold with the command's rate. u̇ is the backward difference as in
//!   `rate`, 0 at rest.
//! * State: one number per play, the five of `rate`.
//!
//! Limits: the loop widens with the rate at any amplitude; noise in the command counts as rate.
//!
//! Source: M. Al Janaideh, P. Krejčí, IEEE/ASME Transactions on Mechatronics 18 (2013) 1498–1507.

use libm::fabs;
use model::{
    Component, Conversion, Declaration, Fit, Free, Inverse, Missing, Quantity, Range, Role, Scale,
    Search, Sizes, Stage, Tick, Violation,
};

use super::numeric_inverse::{Forward, NumericInverse, Rates, mean_slope};
use super::play::{Drive, Plays, Threshold, play};
use super::prandtl_ishlinskii::{OFFSET, R, STRUCTURE, W, check_plays};
use super::rate;
use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `rate-dependent-play`.
pub struct RateDependentPlay;

/// The component `inverse-rate-dependent-play`.
pub static INVERSE: NumericInverse<RateDependentPlay> =
    NumericInverse { forward: &RateDependentPlay, declaration: &INVERSE_DECLARATION };

const GAIN: Quantity =
    Quantity::new("gain", "{position}/{command}", "Linear part without hysteresis")
        .role(Role::Slope)
        .start(0.0)
        .min(0.0)
        .fitted();
pub(super) const RATE: Quantity =
    Quantity::new("rate", "s", "Growth of every threshold with the command's rate")
        .min(0.0)
        .fitted();
pub(super) const COMMAND_MIN: Quantity =
    Quantity::new("command_min", "{command}", "Least command that the inverse gives");
pub(super) const COMMAND_MAX: Quantity =
    Quantity::new("command_max", "{command}", "Greatest command that the inverse gives");

static DECLARATION: Declaration = Declaration {
    kind: "rate-dependent-play",
    name: "hysteresis",
    summary: "Hysteresis that widens with the rate: plays with rate-dependent thresholds",
    equation: "y = offset + gain*u + sum(w[i]*F[i]); F[i] = max(u - t[i], min(u + t[i], F[i])); \
               t[i] = r[i] + rate*|u'|",
    reference: "M. Al Janaideh, P. Krejci, IEEE/ASME Trans. Mechatronics 18 (2013) 1498-1507",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::RATE_DEPENDENCE),
    phenomena: &[&phenomena::RATE_DEPENDENT_HYSTERESIS],
    structure: STRUCTURE,
    parameters: &[R, W, OFFSET, GAIN, RATE],
    ..Declaration::PATH
};

static INVERSE_DECLARATION: Declaration = Declaration {
    kind: "inverse-rate-dependent-play",
    name: "feedforward",
    summary: "Inverse of a rate-dependent-play model, solved at each step",
    equation: "forward(u) = y, with u' = y'/(mean slope of the largest loop)",
    reference: "M. Al Janaideh, P. Krejci, IEEE/ASME Trans. Mechatronics 18 (2013) 1498-1507",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    structure: STRUCTURE,
    parameters: &[R, W, OFFSET, GAIN, RATE, COMMAND_MIN, COMMAND_MAX],
    ..Declaration::PATH
};

/// `r | w | offset | gain | rate` (parameters), and 1/T behind them (coefficients).
fn split(coefficients: &[f64]) -> Option<(Plays<'_>, [f64; 4])> {
    let (arrays, &scalars) = coefficients.split_last_chunk::<4>()?;
    let (r, w) = arrays.split_at(arrays.len() / 2);
    Some((Plays { r, w }, scalars))
}

/// The sum of plays whose thresholds are all `wider` than given.
#[inline]
pub(super) fn widened(plays: Plays<'_>, u: f64, wider: f64, state: &mut [f64]) -> f64 {
    let mut sum = 0.0;
    for ((p, r), w) in state.iter_mut().zip(plays.r).zip(plays.w) {
        *p = play(Drive(u), Threshold(r + wider), *p);
        sum += w * *p;
    }
    sum
}

/// The sum of plays whose thresholds are all `wider` than given; the state stays as it is.
#[inline]
pub(super) fn widened_frozen(plays: Plays<'_>, u: f64, wider: f64, state: &[f64]) -> f64 {
    let terms = state.iter().zip(plays.r).zip(plays.w);
    terms.fold(0.0, |sum, ((p, r), w)| sum + w * play(Drive(u), Threshold(r + wider), *p))
}

static FIT: Fit = Fit {
    summary: "Rate-dependent Prandtl-Ishlinskii: the loop widens with the command's rate",
    powers: &[("gain", 1)],
    search: &[GROWTH],
    starts: &[&[0.0], &[1e-4], &[1e-3], &[1e-2]],
};

static MISSING: Missing =
    Missing { name: "thresholds that grow with the rate", free: &[FREE_GROWTH] };

/// The growth of thresholds with the rate, for a diagnosis.
pub(super) const FREE_GROWTH: Free = Free { quantity: "rate", name: "time", range: Range::Growth };

/// The growth of thresholds with the rate, from none on.
pub(super) const GROWTH: Search =
    Search { name: "rate", scale: Scale::Growth, start: 0.0, lower: 0.0, upper: 1.0 };

impl Component for RateDependentPlay {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("r", &[4.0, 12.0]),
            ("w", &[0.02, 0.01]),
            ("offset", &[0.3]),
            ("gain", &[0.05]),
            ("rate", &[1e-05]),
        ]
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::iteration("inverse-rate-dependent-play")] }
    }

    fn fit(&self) -> Option<&'static Fit> {
        Some(&FIT)
    }

    fn missing(&self) -> Option<&'static Missing> {
        Some(&MISSING)
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let plays = DECLARATION.length(0, structure);
        Sizes { coefficients: 2 * plays + 4, states: plays + rate::STATES }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (Some((arrays, _)), Some((per_period, inner))) =
            (parameters.split_last_chunk::<3>(), coefficients.split_last_mut())
        else {
            return Err(WRONG_LENGTH);
        };
        let (r, w) = arrays.split_at(arrays.len() / 2);
        check_plays(Plays { r, w })?;
        kept(parameters, inner)?;
        *per_period = 1.0 / period;
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((plays, [offset, gain, ..])), &[u], Some((sum, memory)), [y]) = (
            split(coefficients),
            inputs,
            state.split_last_chunk_mut::<{ rate::STATES }>(),
            outputs,
        ) else {
            return;
        };
        *memory = rate::rest(u);
        *y = offset + gain * u + plays.rest(u, sum);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((plays, [offset, gain, growth, per_period])), &[u], Some((sum, memory)), [y]) = (
            split(coefficients),
            inputs,
            state.split_last_chunk_mut::<{ rate::STATES }>(),
            outputs,
        ) else {
            return;
        };
        rate::update(memory, u, per_period);
        *y = offset + gain * u + widened(plays, u, growth * fabs(memory[1]), sum);
    }
}

impl Forward for RateDependentPlay {
    fn frozen(&self, coefficients: &[f64], state: &[f64], [rate, _]: Rates, u: f64) -> f64 {
        let Some((plays, [offset, gain, growth, _])) = split(coefficients) else { return 0.0 };
        offset + gain * u + widened_frozen(plays, u, growth * fabs(rate), state)
    }

    fn mean_slope(&self, coefficients: &[f64], limits: [f64; 2]) -> f64 {
        split(coefficients).map_or(1.0, |(plays, [_, gain, ..])| mean_slope(plays, gain, limits))
    }

    fn check(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _limits: [f64; 2],
    ) -> Result<(), Violation> {
        let Some((_, &[_, gain, _])) = parameters.split_last_chunk::<3>() else {
            return Err(WRONG_LENGTH);
        };
        require(
            gain > 0.0,
            "gain",
            gain,
            "a model whose plays all have dead bands has no inverse; give a gain above 0",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::PrandtlIshlinskii;
    use super::*;
    use crate::testing::{Instance, Random, loop_area};

    fn parameters(rate: f64) -> [f64; 9] {
        [3.0, 8.0, 20.0, 0.01, 0.02, 0.01, 0.3, 0.05, rate]
    }

    #[test]
    fn without_rate_it_is_the_static_model() {
        let signal = Random::new(3).signal(-60.0, 120.0, 500);
        let with = Instance::new(&RateDependentPlay, &[3.0], &parameters(0.0), 1e-4);
        let plain = [0.0, 3.0, 8.0, 20.0, 0.05, 0.01, 0.02, 0.01, 0.3];
        let plain = Instance::new(&PrandtlIshlinskii, &[4.0], &plain, 1e-4);
        let (with, plain) =
            (with.unwrap().response(5.0, &signal), plain.unwrap().response(5.0, &signal));
        for (a, b) in with.iter().zip(&plain) {
            assert!((a - b).abs() < 1e-13);
        }
    }

    #[test]
    fn a_triangle_sees_thresholds_widened_by_the_rate() {
        // ±50 V; 4·50 V per cycle in `points`·2 steps of 0.1 ms.
        for points in [20usize, 200] {
            let mut model =
                Instance::new(&RateDependentPlay, &[3.0], &parameters(1e-4), 1e-4).unwrap();
            let signal = crate::testing::triangle(-50.0, 50.0, points, 3);
            let output = model.response(-50.0, &signal);
            let rate = 100.0 / points as f64 / 1e-4;
            let widths = [3.0, 8.0, 20.0].map(|r| r + 1e-4 * rate);
            let expected: f64 =
                widths.iter().zip([0.01, 0.02, 0.01]).map(|(r, w)| 4.0 * w * r * (50.0 - r)).sum();
            let area = loop_area(&signal[4 * points..], &output[4 * points..]);
            // The corners of the parallelogram fall between samples.
            assert!((area / expected - 1.0).abs() < 0.03, "{points}: {area} {expected}");
        }
    }

    #[test]
    fn the_inverse_leaves_a_fraction_of_the_rate_terms_effect() {
        let period = 1e-5;
        let wanted =
            |n: u32| 4.0 - 3.0 * (core::f64::consts::TAU * 50.0 * period * f64::from(n)).cos();
        let rms = |rate: f64| {
            let p = parameters(1e-4);
            let inverse = parameters(rate);
            let mut forward = Instance::new(&RateDependentPlay, &[3.0], &p, period).unwrap();
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
    fn a_threshold_is_wider_by_the_rate_of_the_step() {
        // Threshold 1 V and 0.125 s: 2 V in a step of 4 V in 0.5 s, 1 V once the command is held.
        let p = [1.0, 1.0, 0.5, 0.25, 0.125];
        let mut model = Instance::new(&RateDependentPlay, &[1.0], &p, 0.5).unwrap();
        assert_eq!(model.rest(&[0.0]), 0.5);
        assert_eq!([model.step(&[4.0]), model.step(&[4.0])], [0.5 + 1.0 + 2.0, 0.5 + 1.0 + 3.0]);
    }

    #[test]
    fn thresholds_and_weights_are_checked() {
        let refused = |p: [f64; 7]| {
            let built = Instance::new(&RateDependentPlay, &[2.0], &p, 1e-3);
            built.err().map(|v| (v.quantity, v.index))
        };
        assert_eq!(refused([1.0, 0.5, 1.0, 1.0, 0.0, 1.0, 0.0]), Some(("r", Some(1))));
        assert_eq!(refused([0.5, 1.0, 1.0, -1.0, 0.0, 1.0, 0.0]), Some(("w", Some(1))));
        assert_eq!(refused([0.5, 1.0, 1.0, 1.0, 0.0, 1.0, 0.0]), None);
    }
}

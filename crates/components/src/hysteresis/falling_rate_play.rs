//! Rate-dependent Prandtl–Ishlinskii hysteresis that widens only while the command falls.
//!
//! ```text
//! y = offset + gain·u + Σ w_i F_i
//! F_i ← max(u − ρ_i, min(u + ρ_i, F_i)),   ρ_i = r_i + rate·max(−u̇, 0)
//! ```
//!
//! * r, w as in `prandtl-ishlinskii`; gain in position per command: a part without memory; rate in
//!   s: growth of every threshold with the rate of a falling command. u̇ is the backward difference
//!   as in `rate`, 0 at rest.
//! * State: one number per play, the five of `rate`.
//!
//! Limits: the rising branch knows no rate; noise in the command counts as rate.
//!
//! Source: M. Al Janaideh, P. Krejčí, IEEE/ASME Transactions on Mechatronics 18 (2013) 1498–1507
//! (thresholds that grow with the rate), of which this is the falling half.

use libm::fmax;
use model::{
    Component, Conversion, Declaration, Example, Fit, Input, Inverse, Missing, Output, Quantity,
    Role, Sizes, Stage, Tick, Violation,
};

use super::numeric_inverse::{Forward, NumericInverse, Rates, mean_slope};
use super::play::Plays;
use super::prandtl_ishlinskii::{OFFSET, R, STRUCTURE, W, check_plays};
use super::rate;
use super::rate_dependent_play::{
    COMMAND_MAX, COMMAND_MIN, FREE_GROWTH, GROWTH, widened, widened_frozen,
};
use crate::effects;
use crate::rules::{WRONG_LENGTH, kept, require};

/// The component `falling-rate-play`.
pub struct FallingRatePlay;

/// The component `inverse-falling-rate-play`.
pub static INVERSE: NumericInverse<FallingRatePlay> =
    NumericInverse { forward: &FallingRatePlay, declaration: &INVERSE_DECLARATION };

const GAIN: Quantity =
    Quantity::new("gain", "{position}/{command}", "Linear part without hysteresis")
        .role(Role::Slope)
        .start(0.0)
        .min(0.0)
        .fitted();
const RATE: Quantity =
    Quantity::new("rate", "s", "Growth of every threshold with the rate of a falling command")
        .min(0.0)
        .fitted();

static DECLARATION: Declaration = Declaration {
    kind: "falling-rate-play",
    name: "hysteresis",
    summary: "Hysteresis that widens with the rate while the command falls",
    equation: "y = offset + gain*u + sum(w[i]*F[i]); F[i] = max(u - t[i], min(u + t[i], F[i])); \
               t[i] = r[i] + rate*max(-u', 0)",
    reference: "M. Al Janaideh, P. Krejci, IEEE/ASME Trans. Mechatronics 18 (2013) 1498-1507",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::RATE_DEPENDENCE),
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: STRUCTURE,
    parameters: &[R, W, OFFSET, GAIN, RATE],
};

static INVERSE_DECLARATION: Declaration = Declaration {
    kind: "inverse-falling-rate-play",
    name: "feedforward",
    summary: "Inverse of a falling-rate-play model, solved at each step",
    equation: "forward(u) = y, with u' = y'/(mean slope of the largest loop)",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    effect: None,
    parameters: &[R, W, OFFSET, GAIN, RATE, COMMAND_MIN, COMMAND_MAX],
    ..DECLARATION
};

/// `r | w | offset | gain | rate` (parameters), and 1/T behind them (coefficients).
fn split(coefficients: &[f64]) -> Option<(Plays<'_>, [f64; 4])> {
    let (arrays, &scalars) = coefficients.split_last_chunk::<4>()?;
    let (r, w) = arrays.split_at(arrays.len() / 2);
    Some((Plays { r, w }, scalars))
}

static FIT: Fit = Fit {
    summary: "Prandtl-Ishlinskii whose loop widens with the rate while the command falls",
    powers: &[("gain", 1)],
    search: &[GROWTH],
    starts: &[&[0.0], &[1e-4], &[1e-3], &[1e-2]],
};

static MISSING: Missing =
    Missing { name: "thresholds that grow while the command falls", free: &[FREE_GROWTH] };

impl Component for FallingRatePlay {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> Example {
        &[
            ("r", &[4.0, 12.0]),
            ("w", &[0.02, 0.01]),
            ("offset", &[0.3]),
            ("gain", &[0.05]),
            ("rate", &[1e-05]),
        ]
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::iteration("inverse-falling-rate-play")] }
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
        *y = offset + gain * u + widened(plays, u, growth * fmax(-memory[1], 0.0), sum);
    }
}

impl Forward for FallingRatePlay {
    fn frozen(&self, coefficients: &[f64], state: &[f64], [rate, _]: Rates, u: f64) -> f64 {
        let Some((plays, [offset, gain, growth, _])) = split(coefficients) else { return 0.0 };
        offset + gain * u + widened_frozen(plays, u, growth * fmax(-rate, 0.0), state)
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
        let rule = "a model whose plays all have dead bands has no inverse; give a gain above 0";
        require(gain > 0.0, "gain", gain, rule)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, loop_area, triangle};

    fn parameters(rate: f64) -> [f64; 9] {
        [3.0, 8.0, 20.0, 0.01, 0.02, 0.01, 0.3, 0.05, rate]
    }

    #[test]
    fn a_threshold_is_wider_only_in_a_step_that_falls() {
        // Threshold 1 V and 0.125 s: 1 V in a step of 4 V up in 0.5 s, 2 V in one down, 1 V once the command is held.
        let p = [1.0, 1.0, 0.5, 0.25, 0.125];
        let mut model = Instance::new(&FallingRatePlay, &[1.0], &p, 0.5).unwrap();
        assert_eq!(model.rest(&[0.0]), 0.5);
        assert_eq!([model.step(&[4.0]), model.step(&[4.0])], [0.5 + 1.0 + 3.0; 2]);
        assert_eq!([model.step(&[0.0]), model.step(&[0.0])], [0.5 + 2.0, 0.5 + 1.0]);
    }

    #[test]
    fn the_falling_side_of_a_loop_is_wider_by_the_rate() {
        // ±50 V; 4·50 V per cycle in `points`·2 steps of 0.1 ms.
        for points in [20usize, 200] {
            let mut model =
                Instance::new(&FallingRatePlay, &[3.0], &parameters(1e-4), 1e-4).unwrap();
            let signal = triangle(-50.0, 50.0, points, 3);
            let output = model.response(-50.0, &signal);
            let wider = 100.0 / points as f64;
            let plays = [(3.0, 0.01), (8.0, 0.02), (20.0, 0.01)];
            let widths = plays.map(|(r, w)| (2.0 * r + wider, w));
            let expected: f64 = widths.iter().map(|(both, w)| w * both * (100.0 - both)).sum();
            let area = loop_area(&signal[4 * points..], &output[4 * points..]);
            // The corners of the parallelogram fall between samples.
            assert!((area / expected - 1.0).abs() < 0.03, "{points}: {area} {expected}");
        }
    }

    #[test]
    fn the_inverse_undoes_it_but_for_a_fraction_of_the_rate_terms_effect() {
        let period = 1e-5;
        let wanted =
            |n: u32| 4.0 - 3.0 * (core::f64::consts::TAU * 50.0 * period * f64::from(n)).cos();
        let rms = |machine: f64, model: f64| {
            let p = parameters(machine);
            let mut forward = Instance::new(&FallingRatePlay, &[3.0], &p, period).unwrap();
            let p = [&parameters(model)[..], &[-50.0, 150.0]].concat();
            let mut inverse = Instance::new(&INVERSE, &[3.0], &p, period).unwrap();
            assert!((forward.rest(&[inverse.rest(&[1.0])]) - 1.0).abs() < 1e-9);
            let errors = (1..6000).map(|n| forward.step(&[inverse.step(&[wanted(n)])]) - wanted(n));
            (errors.skip(1000).map(|e| e * e).sum::<f64>() / 5000.0).sqrt()
        };
        let (with, without) = (rms(1e-4, 1e-4), rms(1e-4, 0.0));
        assert!(without > 0.02, "the rate term must act: {without}");
        assert!(with < 0.2 * without, "{with} of {without}");
        assert!(rms(0.0, 0.0) < 1e-9, "without a rate nothing is left");
    }
}

//! Logarithmic creep: after a step the position goes on by the same amount in each decade of time.
//!
//! `y(t) = y_r·[1 + gain·log₁₀(t/reference)]` after a step to y_r at t = 0
//!
//! * gain without unit, per decade (0.01–0.02); reference in s: the time after a step at which y_r
//!   was read (0.1 s in makers' tables).
//! * The law is made linear, and so valid for every input, by two first-order elements per decade
//!   from `shortest` to `longest` (structural), each with the share gain/2. Between five times the
//!   shortest and a tenth of the longest its step response is off the straight line by less than
//!   2.5 % of gain, one decade further inside by less than 0.3 %; before, y stays near
//!   y_r·[1 + gain·log₁₀(shortest/reference)]; after, it ends.
//! * State: one number per element. Exact at any period. At rest all elements are at the end.
//!
//! Limits: linear and the same for both signs.
//!
//! Source: H. Jung, D.-G. Gweon, Review of Scientific Instruments 71 (2000) 1896–1900.

use libm::{exp, log10, pow, round};
use model::{Component, Declaration, Quantity, Sizes, Stage, Structural, Tick, Violation};

use super::elements::{Elements, coefficients, parts_mut};
use crate::linear::approach;
use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `logarithmic-creep`.
pub struct LogarithmicCreep;

static DECLARATION: Declaration = Declaration {
    kind: "logarithmic-creep",
    name: "creep",
    summary: "Creep in proportion to the logarithm of time",
    equation: "y(t) = y(reference)*(1 + gain*log10(t/reference)) after a step",
    reference: "H. Jung, D.-G. Gweon, Rev. Sci. Instrum. 71 (2000) 1896-1900",
    stage: Stage::Actuator,
    effect: Some(&effects::CREEP),
    phenomena: &[&phenomena::CREEP],
    structure: &[
        Structural::real(
            "shortest",
            "s",
            "Time after a step at which creep begins",
            0.01,
            1e-6,
            1e3,
        ),
        Structural::real("longest", "s", "Time after a step at which creep ends", 1e4, 1e-3, 1e9),
    ],
    parameters: &[
        Quantity::new("gain", "1", "Relative growth of the position per decade of time")
            .releases(&effects::CREEP)
            .fitted(),
        Quantity::new("reference", "s", "Time after a step at which the growth is defined as zero")
            .start(0.1)
            .min(0.0)
            .from_to(0, 1),
    ],
    ..Declaration::PATH
};

/// Elements per decade. The response to a step of elements spaced by h = ln(10)/2 ripples about the
/// straight line by about 2·|Γ(2πi/h)| of an element's share, 1e-3.
const PER_DECADE: f64 = 2.0;

/// The time constants: a grid of two per decade. The sum of 1 − exp(−t/τ_i) over it begins to rise
/// at `shortest`, as its straight part meets zero at e^−γ/√ρ of its first τ (γ is Euler's
/// constant).
fn time_constant(shortest: f64, index: usize) -> f64 {
    const EULER: f64 = 0.577_215_664_901_532_9;
    shortest * exp(EULER) * pow(10.0, (index as f64 + 0.5) / PER_DECADE)
}

fn count(shortest: f64, longest: f64) -> usize {
    round(log10(longest / shortest) * PER_DECADE).clamp(1.0, 64.0) as usize
}

fn elements(structure: &[f64]) -> usize {
    let &[shortest, longest] = structure else { return 0 };
    count(shortest, longest)
}

impl Component for LogarithmicCreep {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let elements = elements(structure);
        Sizes { coefficients: coefficients(elements), states: elements }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[shortest, longest], &[gain, reference]) = (structure, parameters) else {
            return Err(WRONG_LENGTH);
        };
        require(
            shortest < longest,
            "reference",
            reference,
            "the structural setting `shortest` must be below `longest`; change them",
        )?;
        require(
            shortest <= reference && reference <= longest,
            "reference",
            reference,
            "must lie between the structural settings `shortest` and `longest`",
        )?;
        let (direct, fractions, shares) = parts_mut(coefficients).ok_or(WRONG_LENGTH)?;
        let share = gain / PER_DECADE;
        *direct = 1.0 - gain * log10(reference / shortest);
        for (i, (f, s)) in fractions.iter_mut().zip(shares).enumerate() {
            (*f, *s) = (approach(time_constant(shortest, i), period), share);
        }
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some(e), &[u], [y]) = (Elements::new(coefficients), inputs, outputs) else { return };
        *y = e.rest(u, state);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some(e), &[u], [y]) = (Elements::new(coefficients), inputs, outputs) else { return };
        *y = e.step(u, state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    /// Step response at `time`, from a few large steps or many small ones.
    fn response(gain: f64, time: f64, steps: u32) -> f64 {
        let period = time / f64::from(steps);
        let mut creep =
            Instance::new(&LogarithmicCreep, &[0.01, 1e4], &[gain, 0.1], period).unwrap();
        creep.rest(&[0.0]);
        (0..steps).map(|_| creep.step(&[1.0])).last().unwrap()
    }

    #[test]
    fn is_straight_over_the_logarithm_of_time() {
        let gain = 0.02;
        for (first, decades, most) in [(0.05, 4.3, 0.025), (0.5, 2.3, 0.003)] {
            for k in 0..=40 {
                let time = first * 10f64.powf(f64::from(k) / 40.0 * decades);
                let straight = 1.0 + gain * (time / 0.1).log10();
                let error = (response(gain, time, 1) - straight) / gain;
                assert!(error.abs() < most, "{time} s: {error} of the gain");
            }
        }
    }

    #[test]
    fn does_not_depend_on_the_step() {
        for time in [0.1, 3.0, 1000.0] {
            assert!((response(0.02, time, 1) - response(0.02, time, 1000)).abs() < 1e-13);
        }
    }

    #[test]
    fn at_rest_it_has_crept_to_the_end() {
        let mut creep = Instance::new(&LogarithmicCreep, &[0.01, 1e4], &[0.02, 0.1], 1e-3).unwrap();
        let end = creep.rest(&[1.0]);
        assert!((end - (1.0 + 0.02 * 5.0)).abs() < 1e-12, "{end}");
    }
}

//! A mode whose stiffness grows with its deflection (flexures that stretch).
//!
//! `x″ + 2ζω x′ + ω²·x·(1 + hardening·(x/reference)²) = ω²·u`
//!
//! * frequency in Hz, damping: of small motions; hardening ≥ 0 without unit: relative growth of the
//!   stiffness k₃x²/k at the deflection `reference` (0.001–0.05).
//! * State: x and x′/ω. Each period is cut into parts of at most 0.4 rad, or 0.6 rad of the stiffest motion; in
//!   each the linear part is exact and the cubic force is integrated by a rule of fourth order
//!   ([`ForcedMode`]). A state of equilibrium stays.
//! * Beyond three times the reference the force goes on straight, so that every input is safe.
//!
//! Limits: at most 10 000 parts per period: the internal step must suit the mode.
//!
//! Source: A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, Wiley 1979, ch. 4.

use libm::sqrt;
use model::{Component, Declaration, Quantity, Role, Sizes, Stage, Tick, Violation};

use crate::forced::ForcedMode;
use crate::hysteresis::play::between;
use crate::rules::{WRONG_LENGTH, require, second_order};
use crate::{effects, phenomena};

/// The component `duffing`.
pub struct Duffing;

static DECLARATION: Declaration = Declaration {
    kind: "duffing",
    name: "duffing",
    summary: "Mode whose stiffness grows with its deflection",
    equation: "x'' + 2*damping*w*x' + w^2*x*(1 + hardening*(x/reference)^2) = w^2*u; w = \
               2*pi*frequency",
    reference: "A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, Wiley 1979, ch. 4",
    stage: Stage::Mechanics,
    effect: Some(&effects::DUFFING),
    phenomena: &[&phenomena::AMPLITUDE_STIFFNESS],
    parameters: &[
        Quantity::new("frequency", "Hz", "Natural frequency of small motions")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .min(0.0)
            .fitted(),
        Quantity::new(
            "hardening",
            "1",
            "Relative growth of the stiffness at the reference deflection",
        )
        .min(0.0)
        .fitted(),
        Quantity::new("reference", "{position}", "Deflection at which the hardening is given")
            .min(0.0),
    ],
    ..Declaration::PATH
};

/// Deflection, in references, from which on the force is straight.
const REACH: f64 = 3.0;

/// The part of the force beyond the linear one, over the linear stiffness.
fn cubic(x: f64, hardening: f64, reference: f64) -> f64 {
    let inside = between(-REACH, REACH, x / reference);
    let beyond = x / reference - inside;
    (x + 2.0 * reference * beyond) * hardening * inside * inside
}

/// Solution of x + cubic(x) = u by Newton's method, which converges from u without overshoot as the
/// force is odd and grows more than linearly.
fn equilibrium(u: f64, hardening: f64, reference: f64) -> f64 {
    let mut x = u;
    for _ in 0..60 {
        let inside = between(-REACH, REACH, x / reference);
        let next = x
            - (x + cubic(x, hardening, reference) - u) / (1.0 + 3.0 * hardening * inside * inside);
        if next == x {
            break;
        }
        x = next;
    }
    x
}

/// `forced mode | hardening | reference`.
fn split(coefficients: &[f64]) -> Option<(ForcedMode, f64, f64)> {
    let (&mode, &[hardening, reference]) = coefficients.split_first_chunk()? else { return None };
    Some((ForcedMode::of(mode), hardening, reference))
}

impl Component for Duffing {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: ForcedMode::COEFFICIENTS + 2, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[frequency, damping, hardening, reference], Some((mode, [h, r]))) =
            (parameters, coefficients.split_first_chunk_mut())
        else {
            return Err(WRONG_LENGTH);
        };
        second_order(frequency, damping, period)?;
        require(reference > 0.0, "reference", reference, "must be above zero")?;
        let stiffest = sqrt(1.0 + 3.0 * hardening * REACH * REACH);
        *mode = ForcedMode::smooth(frequency, damping, period, stiffest)?.to_array();
        (*h, *r) = (hardening, reference);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((_, hardening, reference)), &[u], [x, v], [y]) =
            (split(coefficients), inputs, state, outputs)
        else {
            return;
        };
        (*x, *v) = (equilibrium(u, hardening, reference), 0.0);
        *y = *x;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((mode, hardening, reference)), &[u], Ok(state), [y]) =
            (split(coefficients), inputs, state.try_into(), outputs)
        else {
            return;
        };
        *y = mode.advance(u, state, |x, _| cubic(x, hardening, reference));
    }
}

#[cfg(test)]
mod tests {
    use super::super::MODE;
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn without_hardening_it_is_the_mode() {
        let signal = Random::new(2).signal(-1.0, 1.0, 200);
        let duffing = Instance::new(&Duffing, &[], &[400.0, 0.02, 0.0, 1.0], 1e-4);
        let mode = Instance::new(&MODE, &[], &[400.0, 0.02, 1.0], 1e-4);
        let (a, b) =
            (duffing.unwrap().response(0.0, &signal), mode.unwrap().response(0.0, &signal));
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-11));
    }

    #[test]
    fn a_free_motion_keeps_its_energy_but_for_the_damping() {
        let (damping, hardening) = (1e-9, 0.3);
        let mut model =
            Instance::new(&Duffing, &[], &[100.0, damping, hardening, 1.0], 1e-4).unwrap();
        model.rest(&[0.0]);
        model.state[0] = 1.5;
        let energy = |x: f64, v: f64| 0.5 * v * v + 0.5 * x * x + 0.25 * hardening * x * x * x * x;
        let start = energy(1.5, 0.0);
        let mut crossings = 0;
        let mut last = 1.5;
        for _ in 0..100_000 {
            let x = model.step(&[0.0]);
            crossings += u32::from(last < 0.0 && x >= 0.0);
            last = x;
        }
        let end = energy(model.state[0], model.state[1]);
        assert!((end / start - 1.0).abs() < 0.02, "{end} {start}");
        // The backbone curve: frequency × (1 + 3/8·hardening·amplitude²) for small hardening.
        let expected = 10.0 * 100.0 * (1.0 + 0.375 * hardening * 1.5 * 1.5);
        assert!((f64::from(crossings) / expected - 1.0).abs() < 0.03, "{crossings} {expected}");
    }

    /// Ten rows per period, and beyond the reference, where the spring is up to twice as stiff.
    #[test]
    fn rows_of_a_log_do_what_short_steps_do() {
        for (hardening, level) in [(0.05, 0.5), (0.3, 0.5), (0.3, 1.5)] {
            let run = |hardening: f64, parts: usize| {
                let p = [400.0, 0.02, hardening, 1.0];
                let mut model = Instance::new(&Duffing, &[], &p, 2.5e-4 / parts as f64).unwrap();
                model.rest(&[0.0]);
                let rows = (0..300).map(|n| if n % 60 < 30 { level } else { -0.4 * level });
                let mut row = |u| (0..parts).fold(0.0, |_, _| model.step(&[u]));
                rows.map(&mut row).collect::<std::vec::Vec<f64>>()
            };
            let rms = |a: &[f64], b: &[f64]| {
                a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
            };
            let fine = run(hardening, 50);
            let part = rms(&run(hardening, 1), &fine) / rms(&fine, &run(0.0, 50));
            assert!(part < 2e-3, "{hardening} {level}: {part} of what the hardening does");
        }
    }

    #[test]
    fn rest_is_an_equilibrium() {
        let mut model = Instance::new(&Duffing, &[], &[400.0, 0.02, 0.05, 1.0], 1e-4).unwrap();
        for u in [0.0, 1.0, -2.5, 40.0] {
            let x = model.rest(&[u]);
            assert!((x + cubic(x, 0.05, 1.0) - u).abs() < 1e-13 * u.abs().max(1.0));
            for _ in 0..100 {
                assert!((model.step(&[u]) - x).abs() < 1e-12 * u.abs().max(1.0));
            }
        }
    }
}

//! Reference lead: makes up for the dynamics that a static inverse leaves out.
//!
//! ```text
//! y = r + clamp(lag·r′ + inertia·r″, ±limit)
//! r′ ≈ (3 r_n − 4 r_{n−1} + r_{n−2})/(2T),  r″ ≈ (r_n − 2 r_{n−1} + r_{n−2})/T²
//! ```
//!
//! * For a mode, `x″/ω² + 2ζx′/ω + x = u` is solved by `u = r + 2ζ/ω·r′ + r″/ω²`: lag 2ζ/ω, inertia
//!   1/ω². First-order lags and delays behind the command add their time constants to `lag`.
//! * Only past samples of the reference are used; it needs no preview.
//! * `limit` bounds the addition: a jump of the reference has no finite derivative, and what is
//!   added passes through the memory of a hysteresis inverse.
//! * State: the two samples before. At rest: y = r.
//!
//! Limits: differences amplify a noisy or quantised reference by 4·inertia/T².
//!
//! Source: inversion of linear dynamics for feedforward, S. Devasia, E. Eleftheriou, S. O. R.
//! Moheimani, IEEE Trans. Control Systems Technology 15 (2007) 802–823.

use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::hysteresis::play::between;
use crate::phenomena;
use crate::rules::WRONG_LENGTH;

/// The component `reference-lead`.
pub struct ReferenceLead;

static DECLARATION: Declaration = Declaration {
    kind: "reference-lead",
    name: "lead",
    summary: "Adds the first and second derivative of the reference, for lags and a mode",
    equation: "y = r + clamp(lag*r' + inertia*r'', +-limit)",
    reference: "S. Devasia, E. Eleftheriou, S. O. R. Moheimani, IEEE Trans. Control Syst. \
                Technol. 15 (2007) 802-823",
    stage: Stage::Control,
    phenomena: &[&phenomena::CONTROLLER_DIFFERENCE],
    parameters: &[
        Quantity::new("lag", "s", "Sum of the path's time constants and delays").min(0.0).tunable(),
        Quantity::new("inertia", "s2", "Second-order coefficient, 1/omega^2 for one mode")
            .min(0.0)
            .tunable(),
        Quantity::new("limit", "{position}", "Greatest correction in either direction")
            .min(0.0)
            .tunable(),
    ],
    ..Declaration::PATH
};

impl Component for ReferenceLead {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[("lag", &[1e-3]), ("inertia", &[1e-7]), ("limit", &[0.5])]
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 3, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[lag, inertia, limit], [newer, older, bound]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        let (first, second) = (0.5 * lag / period, inertia / (period * period));
        (*newer, *older) = (3.0 * first + second, -first - second);
        *bound = limit;
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[r], [y]) = (inputs, outputs) else { return };
        state.fill(r);
        *y = r;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[newer, older, bound], [last, before], &[r], [y]) =
            (coefficients, state, inputs, outputs)
        else {
            return;
        };
        // In differences, as the three coefficients add up to zero: a constant reference is passed
        // on to the bit.
        let addition = newer * (r - *last) + older * (*last - *before);
        *y = r + between(-bound, bound, addition);
        (*before, *last) = (*last, r);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: f64 = 1e-4;

    /// The outputs for a reference, from rest at its first value.
    fn run(parameters: &[f64; 3], reference: &[f64]) -> std::vec::Vec<f64> {
        let (mut coefficients, mut state, mut out) = ([0.0; 3], [0.0; 2], [0.0]);
        ReferenceLead.prepare(&[], parameters, T, &mut coefficients).expect("valid parameters");
        ReferenceLead.rest(&coefficients, &reference[..1], &mut state, &mut out);
        let tick = Tick { index: 1, time: T, period: T };
        let step = |r: &f64| {
            ReferenceLead.step(&coefficients, &mut state, tick, &[*r], &mut out);
            out[0]
        };
        reference.iter().map(step).collect()
    }

    #[test]
    fn a_constant_reference_passes_to_the_bit() {
        for r in [0.1 + 0.2, -3.7e-6, 0.0] {
            assert!(run(&[1e-3, 1e-6, 1.0], &[r; 5]).iter().all(|y| y.to_bits() == r.to_bits()));
        }
    }

    #[test]
    fn a_parabola_gets_its_exact_derivatives() {
        let (lag, inertia) = (2e-3, 5e-7);
        let t = |k: usize| k as f64 * T;
        let reference: std::vec::Vec<f64> = (0..50).map(|k| 3.0 * t(k) * t(k) + t(k)).collect();
        for (k, y) in run(&[lag, inertia, 1.0], &reference).iter().enumerate().skip(3) {
            let exact = reference[k] + lag * (6.0 * t(k) + 1.0) + inertia * 6.0;
            assert!((y - exact).abs() < 1e-14, "{k}: {y} {exact}");
        }
    }

    #[test]
    fn a_jump_adds_no_more_than_the_limit() {
        let y = run(&[1e-3, 1e-6, 0.25], &[0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!(y, [0.0, 0.0, 1.25, 0.75, 1.0, 1.0]);
    }
}

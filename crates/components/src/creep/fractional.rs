//! Fractional-order creep: a power law of frequency, as a ladder of poles and zeros.
//!
//! `G(s) = Π (s + z_k)/(s + p_k)` ≈ `(s/(2π·highest))^(−order)` between `lowest` and `highest`
//!
//! * order without unit, 0.02–0.15: the gain falls by 20·order dB per decade at the constant phase
//!   −90°·order.
//! * lowest, highest in Hz (structural): the band. Below it the gain stays at
//!   (highest/lowest)^order, above it at 1, so the direct elongation is the input itself.
//! * Poles and zeros lie three per decade (Oustaloup). One decade inside the band the gain is off
//!   the power law by less than 0.15 % for orders up to 0.3, and the phase by less than 6°·order;
//!   two decades inside by less than 0.003 % and 0.6°·order.
//! * State: one number per pole. Exact at any period, as the ladder is taken apart into parallel
//!   first-order elements.
//!
//! Limits: linear; at rest the gain is that of the band's lower end.
//!
//! Source: A. Oustaloup, F. Levron, B. Mathieu, F. M. Nanot, IEEE Transactions on Circuits and
//! Systems I 47 (2000) 25–39.

use core::f64::consts::TAU;

use libm::{log10, pow, round};
use model::{Component, Declaration, Quantity, Sizes, Stage, Structural, Tick, Violation};

use super::elements::{Elements, coefficients, parts_mut};
use crate::linear::approach;
use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `fractional-creep`.
pub struct FractionalCreep;

static DECLARATION: Declaration = Declaration {
    kind: "fractional-creep",
    name: "creep",
    summary: "Creep as a power law of frequency between two frequencies",
    equation: "G(s) = product((s + z[k])/(s + p[k])), about (s/(2*pi*highest))^(-order) between \
               lowest and highest",
    reference: "A. Oustaloup et al., IEEE Trans. Circuits and Systems I 47 (2000) 25-39",
    stage: Stage::Actuator,
    effect: Some(&effects::CREEP),
    phenomena: &[&phenomena::CREEP],
    structure: &[
        Structural::real("lowest", "Hz", "Lower end of the band", 1e-4, 1e-9, 1e6),
        Structural::real("highest", "Hz", "Upper end of the band", 100.0, 1e-6, 1e9),
    ],
    parameters: &[Quantity::new("order", "1", "Order of the integral").min(0.0).max(0.9).fitted()],
    ..Declaration::PATH
};

const PER_DECADE: f64 = 3.0;
const MOST: f64 = 64.0;

fn elements(structure: &[f64]) -> usize {
    let &[lowest, highest] = structure else { return 0 };
    round(log10(highest / lowest) * PER_DECADE).clamp(1.0, MOST) as usize
}

/// Pole and zero number `k` of `count`, in rad/s: a pole, half a spacing less the order, a zero.
fn pair(structure: &[f64; 2], order: f64, k: usize, count: usize) -> (f64, f64) {
    let [lowest, highest] = structure;
    let at =
        |part: f64| TAU * lowest * pow(highest / lowest, (k as f64 + 0.5 + part) / count as f64);
    (at(-0.5 * order), at(0.5 * order))
}

impl Component for FractionalCreep {
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
        let (&[lowest, highest], &[order]) = (structure, parameters) else {
            return Err(WRONG_LENGTH);
        };
        require(
            lowest < highest,
            "order",
            order,
            "the structural setting `lowest` must be below `highest`; change them",
        )?;
        let (direct, fractions, shares) = parts_mut(coefficients).ok_or(WRONG_LENGTH)?;
        *direct = 1.0;
        let count = shares.len();
        let pair = |k| pair(&[lowest, highest], order, k, count);
        for (k, (f, share)) in fractions.iter_mut().zip(shares).enumerate() {
            let (pole, zero) = pair(k);
            // Residue of the product at −p_k, as the static gain of this element.
            let mut residue = (zero - pole) / pole;
            for j in (0..count).filter(|j| *j != k) {
                let (p, z) = pair(j);
                residue *= (z - pole) / (p - pole);
            }
            (*f, *share) = (approach(1.0 / pole, period), residue);
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

    const BAND: [f64; 2] = [1e-4, 100.0];

    /// Gain and phase (degrees) of the parallel form at a frequency in Hz.
    fn response(order: f64, frequency: f64) -> (f64, f64) {
        let count = elements(&BAND);
        let mut coefficients = std::vec![0.0; 2 * count + 1];
        FractionalCreep.prepare(&BAND, &[order], 1e-3, &mut coefficients).unwrap();
        let (mut re, mut im) = (1.0, 0.0);
        for k in 0..count {
            let ratio = TAU * frequency / pair(&BAND, order, k, count).0;
            let share = coefficients[1 + count + k];
            re += share / (1.0 + ratio * ratio);
            im -= share * ratio / (1.0 + ratio * ratio);
        }
        (re.hypot(im), im.atan2(re).to_degrees())
    }

    #[test]
    fn is_the_power_law_within_the_stated_errors() {
        for order in [0.02, 0.15, 0.3] {
            for (inside, gain_error, phase_error) in [(1.0, 1.5e-3, 6.0), (2.0, 3e-5, 0.6)] {
                for k in 0..=80 {
                    let decade = -4.0 + inside + (6.0 - 2.0 * inside) * f64::from(k) / 80.0;
                    let frequency = 10f64.powf(decade);
                    let (gain, phase) = response(order, frequency);
                    let gain = gain / (frequency / 100.0).powf(-order) - 1.0;
                    let phase = (phase + 90.0 * order) / order;
                    assert!(gain.abs() < gain_error, "order {order}, {frequency} Hz: gain {gain}");
                    assert!(phase.abs() < phase_error, "order {order}, {frequency} Hz: {phase}");
                }
            }
        }
    }

    #[test]
    fn order_zero_changes_nothing() {
        let mut creep = Instance::new(&FractionalCreep, &BAND, &[0.0], 1e-3).unwrap();
        assert_eq!(creep.rest(&[2.0]), 2.0);
        assert_eq!(creep.step(&[5.0]), 5.0);
    }

    #[test]
    fn at_rest_the_gain_is_that_of_the_lower_end() {
        let mut creep = Instance::new(&FractionalCreep, &BAND, &[0.1], 1e-3).unwrap();
        let gain = creep.rest(&[1.0]);
        assert!((gain - 1e6f64.powf(0.1)).abs() < 1e-9, "{gain}");
    }
}

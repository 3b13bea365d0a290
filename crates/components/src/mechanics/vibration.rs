//! Vibration at fixed frequencies (pumps, spindles, fans).
//!
//! `y = x + Σ amplitude_i·sin(2π·frequency_i·t + phase_i)`
//!
//! * amplitude in position, frequency in Hz, phase in rad for each line; t the time.
//! * No state: a function of time.
//!
//! Limits: steady lines.

use core::f64::consts::TAU;

use model::{Component, Declaration, Quantity, Sizes, Stage, Structural, Tick, Violation};

use crate::rules::WRONG_LENGTH;
use crate::turn;
use crate::{effects, phenomena};

/// The component `vibration`.
pub struct Vibration;

static DECLARATION: Declaration = Declaration {
    kind: "vibration",
    name: "vibration",
    summary: "Vibration at fixed frequencies",
    equation: "y = x + sum(amplitude[i]*sin(2*pi*frequency[i]*t + phase[i]))",
    reference: "sum of sines",
    stage: Stage::Mechanics,
    effect: Some(&effects::PERIODIC_DISTURBANCE),
    phenomena: &[&phenomena::VIBRATION],
    structure: &[Structural::count("lines", "Number of lines", 1, 64)],
    parameters: &[
        Quantity::new("frequency", "Hz", "Frequency of each line").min(0.0).per(0).fitted(),
        Quantity::new("amplitude", "{position}", "Amplitude of each line").per(0).fitted(),
        Quantity::new("phase", "rad", "Phase of each line at time 0").per(0).fitted(),
    ],
    ..Declaration::PATH
};

impl Component for Vibration {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: DECLARATION.parameter_count(structure), states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        if parameters.len() != coefficients.len() {
            return Err(WRONG_LENGTH);
        }
        coefficients.copy_from_slice(parameters);
        // Phases in turns.
        let phases = coefficients.len() / 3 * 2;
        coefficients.iter_mut().skip(phases).for_each(|phase| *phase /= TAU);
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[x], [y]) = (inputs, outputs) else { return };
        *y = x;
    }

    fn step(
        &self,
        coefficients: &[f64],
        _state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[x], [y]) = (inputs, outputs) else { return };
        let lines = coefficients.len() / 3;
        let (frequency, rest) = coefficients.split_at(lines);
        let (amplitude, phase) = rest.split_at(lines);
        let lines = frequency.iter().zip(amplitude).zip(phase);
        *y = lines.fold(x, |y, ((f, a), phase)| y + a * turn::sin(f * tick.time + phase));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn adds_its_lines() {
        let mut model =
            Instance::new(&Vibration, &[2.0], &[10.0, 25.0, 1.0, 0.5, 0.0, 1.0], 1e-3).unwrap();
        assert_eq!(model.rest(&[2.0]), 2.0);
        for n in 1..100 {
            let t = 1e-3 * f64::from(n);
            let expected = 2.0 + (TAU * 10.0 * t).sin() + 0.5 * (TAU * 25.0 * t + 1.0).sin();
            assert!((model.step(&[2.0]) - expected).abs() < 1e-12);
        }
    }
}

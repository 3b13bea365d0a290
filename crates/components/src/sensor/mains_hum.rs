//! Hum of the mains and its harmonics.
//!
//! `y = x + Σ_k amplitude_k·sin(2π·k·frequency·t + phase_k)`, k = 1, 2, …
//!
//! * frequency in Hz: 50 or 60, ± 0.05; amplitude in position, phase in rad for each harmonic; t
//!   the time.
//! * No state: a function of time.
//!
//! Limits: added to the reading; hum of the amplifier would pass the actuator.

use core::f64::consts::TAU;

use model::{Component, Declaration, Quantity, Sizes, Stage, Structural, Tick, Violation};

use crate::rules::WRONG_LENGTH;
use crate::turn;
use crate::{effects, phenomena};

/// The component `mains-hum`.
pub struct MainsHum;

static DECLARATION: Declaration = Declaration {
    kind: "mains-hum",
    name: "hum",
    summary: "Hum of the mains and its harmonics",
    equation: "y = x + sum(amplitude[k]*sin(2*pi*k*frequency*t + phase[k]))",
    reference: "sum of sines",
    stage: Stage::Sensor,
    effect: Some(&effects::MAINS_HUM),
    phenomena: &[&phenomena::MAINS_HUM],
    structure: &[Structural::count(
        "harmonics",
        "Number of harmonics, the first being the mains",
        1,
        64,
    )],
    parameters: &[
        Quantity::new("amplitude", "{position}", "Amplitude of each harmonic").per(0).fitted(),
        Quantity::new("phase", "rad", "Phase of each harmonic at time 0").per(0).fitted(),
        Quantity::new("frequency", "Hz", "Frequency of the mains").start(50.0).min(0.0).fitted(),
    ],
    ..Declaration::PATH
};

impl Component for MainsHum {
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
        let (lines, _) = coefficients.split_at_mut(coefficients.len().saturating_sub(1));
        let amplitudes = lines.len() / 2;
        lines.iter_mut().skip(amplitudes).for_each(|phase| *phase /= TAU);
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
        let (Some((frequency, lines)), &[x], [y]) = (coefficients.split_last(), inputs, outputs)
        else {
            return;
        };
        let (amplitude, phase) = lines.split_at(lines.len() / 2);
        let turns = frequency * tick.time;
        let harmonics = (1u32..).zip(amplitude.iter().zip(phase));
        *y =
            harmonics.fold(x, |y, (k, (a, phase))| y + a * turn::sin(f64::from(k) * turns + phase));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn adds_the_harmonics() {
        let mut model =
            Instance::new(&MainsHum, &[2.0], &[1.0, 0.5, 0.0, 1.0, 50.0], 1e-3).unwrap();
        assert_eq!(model.rest(&[2.0]), 2.0);
        for n in 1..100 {
            let t = 1e-3 * f64::from(n);
            let expected = 2.0 + (TAU * 50.0 * t).sin() + 0.5 * (TAU * 100.0 * t + 1.0).sin();
            assert!((model.step(&[2.0]) - expected).abs() < 1e-12);
        }
    }
}

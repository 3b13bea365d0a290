//! Cutting force of an elliptical vibration cut: once per period, while the tool is in cut.
//!
//! `y = x + amplitude·sin(π·φ/duty)` for 0 ≤ φ < duty, else x;  φ = frac(frequency·t + phase/2π)
//!
//! * amplitude in position: greatest force over the machine's stiffness; frequency in Hz: of the
//!   ellipse; duty without unit: part of the period in cut (0.1–0.5); phase in rad; t the time.
//! * No state: a function of time.
//!
//! Limits: the force does not depend on the motion; a cut as deep as ever.
//!
//! Source: E. Shamoto, T. Moriwaki, CIRP Annals 43 (1994) 35–38 (the process).

use core::f64::consts::TAU;

use libm::floor;
use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::rules::{WRONG_LENGTH, kept, require};
use crate::turn;
use crate::{effects, phenomena};

/// The component `cutting-force`.
pub struct CuttingForce;

static DECLARATION: Declaration = Declaration {
    kind: "cutting-force",
    name: "cutting",
    summary: "Cutting force once per ellipse, while the tool is in cut",
    equation: "y = x + amplitude*sin(pi*p/duty) for p < duty, else x; p = frac(frequency*t + \
               phase/(2*pi))",
    reference: "E. Shamoto, T. Moriwaki, CIRP Annals 43 (1994) 35-38",
    stage: Stage::Mechanics,
    effect: Some(&effects::PERIODIC_DISTURBANCE),
    phenomena: &[&phenomena::CUTTING_FORCE],
    parameters: &[
        Quantity::new("amplitude", "{position}", "Greatest force over stiffness").fitted(),
        Quantity::new("frequency", "Hz", "Frequency of the ellipse").min(0.0).fitted(),
        Quantity::new("duty", "1", "Part of the period in cut")
            .start(0.3)
            .min(0.0)
            .max(1.0)
            .fitted(),
        Quantity::new("phase", "rad", "Phase at time 0").start(0.0).fitted(),
    ],
    ..Declaration::PATH
};

impl Component for CuttingForce {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 4, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[_, _, duty, _] = parameters else { return Err(WRONG_LENGTH) };
        require(duty > 0.0, "duty", duty, "must be above zero; set enabled = false for no cut")?;
        kept(parameters, coefficients)
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
        let (&[amplitude, frequency, duty, phase], &[x], [y]) = (coefficients, inputs, outputs)
        else {
            return;
        };
        let turns = frequency * tick.time + phase / TAU;
        let part = turns - floor(turns);
        *y = if part < duty { x + amplitude * turn::sin(0.5 * part / duty) } else { x };
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::testing::Instance;

    #[test]
    fn acts_for_its_duty_with_the_mean_of_half_a_sine() {
        let mut force = Instance::new(&CuttingForce, &[], &[3.0, 100.0, 0.25, 0.0], 1e-5).unwrap();
        force.rest(&[7.0]);
        let all: std::vec::Vec<f64> = (0..10_000).map(|_| force.step(&[7.0]) - 7.0).collect();
        let acting = all.iter().filter(|y| **y > 0.0).count();
        assert!((acting as f64 / 10_000.0 - 0.25).abs() < 2e-3, "{acting}");
        let mean = all.iter().sum::<f64>() / 10_000.0;
        assert!((mean - 3.0 * 0.25 * 2.0 / PI).abs() < 1e-4, "{mean}");
    }
}

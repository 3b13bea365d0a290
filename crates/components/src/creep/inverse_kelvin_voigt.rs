//! Inverse of creep by Kelvin–Voigt elements: what must be commanded so that the crept position is
//! the wanted one.
//!
//! `u = (y − Σ share_i·(1 − f_i)·z_i)/(1 + Σ share_i·f_i)`, z_i as in `kelvin-voigt-creep`
//!
//! * The exact inverse of `kelvin-voigt-creep` with the same values on the same period, sample by
//!   sample; on another period up to the hold.
//! * It stands where the creep stands behind the hysteresis: in front of the inverse hysteresis.
//! * At rest: u = y/(1 + Σ share_i).
//!
//! Source: as `kelvin-voigt-creep`; inverted in closed form, as it is linear.

use model::{Component, Declaration, Sizes, Stage, Tick, Violation};

use super::elements::{Elements, at_rest};
use super::kelvin_voigt::KelvinVoigtCreep;

/// The component `inverse-kelvin-voigt-creep`.
pub struct InverseKelvinVoigtCreep;

static DECLARATION: Declaration = Declaration {
    kind: "inverse-kelvin-voigt-creep",
    name: "creep",
    summary: "Inverse of Kelvin-Voigt creep: removes it from the reference",
    equation: "u + sum(share[i]*z[i]) = y; time_constant[i]*z[i]' = u - z[i]",
    reference: "H. Janocha, K. Kuhnen, Sensors and Actuators A 79 (2000) 83-89",
    stage: Stage::Control,
    structure: super::kelvin_voigt::DECLARATION.structure,
    parameters: super::kelvin_voigt::DECLARATION.parameters,
    ..Declaration::PATH
};

impl Component for InverseKelvinVoigtCreep {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[("share", &[0.02, 0.03]), ("time_constant", &[0.1, 5.0])]
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        KelvinVoigtCreep.sizes(structure, period)
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        KelvinVoigtCreep.prepare(structure, parameters, period, coefficients)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[y], [u]) = (inputs, outputs) else { return };
        *u = at_rest(coefficients, y);
        state.fill(*u);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some(e), &[y], [u]) = (Elements::new(coefficients), inputs, outputs) else { return };
        *u = e.solve(y, state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn behind_it_the_creep_gives_the_reference() {
        let p = [0.02, 0.03, -0.01, 0.004, 0.5, 20.0];
        let mut inverse = Instance::new(&InverseKelvinVoigtCreep, &[3.0], &p, 1e-3).unwrap();
        let mut creep = Instance::new(&KelvinVoigtCreep, &[3.0], &p, 1e-3).unwrap();
        let u = inverse.rest(&[3.0]);
        assert!((creep.rest(&[u]) - 3.0).abs() < 1e-14);
        for y in Random::new(3).signal(-5.0, 5.0, 2000) {
            let u = inverse.step(&[y]);
            assert!((creep.step(&[u]) - y).abs() < 1e-13);
        }
    }
}

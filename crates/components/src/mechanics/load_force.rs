//! A load force from outside, acting through the actuator's stiffness.
//!
//! `y = u + F/stiffness`
//!
//! In front of a mode it is exact: `m·x″ + c·x′ + k·x = k·(u + F/k) = k·u + F`, so the mode behind
//! it, loaded or not, answers to the force with its own mass and damping.
//!
//! * F is the axis' input `force`, in N, positive towards greater positions; stiffness in N per
//!   position, of the actuator with its flexure.
//! * No state.
//!
//! Limits: linear; the force does not show in the voltage (the direct piezoelectric effect on an
//! amplifier of finite impedance).

use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Violation};

use crate::phenomena;
use crate::rules::{WRONG_LENGTH, require};

/// The component `load-force`.
pub struct LoadForce;

static DECLARATION: Declaration = Declaration {
    kind: "load-force",
    name: "load",
    summary: "External load force through the actuator's stiffness, before a mode",
    equation: "y = u + force/stiffness",
    reference: "A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 3",
    stage: Stage::Mechanics,
    phenomena: &[&phenomena::LOAD_FORCE, &phenomena::CUTTING_FORCE],
    inputs: &[Input::PATH, Input::FORCE],
    parameters: &[Quantity::new(
        "stiffness",
        "N/{position}",
        "Stiffness of the actuator with its flexure",
    )
    .min(0.0)
    .fitted()],
    ..Declaration::PATH
};

impl Component for LoadForce {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 1, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[stiffness], [own]) = (parameters, coefficients) else { return Err(WRONG_LENGTH) };
        require(
            stiffness > 0.0 && (1.0 / stiffness).is_finite(),
            "stiffness",
            stiffness,
            "must be above zero: without stiffness a force has no bounded effect; give the maker's value",
        )?;
        *own = stiffness;
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[stiffness], &[u, force], [y]) = (coefficients, inputs, outputs) else { return };
        *y = u + force / stiffness;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn a_force_bends_by_its_stiffness() {
        let mut load = Instance::new(&LoadForce, &[], &[20e6], 1e-4).unwrap();
        assert!((load.rest(&[3e-6, 100.0]) - 8e-6).abs() < 1e-20);
        assert!((load.step(&[3e-6, -20.0]) - 2e-6).abs() < 1e-20);
        assert!(Instance::new(&LoadForce, &[], &[0.0], 1e-4).is_err());
    }
}

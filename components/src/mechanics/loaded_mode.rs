//! A mode under load: payload mass and a spring to the surroundings.
//!
//! ```text
//! (m + payload)·x″ + c·x′ + (k + external_stiffness)·x = k·u
//! k = m·(2π·frequency)²,   c = 2·damping·√(k·m)
//! ```
//!
//! * frequency, damping, mass m: of the mode without load; payload in kg; external_stiffness in
//!   N/m: a preload spring or the workpiece. The static gain is k/(k + external_stiffness), the
//!   frequency scales with √((1 + external_stiffness/k)/(1 + payload/m)).
//! * State: x and x′/ω. Exact at any period.
//!
//! Limits: one mode; the payload is rigid; gain and frequency move together with the stiffness, and
//! the frequency alone with the mass.

use core::f64::consts::TAU;

use libm::sqrt;
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use crate::effects;
use crate::linear::SecondOrder;
use crate::rules::{WRONG_LENGTH, require, second_order};

/// The component `loaded-mode`.
pub struct LoadedMode;

static DECLARATION: Declaration = Declaration {
    kind: "loaded-mode",
    name: "mode",
    summary: "Second-order mode under a payload mass and an external spring",
    equation: "(m + payload)*x'' + c*x' + (k + external_stiffness)*x = k*u; k = \
               m*(2*pi*frequency)^2; c = 2*damping*sqrt(k*m)",
    reference: "A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 2",
    stage: Stage::Mechanics,
    conversion: Conversion::None,
    effect: Some(&effects::RESONANCE_SHIFT),
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: &[],
    parameters: &[
        Quantity::new("frequency", "Hz", "Undamped natural frequency without load")
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio without load").min(0.0).fitted(),
        Quantity::new("mass", "kg", "Effective moving mass without load").min(0.0),
        Quantity::new("payload", "kg", "Mass of the payload").start(0.0).min(0.0).fitted(),
        Quantity::new("external_stiffness", "N/m", "Stiffness to the surroundings")
            .start(0.0)
            .min(0.0)
            .fitted(),
    ],
};

impl Component for LoadedMode {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: SecondOrder::COEFFICIENTS, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[frequency, damping, mass, payload, external], Ok(values)) =
            (parameters, <&mut [f64; 4]>::try_from(coefficients))
        else {
            return Err(WRONG_LENGTH);
        };
        require(mass > 0.0, "mass", mass, "must be above zero")?;
        second_order(frequency, damping, period)?;
        let stiffness = mass * (TAU * frequency) * (TAU * frequency);
        let (heavier, stiffer) = (1.0 + payload / mass, 1.0 + external / stiffness);
        let frequency = frequency * sqrt(stiffer / heavier);
        let damping = damping / sqrt(stiffer * heavier);
        *values = SecondOrder::new(frequency, damping, 1.0 / stiffer, period).to_array();
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[a, b, c, d], &[u], Ok(state), [y]) =
            (coefficients, inputs, state.try_into(), outputs)
        else {
            return;
        };
        *y = SecondOrder::of([a, b, c, d]).rest(u, state);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[a, b, c, d], &[u], Ok(state), [y]) =
            (coefficients, inputs, state.try_into(), outputs)
        else {
            return;
        };
        *y = SecondOrder::of([a, b, c, d]).step(u, state);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Mode;
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn without_load_it_is_the_mode() {
        let signal = Random::new(2).signal(-1.0, 1.0, 300);
        let loaded = Instance::new(&LoadedMode, &[], &[290.7, 0.02, 0.3, 0.0, 0.0], 1e-4);
        let mode = Instance::new(&Mode, &[], &[290.7, 0.02, 1.0], 1e-4);
        assert_eq!(loaded.unwrap().response(0.0, &signal), mode.unwrap().response(0.0, &signal));
    }

    #[test]
    fn three_times_the_mass_halve_the_frequency_and_an_equal_spring_halves_the_gain() {
        let k = 0.3 * (TAU * 290.7) * (TAU * 290.7);
        let mut heavy =
            Instance::new(&LoadedMode, &[], &[290.7, 0.02, 0.3, 0.9, 0.0], 1e-4).unwrap();
        let mut half = Instance::new(&Mode, &[], &[145.35, 0.01, 1.0], 1e-4).unwrap();
        for u in Random::new(2).signal(-1.0, 1.0, 300) {
            assert!((heavy.step(&[u]) - half.step(&[u])).abs() < 1e-12);
        }
        let mut stiff = Instance::new(&LoadedMode, &[], &[290.7, 0.02, 0.3, 0.0, k], 1e-4).unwrap();
        assert!((stiff.rest(&[3.0]) - 1.5).abs() < 1e-12);
    }
}

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
use model::{Declaration, Quantity, Role, Stage, Violation};

use crate::linear::SecondOrder;
use crate::low_pass::LowPass;
use crate::rules::{WRONG_LENGTH, require, second_order};
use crate::{effects, phenomena};

/// The component `loaded-mode`.
pub static LOADED_MODE: LowPass =
    LowPass { declaration: &DECLARATION, law: loaded, extended: |_| None };

static DECLARATION: Declaration = Declaration {
    kind: "loaded-mode",
    name: "mode",
    summary: "Second-order mode under a payload mass and an external spring",
    equation: "(m + payload)*x'' + c*x' + (k + external_stiffness)*x = k*u; k = \
               m*(2*pi*frequency)^2; c = 2*damping*sqrt(k*m)",
    reference: "A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 2",
    stage: Stage::Mechanics,
    effect: Some(&effects::RESONANCE_SHIFT),
    phenomena: &[&phenomena::PAYLOAD, &phenomena::ELLIPSE_ERROR],
    parameters: &[
        Quantity::new("frequency", "Hz", "Undamped natural frequency without load")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio without load")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .min(0.0)
            .fitted(),
        Quantity::new("mass", "kg", "Effective moving mass without load").min(0.0),
        Quantity::new("payload", "kg", "Mass of the payload").start(0.0).min(0.0).fitted(),
        Quantity::new("external_stiffness", "N/m", "Stiffness to the surroundings")
            .start(0.0)
            .min(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};

fn loaded(parameters: &[f64], period: f64) -> Result<SecondOrder, Violation> {
    let &[frequency, damping, mass, payload, external] = parameters else {
        return Err(WRONG_LENGTH);
    };
    require(mass > 0.0, "mass", mass, "must be above zero")?;
    second_order(frequency, damping, period)?;
    let stiffness = mass * (TAU * frequency) * (TAU * frequency);
    let (heavier, stiffer) = (1.0 + payload / mass, 1.0 + external / stiffness);
    let frequency = frequency * sqrt(stiffer / heavier);
    let damping = damping / sqrt(stiffer * heavier);
    Ok(SecondOrder::new(frequency, damping, 1.0 / stiffer, period))
}

#[cfg(test)]
mod tests {
    use super::super::MODE;
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn without_load_it_is_the_mode() {
        let signal = Random::new(2).signal(-1.0, 1.0, 300);
        let loaded = Instance::new(&LOADED_MODE, &[], &[290.7, 0.02, 0.3, 0.0, 0.0], 1e-4);
        let mode = Instance::new(&MODE, &[], &[290.7, 0.02, 1.0], 1e-4);
        assert_eq!(loaded.unwrap().response(0.0, &signal), mode.unwrap().response(0.0, &signal));
    }

    #[test]
    fn three_times_the_mass_halve_the_frequency_and_an_equal_spring_halves_the_gain() {
        let k = 0.3 * (TAU * 290.7) * (TAU * 290.7);
        let mut heavy =
            Instance::new(&LOADED_MODE, &[], &[290.7, 0.02, 0.3, 0.9, 0.0], 1e-4).unwrap();
        let mut half = Instance::new(&MODE, &[], &[145.35, 0.01, 1.0], 1e-4).unwrap();
        for u in Random::new(2).signal(-1.0, 1.0, 300) {
            assert!((heavy.step(&[u]) - half.step(&[u])).abs() < 1e-12);
        }
        let mut stiff =
            Instance::new(&LOADED_MODE, &[], &[290.7, 0.02, 0.3, 0.0, k], 1e-4).unwrap();
        assert!((stiff.rest(&[3.0]) - 1.5).abs() < 1e-12);
    }
}

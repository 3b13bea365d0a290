//! A second-order mode of the mechanics.
//!
//! `x″ + 2ζω x′ + ω² x = ω² · gain · u`, ω = 2π·frequency
//!
//! * frequency in Hz: undamped natural frequency, √(k/m)/2π; damping: ζ > 0, also ≥ 1; gain:
//!   static gain, 1 where the path already is a position.
//! * State: x and x′/ω. The input is held over a step, so the discretisation is exact at any
//!   period, also one much longer than the mode's ([`Transition`]). Over a
//!   step that is long against the mode the output at the step's end is right, and what happens
//!   within it is not seen.
//!
//! Limits: one mode, collocated; linear.

use model::{Component, Declaration, Extension, Quantity, Role, Stage};

use super::{Duffing, Friction, NonlinearDamping, PositionStiffness};
use crate::low_pass::{self, LowPass};
use crate::{effects, phenomena};

/// The component `mode`.
pub static MODE: LowPass =
    LowPass { declaration: &DECLARATION, law: low_pass::with_gain, extended };

static DECLARATION: Declaration = Declaration {
    kind: "mode",
    name: "mode",
    summary: "Second-order mode with exact discretisation at any step and any damping",
    equation: "x'' + 2*damping*w*x' + w^2*x = w^2*gain*u; w = 2*pi*frequency",
    reference: "A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 2",
    stage: Stage::Mechanics,
    effect: Some(&effects::EXTRA_MODE),
    phenomena: &[&phenomena::MODE, &phenomena::ELLIPSE_ERROR],
    parameters: &[
        Quantity::new("frequency", "Hz", "Undamped natural frequency")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio; 1 is critical")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .min(0.0)
            .fitted(),
        Quantity::new("gain", "1", "Static gain").role(Role::Gain).start(1.0).fitted(),
    ],
    ..Declaration::PATH
};

/// What a linear mode becomes with one thing more.
fn extended(by: Extension) -> Option<&'static dyn Component> {
    match by {
        Extension::Hardening => Some(&Duffing),
        Extension::PositionStiffness => Some(&PositionStiffness),
        Extension::Friction => Some(&Friction),
        Extension::NonlinearDamping => Some(&NonlinearDamping),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;
    use crate::testing::{Instance, Random};

    /// Closed form of the unit step response.
    fn step_response(frequency: f64, damping: f64, time: f64) -> f64 {
        let w = TAU * frequency;
        if damping < 1.0 {
            let d = (1.0 - damping * damping).sqrt();
            let (s, c) = (w * d * time).sin_cos();
            1.0 - (-damping * w * time).exp() * (c + damping / d * s)
        } else if damping == 1.0 {
            1.0 - (-w * time).exp() * (1.0 + w * time)
        } else {
            let d = (damping * damping - 1.0).sqrt();
            let (fast, slow) = (damping + d, 1.0 / (damping + d));
            1.0 - (fast * (-slow * w * time).exp() - slow * (-fast * w * time).exp()) / (2.0 * d)
        }
    }

    #[test]
    fn step_response_is_the_closed_form_for_all_dampings_and_step_sizes() {
        for damping in [3.63e-4, 0.02, 0.5, 0.99, 1.0, 1.01, 2.0, 20.0] {
            for period in [1e-6, 2e-5, 1e-4, 4e-3, 0.02] {
                let p = [404.0, damping, 3.0];
                let mut mode = Instance::new(&MODE, &[], &p, period).unwrap();
                mode.rest(&[0.0]);
                for n in 1..400 {
                    let exact = 3.0 * step_response(404.0, damping, f64::from(n) * period);
                    let error = mode.step(&[1.0]) - exact;
                    assert!(error.abs() < 1e-10, "zeta {damping}, T {period}, n {n}: {error}");
                }
            }
        }
    }

    #[test]
    fn critical_damping_is_no_special_case() {
        let signal = Random::new(5).signal(-1.0, 1.0, 500);
        let response = |damping: f64| {
            let mode = Instance::new(&MODE, &[], &[100.0, damping, 1.0], 1e-4);
            mode.unwrap().response(0.0, &signal)
        };
        let critical = response(1.0);
        for damping in [1.0 - 1e-9, 1.0 + 1e-9] {
            for (near, at) in response(damping).iter().zip(&critical) {
                assert!((near - at).abs() < 1e-8, "zeta {damping}: {near} {at}");
            }
        }
    }

    #[test]
    fn rest_is_an_equilibrium_to_the_bit() {
        let mut mode = Instance::new(&MODE, &[], &[482.6, 0.01, 0.9], 2e-5).unwrap();
        let rest = mode.rest(&[0.3]);
        assert!((0..10).all(|_| mode.step(&[0.3]).to_bits() == rest.to_bits()));
    }

    #[test]
    fn undamped_and_static_modes_are_refused() {
        let refused = |p: [f64; 3]| Instance::new(&MODE, &[], &p, 1e-4).err().map(|e| e.quantity);
        assert_eq!(refused([0.0, 0.1, 1.0]), Some("frequency"));
        assert_eq!(refused([100.0, 0.0, 1.0]), Some("damping"));
        assert_eq!(refused([1e300, 0.1, 1.0]), None);
        assert_eq!(refused([f64::MAX, 0.1, 1.0]), Some("frequency"));
    }
}

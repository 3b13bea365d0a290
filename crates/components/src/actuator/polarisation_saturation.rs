//! Saturation of the strain towards both ends of the voltage range.
//!
//! `v_eff = centre + half_range·S(ξ)`, `S(ξ) = ξ − flattening·ξ³`, ξ = (v − centre)/half_range
//!
//! * It acts on the command, before the actuator's gain or hysteresis. centre, half_range in
//!   command; flattening without unit: loss at both ends as a part of half the range (0.01–0.04).
//! * Beyond |ξ| = 1 S goes on straight, so it stays increasing. No state.
//!
//! Limits: symmetric about the centre; static.

use crate::hysteresis::play::between;
use model::{Component, Declaration, Quantity, Sizes, Stage, Violation};

use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `polarisation-saturation`.
pub struct PolarisationSaturation;

static DECLARATION: Declaration = Declaration {
    kind: "polarisation-saturation",
    name: "saturation",
    summary: "Saturation of the strain towards both ends of the voltage range",
    equation: "v = centre + half_range*(xi - flattening*xi^3); xi = (u - centre)/half_range, \
               straight beyond 1",
    reference: "IEEE Std 176-1987, IEEE Standard on Piezoelectricity (nonlinear limits)",
    stage: Stage::Actuator,
    effect: Some(&effects::POLARISATION_SATURATION),
    phenomena: &[&phenomena::POLARISATION_SATURATION],
    parameters: &[
        Quantity::new("flattening", "1", "Loss at the ends, relative to half the range")
            .min(0.0)
            .max(0.3)
            .fitted(),
        Quantity::new("centre", "{command}", "Middle of the range"),
        Quantity::new("half_range", "{command}", "Half of the range").min(0.0),
    ],
    ..Declaration::PATH
};

impl Component for PolarisationSaturation {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 3, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[.., half_range] = parameters else { return Err(WRONG_LENGTH) };
        require(half_range > 0.0, "half_range", half_range, "must be above zero")?;
        kept(parameters, coefficients)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[flattening, centre, half_range], &[u], [y]) = (coefficients, inputs, outputs) else {
            return;
        };
        let xi = (u - centre) / half_range;
        let inside = between(-1.0, 1.0, xi);
        let beyond = (1.0 - 3.0 * flattening) * (xi - inside);
        *y = centre + half_range * (inside - flattening * inside * inside * inside + beyond);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn loses_the_flattening_at_both_ends_and_stays_increasing() {
        let p = [0.03, 50.0, 50.0];
        let mut map = Instance::new(&PolarisationSaturation, &[], &p, 1e-3).unwrap();
        assert_eq!(map.step(&[50.0]), 50.0);
        assert!((map.step(&[100.0]) - 98.5).abs() < 1e-12);
        assert!((map.step(&[0.0]) - 1.5).abs() < 1e-12);
        let mut last = f64::NEG_INFINITY;
        for k in 0..400 {
            let v = map.step(&[-100.0 + f64::from(k)]);
            assert!(v > last);
            last = v;
        }
    }
}

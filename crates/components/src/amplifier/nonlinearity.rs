//! Offset and integral nonlinearity of converter and amplifier.
//!
//! `v = u + offset + half_range·(quadratic·ξ² + cubic·ξ³)`, ξ = (u − centre)/half_range
//!
//! * offset, centre, half_range in command; quadratic, cubic without unit: deviation at the ends of
//!   the range as a part of half of it (1e-4 to 5e-3).
//! * No state.
//!
//! Limits: static; meant for |ξ| ≤ 1.

use model::{Component, Declaration, Quantity, Sizes, Stage, Violation};

use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `amplifier-nonlinearity`.
pub struct AmplifierNonlinearity;

static DECLARATION: Declaration = Declaration {
    kind: "amplifier-nonlinearity",
    name: "nonlinearity",
    summary: "Offset and integral nonlinearity of converter and amplifier",
    equation: "v = u + offset + half_range*(quadratic*xi^2 + cubic*xi^3); xi = (u - \
               centre)/half_range",
    reference: "IEEE Std 1241, Terminology and Test Methods for Analog-to-Digital Converters",
    stage: Stage::Amplifier,
    effect: Some(&effects::SENSOR_NONLINEARITY),
    phenomena: &[&phenomena::CONVERTER_NONLINEARITY],
    parameters: &[
        Quantity::new("offset", "{command}", "Voltage at zero command").start(0.0).fitted(),
        Quantity::new("quadratic", "1", "Quadratic deviation at the end of the range")
            .start(0.0)
            .fitted(),
        Quantity::new("cubic", "1", "Cubic deviation at the end of the range").start(0.0).fitted(),
        Quantity::new("centre", "{command}", "Middle of the range"),
        Quantity::new("half_range", "{command}", "Half of the range").min(0.0),
    ],
    ..Declaration::PATH
};

impl Component for AmplifierNonlinearity {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 5, states: 0 }
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
        let (&[offset, quadratic, cubic, centre, half_range], &[u], [y]) =
            (coefficients, inputs, outputs)
        else {
            return;
        };
        let xi = (u - centre) / half_range;
        *y = u + offset + half_range * (quadratic + cubic * xi) * xi * xi;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn deviates_as_given_at_the_ends_and_not_in_the_middle() {
        let p = [0.5, 0.002, -0.004, 50.0, 50.0];
        let mut map = Instance::new(&AmplifierNonlinearity, &[], &p, 1e-3).unwrap();
        assert_eq!(map.step(&[50.0]), 50.5);
        assert!((map.step(&[100.0]) - (100.5 + 50.0 * (0.002 - 0.004))).abs() < 1e-12);
        assert!((map.step(&[0.0]) - (0.5 + 50.0 * (0.002 + 0.004))).abs() < 1e-12);
    }
}

//! Thermal growth of the structure with the temperature of the surroundings.
//!
//! `y = x + expansion·(T_s − reference)`, `time_constant·T_s′ = T − T_s`
//!
//! * T is the plant's input `temperature`; expansion in position per K; time_constant in s of the
//!   structure that follows it, 0: at once; reference: temperature without growth.
//! * State: T_s. At rest T_s = T.
//!
//! Limits: one time constant; see `thermal-drift` for drift without a temperature.

use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Tick, Violation};

use crate::linear::approach;
use crate::rules::WRONG_LENGTH;
use crate::{effects, phenomena};

/// The component `thermal-expansion`.
pub struct ThermalExpansion;

static DECLARATION: Declaration = Declaration {
    kind: "thermal-expansion",
    name: "expansion",
    summary: "Thermal growth of the structure with the temperature of the surroundings",
    equation: "y = x + expansion*(Ts - reference); time_constant*Ts' = temperature - Ts",
    reference: "ISO 230-3, Determination of thermal effects",
    stage: Stage::Environment,
    effect: Some(&effects::THERMAL_DRIFT),
    phenomena: &[&phenomena::THERMAL_GROWTH],
    inputs: &[Input::PATH, Input::TEMPERATURE],
    parameters: &[
        Quantity::new("expansion", "{position}/K", "Growth per kelvin").fitted(),
        Quantity::new("time_constant", "s", "Time constant of the structure")
            .start(1000.0)
            .min(0.0)
            .fitted(),
        Quantity::new("reference", "degC", "Temperature without growth").start(20.0).min(-273.15),
    ],
    ..Declaration::PATH
};

impl Component for ThermalExpansion {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 3, states: 1 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[expansion, time_constant, reference], [growth, part, zero]) =
            (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        let fraction = if time_constant > 0.0 { approach(time_constant, period) } else { 1.0 };
        (*growth, *part, *zero) = (expansion, fraction, reference);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[growth, _, zero], &[x, outside], [inside], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        *inside = outside;
        *y = x + growth * (*inside - zero);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[growth, part, zero], &[x, outside], [inside], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        *inside += part * (outside - *inside);
        *y = x + growth * (*inside - zero);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn the_structure_follows_a_step_of_the_temperature() {
        let p = [2e-6, 10.0, 293.15];
        let mut part = Instance::new(&ThermalExpansion, &[], &p, 0.5).unwrap();
        assert_eq!(part.rest(&[1e-6, 293.15]), 1e-6);
        for n in 1..100 {
            let exact = 2e-6 * 3.0 * (1.0 - (-0.5 * f64::from(n) / 10.0).exp());
            assert!((part.step(&[0.0, 296.15]) - exact).abs() < 1e-16);
        }
    }
}

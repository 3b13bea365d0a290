//! Thermal growth of the structure: steady, settling, and in proportion to a given temperature.
//!
//! ```text
//! y = x + rate·t + settling·(1 − exp(−t/time_constant)) + g
//! time_constant·g′ = expansion·temperature_change − g
//! ```
//!
//! * rate in position per second; settling in position; time_constant in s; expansion in position
//!   per K; temperature_change in K: may be changed during a run, and so serves as an input. t is
//!   the time since the start.
//! * State: g, and the part of the settling that is done. At rest g has reached
//!   expansion·temperature_change. Exact at any period.
//!
//! Limits: one time constant.

use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::linear::approach;
use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `thermal-drift`.
pub struct ThermalDrift;

static DECLARATION: Declaration = Declaration {
    kind: "thermal-drift",
    name: "drift",
    summary: "Thermal growth of the structure: steady, settling, and in proportion to a given temperature",
    equation: "y = x + rate*t + settling*(1 - exp(-t/time_constant)) + g; time_constant*g' = \
               expansion*temperature_change - g",
    reference: "ISO 230-3, Determination of thermal effects",
    stage: Stage::Environment,
    effect: Some(&effects::THERMAL_DRIFT),
    phenomena: &[&phenomena::THERMAL_GROWTH],
    parameters: &[
        Quantity::new("rate", "{position}/s", "Steady drift").start(0.0).fitted(),
        Quantity::new("settling", "{position}", "Drift that settles after the start")
            .start(0.0)
            .fitted(),
        Quantity::new("time_constant", "s", "Time constant").start(1000.0).min(0.0).fitted(),
        Quantity::new("expansion", "{position}/K", "Growth per kelvin").start(0.0).fitted(),
        Quantity::new(
            "temperature_change",
            "K",
            "Difference from the temperature at which the growth is zero",
        )
        .start(0.0)
        .tunable(),
    ],
    ..Declaration::PATH
};

impl Component for ThermalDrift {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 4, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[rate, settling, time_constant, expansion, change], [slope, end, fraction, growth]) =
            (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        require(time_constant > 0.0, "time_constant", time_constant, "must be above zero")?;
        (*slope, *end, *growth) = (rate * period, settling, expansion * change);
        *fraction = approach(time_constant, period);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[.., growth], &[x], [g, settled], [y]) = (coefficients, inputs, state, outputs)
        else {
            return;
        };
        (*g, *settled) = (growth, 0.0);
        *y = x + *g;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[slope, end, fraction, growth], &[x], [g, settled], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        *g += fraction * (growth - *g);
        *settled += fraction * (1.0 - *settled);
        *y = x + slope * tick.index as f64 + end * *settled + *g;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn drifts_settles_and_follows_the_temperature() {
        let mut p = [2e-3, 0.5, 10.0, 0.1, 0.0];
        let mut drift = Instance::new(&ThermalDrift, &[], &p, 0.1).unwrap();
        assert_eq!(drift.rest(&[1.0]), 1.0);
        for n in 1..=500 {
            let t = 0.1 * f64::from(n);
            let expected = 1.0 + 2e-3 * t - 0.5 * (-t / 10.0).exp_m1();
            assert!((drift.step(&[1.0]) - expected).abs() < 1e-12);
        }
        p[4] = 3.0;
        drift.set(&p).unwrap();
        for n in 501..=600 {
            let t = 0.1 * f64::from(n);
            let still = 1.0 + 2e-3 * t - 0.5 * (-t / 10.0).exp_m1();
            let expected = still - 0.3 * (-(t - 50.0) / 10.0).exp_m1();
            assert!((drift.step(&[1.0]) - expected).abs() < 1e-11);
        }
    }
}

//! The thermal port of the actuator: its temperature from outside, the heat of its losses to outside.
//!
//! ```text
//! y = x·[1 + coefficient·(T − reference)] + growth·(T − reference)
//! heat = (π/2)·loss·capacitance·|ṽ·v′|
//! ```
//!
//! * T is the axis' input `actuator_temperature`, in K: what a thermal network outside computes of `heat`,
//!   in W, which flows out of the actuator. v is the path's voltage where it is turned into a position,
//!   ṽ = v − (its mean over `averaging`). For a sine of amplitude V and frequency f the mean heat is the loss
//!   π·f·capacitance·V²·loss of a capacitor.
//! * coefficient in 1/K: of the gain; growth in position per K: of the length; loss: tan δ (0.01–0.1);
//!   averaging in s: longer than a period of the drive.
//! * State: the mean of v, the last v. At rest heat = 0.
//!
//! Limits: one temperature for the whole stack; the loss depends neither on amplitude nor on temperature.
//! `self-heating` has a thermal mass of its own, and no port.

use core::f64::consts::FRAC_PI_2;

use model::{Component, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation};

use super::self_heating::alternating;
use crate::linear::approach;
use crate::phenomena;
use crate::rules::{WRONG_LENGTH, require};

/// The component `thermal-port`.
pub struct ThermalPort;

static DECLARATION: Declaration = Declaration {
    kind: "thermal-port",
    name: "thermal",
    summary: "Thermal port of the actuator: temperature from outside, heat of its losses as output",
    equation: "y = x*(1 + coefficient*(T - reference)) + growth*(T - reference); heat = \
               pi/2*loss*capacitance*|(v - mean(v))*v'|",
    reference: "K. Uchino, S. Hirose, IEEE Trans. UFFC 48 (2001) 307-321",
    stage: Stage::Actuator,
    phenomena: &[&phenomena::THERMAL_NETWORK],
    inputs: &[
        Input::PATH,
        Input::axis_at_rest("actuator_temperature"),
        Input::axis_at_rest("voltage"),
    ],
    outputs: &[
        Output::PATH,
        Output::published("heat", "W", "Heat that flows out of the actuator", false),
    ],
    parameters: &[
        Quantity::new("growth", "{position}/K", "Change of the position per kelvin").fitted(),
        Quantity::new("loss", "1", "Loss tangent").min(0.0).fitted(),
        Quantity::new("capacitance", "C/{command}", "Capacitance").min(0.0),
        Quantity::new("coefficient", "1/K", "Relative change of the gain per kelvin")
            .start(0.0)
            .fitted(),
        Quantity::new("reference", "K", "Temperature without change").start(293.15).min(0.0),
        Quantity::new("averaging", "s", "Time over which the mean voltage is taken")
            .start(1.0)
            .min(0.0),
    ],
    ..Declaration::PATH
};

impl Component for ThermalPort {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 5, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (
            &[growth, loss, capacitance, coefficient, reference, averaging],
            [length, gain, zero, power, forget],
        ) = (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        require(averaging > 0.0, "averaging", averaging, "must be above zero")?;
        (*length, *gain, *zero) = (growth, coefficient, reference);
        *power = FRAC_PI_2 * loss * capacitance / period;
        *forget = approach(averaging, period);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[length, gain, zero, ..], &[x, temperature, v], [mean, last], [y, heat]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        (*mean, *last) = (v, v);
        let warmer = temperature - zero;
        *y = x * (1.0 + gain * warmer) + length * warmer;
        *heat = 0.0;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[length, gain, zero, power, forget], &[x, temperature, v], [mean, last], [y, heat]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let warmer = temperature - zero;
        *y = x * (1.0 + gain * warmer) + length * warmer;
        *heat = power * alternating(v, mean, last, forget);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn a_sine_gives_the_loss_of_its_capacitance_and_a_constant_none() {
        let (f, period) = (100.0, 1e-5);
        let p = [0.0, 0.02, 1e-6, 0.0, 293.15, 0.5];
        let mut port = Instance::new(&ThermalPort, &[], &p, period).unwrap();
        port.rest(&[0.0, 293.15, 60.0]);
        let (mut sum, mut count) = (0.0, 0);
        for n in 1..500_000 {
            let phase = core::f64::consts::TAU * f * period * f64::from(n);
            port.step(&[0.0, 293.15, 60.0 + 50.0 * phase.sin()]);
            if n >= 400_000 {
                (sum, count) = (sum + port.outputs[1], count + 1);
            }
        }
        let expected = core::f64::consts::PI * f * 1e-6 * 50.0 * 50.0 * 0.02;
        let mean = sum / f64::from(count);
        assert!((mean / expected - 1.0).abs() < 1e-3, "{mean} {expected}");

        port.rest(&[0.0, 293.15, 60.0]);
        port.step(&[0.0, 293.15, 60.0]);
        assert_eq!(port.outputs[1], 0.0);
    }

    #[test]
    fn warmth_grows_length_and_gain() {
        let p = [0.2e-6, 0.0, 0.0, 0.001, 293.15, 1.0];
        let mut port = Instance::new(&ThermalPort, &[], &p, 1e-3).unwrap();
        assert_eq!(port.rest(&[5e-6, 293.15, 0.0]), 5e-6);
        assert!((port.step(&[5e-6, 303.15, 0.0]) - (5e-6 * 1.01 + 2e-6)).abs() < 1e-18);
        assert!((port.rest(&[5e-6, 303.15, 0.0]) - (5e-6 * 1.01 + 2e-6)).abs() < 1e-18);
    }
}

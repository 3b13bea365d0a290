//! Warming of the actuator by its own losses.
//!
//! ```text
//! ṽ = v − (its mean over `averaging`)
//! P = (π/2)·loss·capacitance·|ṽ·v′|
//! time_constant·θ′ = resistance·P − θ
//! y = x·(1 + coefficient·θ) + growth·θ
//! ```
//!
//! * v = amplification·command, in V; ṽ its alternating part. For a sine of amplitude V and
//!   frequency f the mean of P is the loss π·f·capacitance·V²·loss of a capacitor.
//! * loss: tan δ (0.01–0.1); capacitance in F; resistance in K/W, time_constant in s: thermal;
//!   coefficient in 1/K: of the gain; growth in position per K: of the length; averaging in s:
//!   longer than a period of the drive.
//! * State: θ, the mean of v, the last v. At rest θ = 0.
//!
//! Limits: one temperature for the whole stack; the loss does not depend on amplitude.

use core::f64::consts::FRAC_PI_2;

use libm::fabs;
use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Tick, Violation};

use crate::linear::approach;
use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `self-heating`.
pub struct SelfHeating;

static DECLARATION: Declaration = Declaration {
    kind: "self-heating",
    name: "heating",
    summary: "Self-heating of the actuator by its losses, which changes gain and length",
    equation: "time_constant*T' = resistance*P - T; P = pi/2*loss*capacitance*|(v - mean(v))*v'|; \
               y = x*(1 + coefficient*T) + growth*T",
    reference: "K. Uchino, S. Hirose, IEEE Trans. UFFC 48 (2001) 307-321",
    stage: Stage::Actuator,
    effect: Some(&effects::SELF_HEATING),
    phenomena: &[&phenomena::SELF_HEATING],
    inputs: &[Input::PATH, Input::axis("command")],
    parameters: &[
        Quantity::new("loss", "1", "Loss tangent").min(0.0).fitted(),
        Quantity::new("capacitance", "F", "Capacitance").min(0.0),
        Quantity::new("resistance", "K/W", "Thermal resistance to the surroundings")
            .min(0.0)
            .fitted(),
        Quantity::new("time_constant", "s", "Thermal time constant").min(0.0).fitted(),
        Quantity::new("coefficient", "1/K", "Relative change of the gain per kelvin")
            .start(0.0)
            .fitted(),
        Quantity::new("growth", "{position}/K", "Change of the position per kelvin")
            .start(0.0)
            .fitted(),
        Quantity::new("amplification", "1", "Voltage per command").start(1.0),
        Quantity::new("averaging", "s", "Time over which the mean voltage is taken")
            .start(1.0)
            .min(0.0),
    ],
    ..Declaration::PATH
};

/// |ṽ·Δv| over a step that ends at v; the mean and the last v follow.
pub(super) fn alternating(v: f64, mean: &mut f64, last: &mut f64, forget: f64) -> f64 {
    let middle = 0.5 * (v + *last) - *mean;
    let product = middle * (v - *last);
    *mean += forget * (v - *mean);
    *last = v;
    fabs(product)
}

impl Component for SelfHeating {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 6, states: 3 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (
            &[
                loss,
                capacitance,
                resistance,
                time_constant,
                coefficient,
                growth,
                amplification,
                averaging,
            ],
            [heat, warming, gain, length, factor, forget],
        ) = (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        let rule = "must be above zero";
        require(time_constant > 0.0, "time_constant", time_constant, rule)?;
        require(averaging > 0.0, "averaging", averaging, rule)?;
        // |ṽ·Δv|/T is |ṽ·v′| in the mean over the step.
        *heat = FRAC_PI_2 * loss * capacitance * resistance / period;
        *warming = approach(time_constant, period);
        (*gain, *length, *factor) = (coefficient, growth, amplification);
        *forget = approach(averaging, period);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[.., factor, _], &[x, command], [theta, mean, last], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let v = factor * command;
        (*theta, *mean, *last) = (0.0, v, v);
        *y = x;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (
            &[heat, warming, gain, length, factor, forget],
            &[x, command],
            [theta, mean, last],
            [y],
        ) = (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let target = heat * alternating(factor * command, mean, last, forget);
        *theta += warming * (target - *theta);
        *y = x * (1.0 + gain * *theta) + length * *theta;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn a_sine_warms_by_the_loss_of_its_capacitance() {
        let (f, period) = (100.0, 1e-5);
        let p = [0.02, 1e-6, 50.0, 0.2, 0.0, 1.0, 1.0, 0.5];
        let mut model = Instance::new(&SelfHeating, &[], &p, period).unwrap();
        model.rest(&[0.0, 60.0]);
        let mut theta = 0.0;
        for n in 1..500_000 {
            let phase = core::f64::consts::TAU * f * period * f64::from(n);
            theta = model.step(&[0.0, 60.0 + 50.0 * phase.sin()]);
        }
        let expected = 50.0 * core::f64::consts::PI * f * 1e-6 * 50.0 * 50.0 * 0.02;
        assert!((theta / expected - 1.0).abs() < 0.02, "{theta} {expected}");
    }

    #[test]
    fn a_constant_command_does_not_warm() {
        let p = [0.02, 1e-6, 50.0, 0.2, 0.001, 1.0, 1.0, 0.5];
        let mut model = Instance::new(&SelfHeating, &[], &p, 1e-3).unwrap();
        assert_eq!(model.rest(&[3.0, 60.0]), 3.0);
        assert_eq!(model.step(&[3.0, 60.0]), 3.0);
    }
}

//! Amplifier with output resistance and current limit into the actuator's capacitance.
//!
//! `capacitance·v′ = min(max((gain·u − v)/resistance, −current), current)`
//!
//! * resistance in Ohm, capacitance in F, current in A; gain as of `amplifier-lag`. The bandwidth
//!   is 1/(2π·resistance·capacitance), the greatest slope current/capacitance.
//! * State: v. With the input held over a step, v runs straight while the difference is above
//!   resistance·current and then approaches the input exponentially: solved exactly at any period.
//!
//! Limits: constant capacitance; the same current in both directions; no rms limit.

use libm::{copysign, expm1, fabs, fmax, fmin};
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use crate::effects;
use crate::rules::{WRONG_LENGTH, require};

/// The component `amplifier-rc`.
pub struct AmplifierRc;

static DECLARATION: Declaration = Declaration {
    kind: "amplifier-rc",
    name: "amplifier",
    summary: "Output resistance and current limit into the capacitance",
    equation: "capacitance*v' = min(max((gain*u - v)/resistance, -current), current)",
    reference: "A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning \
                Systems, Springer 2014, ch. 14",
    stage: Stage::Amplifier,
    conversion: Conversion::None,
    effect: Some(&effects::AMPLIFIER_BANDWIDTH),
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: &[],
    parameters: &[
        Quantity::new("resistance", "Ohm", "Output resistance").min(0.0).fitted(),
        Quantity::new("capacitance", "F", "Capacitance of the actuator").min(0.0),
        Quantity::new("current", "A", "Greatest current").min(0.0).fitted(),
        Quantity::new("gain", "1", "Gain at low frequency").start(1.0).fitted(),
    ],
};

impl Component for AmplifierRc {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 5, states: 1 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[resistance, capacitance, current, gain], [tau, slope, knee, factor, length]) =
            (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        let rule = "must be above zero";
        require(resistance > 0.0, "resistance", resistance, rule)?;
        require(capacitance > 0.0, "capacitance", capacitance, rule)?;
        require(current > 0.0, "current", current, rule)?;
        (*tau, *slope) = (resistance * capacitance, current / capacitance);
        (*knee, *factor, *length) = (resistance * current, gain, period);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[_, _, _, gain, _], &[u], [v], [y]) = (coefficients, inputs, state, outputs) else {
            return;
        };
        *v = gain * u;
        *y = *v;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[tau, slope, knee, gain, period], &[u], [v], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let difference = gain * u - *v;
        // Time at the current limit, then the exponential for what is left of the step.
        let straight = fmin(fmax(fabs(difference) - knee, 0.0) / slope, period);
        *v += copysign(slope * straight, difference);
        *v -= (gain * u - *v) * expm1((straight - period) / tau);
        *y = *v;
    }
}

#[cfg(test)]
mod tests {
    use super::super::AmplifierLag;
    use super::*;
    use crate::testing::{Instance, Random};

    const P: [f64; 4] = [100.0, 1e-6, 0.05, 10.0];

    #[test]
    fn small_signals_see_the_lag() {
        let signal = Random::new(4).signal(-0.2, 0.2, 300);
        let rc = Instance::new(&AmplifierRc, &[], &P, 1e-5).unwrap().response(0.0, &signal);
        let bandwidth = 1.0 / (core::f64::consts::TAU * 100.0 * 1e-6);
        let lag = Instance::new(&AmplifierLag, &[], &[bandwidth, 10.0], 1e-5).unwrap();
        let mut lag = lag;
        for (a, b) in rc.iter().zip(lag.response(0.0, &signal)) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn a_large_step_runs_straight_and_then_settles_at_every_step_size() {
        // 100 V at 50 V/ms: straight to 95 V within 1.9 ms, then 5 V exponentially in 0.1 ms.
        let exact = |t: f64| {
            if t < 1.9e-3 { 5e4 * t } else { 100.0 - 5.0 * (-(t - 1.9e-3) / 1e-4).exp() }
        };
        for period in [1e-5, 3.3e-4, 2e-3] {
            let mut rc = Instance::new(&AmplifierRc, &[], &P, period).unwrap();
            rc.rest(&[0.0]);
            for n in 1..30 {
                let v = rc.step(&[10.0]);
                let expected = exact(f64::from(n) * period);
                assert!((v - expected).abs() < 1e-9, "period {period}, step {n}: {v} {expected}");
            }
        }
    }
}

//! Amplifier with output resistance and current limit into the actuator's capacitance.
//!
//! ```text
//! capacitance·v′ + transduction·x′ = i
//! i = min(max((gain·u − v)/resistance, −current), current)
//! ```
//!
//! * resistance in Ohm, capacitance in F, current in A; gain as of `amplifier-lag`. The bandwidth
//!   is 1/(2π·resistance·capacitance), the greatest slope current/capacitance. transduction in C per
//!   position = N per volt: the motional current of the moving actuator is drawn through the same
//!   resistance, so that the voltage dips where the stage moves, most at its resonance.
//! * x is the displacement behind the mechanics; x′ its mean over the step before (the displacement
//!   is computed later on the path).
//! * State: v and the last x. With input and motional current held over a step, v runs straight
//!   while the current is at its limit and otherwise approaches its end exponentially: solved
//!   exactly at any period.
//!
//! Limits: constant capacitance; the same current in both directions; no rms limit; the motional
//! current is one step late, which needs a step that is short against the mode, and a transduction
//! times the displacement per volt below the capacitance (as in any real actuator).
//!
//! Source: A. J. Fleming, K. K. Leang (below), ch. 14; M. Goldfarb, N. Celanovic, IEEE Control
//! Systems 17 (1997) 69–79 (the motional charge).

use libm::{copysign, exp, fabs, fmax, log};
use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Tick, Violation};

use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `amplifier-rc`.
pub struct AmplifierRc;

static DECLARATION: Declaration = Declaration {
    kind: "amplifier-rc",
    name: "amplifier",
    summary: "Output resistance and current limit into the capacitance of a moving actuator",
    equation: "capacitance*v' + transduction*x' = i; i = min(max((gain*u - v)/resistance, \
               -current), current)",
    reference: "A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning \
                Systems, Springer 2014, ch. 14",
    stage: Stage::Amplifier,
    effect: Some(&effects::AMPLIFIER_BANDWIDTH),
    phenomena: &[&phenomena::AMPLIFIER_LAG, &phenomena::CURRENT_LIMIT],
    inputs: &[Input::PATH, Input::axis("displacement")],
    parameters: &[
        Quantity::new("resistance", "Ohm", "Output resistance").min(0.0).fitted(),
        Quantity::new("capacitance", "F", "Capacitance of the actuator").min(0.0),
        Quantity::new("current", "A", "Greatest current").min(0.0).fitted(),
        Quantity::new("gain", "1", "Gain at low frequency").start(1.0).fitted(),
        Quantity::new("transduction", "C/{position}", "Charge per displacement; 0 for none")
            .start(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};

/// What is left of the way to the input, over a step with a steady motional current.
struct Load {
    /// resistance·capacitance.
    tau: f64,
    /// current/capacitance.
    slope: f64,
    /// resistance·current: from here on the current is at its limit.
    knee: f64,
    /// resistance·motional current: where the difference settles.
    target: f64,
}

impl Load {
    /// The difference `gain·u − v` after `time`: straight at the current limit, exponential below
    /// it. Three pieces at most: into the linear range, through it, out of it.
    fn after(&self, mut d: f64, mut time: f64) -> f64 {
        for _ in 0..3 {
            let side = copysign(1.0, d);
            let (far, target) = (side * d, side * self.target);
            if far > self.knee || (far == self.knee && target > self.knee) {
                // v runs at the limit's slope less the motional current's.
                let rate = self.slope * (1.0 - target / self.knee);
                let straight = if rate > 0.0 { (far - self.knee) / rate } else { f64::INFINITY };
                if straight >= time {
                    return d - side * rate * time;
                }
                (d, time) = (side * self.knee, time - straight);
            } else {
                let end = self.target - (self.target - d) * exp(-time / self.tau);
                if fabs(end) <= self.knee {
                    return end;
                }
                let edge = copysign(self.knee, end);
                let reached = self.tau * log((self.target - d) / (self.target - edge));
                (d, time) = (edge, fmax(time - reached, 0.0));
            }
        }
        d
    }
}

impl Component for AmplifierRc {
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
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (
            &[resistance, capacitance, current, gain, transduction],
            [tau, slope, knee, factor, motional],
        ) = (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        let rule = "must be above zero";
        require(resistance > 0.0, "resistance", resistance, rule)?;
        require(capacitance > 0.0, "capacitance", capacitance, rule)?;
        require(current > 0.0, "current", current, rule)?;
        (*tau, *slope) = (resistance * capacitance, current / capacitance);
        (*knee, *factor, *motional) = (resistance * current, gain, resistance * transduction);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[_, _, _, gain, _], &[u, x], [v, last], [y]) = (coefficients, inputs, state, outputs)
        else {
            return;
        };
        (*v, *last) = (gain * u, x);
        *y = *v;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[tau, slope, knee, gain, motional], &[u, x], [v, last], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let target = motional * (x - *last) / tick.period;
        let load = Load { tau, slope, knee, target };
        (*v, *last) = (gain * u - load.after(gain * u - *v, tick.period), x);
        *y = *v;
    }
}

#[cfg(test)]
mod tests {
    use super::super::AmplifierLag;
    use super::*;
    use crate::testing::{Instance, Random};

    const P: [f64; 5] = [100.0, 1e-6, 0.05, 10.0, 0.0];

    #[test]
    fn small_signals_see_the_lag() {
        let mut rc = Instance::new(&AmplifierRc, &[], &P, 1e-5).unwrap();
        let bandwidth = 1.0 / (core::f64::consts::TAU * 100.0 * 1e-6);
        let mut lag = Instance::new(&AmplifierLag, &[], &[bandwidth, 10.0], 1e-5).unwrap();
        rc.rest(&[0.0, 3.0]);
        lag.rest(&[0.0]);
        for u in Random::new(4).signal(-0.2, 0.2, 300) {
            assert!((rc.step(&[u, 3.0]) - lag.step(&[u])).abs() < 1e-12);
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
            rc.rest(&[0.0, 0.0]);
            for n in 1..30 {
                let v = rc.step(&[10.0, 0.0]);
                let expected = exact(f64::from(n) * period);
                assert!((v - expected).abs() < 1e-9, "period {period}, step {n}: {v} {expected}");
            }
        }
    }

    /// Against many small Euler steps, with motional currents up to three times the limit.
    #[test]
    fn the_motional_current_is_drawn_through_the_resistance() {
        let (resistance, c, limit, gain, n, period) = (100.0, 1e-6, 0.05, 10.0, 2.0, 3e-4);
        let p = [resistance, c, limit, gain, n];
        let mut rc = Instance::new(&AmplifierRc, &[], &p, period).unwrap();
        let mut random = Random::new(8);
        let (mut x, mut last, mut v) = (0.0, 0.0, rc.rest(&[0.0, 0.0]));
        for _ in 0..300 {
            let u = random.between(-2.0, 2.0);
            let motional = n * (x - last) / period;
            let fine = 20_000;
            for _ in 0..fine {
                let i = ((gain * u - v) / resistance).clamp(-limit, limit);
                v += period / f64::from(fine) * (i - motional) / c;
            }
            let found = rc.step(&[u, x]);
            assert!((found - v).abs() < 2e-3, "{found} {v}");
            v = found;
            last = x;
            x += random.between(-1.0, 1.0) * 3.0 * limit * period / n;
        }
    }

    #[test]
    fn a_steady_motion_costs_the_voltage_over_the_resistance() {
        // 2 N/V · 0.01 m/s = 20 mA through 100 Ohm.
        let p = [100.0, 1e-6, 0.05, 10.0, 2.0];
        let mut rc = Instance::new(&AmplifierRc, &[], &p, 1e-4).unwrap();
        rc.rest(&[5.0, 0.0]);
        let end = (1..200).map(|k| rc.step(&[5.0, 1e-6 * f64::from(k)])).last().unwrap();
        assert!((end - 48.0).abs() < 1e-9, "{end}");
    }
}

//! Disturbance observer in front of an inverse model.
//!
//! ```text
//! v = r − d,  d = Q·(measured − M·v)
//! M: delay, then a first-order lag;  Q: first-order low-pass of this bandwidth
//! ```
//!
//! * Inverse and machine behind it are together nearly M: what the measured position has beyond M·v is
//!   a disturbance in units of position (creep, drift, the inverse's error), and is taken off the
//!   reference before the inverse. Up to the bandwidth the machine so follows r as if it were M.
//! * lag and delay in s: time constant and dead time from v to the measured position (`longest` is
//!   structural); bandwidth in Hz, below about a tenth of 1/(2π·(lag + delay)) of what M leaves out.
//! * |d| ≤ limit. While `enable` is false d is held at 0. At rest d = 0 and M rests at v.
//!
//! Source: K. Ohnishi, M. Shibata, T. Murakami, IEEE/ASME Trans. Mechatronics 1 (1996) 56–67; for a
//! machine with its inverse: J. Yi, S. Chang, Y. Shen, IEEE/ASME Trans. Mechatronics 14 (2009) 456–464.

use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Structural, Tick, Violation};

use super::limiter::ENABLE;
use crate::hysteresis::play::between;
use crate::linear::{approach, lag_fraction};
use crate::rules::{WRONG_LENGTH, require};
use crate::timing::delay::{Ring, ring_size, steps_of};

/// The component `disturbance-observer`.
pub struct DisturbanceObserver;

static DECLARATION: Declaration = Declaration {
    kind: "disturbance-observer",
    name: "observer",
    summary: "Estimates the machine's deviation from its model and subtracts it from the reference, before the inverse",
    equation: "v = r - d; d = Q*(measured - M*v); M = exp(-s*delay)/(1 + s*lag); Q = 1/(1 + \
               s/(2*pi*bandwidth)); |d| <= limit",
    reference: "K. Ohnishi, M. Shibata, T. Murakami, IEEE/ASME Trans. Mechatronics 1 (1996) 56-67",
    stage: Stage::Control,
    inputs: &[Input::PATH, Input::axis("measured"), ENABLE],
    structure: &[Structural::real("longest", "s", "Longest delay that can be set", 0.1, 0.0, 10.0)],
    parameters: &[
        Quantity::new("bandwidth", "Hz", "Frequency up to which disturbances are compensated")
            .min(0.0)
            .tunable(),
        Quantity::new("lag", "s", "Time constant from the inverse to the measured position")
            .start(0.0)
            .min(0.0)
            .tunable(),
        Quantity::new("delay", "s", "Dead time from the inverse to the measured position")
            .start(0.0)
            .min(0.0)
            .at_most(0)
            .tunable(),
        Quantity::new("limit", "{position}", "Greatest disturbance that is compensated")
            .min(0.0)
            .tunable(),
    ],
    ..Declaration::PATH
};

impl Component for DisturbanceObserver {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("longest", &[0.1]),
            ("bandwidth", &[10.0]),
            ("lag", &[1e-3]),
            ("delay", &[2.35e-4]),
            ("limit", &[0.5]),
        ]
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        Sizes { coefficients: 5, states: 3 + ring_size(structure, period) }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (
            &[longest],
            &[bandwidth, lag, delay, limit],
            [low_pass, follow, integer, fraction, own_limit],
        ) = (structure, parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        let rule = "must be above 0; omit the observer to disable it";
        require(bandwidth > 0.0, "bandwidth", bandwidth, rule)?;
        *low_pass = lag_fraction(bandwidth, period);
        *follow = if lag > 0.0 { approach(lag, period) } else { 1.0 };
        // What is measured now has seen the command of the step before.
        (*integer, *fraction) = steps_of("delay", delay, longest, period)?;
        *own_limit = limit;
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[r, ..], [y]) = (inputs, outputs) else { return };
        let Some(([model, disturbance, last], ring)) = state.split_first_chunk_mut::<3>() else {
            return;
        };
        (*model, *disturbance, *last, *y) = (r, 0.0, r, r);
        Ring(ring).rest(r);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[low_pass, follow, integer, fraction, limit], &[r, measured, enable], [y]) =
            (coefficients, inputs, outputs)
        else {
            return;
        };
        let Some(([model, disturbance, last], ring)) = state.split_first_chunk_mut::<3>() else {
            return;
        };
        let delayed = Ring(ring).push(*last, integer, fraction);
        *model += follow * (delayed - *model);
        if enable == 0.0 {
            *disturbance = 0.0;
        } else {
            *disturbance += low_pass * (measured - *model - *disturbance);
            *disturbance = between(-limit, limit, *disturbance);
        }
        *y = r - *disturbance;
        *last = *y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    /// Errors of a machine that is the model but for an offset and a gain.
    fn error_of(gain: f64, offset: f64, steps: usize) -> f64 {
        let (period, lag) = (1e-3, 5e-3_f64);
        let p = [10.0, lag, 2e-3, 10.0];
        let mut observer = Instance::new(&DisturbanceObserver, &[0.1], &p, period).unwrap();
        observer.rest(&[0.0, 0.0, 1.0]);
        let follow = 1.0 - (-period / lag).exp();
        let (mut pipe, mut x) = ([0.0; 3], 0.0);
        for _ in 0..steps {
            // The command of a step acts from its end on.
            x += follow * (gain * pipe[2] - x);
            let v = observer.step(&[1.0, x + offset, 1.0]);
            pipe = [v, pipe[0], pipe[1]];
        }
        1.0 - x - offset
    }

    #[test]
    fn a_constant_disturbance_and_a_wrong_gain_leave_no_error() {
        assert!(error_of(1.0, 0.5, 20).abs() > 0.1);
        assert!(error_of(1.0, 0.5, 5000).abs() < 1e-9);
        assert!(error_of(0.8, -0.2, 5000).abs() < 1e-9);
    }

    #[test]
    fn where_the_machine_is_the_model_nothing_is_taken_off() {
        let p = [30.0, 0.0, 0.0, 10.0];
        let mut observer = Instance::new(&DisturbanceObserver, &[0.1], &p, 1e-3).unwrap();
        observer.rest(&[0.0, 0.0, 1.0]);
        let mut last = 0.0;
        for n in 0..500 {
            let r = (0.05 * f64::from(n)).sin();
            let v = observer.step(&[r, last, 1.0]);
            assert!((v - r).abs() < 1e-12);
            last = v;
        }
    }
}

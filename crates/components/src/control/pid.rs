//! PID control with feedforward, in the positional discrete form of the papers.
//!
//! ```text
//! e = reference − measured
//! I_k = I_{k−1} + ki·T·e_k
//! q_k = f·q_{k−1} + (1 − f)·(e_k − e_{k−1})/T,  f = exp(−T/derivative_filter)
//! u_k = kff·u_ff + kp·e_k + I_k + kd·q_k
//! c_k = min(max(u_k, output_min), output_max), moved by at most rate_max·T from c_{k−1}
//! ```
//!
//! * kp in command per position, ki in command per position and second, kd in command-seconds per
//!   position; T is the controller's period; kff is feedforward_gain. All gains and limits may be
//!   changed during a run; the integral I is kept in units of the command, so that a change of ki
//!   causes no jump. PI control is kd = 0.
//! * Papers that print their sums without T (kI·Σe, kD·Δe) have ki = kI/T and kd = kD·T.
//! * derivative_filter in s is the time constant of the derivative's first-order filter; 0, the
//!   default, gives the papers' form, q_k = (e_k − e_{k−1})/T.
//! * Anti-windup: with tracking_time = 0, the default, by conditional integration: where u_k is
//!   beyond a limit and ki·T·e_k drives it further out, I keeps its last value; where it leads back,
//!   it is integrated. With tracking_time > 0 by back-calculation: I grows by T/tracking_time·(c_k − u_k) too.
//! * `enable` = false holds the command at its last value (hold = 1, the default), or moves it to
//!   `safe` (hold = 0), within limits and rate. At the step at which it becomes true, I is set such that
//!   u_k is the last command, e_{k−1} to e_k and q to 0: no jump, no kick of the derivative.
//! * Outputs: the command; `feedforward` kff·u_ff and `feedback` u_k − kff·u_ff, both before the
//!   limits (feedback is 0 while disabled); `saturated`: the command is not u_k.
//! * At rest: the limited feedforward (disabled, with hold = 0: safe), I = 0, and e_{k−1} the present
//!   error.
//!
//! Source: K. J. Åström, T. Hägglund, Advanced PID Control, ISA 2006, ch. 3 and 13.

use libm::exp;
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use super::limiter::{ENABLE, HOLD, KFF, Limiter, OUTPUT_MAX, OUTPUT_MIN, RATE_MAX, SAFE, truth};
use crate::phenomena;
use crate::rules::WRONG_LENGTH;

/// The component `pid`.
pub struct Pid;

static DECLARATION: Declaration = Declaration {
    kind: "pid",
    name: "pid",
    summary: "PID with feedforward, output and rate limits, anti-windup and bumpless enabling",
    equation: "u = feedforward_gain*u_ff + kp*e + I + kd*q; I = I + ki*T*e; q = f*q + (1 - f)*(e - \
               e_last)/T; f = exp(-T/derivative_filter); e = reference - measured; command = \
               min(max(u, output_min), output_max), at most rate_max*T from the last",
    reference: "K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, ch. 3 and 13",
    stage: Stage::Control,
    conversion: Conversion::Control,
    phenomena: &[&phenomena::CONTROLLER_DIFFERENCE],
    inputs: &[
        Input { name: "feedforward", ..Input::PATH },
        Input::axis("reference"),
        Input::axis("measured"),
        ENABLE,
    ],
    outputs: &[
        Output { name: "command", published: None },
        Output::published("feedforward", "{command}", "Feedforward before the limits", false),
        Output::published("feedback", "{command}", "Feedback before the limits", false),
        Output::published("saturated", "1", "The command is at a limit", true),
    ],
    parameters: &[
        Quantity::new("kp", "{command}/{position}", "Proportional gain").tunable().fitted(),
        Quantity::new("ki", "{command}/{position}/s", "Integral gain")
            .start(0.0)
            .tunable()
            .fitted(),
        Quantity::new("kd", "{command}.s/{position}", "Derivative gain")
            .start(0.0)
            .tunable()
            .fitted(),
        Quantity::new(
            "derivative_filter",
            "s",
            "Time constant of the derivative's filter, 0 for none",
        )
        .start(0.0)
        .min(0.0)
        .tunable(),
        OUTPUT_MIN,
        OUTPUT_MAX,
        KFF,
        RATE_MAX,
        Quantity::new(
            "tracking_time",
            "s",
            "Time constant of anti-windup by back-calculation, 0 for conditional integration",
        )
        .start(0.0)
        .min(0.0)
        .tunable(),
        HOLD,
        SAFE,
    ],
    ..Declaration::PATH
};

impl Component for Pid {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("kp", &[2.0]),
            ("ki", &[300.0]),
            ("kd", &[1e-4]),
            ("derivative_filter", &[0.0]),
            ("output_min", &[0.0]),
            ("output_max", &[120.0]),
            ("feedforward_gain", &[0.9]),
            ("rate_max", &[5e5]),
            ("tracking_time", &[0.0]),
            ("hold", &[1.0]),
            ("safe", &[20.0]),
        ]
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: OWN + Limiter::COEFFICIENTS, states: 5 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[kp, ki, kd, filter, min, max, kff, rate, tracking, hold, safe] = parameters else {
            return Err(WRONG_LENGTH);
        };
        let (own, limits) = coefficients.split_at_mut_checked(OWN).ok_or(WRONG_LENGTH)?;
        Limiter::prepare([min, max, rate, hold, safe], period, limits)?;
        let own = <&mut [f64; OWN]>::try_from(own).map_err(|_| WRONG_LENGTH)?;
        let keep = if filter > 0.0 { exp(-period / filter) } else { 0.0 };
        let track = if tracking > 0.0 { period / tracking } else { 0.0 };
        *own = [kp, ki * period, kd / period, keep, kff, track];
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((own, limiter)), &[feedforward, reference, measured, enable]) =
            (parts(coefficients), inputs)
        else {
            return;
        };
        let (
            [integral, last_error, difference, last_command, was_on],
            [command, ff, feedback, saturated],
        ) = (state, outputs)
        else {
            return;
        };
        *ff = own[4] * feedforward;
        *command = limiter.rest(*ff, enable);
        *feedback = 0.0;
        *saturated = truth(enable != 0.0 && *command != *ff);
        (*integral, *last_error, *difference) = (0.0, reference - measured, 0.0);
        (*last_command, *was_on) = (*command, truth(enable != 0.0));
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((own, limiter)), &[feedforward, reference, measured, enable]) =
            (parts(coefficients), inputs)
        else {
            return;
        };
        let &[kp, ki_t, kd_per_t, keep, kff, track] = own;
        let (
            [integral, last_error, difference, last_command, was_on],
            [command, ff, feedback, saturated],
        ) = (state, outputs)
        else {
            return;
        };
        *ff = kff * feedforward;
        if enable == 0.0 {
            *command = limiter.open(*last_command);
            (*feedback, *saturated) = (0.0, 0.0);
            (*last_command, *was_on) = (*command, 0.0);
            return;
        }
        let error = reference - measured;
        if *was_on == 0.0 {
            (*last_error, *difference, *was_on) = (error, 0.0, 1.0);
            *integral = *last_command - *ff - (kp + ki_t) * error;
        }
        let increment = ki_t * error;
        *difference = keep * *difference + (1.0 - keep) * (error - *last_error);
        *feedback = kp * error + (*integral + increment) + kd_per_t * *difference;
        let free = *ff + *feedback;
        *command = limiter.limit(free, *last_command);
        if track > 0.0 {
            *integral += increment + track * (*command - free);
        } else {
            let winds_up =
                (free > *command && increment > 0.0) || (free < *command && increment < 0.0);
            if !winds_up {
                *integral += increment;
            }
        }
        *saturated = truth(*command != free);
        (*last_error, *last_command) = (error, *command);
    }
}

/// Coefficients beside those of the limiter.
const OWN: usize = 6;

#[inline]
fn parts(coefficients: &[f64]) -> Option<(&[f64; OWN], Limiter)> {
    let (own, limits) = coefficients.split_at_checked(OWN)?;
    Some((own.try_into().ok()?, Limiter::of(limits)?))
}

#[cfg(test)]
mod tests;

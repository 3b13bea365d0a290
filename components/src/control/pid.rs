//! PID control with feedforward, in the positional discrete form of the papers.
//!
//! ```text
//! e = reference − measured
//! I_k = I_{k−1} + ki·T·e_k
//! q_k = f·q_{k−1} + (1 − f)·(e_k − e_{k−1})/T,  f = exp(−T/derivative_filter)
//! u_k = u_ff + kp·e_k + I_k + kd·q_k
//! command = min(max(u_k, output_min), output_max)
//! ```
//!
//! * kp in command per position, ki in command per position and second, kd in command-seconds per
//!   position; T is the controller's period. All gains and limits may be changed during a run; the
//!   integral I is kept in units of the command, so that a change of ki causes no jump.
//! * derivative_filter in s is the time constant of the derivative's first-order filter; 0, the
//!   default, gives the papers' form, q_k = (e_k − e_{k−1})/T.
//! * Anti-windup by conditional integration: where u_k is beyond a limit and ki·T·e_k drives it
//!   further out, I keeps its last value; where it leads back, it is integrated.
//! * `enable` = false holds the command at its last value (within the limits). At the step at which
//!   it becomes true, I is set such that u_k is that value, e_{k−1} to e_k and q to 0: no jump, no
//!   kick of the derivative.
//! * Outputs: the command; `feedforward` u_ff and `feedback` u_k − u_ff, both before the limits
//!   (feedback is 0 while disabled); `saturated`: u_k is beyond a limit.
//! * At rest: the limited feedforward, I = 0, and e_{k−1} the present error.
//!
//! Source: K. J. Åström, T. Hägglund, Advanced PID Control, ISA 2006, ch. 3 and 13.

use libm::exp;
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use crate::hysteresis::play::between;
use crate::rules::{WRONG_LENGTH, require};

/// The component `pid`.
pub struct Pid;

static DECLARATION: Declaration = Declaration {
    kind: "pid",
    name: "pid",
    summary: "PID with feedforward, output limits, anti-windup and bumpless enabling",
    equation: "u = u_ff + kp*e + I + kd*q; I = I + ki*T*e; q = f*q + (1 - f)*(e - e_last)/T; \
               f = exp(-T/derivative_filter); e = reference - measured; \
               command = min(max(u, output_min), output_max)",
    reference: "K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, ch. 3 and 13",
    stage: Stage::Control,
    conversion: Conversion::Control,
    effect: None,
    inputs: &[
        Input { name: "feedforward", ..Input::PATH },
        Input::axis("reference"),
        Input::axis("measured"),
        Input::system("enable"),
    ],
    outputs: &[
        Output { name: "command", published: None },
        Output::published("feedforward", "{command}", "Feedforward before the limits", false),
        Output::published("feedback", "{command}", "Feedback before the limits", false),
        Output::published("saturated", "1", "The command is at a limit", true),
    ],
    structure: &[],
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
        Quantity::new("output_min", "{command}", "Least command").tunable(),
        Quantity::new("output_max", "{command}", "Greatest command").tunable(),
    ],
};

impl Component for Pid {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 6, states: 5 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[kp, ki, kd, filter, min, max], [p, i, d, keep, low, high]) =
            (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        require(
            min < max,
            "output_min",
            min,
            "must be below output_max; set both before the next step",
        )?;
        (*p, *i, *d, *low, *high) = (kp, ki * period, kd / period, min, max);
        *keep = if filter > 0.0 { exp(-period / filter) } else { 0.0 };
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[.., low, high], &[feedforward, reference, measured, enable]) =
            (coefficients, inputs)
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
        *command = between(low, high, feedforward);
        (*ff, *feedback) = (feedforward, 0.0);
        *saturated = truth(*command != feedforward);
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
        let (&[kp, ki_t, kd_per_t, keep, low, high], &[feedforward, reference, measured, enable]) =
            (coefficients, inputs)
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
        *ff = feedforward;
        if enable == 0.0 {
            *command = between(low, high, *last_command);
            (*feedback, *saturated) = (0.0, 0.0);
            (*last_command, *was_on) = (*command, 0.0);
            return;
        }
        let error = reference - measured;
        if *was_on == 0.0 {
            (*last_error, *difference, *was_on) = (error, 0.0, 1.0);
            *integral = *last_command - feedforward - (kp + ki_t) * error;
        }
        let increment = ki_t * error;
        *difference = keep * *difference + (1.0 - keep) * (error - *last_error);
        *feedback = kp * error + (*integral + increment) + kd_per_t * *difference;
        let free = feedforward + *feedback;
        let winds_up = (free > high && increment > 0.0) || (free < low && increment < 0.0);
        if !winds_up {
            *integral += increment;
        }
        *command = between(low, high, free);
        *saturated = truth(*command != free);
        (*last_error, *last_command) = (error, *command);
    }
}

/// A truth value as a number.
fn truth(value: bool) -> f64 {
    f64::from(u8::from(value))
}

#[cfg(test)]
mod tests;

//! PID control with feedforward, in the positional discrete form of the papers.
//!
//! ```text
//! e = reference − measured
//! I_k = I_{k−1} + ki·T·e_k
//! u_k = u_ff + kp·e_k + I_k + kd·(e_k − e_{k−1})/T
//! command = min(max(u_k, output_min), output_max)
//! ```
//!
//! * kp in command per position, ki in command per position and second, kd in command-seconds per
//!   position; T is the controller's period. All gains and limits may be changed during a run; the
//!   integral I is kept in units of the command, so that a change of ki causes no jump.
//! * Anti-windup by conditional integration: where u_k is beyond a limit and ki·T·e_k drives it
//!   further out, I keeps its last value; where it leads back, it is integrated.
//! * `enable` = false holds the command at its last value (within the limits). At the step at which
//!   it becomes true, I is set such that u_k is that value, and e_{k−1} to e_k: no jump, no kick
//!   of the derivative.
//! * Outputs: the command; `feedforward` u_ff and `feedback` u_k − u_ff, both before the limits
//!   (feedback is 0 while disabled); `saturated`: u_k is beyond a limit.
//! * At rest: the limited feedforward, I = 0, and e_{k−1} the present error.
//!
//! Source: K. J. Åström, T. Hägglund, Advanced PID Control, ISA 2006, ch. 3 and 13.

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
    equation: "u = u_ff + kp*e + I + kd*(e - e_last)/T; I = I + ki*T*e; e = reference - measured; \
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
        Quantity::new("output_min", "{command}", "Least command").tunable(),
        Quantity::new("output_max", "{command}", "Greatest command").tunable(),
    ],
};

impl Component for Pid {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 5, states: 4 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[kp, ki, kd, min, max], [p, i, d, low, high]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        require(
            min < max,
            "output_min",
            min,
            "must be below output_max; set both before the next step",
        )?;
        (*p, *i, *d, *low, *high) = (kp, ki * period, kd / period, min, max);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[.., low, high], &[feedforward, reference, measured, enable]) =
            (coefficients, inputs)
        else {
            return;
        };
        let ([integral, last_error, last_command, was_on], [command, ff, feedback, saturated]) =
            (state, outputs)
        else {
            return;
        };
        *command = between(low, high, feedforward);
        (*ff, *feedback) = (feedforward, 0.0);
        *saturated = truth(*command != feedforward);
        (*integral, *last_error) = (0.0, reference - measured);
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
        let (&[kp, ki_t, kd_per_t, low, high], &[feedforward, reference, measured, enable]) =
            (coefficients, inputs)
        else {
            return;
        };
        let ([integral, last_error, last_command, was_on], [command, ff, feedback, saturated]) =
            (state, outputs)
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
            (*last_error, *was_on) = (error, 1.0);
            *integral = *last_command - feedforward - (kp + ki_t) * error;
        }
        let increment = ki_t * error;
        *feedback = kp * error + (*integral + increment) + kd_per_t * (error - *last_error);
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

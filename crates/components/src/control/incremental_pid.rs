//! PID control in incremental (velocity) form, with feedforward.
//!
//! ```text
//! e = reference − measured
//! Δ_k = kp·(e_k − e_{k−1}) + ki·T·e_k + kd/T·(e_k − 2e_{k−1} + e_{k−2})
//! u_k = kff·u_ff + v_{k−1} + Δ_k
//! c_k = min(max(u_k, output_min), output_max), moved by at most rate_max·T from c_{k−1}
//! v_k = v_{k−1} + Δ_k, or c_k − kff·u_ff where c_k is not u_k
//! ```
//!
//! * Gains, limits, `enable`, `hold`, `safe` and outputs as for `pid`. Away from the limits both
//!   forms are the same; at a limit, increments that do not act are dropped, so nothing winds up.
//! * Papers that print it without T have ki = Ki/T and kd = Kd·T.
//! * At rest: the limited feedforward, v = 0, past errors the present one.
//!
//! Source: LS-SVM with stop operators tuned by particle swarm, eqs. (22), (23).

use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use super::limiter::{ENABLE, HOLD, KFF, Limiter, OUTPUT_MAX, OUTPUT_MIN, RATE_MAX, SAFE, truth};
use crate::phenomena;
use crate::rules::WRONG_LENGTH;

/// The component `incremental-pid`.
pub struct IncrementalPid;

static DECLARATION: Declaration = Declaration {
    kind: "incremental-pid",
    name: "pid",
    summary: "PID in incremental form with feedforward, output and rate limits, bumpless enabling",
    equation: "u = feedforward_gain*u_ff + v; v = v_last + kp*(e - e1) + ki*T*e + kd/T*(e - 2*e1 + \
               e2); e = reference - measured; command = min(max(u, output_min), output_max), at most \
               rate_max*T from the last",
    reference: "LS-SVM with stop operators tuned by particle swarm, eqs. (22), (23)",
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
        OUTPUT_MIN,
        OUTPUT_MAX,
        KFF,
        RATE_MAX,
        HOLD,
        SAFE,
    ],
    ..Declaration::PATH
};

/// Coefficients beside those of the limiter.
const OWN: usize = 4;

#[inline]
fn parts(coefficients: &[f64]) -> Option<(&[f64; OWN], Limiter)> {
    let (own, limits) = coefficients.split_at_checked(OWN)?;
    Some((own.try_into().ok()?, Limiter::of(limits)?))
}

impl Component for IncrementalPid {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("kp", &[2.0]),
            ("ki", &[300.0]),
            ("kd", &[1e-4]),
            ("output_min", &[0.0]),
            ("output_max", &[120.0]),
            ("feedforward_gain", &[0.9]),
            ("rate_max", &[5e5]),
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
        let &[kp, ki, kd, min, max, kff, rate, hold, safe] = parameters else {
            return Err(WRONG_LENGTH);
        };
        let (own, limits) = coefficients.split_at_mut_checked(OWN).ok_or(WRONG_LENGTH)?;
        Limiter::prepare([min, max, rate, hold, safe], period, limits)?;
        let own = <&mut [f64; OWN]>::try_from(own).map_err(|_| WRONG_LENGTH)?;
        *own = [kp, ki * period, kd / period, kff];
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((own, limiter)), &[feedforward, reference, measured, enable]) =
            (parts(coefficients), inputs)
        else {
            return;
        };
        let ([sum, newer, older, last, was_on], [command, ff, feedback, saturated]) =
            (state, outputs)
        else {
            return;
        };
        *ff = own[3] * feedforward;
        *command = limiter.rest(*ff, enable);
        *feedback = 0.0;
        *saturated = truth(enable != 0.0 && *command != *ff);
        (*sum, *newer, *older) = (0.0, reference - measured, reference - measured);
        (*last, *was_on) = (*command, truth(enable != 0.0));
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
        let &[kp, ki_t, kd_per_t, kff] = own;
        let ([sum, newer, older, last, was_on], [command, ff, feedback, saturated]) =
            (state, outputs)
        else {
            return;
        };
        *ff = kff * feedforward;
        if enable == 0.0 {
            *command = limiter.open(*last);
            (*feedback, *saturated) = (0.0, 0.0);
            (*last, *was_on) = (*command, 0.0);
            return;
        }
        let error = reference - measured;
        if *was_on == 0.0 {
            (*newer, *older, *was_on) = (error, error, 1.0);
            *sum = *last - *ff - ki_t * error;
        }
        let increment = kp * (error - *newer)
            + ki_t * error
            + kd_per_t * ((error - *newer) - (*newer - *older));
        *feedback = *sum + increment;
        let free = *ff + *feedback;
        *command = limiter.limit(free, *last);
        let is_limited = *command != free;
        *saturated = truth(is_limited);
        *sum = if is_limited { *command - *ff } else { *feedback };
        (*older, *newer, *last) = (*newer, error, *command);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Pid;
    use crate::testing::{Instance, Random};

    const T: f64 = 2e-3;
    const WIDE: [f64; 2] = [-1e9, 1e9];

    fn incremental(gains: [f64; 3], limits: [f64; 2], rate: f64) -> Instance {
        let p = [&gains[..], &limits, &[1.0, rate, 1.0, 0.0]].concat();
        Instance::new(&IncrementalPid, &[], &p, T).unwrap()
    }

    #[test]
    fn away_from_the_limits_it_is_the_positional_form() {
        let gains = [35.0, 715.0, 0.43];
        let mut one = incremental(gains, WIDE, 0.0);
        let p = [&gains[..], &[0.0], &WIDE, &[1.0, 0.0, 0.0, 1.0, 0.0]].concat();
        let mut other = Instance::new(&Pid, &[], &p, T).unwrap();
        let mut random = Random::new(4);
        let rest = [3.0, 0.2, 0.2, 1.0];
        assert_eq!(one.rest(&rest), other.rest(&rest));
        for n in 0..500 {
            let inputs = [random.between(-9.0, 9.0), random.between(-1.0, 1.0), 0.1, 1.0];
            let (a, b) = (one.step(&inputs), other.step(&inputs));
            assert!((a - b).abs() < 1e-8 * b.abs().max(1.0), "step {n}: {a} {b}");
        }
    }

    #[test]
    fn it_leaves_a_limit_as_soon_as_the_error_turns() {
        let mut pid = incremental([1.0, 1000.0, 0.0], [0.0, 10.0], 0.0);
        pid.rest(&[5.0, 0.0, 0.0, 1.0]);
        for _ in 0..1000 {
            pid.step(&[5.0, 1.0, 0.0, 1.0]);
        }
        assert_eq!((pid.outputs[0], pid.outputs[3]), (10.0, 1.0));
        assert!(pid.step(&[5.0, -0.1, 0.0, 1.0]) < 10.0);
    }

    #[test]
    fn the_rate_is_limited_and_enabling_is_bumpless() {
        let mut pid = incremental([100.0, 10.0, 0.0], WIDE, 500.0);
        pid.rest(&[0.0; 4]);
        let mut last = pid.step(&[0.0, 0.0, 0.0, 0.0]);
        for n in 0..50 {
            let on = f64::from(u8::from(n % 20 > 9));
            let now = pid.step(&[f64::from(n), 1.0, 0.0, on]);
            assert!((now - last).abs() <= 500.0 * T * (1.0 + 1e-12), "{n}: {last} to {now}");
            if n % 20 == 10 {
                assert!((now - last).abs() < 1e-9, "a bump of {} at {n}", now - last);
            }
            last = now;
        }
        assert!(last > 0.0);
    }
}

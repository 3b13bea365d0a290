//! Rate-dependent Prandtl–Ishlinskii hysteresis whose memory lags behind the command.
//!
//! ```text
//! y = offset + gain·u + Σ w_i P_i,   P_i ← max(v − r_i, min(v + r_i, P_i))
//! v′ = 2π·bandwidth·(u − v)
//! ```
//!
//! * r, w as in `prandtl-ishlinskii`; gain in position per command: the part that follows at once;
//!   bandwidth in Hz: domains turn with the time constant 1/(2π·bandwidth).
//! * Slowly it is the symmetric model; from the bandwidth on loops first widen, then the memory's part
//!   of the stroke falls.
//! * State: one number per play, and v, exactly for a command that is held over the step.
//!
//! Limits: one time constant for all thresholds.
//!
//! Source: K. Kuhnen, European Journal of Control 9 (2003) 407–418 (plays); the lag is that of a first-order
//! relaxation in front of them.

use model::{
    Component, Conversion, Declaration, Free, Missing, Quantity, Range, Role, Sizes, Stage, Tick,
    Violation,
};

use super::play::Plays;
use super::prandtl_ishlinskii::{OFFSET, R, STRUCTURE, W, check_plays};
use crate::linear::lag_fraction;
use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `lagging-play`.
pub struct LaggingPlay;

static DECLARATION: Declaration = Declaration {
    kind: "lagging-play",
    name: "hysteresis",
    summary: "Hysteresis whose memory lags behind the command",
    equation: "y = offset + gain*u + sum(w[i]*P[i]); P[i] = max(v - r[i], min(v + r[i], P[i])); v' \
               = 2*pi*bandwidth*(u - v)",
    reference: "K. Kuhnen, European Journal of Control 9 (2003) 407-418",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::RATE_DEPENDENCE),
    phenomena: &[&phenomena::RATE_DEPENDENT_HYSTERESIS],
    structure: STRUCTURE,
    parameters: &[
        R,
        W,
        OFFSET,
        Quantity::new("gain", "{position}/{command}", "Linear part without hysteresis")
            .role(Role::Slope)
            .start(0.0)
            .min(0.0)
            .fitted(),
        Quantity::new("bandwidth", "Hz", "Bandwidth of the low-pass before the plays")
            .min(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};

static MISSING: Missing = Missing {
    name: "plays that lag",
    free: &[Free { quantity: "bandwidth", name: "bandwidth", range: Range::Bandwidth }],
};

/// `r | w | offset | gain | bandwidth`; coefficients have the part of a step in its place.
fn split(values: &[f64]) -> Option<(Plays<'_>, [f64; 3])> {
    let (arrays, &scalars) = values.split_last_chunk::<3>()?;
    let (r, w) = arrays.split_at(arrays.len() / 2);
    Some((Plays { r, w }, scalars))
}

impl Component for LaggingPlay {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("r", &[4.0, 12.0]),
            ("w", &[0.02, 0.01]),
            ("offset", &[0.3]),
            ("gain", &[0.05]),
            ("bandwidth", &[150.0]),
        ]
    }

    fn missing(&self) -> Option<&'static Missing> {
        Some(&MISSING)
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let plays = DECLARATION.length(0, structure);
        Sizes { coefficients: DECLARATION.parameter_count(structure), states: plays + 1 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (plays, [_, _, bandwidth]) = split(parameters).ok_or(WRONG_LENGTH)?;
        check_plays(plays)?;
        require(bandwidth > 0.0, "bandwidth", bandwidth, "must be above zero")?;
        kept(parameters, coefficients)?;
        if let Some(last) = coefficients.last_mut() {
            *last = lag_fraction(bandwidth, period);
        }
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((plays, [offset, gain, _])), &[u], Some((v, own)), [y]) =
            (split(coefficients), inputs, state.split_last_mut(), outputs)
        else {
            return;
        };
        *v = u;
        *y = offset + gain * u + plays.rest(u, own);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((plays, [offset, gain, part])), &[u], Some((v, own)), [y]) =
            (split(coefficients), inputs, state.split_last_mut(), outputs)
        else {
            return;
        };
        *v += part * (u - *v);
        *y = offset + gain * u + plays.step(*v, own);
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;
    use std::vec::Vec;

    use super::*;
    use crate::testing::{Instance, Random};

    const PERIOD: f64 = 1e-4;

    fn new(bandwidth: f64) -> Instance {
        let all = [0.0, 10.0, 30.0, 0.02, 0.01, 0.005, 0.5, 0.03, bandwidth];
        Instance::new(&LaggingPlay, &[3.0], &all, PERIOD).unwrap()
    }

    #[test]
    fn with_a_bandwidth_far_beyond_the_step_it_is_the_symmetric_model() {
        let plain = [0.0, 10.0, 30.0, 0.05, 0.01, 0.005, 0.5];
        let plain = Instance::new(&super::super::PrandtlIshlinskii, &[3.0], &plain, PERIOD);
        let signal = Random::new(3).signal(-100.0, 120.0, 500);
        let (own, plain) = (new(1e6).response(5.0, &signal), plain.unwrap().response(5.0, &signal));
        assert!(own.iter().zip(plain).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    /// After a step the part that follows at once is there; the rest comes with the time constant.
    #[test]
    fn a_step_ends_where_the_symmetric_model_is_at_once() {
        let mut model = new(20.0);
        model.rest(&[0.0]);
        let y: Vec<f64> = (0..2000).map(|_| model.step(&[100.0])).collect();
        let end = 0.5 + 3.0 + 0.02 * 100.0 + 0.01 * 90.0 + 0.005 * 70.0;
        assert!((y[1999] - end).abs() < 1e-9, "{}", y[1999]);
        for n in [0, 50, 200] {
            let v = 100.0 * (1.0 - (-TAU * 20.0 * PERIOD * f64::from(n + 1)).exp());
            let memory = 0.02 * v + 0.01 * (v - 10.0_f64).max(0.0) + 0.005 * (v - 30.0).max(0.0);
            let at = y[n as usize];
            assert!((at - (3.5 + memory)).abs() < 1e-9, "row {n}: {at}");
        }
    }
}

//! Repetitive control: learns the command that a periodic reference needs, from one period to the next.
//!
//! ```text
//! w_k = keep·Σ_j h_j·w_{k−N+j} + gain·e_{k−N+lead},  |w| ≤ limit,  e = reference − measured
//! command = path + w
//! ```
//!
//! * N samples are one `cycle` of the reference. gain in command per position; lead in s is the delay
//!   from the command to the measured position that the learning makes up for.
//! * h is a window (Hann, 2·half + 1 taps, sum 1) without phase: it ends learning above about
//!   1/(2·(half + 1)·T), where the machine's phase is not known. keep ≤ 1 forgets slowly.
//! * It converges where |H·keep − gain·G·z^lead| < 1 for the machine's response G from command to
//!   position, with |H| the window's response.
//! * While `enable` is false w is held at 0 and nothing is learned. The first period has w = 0.
//!
//! Limits: disturbances that do not repeat are answered a period late; noise of e adds
//! gain/√(1 − (keep·|H|)²) of itself to the command, so gain is kept small.
//!
//! Source: L. Cuiyan, Z. Dongchun, Z. Xianyi, A survey of repetitive control, IEEE/RSJ IROS 2004;
//! D. A. Bristow, M. Tharayil, A. G. Alleyne, A survey of iterative learning control, IEEE Control
//! Systems 26 (2006) 96–114.

use core::f64::consts::PI;

use libm::{cos, fabs, round};
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Structural, Tick,
    Violation,
};

use super::limiter::ENABLE;
use crate::hysteresis::play::between;
use crate::rules::{WRONG_LENGTH, require};

/// The component `repetitive`.
pub struct Repetitive;

/// Most samples of a cycle.
const MOST: usize = 1 << 20;

static DECLARATION: Declaration = Declaration {
    kind: "repetitive",
    name: "repetitive",
    summary: "Repetitive (iterative learning) control of a periodic reference",
    equation: "w(k) = keep*sum(h[j]*w(k-N+j)) + gain*e(k-N+lead); e = reference - measured; command = \
               path + w",
    reference: "D. A. Bristow, M. Tharayil, A. G. Alleyne, IEEE Control Systems 26 (2006) 96-114",
    stage: Stage::Control,
    conversion: Conversion::Control,
    inputs: &[Input::PATH, Input::axis("reference"), Input::axis("measured"), ENABLE],
    outputs: &[Output { name: "command", published: None }],
    structure: &[
        Structural {
            name: "cycle",
            unit: "s",
            description: "Period of the reference, a whole number of sample times",
            start: None,
            min: 1e-9,
            max: 1e6,
            integer: false,
        },
        Structural {
            name: "half",
            unit: "1",
            description: "Half length of the window, in samples",
            start: Some(10.0),
            min: 0.0,
            max: 1000.0,
            integer: true,
        },
    ],
    parameters: &[
        Quantity::new("gain", "{command}/{position}", "Learning gain").tunable(),
        Quantity::new("lead", "s", "Delay from the command to the measured position")
            .start(0.0)
            .min(0.0)
            .tunable(),
        Quantity::new("keep", "1", "Share of the learned command that is kept for the next cycle")
            .start(1.0)
            .min(0.0)
            .max(1.0)
            .tunable(),
        Quantity::new("limit", "{command}", "Greatest command that is learned").min(0.0).tunable(),
    ],
    ..Declaration::PATH
};

/// Samples of a cycle and half length of the window.
fn lengths(structure: &[f64], period: f64) -> (usize, usize) {
    let &[cycle, half] = structure else { return (0, 0) };
    let samples = round(cycle / period);
    (if samples >= 1.0 { (samples as usize).min(MOST) } else { 0 }, half as usize)
}

impl Component for Repetitive {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("cycle", &[0.01]),
            ("half", &[5.0]),
            ("gain", &[0.5]),
            ("lead", &[3e-4]),
            ("keep", &[0.99]),
            ("limit", &[20.0]),
        ]
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        let (samples, half) = lengths(structure, period);
        // Place, errors and learned commands of a cycle, and of the window behind it.
        Sizes { coefficients: 3 + half + 1, states: 1 + 2 * (samples + half + 1) }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (samples, half) = lengths(structure, period);
        let (&[gain, lead, keep, limit], Some(([own_gain, own_lead, own_limit], window))) =
            (parameters, coefficients.split_first_chunk_mut::<3>())
        else {
            return Err(WRONG_LENGTH);
        };
        let cycle = structure.first().copied().unwrap_or(0.0);
        let off = fabs(cycle / period - samples as f64);
        let rule = "must be a whole number of sample times, more than the window is long, and at most a \
                    million; choose the step so";
        require(samples > 2 * half + 1 && off < 1e-4, "cycle", cycle, rule)?;
        let ahead = round(lead / period);
        let rule = "must be shorter than half the cycle";
        require(ahead < 0.5 * samples as f64, "lead", lead, rule)?;
        (*own_gain, *own_lead, *own_limit) = (gain, ahead, limit);
        let hann = |j: usize| 0.5 * (1.0 + cos(PI * j as f64 / (half + 1) as f64));
        let sum: f64 = hann(0) + 2.0 * (1..=half).map(hann).sum::<f64>();
        for (j, tap) in window.iter_mut().enumerate() {
            *tap = keep * hann(j) / sum;
        }
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[path, ..], [command]) = (inputs, outputs) else { return };
        state.fill(0.0);
        *command = path;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((&[gain, lead, limit], window)), &[path, reference, measured, enable], [command]) =
            (coefficients.split_first_chunk::<3>(), inputs, outputs)
        else {
            return;
        };
        let Some((place, rings)) = state.split_first_mut() else { return };
        let room = rings.len() / 2;
        let (errors, learned) = rings.split_at_mut(room);
        // The rings hold the window's half length more than a cycle.
        let samples = room.saturating_sub(window.len());
        let now = *place as usize;
        let back = |steps: usize| {
            if now >= steps { now - steps } else { (now + room).saturating_sub(steps) }
        };
        let past = samples.saturating_sub(lead as usize);
        let mut w = 0.0;
        let mut error = 0.0;
        if enable != 0.0 {
            error = reference - measured;
            let at = |ring: &[f64], steps: usize| ring.get(back(steps)).copied().unwrap_or(0.0);
            for (j, tap) in window.iter().enumerate() {
                let later = at(learned, samples.saturating_sub(j));
                let earlier = if j > 0 { at(learned, samples.saturating_add(j)) } else { 0.0 };
                w += tap * (later + earlier);
            }
            w = between(-limit, limit, w + gain * at(errors, past));
        }
        if let (Some(own_error), Some(own)) = (errors.get_mut(now), learned.get_mut(now)) {
            (*own_error, *own) = (error, w);
        }
        *place = if now + 1 < room { now + 1 } else { 0 } as f64;
        *command = path + w;
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;
    use std::vec::Vec;

    use super::*;
    use crate::testing::Instance;

    /// Greatest error in each cycle of a machine `y(k) = u(k − 3)` with a periodic disturbance.
    fn errors(half: f64, parameters: &[f64; 4], cycles: usize) -> Vec<f64> {
        const N: usize = 200;
        let period = 1e-3;
        let mut law =
            Instance::new(&Repetitive, &[N as f64 * period, half], parameters, period).unwrap();
        law.rest(&[0.0, 0.0, 0.0, 1.0]);
        let mut pipe = [0.0; 3];
        let mut all = Vec::new();
        for cycle in 0..cycles {
            let mut worst = 0.0_f64;
            for k in 0..N {
                let phase = TAU * k as f64 / N as f64;
                let reference = phase.sin();
                // Its third harmonic stands for a hysteresis.
                let measured = pipe[2] + 0.2 * (3.0 * phase).sin();
                let command = law.step(&[reference, reference, measured, 1.0]);
                pipe = [command, pipe[0], pipe[1]];
                if cycle > 0 {
                    worst = worst.max((reference - measured).abs());
                }
            }
            all.push(worst);
        }
        all
    }

    #[test]
    fn what_repeats_is_learned_away() {
        // Delay in the loop: the command of step k is measured at step k + 3.
        let found = errors(0.0, &[0.5, 3e-3, 1.0, 10.0], 40);
        assert!(found[1] > 0.1, "{found:?}");
        assert!(found[39] < 1e-10, "{found:?}");
        // Half of the error is learned in each cycle.
        assert!((found[9] / found[8] - 0.5).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn the_window_leaves_what_lies_above_it() {
        // A harmonic of response H keeps (1 − H)/(1 − H + gain) of its error.
        let found = errors(5.0, &[0.5, 3e-3, 1.0, 10.0], 60);
        let half = 5;
        let hann = |j: usize| 0.5 * (1.0 + (PI * j as f64 / (half + 1) as f64).cos());
        let sum = hann(0) + 2.0 * (1..=half).map(hann).sum::<f64>();
        let at = |angle: f64| {
            let taps = (1..=half).map(|j| 2.0 * hann(j) * (angle * j as f64).cos()).sum::<f64>();
            let open = 1.0 - (hann(0) + taps) / sum;
            open / (open + 0.5)
        };
        // The delay leaves 2·sin(1.5·2π/200) of the first harmonic, the disturbance 0.2 of the third.
        let step = TAU / 200.0;
        let bound = 2.0 * (1.5 * step).sin() * at(step) + 0.2 * at(3.0 * step);
        assert!(found[59] < bound && found[59] > 0.7 * bound, "{bound}: {found:?}");
    }

    #[test]
    fn the_limit_holds_and_a_cycle_has_an_integer_number_of_samples() {
        let found = errors(0.0, &[0.5, 3e-3, 1.0, 1e-3], 40);
        assert!(found[39] > 0.9 * found[1]);
        let refused = Instance::new(&Repetitive, &[0.2003, 3.0], &[1.0, 0.0, 1.0, 1.0], 1e-3).err();
        assert_eq!(refused.map(|v| v.quantity), Some("cycle"));
    }
}

//! The controller on the plant that it was made from.

use core::f64::consts::TAU;

use data::{Blueprint, CheckedBlueprint};
use serde::Serialize;

use crate::closed_loop::simulate_loop;
use crate::feedforward::is_feedforward;

/// Part of the reach that a wave swings over.
const SWING: f64 = 0.6;
/// Highest frequency of the slow wave in Hz, and fewest samples of a wave.
const SLOW: (f64, f64) = (1.0, 200.0);
/// The fast wave: part of the bandwidth, and fewest samples.
const FAST: (f64, f64) = (0.25, 40.0);
/// Waves in all, and those that are judged.
const WAVES: (f64, f64) = (3.0, 2.0);
/// Most samples of a run.
const ROWS: f64 = 120_000.0;
/// Phase from one axis to the next.
const PHASE: f64 = 1.3;

/// What a controller does on its own plant along a sine over the middle of the reach; errors are root mean
/// squares in parts of the reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Of the wave, in Hz.
    pub frequency: f64,
    /// Part of the reach that the wave swings over.
    pub swing: f64,
    /// The feedforward alone; `None` where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feedforward: Option<f64>,
    /// The closed loop with its feedforward.
    pub closed_loop: f64,
    /// The feedback alone.
    pub feedback: f64,
}

/// Frequencies of the slow and the fast wave.
pub(crate) fn frequencies(period: f64, bandwidth: f64) -> Vec<f64> {
    let least = WAVES.0 / (ROWS * period);
    let slow = SLOW.0.min(1.0 / (SLOW.1 * period)).max(least);
    let fast = (FAST.0 * bandwidth).min(1.0 / (FAST.1 * period));
    if fast > 2.0 * slow { vec![slow, fast] } else { vec![slow] }
}

/// The references of all axes, and the row from which on they are judged.
pub(crate) fn waves(reaches: &[(f64, f64)], frequency: f64, period: f64) -> (Vec<Vec<f64>>, usize) {
    let rows = (WAVES.0 / (frequency * period)).ceil() as usize;
    let wave = |(axis, (low, high)): (usize, &(f64, f64))| {
        let (middle, half) = (0.5 * (low + high), 0.5 * SWING * (high - low));
        let at = |k: usize| {
            let turn = TAU * frequency * k as f64 * period;
            // It begins softly: a jump of the reference is no part of a wave.
            let on = if turn < TAU { 0.5 - 0.5 * (0.5 * turn).cos() } else { 1.0 };
            middle + half * on * (turn + PHASE * axis as f64).sin()
        };
        (0..rows).map(at).collect()
    };
    let from = ((WAVES.0 - WAVES.1) / WAVES.0 * rows as f64) as usize;
    (reaches.iter().enumerate().map(wave).collect(), from)
}

/// The swing of the waves.
pub(crate) const fn swing() -> f64 {
    SWING
}

/// A reference, so many periods later.
pub(crate) fn delayed(reference: &[f64], periods: usize) -> impl Iterator<Item = f64> {
    reference.iter().take(1).cycle().take(periods).chain(reference).copied()
}

/// Reference, `late` periods before, less position of each axis from a row on; infinite where the run leaves the model's range.
pub(crate) fn errors(
    plant: &CheckedBlueprint,
    controller: &CheckedBlueprint,
    references: &[Vec<f64>],
    from: usize,
    period: f64,
    late: &[usize],
) -> Vec<Vec<f64>> {
    match simulate_loop(plant, controller, references, period) {
        Ok(run) => {
            let each = references.iter().zip(&run.position).zip(late);
            each.map(|((r, p), late)| {
                delayed(r, *late).zip(p).skip(from).map(|(r, p)| r - p).collect()
            })
            .collect()
        }
        Err(_) => vec![vec![f64::INFINITY]; references.len()],
    }
}

/// Root mean square.
pub(crate) fn rms(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().map(|x| x * x).sum();
    (sum / values.len().max(1) as f64).sqrt()
}

/// The controller without feedback on the axes for which this holds.
pub(crate) fn without_feedback(controller: &Blueprint) -> Blueprint {
    let mut alone = controller.clone();
    for axis in &mut alone.axes {
        for component in axis.components.iter_mut().filter(|c| !is_feedforward(c)) {
            for gain in ["kp", "ki", "kd", "gain"] {
                if component.get(gain).is_some() {
                    component.set(gain, 0.0);
                }
            }
        }
    }
    alone
}

/// The controller without feedforward.
pub(crate) fn without_feedforward(controller: &Blueprint) -> Blueprint {
    let mut alone = controller.clone();
    for axis in &mut alone.axes {
        // What stands behind the law shapes the feedback.
        let law = axis.components.iter().position(|component| !is_feedforward(component));
        axis.components.drain(..law.unwrap_or(axis.components.len()));
        for component in &mut axis.components {
            if component.get("setpoint_weight").is_some() {
                component.set("setpoint_weight", 0.0);
            }
        }
    }
    alone.tables.clear();
    alone
}

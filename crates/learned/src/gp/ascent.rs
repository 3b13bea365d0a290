//! L-BFGS on the logarithms of the hyperparameters.
//!
//! Reference: J. Nocedal, S. Wright, Numerical Optimization, 2nd ed., algorithms 7.4 and 3.1.

use std::collections::VecDeque;

use super::{Hyperparameters, Likelihood, likelihood};
use crate::Error;
use crate::lssvm::Samples;

/// Pairs that are remembered.
const MEMORY: usize = 8;
/// Greatest change of a logarithm in one step.
const LONGEST: f64 = 2.0;
/// Least ln(σ_n/σ_f).
const LEAST_NOISE: f64 = -10.0;
/// Range of the logarithms about the start.
const REACH: f64 = 14.0;

fn logs(p: &Hyperparameters) -> Vec<f64> {
    [p.signal.ln(), p.noise.ln()].into_iter().chain(p.lengths.iter().map(|l| l.ln())).collect()
}

fn parameters(logs: &[f64]) -> Hyperparameters {
    let lengths = logs[2..].iter().map(|l| l.exp()).collect();
    Hyperparameters { signal: logs[0].exp(), noise: logs[1].exp(), lengths }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The best of at most `evaluations` evaluations.
pub(super) fn ascend(
    samples: &Samples,
    start: &Hyperparameters,
    evaluations: usize,
) -> Result<Likelihood, Error> {
    let origin = logs(start);
    let (mut x, mut best) = (origin.clone(), likelihood(samples, start)?);
    let mut pairs: VecDeque<(Vec<f64>, Vec<f64>)> = VecDeque::new();
    let mut count = 1;
    while count < evaluations {
        let mut direction = two_loops(&pairs, &best.gradient);
        let mut slope = dot(&direction, &best.gradient);
        if slope <= 0.0 {
            pairs.clear();
            direction.clone_from(&best.gradient);
            slope = dot(&direction, &best.gradient);
        }
        let longest = direction.iter().fold(0.0_f64, |a, d| a.max(d.abs()));
        if slope < 1e-10 * best.value.abs() || longest == 0.0 {
            break;
        }
        let first = if pairs.is_empty() { 0.5 } else { LONGEST };
        let mut step = (first / longest).min(1.0);
        let mut moved = None;
        while count < evaluations && step * longest > 1e-7 {
            let probe: Vec<f64> = x
                .iter()
                .zip(&direction)
                .zip(&origin)
                .map(|((x, d), o)| (x + step * d).clamp(o - REACH, o + REACH))
                .collect();
            count += 1;
            let mut probe = probe;
            // Less noise than this leaves a matrix that double precision cannot solve.
            probe[1] = probe[1].max(probe[0] + LEAST_NOISE);
            // A matrix that is not positive definite is a step too far.
            match likelihood(samples, &parameters(&probe)) {
                Ok(found) if found.value >= best.value + 1e-4 * step * slope => {
                    moved = Some((probe, found));
                    break;
                }
                Ok(_) | Err(Error::IllPosed { .. }) => step *= 0.4,
                Err(error) => return Err(error),
            }
        }
        let Some((next, found)) = moved else { break };
        let s: Vec<f64> = next.iter().zip(&x).map(|(a, b)| a - b).collect();
        // Of the negative likelihood, so that the curvature is positive.
        let y: Vec<f64> = best.gradient.iter().zip(&found.gradient).map(|(a, b)| a - b).collect();
        if dot(&s, &y) > 1e-12 {
            pairs.push_back((s, y));
            if pairs.len() > MEMORY {
                pairs.pop_front();
            }
        }
        let gain = found.value - best.value;
        (x, best) = (next, found);
        if gain < 1e-6 * best.value.abs() {
            break;
        }
    }
    Ok(best)
}

/// The gradient times the inverse curvature that the pairs tell.
fn two_loops(pairs: &VecDeque<(Vec<f64>, Vec<f64>)>, gradient: &[f64]) -> Vec<f64> {
    let mut q = gradient.to_vec();
    let mut factors = Vec::new();
    for (s, y) in pairs.iter().rev() {
        let a = dot(s, &q) / dot(s, y);
        q.iter_mut().zip(y).for_each(|(q, y)| *q -= a * y);
        factors.push(a);
    }
    if let Some((s, y)) = pairs.back() {
        let scale = dot(s, y) / dot(y, y);
        q.iter_mut().for_each(|q| *q *= scale);
    }
    for ((s, y), a) in pairs.iter().zip(factors.iter().rev()) {
        let b = dot(y, &q) / dot(s, y);
        q.iter_mut().zip(s).for_each(|(q, s)| *q += (a - b) * s);
    }
    q
}

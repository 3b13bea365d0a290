//! Coupled simulated annealing: several walkers whose acceptance depends on all of them.
//!
//! ```text
//! accept a worse value with exp((E_k − max E)/T_a)/Σ exp((E_j − max E)/T_a);
//! T_a is steered so that the variance of these probabilities is 99 % of its maximum
//! ```
//!
//! Reference: S. Xavier-de-Souza, J. Suykens, J. Vandewalle, D. Bolle, Coupled simulated annealing,
//! IEEE Trans. Syst. Man Cybern. B 40 (2010) 320-335 (CSA-MwVC).

use super::random::Random;
use super::{Best, Counted, Watch, clamp};

/// Size of an annealing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Annealing {
    /// Number of walkers.
    pub walkers: usize,
    /// Steps of each walker.
    pub steps: usize,
    /// Seed.
    pub seed: u64,
}

impl Default for Annealing {
    fn default() -> Self {
        Self { walkers: 5, steps: 30, seed: 1 }
    }
}

/// Searches within the box with coupled walkers; a simplex afterwards finds the bottom.
pub fn coupled_annealing(
    bounds: &[(f64, f64)],
    annealing: Annealing,
    function: &mut dyn FnMut(&[f64]) -> f64,
    watch: Watch<'_>,
) -> Best {
    let walkers = annealing.walkers.max(2);
    let mut random = Random::new(annealing.seed);
    let mut counted = Counted::new(function, watch);
    let mut points: Vec<Vec<f64>> = Vec::new();
    for _ in 0..walkers {
        points.push(bounds.iter().map(|b| random.between(*b)).collect());
    }
    let mut values: Vec<f64> = points.iter().map(|p| counted.at(p)).collect();
    let mut acceptance = 1.0;
    let expected = 0.99 * (walkers as f64 - 1.0) / (walkers as f64).powi(2);
    for step in 1..=annealing.steps {
        let reach = 1.0 / step as f64;
        let shares = shares(&values, acceptance);
        let mean = 1.0 / walkers as f64;
        let variance = shares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() * mean;
        acceptance *= if variance < expected { 0.95 } else { 1.05 };
        for k in 0..walkers {
            let mut probe = points[k].clone();
            for (x, (low, high)) in probe.iter_mut().zip(bounds) {
                *x += 0.1 * (high - low) * reach * random.cauchy();
            }
            clamp(&mut probe, bounds);
            let value = counted.at(&probe);
            if value <= values[k] || shares[k] > random.unit() {
                (points[k], values[k]) = (probe, value);
            }
            if counted.stopped {
                return counted.best;
            }
        }
    }
    counted.best
}

/// Each walker's probability to accept a worse value.
fn shares(values: &[f64], temperature: f64) -> Vec<f64> {
    let finite = values.iter().copied().filter(|v| v.is_finite());
    let (least, most) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let scale = (most - least).max(f64::MIN_POSITIVE);
    let energy = |v: &f64| ((v.min(most) - most) / scale / temperature).exp();
    let all: Vec<f64> = values.iter().map(energy).collect();
    let sum: f64 = all.iter().sum();
    all.iter().map(|e| if sum > 0.0 { e / sum } else { 0.0 }).collect()
}

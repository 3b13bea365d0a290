//! A search that needs values only.

use numerics::random::SplitMix64;

/// Part of the values that is exchanged.
const EXCHANGED: f64 = 0.7;

/// The least of a function within bounds, and where it is.
///
/// `effort`: points per bound, and rounds. Differential evolution, the same at every run (R. Storn, K. Price, Journal
/// of Global Optimization 11 (1997) 341–359).
pub(crate) fn evolve(
    bounds: &[(f64, f64)],
    effort: (usize, usize),
    cost: impl Fn(&[f64]) -> f64,
) -> (Vec<f64>, f64) {
    let mut random = SplitMix64::new(1);
    let mut draw = move || random.uniform();
    let size = effort.0 * bounds.len();
    let mut all: Vec<(Vec<f64>, f64)> = (0..size)
        .map(|_| {
            let x: Vec<f64> =
                bounds.iter().map(|(low, high)| low + draw() * (high - low)).collect();
            let value = cost(&x);
            (x, value)
        })
        .collect();
    let least = |all: &[(Vec<f64>, f64)]| {
        (0..all.len()).min_by(|a, b| all[*a].1.total_cmp(&all[*b].1)).unwrap_or(0)
    };
    for _ in 0..effort.1 {
        let scale = 0.5 + 0.5 * draw();
        for at in 0..size {
            let best = least(&all);
            let mut other = || ((draw() * size as f64) as usize).min(size - 1);
            let (one, two) = (other(), other());
            let sure = (draw() * bounds.len() as f64) as usize;
            let x: Vec<f64> = bounds
                .iter()
                .enumerate()
                .map(|(k, (low, high))| {
                    if k != sure && draw() > EXCHANGED {
                        return all[at].0[k];
                    }
                    let moved = all[best].0[k] + scale * (all[one].0[k] - all[two].0[k]);
                    if (*low..=*high).contains(&moved) {
                        moved
                    } else {
                        low + draw() * (high - low)
                    }
                })
                .collect();
            let value = cost(&x);
            if value <= all[at].1 {
                all[at] = (x, value);
            }
        }
    }
    all.swap_remove(least(&all))
}

//! The command and its derivatives about one instant, from a low-pass of finite response.
//!
//! ```text
//! 2:  v, v̇          6:  v, v̇ at t−T, t, t+T          9:  also v̈          12:  also the jerk
//! ```
//!
//! The low-pass is a windowed sinc of 2m + 1 taps and delays by m steps; the instant t + T adds one
//! for 6 inputs and more. A model trained with these inputs and outputs that are shifted by
//! [`delay`](Derivatives::delay) steps is centred; in real time its output is late by that delay.
//! Derivatives are backward differences of the filtered command, each divided by a scale so that
//! all inputs are of order one.
//!
//! Source: Gaussian process with high-dimensional input, eqs. (13)-(19); the paper's filter is not
//! stated.

/// Dimension, filter and scales.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivatives {
    dimension: usize,
    taps: Vec<f64>,
    cutoff: f64,
    /// 1/scale of the command and of its first three differences per step.
    factors: [f64; 4],
}

/// Filtered values that are kept: t + T back to t − T and three differences.
const KEPT: usize = 6;

impl Derivatives {
    /// `dimension` is 2, 6, 9 or 12; `half` is m (0: no filter); `cutoff` in cycles per step, up to
    /// 0.5; `scales` divide the command and its differences of order 1 to 3 per step. `None` for
    /// other values.
    #[must_use]
    pub fn new(dimension: usize, half: usize, cutoff: f64, scales: [f64; 4]) -> Option<Self> {
        let known = matches!(dimension, 2 | 6 | 9 | 12);
        let sound = scales.iter().all(|s| s.is_finite() && *s > 0.0);
        (known && sound && half <= 1000 && cutoff > 0.0 && cutoff <= 0.5).then(|| Self {
            dimension,
            taps: low_pass(half, cutoff),
            cutoff,
            factors: scales.map(|s| 1.0 / s),
        })
    }

    pub(super) fn dimension(&self) -> usize {
        self.dimension
    }

    pub(super) fn memory(&self) -> usize {
        self.taps.len() + KEPT
    }

    /// Half length m of the low-pass.
    #[must_use]
    pub fn half(&self) -> usize {
        self.taps.len() / 2
    }

    /// Cut-off of the low-pass in cycles per step.
    #[must_use]
    pub fn cutoff(&self) -> f64 {
        self.cutoff
    }

    /// Steps from the instant that the inputs describe to the last command that they use.
    #[must_use]
    pub fn delay(&self) -> usize {
        self.taps.len() / 2 + usize::from(self.dimension > 2)
    }

    pub(super) fn rest(&self, u: f64, memory: &mut [f64]) {
        memory.fill(u);
    }

    pub(super) fn step(&self, u: f64, memory: &mut [f64], z: &mut [f64]) {
        let (raw, kept) = memory.split_at_mut(self.taps.len().min(memory.len()));
        let Some(last) = raw.len().checked_sub(1) else { return };
        raw.copy_within(..last, 1);
        raw[0] = u;
        let filtered = raw.iter().zip(&self.taps).map(|(x, w)| x * w).sum();
        kept.copy_within(..KEPT - 1, 1);
        kept[0] = filtered;
        if self.dimension == 2 {
            z[0] = kept[0] * self.factors[0];
            z[1] = (kept[0] - kept[1]) * self.factors[1];
            return;
        }
        // Oldest first, derivative after derivative, as the paper orders them.
        let orders = self.dimension / 3;
        for (order, z) in z.chunks_exact_mut(3).take(orders).enumerate() {
            for (at, z) in z.iter_mut().enumerate() {
                *z = difference(&kept[2 - at..], order) * self.factors[order];
            }
        }
    }
}

/// The backward difference of this order, the newest value first.
fn difference(x: &[f64], order: usize) -> f64 {
    match order {
        0 => x[0],
        1 => x[0] - x[1],
        2 => x[0] - 2.0 * x[1] + x[2],
        _ => x[0] - 3.0 * x[1] + 3.0 * x[2] - x[3],
    }
}

/// A sinc of this cut-off (cycles per step) in a Hamming window, of sum one.
fn low_pass(half: usize, cutoff: f64) -> Vec<f64> {
    let tap = |k: usize| {
        let t = k as f64 - half as f64;
        let angle = core::f64::consts::TAU * cutoff * t;
        let sinc = if t == 0.0 { 1.0 } else { libm::sin(angle) / angle };
        let phase = core::f64::consts::PI * t / (half as f64 + 1.0);
        sinc * (0.54 + 0.46 * libm::cos(phase))
    };
    let taps: Vec<f64> = (0..=2 * half).map(tap).collect();
    let sum: f64 = taps.iter().sum();
    taps.iter().map(|t| t / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Features;
    use super::*;

    #[test]
    fn a_cubic_has_its_derivatives_at_the_delayed_instant() {
        // Without filter: differences of t³ are known exactly.
        let plain = Derivatives::new(12, 0, 0.5, [1.0, 1.0, 1.0, 1.0]).unwrap();
        assert_eq!(plain.delay(), 1);
        let features = Features::Derivatives(plain);
        let cube = |t: i32| f64::from(t).powi(3);
        let u: Vec<f64> = (0..30).map(cube).collect();
        let all = features.of_record(&u, &u);
        let z = &all[12 * 20..12 * 21];
        for (at, t) in [18, 19, 20].into_iter().enumerate() {
            assert_eq!(z[at], cube(t));
            assert_eq!(z[3 + at], cube(t) - cube(t - 1));
            assert_eq!(z[6 + at], 6.0 * f64::from(t - 1));
            assert_eq!(z[9 + at], 6.0);
        }
    }

    #[test]
    fn the_low_pass_delays_a_slow_sine_and_removes_a_fast_one() {
        let filter = Derivatives::new(2, 10, 0.1, [1.0; 4]).unwrap();
        assert_eq!(filter.delay(), 10);
        let features = Features::Derivatives(filter);
        let sine = |f: f64, k: usize| libm::sin(core::f64::consts::TAU * f * k as f64);
        let slow: Vec<f64> = (0..300).map(|k| sine(0.01, k)).collect();
        let all = features.of_record(&slow, &slow);
        for k in 50..300 {
            assert!((all[2 * k] - slow[k - 10]).abs() < 0.02);
        }
        let fast: Vec<f64> = (0..300).map(|k| sine(0.3, k)).collect();
        let all = features.of_record(&fast, &fast);
        assert!((50..300).all(|k| all[2 * k].abs() < 0.01));
        assert!(Derivatives::new(7, 1, 0.1, [1.0; 4]).is_none());
    }
}

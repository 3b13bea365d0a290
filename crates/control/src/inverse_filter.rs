//! What undoes a discrete linear part in front of an inverse.
//!
//! ```text
//! D(z) = b_m z⁻ᵐ ∏(1 − n_i z⁻¹)/∏(1 − p_j z⁻¹)
//! ```
//!
//! Zeros that the inverse may have as poles (inside the unit circle, and not close to it on its left side, where
//! they ring from sample to sample) are undone exactly, and all poles; the others and the m samples of delay
//! to second order in the frequency, as a lag is: `1/∏(1 − n z⁻¹)·(1 − n) ≈ 1 + lag·s + inertia·s²`.
//!
//! Source: M. Tomizuka, Zero phase error tracking algorithm for digital control, ASME J. Dyn. Syst.
//! Meas. Control 109 (1987) 65–68 (which zeros may be cancelled).

use nalgebra::Complex;

use identify::learned::Arx;

/// Magnitude up to which zeros on the left side are undone exactly.
const RINGING: f64 = 0.7;
/// Magnitude from which a zero counts as on the unit circle.
const ON_CIRCLE: f64 = 1.0 - 1e-9;
/// Leading coefficients of the numerator below this part of the greatest one are samples of delay.
const NOTHING: f64 = 1e-9;

/// A filter, and what a lead adds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InverseFilter {
    /// With the gain 1 at rest.
    pub(crate) filter: Arx,
    /// In s.
    pub(crate) lag: f64,
    /// In s².
    pub(crate) inertia: f64,
}

impl InverseFilter {
    /// Undoes a stable linear part whose gain at rest is not 0.
    pub(crate) fn of(linear: &Arx, period: f64) -> Self {
        let greatest = linear.b.iter().fold(0.0_f64, |m, b| m.max(b.abs()));
        let late = linear.b.iter().position(|b| b.abs() > NOTHING * greatest).unwrap_or(0);
        let numerator = &linear.b[late..];
        let first = numerator.first().copied().unwrap_or(1.0);
        let tail: Vec<f64> = numerator.iter().skip(1).map(|b| b / first).collect();
        let zeros = Arx { b: vec![1.0], a: tail }.poles();
        let is_cancelled = |z: &Complex<f64>| {
            let size = z.norm();
            size < RINGING || size < ON_CIRCLE && z.re > 0.0
        };
        let (cancelled, left): (Vec<_>, Vec<_>) = zeros.into_iter().partition(is_cancelled);
        let mut a = vec![Complex::new(1.0, 0.0)];
        for zero in cancelled {
            a.push(Complex::new(0.0, 0.0));
            for k in (1..a.len()).rev() {
                let before = a[k - 1];
                a[k] -= zero * before;
            }
        }
        let a: Vec<f64> = a.iter().skip(1).map(|a| a.re).collect();
        let scale = (1.0 + a.iter().sum::<f64>()) / (1.0 + linear.a.iter().sum::<f64>());
        let b = core::iter::once(&1.0).chain(&linear.a).map(|a| scale * a).collect();
        let (mut first, mut second) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
        let mut times = |p: Complex<f64>, q: Complex<f64>| {
            (first, second) = (first + p, second + p * first + q);
        };
        for _ in 0..late {
            times(Complex::from(period), Complex::from(0.5 * period * period));
        }
        for zero in left {
            // (1 − n e^{−sT})/(1 − n) = 1 + c₁ s + c₂ s², and its inverse.
            let one = zero * period / (1.0 - zero);
            let two = -zero * period * period / (2.0 * (1.0 - zero));
            times(-one, one * one - two);
        }
        Self { filter: Arx { b, a }, lag: first.re, inertia: second.re }
    }

    /// Whether the filter does anything.
    pub(crate) fn filters(&self) -> bool {
        self.filter.b.len() > 1 || !self.filter.a.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;

    const PERIOD: f64 = 1e-3;

    fn sine(frequency: f64) -> Vec<f64> {
        (0..4000).map(|k| (TAU * frequency * f64::from(k) * PERIOD).sin()).collect()
    }

    /// The lead as the component `reference-lead` computes it.
    fn lead(cancelled: &InverseFilter, x: &[f64]) -> Vec<f64> {
        let at = |k: usize, back: usize| x[k.saturating_sub(back)];
        let one = |k: usize| (3.0 * at(k, 0) - 4.0 * at(k, 1) + at(k, 2)) / (2.0 * PERIOD);
        let two = |k: usize| (at(k, 0) - 2.0 * at(k, 1) + at(k, 2)) / (PERIOD * PERIOD);
        (0..x.len()).map(|k| x[k] + cancelled.lag * one(k) + cancelled.inertia * two(k)).collect()
    }

    fn error(linear: &Arx, frequency: f64) -> f64 {
        let cancelled = InverseFilter::of(linear, PERIOD);
        assert!(cancelled.filter.is_stable());
        let wanted = sine(frequency);
        let gain = linear.gain();
        let asked = cancelled.filter.simulate(&lead(&cancelled, &wanted), 0.0);
        let got = linear.simulate(&asked, 0.0);
        let late = 2000..4000;
        late.map(|k| (got[k] / gain - wanted[k]).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn lag_and_creep_are_cancelled_exactly() {
        let creep = Arx { b: vec![1.02, -1.0198], a: vec![-0.9998] };
        let linear = Arx::lag(20.0, PERIOD).then(&creep);
        assert!(error(&linear, 40.0) < 1e-6);
        assert!(InverseFilter::of(&linear, PERIOD).lag == 0.0);
    }

    #[test]
    fn delay_and_zeros_beyond_the_circle_are_compensated() {
        let late = Arx { b: vec![0.0, 0.3, 0.6], a: vec![-0.1] };
        let cancelled = InverseFilter::of(&late, PERIOD);
        assert!(
            cancelled.filters() && (cancelled.lag / PERIOD - 5.0 / 3.0).abs() < 1e-12,
            "{cancelled:?}"
        );
        let plain = Arx { b: vec![1.0], a: Vec::new() };
        assert!(!InverseFilter::of(&plain, PERIOD).filters());
        // 1.7 samples at 10 Hz turn by 0.1.
        assert!(error(&late, 10.0) < 0.01, "{}", error(&late, 10.0));
    }
}

//! The fast Fourier transform; `rustfft` behind it, which is generic and would be compiled anew in each
//! crate that names it.

use std::fmt;
use std::sync::Arc;

use rustfft::FftPlanner;

use crate::Complex;

/// A transform of a fixed length in one direction, for any number of signals.
///
/// ```text
/// forward   X_k = Σ_m x_m e^(−j2πkm/n)
/// inverse   x_m = Σ_k X_k e^(+j2πkm/n)      (n times the signal: it is not divided by n)
/// ```
#[derive(Clone)]
pub struct Fft(Arc<dyn rustfft::Fft<f64>>);

impl Fft {
    /// Plans the forward transform of `n` values.
    pub fn forward(n: usize) -> Self {
        Self(FftPlanner::new().plan_fft_forward(n))
    }

    /// Plans the inverse transform of `n` values, without the factor 1/n.
    pub fn inverse(n: usize) -> Self {
        Self(FftPlanner::new().plan_fft_inverse(n))
    }

    /// Number of values of one transform.
    #[expect(clippy::len_without_is_empty, reason = "a length of transforms, not of a container")]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Transforms `values` in place.
    ///
    /// # Panics
    /// If their number is no multiple of [`len`](Self::len).
    pub fn process(&self, values: &mut [Complex]) {
        self.0.process(values);
    }

    /// Transforms a real signal of [`len`](Self::len) values; all lines, of which those above n/2 are the
    /// conjugates of those below.
    ///
    /// # Panics
    /// If the length of `signal` is no multiple of [`len`](Self::len).
    pub fn of_real(&self, signal: &[f64]) -> Vec<Complex> {
        let mut lines: Vec<Complex> = signal.iter().map(|x| Complex::new(*x, 0.0)).collect();
        self.process(&mut lines);
        lines
    }
}

impl fmt::Debug for Fft {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Fft of {} values, {:?}", self.0.len(), self.0.fft_direction())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_sum_of_its_definition_and_its_own_inverse() {
        for n in [1, 2, 7, 12, 61] {
            let signal: Vec<f64> = (0..n).map(|k| ((k * k + 3 * k) % 17) as f64 - 8.0).collect();
            let lines = Fft::forward(n).of_real(&signal);
            for (k, line) in lines.iter().enumerate() {
                let turn = |m: usize| -std::f64::consts::TAU * (k * m % n) as f64 / n as f64;
                let sum: Complex =
                    (0..n).map(|m| Complex::from_polar(1.0, turn(m)) * signal[m]).sum();
                assert!((sum - line).norm() < 1e-10 * (n as f64) * 8.0, "{n} {k}: {sum} {line}");
            }
            let mut back = lines;
            Fft::inverse(n).process(&mut back);
            for (x, y) in signal.iter().zip(&back) {
                assert!((x * n as f64 - y.re).abs() < 1e-9 && y.im.abs() < 1e-9, "{n}: {x} {y}");
            }
        }
    }
}

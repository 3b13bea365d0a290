//! Spectra of signals: the window, one windowed transform, and amplitude density by Welch's method.

use crate::Complex;
use crate::fft::Fft;

/// Hann's window of `n` values, as periodic: `w_k = (1 − cos 2πk/n)/2`; `Σ w² = 3n/8`.
pub fn hann(n: usize) -> Vec<f64> {
    (0..n).map(|k| 0.5 - 0.5 * (std::f64::consts::TAU * k as f64 / n as f64).cos()).collect()
}

/// The forward transform of a signal, its mean taken out, under [Hann's window](hann); all lines.
pub fn windowed(signal: &[f64]) -> Vec<Complex> {
    let n = signal.len();
    let mean = signal.iter().sum::<f64>() / n as f64;
    let weighted: Vec<f64> = signal.iter().zip(hann(n)).map(|(x, w)| w * (x - mean)).collect();
    Fft::forward(n).of_real(&weighted)
}

/// The amplitude on each line of a signal's spectrum, its mean taken out, under [Hann's window](hann): of a sine of k waves
/// over the signal the one on line k. All lines.
pub fn amplitudes(signal: &[f64]) -> Vec<f64> {
    let scale = 4.0 / signal.len() as f64;
    windowed(signal).iter().map(|line| scale * line.norm()).collect()
}

/// Segments over which powers are averaged, at least, where the signal is long enough.
const SEGMENTS: usize = 8;
/// Shortest segment.
const SHORTEST: usize = 256;

/// One-sided amplitude density by Welch's method: segments of equal length that overlap by half, their
/// mean taken out, Hann's window w.
///
/// ```text
/// a(f_k) = √(2 T · mean over segments |FFT(w x)_k|² / Σ w²),   f_k = k/(n T)
/// ```
///
/// `values` every `period` (T) s; the density is in the signal's unit per √Hz. Values that are not finite
/// count as 0. Fewer than eight values have no density.
///
/// Source: P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70–73.
pub fn welch(values: &[f64], period: f64) -> (Vec<f64>, Vec<f64>) {
    let n = (2 * values.len() / (SEGMENTS + 1)).max(SHORTEST).min(values.len());
    if n < 8 || !(period.is_finite() && period > 0.0) {
        return (Vec::new(), Vec::new());
    }
    let window = hann(n);
    let weight: f64 = window.iter().map(|w| w * w).sum();
    let transform = Fft::forward(n);
    let mut powers = vec![0.0; n / 2 + 1];
    let mut count = 0.0;
    for start in (0..=values.len() - n).step_by((n / 2).max(1)) {
        let segment = &values[start..start + n];
        let finite = |x: &f64| if x.is_finite() { *x } else { 0.0 };
        let mean = segment.iter().map(finite).sum::<f64>() / n as f64;
        let mut buffer: Vec<Complex> = segment
            .iter()
            .zip(&window)
            .map(|(x, w)| Complex::new(w * (finite(x) - mean), 0.0))
            .collect();
        transform.process(&mut buffer);
        for (power, value) in powers.iter_mut().zip(&buffer) {
            *power += value.norm_sqr();
        }
        count += 1.0;
    }
    let scale = 2.0 * period / (weight * count);
    let width = 1.0 / (n as f64 * period);
    // The mean has been taken out: the line at 0 says nothing.
    let lines = 1..powers.len();
    let frequencies = lines.clone().map(|k| k as f64 * width).collect();
    (frequencies, lines.map(|k| (scale * powers[k]).sqrt()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_has_the_power_that_its_doc_states_and_takes_the_mean_out() {
        for n in [8, 9, 100] {
            let power: f64 = hann(n).iter().map(|w| w * w).sum();
            assert!((power - 0.375 * n as f64).abs() < 1e-9, "{n}: {power}");
            assert!(windowed(&vec![7.0; n]).iter().all(|line| line.norm() < 1e-9));
        }
    }

    #[test]
    fn a_sine_has_its_amplitude_on_the_line_of_its_waves() {
        let sine = |k: i32| 2.0 + 3.0 * (std::f64::consts::TAU * 7.0 * f64::from(k) / 99.0).sin();
        let found = amplitudes(&(0..99).map(sine).collect::<Vec<_>>());
        assert_eq!(found.len(), 99);
        assert!((found[7] - 3.0).abs() < 1e-12 && found[0].max(found[10]) < 1e-12, "{found:?}");
    }

    #[test]
    fn the_power_of_a_signal_is_the_integral_of_its_density() {
        let (period, n) = (1e-3, 20_000);
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        let values: Vec<f64> = (0..n)
            .map(|k| 5.0 + (std::f64::consts::TAU * 50.0 * f64::from(k) * period).sin() + noise())
            .collect();
        let (frequencies, density) = welch(&values, period);
        let width = frequencies[1] - frequencies[0];
        let power: f64 = density.iter().map(|a| a * a * width).sum();
        // A sine of amplitude 1 and noise of one part in twelve.
        assert!((power / (0.5 + 1.0 / 12.0) - 1.0).abs() < 0.02, "{power}");
        let peak = (0..density.len()).max_by(|a, b| density[*a].total_cmp(&density[*b])).unwrap();
        assert!((frequencies[peak] - 50.0).abs() <= width);
        // White noise of variance 1/12 over half the sample rate.
        let floor = (2.0 * period / 12.0_f64).sqrt();
        let far: Vec<f64> = frequencies
            .iter()
            .zip(&density)
            .filter(|(f, _)| **f > 200.0)
            .map(|(_, a)| a * a)
            .collect();
        let mean = (far.iter().sum::<f64>() / far.len() as f64).sqrt();
        assert!((mean / floor - 1.0).abs() < 0.03, "{mean} {floor}");
    }

    #[test]
    fn short_signals_have_none() {
        assert!(welch(&[1.0; 7], 1.0).0.is_empty());
        assert!(welch(&[1.0; 100], 0.0).0.is_empty());
        assert_eq!(welch(&[1.0; 100], 1.0).0.len(), 50);
    }
}

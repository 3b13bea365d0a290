//! Noise of the sensor: white, and 1/f below a corner.
//!
//! `y = x + n`, density `S(f) = A·(1 + corner/f)` from `lowest` to half the sample rate, A =
//! 2·rms²·period
//!
//! * rms in position: standard deviation of the white part per sample of the internal step; corner
//!   in Hz: where the 1/f part is as strong as the white one, 0 for none; seed: any number; the
//!   component's place in the model goes into it, so that two axes differ under equal seeds.
//!   lowest in Hz is structural: the 1/f part levels off below it.
//! * The 1/f part is white noise through a half-order integrator, a sum of first-order lags, two per
//!   decade, by the trapezoidal rule on `s^(-1/2) = 1/π ∫ e^(u/2)/(s + eᵘ) du`. The poles left out at
//!   the ends go into the last one and into a direct term. |G|² is that of 1/f within 2.5 % from twice
//!   `lowest` to a twentieth of the sample rate, 6.5 % to a tenth, 10 % at `lowest`.
//! * State: one number per lag; at rest drawn from the steady distribution, correlated as it is: the
//!   projection of the past on the orthonormal functions of Takenaka and Malmquist. All draws are
//!   functions of seed, source and step.
//!
//! Limits: the white part has no bandwidth of its own: put a bandwidth behind it where the sensor's
//! is below half the sample rate.
//!
//! Source: N. J. Kasdin, Proceedings of the IEEE 83 (1995) 802–827.

use core::f64::consts::{LN_10, PI, TAU};

use libm::{ceil, exp, expm1, log10, pow, sqrt};
use model::{Component, Declaration, Quantity, Sizes, Stage, Structural, Tick, Violation};

use crate::random::{normal, normals};
use crate::rules::WRONG_LENGTH;
use crate::{effects, phenomena};

/// The component `sensor-noise`.
pub struct SensorNoise;

static DECLARATION: Declaration = Declaration {
    kind: "sensor-noise",
    name: "noise",
    summary: "Noise of the sensor: white, and 1/f below a corner",
    equation: "y = x + n; S(f) = A*(1 + corner/f); A = 2*rms^2*period",
    reference: "N. J. Kasdin, Proc. IEEE 83 (1995) 802-827",
    stage: Stage::Sensor,
    effect: Some(&effects::SENSOR_NOISE),
    phenomena: &[&phenomena::SENSOR_NOISE],
    structure: &[Structural::real(
        "lowest",
        "Hz",
        "Frequency below which the 1/f part levels off",
        0.01,
        1e-9,
        1e6,
    )],
    parameters: &[
        Quantity::new(
            "rms",
            "{position}",
            "Standard deviation of the white part per internal step",
        )
        .min(0.0)
        .fitted(),
        Quantity::new("corner", "Hz", "Frequency below which 1/f noise is stronger")
            .start(0.0)
            .min(0.0)
            .fitted(),
        Quantity::new("seed", "1", "Seed of the noise").start(1.0).seed(),
    ],
    ..Declaration::PATH
};

/// Lags per decade.
const PER_DECADE: f64 = 2.0;

/// Part of the sum over the poles beyond either end that is made up for.
const BEYOND: f64 = 0.85;

/// From `lowest` to half the sample rate.
fn poles(structure: &[f64], period: f64) -> usize {
    let lowest = structure.first().copied().unwrap_or(1.0);
    ceil(log10(0.5 / (period * lowest)) * PER_DECADE).clamp(0.0, 64.0) as usize
}

/// Coefficients by name.
struct Noise<'a> {
    rms: f64,
    seed: f64,
    /// Direct term of the 1/f part; 0 where it has none.
    direct: f64,
    decays: &'a [f64],
    gains: &'a [f64],
}

impl<'a> Noise<'a> {
    #[inline]
    fn of(coefficients: &'a [f64]) -> Option<Self> {
        let (&[rms, seed, direct], arrays) = coefficients.split_first_chunk()?;
        let (decays, gains) = arrays.split_at(arrays.len() / 2);
        Some(Self { rms, seed, direct, decays, gains })
    }

    /// The noise of hit `count`.
    #[inline]
    fn step(&self, state: &mut [f64], count: u64) -> f64 {
        let [white, drive] = normals(self.seed, 0, count);
        if self.direct == 0.0 {
            return self.rms * white;
        }
        let lags = state.iter_mut().zip(self.decays.iter().zip(self.gains));
        lags.fold(self.rms * white + self.direct * drive, |sum, (n, (decay, gain))| {
            *n = decay * *n + gain * drive;
            sum + *n
        })
    }

    /// Draws the lags from their steady distribution.
    fn draw(&self, state: &mut [f64]) {
        for (k, n) in state.iter_mut().enumerate() {
            let (Some(&a), Some(&gain)) = (self.decays.get(k), self.gains.get(k)) else { continue };
            let (mut sum, mut product) = (0.0, 1.0);
            for (channel, &b) in (1u32..).zip(self.decays.iter().take(k + 1)) {
                let whiten = sqrt(1.0 - b * b) / (1.0 - a * b);
                sum += product * whiten * normal(self.seed, channel, 0);
                product *= (a - b) / (1.0 - a * b);
            }
            *n = gain * sum;
        }
    }
}

impl Component for SensorNoise {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        let poles = poles(structure, period);
        Sizes { coefficients: 3 + 2 * poles, states: poles }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[lowest], &[rms, corner, seed], Some((head, arrays))) =
            (structure, parameters, coefficients.split_first_chunk_mut::<3>())
        else {
            return Err(WRONG_LENGTH);
        };
        let apart = LN_10 / PER_DECADE;
        let beyond = BEYOND / expm1(0.5 * apart);
        let strength = rms * sqrt(TAU * corner) * apart / PI;
        let (decays, gains) = arrays.split_at_mut(arrays.len() / 2);
        let mut weight = 0.0;
        for (k, (decay, gain)) in decays.iter_mut().zip(gains).enumerate() {
            let pole = TAU * lowest * pow(10.0, k as f64 / PER_DECADE);
            weight = strength / sqrt(pole);
            let below = if k == 0 { beyond } else { 0.0 };
            (*decay, *gain) =
                (exp(-pole * period), -expm1(-pole * period) * weight * (1.0 + below));
        }
        *head = [rms, seed, weight * beyond];
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some(noise), &[x], [y]) = (Noise::of(coefficients), inputs, outputs) else { return };
        noise.draw(state);
        *y = x + noise.step(state, 0);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some(noise), &[x], [y]) = (Noise::of(coefficients), inputs, outputs) else { return };
        *y = x + noise.step(state, tick.index);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    fn noise(rms: f64, corner: f64, seed: f64, count: usize) -> std::vec::Vec<f64> {
        let p = [rms, corner, seed];
        let mut model = Instance::new(&SensorNoise, &[0.01], &p, 1e-3).unwrap();
        model.rest(&[0.0]);
        (0..count).map(|_| model.step(&[0.0])).collect()
    }

    /// Mean power in the band from f to 1.2 f, over the white density, by single-frequency sums.
    fn density(all: &[f64], f: f64) -> f64 {
        let (window, mut sum, mut count) = (numerics::spectrum::hann(16_384), 0.0, 0.0);
        for block in all.chunks_exact(window.len()) {
            for step in 0..4 {
                let f = f * (1.0 + 0.05 * f64::from(step));
                let (mut re, mut im, mut norm) = (0.0, 0.0, 0.0);
                for (n, (y, hann)) in block.iter().zip(&window).enumerate() {
                    let (s, c) = (TAU * f * 1e-3 * n as f64).sin_cos();
                    re += hann * y * c;
                    im += hann * y * s;
                    norm += hann * hann;
                }
                sum += (re * re + im * im) / norm;
                count += 1.0;
            }
        }
        sum / count
    }

    #[test]
    fn white_noise_has_its_standard_deviation() {
        let all = noise(2.0, 0.0, 1.0, 50_000);
        let rms = (all.iter().map(|y| y * y).sum::<f64>() / 5e4).sqrt();
        assert!((rms / 2.0 - 1.0).abs() < 0.02, "{rms}");
    }

    #[test]
    fn the_density_rises_by_the_corner_over_the_frequency() {
        let all = noise(1.0, 20.0, 3.0, 60 * 16_384);
        for f in [0.5, 2.0, 20.0, 100.0] {
            let ratio = density(&all, f) / (1.0 + 20.0 / (1.08 * f));
            assert!((ratio - 1.0).abs() < 0.25, "{f} Hz: {ratio}");
        }
    }

    /// |G|² of the coefficients against 1/f, from sample to sample.
    #[test]
    fn the_ladder_is_a_half_order_integrator() {
        for period in [1e-3, 2.5e-4, 1e-5] {
            let sizes = SensorNoise.sizes(&[0.01], period);
            let mut c = std::vec![0.0; sizes.coefficients];
            SensorNoise.prepare(&[0.01], &[2.0, 3.0, 1.0], period, &mut c).unwrap();
            let noise = Noise::of(&c).unwrap();
            let mut f = 0.01;
            while f * period < 0.1 {
                let (sin, cos) = (TAU * f * period).sin_cos();
                let (mut re, mut im) = (noise.direct, 0.0);
                for (a, g) in noise.decays.iter().zip(noise.gains) {
                    let (p, q) = (1.0 - a * cos, a * sin);
                    re += g * p / (p * p + q * q);
                    im -= g * q / (p * p + q * q);
                }
                let ratio = (re * re + im * im) * f / (2.0 * 2.0 * 3.0);
                let allowed = match f {
                    f if f < 0.02 => 0.1,
                    f if f * period < 0.05 => 0.025,
                    _ => 0.065,
                };
                assert!((ratio - 1.0).abs() < allowed, "{f} Hz at {period} s: {ratio}");
                f *= 1.07;
            }
        }
    }

    /// The steady distribution has the covariance that the recursion keeps.
    #[test]
    fn the_lags_are_drawn_from_their_steady_distribution() {
        let seeds = 4000;
        let mut sums = [[0.0; 3]; 3];
        let mut expected = sums;
        for seed in 0..seeds {
            let p = [1.0, 20.0, f64::from(seed)];
            let mut c = [0.0; 9];
            SensorNoise.prepare(&[5.0], &p, 1.0 / 160.0, &mut c).unwrap();
            let noise = Noise::of(&c).unwrap();
            let mut state = [0.0; 3];
            noise.draw(&mut state);
            for i in 0..3 {
                for j in 0..3 {
                    sums[i][j] += state[i] * state[j] / f64::from(seeds);
                    let one = noise.gains[i] * noise.gains[j];
                    expected[i][j] = one / (1.0 - noise.decays[i] * noise.decays[j]);
                }
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                let scale = (expected[i][i] * expected[j][j]).sqrt();
                let error = (sums[i][j] - expected[i][j]) / scale;
                // Five standard errors of a product: at most √2/√n.
                assert!(error.abs() < 5.0 * (2.0 / f64::from(seeds)).sqrt(), "{i} {j}: {error}");
            }
        }
    }

    #[test]
    fn seeds_give_different_noise_and_the_same_seed_the_same() {
        assert_eq!(noise(1.0, 5.0, 1.0, 50), noise(1.0, 5.0, 1.0, 50));
        assert!(noise(1.0, 5.0, 1.0, 50) != noise(1.0, 5.0, 2.0, 50));
    }
}

//! Noise of the sensor: white, and 1/f below a corner.
//!
//! `y = x + n`, density `S(f) = A·(1 + corner/f)` from `lowest` to half the sample rate, A =
//! 2·rms²·period
//!
//! * rms in position: standard deviation of the white part per sample of the internal step; corner
//!   in Hz: where the 1/f part is as strong as the white one, 0 for none; seed: any number,
//!   different for each instance. lowest in Hz is structural: the 1/f part levels off below it.
//! * The 1/f part is a sum of first-order noises, three per decade, each of variance
//!   A·corner·ln(10)/3; their sum is off the straight line by less than 5 % one decade inside.
//! * State: one number per first-order noise; at rest drawn from its steady distribution. All draws
//!   are functions of seed, source and step.
//!
//! Limits: the white part has no bandwidth of its own: put a bandwidth behind it where the sensor's
//! is below half the sample rate.
//!
//! Source: N. J. Kasdin, Proceedings of the IEEE 83 (1995) 802–827.

use core::f64::consts::{LN_10, TAU};

use libm::{ceil, exp, log10, pow, sqrt};
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Structural, Tick,
    Violation,
};

use crate::effects;
use crate::random::normal;
use crate::rules::WRONG_LENGTH;

/// The component `sensor-noise`.
pub struct SensorNoise;

static DECLARATION: Declaration = Declaration {
    kind: "sensor-noise",
    name: "noise",
    summary: "Noise of the sensor: white, and 1/f below a corner",
    equation: "y = x + n; S(f) = A*(1 + corner/f); A = 2*rms^2*period",
    reference: "N. J. Kasdin, Proc. IEEE 83 (1995) 802-827",
    stage: Stage::Sensor,
    conversion: Conversion::None,
    effect: Some(&effects::SENSOR_NOISE),
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
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
        Quantity::new("seed", "1", "Seed of the noise").start(1.0),
    ],
};

/// First-order noises per decade.
const PER_DECADE: f64 = 3.0;

/// From `lowest` to half the sample rate.
fn poles(structure: &[f64], period: f64) -> usize {
    let lowest = structure.first().copied().unwrap_or(1.0);
    ceil(log10(0.5 / (period * lowest)) * PER_DECADE).clamp(0.0, 64.0) as usize
}

impl Component for SensorNoise {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        {
            let poles = poles(structure, period);
            Sizes { coefficients: 2 + 2 * poles, states: poles }
        }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[lowest], &[rms, corner, seed], Some((head, poles))) =
            (structure, parameters, coefficients.split_first_chunk_mut::<2>())
        else {
            return Err(WRONG_LENGTH);
        };
        *head = [rms, seed];
        let variance = 2.0 * rms * rms * period * corner * LN_10 / PER_DECADE;
        let (poles, _) = poles.as_chunks_mut::<2>();
        for (k, [decay, spread]) in poles.iter_mut().enumerate() {
            let frequency = lowest * pow(10.0, k as f64 / PER_DECADE);
            *decay = exp(-TAU * frequency * period);
            *spread = sqrt(variance);
        }
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((&[rms, seed], poles)), &[x], [y]) =
            (coefficients.split_first_chunk::<2>(), inputs, outputs)
        else {
            return;
        };
        let (poles, _) = poles.as_chunks::<2>();
        let mut sum = rms * normal(seed, 0, 0);
        for ((channel, n), [_, spread]) in (1u32..).zip(state).zip(poles) {
            *n = spread * normal(seed, channel, 0);
            sum += *n;
        }
        *y = x + sum;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((&[rms, seed], poles)), &[x], [y]) =
            (coefficients.split_first_chunk::<2>(), inputs, outputs)
        else {
            return;
        };
        let (poles, _) = poles.as_chunks::<2>();
        let mut sum = rms * normal(seed, 0, tick.index);
        for ((channel, n), [decay, spread]) in (1u32..).zip(state).zip(poles) {
            if *spread != 0.0 {
                let fresh = spread * sqrt(1.0 - decay * decay);
                *n = decay * *n + fresh * normal(seed, channel, tick.index);
                sum += *n;
            }
        }
        *y = x + sum;
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
        let (window, mut sum, mut count) = (16_384, 0.0, 0.0);
        for block in all.chunks_exact(window) {
            for step in 0..4 {
                let f = f * (1.0 + 0.05 * f64::from(step));
                let (mut re, mut im, mut norm) = (0.0, 0.0, 0.0);
                for (n, y) in block.iter().enumerate() {
                    let hann = (core::f64::consts::PI * n as f64 / window as f64).sin().powi(2);
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

    #[test]
    fn seeds_give_different_noise_and_the_same_seed_the_same() {
        assert_eq!(noise(1.0, 5.0, 1.0, 50), noise(1.0, 5.0, 1.0, 50));
        assert!(noise(1.0, 5.0, 1.0, 50) != noise(1.0, 5.0, 2.0, 50));
    }
}

//! What the command does between two rows of a log.
//!
//! The models hold row k from t_k until t_{k+1}. A log of an instrument that samples a moving command does
//! not: the command moved on between the rows. A held command that the machine answers to as it did to the
//! real one is, with the sample time T and frequencies f below 1/(2T),
//!
//! ```text
//! straight between rows   u'_k = (u_k + u_{k+1})/2                    (the mean over the interval)
//! band-limited            U'(f) = U(f)·exp(iπfT)/sinc(fT)             (sinc(x) = sin(πx)/(πx))
//! ```
//!
//! Source: L. Ljung, System Identification, 2nd ed., 1999, section 13.3 (intersample behaviour);
//! R. Pintelon, J. Schoukens, System Identification: A Frequency Domain Approach, 2012, section 6.8.

use numerics::Complex;
use numerics::fft::Fft;
use serde::{Deserialize, Serialize};

/// Largest part of a sample that times may be off a uniform grid.
const UNIFORM: f64 = 1e-3;

/// What the command does between two rows of a log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Between {
    /// It is held (zero-order hold): a converter's output.
    #[default]
    Zoh,
    /// It goes straight to the next row (first-order hold).
    Line,
    /// It has no part above half the sample rate: sampled behind an anti-alias filter.
    BandLimited,
}

impl Between {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Zoh, Self::Line, Self::BandLimited];

    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Zoh => "zoh",
            Self::Line => "line",
            Self::BandLimited => "band-limited",
        }
    }

    /// In words, as in "the command is taken as …".
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Zoh => "held between the rows",
            Self::Line => "straight between the rows",
            Self::BandLimited => "band-limited between the rows",
        }
    }

    /// The one of this name.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|between| between.name() == name)
    }

    /// The held command that stands for the logged one; as it is where the times are not uniform.
    pub(crate) fn held(self, time: &[f64], command: Vec<f64>) -> Vec<f64> {
        if self == Self::Zoh || command.len() < 8 || !is_uniform(time) {
            return command;
        }
        match self {
            Self::Zoh => command,
            Self::Line => {
                let means = command.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
                means.chain(command.last().copied()).collect()
            }
            Self::BandLimited => band_limited(&command),
        }
    }
}

fn is_uniform(time: &[f64]) -> bool {
    let [first, .., last] = time else { return false };
    let period = (last - first) / (time.len() - 1) as f64;
    let is_near = |(k, t): (usize, &f64)| (t - first - k as f64 * period).abs() <= UNIFORM * period;
    period > 0.0 && time.iter().enumerate().all(is_near)
}

/// Half a sample earlier, the droop of the hold taken back. The record is continued by its mirror image, so
/// that its end does not run into its begin.
fn band_limited(command: &[f64]) -> Vec<f64> {
    let mirrored: Vec<f64> = command.iter().chain(command.iter().rev()).copied().collect();
    let count = mirrored.len();
    let mut all = Fft::forward(count).of_real(&mirrored);
    for (k, value) in all.iter_mut().enumerate() {
        // Frequency times sample time, from -1/2 to 1/2.
        let f = if 2 * k <= count { k as f64 } else { k as f64 - count as f64 } / count as f64;
        let angle = std::f64::consts::PI * f;
        let droop = if f == 0.0 { 1.0 } else { angle.sin() / angle };
        *value *= Complex::from_polar(1.0 / droop, angle);
    }
    Fft::inverse(count).process(&mut all);
    all[..command.len()].iter().map(|value| value.re / count as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// What a lag of 10 ms answers to a sine of 20 Hz that is sampled at 500 Hz: exactly, and to held commands.
    #[test]
    fn a_lag_answers_to_the_held_command_as_to_the_real_one() {
        let (period, frequency, lag) = (2e-3, 20.0, 1e-2);
        let time: Vec<f64> = (0..2000).map(|k| k as f64 * period).collect();
        let command: Vec<f64> = time.iter().map(|t| (TAU * frequency * t).sin()).collect();
        let w = TAU * frequency * lag;
        let exact = |t: f64| (TAU * frequency * t - w.atan()).sin() / (1.0 + w * w).sqrt();
        let error = |between: Between| {
            let held = between.held(&time, command.clone());
            let decay = (-period / lag).exp();
            let (mut y, mut worst) = (0.0, 0.0_f64);
            for (k, t) in time.iter().enumerate() {
                if (500..1500).contains(&k) {
                    worst = worst.max((y - exact(*t)).abs());
                }
                y = decay * y + (1.0 - decay) * held[k];
            }
            worst * (1.0 + w * w).sqrt()
        };
        // A held sine is late by half a sample: π·20 Hz·2 ms = 0.13 rad.
        assert!((error(Between::Zoh) - 2.0 * (0.5 * PI * frequency * period).sin()).abs() < 0.05);
        assert!(error(Between::Line) < 0.02, "{}", error(Between::Line));
        assert!(error(Between::BandLimited) < 0.01, "{}", error(Between::BandLimited));
    }

    #[test]
    fn a_log_that_is_not_uniform_is_left_as_it_is() {
        let mut time: Vec<f64> = (0..20).map(f64::from).collect();
        time[7] += 0.1;
        let command: Vec<f64> = time.iter().map(|t| t.sin()).collect();
        for between in Between::ALL {
            assert_eq!(between.held(&time, command.clone()), command);
            assert_eq!(Between::find(between.name()), Some(between));
        }
    }
}

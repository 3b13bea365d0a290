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
//!
//! Nor need a row's reading be taken before its command acts, as it is in a loop that reads, computes and
//! writes. Where both are sampled at one instant the reading answers to the command up to its own row; where a
//! row is written once its command has acted, to its own row's command.

use numerics::Complex;
use numerics::fft::Fft;
use serde::{Deserialize, Serialize};

use crate::thresholds::base::Thresholds;

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
    /// All assumptions about the command between two rows.
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

    /// The assumption of this name.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|between| between.name() == name)
    }

    /// When readings are taken, where nobody says: of a held command before it acts, of one that moves with it.
    fn usual_reading(self) -> Reading {
        if self == Self::Zoh { Reading::Before } else { Reading::With }
    }

    /// The held command that stands for the logged one; as it is where the times are not uniform.
    fn held(self, time: &[f64], command: Vec<f64>) -> Vec<f64> {
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

/// When the reading of a row is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reading {
    /// Before the command of its row acts: it answers to the rows before.
    #[default]
    Before,
    /// At the instant of its command.
    With,
    /// Once the command of its row has acted until the next one.
    After,
}

impl Reading {
    /// All instants at which a reading may be taken.
    pub const ALL: [Self; 3] = [Self::Before, Self::With, Self::After];

    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Before => "before",
            Self::With => "with",
            Self::After => "after",
        }
    }

    /// In words, as in "the reading of a row is taken …".
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Before => "before its command acts",
            Self::With => "at the instant of its command",
            Self::After => "after its command has acted",
        }
    }

    /// The instant of this name.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|reading| reading.name() == name)
    }

    /// Rows by which the reading is later.
    fn row(self) -> isize {
        match self {
            Self::Before => -1,
            Self::With => 0,
            Self::After => 1,
        }
    }
}

/// How a log is read: what the command does between rows, and when readings are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Course {
    pub(crate) between: Between,
    pub(crate) reading: Reading,
}

impl Course {
    /// As said, and as usual where nothing is.
    pub(crate) fn given(between: Option<Between>, reading: Option<Reading>) -> Self {
        let between = between.unwrap_or_default();
        Self { between, reading: reading.unwrap_or(between.usual_reading()) }
    }

    /// What else a log may be read as that says no more than this.
    pub(crate) fn open(between: Option<Between>, reading: Option<Reading>) -> Vec<Self> {
        let given = Self::given(between, reading);
        let betweens = Between::ALL.into_iter().filter(|b| between.is_none_or(|own| own == *b));
        betweens
            .flat_map(|between| {
                // A held command that acts at once is seen by the row that is read after it.
                let usual = [between.usual_reading(), Reading::After];
                let readings = reading.map_or(usual.to_vec(), |own| vec![own]);
                readings.into_iter().map(move |reading| Self { between, reading })
            })
            .filter(|course| *course != given)
            .collect()
    }

    /// In words, as in "the log is read as …".
    pub(crate) fn words(self) -> String {
        format!("the command {}, each reading {}", self.between.words(), self.reading.words())
    }

    /// The held command that stands for the logged one, row by row; it acts until the next row.
    pub(crate) fn held(self, time: &[f64], command: &[f64]) -> Vec<f64> {
        let mut held = self.between.held(time, command.to_vec());
        let last = held.len().saturating_sub(1);
        // Held, a row acts from its own instant on: a reading at that instant is one before it acts.
        let natural = self.between.usual_reading();
        let rows = match (self.between, self.reading) {
            (Between::Zoh, Reading::Before | Reading::With) => 0,
            (Between::Zoh, Reading::After) => 1,
            (_, reading) => reading.row() - natural.row(),
        };
        match rows {
            1 if last > 0 => {
                held.rotate_left(1);
                held[last] = held[last - 1];
            }
            -1 if last > 0 => {
                held.rotate_right(1);
                held[0] = command[0];
            }
            _ => {}
        }
        held
    }
}

fn is_uniform(time: &[f64]) -> bool {
    let [first, .., last] = time else { return false };
    let period = (last - first) / (time.len() - 1) as f64;
    let is_near = |(k, t): (usize, &f64)| {
        (t - first - k as f64 * period).abs() <= Thresholds::UNIFORM_TIMES * period
    };
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
    fn a_reading_that_comes_later_answers_to_a_later_row() {
        let time: Vec<f64> = (0..10).map(f64::from).collect();
        let command: Vec<f64> = time.iter().map(|t| t * t).collect();
        let held = |between, reading| Course { between, reading }.held(&time, &command);
        let zoh = held(Between::Zoh, Reading::Before);
        assert_eq!(zoh, command);
        assert_eq!(held(Between::Zoh, Reading::After)[..9], command[1..]);
        let line = held(Between::Line, Reading::With);
        assert_eq!(line[3], 12.5);
        assert_eq!(held(Between::Line, Reading::Before)[1..], line[..9]);
        assert_eq!(held(Between::Line, Reading::After)[..9], line[1..]);
    }

    #[test]
    fn what_is_said_is_not_open() {
        assert_eq!(Course::given(Some(Between::Line), None).reading, Reading::With);
        let open = Course::open(None, None);
        assert_eq!(open.len(), 5);
        assert!(!open.contains(&Course::default()));
        let of = |between, reading| Course::open(between, reading);
        assert!(of(Some(Between::Zoh), Some(Reading::After)).is_empty());
        assert!(of(Some(Between::Line), None).iter().all(|c| c.between == Between::Line));
        assert!(of(None, Some(Reading::With)).iter().all(|c| c.reading == Reading::With));
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

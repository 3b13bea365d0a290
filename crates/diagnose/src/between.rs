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
//! A model that takes several steps from row to row is played the course itself: its mean over each step, or, as a
//! converter does that interpolates between the rows, its value at the begin of each, held over it.
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

    /// The held command, one value per row, to which a machine with these readings (none: the usual ones) answers as to the one
    /// of the log; times in s. Where they are not uniform it is the log's, except that of readings after their command.
    #[must_use]
    pub fn as_held(self, reading: Option<Reading>, time: &[f64], command: &[f64]) -> Vec<f64> {
        Course::given(Some(self), reading).held(time, command, 1)
    }

    /// How logs are read of which so much is said: as usual where nothing is.
    #[must_use]
    pub fn with_reading(between: Option<Self>, reading: Option<Reading>) -> (Self, Reading) {
        let between = between.unwrap_or_default();
        (between, reading.unwrap_or(between.usual_reading()))
    }

    /// When readings are taken, where nobody says: of a held command before it acts, of one that moves with it.
    fn usual_reading(self) -> Reading {
        if self == Self::Zoh { Reading::Before } else { Reading::With }
    }

    /// The held command that stands for the logged one, a value for each step; as it is where the times are not uniform.
    fn held(self, time: &[f64], command: &[f64], grid: Grid) -> Vec<f64> {
        let Grid { per_row, are_held } = grid;
        let is_short = command.len() < 8 || !is_uniform(time);
        match self {
            Self::Line if !is_short => {
                let next = command[1..].iter().chain(command.last());
                let middle = if are_held { 0.0 } else { 0.5 };
                let row = |(u, next): (&f64, &f64)| {
                    let (u, rise) = (*u, (next - u) / per_row as f64);
                    (0..per_row).map(move |step| u + (step as f64 + middle) * rise)
                };
                command.iter().zip(next).flat_map(row).collect()
            }
            Self::BandLimited if !is_short => band_limited(command, grid),
            _ => command.iter().flat_map(|u| std::iter::repeat_n(*u, per_row)).collect(),
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

/// The model's steps from row to row.
#[derive(Clone, Copy)]
struct Grid {
    per_row: usize,
    /// Whether a command that moves is held over each.
    are_held: bool,
}

/// How a log is read: what the command does between rows, and when readings are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Course {
    pub(crate) between: Between,
    pub(crate) reading: Reading,
    /// Whether a command that moves is held over each of several steps of the model.
    pub(crate) is_stepped: bool,
}

impl Course {
    /// As said, and as usual where nothing is.
    pub(crate) fn given(between: Option<Between>, reading: Option<Reading>) -> Self {
        let (between, reading) = Between::with_reading(between, reading);
        Self { between, reading, is_stepped: false }
    }

    /// What else than `first` a log may be read as where so much is said, by a model with several `steps` from row to row
    /// or one.
    pub(crate) fn open(
        first: Self,
        (between, reading): (Option<Between>, Option<Reading>),
        steps: bool,
    ) -> Vec<Self> {
        let betweens = Between::ALL.into_iter().filter(|b| between.is_none_or(|own| own == *b));
        betweens
            .flat_map(|between| {
                // A held command that acts at once is seen by the row that is read after it.
                let usual = [between.usual_reading(), Reading::After];
                let readings = reading.map_or(usual.to_vec(), |own| vec![own]);
                let kinds: &[bool] =
                    if steps && between != Between::Zoh { &[false, true] } else { &[false] };
                let of = move |reading| {
                    kinds.iter().map(move |kind| Self { between, reading, is_stepped: *kind })
                };
                readings.into_iter().flat_map(of)
            })
            .filter(|course| *course != first)
            .collect()
    }

    /// In words, as in "the log is read as …".
    pub(crate) fn words(self) -> String {
        let stepped = if self.is_stepped { " and held over each step of the model" } else { "" };
        let (between, reading) = (self.between.words(), self.reading.words());
        format!("the command {between}{stepped}, each reading {reading}")
    }

    /// The held command that stands for the logged one, a value for each of these steps per row; the last of them acts
    /// until the next row.
    pub(crate) fn held(self, time: &[f64], command: &[f64], steps: usize) -> Vec<f64> {
        let are_held = self.is_stepped && steps > 1;
        let mut held = self.between.held(time, command, Grid { per_row: steps, are_held });
        let kept = held.len().saturating_sub(steps);
        // Held, a row acts from its own instant on: a reading at that instant is one before it acts.
        let natural = self.between.usual_reading();
        let rows = match (self.between, self.reading) {
            (Between::Zoh, Reading::Before | Reading::With) => 0,
            (Between::Zoh, Reading::After) => 1,
            (_, reading) => reading.row() - natural.row(),
        };
        match rows {
            1 if kept > 0 => {
                held.rotate_left(steps);
                let last = held[kept - 1];
                held[kept..].fill(last);
            }
            -1 if kept > 0 => {
                held.rotate_right(steps);
                held[..steps].fill(command[0]);
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

/// Half a step earlier, the droop of its hold taken back; or as the course is at the begin of each step. The record is
/// continued by its mirror image, so that its end does not run into its begin.
fn band_limited(command: &[f64], Grid { per_row, are_held }: Grid) -> Vec<f64> {
    let mirrored: Vec<f64> = command.iter().chain(command.iter().rev()).copied().collect();
    let count = mirrored.len();
    let rows = Fft::forward(count).of_real(&mirrored);
    let mut all = vec![Complex::default(); count * per_row];
    for (k, value) in rows.into_iter().enumerate() {
        // Frequency times sample time, from -1/2 to 1/2.
        let is_lower = 2 * k <= count;
        let f = if is_lower { k as f64 } else { k as f64 - count as f64 } / count as f64;
        let angle = std::f64::consts::PI * f / per_row as f64;
        let droop = if f == 0.0 { 1.0 } else { angle.sin() / angle };
        let at = if is_lower { k } else { k + count * (per_row - 1) };
        all[at] = if are_held { value } else { value * Complex::from_polar(1.0 / droop, angle) };
    }
    Fft::inverse(count * per_row).process(&mut all);
    all[..command.len() * per_row].iter().map(|value| value.re / count as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    const ONE: Grid = Grid { per_row: 1, are_held: false };

    /// What a lag of 10 ms answers to a sine of 20 Hz that is sampled at 500 Hz: exactly, and to held commands.
    #[test]
    fn a_lag_answers_to_the_held_command_as_to_the_real_one() {
        let (period, frequency, lag) = (2e-3, 20.0, 1e-2);
        let time: Vec<f64> = (0..2000).map(|k| k as f64 * period).collect();
        let command: Vec<f64> = time.iter().map(|t| (TAU * frequency * t).sin()).collect();
        let w = TAU * frequency * lag;
        let exact = |t: f64| (TAU * frequency * t - w.atan()).sin() / (1.0 + w * w).sqrt();
        let error = |between: Between| {
            let held = between.held(&time, &command, ONE);
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
        let held = |between, reading| {
            Course { between, reading, is_stepped: false }.held(&time, &command, 1)
        };
        let zoh = held(Between::Zoh, Reading::Before);
        assert_eq!(zoh, command);
        assert_eq!(held(Between::Zoh, Reading::After)[..9], command[1..]);
        let line = held(Between::Line, Reading::With);
        assert_eq!(line[3], 12.5);
        assert_eq!(held(Between::Line, Reading::Before)[1..], line[..9]);
        assert_eq!(held(Between::Line, Reading::After)[..9], line[1..]);
    }

    #[test]
    fn several_steps_from_row_to_row_are_played_the_course_itself() {
        let time: Vec<f64> = (0..400).map(|k| f64::from(k) * 1e-3).collect();
        // 60 and 180 Hz at 1 kHz, from rest to rest.
        let course = |t: f64| {
            (0.5 - 0.5 * (TAU * t / 0.4).cos())
                * ((TAU * 60.0 * t).sin() + 0.5 * (TAU * 180.0 * t).sin())
        };
        let command: Vec<f64> = time.iter().map(|t| course(*t)).collect();
        let of = |between, reading, is_stepped| {
            Course { between, reading, is_stepped }.held(&time, &command, 4)
        };
        let error = |held: &[f64], wanted: &dyn Fn(f64) -> f64| {
            let at = |(k, u): (usize, &f64)| (u - wanted(k as f64 * 2.5e-4)).abs();
            held.iter().enumerate().skip(100).take(1400).map(at).fold(0.0, f64::max)
        };
        let (with, before, after) = (Reading::With, Reading::Before, Reading::After);
        let stepped = |reading| of(Between::BandLimited, reading, true);
        assert!(error(&stepped(with), &course) < 1e-3);
        assert!(error(&stepped(before), &|t| course(t - 1e-3)) < 1e-3);
        assert!(error(&stepped(after), &|t| course(t + 1e-3)) < 1e-3);
        // The middle of each step, and 0.3 % of the wave of 180 Hz, which a hold over 0.25 ms takes.
        assert!(error(&of(Between::BandLimited, with, false), &|t| course(t + 1.25e-4)) < 3e-3);
        let at = |part: f64| command[10] + part * (command[11] - command[10]);
        assert_eq!(of(Between::Line, with, true)[41], at(0.25));
        assert_eq!(of(Between::Line, with, false)[41], at(0.375));
        let zoh = of(Between::Zoh, before, false);
        assert!(zoh.chunks(4).zip(&command).all(|(held, u)| held == [*u; 4]));
        assert_eq!(of(Between::Zoh, after, false)[..1596], zoh[4..]);
    }

    #[test]
    fn what_is_given_is_not_open() {
        assert_eq!(Course::given(Some(Between::Line), None).reading, Reading::With);
        let (held, nothing) = (Course::default(), (None, None));
        let open = Course::open(held, nothing, false);
        assert_eq!(open.len(), 5);
        assert_eq!(Course::open(held, nothing, true).len(), 9);
        assert!(!open.contains(&held));
        let after = Course::given(None, Some(Reading::After));
        let others = Course::open(after, nothing, false);
        assert!(others.contains(&held) && !others.contains(&after));
        let of = |between, reading| {
            Course::open(Course::given(between, reading), (between, reading), false)
        };
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
            assert_eq!(between.held(&time, &command, ONE), command);
            assert_eq!(Between::find(between.name()), Some(between));
        }
    }
}

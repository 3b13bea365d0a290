//! Commands of several kinds. Each record begins at rest under its first value.

use std::f64::consts::TAU;

use crate::random::Random;

/// A kind of record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Random phases, 2 to 600 Hz, falling with frequency.
    Multisine,
    /// Triangles whose amplitude falls.
    FallingTriangle,
    /// Steps up and down the range.
    Staircase,
    /// 5 to 500 Hz.
    Sweep,
    /// Triangles whose amplitude grows.
    RisingTriangle,
    /// About 47 Hz.
    FastSine,
    /// Steps of random height and length.
    RandomSteps,
    /// Production: moves to places, dwells, scans.
    Operation,
    /// Nothing moves.
    Idle,
}

impl Kind {
    /// Records to fit.
    pub const FIT: [Self; 4] =
        [Self::Multisine, Self::FallingTriangle, Self::Staircase, Self::Sweep];
    /// Records to judge; also the kinds of those that nobody but the scorer sees.
    pub const HELD_OUT: [Self; 4] =
        [Self::Multisine, Self::RisingTriangle, Self::RandomSteps, Self::FastSine];

    /// Name of the log.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Multisine => "multisine",
            Self::FallingTriangle => "falling-triangle",
            Self::Staircase => "staircase",
            Self::Sweep => "sweep",
            Self::RisingTriangle => "rising-triangle",
            Self::FastSine => "fast-sine",
            Self::RandomSteps => "random-steps",
            Self::Operation => "operation",
            Self::Idle => "idle",
        }
    }

    /// Usual length in s.
    #[must_use]
    pub const fn seconds(self) -> f64 {
        match self {
            Self::FastSine => 1.0,
            Self::Sweep | Self::Idle => 1.5,
            Self::Operation => 8.0,
            _ => 2.0,
        }
    }

    /// The command in V over `rows` periods; `level` scales the amplitude, 1 being nearly the range.
    #[must_use]
    pub fn command(self, rows: usize, period: f64, level: f64, random: &mut Random) -> Vec<f64> {
        let seconds = rows as f64 * period;
        let value: Box<dyn FnMut(f64) -> f64 + '_> = match self {
            Self::Multisine => Box::new(multisine(seconds, level, random)),
            Self::FallingTriangle => {
                let hz = random.between(3.0, 4.0);
                Box::new(move |t| triangle(t, hz, 48.0 * level * (1.0 - 0.85 * t / seconds)))
            }
            Self::RisingTriangle => {
                let hz = random.between(2.0, 2.8);
                Box::new(move |t| triangle(t, hz, 46.0 * level * (0.15 + 0.85 * t / seconds)))
            }
            Self::Staircase => Box::new(staircase(seconds, level)),
            Self::Sweep => Box::new(move |t| {
                // Logarithmic: the phase is the integral of 5·100^(t/T).
                let rate = 100.0_f64.ln() / seconds;
                let phase = 5.0 * ((rate * t).exp() - 1.0) / rate;
                50.0 + 20.0 * level * (-2.5 * t / seconds).exp() * (TAU * phase).sin()
            }),
            Self::FastSine => {
                let hz = random.between(42.0, 54.0);
                // One period to grow.
                Box::new(move |t| 50.0 + 40.0 * level * (t * hz).min(1.0) * (TAU * hz * t).sin())
            }
            Self::RandomSteps => Box::new(random_steps(level, random)),
            Self::Operation => Box::new(operation(level, random)),
            Self::Idle => Box::new(|_| 0.0),
        };
        (0..rows).map(|k| k as f64 * period).map(value).collect()
    }
}

/// About the middle of the range, beginning there.
fn triangle(t: f64, hz: f64, amplitude: f64) -> f64 {
    let turn = (t * hz + 0.75).fract();
    50.0 + amplitude * (4.0 * (turn - 0.5).abs() - 1.0)
}

fn multisine(seconds: f64, level: f64, random: &mut Random) -> impl FnMut(f64) -> f64 + use<> {
    // Whole periods per record, lines that grow apart.
    let base = 1.0 / seconds.max(0.5);
    let mut lines = Vec::new();
    let mut n: f64 = (2.0 / base).ceil();
    while n * base <= 600.0 {
        let hz = n * base;
        lines.push((TAU * hz, 1.0 / (1.0 + hz / 25.0), TAU * random.unit()));
        n = (n * 1.06 + 1.0).round();
    }
    let peak = 2.6 * (lines.iter().map(|l| l.1 * l.1).sum::<f64>() / 2.0).sqrt();
    move |t| {
        let sum: f64 = lines.iter().map(|(w, a, phase)| a * (w * t + phase).sin()).sum();
        // 20 ms to grow, or the record would begin with a blow.
        (50.0 + 44.0 * level * (t / 0.02).min(1.0) * sum / peak).clamp(-15.0, 115.0)
    }
}

fn staircase(seconds: f64, level: f64) -> impl FnMut(f64) -> f64 {
    const LEVELS: [f64; 10] = [0.0, 25.0, 50.0, 75.0, 96.0, 70.0, 45.0, 15.0, 60.0, 30.0];
    move |t| {
        let index = (t / seconds * LEVELS.len() as f64) as usize;
        level * LEVELS.get(index).copied().unwrap_or(0.0)
    }
}

fn random_steps(level: f64, random: &mut Random) -> impl FnMut(f64) -> f64 + use<> {
    let mut random = Random::new(random.next_u64(), &[]);
    let (mut value, mut until) = (0.0, 0.05);
    move |t| {
        if t >= until {
            value = level * random.between(2.0, 95.0);
            until = t + random.between(0.08, 0.35);
        }
        value
    }
}

/// Moves with bounded speed to random places, dwells, and now and then a scan of triangles.
fn operation(level: f64, random: &mut Random) -> impl FnMut(f64) -> f64 + use<> {
    let mut random = Random::new(random.next_u64(), &[]);
    let (mut from, mut to) = (5.0, 5.0);
    let (mut begin, mut move_for, mut until, mut scan) = (0.0, 0.1, 0.2, 0.0);
    move |t| {
        if t >= until {
            from = to;
            to = 5.0 + level * random.between(0.0, 85.0);
            begin = t;
            move_for = (to - from).abs() / random.between(400.0, 2500.0) + 0.002;
            scan = if random.unit() < 0.3 { random.between(8.0, 20.0) } else { 0.0 };
            until = begin + move_for + random.between(0.1, 0.5);
        }
        let part = ((t - begin) / move_for).clamp(0.0, 1.0);
        // A cubic blend: no jump of the speed.
        let place = from + (to - from) * part * part * (3.0 - 2.0 * part);
        let turn = ((t - begin - move_for).max(0.0) * 12.0 + 0.75).fract();
        let amplitude = scan * (((t - begin - move_for) * 12.0).clamp(0.0, 1.0));
        (place + amplitude * (4.0 * (turn - 0.5).abs() - 1.0)).clamp(0.0, 100.0)
    }
}

/// The neighbour's command: slow moves and a few lines, independent of this axis.
#[must_use]
pub fn neighbour(rows: usize, period: f64, random: &mut Random) -> Vec<f64> {
    let lines: Vec<(f64, f64, f64)> = (0..6)
        .map(|i| {
            let hz = random.between(1.0, 3.0) * 2.2_f64.powi(i);
            (TAU * hz, 18.0 / (1.0 + 0.3 * f64::from(i)), TAU * random.unit())
        })
        .collect();
    (0..rows)
        .map(|k| {
            let t = k as f64 * period;
            let sum: f64 = lines.iter().map(|(w, a, p)| a * ((w * t + p).sin() - p.sin())).sum();
            (50.0 + sum).clamp(0.0, 100.0)
        })
        .collect()
}

/// Sensor noise of this standard deviation: seven tenths of its power white, the rest 1/f from 0.2 to
/// 125 Hz as a sum of relaxations.
#[must_use]
pub fn noise(rows: usize, period: f64, sigma: f64, random: &mut Random) -> Vec<f64> {
    const CORNERS: [f64; 5] = [0.2, 1.0, 5.0, 25.0, 125.0];
    let white = sigma * 0.7_f64.sqrt();
    let pink = sigma * (0.3 / CORNERS.len() as f64).sqrt();
    let keep = CORNERS.map(|hz| (-TAU * hz * period).exp());
    let drive = keep.map(|k| (1.0 - k * k).sqrt());
    let mut state = CORNERS.map(|_| random.normal());
    (0..rows)
        .map(|_| {
            for ((x, k), d) in state.iter_mut().zip(keep).zip(drive) {
                *x = k * *x + d * random.normal();
            }
            white * random.normal() + pink * state.iter().sum::<f64>()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Kind; 9] = [
        Kind::Multisine,
        Kind::FallingTriangle,
        Kind::Staircase,
        Kind::Sweep,
        Kind::RisingTriangle,
        Kind::FastSine,
        Kind::RandomSteps,
        Kind::Operation,
        Kind::Idle,
    ];

    #[test]
    fn commands_stay_in_range_repeat_and_differ_by_seed() {
        for kind in ALL {
            let draw = |seed| {
                let mut random = Random::new(seed, &[]);
                kind.command(8000, 2.5e-4, 1.0, &mut random)
            };
            let command = draw(1);
            assert!(command.iter().all(|u| (-15.0..=115.0).contains(u)), "{kind:?}");
            assert_eq!(command, draw(1));
            let is_fixed = matches!(kind, Kind::Staircase | Kind::Sweep | Kind::Idle);
            assert_eq!(command == draw(2), is_fixed, "{kind:?}");
        }
    }

    #[test]
    fn records_begin_without_a_blow() {
        for kind in ALL {
            let command = kind.command(8000, 2.5e-4, 1.0, &mut Random::new(4, &[]));
            assert!((command[1] - command[0]).abs() < 2.0, "{kind:?}");
        }
    }

    #[test]
    fn noise_has_its_standard_deviation_and_more_power_at_low_frequency() {
        let (n, h) = (400_000, 2.5e-4);
        let all = noise(n, h, 0.5, &mut Random::new(9, &[]));
        let mean = all.iter().sum::<f64>() / n as f64;
        let power = all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n as f64;
        assert!((power.sqrt() / 0.5 - 1.0).abs() < 0.03, "{}", power.sqrt());
        // White noise would lose a factor of 400 in means of 400 samples.
        let blocks = all.chunks(400).map(|b| (b.iter().sum::<f64>() / 400.0).powi(2));
        let low = blocks.sum::<f64>() / 1000.0;
        assert!(low > 20.0 * power / 400.0, "{low} {power}");
    }
}

//! Effects that are in nobody's library.

use std::f64::consts::TAU;

use super::linear::Lags;
use super::{Block, Tick};
use crate::random::Random;

/// A gain that breathes: `y = x (1 + depth·sin 2πft)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GainModulation {
    depth: f64,
    hz: f64,
    phase: f64,
}

impl GainModulation {
    pub(crate) fn new(depth: f64, hz: f64, random: &mut Random) -> Self {
        Self { depth, hz, phase: random.unit() }
    }
}

impl Block for GainModulation {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        x
    }
    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        x * (1.0 + self.depth * (TAU * (self.hz * tick.time + self.phase)).sin())
    }
}

/// Vibration in a narrow band: noise through a resonance of 4 % damping, so no line and no period.
#[derive(Clone, Debug)]
pub(crate) struct Vibration {
    a: [f64; 2],
    drive: f64,
    state: [f64; 2],
    random: Random,
}

impl Vibration {
    /// Of the root mean square `level` in µm about a frequency in Hz.
    pub(crate) fn new(level: f64, hz: f64, random: Random, period: f64) -> Self {
        let angle = TAU * hz * period;
        let radius = (-0.04 * angle).exp();
        let a = [2.0 * radius * angle.cos(), -radius * radius];
        // Variance of y_k = a₁y_{k−1} + a₂y_{k−2} + e_k.
        let variance = (1.0 - a[1]) / ((1.0 + a[1]) * ((1.0 - a[1]).powi(2) - a[0] * a[0]));
        let drive = level / variance.sqrt();
        let mut all = Self { a, drive, state: [0.0; 2], random };
        // Long enough to forget its start.
        let warm = (20.0 / (0.04 * angle)) as usize;
        for _ in 0..warm {
            all.next();
        }
        all
    }

    fn next(&mut self) -> f64 {
        let y = self.a[0] * self.state[0]
            + self.a[1] * self.state[1]
            + self.drive * self.random.normal();
        self.state = [y, self.state[0]];
        y
    }
}

impl Block for Vibration {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        x
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        x + self.next()
    }
}

/// Glitches: jumps at random times that decay within milliseconds.
#[derive(Clone, Debug)]
pub(crate) struct Glitches {
    level: f64,
    chance: f64,
    keep: f64,
    value: f64,
    random: Random,
}

impl Glitches {
    /// Of the mean height `level` in µm, about twelve per second.
    pub(crate) fn new(level: f64, random: Random, period: f64) -> Self {
        Self { level, chance: 12.0 * period, keep: (-period / 3e-3).exp(), value: 0.0, random }
    }
}

impl Block for Glitches {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        x
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.value *= self.keep;
        if self.random.unit() < self.chance {
            self.value -= self.level * self.random.sign() * (1.0 - self.random.unit()).ln();
        }
        x + self.value
    }
}

/// A reading without its constant part: the droop of an AC-coupled amplifier since the record began.
#[derive(Clone, Debug)]
pub(crate) struct AcCoupling(Lags);

impl AcCoupling {
    /// With a corner in rad/s.
    pub(crate) fn new(corner: f64, period: f64) -> Self {
        Self(Lags::new(1.0 / corner, 1, period))
    }
}

impl Block for AcCoupling {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.0.set(0.0);
        x
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        x - self.0.follow(x)
    }
}

/// A reading that freezes now and then.
#[derive(Clone, Debug)]
pub(crate) struct HeldSamples {
    length: f64,
    chance: f64,
    period: f64,
    left: f64,
    value: f64,
    random: Random,
}

impl HeldSamples {
    /// For `length` in s on average, about eight times per second.
    pub(crate) fn new(length: f64, random: Random, period: f64) -> Self {
        Self { length, chance: 8.0 * period, period, left: 0.0, value: 0.0, random }
    }
}

impl Block for HeldSamples {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.value = x;
        x
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.left -= self.period;
        if self.left <= 0.0 {
            self.value = x;
            if self.random.unit() < self.chance {
                self.left = self.length * self.random.between(0.5, 1.5);
            }
        }
        self.value
    }
}

/// Popcorn noise: jumps between two levels, about six per second.
#[derive(Clone, Debug)]
pub(crate) struct Telegraph {
    level: f64,
    chance: f64,
    random: Random,
}

impl Telegraph {
    /// Levels ±`level` in µm.
    pub(crate) fn new(level: f64, mut random: Random, period: f64) -> Self {
        Self { level: level * random.sign(), chance: 6.0 * period, random }
    }
}

impl Block for Telegraph {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        x + self.level
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        if self.random.unit() < self.chance {
            self.level = -self.level;
        }
        x + self.level
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vibration_has_the_stated_power_and_no_line() {
        let mut vibration = Vibration::new(2.0, 30.0, Random::new(5, &[]), 1e-3);
        let values: Vec<f64> =
            (0..400_000).map(|_| vibration.step(0.0, &Tick::default())).collect();
        let power = values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64;
        assert!((power / 4.0 - 1.0).abs() < 0.05, "{power}");
        // A line would keep its phase: the correlation over 10 s is nil.
        let far = values.iter().zip(&values[10_000..]).map(|(a, b)| a * b).sum::<f64>();
        assert!((far / (4.0 * values.len() as f64)).abs() < 0.05);
    }

    #[test]
    fn a_frozen_reading_repeats_its_value() {
        let mut held = HeldSamples::new(0.02, Random::new(2, &[]), 1e-3);
        let values: Vec<f64> =
            (0..20_000).map(|k| held.step(f64::from(k), &Tick::default())).collect();
        let frozen = values.windows(2).filter(|w| w[0] == w[1]).count();
        // Eight per second of free time, 20 ms each: about one part in seven.
        assert!((2000..3600).contains(&frozen), "{frozen}");
    }

    #[test]
    fn ac_coupling_forgets_a_step() {
        let mut block = AcCoupling::new(2.0, 1e-3);
        assert_eq!(block.rest(5.0, &Tick::default()), 5.0);
        let y = (0..1000).fold(0.0, |_, _| block.step(5.0, &Tick::default()));
        assert!((y - 5.0 * (-2.0_f64).exp()).abs() < 1e-9);
    }
}

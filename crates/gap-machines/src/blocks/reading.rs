//! What the sensor and its surroundings add to a position.

use std::f64::consts::TAU;

use super::linear::{Lags, Mode};
use super::{Block, Tick};
use crate::random::Random;

/// A constant factor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gain(pub(crate) f64);

impl Block for Gain {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.0 * x
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.0 * x
    }
}

/// A factor that ages: `1 + growth·(1 + 0.05 lg(1 + t/0.1 s))`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GainOverTime(pub(crate) f64);

impl Block for GainOverTime {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        (1.0 + self.0) * x
    }
    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        (1.0 + self.0 * (1.0 + 0.05 * (1.0 + tick.time / 0.1).log10())) * x
    }
}

/// Motion by the neighbour's command, at once or through a lag and a mode.
#[derive(Clone, Debug)]
pub(crate) struct Coupling {
    gain: f64,
    path: Option<(Lags, Mode)>,
}

impl Coupling {
    /// In µm/V, at once.
    pub(crate) fn prompt(gain: f64) -> Self {
        Self { gain, path: None }
    }

    /// In µm/V, through a lag of `tau` in s and a mode.
    pub(crate) fn slow(gain: f64, tau: f64, mode: (f64, f64), period: f64) -> Self {
        let path = Some((Lags::new(tau, 1, period), Mode::new(mode.0, mode.1, period)));
        Self { gain, path }
    }
}

impl Block for Coupling {
    fn rest(&mut self, x: f64, tick: &Tick) -> f64 {
        if let Some((lag, mode)) = &mut self.path {
            lag.set(tick.neighbour);
            mode.set(tick.neighbour);
        }
        x + self.gain * tick.neighbour
    }
    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        let moved = match &mut self.path {
            Some((lag, mode)) => mode.follow(lag.follow(tick.neighbour)),
            None => tick.neighbour,
        };
        x + self.gain * moved
    }
}

/// Thermal drift `level·(slope·t/2 s + growth·(1 − e^(−t/τ)))`, different in each record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drift {
    slope: f64,
    growth: f64,
    tau: f64,
}

impl Drift {
    /// Of the size `level` in µm.
    pub(crate) fn new(level: f64, random: &mut Random) -> Self {
        Self {
            slope: level * random.between(0.5, 1.0) * random.sign() / 2.0,
            growth: level * random.between(0.2, 0.6) * random.sign(),
            tau: random.between(0.4, 1.5),
        }
    }
}

impl Block for Drift {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        x
    }
    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        x + self.slope * tick.time - self.growth * (-tick.time / self.tau).exp_m1()
    }
}

/// A random walk from zero.
#[derive(Clone, Debug)]
pub(crate) struct Walk {
    step: f64,
    random: Random,
    at: f64,
}

impl Walk {
    /// Of `level` µm after 1 s.
    pub(crate) fn new(level: f64, random: Random, period: f64) -> Self {
        Self { step: level * period.sqrt(), random, at: 0.0 }
    }
}

impl Block for Walk {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        x
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.at += self.step * self.random.normal();
        x + self.at
    }
}

/// Hum with its third harmonic.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hum {
    level: f64,
    third: f64,
    hz: f64,
    phases: [f64; 2],
}

impl Hum {
    /// Amplitudes of the fundamental in µm and of the third harmonic relative to it, random phases.
    pub(crate) fn new(level: f64, third: f64, hz: f64, random: &mut Random) -> Self {
        let phases = [random.unit(), random.unit()];
        Self { level, third, hz, phases }
    }

    fn value(&self, time: f64) -> f64 {
        let [one, three] = self.phases;
        let turn = self.hz * time;
        self.level * ((TAU * (turn + one)).sin() + self.third * (TAU * (3.0 * turn + three)).sin())
    }
}

impl Block for Hum {
    fn rest(&mut self, x: f64, tick: &Tick) -> f64 {
        x + self.value(tick.time)
    }
    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        x + self.value(tick.time)
    }
}

/// Feed-through of the command, or of its rate, past the mechanics.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FeedThrough {
    gain: f64,
    of_rate: bool,
    last: f64,
    period: f64,
}

impl FeedThrough {
    /// In µm/V; of the rate in µm s/V.
    pub(crate) fn new(gain: f64, of_rate: bool, period: f64) -> Self {
        Self { gain, of_rate, last: 0.0, period }
    }
}

impl Block for FeedThrough {
    fn rest(&mut self, x: f64, tick: &Tick) -> f64 {
        self.last = tick.command;
        if self.of_rate { x } else { x + self.gain * tick.command }
    }
    fn step(&mut self, x: f64, tick: &Tick) -> f64 {
        let rate = (tick.command - self.last) / self.period;
        self.last = tick.command;
        x + self.gain * if self.of_rate { rate } else { tick.command }
    }
}

/// A converter's resolution: to the nearest step, or downwards with every fifth code missing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quantiser {
    step: f64,
    is_worn: bool,
}

impl Quantiser {
    pub(crate) fn new(step: f64, is_worn: bool) -> Self {
        Self { step, is_worn }
    }

    fn output(self, x: f64) -> f64 {
        if !self.is_worn {
            return self.step * (x / self.step).round();
        }
        let code = (x / self.step).floor();
        let code = if code.rem_euclid(5.0) == 3.0 { code - 1.0 } else { code };
        // Half a step up, or the gain group would hide a mean of half a step.
        self.step * (code + 0.5)
    }
}

impl Block for Quantiser {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.output(x)
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        self.output(x)
    }
}

/// White noise beside the sensor's own.
#[derive(Clone, Debug)]
pub(crate) struct White {
    level: f64,
    random: Random,
}

impl White {
    /// Of the standard deviation `level` in µm.
    pub(crate) fn new(level: f64, random: Random) -> Self {
        Self { level, random }
    }
}

impl Block for White {
    fn rest(&mut self, x: f64, _tick: &Tick) -> f64 {
        x + self.level * self.random.normal()
    }
    fn step(&mut self, x: f64, _tick: &Tick) -> f64 {
        x + self.level * self.random.normal()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rms(block: &mut dyn Block, n: usize, period: f64) -> f64 {
        let tick = |k: usize| Tick { time: k as f64 * period, ..Tick::default() };
        block.rest(0.0, &tick(0));
        let sum: f64 = (1..=n).map(|k| block.step(0.0, &tick(k)).powi(2)).sum();
        (sum / n as f64).sqrt()
    }

    #[test]
    fn hum_has_the_power_of_its_lines() {
        let mut hum = Hum::new(2.0, 0.5, 50.0, &mut Random::new(3, &[]));
        let exact = (2.0_f64.powi(2) / 2.0 + 1.0 / 2.0).sqrt();
        assert!((rms(&mut hum, 4000, 1e-3) / exact - 1.0).abs() < 1e-9);
    }

    #[test]
    fn rounding_has_the_power_of_a_uniform_error() {
        let q = 0.7;
        for worn in [false, true] {
            let quantiser = Quantiser::new(q, worn);
            let n = 100_000;
            let error = (0..n).map(|k| {
                let x = f64::from(k) * 1e-3;
                (quantiser.output(x) - x).powi(2)
            });
            let rms = (error.sum::<f64>() / f64::from(n)).sqrt();
            // Nearest: q²/12. Worn: one code in five is off by a whole step more.
            let exact = if worn { q * (1.0 / 12.0 + 0.2_f64).sqrt() } else { q / 12.0_f64.sqrt() };
            assert!((rms / exact - 1.0).abs() < 0.01, "{rms} {exact}");
        }
    }

    #[test]
    fn a_walk_spreads_with_the_root_of_time() {
        let spread = |n: usize| {
            let ends = (0..400).map(|seed| {
                let mut walk = Walk::new(1.0, Random::new(seed, &[]), 1e-3);
                (0..n).fold(0.0, |_, _| walk.step(0.0, &Tick::default())).powi(2)
            });
            (ends.sum::<f64>() / 400.0).sqrt()
        };
        // Standard error of a spread from 400 draws: 3.5 %.
        assert!((spread(1000) - 1.0).abs() < 0.12, "{}", spread(1000));
        assert!((spread(250) - 0.5).abs() < 0.06);
    }

    #[test]
    fn coupling_reaches_the_same_end_at_once_or_slowly() {
        let tick = |neighbour| Tick { neighbour, ..Tick::default() };
        let mut prompt = Coupling::prompt(0.01);
        let mut slow = Coupling::slow(0.01, 2e-3, (200.0, 0.05), 1e-4);
        prompt.rest(1.0, &tick(0.0));
        slow.rest(1.0, &tick(0.0));
        assert_eq!(prompt.step(1.0, &tick(50.0)), 1.5);
        assert!((slow.step(1.0, &tick(50.0)) - 1.0).abs() < 0.01);
        let end = (0..20_000).fold(0.0, |_, _| slow.step(1.0, &tick(50.0)));
        assert!((end - 1.5).abs() < 1e-9);
    }
}

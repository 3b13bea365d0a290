//! Late commands.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::{Block, Tick};

/// A line of past inputs, one per period; the newest first.
#[derive(Clone, Debug)]
struct Line(VecDeque<f64>);

impl Line {
    fn new(longest: f64) -> Self {
        Self(VecDeque::from(vec![0.0; longest.max(0.0).ceil() as usize + 2]))
    }

    fn push(&mut self, x: f64) {
        self.0.pop_back();
        self.0.push_front(x);
    }

    /// The mean over a period of the held signal, `periods` late.
    fn late(&self, periods: f64) -> f64 {
        let integer = periods.max(0.0).floor();
        let part = periods.max(0.0) - integer;
        let get = |i: usize| self.0.get(i).or(self.0.back()).copied().unwrap_or(0.0);
        (1.0 - part) * get(integer as usize) + part * get(integer as usize + 1)
    }
}

/// A constant delay.
#[derive(Clone, Debug)]
pub(crate) struct Delay {
    line: Line,
    periods: f64,
}

impl Delay {
    /// A delay in s.
    pub(crate) fn new(seconds: f64, period: f64) -> Self {
        let periods = seconds / period;
        Self { line: Line::new(periods), periods }
    }
}

impl Block for Delay {
    fn rest(&mut self, u: f64, _tick: &Tick) -> f64 {
        self.line.0.iter_mut().for_each(|x| *x = u);
        u
    }
    fn step(&mut self, u: f64, _tick: &Tick) -> f64 {
        self.line.push(u);
        self.line.late(self.periods)
    }
}

/// A delay that a bus with a beat causes: `T·(1 + 0.3 sin 2πft)`.
#[derive(Clone, Debug)]
pub(crate) struct VaryingDelay {
    line: Line,
    periods: f64,
    hz: f64,
}

impl VaryingDelay {
    /// The mean in s and the frequency of the beat in Hz.
    pub(crate) fn new(seconds: f64, hz: f64, period: f64) -> Self {
        let periods = seconds / period;
        Self { line: Line::new(1.3 * periods), periods, hz }
    }
}

impl Block for VaryingDelay {
    fn rest(&mut self, u: f64, _tick: &Tick) -> f64 {
        self.line.0.iter_mut().for_each(|x| *x = u);
        u
    }
    fn step(&mut self, u: f64, tick: &Tick) -> f64 {
        self.line.push(u);
        self.line.late(self.periods * (1.0 + 0.3 * (TAU * self.hz * tick.time).sin()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_comes_late_by_the_delay() {
        let tick = Tick::default();
        let mut delay = Delay::new(2.25e-3, 1e-3);
        delay.rest(0.0, &tick);
        for k in 1..20 {
            let y = delay.step(f64::from(k), &tick);
            let expected = (f64::from(k) - 2.25).max(0.0);
            assert!(k < 4 || (y - expected).abs() < 1e-12, "{k}: {y}");
        }
        let mut none = Delay::new(0.0, 1e-3);
        none.rest(0.0, &tick);
        assert_eq!(none.step(3.0, &tick), 3.0);
    }

    #[test]
    fn a_varying_delay_swings_about_its_mean() {
        let mut delay = VaryingDelay::new(5e-3, 4.0, 1e-3);
        delay.rest(0.0, &Tick::default());
        let late: Vec<f64> = (1..1000)
            .map(|k| {
                let time = f64::from(k) * 1e-3;
                f64::from(k) - delay.step(f64::from(k), &Tick { time, ..Tick::default() })
            })
            .skip(20)
            .collect();
        let (low, high) =
            late.iter().fold((9e9, 0.0), |(l, h): (f64, f64), x| (l.min(*x), h.max(*x)));
        assert!((low - 3.5).abs() < 0.05 && (high - 6.5).abs() < 0.05, "{low} {high}");
    }
}

//! Linear blocks, discretised exactly for an input that is held.

use std::f64::consts::TAU;

use super::{Block, Tick};

/// First-order lags in series, each `τ y′ + y = x`.
#[derive(Clone, Debug)]
pub(crate) struct Lags {
    fraction: f64,
    state: Vec<f64>,
}

impl Lags {
    /// `count` lags of the time constant `tau` in s.
    pub(crate) fn new(tau: f64, count: usize, period: f64) -> Self {
        let fraction = if tau > 0.0 { -(-period / tau).exp_m1() } else { 1.0 };
        Self { fraction, state: vec![0.0; count] }
    }

    /// One lag of a bandwidth in Hz.
    pub(crate) fn of_bandwidth(hz: f64, period: f64) -> Self {
        Self::new(1.0 / (TAU * hz), 1, period)
    }

    pub(crate) fn set(&mut self, value: f64) {
        self.state.fill(value);
    }

    pub(crate) fn follow(&mut self, input: f64) -> f64 {
        let mut x = input;
        for y in &mut self.state {
            *y += self.fraction * (x - *y);
            x = *y;
        }
        x
    }
}

impl Block for Lags {
    fn rest(&mut self, input: f64, _tick: &Tick) -> f64 {
        self.set(input);
        input
    }
    fn step(&mut self, input: f64, _tick: &Tick) -> f64 {
        self.follow(input)
    }
}

/// `x″ + 2ζω x′ + ω² x = ω² u` with ζ < 1, by the matrix exponential.
#[derive(Clone, Debug)]
pub(crate) struct Mode {
    /// Rows of exp(A·period) for the state (x, x′/ω).
    matrix: [[f64; 2]; 2],
    /// Deviation from the input, and rate over ω.
    state: [f64; 2],
    input: f64,
}

impl Mode {
    /// A mode of this frequency in Hz and this damping ratio; `period` in s.
    pub(crate) fn new(frequency: f64, damping: f64, period: f64) -> Self {
        Self { matrix: transition(frequency, damping, period), state: [0.0; 2], input: 0.0 }
    }

    pub(crate) fn set(&mut self, x: f64) {
        (self.state, self.input) = ([0.0; 2], x);
    }

    /// Speed over ω.
    pub(crate) fn rate(&self) -> f64 {
        self.state[1]
    }

    pub(crate) fn follow(&mut self, input: f64) -> f64 {
        let e = self.state[0] + self.input - input;
        let [a, b] = self.matrix;
        self.state = [a[0] * e + a[1] * self.state[1], b[0] * e + b[1] * self.state[1]];
        self.input = input;
        self.state[0] + input
    }
}

/// exp(A·period) of `e″ + 2ζω e′ + ω² e = 0` for the state (e, e′/ω): by scaling and squaring of a
/// Taylor series, valid for every damping.
fn transition(frequency: f64, damping: f64, period: f64) -> [[f64; 2]; 2] {
    let angle = TAU * frequency * period;
    let halvings = (angle * (1.0 + 2.0 * damping) * 16.0).max(1.0).log2().ceil() as i32;
    let scale = angle / 2.0_f64.powi(halvings);
    let a = [[0.0, scale], [-scale, -2.0 * damping * scale]];
    let mut sum = [[1.0, 0.0], [0.0, 1.0]];
    let mut term = sum;
    for k in 1..14 {
        term = product(&term, &a).map(|row| row.map(|x| x / f64::from(k)));
        for (row, add) in sum.iter_mut().zip(term) {
            row[0] += add[0];
            row[1] += add[1];
        }
    }
    for _ in 0..halvings {
        sum = product(&sum, &sum);
    }
    sum
}

fn product(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    a.map(|row| [row[0] * b[0][0] + row[1] * b[1][0], row[0] * b[0][1] + row[1] * b[1][1]])
}

impl Block for Mode {
    fn rest(&mut self, input: f64, _tick: &Tick) -> f64 {
        self.set(input);
        input
    }
    fn step(&mut self, input: f64, _tick: &Tick) -> f64 {
        self.follow(input)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_answers_a_step_with_the_closed_form() {
        let (f, zeta, h) = (300.0, 0.04, 1.0 / 4000.0);
        let mut mode = Mode::new(f, zeta, h);
        mode.set(0.0);
        let (w, d) = (TAU * f, f64::sqrt(1.0 - zeta * zeta));
        for n in 1..200 {
            let t = f64::from(n) * h;
            let (s, c) = (w * d * t).sin_cos();
            let exact = 1.0 - (-zeta * w * t).exp() * (c + zeta / d * s);
            assert!((mode.follow(1.0) - exact).abs() < 1e-12, "step {n}");
        }
    }

    #[test]
    fn lags_in_series_answer_a_step_with_the_erlang_distribution() {
        let (tau, h) = (2e-3, 1e-6);
        let mut lags = Lags::new(tau, 3, h);
        lags.set(0.0);
        for n in 1..=10_000 {
            let y = lags.follow(1.0);
            let s = f64::from(n) * h / tau;
            let exact = 1.0 - (-s).exp() * (1.0 + s + s * s / 2.0);
            // The lags step one after the other, so each takes its input a period early.
            assert!((y - exact).abs() < 2.0 * h / tau, "step {n}: {y} {exact}");
        }
    }
}

//! The servo of an emulated instrument: a PID law with two notch filters, once per servo cycle.
//!
//! ```text
//! u = u₀ + [p·e + i·Σe + d·(e − e₋)] / g,  notches behind it
//! N(s) = (s² + 2·z·ω·s + ω²) / (s² + 2·q·ω·s + ω²),  bilinear, ω kept
//! ```
//!
//! g is the static gain of the stage, e the target minus the position. The integral stays within the voltages.

use core::f64::consts::PI;

/// A notch filter: off at frequency 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::emulate) struct Notch {
    /// In Hz.
    pub(super) frequency: f64,
    /// Damping ratio z of the zeros.
    pub(super) zeros: f64,
    /// Damping ratio q of the poles.
    pub(super) poles: f64,
    /// Numerator and denominator without the leading 1.
    numerator: [f64; 3],
    denominator: [f64; 2],
    state: [f64; 2],
}

impl Notch {
    /// A notch at rest at a value.
    pub(super) fn new([frequency, zeros, poles]: [f64; 3], period: f64, value: f64) -> Self {
        let k = (PI * frequency * period).tan();
        let norm = 1.0 / (1.0 + 2.0 * poles * k + k * k);
        let numerator =
            [1.0 + 2.0 * zeros * k + k * k, 2.0 * (k * k - 1.0), 1.0 - 2.0 * zeros * k + k * k]
                .map(|c| c * norm);
        let denominator = [2.0 * (k * k - 1.0), 1.0 - 2.0 * poles * k + k * k].map(|c| c * norm);
        let mut notch = Notch { frequency, zeros, poles, numerator, denominator, state: [0.0; 2] };
        notch.rest(value);
        notch
    }

    fn rest(&mut self, value: f64) {
        let [b0, _, b2] = self.numerator;
        self.state = [(1.0 - b0) * value, (b2 - self.denominator[1]) * value];
    }

    fn step(&mut self, x: f64) -> f64 {
        if self.frequency <= 0.0 {
            return x;
        }
        let ([b0, b1, b2], [a1, a2]) = (self.numerator, self.denominator);
        let y = b0 * x + self.state[0];
        self.state = [b1 * x - a1 * y + self.state[1], b2 * x - a2 * y];
        y
    }
}

/// The law of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::emulate) struct Servo {
    pub(super) proportional: f64,
    /// Per cycle.
    pub(super) integral: f64,
    /// In cycles.
    pub(super) derivative: f64,
    pub(super) notches: [Notch; 2],
    /// u₀ and the integral, in V.
    sum: f64,
    last: f64,
}

impl Servo {
    pub(super) fn new(integral: f64) -> Self {
        Servo { integral, ..Servo::default() }
    }

    /// Takes over at a voltage and an error.
    pub(super) fn rest(&mut self, volts: f64, error: f64) {
        (self.sum, self.last) = (volts, error);
        self.notches.iter_mut().for_each(|notch| notch.rest(volts));
    }

    /// One cycle: the voltage.
    pub(super) fn step(&mut self, error: f64, gain: f64, [least, greatest]: [f64; 2]) -> f64 {
        self.sum = (self.sum + self.integral * error / gain).clamp(least, greatest);
        let fast = self.proportional * error + self.derivative * (error - self.last);
        self.last = error;
        let volts = self.notches.iter_mut().fold(self.sum + fast / gain, |u, notch| notch.step(u));
        volts.clamp(least, greatest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_notch_takes_out_its_frequency_and_keeps_rest() {
        let period = 1e-3;
        for [zeros, poles] in [[0.05, 1.0], [0.0, 0.3]] {
            let mut notch = Notch::new([80.0, zeros, poles], period, 2.0);
            let sine = |k: usize, f: f64| (2.0 * PI * f * k as f64 * period).sin();
            assert!((notch.step(2.0) - 2.0).abs() < 1e-12);
            let mut peak = |f: f64| {
                let all: Vec<f64> = (0..4000).map(|k| notch.step(sine(k, f))).collect();
                all[3000..].iter().fold(0.0_f64, |most, y| most.max(y.abs()))
            };
            let left = zeros / poles;
            assert!((peak(80.0) - left).abs() < 0.01, "{left}");
            assert!(peak(2.0) > 0.98);
        }
    }

    #[test]
    fn an_integrator_alone_is_a_sum_and_takes_over_without_a_jump() {
        let mut servo = Servo::new(0.03);
        servo.rest(5.0, 1.0);
        assert!((servo.step(1.0, 2.0, [0.0, 10.0]) - 5.015).abs() < 1e-12);
        assert_eq!(servo.step(1e9, 2.0, [0.0, 10.0]), 10.0);
        assert!((servo.step(-1.0, 2.0, [0.0, 10.0]) - 9.985).abs() < 1e-12, "no windup");
    }
}

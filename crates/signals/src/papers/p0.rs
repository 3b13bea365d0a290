//! P0, driving voltages of one piezo axis: two to train with, two to test with.

use std::f64::consts::PI;

use libm::{cos, exp, sin};

use crate::parameter::{DURATION, Parameter, SAMPLE_TIME};
use crate::shape::over_duration;
use crate::signal_type::{ChannelType, SignalType};

const PARAMETERS: &[Parameter] =
    &[SAMPLE_TIME.start(5e-3).max(0.1), DURATION.start(20.0).max(20.0)];

/// Training and test voltages.
pub(crate) static P0: &[SignalType] = &[
    SignalType {
        name: "p0-train-h",
        summary: "Trains the hysteresis: fixed frequency of 0.5 Hz, amplitude from 75 V down to \
                  15.4 V",
        source: "P0, section IV-B1",
        equation: "u = 75 + 75·sin(πt − 0.5π)·cos(0.0217πt)",
        parameters: PARAMETERS,
        channels: &[ChannelType::new("u", "V", 0.0, 150.0)],
        rules: &[],
        samples: over_duration,
        law: |s| vec![s.sampled(|t| 75.0 + 75.0 * sin(PI * t - 0.5 * PI) * cos(0.0217 * PI * t))],
    },
    SignalType {
        name: "p0-train-d",
        summary: "Trains the linear dynamics: full amplitude, frequency from 0.35 Hz up to 1.90 Hz",
        source: "P0, section IV-B4",
        equation: "u = 75 + 75·sin(0.7π·e^(0.05t)·t − 0.5π)",
        parameters: PARAMETERS,
        channels: &[ChannelType::new("u", "V", 0.0, 150.0)],
        rules: &[],
        samples: over_duration,
        law: |s| vec![s.sampled(|t| 75.0 + 75.0 * sin(0.7 * PI * exp(0.05 * t) * t - 0.5 * PI))],
    },
    SignalType {
        name: "p0-test-1",
        summary: "Tests with varying frequency and amplitude",
        source: "P0, section IV-B5",
        equation: "u = 75 + 75·sin(3π·e^(−0.03t)·t − 0.5π)·cos(0.55 + 0.35·cos(0.1πt))",
        parameters: PARAMETERS,
        channels: &[ChannelType::new("u", "V", 0.0, 150.0)],
        rules: &[],
        samples: over_duration,
        law: |s| vec![s.sampled(|t| 75.0 + 75.0 * carrier(t) * envelope(t))],
    },
    SignalType {
        name: "p0-test-2",
        summary: "Tests with a cubed sine, then with decaying jumps from 10 s on",
        source: "P0, section IV-B5; of the two formulas, the second holds at t = 10 s",
        equation: "u = 75 + 75·sin³(3π·e^(−0.03t)·t − 0.5π)·cos(0.55 + 0.35·cos(0.1πt)) for \
                   t < 10 s, then 75 + 32.5·sgn(sin πt)·e^(−0.1t)",
        parameters: PARAMETERS,
        channels: &[ChannelType::new("u", "V", 0.0, 150.0)],
        rules: &[],
        samples: over_duration,
        law: |s| vec![s.sampled(test_2)],
    },
];

fn carrier(t: f64) -> f64 {
    sin(3.0 * PI * exp(-0.03 * t) * t - 0.5 * PI)
}

fn envelope(t: f64) -> f64 {
    cos(0.55 + 0.35 * cos(0.1 * PI * t))
}

fn test_2(t: f64) -> f64 {
    if t < 10.0 - 1e-9 {
        let sine = carrier(t);
        75.0 + 75.0 * (sine * sine * sine) * envelope(t)
    } else {
        75.0 + 32.5 * sign_of_sin_pi(t) * exp(-0.1 * t)
    }
}

/// sgn(sin πt) for t ≥ 0, exactly 0 at whole t, where `sin` of a rounded π·t would be ±1e-15.
fn sign_of_sin_pi(t: f64) -> f64 {
    if (t - libm::round(t)).abs() < 1e-9 {
        0.0
    } else if libm::fmod(libm::floor(t), 2.0) == 0.0 {
        1.0
    } else {
        -1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(index: usize) -> Vec<f64> {
        P0[index].generate(&[]).expect("a paper's signal").channels[0].values.clone()
    }

    /// Sample at `t` seconds of a record at 5 ms.
    fn at(values: &[f64], t: f64) -> f64 {
        values[libm::round(t / 5e-3) as usize]
    }

    fn close(value: f64, expected: f64) {
        assert!((value - expected).abs() < 1e-9, "{value} instead of {expected}");
    }

    #[test]
    fn train_h_has_the_printed_amplitudes() {
        let u = values(0);
        assert_eq!(u.len(), 4000);
        close(at(&u, 0.0), 0.0);
        close(at(&u, 1.0), 75.0 + 75.0 * cos(0.0217 * PI));
        close(at(&u, 0.5), 75.0);
        // "The signal amplitude was initially 75 V and gradually decreased to 15.4 V."
        close(at(&u, 19.0), 75.0 + 75.0 * cos(0.0217 * PI * 19.0));
        let last = 75.0 * cos(0.0217 * PI * 20.0);
        assert!((last - 15.4).abs() < 0.05, "{last}");
    }

    #[test]
    fn train_d_has_the_printed_frequencies() {
        let fine = P0[1].generate(&[("sample_time", 1e-4)]).expect("a paper's signal");
        let u = &fine.channels[0].values;
        // 19.03 turns in all, hence 19 maxima.
        let maxima: Vec<usize> =
            (1..u.len() - 1).filter(|&n| u[n] > u[n - 1] && u[n] >= u[n + 1]).collect();
        assert_eq!(maxima.len(), 19);
        // "initially 0.35 Hz and gradually increased to 1.90 Hz": the curvature at the lower
        // reversal t = 0 is 75·ω², and the last two maxima lie one period apart.
        let curvature = 2.0 * (u[1] - u[0]) / 1e-8;
        let start = libm::sqrt(curvature / 75.0) / (2.0 * PI);
        assert!((start - 0.35).abs() < 1e-3, "{start}");
        let period = (maxima[18] - maxima[17]) as f64 * 1e-4;
        assert!((1.0 / period - 1.85).abs() < 0.04, "{}", 1.0 / period);
    }

    #[test]
    fn test_1_at_chosen_instants() {
        let u = values(2);
        close(at(&u, 0.0), 75.0 - 75.0 * cos(0.9));
        close(at(&u, 10.0), 75.0 + 75.0 * sin(30.0 * PI * exp(-0.3) - 0.5 * PI) * cos(0.2));
    }

    #[test]
    fn test_2_has_both_parts_and_exact_zeros_of_the_sign() {
        let (smooth, u) = (values(2), values(3));
        for t in [0.0, 1.235, 9.995] {
            let sine = (at(&smooth, t) - 75.0) / (75.0 * envelope(t));
            close(at(&u, t), 75.0 + 75.0 * sine * sine * sine * envelope(t));
        }
        for t in 10..20 {
            assert_eq!(at(&u, f64::from(t)), 75.0);
            let sign = if t % 2 == 0 { 1.0 } else { -1.0 };
            let t = f64::from(t) + 0.5;
            close(at(&u, t), 75.0 + sign * 32.5 * exp(-0.1 * t));
        }
    }
}

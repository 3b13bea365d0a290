//! Chirps between two limits.

use crate::parameter::{DURATION, HIGH, LOW, Parameter, SAMPLE_TIME};
use crate::rules::{LOW_BELOW_HIGH, carried};
use crate::shape::{over_duration, rising_cosine};
use crate::signal_type::{ChannelType, Rule, Settings, SignalType};

/// Frequency at t = 0.
pub(crate) const START_FREQUENCY: Parameter =
    Parameter::real("start_frequency", "Hz", "Frequency at t = 0.", [1.0, 1e-6, 1e6]);

/// Frequency at the end of the record.
pub(crate) const END_FREQUENCY: Parameter =
    Parameter::real("end_frequency", "Hz", "Frequency at t = duration.", [100.0, 1e-6, 1e6]);

/// Both ends of the sweep are carried by the grid.
pub(crate) const SWEEP_BELOW_NYQUIST: [Rule; 2] = [
    Rule {
        parameter: "start_frequency",
        text: "must not exceed half the sample rate, 1/(2·sample_time); lower it or sample faster",
        holds: |s| carried(s, &START_FREQUENCY),
    },
    Rule {
        parameter: "end_frequency",
        text: "must not exceed half the sample rate, 1/(2·sample_time); lower it or sample faster",
        holds: |s| carried(s, &END_FREQUENCY),
    },
];

const PARAMETERS: &[Parameter] =
    &[LOW, HIGH, START_FREQUENCY, END_FREQUENCY, SAMPLE_TIME, DURATION.start(10.0)];

const RULES: &[Rule] = &[LOW_BELOW_HIGH, SWEEP_BELOW_NYQUIST[0], SWEEP_BELOW_NYQUIST[1]];

/// Linear and logarithmic chirp.
pub(crate) static CHIRPS: &[SignalType] = &[
    SignalType {
        name: "chirp-linear",
        summary: "Sine whose frequency changes linearly in time: equal time per hertz",
        source: "general",
        equation: "u = (low + high)/2 − (high − low)/2 · cos 2π(f0·t + (f1 − f0)·t²/(2·duration))",
        parameters: PARAMETERS,
        channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
        rules: RULES,
        samples: over_duration,
        law: |s| vec![swept(s, linear_turns)],
    },
    SignalType {
        name: "chirp-logarithmic",
        summary: "Sine whose frequency changes exponentially in time: equal time per octave",
        source: "general",
        equation: "u = (low + high)/2 − (high − low)/2 · \
                   cos 2π(f0·duration/λ·(e^(λ·t/duration) − 1)), λ = ln(f1/f0)",
        parameters: PARAMETERS,
        channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
        rules: RULES,
        samples: over_duration,
        law: |s| vec![swept(s, logarithmic_turns)],
    },
];

/// A sweep with `turns(f0, f1, duration, t)` turns up to time t.
fn swept(s: &Settings, turns: fn([f64; 3], f64) -> f64) -> Vec<f64> {
    let (low, high) = (s.get(&LOW), s.get(&HIGH));
    let sweep = [s.get(&START_FREQUENCY), s.get(&END_FREQUENCY), s.get(&DURATION)];
    s.sampled(|t| rising_cosine(low, high, turns(sweep, t)))
}

/// Integral of f0 + (f1 − f0)·t/D.
pub(crate) fn linear_turns([f0, f1, duration]: [f64; 3], t: f64) -> f64 {
    (f0 + 0.5 * (f1 - f0) * t / duration) * t
}

/// Integral of f0·(f1/f0)^(t/D); `expm1` keeps it exact for nearly equal frequencies.
pub(crate) fn logarithmic_turns([f0, f1, duration]: [f64; 3], t: f64) -> f64 {
    let rate = libm::log(f1 / f0) / duration;
    if rate == 0.0 { f0 * t } else { f0 * libm::expm1(rate * t) / rate }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Central difference of the turns: the instantaneous frequency.
    fn frequency(turns: fn([f64; 3], f64) -> f64, sweep: [f64; 3], t: f64) -> f64 {
        (turns(sweep, t + 1e-4) - turns(sweep, t - 1e-4)) / 2e-4
    }

    #[test]
    fn frequencies_run_from_start_to_end() {
        let sweep = [2.0, 200.0, 10.0];
        for (t, linear, logarithmic) in [(0.0, 2.0, 2.0), (5.0, 101.0, 20.0), (10.0, 200.0, 200.0)]
        {
            assert!((frequency(linear_turns, sweep, t) - linear).abs() < 1e-5 * linear);
            assert!(
                (frequency(logarithmic_turns, sweep, t) - logarithmic).abs() < 1e-5 * logarithmic
            );
        }
    }

    #[test]
    fn a_sweep_that_stays_is_a_sine() {
        for turns in [linear_turns as fn([f64; 3], f64) -> f64, logarithmic_turns] {
            assert_eq!(turns([3.0, 3.0, 10.0], 7.0), 21.0);
        }
        let nearly = logarithmic_turns([3.0, 3.0 * (1.0 + 1e-14), 10.0], 7.0);
        assert!((nearly - 21.0).abs() < 1e-11, "{nearly}");
    }
}

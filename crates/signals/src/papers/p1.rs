//! P1, voltages at the input of the amplifier (gain 10): training A to C, tests D to G.

use std::f64::consts::PI;

use libm::{cos, exp};

use crate::parameter::{DURATION, Parameter, SAMPLE_TIME, SEED};
use crate::random::Random;
use crate::rules::{BAND_BELOW_NYQUIST, BAND_IN_ORDER, HIGHEST, LOWEST};
use crate::shape::{over_duration, rising_cosine};
use crate::signal_type::{ChannelType, Rule, Settings, SignalType};

const TOP: Parameter = Parameter::real(
    "top",
    "V",
    "Greatest value, reached at the first upper reversal; the least is 0.",
    [8.5, 1e-3, 12.0],
);

const AFTER: Parameter = Parameter::real(
    "after",
    "1",
    "Greatest reversal after the first wave, as a part of top.",
    [1.0, 0.0, 1.0],
);
const SWING: Parameter = Parameter::real(
    "swing",
    "1",
    "Least upper reversal after the first wave, as a part of the greatest; lower ones mirror it.",
    [0.5, 0.5, 1.0],
);
const BIAS: Parameter = Parameter::real(
    "bias",
    "1",
    "Exponent that favours the band's upper end; 1 is uniform.",
    [1.0, 0.1, 100.0],
);

const T: Parameter = SAMPLE_TIME.start(2e-3).max(0.02);
const PARAMETERS: &[Parameter] = &[T, DURATION];
const FIVE_VOLTS: &[ChannelType] = &[ChannelType::new("u", "V", 0.0, 5.0)];

const RANDOM_SOURCE: &str = "P1, table 2; the text gives the band only, the waveform and the numbers are assumed (at most the 8.5 V of table 3)";
const RANDOM_EQUATION: &str = "half cosine waves from 0 up, each of 1/(2f); the first two at the \
                               highest frequency, up to top and down, then f = f1 - (f1 - \
                               f0)·v^bias; upper reversals uniform in swing to 1, lower ones in 0 \
                               to 1 - swing, times after·top; v uniform in 0 to 1";
const RANDOM_RULES: &[Rule] = &[BAND_IN_ORDER, BAND_BELOW_NYQUIST];

/// Signals A to G.
pub(crate) static P1: &[SignalType] = &[
    SignalType {
        name: "p1-a",
        summary: "Training signal A: sine of 3 Hz",
        source: "P1, table 2",
        equation: "u = 2.5·sin(6πt − π/2) + 2.5",
        parameters: PARAMETERS,
        channels: FIVE_VOLTS,
        rules: &[],
        samples: over_duration,
        law: |s| vec![sine(s, 3.0)],
    },
    SignalType {
        name: "p1-b",
        summary: "Training signal B: sine of 10 Hz",
        source: "P1, table 2",
        equation: "u = 2.5·sin(20πt − π/2) + 2.5",
        parameters: PARAMETERS,
        channels: FIVE_VOLTS,
        rules: &[],
        samples: over_duration,
        law: |s| vec![sine(s, 10.0)],
    },
    SignalType {
        name: "p1-c",
        summary: "Training signal C: random sinusoid of 1 to 7 Hz (stand-in wave form)",
        source: RANDOM_SOURCE,
        equation: RANDOM_EQUATION,
        parameters: &[
            LOWEST,
            HIGHEST.start(7.0),
            TOP.start(8.1),
            AFTER.start(0.17),
            SWING,
            BIAS,
            SEED,
            T,
            DURATION,
        ],
        channels: &[ChannelType::new("u", "V", 0.0, 8.1)],
        rules: RANDOM_RULES,
        samples: over_duration,
        law: |s| vec![random_sinusoid(s)],
    },
    SignalType {
        name: "p1-d",
        summary: "Test signal D: sine of 2 Hz",
        source: "P1, table 2",
        equation: "u = 2.5·sin(4πt − π/2) + 2.5",
        parameters: PARAMETERS,
        channels: FIVE_VOLTS,
        rules: &[],
        samples: over_duration,
        law: |s| vec![sine(s, 2.0)],
    },
    SignalType {
        name: "p1-e",
        summary: "Test signal E: decaying amplitude; over 1 s the frequency falls from 1.5 to 1.25 Hz",
        source: "P1, table 2, whose 1 to 20 Hz the formula does not give",
        equation: "u = 2·e^(−0.13t)·(cos(3πt·e^(−0.09t) − 3.15) + 1)",
        parameters: PARAMETERS,
        channels: &[ChannelType::new("u", "V", 0.0, 4.0)],
        rules: &[],
        samples: over_duration,
        law: |s| vec![s.sampled(|t| decaying_wave(2.0, t))],
    },
    SignalType {
        name: "p1-f",
        summary: "Test signal F: random sinusoid of 1 to 5 Hz (stand-in wave form)",
        source: RANDOM_SOURCE,
        equation: RANDOM_EQUATION,
        parameters: &[
            LOWEST,
            HIGHEST.start(5.0),
            TOP.start(3.1),
            AFTER,
            SWING,
            BIAS,
            SEED.start(2.0),
            T,
            DURATION,
        ],
        channels: &[ChannelType::new("u", "V", 0.0, 3.1)],
        rules: RANDOM_RULES,
        samples: over_duration,
        law: |s| vec![random_sinusoid(s)],
    },
    SignalType {
        name: "p1-g",
        summary: "Test signal G: random sinusoid of 1 to 20 Hz (stand-in wave form)",
        source: RANDOM_SOURCE,
        equation: RANDOM_EQUATION,
        parameters: &[
            LOWEST,
            HIGHEST.start(20.0),
            TOP.start(7.6),
            AFTER,
            SWING.start(0.93),
            BIAS.start(8.0),
            SEED.start(3.0),
            T,
            DURATION,
        ],
        channels: &[ChannelType::new("u", "V", 0.0, 7.6)],
        rules: RANDOM_RULES,
        samples: over_duration,
        law: |s| vec![random_sinusoid(s)],
    },
];

/// 2.5 sin(2πft − π/2) + 2.5.
fn sine(s: &Settings, frequency: f64) -> Vec<f64> {
    s.sampled(|t| rising_cosine(0.0, 5.0, frequency * t))
}

/// a·e^(−0.13t)·(cos(3πt·e^(−0.09t) − 3.15) + 1), which P2 (its equation 17) trains with too.
pub(crate) fn decaying_wave(amplitude: f64, t: f64) -> f64 {
    amplitude * exp(-0.13 * t) * (cos(3.0 * PI * t * exp(-0.09 * t) - 3.15) + 1.0)
}

/// Half a wave between two reversals.
struct HalfWave {
    begin: f64,
    length: f64,
    from: f64,
    to: f64,
}

fn random_sinusoid(s: &Settings) -> Vec<f64> {
    let waves = half_waves(s);
    let mut waves = waves.iter().peekable();
    let mut values = Vec::with_capacity(s.samples());
    for n in 0..s.samples() {
        let t = n as f64 * s.sample_time();
        while waves.peek().is_some_and(|wave| t >= wave.begin + wave.length) {
            waves.next();
        }
        values.extend(
            waves.peek().map(|wave| {
                rising_cosine(wave.from, wave.to, 0.5 * (t - wave.begin) / wave.length)
            }),
        );
    }
    values
}

/// Half waves that cover the record: one wave up to the top, then random ones; each reversal's
/// numbers are drawn in the order frequency, level.
fn half_waves(s: &Settings) -> Vec<HalfWave> {
    let (top, end) = (s.get(&TOP), s.samples() as f64 * s.sample_time());
    let (lowest, highest) = (s.get(&LOWEST), s.get(&HIGHEST));
    let (after, swing, bias) = (s.get(&AFTER) * top, s.get(&SWING), s.get(&BIAS));
    let mut random = Random::new(s.get(&SEED), 0);
    let mut waves: Vec<HalfWave> = Vec::new();
    let (mut begin, mut from) = (0.0, 0.0);
    while begin <= end {
        let frequency = match waves.len() {
            0 | 1 => highest,
            _ => highest - (highest - lowest) * libm::pow(random.between(0.0, 1.0), bias),
        };
        let to = match waves.len() {
            0 => top,
            n if n.is_multiple_of(2) => after * random.between(swing, 1.0),
            _ => after * random.between(0.0, 1.0 - swing),
        };
        let length = 0.5 / frequency;
        waves.push(HalfWave { begin, length, from, to });
        (begin, from) = (begin + length, to);
    }
    waves
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(name: &str) -> &'static SignalType {
        P1.iter().find(|kind| kind.name == name).expect("a signal of P1")
    }

    fn values(name: &str, settings: &[(&str, f64)]) -> Vec<f64> {
        kind(name).generate(settings).expect("a signal").channels[0].values.clone()
    }

    #[test]
    fn every_signal_has_500_samples_of_2_ms() {
        for kind in P1 {
            let signal = kind.generate(&[]).expect("a signal");
            assert_eq!((signal.len(), signal.period), (500, 2e-3), "{}", kind.name);
        }
    }

    #[test]
    fn sines_follow_the_printed_formulas() {
        for (name, factor) in [("p1-a", 6.0), ("p1-b", 20.0), ("p1-d", 4.0)] {
            for (n, value) in values(name, &[]).iter().enumerate() {
                let t = n as f64 * 2e-3;
                let expected = 2.5 * libm::sin(factor * PI * t - PI / 2.0) + 2.5;
                assert!((value - expected).abs() < 1e-12, "{name} at {t}");
            }
        }
    }

    #[test]
    fn signal_e_at_chosen_instants() {
        let u = values("p1-e", &[]);
        assert!((u[0] - 2.0 * (cos(3.15) + 1.0)).abs() < 1e-15);
        let at_half = 2.0 * exp(-0.065) * (cos(1.5 * PI * exp(-0.045) - 3.15) + 1.0);
        assert!((u[250] - at_half).abs() < 1e-12);
    }

    #[test]
    fn half_waves_keep_the_band_and_join_without_a_step() {
        for (name, band) in [("p1-c", 1.0..=7.0), ("p1-f", 1.0..=5.0), ("p1-g", 1.0..=20.0)] {
            for seed in 0..50 {
                let given = [("seed", f64::from(seed))];
                let settings = kind(name).checked(&given).expect("settings");
                let waves = half_waves(&settings);
                assert!(waves.iter().all(|w| band.contains(&(0.5 / w.length))), "{name}");
                for pair in waves.windows(2) {
                    assert_eq!(pair[0].to, pair[1].from);
                    assert_eq!(pair[0].begin + pair[0].length, pair[1].begin);
                }
            }
        }
    }

    #[test]
    fn random_signals_start_at_zero_and_reach_their_top() {
        for (name, top) in [("p1-c", 8.1), ("p1-f", 3.1), ("p1-g", 7.6)] {
            for seed in 0..50 {
                let u = values(name, &[("seed", f64::from(seed)), ("sample_time", 1e-4)]);
                let highest = u.iter().copied().fold(0.0, f64::max);
                assert_eq!(u[0], 0.0);
                assert!(u.iter().all(|v| (0.0..=top).contains(v)), "{name}");
                // The nearest sample is at most half a sample from the reversal.
                let missed = top * 0.25 * (PI * 20.0 * 1e-4) * (PI * 20.0 * 1e-4);
                assert!(highest > top - missed, "{name}: {highest}");
            }
        }
    }
}

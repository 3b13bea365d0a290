//! P3, driving voltages behind the amplifier (gain 15): the controller alone puts out at most 10 V.
//!
//! The paper prints the same formulas for its references and keeps these within 0 to 10 µm. With
//! the stroke of 26.52 µm taken for 150 V (15 times 10 V), a volt makes 0.1768 µm: by this
//! [`Channel::scaled`](crate::Channel::scaled) turns a voltage here into the reference.

use crate::general::chirp::{
    END_FREQUENCY, START_FREQUENCY, SWEEP_BELOW_NYQUIST, logarithmic_turns,
};
use crate::parameter::{DURATION, FREQUENCY, Parameter, SAMPLE_TIME};
use crate::rules::FREQUENCY_BELOW_NYQUIST;
use crate::shape::{between, over_duration, rising_cosine, sin_turns, triangle_turns};
use crate::signal_type::{ChannelType, Settings, SignalType};

const TOP: Parameter =
    Parameter::real("top", "V", "Greatest value; the least is 0.", [30.0, 1e-3, 150.0]);
const T: Parameter = SAMPLE_TIME.start(50e-6);
const THIRTY_VOLTS: &[ChannelType] = &[ChannelType::new("u", "V", 0.0, 30.0)];

/// Training chirp and test signals.
pub(crate) static P3: &[SignalType] = &[
    SignalType {
        name: "p3-chirp",
        summary: "Trains all models: chirp from 25 to 1025 Hz, 0 to 30 V",
        source: "P3, section 2.4; the text gives neither duration nor law; 0.2 s and a logarithmic sweep are assumed: the errors of the MPI model fitted to it grow from 100 Hz to \
                 1 kHz, which a linear sweep, most of it above 500 Hz, does not give",
        equation: "u = top/2·(1 − cos 2πφ), φ = f0·duration/L·(e^(L·t/duration) − 1), L = ln(f1/f0)",
        parameters: &[
            TOP,
            START_FREQUENCY.start(25.0),
            END_FREQUENCY.start(1025.0),
            T,
            DURATION.start(0.2),
        ],
        channels: THIRTY_VOLTS,
        rules: &SWEEP_BELOW_NYQUIST,
        samples: over_duration,
        law: |s| vec![chirp(s)],
    },
    SignalType {
        name: "p3-sine",
        summary: "Sine of a frequency to choose: 100, 200, 300, 500 and 1000 Hz test the models, \
                  100 to 1000 Hz in steps of 100 Hz the control",
        source: "P3, section 2.4; the text says up to 30 V, 0 to 30 V is read from it",
        equation: "u = top/2·(1 − cos(2π·frequency·t))",
        parameters: &[FREQUENCY.start(100.0), TOP, T, DURATION.start(0.1)],
        channels: THIRTY_VOLTS,
        rules: &[FREQUENCY_BELOW_NYQUIST],
        samples: over_duration,
        law: |s| vec![sine(s)],
    },
    SignalType {
        name: "p3-two-tone",
        summary: "Tones of 120 and 180 Hz about 22.5 V, where it starts",
        source: "P3, section 2.4",
        equation: "u = 7.5·(sin(120·2πt) + sin(180·2πt)) + 22.5",
        parameters: &[T.max(2e-3), DURATION.start(0.1)],
        channels: &[ChannelType::new("u", "V", 7.5, 37.5)],
        rules: &[],
        samples: over_duration,
        law: |s| vec![tones(s, &[(7.5, 120.0), (7.5, 180.0)])],
    },
    SignalType {
        name: "p3-four-tone",
        summary: "Tones of 100, 150, 200 and 250 Hz about 22.5 V, where it starts",
        source: "P3, section 2.4",
        equation: "u = 6·sin(100·2πt) + 3·sin(150·2πt) + 3·sin(200·2πt) + 6·sin(250·2πt) + 22.5",
        parameters: &[T.max(2e-3), DURATION.start(0.1)],
        channels: &[ChannelType::new("u", "V", 4.5, 40.5)],
        rules: &[],
        samples: over_duration,
        law: |s| vec![tones(s, &[(6.0, 100.0), (3.0, 150.0), (3.0, 200.0), (6.0, 250.0)])],
    },
    SignalType {
        name: "p3-triangle",
        summary: "Triangle wave of 50 Hz, 0 to 20 V",
        source: "P3, section 2.4; the text says up to 20 V, 0 to 20 V is read from it",
        equation: "u = top·2·|x − round x|, x = frequency·t",
        parameters: &[FREQUENCY.start(50.0), TOP.start(20.0), T, DURATION.start(0.1)],
        channels: &[ChannelType::new("u", "V", 0.0, 20.0)],
        rules: &[FREQUENCY_BELOW_NYQUIST],
        samples: over_duration,
        law: |s| vec![triangle(s)],
    },
];

fn chirp(s: &Settings) -> Vec<f64> {
    let sweep = [s.get(&START_FREQUENCY), s.get(&END_FREQUENCY), s.get(&DURATION)];
    let top = s.get(&TOP);
    s.sampled(|t| rising_cosine(0.0, top, logarithmic_turns(sweep, t)))
}

fn sine(s: &Settings) -> Vec<f64> {
    let (top, frequency) = (s.get(&TOP), s.get(&FREQUENCY));
    s.sampled(|t| rising_cosine(0.0, top, frequency * t))
}

fn triangle(s: &Settings) -> Vec<f64> {
    let (top, frequency) = (s.get(&TOP), s.get(&FREQUENCY));
    s.sampled(|t| between(0.0, top, triangle_turns(frequency * t)))
}

/// 22.5 V and tones of (amplitude, frequency).
fn tones(s: &Settings, tones: &[(f64, f64)]) -> Vec<f64> {
    s.sampled(|t| 22.5 + tones.iter().map(|(a, f)| a * sin_turns(f * t)).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn values(name: &str, settings: &[(&str, f64)]) -> Vec<f64> {
        let kind = P3.iter().find(|kind| kind.name == name).expect("a signal of P3");
        kind.generate(settings).expect("a signal").channels[0].values.clone()
    }

    #[test]
    fn tones_follow_the_printed_formulas() {
        let (two, four) = (values("p3-two-tone", &[]), values("p3-four-tone", &[]));
        for n in [0, 1, 17, 333, 1999] {
            let sine = |f: f64| libm::sin(f * 2.0 * PI * n as f64 * 50e-6);
            let expected = 7.5 * (sine(120.0) + sine(180.0)) + 22.5;
            assert!((two[n] - expected).abs() < 1e-10);
            let expected = 6.0 * sine(100.0)
                + 3.0 * sine(150.0)
                + 3.0 * sine(200.0)
                + 6.0 * sine(250.0)
                + 22.5;
            assert!((four[n] - expected).abs() < 1e-10);
        }
    }

    #[test]
    fn the_triangle_turns_at_0_and_20_v() {
        let u = values("p3-triangle", &[]);
        for (n, expected) in [(0, 0.0), (100, 10.0), (200, 20.0), (300, 10.0), (400, 0.0)] {
            assert!((u[n] - expected).abs() < 1e-12, "{n}: {}", u[n]);
        }
    }

    #[test]
    fn sines_of_the_paper_are_carried() {
        for f in (100..=1000).step_by(100) {
            let u = values("p3-sine", &[("frequency", f64::from(f))]);
            let expected = 15.0 - 15.0 * libm::cos(2.0 * PI * f64::from(f) * 3.0 * 50e-6);
            assert!((u[3] - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn the_chirp_makes_as_many_turns_as_its_logarithmic_mean_frequency() {
        let u = values("p3-chirp", &[("sample_time", 1e-6)]);
        let maxima = u.windows(3).filter(|w| w[1] > w[0] && w[1] >= w[2]).count();
        // (1025 − 25) Hz / ln 41 · 0.2 s = 53.86 turns; the last maximum lies at 53.5.
        assert_eq!(maxima, 54);
    }
}

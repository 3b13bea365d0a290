//! P2, voltages at the input of the amplifier (gain 10) and the reference of the control.

use super::p1::decaying_wave;
use crate::general::chirp::{END_FREQUENCY, START_FREQUENCY, SWEEP_BELOW_NYQUIST, linear_turns};
use crate::parameter::{DURATION, Parameter, SAMPLE_TIME};
use crate::shape::{over_duration, rising_cosine, sin_turns};
use crate::signal_type::{ChannelType, Settings, SignalType};

const AMPLITUDE: Parameter =
    Parameter::real("amplitude", "V", "Amplitude about zero.", [0.5, 1e-3, 10.0]);
const TEN_VOLTS: &[ChannelType] = &[ChannelType::new("u", "V", 0.0, 10.0)];
const PARAMETERS: &[Parameter] = &[SAMPLE_TIME.start(0.02).max(0.1), DURATION.start(10.0)];

/// Sweep, training, tests and the reference of the control.
pub(crate) static P2: &[SignalType] = &[
    SignalType {
        name: "p2-sweep",
        summary: "Identifies the linear plant: swept sine of 0.5 V from 1 to 1000 Hz",
        source: "P2, section IV-B; the text gives no duration, 20 s is assumed",
        equation: "u = amplitude·sin 2π(f0·t + (f1 − f0)·t²/(2·duration))",
        parameters: &[
            AMPLITUDE,
            START_FREQUENCY,
            END_FREQUENCY.start(1000.0),
            SAMPLE_TIME.start(5e-4),
            DURATION.start(20.0),
        ],
        channels: &[ChannelType::new("u", "V", -0.5, 0.5)],
        rules: &SWEEP_BELOW_NYQUIST,
        samples: over_duration,
        law: |s| vec![sweep(s)],
    },
    SignalType {
        name: "p2-train",
        summary: "Trains all models: waves from 0 V up, of 10 V and 1.5 Hz at first, that get lower and slower",
        source: "P2, equation (17) with the bracket that the print lost: only this form spans 0 to \
                 10 V",
        equation: "u = 5·e^(−0.13t)·(cos(3πt·e^(−0.09t) − 3.15) + 1)",
        parameters: &[SAMPLE_TIME.start(0.02).max(0.1), DURATION.start(10.0).max(10.0)],
        channels: TEN_VOLTS,
        rules: &[],
        samples: over_duration,
        law: |s| vec![s.sampled(|t| decaying_wave(5.0, t))],
    },
    SignalType {
        name: "p2-test-1",
        summary: "Stand-in for test signal 1, called simple and shown as a figure only: sine of \
                  0.5 Hz over the whole range",
        source: "replaces P2, figure 4(a)",
        equation: "u = 5 − 5·cos(πt)",
        parameters: PARAMETERS,
        channels: TEN_VOLTS,
        rules: &[],
        samples: over_duration,
        law: |s| vec![s.sampled(|t| rising_cosine(0.0, 10.0, 0.5 * t))],
    },
    SignalType {
        name: "p2-test-2",
        summary: "Stand-in for test signal 2, called more complex and shown as a figure only: two \
                  tones with minor loops over the whole range",
        source: "replaces P2, figure 5(a)",
        equation: "u = 5 − 2.5·cos(0.5πt) − 2.5·cos(2.5πt)",
        parameters: PARAMETERS,
        channels: TEN_VOLTS,
        rules: &[],
        samples: over_duration,
        law: |s| {
            let tone = |turns| rising_cosine(0.0, 5.0, turns);
            vec![s.sampled(|t| tone(0.25 * t) + tone(1.25 * t))]
        },
    },
    SignalType {
        name: "p2-control",
        summary: "Reference of the control: sine of 2 Hz over 136 µm, from rest",
        source: "P2, section V-A; the text gives 2 Hz, and errors in µm and percent that fit a \
                 range of 136 µm; offset and 2 s are assumed",
        equation: "r = 68 + 68·sin(4πt − π/2)",
        parameters: &[SAMPLE_TIME.start(4e-3).max(0.05), DURATION.start(2.0)],
        channels: &[ChannelType::new("r", "um", 0.0, 136.0)],
        rules: &[],
        samples: over_duration,
        law: |s| vec![s.sampled(|t| rising_cosine(0.0, 136.0, 2.0 * t))],
    },
];

fn sweep(s: &Settings) -> Vec<f64> {
    let sweep = [s.get(&START_FREQUENCY), s.get(&END_FREQUENCY), s.get(&DURATION)];
    let amplitude = s.get(&AMPLITUDE);
    s.sampled(|t| amplitude * sin_turns(linear_turns(sweep, t)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(name: &str) -> Vec<f64> {
        let kind = P2.iter().find(|kind| kind.name == name).expect("a signal of P2");
        kind.generate(&[]).expect("a signal").channels[0].values.clone()
    }

    #[test]
    fn the_training_signal_spans_0_to_10_v() {
        let u = values("p2-train");
        assert_eq!(u.len(), 500);
        assert!(u.iter().all(|v| (0.0..10.0).contains(v)));
        let highest = u.iter().copied().fold(0.0, f64::max);
        // The first maximum at t ≈ 0.34 s has lost 4 % by the decay.
        assert!((9.0..10.0).contains(&highest), "{highest}");
        let t: f64 = 3.0;
        let expected = 5.0
            * libm::exp(-0.39)
            * (libm::cos(9.0 * std::f64::consts::PI * libm::exp(-0.27) - 3.15) + 1.0);
        assert!((u[(t / 0.02).round() as usize] - expected).abs() < 1e-12);
    }

    #[test]
    fn the_tests_span_0_to_10_v() {
        let (one, two) = (values("p2-test-1"), values("p2-test-2"));
        assert_eq!((one.len(), two.len()), (500, 500));
        assert_eq!((one[0], one[50], two[0], two[100]), (0.0, 10.0, 0.0, 10.0));
        // Minor loops: more reversals than the slow tone has.
        let reversals = two.windows(3).filter(|w| (w[1] - w[0]) * (w[2] - w[1]) < 0.0).count();
        assert!(reversals > 15, "{reversals}");
    }

    #[test]
    fn the_reference_has_2_hz_and_136_um() {
        use std::f64::consts::PI;
        let r = values("p2-control");
        assert_eq!((r.len(), r[0]), (500, 0.0));
        for n in [25, 62, 499] {
            let t = n as f64 * 4e-3;
            let expected = 68.0 + 68.0 * libm::sin(4.0 * PI * t - PI / 2.0);
            assert!((r[n] - expected).abs() < 1e-11);
        }
    }
}

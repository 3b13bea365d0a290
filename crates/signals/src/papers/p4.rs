//! P4, loops of one axis and references of the tool's ellipse.

use crate::general::ellipse::{CENTRE, EQUATION, INCLINATION, RULES, SEMI_AXES, START, ellipse};
use crate::parameter::{DURATION, FREQUENCY, Parameter, SAMPLE_TIME};
use crate::rules::FREQUENCY_BELOW_NYQUIST;
use crate::shape::{over_duration, rising_cosine};
use crate::signal_type::{ChannelType, Settings, SignalType};

const TOP: Parameter =
    Parameter::real("top", "V", "Greatest value; the least is 0.", [120.0, 1e-3, 150.0]);

/// Loops and ellipses.
pub(crate) static P4: &[SignalType] = &[
    SignalType {
        name: "p4-loop-1hz",
        summary: "Loop of 0 to 120 V at 1 Hz: fits the static model",
        parameters: &loop_parameters(1.0),
        ..LOOP
    },
    SignalType {
        name: "p4-loop-10hz",
        summary: "Loop of 0 to 120 V at 10 Hz: fits and tests the dynamic model",
        parameters: &loop_parameters(10.0),
        ..LOOP
    },
    SignalType {
        name: "p4-loop-50hz",
        summary: "Loop of 0 to 120 V at 50 Hz: fits the dynamic model",
        parameters: &loop_parameters(50.0),
        ..LOOP
    },
    SignalType {
        name: "p4-loop-100hz",
        summary: "Loop of 0 to 120 V at 100 Hz: fits and tests the dynamic model",
        parameters: &loop_parameters(100.0),
        ..LOOP
    },
    SignalType {
        name: "p4-ellipse",
        summary: "Reference of the tool within what 120 V reach: Y 1 to 5 µm, Z 1 to 8 µm",
        source: "replaces P4, section 4, case 2, whose Z of 9 µm is over the 8.87 µm of tables \
                 2 and 3 at 120 V",
        parameters: &ellipse_parameters(20.0, [3.0, 4.5], REACHABLE),
        channels: &[ChannelType::new("y", "um", 0.0, 5.0), ChannelType::new("z", "um", 0.0, 8.0)],
        ..TOOL
    },
    SignalType {
        name: "p4-ellipse-case-1",
        summary: "Reference of the tool, case 1: upright, Y 1 to 6 µm, Z 1 to 11 µm",
        source: "P4, section 4, case 1; by tables 2 and 3 it takes 120.7 V (Y) and 147.6 V (Z)",
        parameters: &ellipse_parameters(0.0, [3.5, 6.0], [5.0, 2.5]),
        channels: &[ChannelType::new("y", "um", 0.0, 6.0), ChannelType::new("z", "um", 0.0, 11.0)],
        ..TOOL
    },
    SignalType {
        name: "p4-ellipse-case-2",
        summary: "Reference of the tool, case 2: inclined by 20 deg, Y 1 to 5 µm, Z 1 to 9 µm",
        source: "P4, section 4, case 2; by tables 2 and 3, Z takes more than 120 V",
        parameters: &ellipse_parameters(20.0, [3.0, 5.0], CASE_2),
        channels: &[ChannelType::new("y", "um", 0.0, 5.0), ChannelType::new("z", "um", 0.0, 9.0)],
        ..TOOL
    },
];

/// What the loops share.
const LOOP: SignalType = SignalType {
    name: "",
    summary: "",
    source: "P4, sections 2.1 and 2.3; the text gives no sample time, 1000 samples a period and \
             three periods (the first starts from the virgin curve) are assumed",
    equation: "u = top/2·(1 − cos(2π·frequency·t))",
    parameters: &[],
    channels: &[ChannelType::new("u", "V", 0.0, 120.0)],
    rules: &[FREQUENCY_BELOW_NYQUIST],
    samples: over_duration,
    law: hysteresis_loop,
};

/// What the ellipses share.
const TOOL: SignalType = SignalType {
    name: "",
    summary: "",
    source: "",
    equation: EQUATION,
    parameters: &[],
    channels: &[],
    rules: RULES,
    samples: over_duration,
    law: ellipse,
};

/// Semi-axes a, b in µm of the ellipse inclined by i = 20° that spans Y 1 to 5 and Z 1 to 8 µm,
/// from the half spans h: a², b² = ((h_z² + h_y²) ± (h_z² − h_y²)/cos 2i)/2.
const REACHABLE: [f64; 2] = [3.675_568_672_803_659, 1.655_353_415_891_709_4];
/// Semi-axes in µm of such an ellipse that spans Y 1 to 5 and Z 1 to 9 µm.
const CASE_2: [f64; 2] = [4.222_847_822_973_694, 1.472_262_294_567_896_7];

const fn loop_parameters(frequency: f64) -> [Parameter; 4] {
    [
        FREQUENCY.start(frequency),
        TOP,
        SAMPLE_TIME.start(1e-3 / frequency),
        DURATION.start(3.0 / frequency),
    ]
}

const fn ellipse_parameters(
    inclination: f64,
    [centre_y, centre_z]: [f64; 2],
    [long, short]: [f64; 2],
) -> [Parameter; 9] {
    [
        INCLINATION.start(inclination),
        CENTRE[0].start(centre_y),
        CENTRE[1].start(centre_z),
        SEMI_AXES[0].start(long),
        SEMI_AXES[1].start(short),
        FREQUENCY.start(100.0),
        START,
        SAMPLE_TIME.start(20e-6),
        DURATION.start(0.2),
    ]
}

fn hysteresis_loop(s: &Settings) -> Vec<Vec<f64>> {
    let (top, frequency) = (s.get(&TOP), s.get(&FREQUENCY));
    vec![s.sampled(|t| rising_cosine(0.0, top, frequency * t))]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(name: &str) -> &'static SignalType {
        P4.iter().find(|kind| kind.name == name).expect("a signal of P4")
    }

    #[test]
    fn semi_axes_follow_from_the_spans() {
        let cos = libm::cos(40.0 * std::f64::consts::PI / 180.0);
        for (axes, [y, z]) in [(REACHABLE, [2.0, 3.5]), (CASE_2, [2.0, 4.0])] {
            let (sum, difference) = (z * z + y * y, (z * z - y * y) / cos);
            assert!((axes[0] - libm::sqrt(0.5 * (sum + difference))).abs() < 1e-14);
            assert!((axes[1] - libm::sqrt(0.5 * (sum - difference))).abs() < 1e-14);
        }
    }

    #[test]
    fn ellipses_span_what_the_paper_says() {
        for (name, [y, z]) in [
            ("p4-ellipse", [[1.0, 5.0], [1.0, 8.0]]),
            ("p4-ellipse-case-1", [[1.0, 6.0], [1.0, 11.0]]),
            ("p4-ellipse-case-2", [[1.0, 5.0], [1.0, 9.0]]),
        ] {
            let signal = kind(name).generate(&[("sample_time", 1e-6)]).expect("an ellipse");
            for (channel, [low, high]) in signal.channels.iter().zip([y, z]) {
                let settled = channel.values[50_000..].to_vec();
                let settled = crate::Channel { values: settled, ..channel.clone() };
                // 10 000 samples a period: the nearest lies within 1e-7 of the extreme.
                assert!((settled.minimum() - low).abs() < 1e-6, "{name}: {}", settled.minimum());
                assert!((settled.maximum() - high).abs() < 1e-6, "{name}: {}", settled.maximum());
                assert!(channel.minimum() >= 0.0 && channel.maximum() <= high + 1e-12);
            }
        }
    }

    #[test]
    fn loops_have_three_periods_of_1000_samples_from_0_to_120_v() {
        for (name, frequency) in [
            ("p4-loop-1hz", 1.0),
            ("p4-loop-10hz", 10.0),
            ("p4-loop-50hz", 50.0),
            ("p4-loop-100hz", 100.0),
        ] {
            let signal = kind(name).generate(&[]).expect("a loop");
            let u = &signal.channels[0].values;
            assert_eq!(signal.len(), 3000);
            assert!((signal.duration() * frequency - 3.0).abs() < 1e-12);
            for period in 0..3 {
                assert!(u[1000 * period].abs() < 1e-9);
                assert!((u[1000 * period + 500] - 120.0).abs() < 1e-9);
                assert!((u[1000 * period + 250] - 60.0).abs() < 1e-9);
            }
        }
    }
}

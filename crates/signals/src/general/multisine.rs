//! Multisines: sums of cosines on the lines of one period, with random phases.

use std::f64::consts::PI;

use crate::parameter::{HIGH, LOW, Parameter, SAMPLE_TIME, SEED};
use crate::random::Random;
use crate::rules::{BAND_BELOW_NYQUIST, BAND_IN_ORDER, HIGHEST, LOW_BELOW_HIGH, LOWEST};
use crate::signal_type::{ChannelType, Rule, Settings, SignalType};

const SAMPLES_PER_PERIOD: Parameter = Parameter::integer(
    "samples_per_period",
    "Samples N of one period; the lines lie at k/(N·sample_time).",
    [4000, 4, 100_000],
);
const PERIODS: Parameter = Parameter::integer(
    "periods",
    "Number of equal periods; leave out the first ones until the plant is in steady state.",
    [3, 1, 100_000],
);
const GROUP: Parameter = Parameter::integer(
    "group",
    "Size of the groups of neighbouring odd lines of which one each is left out at random.",
    [4, 2, 1000],
);

/// Stream of the phases, the same for all kinds.
const PHASES: u64 = 0;
/// Stream of the choice of lines that are left out.
const LEFT_OUT: u64 = 1;

/// Start values of the band: lines of 2.5 Hz from 2.5 Hz to 1 kHz.
const BAND: [Parameter; 2] = [LOWEST.start(2.5), HIGHEST.start(1000.0)];

const PARAMETERS: &[Parameter] =
    &[LOW, HIGH, BAND[0], BAND[1], SAMPLES_PER_PERIOD, PERIODS, SEED, SAMPLE_TIME.start(1e-4)];

const NO_LINE: &str = "leaves no line of the kind in the band: lines lie at \
                       k/(samples_per_period·sample_time), below half the sample rate; \
                       widen the band or take more samples per period";

const EQUATION: &str = "u = (low + high)/2 + c·Σ_k cos(2πk·n/N + φ_k), c such that max|u − mean| = \
                        (high − low)/2";

/// Full, odd and odd-random multisine.
pub(crate) static MULTISINES: &[SignalType] = &[
    SignalType {
        name: "multisine",
        summary: "Random-phase multisine: every line of a band with the same amplitude",
        source: "general; Pintelon and Schoukens, System Identification, 2012, ch. 5",
        equation: EQUATION,
        parameters: PARAMETERS,
        channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
        rules: &[
            LOW_BELOW_HIGH,
            BAND_IN_ORDER,
            BAND_BELOW_NYQUIST,
            Rule {
                parameter: "highest_frequency",
                text: NO_LINE,
                holds: |s| !band_lines(s, 1).is_empty() || !(BAND_IN_ORDER.holds)(s),
            },
        ],
        samples,
        law: |s| vec![multisine(s, &band_lines(s, 1))],
    },
    SignalType {
        name: "multisine-odd",
        summary: "Random-phase multisine of odd lines only: even distortions fall on empty lines",
        source: "general; Pintelon and Schoukens, System Identification, 2012, ch. 5",
        equation: EQUATION,
        parameters: PARAMETERS,
        channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
        rules: &[
            LOW_BELOW_HIGH,
            BAND_IN_ORDER,
            BAND_BELOW_NYQUIST,
            Rule {
                parameter: "highest_frequency",
                text: NO_LINE,
                holds: |s| !band_lines(s, 2).is_empty() || !(BAND_IN_ORDER.holds)(s),
            },
        ],
        samples,
        law: |s| vec![multisine(s, &band_lines(s, 2))],
    },
    SignalType {
        name: "multisine-odd-random",
        summary: "Odd multisine with one line of each group left out at random: odd distortions \
                  fall on the odd empty lines, even ones on the even",
        source: "general; Pintelon and Schoukens, System Identification, 2012, ch. 5",
        equation: EQUATION,
        parameters: &[
            LOW,
            HIGH,
            BAND[0],
            BAND[1],
            GROUP,
            SAMPLES_PER_PERIOD,
            PERIODS,
            SEED,
            SAMPLE_TIME.start(1e-4),
        ],
        channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
        rules: &[
            LOW_BELOW_HIGH,
            BAND_IN_ORDER,
            BAND_BELOW_NYQUIST,
            Rule {
                parameter: "group",
                text: "is more than the odd lines in the band, so none would be left out; take \
                       smaller groups, a wider band or more samples per period",
                holds: |s| band_lines(s, 2).len() >= s.count(&GROUP) || !(BAND_IN_ORDER.holds)(s),
            },
        ],
        samples,
        law: |s| vec![multisine(s, &odd_random_lines(s))],
    },
];

fn samples(s: &Settings) -> f64 {
    s.get(&SAMPLES_PER_PERIOD) * s.get(&PERIODS)
}

/// Lines of the band from the first one, every `stride`-th from 1, below half the sample rate (the
/// line at half the sample rate has no phase).
fn band_lines(s: &Settings, stride: usize) -> Vec<usize> {
    let count = s.count(&SAMPLES_PER_PERIOD);
    let period = count as f64 * s.sample_time();
    let first = libm::ceil(s.get(&LOWEST) * period * (1.0 - 1e-12)) as usize;
    let last = libm::floor(s.get(&HIGHEST) * period * (1.0 + 1e-12)) as usize;
    let last = last.min((count - 1) / 2);
    (1..=last).step_by(stride).filter(|&k| k >= first).collect()
}

/// Odd lines without one of each full group.
fn odd_random_lines(s: &Settings) -> Vec<usize> {
    let mut random = Random::new(s.get(&SEED), LEFT_OUT);
    let group = s.count(&GROUP);
    let mut lines = Vec::new();
    for neighbours in band_lines(s, 2).chunks(group) {
        let left_out = if neighbours.len() == group { random.below(group) } else { group };
        lines.extend(
            neighbours.iter().enumerate().filter(|&(at, _)| at != left_out).map(|(_, &k)| k),
        );
    }
    lines
}

/// The periods of a multisine with these lines, scaled to the limits.
fn multisine(s: &Settings, lines: &[usize]) -> Vec<f64> {
    let (low, high) = (s.get(&LOW), s.get(&HIGH));
    let sum = one_period(s.count(&SAMPLES_PER_PERIOD), lines, s.get(&SEED));
    let peak = sum.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let (mean, half) = (0.5 * (low + high), 0.5 * (high - low));
    let scale = |x: &f64| (mean + half * (x / peak)).clamp(low, high);
    let period: Vec<f64> = sum.iter().map(scale).collect();
    period.repeat(s.count(&PERIODS))
}

/// Σ cos(2πk·n/N + φ_k) over one period. The angles are whole multiples of 2π/N, so one table of
/// the circle serves all lines and no rounding builds up along the record.
fn one_period(count: usize, lines: &[usize], seed: f64) -> Vec<f64> {
    let angle = |n: usize| 2.0 * PI * n as f64 / count as f64;
    let circle: Vec<(f64, f64)> = (0..count).map(|n| libm::sincos(angle(n))).collect();
    let mut random = Random::new(seed, PHASES);
    let mut sum = vec![0.0; count];
    for &line in lines {
        let (sin_phase, cos_phase) = libm::sincos(random.between(0.0, 2.0 * PI));
        let mut at = 0;
        for value in &mut sum {
            if let Some((sin, cos)) = circle.get(at) {
                *value += cos_phase * cos - sin_phase * sin;
            }
            at += line;
            if at >= count {
                at -= count;
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(name: &str, given: &[(&str, f64)]) -> Settings {
        let kind = MULTISINES.iter().find(|kind| kind.name == name).expect("a multisine");
        kind.checked(given).expect("settings that hold")
    }

    #[test]
    fn the_band_includes_its_ends() {
        // 100 samples of 1 ms: lines of 10 Hz.
        let band = [
            ("samples_per_period", 100.0),
            ("sample_time", 1e-3),
            ("lowest_frequency", 30.0),
            ("highest_frequency", 70.0),
        ];
        assert_eq!(band_lines(&settings("multisine", &band), 1), [3, 4, 5, 6, 7]);
        assert_eq!(band_lines(&settings("multisine-odd", &band), 2), [3, 5, 7]);
    }

    #[test]
    fn the_line_at_half_the_sample_rate_stays_empty() {
        let band = [
            ("samples_per_period", 10.0),
            ("sample_time", 1e-3),
            ("lowest_frequency", 300.0),
            ("highest_frequency", 500.0),
        ];
        assert_eq!(band_lines(&settings("multisine", &band), 1), [3, 4]);
    }

    #[test]
    fn one_line_of_each_full_group_is_left_out() {
        let s = settings("multisine-odd-random", &[("highest_frequency", 1000.0)]);
        let (all, kept) = (band_lines(&s, 2), odd_random_lines(&s));
        assert_eq!((all.len(), kept.len()), (200, 150));
        for group in all.chunks(4) {
            assert_eq!(group.iter().filter(|k| kept.contains(k)).count(), 3);
        }
    }
}

//! Levels: rest, step, staircase.

use crate::parameter::{DURATION, HIGH, LOW, Parameter, RISE, SAMPLE_TIME};
use crate::rules::{LOW_BELOW_HIGH, rise_within};
use crate::shape::{between, instants, over_duration, smooth_step};
use crate::signal_type::{ChannelType, Rule, Settings, SignalType};

const LEVEL: Parameter = Parameter::real("level", "V", "The constant value.", [0.0, -1e4, 1e4]);
const STEP_TIME: Parameter =
    Parameter::real("step_time", "s", "Time at which the change begins.", [0.1, 0.0, 1e5]);
const STEPS: Parameter =
    Parameter::integer("steps", "Number of equal steps from low to high.", [10, 1, 100_000]);
const HOLD: Parameter = Parameter::real(
    "hold",
    "s",
    "Time from one change of level to the next, rounded to whole samples.",
    [1.0, 1e-6, 1e5],
);
const CYCLES: Parameter = Parameter::integer("cycles", "Times up and down.", [1, 1, 10_000]);
const BEFORE: Parameter =
    Parameter::real("before", "V", "Value before the change.", [0.0, -1e4, 1e4]);
const AFTER: Parameter =
    Parameter::real("after", "V", "Value after the change.", [100.0, -1e4, 1e4]);

/// Rest, step and staircase.
pub(crate) static LEVELS: &[SignalType] = &[
    SignalType {
        name: "rest",
        summary: "A constant value: shows noise, drift, hum and disturbances alone",
        source: "general",
        equation: "u = level",
        parameters: &[LEVEL, SAMPLE_TIME, DURATION.start(10.0)],
        channels: &[ChannelType::new("u", "V", 0.0, 0.0)],
        rules: &[],
        samples: over_duration,
        law: |s| vec![vec![s.get(&LEVEL); s.samples()]],
    },
    SignalType {
        name: "step",
        summary: "One change of level, at once or as a half cosine wave",
        source: "general",
        equation: "u = before + (after − before)·σ((t − step_time)/rise), σ(x) = (1 − cos πx)/2 \
                   from 0 to 1; at rise = 0 the jump acts from the first sample with t ≥ step_time",
        parameters: &[BEFORE, AFTER, STEP_TIME, RISE, SAMPLE_TIME, DURATION],
        channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
        rules: &[
            Rule {
                parameter: "step_time",
                text: "must lie before the end of the record; lower it or raise duration",
                holds: |s| s.get(&STEP_TIME) < s.get(&DURATION),
            },
            rise_within(
                "must end within the record, at most duration − step_time; lower it or raise \
                 duration",
                |s| s.get(&STEP_TIME) + s.get(&RISE) <= s.get(&DURATION),
            ),
        ],
        samples: over_duration,
        law: |s| vec![step(s)],
    },
    SignalType {
        name: "staircase",
        summary: "Equal steps up to the upper limit and down again, each held: creep on every level",
        source: "general",
        equation: "level j of 2·steps·cycles + 1 = low + (high − low)·m/steps, \
                   m = 0, 1, … steps, … 1, 0, …; each held for hold seconds",
        parameters: &[LOW, HIGH, STEPS, HOLD, RISE, CYCLES, SAMPLE_TIME],
        channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
        rules: &[
            LOW_BELOW_HIGH,
            Rule {
                parameter: "hold",
                text: "is less than one sample time; raise it or sample faster",
                holds: |s| hold_ticks(s) >= 1.0,
            },
            rise_within("must not exceed hold; lower it or raise hold", |s| {
                s.get(&RISE) <= s.get(&HOLD)
            }),
        ],
        samples: |s| (2.0 * s.get(&STEPS) * s.get(&CYCLES) + 1.0) * hold_ticks(s),
        law: |s| vec![staircase(s)],
    },
];

/// Part of the way to a new level, `elapsed` samples after the change.
fn part(elapsed: f64, rise_ticks: f64) -> f64 {
    if elapsed < 0.0 {
        0.0
    } else if rise_ticks == 0.0 {
        1.0
    } else {
        smooth_step(elapsed / rise_ticks)
    }
}

fn step(s: &Settings) -> Vec<f64> {
    let (before, after) = (s.get(&BEFORE), s.get(&AFTER));
    let rise = s.get(&RISE) / s.sample_time();
    // An instant within 1e-9 T of step_time is step_time.
    let exact = s.get(&STEP_TIME) / s.sample_time();
    let start = if rise == 0.0 { instants(s, s.get(&STEP_TIME)) } else { exact };
    (0..s.samples()).map(|n| between(before, after, part(n as f64 - start, rise))).collect()
}

fn hold_ticks(s: &Settings) -> f64 {
    s.ticks(s.get(&HOLD))
}

fn staircase(s: &Settings) -> Vec<f64> {
    let (low, high, steps) = (s.get(&LOW), s.get(&HIGH), s.count(&STEPS));
    let (hold, rise) = (hold_ticks(s) as usize, s.get(&RISE) / s.sample_time());
    let level = |j: usize| {
        let phase = j % (2 * steps);
        between(low, high, phase.min(2 * steps - phase) as f64 / steps as f64)
    };
    let value = |n: usize| {
        let (j, elapsed) = (n / hold, n % hold);
        between(level(j.saturating_sub(1)), level(j), part(elapsed as f64, rise))
    };
    (0..s.samples()).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(index: usize, settings: &[(&str, f64)]) -> Vec<f64> {
        LEVELS[index].generate(settings).expect("a signal").channels[0].values.clone()
    }

    #[test]
    fn stairs_go_up_and_down_and_end_where_they_began() {
        let settings = [
            ("steps", 3.0),
            ("hold", 0.02),
            ("sample_time", 0.01),
            ("cycles", 2.0),
            ("low", -3.0),
            ("high", 6.0),
        ];
        let levels: Vec<f64> = values(2, &settings).chunks(2).map(|hold| hold[0]).collect();
        let one = [-3.0, 0.0, 3.0, 6.0, 3.0, 0.0];
        assert_eq!(levels, [&one[..], &one[..], &[-3.0]].concat());
    }

    #[test]
    fn a_jump_acts_from_its_instant_on() {
        let settings = [("step_time", 0.3), ("sample_time", 0.1)];
        let expected = [0.0, 0.0, 0.0, 100.0, 100.0, 100.0, 100.0, 100.0, 100.0, 100.0];
        assert_eq!(values(1, &settings), expected);
        let between_samples = [("step_time", 0.25), ("sample_time", 0.1)];
        assert_eq!(values(1, &between_samples), expected);
    }

    #[test]
    fn a_rise_is_a_half_cosine() {
        let settings = [("step_time", 0.2), ("rise", 0.4), ("sample_time", 0.1)];
        let quarter = 50.0 - 50.0 * libm::sqrt(0.5);
        let expected = [0.0, 0.0, 0.0, quarter, 50.0, 100.0 - quarter, 100.0, 100.0];
        for (value, expected) in values(1, &settings).iter().zip(expected) {
            assert!((value - expected).abs() < 1e-12, "{value} {expected}");
        }
    }
}

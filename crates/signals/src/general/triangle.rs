//! Triangle waves.

use crate::parameter::{DURATION, FREQUENCY, HIGH, LOW, Parameter, SAMPLE_TIME};
use crate::rules::{FREQUENCY_BELOW_NYQUIST, LOW_BELOW_HIGH};
use crate::shape::{between, legs, over_duration, triangle_turns};
use crate::signal_type::{ChannelType, Settings, SignalType};

const CYCLES: Parameter =
    Parameter::integer("cycles", "Number of ever smaller cycles.", [10, 1, 100_000]);

/// Triangle and decaying triangle.
pub(crate) static TRIANGLES: &[SignalType] = &[
    SignalType {
        name: "triangle",
        summary: "Triangle wave between two limits, starting at the lower one",
        source: "general",
        equation: "u = low + (high − low)·2·|x − round x|, x = frequency·t",
        parameters: &[LOW, HIGH, FREQUENCY, SAMPLE_TIME, DURATION.start(5.0)],
        channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
        rules: &[LOW_BELOW_HIGH, FREQUENCY_BELOW_NYQUIST],
        samples: over_duration,
        law: |s| vec![triangle(s)],
    },
    SignalType {
        name: "triangle-decaying",
        summary: "Triangle whose reversals close in on the middle: nested loops, and a plant \
                  without memory at the end",
        source: "general",
        equation: "reversal j = mean + (−1)^(j+1)·(high − low)/2·(1 − j/(2·cycles)), \
                   j = 0 … 2·cycles, joined by straight legs of 1/(2·frequency), rounded to \
                   whole samples",
        parameters: &[LOW, HIGH, FREQUENCY, CYCLES, SAMPLE_TIME],
        channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
        rules: &[LOW_BELOW_HIGH, FREQUENCY_BELOW_NYQUIST],
        samples: |s| 2.0 * s.get(&CYCLES) * leg_ticks(s) + 1.0,
        law: |s| vec![decaying(s)],
    },
];

/// A triangle wave from `low` at t = 0 to `high` half a period later.
pub(crate) fn triangle(s: &Settings) -> Vec<f64> {
    let (low, high, frequency) = (s.get(&LOW), s.get(&HIGH), s.get(&FREQUENCY));
    s.sampled(|t| between(low, high, triangle_turns(frequency * t)))
}

/// Samples of half a period; at least 1 because the grid carries the frequency.
fn leg_ticks(s: &Settings) -> f64 {
    s.ticks(0.5 / s.get(&FREQUENCY))
}

fn decaying(s: &Settings) -> Vec<f64> {
    let (low, high, halves) = (s.get(&LOW), s.get(&HIGH), 2 * s.count(&CYCLES));
    let corner = |j: usize| {
        let part = 0.5 * j as f64 / halves as f64;
        between(low, high, if j.is_multiple_of(2) { part } else { 1.0 - part })
    };
    let corners: Vec<f64> = (0..=halves).map(corner).collect();
    let ticks = leg_ticks(s) as usize;
    legs(&corners, |_| ticks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reversals_shrink_to_the_middle() {
        let settings = [("cycles", 2.0), ("frequency", 1.0), ("sample_time", 0.125)];
        let signal = TRIANGLES[1].generate(&settings).expect("a triangle");
        let values = &signal.channels[0].values;
        let corners: Vec<f64> = values.iter().copied().step_by(4).collect();
        assert_eq!(corners, [0.0, 87.5, 25.0, 62.5, 50.0]);
        assert_eq!(values.len(), 17);
    }
}

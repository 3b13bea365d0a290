//! Sine between two limits.

use crate::parameter::{DURATION, FREQUENCY, HIGH, LOW, Parameter, SAMPLE_TIME};
use crate::rules::{FREQUENCY_BELOW_NYQUIST, LOW_BELOW_HIGH};
use crate::shape::{over_duration, rising_cosine};
use crate::signal_type::{ChannelType, Settings, SignalType};

const PHASE: Parameter = Parameter::real(
    "phase",
    "deg",
    "Phase at t = 0; −90 deg starts at low with zero slope.",
    [-90.0, -360.0, 360.0],
);

/// Sine.
pub(crate) static SINE: &[SignalType] = &[SignalType {
    name: "sine",
    summary: "Sine between two limits, starting at the lower one with zero slope",
    source: "general",
    equation: "u = (low + high)/2 + (high − low)/2 · sin(2π·frequency·t + phase)",
    parameters: &[LOW, HIGH, FREQUENCY, PHASE, SAMPLE_TIME, DURATION.start(5.0)],
    channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
    rules: &[LOW_BELOW_HIGH, FREQUENCY_BELOW_NYQUIST],
    samples: over_duration,
    law: |s| vec![sine(s)],
}];

fn sine(s: &Settings) -> Vec<f64> {
    let (low, high, frequency) = (s.get(&LOW), s.get(&HIGH), s.get(&FREQUENCY));
    let phase = (s.get(&PHASE) + 90.0) / 360.0;
    s.sampled(|t| rising_cosine(low, high, frequency * t + phase))
}

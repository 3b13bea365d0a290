//! First-order reversal curves.

use crate::parameter::{HIGH, LOW, Parameter, SAMPLE_TIME};
use crate::rules::LOW_BELOW_HIGH;
use crate::shape::{between, legs};
use crate::signal_type::{ChannelType, Rule, Settings, SignalType};

const CURVES: Parameter = Parameter::integer(
    "curves",
    "Number of reversal curves, the deepest from low.",
    [20, 1, 10_000],
);
const RATE: Parameter = Parameter::real(
    "rate",
    "V/s",
    "Slope of all legs; rounded so that a step between two reversal levels takes whole samples.",
    [100.0, 1e-6, 1e9],
);

/// First-order reversal curves.
pub(crate) static REVERSAL_CURVES: &[SignalType] = &[SignalType {
    name: "first-order-reversal-curves",
    summary: "From low to high, then down to ever deeper reversals and back to high each time, and \
              to low at the end: the data of a Preisach density",
    source: "general; Mayergoyz, Mathematical Models of Hysteresis and their Applications, 2003, \
             ch. 1",
    equation: "reversal k = high − (high − low)·k/curves, k = 1 … curves, straight legs of one rate",
    parameters: &[LOW, HIGH, CURVES, RATE, SAMPLE_TIME],
    channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
    rules: &[
        LOW_BELOW_HIGH,
        Rule {
            parameter: "rate",
            text: "passes a step between two reversal levels, (high − low)/curves, in less than half \
                   a sample time; lower rate or curves, or sample faster",
            holds: |s| step_ticks(s) >= 1.0 || !(LOW_BELOW_HIGH.holds)(s),
        },
    ],
    samples: |s| {
        let curves = s.get(&CURVES);
        step_ticks(s) * (2.0 * curves + curves * (curves + 1.0)) + 1.0
    },
    law: |s| vec![curves(s)],
}];

/// Samples from one reversal level to the next.
fn step_ticks(s: &Settings) -> f64 {
    s.ticks((s.get(&HIGH) - s.get(&LOW)) / (s.get(&CURVES) * s.get(&RATE)))
}

fn curves(s: &Settings) -> Vec<f64> {
    let (low, high, curves) = (s.get(&LOW), s.get(&HIGH), s.count(&CURVES));
    let reversal = |k: usize| between(high, low, k as f64 / curves as f64);
    let mut corners = vec![low, high];
    corners.extend((1..=curves).flat_map(|k| [reversal(k), high]));
    corners.push(low);
    // Legs 1 and 2 belong to curve 1, 3 and 4 to curve 2, …; the first and last span all levels.
    let levels = move |leg: usize| if leg == 0 { curves } else { leg.div_ceil(2).min(curves) };
    let step = step_ticks(s) as usize;
    legs(&corners, |leg| step * levels(leg))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values at which the direction changes.
    fn reversals(values: &[f64]) -> Vec<f64> {
        let turns = |w: &&[f64]| (w[1] - w[0]) * (w[2] - w[1]) < 0.0;
        values.windows(3).filter(turns).map(|w| w[1]).collect()
    }

    #[test]
    fn reversals_are_the_declared_levels_and_high_in_turn() {
        let signal = REVERSAL_CURVES[0]
            .generate(&[("curves", 4.0), ("low", -20.0), ("high", 100.0), ("rate", 300.0)])
            .expect("curves");
        let values = &signal.channels[0].values;
        let expected = [100.0, 70.0, 100.0, 40.0, 100.0, 10.0, 100.0, -20.0, 100.0];
        assert_eq!(reversals(values), expected);
        assert_eq!((values[0], values[values.len() - 1]), (-20.0, -20.0));
    }

    #[test]
    fn every_leg_has_the_stated_rate() {
        let signal = REVERSAL_CURVES[0].generate(&[("rate", 200.0)]).expect("curves");
        let values = &signal.channels[0].values;
        let steps = values.windows(2).map(|w| (w[1] - w[0]).abs() / signal.period);
        assert!(steps.into_iter().all(|rate| (rate - 200.0).abs() < 1e-6));
    }
}

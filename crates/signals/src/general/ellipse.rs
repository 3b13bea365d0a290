//! Ellipse in the plane of two axes.

use std::f64::consts::PI;

use crate::parameter::{DURATION, FREQUENCY, Parameter, RISE, SAMPLE_TIME};
use crate::rules::{FREQUENCY_BELOW_NYQUIST, rise_within};
use crate::shape::{cos_turns, over_duration, sin_turns, smooth_step};
use crate::signal_type::{ChannelType, Rule, Settings, SignalType};

/// Angle between long axis and Z.
pub(crate) const INCLINATION: Parameter = Parameter::real(
    "inclination",
    "deg",
    "Angle from the Z direction to the long axis, positive towards Y.",
    [20.0, -180.0, 180.0],
);
/// Centre.
pub(crate) const CENTRE: [Parameter; 2] = [
    Parameter::real("centre_y", "um", "Y of the centre.", [10.0, -1e6, 1e6]),
    Parameter::real("centre_z", "um", "Z of the centre.", [10.0, -1e6, 1e6]),
];
/// Half the long and half the short axis.
pub(crate) const SEMI_AXES: [Parameter; 2] = [
    Parameter::real("semi_axis_long", "um", "Half the long axis.", [6.0, 0.0, 1e6]),
    Parameter::real(
        "semi_axis_short",
        "um",
        "Half the short axis; 0 gives a straight line.",
        [3.0, 0.0, 1e6],
    ),
];
/// Smooth start.
pub(crate) const START: Parameter = Parameter {
    description: "Time in which the reference grows from zero to the ellipse, as a half cosine \
                  wave; 0 starts on the ellipse.",
    ..RISE.start(0.05)
};

/// Rules of every ellipse.
pub(crate) const RULES: &[Rule] = &[
    Rule {
        parameter: "semi_axis_short",
        text: "must not exceed semi_axis_long; exchange them and turn inclination by 90 deg",
        holds: |s| s.get(&SEMI_AXES[1]) <= s.get(&SEMI_AXES[0]),
    },
    FREQUENCY_BELOW_NYQUIST,
    rise_within("must not exceed duration; lower it or raise duration", |s| {
        s.get(&RISE) <= s.get(&DURATION)
    }),
];

/// Equation of every ellipse.
pub(crate) const EQUATION: &str = "y = σ·(centre_y − a·sin i·cos ωt + b·cos i·sin ωt), \
                                   z = σ·(centre_z − a·cos i·cos ωt − b·sin i·sin ωt), \
                                   a, b semi-axes, i inclination, ω = 2π·frequency, \
                                   σ = (1 − cos πt/rise)/2 until rise, then 1";

/// Ellipse.
pub(crate) static ELLIPSE: &[SignalType] = &[SignalType {
    name: "ellipse",
    summary: "Ellipse with inclination in the plane of two axes, reached smoothly from rest at zero",
    source: "general",
    equation: EQUATION,
    parameters: &[
        INCLINATION,
        CENTRE[0],
        CENTRE[1],
        SEMI_AXES[0],
        SEMI_AXES[1],
        FREQUENCY.start(10.0),
        START.start(0.5),
        SAMPLE_TIME,
        DURATION.start(2.0),
    ],
    channels: &[ChannelType::new("y", "um", 0.0, 13.5), ChannelType::new("z", "um", 0.0, 15.8)],
    rules: RULES,
    samples: over_duration,
    law: ellipse,
}];

/// The channels y and z.
pub(crate) fn ellipse(s: &Settings) -> Vec<Vec<f64>> {
    let [centre_y, centre_z] = CENTRE.map(|p| s.get(&p));
    let [long, short] = SEMI_AXES.map(|p| s.get(&p));
    let (frequency, rise) = (s.get(&FREQUENCY), s.get(&RISE));
    let (sin, cos) = libm::sincos(s.get(&INCLINATION) * PI / 180.0);
    let grown = |t: f64| if t < rise { smooth_step(t / rise) } else { 1.0 };
    let y = |along: f64, across: f64| centre_y + along * sin + across * cos;
    let z = |along: f64, across: f64| centre_z + along * cos - across * sin;
    let at = |t: f64| (-long * cos_turns(frequency * t), short * sin_turns(frequency * t));
    let y = s.sampled(|t| grown(t) * y(at(t).0, at(t).1));
    let z = s.sampled(|t| grown(t) * z(at(t).0, at(t).1));
    vec![y, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fulfil_the_equation_of_the_ellipse() {
        let signal = ELLIPSE[0].generate(&[("inclination", 35.0), ("rise", 0.0)]).expect("ellipse");
        let (sin, cos) = libm::sincos(35.0 * PI / 180.0);
        for (y, z) in signal.channels[0].values.iter().zip(&signal.channels[1].values) {
            let (y, z) = (y - 10.0, z - 10.0);
            let (along, across) = (y * sin + z * cos, y * cos - z * sin);
            let one = (along / 6.0) * (along / 6.0) + (across / 3.0) * (across / 3.0);
            assert!((one - 1.0).abs() < 1e-12, "{one}");
        }
    }

    #[test]
    fn the_long_axis_lies_at_the_inclination() {
        let signal = ELLIPSE[0].generate(&[("inclination", 90.0), ("rise", 0.0)]).expect("ellipse");
        let (y, z) = (&signal.channels[0], &signal.channels[1]);
        assert!((y.maximum() - 16.0).abs() < 1e-12 && (y.minimum() - 4.0).abs() < 1e-12);
        assert!((z.maximum() - 13.0).abs() < 1e-9 && (z.minimum() - 7.0).abs() < 1e-9);
    }

    #[test]
    fn it_starts_at_zero_with_zero_slope() {
        let signal = ELLIPSE[0].generate(&[("sample_time", 1e-5)]).expect("ellipse");
        for channel in &signal.channels {
            assert_eq!(channel.values[0], 0.0);
            assert!(channel.values[1].abs() < 1e-7);
        }
    }
}

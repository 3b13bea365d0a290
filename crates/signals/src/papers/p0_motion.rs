//! P0, motions of all four axes at once: calibration of the Jacobian, trajectories on both
//! detectors. The paper shows them in figures only, so the curves here stand in for them.

use crate::parameter::{DURATION, Parameter, SAMPLE_TIME};
use crate::shape::{cos_turns, instants, over_duration, rising_cosine, sin_turns, smooth_step};
use crate::signal_type::{ChannelType, Rule, Settings, SignalType};

/// Jacobian J of P0 in µm per unit of θ; rows x1, y1, x2, y2.
const JACOBIAN: [[f64; 4]; 4] = [
    [504.693, 3.33402, 0.0, 0.0],
    [14.4123, -515.344, 0.0, 0.0],
    [210.358, -12.0015, -129.337, 7.85753],
    [1.18470, 217.263, -3.04729, -142.002],
];

/// Positions p0 at θ = 0 in µm.
const AT_REST: [f64; 4] = [-261.625, 272.281, -46.6467, -39.1210];

const TOP: Parameter = Parameter::real(
    "top",
    "1",
    "Greatest normalised angle of each axis; the least is 0.",
    [0.9, 1e-3, 1.0],
);
/// Whole waves of axes 1 to 4 in one record: any two are orthogonal over it.
const WAVES: [f64; 4] = [3.0, 4.0, 5.0, 7.0];

const PASS: Parameter =
    Parameter::real("pass", "s", "Time of one pass along the curves.", [2.0, 0.01, 1e4]);
const SIZE_1: Parameter = Parameter::real(
    "size_1",
    "um",
    "Radius of the circles that generate the cardioid on detector 1, which spans 5.2 by 4.5 radii.",
    [50.0, 0.0, 110.0],
);
const SIZE_2: Parameter = Parameter::real(
    "size_2",
    "um",
    "Radius of the circle that generates the deltoid on detector 2, which spans 5.2 by 4.5 radii.",
    [20.0, 0.0, 110.0],
);
const APPROACH: Parameter = Parameter::real(
    "approach",
    "s",
    "Time of the smooth way from rest to the start of the curves.",
    [1.0, 0.0, 1e4],
);
const SETTLE: Parameter = Parameter::real(
    "settle",
    "s",
    "Time of rest at the start of the curves, before the pass.",
    [1.0, 0.0, 1e4],
);

const STAND_IN: &str = "P0, section IV-D2 and figure 13; the text gives the time only (2 s at rate \
                        1, 1 s at rate 2), the curves replace the figure";
const CURVES: &str = "on detector 1 a cardioid, x1 + j·y1 = c1 + j·size_1·(2e^(jφ) − e^(2jφ) + 3/4), \
                      on detector 2 a deltoid, x2 + j·y2 = c2 − j·size_2·(2e^(−jφ) + e^(2jφ)), \
                      φ = 2πτ/pass over the pass; both start and end in a cusp, at rest; c1, c2 is \
                      where all angles are 0.5; before the pass from p0 on a half cosine wave, and \
                      a rest";
const REACHABLE: Rule = Rule {
    parameter: "size_2",
    text: "and size_1 together ask for a normalised angle outside 0 to 1; lower the one or the other",
    holds: reachable,
};

/// Calibration and trajectories.
pub(crate) static P0_MOTIONS: &[SignalType] = &[
    SignalType {
        name: "p0-calibration",
        summary: "Calibrates the Jacobian: normalised angles of four axes that move at once, each with its own frequency",
        source: "P0, section IV-D1; the text gives 5 s and 5 ms, the motion is assumed",
        equation: "θ_i = top/2·(1 − cos(2π·k_i·t/duration)), k = 3, 4, 5, 7 waves",
        parameters: &[TOP, SAMPLE_TIME.start(5e-3).max(0.1), DURATION.start(5.0)],
        channels: &[
            ChannelType::new("theta1", "1", 0.0, 0.9),
            ChannelType::new("theta2", "1", 0.0, 0.9),
            ChannelType::new("theta3", "1", 0.0, 0.9),
            ChannelType::new("theta4", "1", 0.0, 0.9),
        ],
        rules: &[Rule {
            parameter: "duration",
            text: "holds fewer than 15 samples, too few for 7 waves; raise it or sample faster",
            holds: |s| over_duration(s) >= 15.0,
        }],
        samples: over_duration,
        law: calibration,
    },
    SignalType {
        name: "p0-trajectory-1",
        summary: "Trajectories of both laser spots at rate 1: one pass in 2 s (stand-in curves)",
        source: STAND_IN,
        equation: CURVES,
        parameters: &[PASS, SIZE_1, SIZE_2, APPROACH, SETTLE, SAMPLE_TIME.start(5e-3).max(0.1)],
        channels: POSITIONS,
        rules: &[REACHABLE],
        samples: trajectory_samples,
        law: trajectory,
    },
    SignalType {
        name: "p0-trajectory-2",
        summary: "Trajectories of both laser spots at rate 2: one pass in 1 s (stand-in curves)",
        source: STAND_IN,
        equation: CURVES,
        parameters: &[
            PASS.start(1.0),
            SIZE_1,
            SIZE_2,
            APPROACH,
            SETTLE,
            SAMPLE_TIME.start(5e-3).max(0.1),
        ],
        channels: POSITIONS,
        rules: &[REACHABLE],
        samples: trajectory_samples,
        law: trajectory,
    },
];

/// Reference positions of the two spots; p0 lies outside the curves.
const POSITIONS: &[ChannelType] = &[
    ChannelType::new("x1", "um", -261.625, 122.3),
    ChannelType::new("y1", "um", -90.7, 272.281),
    ChannelType::new("x2", "um", -60.2, 43.8),
    ChannelType::new("y2", "um", -62.5, 27.6),
];

fn calibration(s: &Settings) -> Vec<Vec<f64>> {
    let (top, duration) = (s.get(&TOP), s.get(&DURATION));
    let axis = |waves: f64| s.sampled(|t| rising_cosine(0.0, top, waves * t / duration));
    WAVES.map(axis).to_vec()
}

fn trajectory_samples(s: &Settings) -> f64 {
    instants(s, s.get(&APPROACH) + s.get(&SETTLE) + s.get(&PASS))
}

fn trajectory(s: &Settings) -> Vec<Vec<f64>> {
    let (pass, approach) = (s.get(&PASS), s.get(&APPROACH));
    let begin = approach + s.get(&SETTLE);
    let curve = Curve::new(s);
    let start = curve.at(0.0);
    let position = |t: f64| {
        if t < approach {
            let part = smooth_step(t / approach);
            std::array::from_fn(|i| AT_REST[i] + part * (start[i] - AT_REST[i]))
        } else {
            curve.at(((t - begin) / pass).max(0.0))
        }
    };
    (0..4).map(|i| s.sampled(|t| position(t)[i])).collect()
}

/// The closed curves on both detectors.
struct Curve {
    centre: [f64; 4],
    size_1: f64,
    size_2: f64,
}

impl Curve {
    fn new(s: &Settings) -> Self {
        let half = |i: usize| AT_REST[i] + 0.5 * JACOBIAN[i].iter().sum::<f64>();
        let centre = std::array::from_fn(half);
        Self { centre, size_1: s.get(&SIZE_1), size_2: s.get(&SIZE_2) }
    }

    /// Positions x1, y1, x2, y2 after `turns` of the pass.
    fn at(&self, turns: f64) -> [f64; 4] {
        let [c1, s1, c2, s2] =
            [cos_turns(turns), sin_turns(turns), cos_turns(2.0 * turns), sin_turns(2.0 * turns)];
        let [x1, y1, x2, y2] = self.centre;
        [
            x1 - self.size_1 * (2.0 * s1 - s2),
            y1 + self.size_1 * (2.0 * c1 - c2 + 0.75),
            x2 - self.size_2 * (2.0 * s1 - s2),
            y2 - self.size_2 * (2.0 * c1 + c2),
        ]
    }
}

/// Whether all angles stay within 0 to 1 along the curves; the straight way from rest (all angles
/// 0) to their start then does too.
fn reachable(s: &Settings) -> bool {
    let curve = Curve::new(s);
    let inside = |angle: &f64| (0.0..=1.0).contains(angle);
    (0..720).all(|n| angles(curve.at(f64::from(n) / 720.0)).iter().all(inside))
}

/// θ = J⁻¹(p − p0), by the two diagonal blocks: spot 1 does not see mirror 2.
fn angles(position: [f64; 4]) -> [f64; 4] {
    let d: [f64; 4] = std::array::from_fn(|i| position[i] - AT_REST[i]);
    let [a, b] =
        solved([JACOBIAN[0][0], JACOBIAN[0][1]], [JACOBIAN[1][0], JACOBIAN[1][1]], [d[0], d[1]]);
    let left = |i: usize| d[i] - JACOBIAN[i][0] * a - JACOBIAN[i][1] * b;
    let rest = [left(2), left(3)];
    let [c, d] = solved([JACOBIAN[2][2], JACOBIAN[2][3]], [JACOBIAN[3][2], JACOBIAN[3][3]], rest);
    [a, b, c, d]
}

/// Solution of two equations by Cramer's rule; the blocks of J are far from singular.
fn solved([a, b]: [f64; 2], [c, d]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    let determinant = a * d - b * c;
    [(x * d - b * y) / determinant, (a * y - x * c) / determinant]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_invert_the_kinematics() {
        let theta = [0.1, 0.7, 0.35, 0.9];
        let forward = |i: usize| {
            let row: f64 = JACOBIAN[i].iter().zip(theta).map(|(j, t)| j * t).sum();
            row + AT_REST[i]
        };
        for (angle, expected) in angles(std::array::from_fn(forward)).iter().zip(theta) {
            assert!((angle - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn trajectories_are_reachable_with_a_margin() {
        for kind in &P0_MOTIONS[1..] {
            let signal = kind.generate(&[]).expect("a trajectory");
            for n in 0..signal.len() {
                let position = std::array::from_fn(|i| signal.channels[i].values[n]);
                let angles = angles(position);
                let inside = |a: &f64| (-1e-12..=0.9).contains(a);
                assert!(angles.iter().all(inside), "sample {n}: {angles:?}");
            }
        }
    }

    #[test]
    fn curves_out_of_reach_are_refused() {
        let error = P0_MOTIONS[1].generate(&[("size_1", 50.0), ("size_2", 60.0)]).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("size_2 = 60 um") && text.contains("outside 0 to 1"), "{text}");
    }

    #[test]
    fn a_pass_takes_its_time_and_begins_and_ends_at_rest() {
        for (kind, pass) in P0_MOTIONS[1..].iter().zip([2.0, 1.0]) {
            let signal = kind.generate(&[("sample_time", 1e-4)]).expect("a trajectory");
            assert_eq!(signal.len(), 20_000 + (10_000.0 * pass) as usize);
            for (channel, rest) in signal.channels.iter().zip(AT_REST) {
                let u = &channel.values;
                assert_eq!(u[0], rest);
                assert_eq!(u[10_000], u[19_999]);
                let way = |n: usize| (u[n + 1] - u[n]).abs();
                let longest = (20_000..u.len() - 1).map(way).fold(0.0, f64::max);
                for n in [0, 9_999, 15_000, 20_000, u.len() - 2] {
                    assert!(way(n) < 0.01 * longest, "{} at {n}: {}", channel.name, way(n));
                }
            }
        }
    }

    #[test]
    fn the_curves_are_closed() {
        let signal = P0_MOTIONS[1].generate(&[]).expect("a trajectory");
        for channel in &signal.channels {
            let end = 2.0 * channel.values[799] - channel.values[798];
            assert!((end - channel.values[400]).abs() < 0.05, "{}: {end}", channel.name);
        }
    }

    #[test]
    fn calibration_moves_all_axes_independently() {
        let signal = P0_MOTIONS[0].generate(&[]).expect("a motion");
        assert_eq!(signal.len(), 1000);
        let alternating: Vec<Vec<f64>> =
            signal.channels.iter().map(|c| c.values.iter().map(|v| v - 0.45).collect()).collect();
        for (i, a) in alternating.iter().enumerate() {
            for (j, b) in alternating.iter().enumerate() {
                let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                let expected = if i == j { 0.5 * 0.45 * 0.45 * 1000.0 } else { 0.0 };
                assert!((product - expected).abs() < 1e-9, "axes {i} and {j}: {product}");
            }
        }
    }

    #[test]
    fn the_cusps_are_at_the_start() {
        // Both speeds vanish at φ = 0 in proportion to φ: twice the step goes four times as far.
        let signal = P0_MOTIONS[1].generate(&[]).expect("a trajectory");
        let curves = [&signal.channels[1].values, &signal.channels[3].values];
        for u in curves {
            let (one, two) = (u[401] - u[400], u[402] - u[400]);
            assert!((two / one - 4.0).abs() < 0.01, "{}", two / one);
        }
    }
}

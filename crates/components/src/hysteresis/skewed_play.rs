//! Asymmetric Prandtl–Ishlinskii hysteresis: loops that are wider at one end of the range.
//!
//! ```text
//! y = offset + Σ w_i P_i + ξ·Σ skew_i (P_i − u) + play_weight·(Q − u)
//! P_i ← max(u − r_i, min(u + r_i, P_i)),   Q ← max(u − ρ, min(u + ρ, Q))
//! ρ = half_range·max(0, width + width_growth·ξ + width_curvature·ξ²),   ξ = (u − centre)/half_range
//! ```
//!
//! * r, w as in `prandtl-ishlinskii`; skew_i in position per command: P_i − u is the memory part of a
//!   play, whose weight grows along the range. Q is one more play, whose width changes along it: width,
//!   its growth and its curvature as shares of half the range.
//! * centre, half_range in units of the command: where ξ goes from −1 to 1; outside it goes on.
//! * State: one number per play, and Q. At rest as after a monotonic move from the virgin state.
//!
//! Limits: independent of rate; with a skew or a play_weight that outweighs the plays a branch may turn
//! back, so that there is no inverse.
//!
//! Source: a play with a width of its own at each input is that of A. Visintin, Differential Models of
//! Hysteresis, Springer 1994, ch. III.2 (generalised play); weights that depend on the input as in
//! K. Kuhnen, European Journal of Control 9 (2003) 407–418, for its dead zones.

use libm::fmax;
use model::{Component, Conversion, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use super::play::{Drive, Plays, Threshold, play};
use super::prandtl_ishlinskii::{OFFSET, R, STRUCTURE, W, check_plays};
use crate::rules::{WRONG_LENGTH, kept, require};
use crate::{effects, phenomena};

/// The component `skewed-play`.
pub struct SkewedPlay;

static DECLARATION: Declaration = Declaration {
    kind: "skewed-play",
    name: "hysteresis",
    summary: "Asymmetric hysteresis, independent of rate: plays that are wider at one end of the range",
    equation: "y = offset + sum(w[i]*P[i]) + x*sum(skew[i]*(P[i] - u)) + play_weight*(Q - u); P[i] = \
               max(u - r[i], min(u + r[i], P[i])); Q the same with half_range*max(0, width + \
               width_growth*x + width_curvature*x^2); x = (u - centre)/half_range",
    reference: "A. Visintin, Differential Models of Hysteresis, Springer 1994, ch. III",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::ASYMMETRY),
    phenomena: &[&phenomena::ASYMMETRIC_HYSTERESIS],
    structure: STRUCTURE,
    parameters: &[
        R,
        W,
        Quantity::new(
            "skew",
            "{position}/{command}",
            "Growth of the weight of each play's memory towards the upper end of the range",
        )
        .per(0)
        .fitted(),
        OFFSET,
        Quantity::new(
            "play_weight",
            "{position}/{command}",
            "Weight of the play whose width changes",
        )
        .start(0.0)
        .fitted(),
        Quantity::new(
            "width",
            "1",
            "Half width of that play at the centre, relative to half_range",
        )
        .start(0.0)
        .min(0.0)
        .fitted(),
        Quantity::new(
            "width_growth",
            "1",
            "Growth of the width towards the upper end of the range",
        )
        .start(0.0)
        .fitted(),
        Quantity::new("width_curvature", "1", "Growth of the width towards both ends of the range")
            .start(0.0)
            .fitted(),
        Quantity::new("centre", "{command}", "Middle of the range"),
        Quantity::new("half_range", "{command}", "Half of the range").min(0.0),
    ],
    ..Declaration::PATH
};

/// What is not an array.
struct Scalars {
    offset: f64,
    weight: f64,
    width: [f64; 3],
    centre: f64,
    half: f64,
}

/// `r | w | skew | offset | play_weight | width | growth | curvature | centre | half_range`: parameters
/// and coefficients alike.
fn split(values: &[f64]) -> Option<(Plays<'_>, &[f64], Scalars)> {
    let (arrays, &[offset, weight, width, growth, curvature, centre, half]) =
        values.split_last_chunk()?;
    let (r, rest) = arrays.split_at(arrays.len() / 3);
    let (w, skew) = rest.split_at(r.len());
    let width = [width, growth, curvature];
    Some((Plays { r, w }, skew, Scalars { offset, weight, width, centre, half }))
}

/// The position once the plays have gone on to this command.
#[inline]
fn advance(coefficients: &[f64], u: f64, state: &mut [f64]) -> Option<f64> {
    let (plays, skew, s) = split(coefficients)?;
    let (wide, own) = state.split_last_mut()?;
    let place = (u - s.centre) / s.half;
    let sum = plays.step(u, own);
    let skewed = own.iter().zip(skew).fold(0.0, |sum, (p, v)| sum + v * (p - u));
    let [width, growth, curvature] = s.width;
    let width = s.half * fmax(width + place * (growth + place * curvature), 0.0);
    *wide = play(Drive(u), Threshold(width), *wide);
    Some(s.offset + sum + place * skewed + s.weight * (*wide - u))
}

impl Component for SkewedPlay {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("r", &[0.0, 8.0, 20.0]),
            ("w", &[0.05, 0.02, 0.01]),
            ("skew", &[0.0, 0.004, 0.006]),
            ("offset", &[0.3]),
            ("play_weight", &[0.01]),
            ("width", &[0.2]),
            ("width_growth", &[0.1]),
            ("width_curvature", &[0.05]),
            ("centre", &[50.0]),
            ("half_range", &[50.0]),
        ]
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let plays = DECLARATION.length(0, structure);
        Sizes { coefficients: DECLARATION.parameter_count(structure), states: plays + 1 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (plays, _, scalars) = split(parameters).ok_or(WRONG_LENGTH)?;
        check_plays(plays)?;
        require(scalars.half > 0.0, "half_range", scalars.half, "must be above zero")?;
        let [width, ..] = scalars.width;
        require(width >= 0.0, "width", width, "must be zero or positive")?;
        kept(parameters, coefficients)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [y]) = (inputs, outputs) else { return };
        state.fill(0.0);
        if let Some(position) = advance(coefficients, u, state) {
            *y = position;
        }
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[u], [y]) = (inputs, outputs) else { return };
        if let Some(position) = advance(coefficients, u, state) {
            *y = position;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;
    use crate::testing::{Instance, Random, loop_area};

    const PLAYS: [f64; 6] = [0.0, 10.0, 30.0, 0.02, 0.01, 0.005];

    fn new(skew: [f64; 3], rest: [f64; 7]) -> Instance {
        let all: Vec<f64> = PLAYS.iter().chain(&skew).chain(&rest).copied().collect();
        Instance::new(&SkewedPlay, &[3.0], &all, 1e-4).unwrap()
    }

    #[test]
    fn without_skew_it_is_the_symmetric_model() {
        let plain: Vec<f64> = PLAYS.iter().copied().chain([0.5]).collect();
        let plain = Instance::new(&super::super::PrandtlIshlinskii, &[3.0], &plain, 1e-4);
        let signal = Random::new(3).signal(-100.0, 120.0, 500);
        let (own, plain) = (
            new([0.0; 3], [0.5, 0.0, 0.2, 0.1, 0.1, 50.0, 50.0]).response(5.0, &signal),
            plain.unwrap().response(5.0, &signal),
        );
        assert!(own.iter().zip(plain).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    /// A play of the weight w and the threshold r has loops of the area 4·w·r·(a − r) under u = c ± a.
    #[test]
    fn a_skewed_play_has_the_loop_of_its_place() {
        let area = |centre: f64| {
            let mut model = new([0.0, 0.004, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 50.0, 50.0]);
            let turn = |k: usize| 15.0 * (1.0 - ((k % 400) as f64 / 200.0 - 1.0).abs() * 2.0);
            let u: Vec<f64> = (0..=1200).map(|k| centre + turn(k)).collect();
            model.rest(&[u[0]]);
            let y: Vec<f64> = u.iter().map(|u| model.step(&[*u])).collect();
            loop_area(&u[800..], &y[800..]).abs()
        };
        // The threshold of 30 V stands still under ±15 V. The mean of ξ over a loop is its centre's.
        for (centre, weight) in [(50.0, 0.01), (80.0, 0.0124), (20.0, 0.0076)] {
            let wanted = 4.0 * weight * 10.0 * 5.0;
            assert!((area(centre) / wanted - 1.0).abs() < 0.02, "{centre}: {}", area(centre));
        }
    }

    #[test]
    fn the_last_play_is_as_wide_as_the_place_says() {
        let mut model = new([0.0; 3], [0.0, 1.0, 0.2, 0.1, 0.05, 50.0, 50.0]);
        let mut plain = new([0.0; 3], [0.0, 0.0, 0.2, 0.1, 0.05, 50.0, 50.0]);
        // Up from the virgin state Q − u is minus the half width.
        for u in [50.0, 75.0, 100.0] {
            let part = model.step(&[u]) - plain.step(&[u]);
            let place = (u - 50.0) / 50.0;
            let width = 50.0 * (0.2 + 0.1 * place + 0.05 * place * place);
            assert!((part + width).abs() < 1e-9, "{u}: {part}, half width {width}");
        }
    }

    #[test]
    fn a_range_of_nothing_is_refused() {
        let all: Vec<f64> = PLAYS
            .iter()
            .copied()
            .chain([0.0; 3])
            .chain([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
            .collect();
        let refused = Instance::new(&SkewedPlay, &[3.0], &all, 1e-4).err().unwrap();
        assert_eq!(refused.quantity, "half_range");
    }
}

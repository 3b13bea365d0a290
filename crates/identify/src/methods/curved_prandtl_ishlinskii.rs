//! Prandtl–Ishlinskii with a smooth density, between two static curves, with creep.
//!
//! ```text
//! x = u + half·quadratic·ξ²                        (amplifier-nonlinearity)
//! h = Σ w_i P_i[x]                                  (prandtl-ishlinskii)
//! z = h + share·Σ z_j                                  (kelvin-voigt-creep, three decades)
//! y = z + half_y·(quadratic·η² + cubic·η³)          (sensor-polynomial)
//! ```
//!
//! The curve before the plays and the one behind them together make a loop that is wider at one end
//! than at the other, which neither does alone. The weights are linear once the last curve is undone
//! on the measured positions. A penalty on their second differences leaves a density of plays that is
//! a straight line over the threshold: one large loop hardly tells neighbouring plays apart, and a
//! ragged set of weights that fits it fails on smaller loops. The creep has
//! one number, the share per decade: free shares pass for the phase of the delay at one frequency. As the
//! density is smooth, the number of plays is that of an integral's nodes: twice the grid of the others.

use data::ComponentBlueprint;

use super::prandtl_ishlinskii::plays;
use super::{Bank, Chain, FitContext, Method, Shape, Weights};
use crate::error::Error;
use crate::fit::response::Part;

/// The method `curved-prandtl-ishlinskii`.
pub(crate) struct Curved;

/// Strength of the penalty relative to half the command's range.
const SMOOTHNESS: f64 = 30.0;
/// Plays to which [`SMOOTHNESS`] refers.
const REFERENCE_PLAYS: f64 = 24.0;
/// How far the undone curve may lie from the middle, in half ranges.
const REACH: f64 = 2.0;
/// Newton steps that undo the last curve.
const NEWTON: usize = 12;

/// Thresholds twice as fine as those of the other methods.
fn thresholds(scene: &FitContext) -> Vec<f64> {
    let middle = scene.thresholds.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let last = scene.thresholds.iter().rev().take(2).copied().collect::<Vec<_>>();
    let beyond = if let [last, before] = last[..] { 1.5 * last - 0.5 * before } else { 0.0 };
    let between = middle.chain([beyond]);
    scene.thresholds.iter().copied().zip(between).flat_map(|(r, next)| [r, next]).collect()
}

/// Time constants of the creep: a half, a twentieth and a two-hundredth of the time fitted on.
fn time_constants(scene: &FitContext) -> [f64; 3] {
    [200.0, 20.0, 2.0].map(|part| scene.duration / part)
}

impl Method for Curved {
    fn name(&self) -> &'static str {
        "curved-prandtl-ishlinskii"
    }

    fn summary(&self) -> &'static str {
        "Smooth Prandtl-Ishlinskii between two static curves, with creep: asymmetric loops"
    }

    fn shape(&self, _scene: &FitContext) -> Vec<Shape> {
        vec![
            Shape::new("nonlinearity.quadratic", "1", 0.0, (-0.3, 0.3)),
            Shape::new("linearity.quadratic", "1", 0.0, (-0.25, 0.25)),
            Shape::new("linearity.cubic", "1", 0.0, (-0.1, 0.1)),
            // Makers state 1 to 2 % per decade of time; a record that starts with the machine's first
            // move shows it as drift (`Record::rested_at`).
            Shape::new("creep.share (each)", "1", 0.01, (0.0, 0.03)),
        ]
    }

    fn starts(&self, _scene: &FitContext) -> Vec<Vec<f64>> {
        let bends = [(0.0, 0.0), (0.1, -0.1), (-0.1, 0.1), (0.15, -0.2), (-0.15, 0.2)];
        bends.map(|(before, behind)| vec![before, behind, 0.0, 0.01]).to_vec()
    }

    fn weights(&self, scene: &FitContext) -> Weights {
        Weights::plays(&[], &thresholds(scene))
    }

    fn bank<'a>(
        &'a self,
        scene: &'a FitContext,
        shape: &[f64],
        step: f64,
    ) -> Result<Bank<'a>, Error> {
        let (centre, half) = scene.centre();
        let [before, share] = [shape[0], shape[3]];
        let [a, b, c] = time_constants(scene);
        let parameters = [share, share, share, a, b, c];
        let thresholds = thresholds(scene);
        let creep =
            |_: &f64| Part::new(&components::creep::KelvinVoigtCreep, &[3.0], &parameters, step);
        let mut creeps = thresholds.iter().map(creep).collect::<Result<Vec<_>, _>>()?;
        let mut plays = plays(thresholds);
        let mut at_rest = true;
        Ok(Box::new(move |u, row| {
            plays(u + half * before * ((u - centre) / half).powi(2), row);
            for (value, creep) in row.iter_mut().zip(&mut creeps) {
                *value = if at_rest { creep.rest(*value) } else { creep.step(*value) };
            }
            at_rest = false;
        }))
    }

    fn unmapped(
        &self,
        scene: &FitContext,
        shape: &[f64],
        output: &[f64],
    ) -> Option<Vec<(f64, f64)>> {
        let (middle, half) = scene.middle();
        let (quadratic, cubic) = (shape[1], shape[2]);
        let undo = |y: &f64| {
            let mut x = *y;
            let mut slope = 1.0;
            for _ in 0..NEWTON {
                let at = (x - middle) / half;
                slope = (1.0 + (2.0 * quadratic + 3.0 * cubic * at) * at).max(0.05);
                x -= (x + half * (quadratic + cubic * at) * at * at - y) / slope;
                // Beyond the range of the positions the curve may fold back.
                x = x.clamp(middle - REACH * half, middle + REACH * half);
            }
            (x, slope)
        };
        Some(output.iter().map(undo).collect())
    }

    fn penalty(&self, scene: &FitContext) -> Vec<Vec<f64>> {
        let count = thresholds(scene).len();
        let (_, half) = scene.centre();
        let strength = SMOOTHNESS * half * (count as f64 / REFERENCE_PLAYS).powf(2.5);
        // The first play is the part without memory, no part of the density.
        (1..count.saturating_sub(2))
            .map(|i| {
                let mut row = vec![0.0; count];
                row[i] = strength;
                row[i + 1] = -2.0 * strength;
                row[i + 2] = strength;
                row
            })
            .collect()
    }

    fn chain(&self, scene: &FitContext, shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        let (centre, half) = scene.centre();
        let (middle, half_position) = scene.middle();
        let hysteresis = vec![
            ComponentBlueprint::new("amplifier-nonlinearity")
                .value("quadratic", shape[0])
                .value("centre", centre)
                .value("half_range", half),
            ComponentBlueprint::new("prandtl-ishlinskii")
                .value("r", thresholds(scene))
                .value("w", weights)
                // Creep raises what rests in front of it by the sum of its shares.
                .value("offset", offset / (1.0 + 3.0 * shape[3])),
            ComponentBlueprint::new("kelvin-voigt-creep")
                .value("share", [shape[3]; 3])
                .value("time_constant", time_constants(scene)),
        ];
        let reading = vec![
            ComponentBlueprint::new("sensor-polynomial")
                .value("quadratic", shape[1])
                .value("cubic", shape[2])
                .value("centre", middle)
                .value("half_range", half_position),
        ];
        Chain { hysteresis, reading }
    }
}

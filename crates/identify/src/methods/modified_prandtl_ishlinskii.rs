//! Kuhnen's modified Prandtl–Ishlinskii: plays followed by one-sided dead zones.
//!
//! `y = offset + S(Σ w_i P_i)`. For an offset and slopes the dead zones are undone on the measured
//! positions, and the weights are linear in what is left. The edges are fixed: quarters of the
//! position's range, seen from the position at zero command.

use components::hysteresis::dead_zone::DeadZones;
use data::ComponentBlueprint;

use super::prandtl_ishlinskii::plays;
use super::{Bank, Chain, FitContext, Method, Shape, Weights};
use crate::error::Error;

/// The method `modified-prandtl-ishlinskii`.
pub(crate) struct ModifiedPrandtlIshlinskii;

/// Edges as positions less the one at zero command.
fn edges(scene: &FitContext) -> Vec<f64> {
    let [low, high] = scene.position;
    let range = high - low;
    let quarters = [0.2, 0.4, 0.6, 0.8].map(|part| low + part * range - scene.zero);
    quarters.into_iter().filter(|edge| edge.abs() > 0.05 * range).collect()
}

impl Method for ModifiedPrandtlIshlinskii {
    fn name(&self) -> &'static str {
        "modified-prandtl-ishlinskii"
    }

    fn summary(&self) -> &'static str {
        "Kuhnen's modified Prandtl-Ishlinskii: asymmetric by one-sided dead zones behind the plays"
    }

    fn shape(&self, scene: &FitContext) -> Vec<Shape> {
        let (_, half) = scene.middle();
        let bounds = (scene.zero - half, scene.zero + half);
        let mut all = vec![Shape::new("hysteresis.offset", "{position}", scene.zero, bounds)];
        let slopes = (1..=edges(scene).len()).map(|i| format!("hysteresis.slope[{i}]"));
        all.extend(slopes.map(|name| Shape::new(name, "1", 0.0, (-0.2, 0.4))));
        all
    }

    fn weights(&self, scene: &FitContext) -> Weights {
        Weights::plays(&[], &scene.thresholds)
    }

    fn bank<'a>(
        &'a self,
        scene: &'a FitContext,
        _shape: &[f64],
        _step: f64,
    ) -> Result<Bank<'a>, Error> {
        Ok(plays(scene.thresholds.clone()))
    }

    fn unmapped(
        &self,
        scene: &FitContext,
        shape: &[f64],
        output: &[f64],
    ) -> Option<Vec<(f64, f64)>> {
        let edges = edges(scene);
        let zones = DeadZones { edges: &edges, slopes: &shape[1..] };
        // At most four slopes of −0.2 each, so the map rises everywhere.
        let undo = |y: &f64| {
            let y = y - shape[0];
            let mut x = y;
            let mut slope = 1.0;
            for _ in 0..8 {
                slope = 1.0 + active(&zones, x);
                x -= (zones.map(x) - y) / slope;
            }
            (x, slope)
        };
        Some(output.iter().map(undo).collect())
    }

    fn anchored(&self) -> bool {
        true
    }

    fn chain(&self, scene: &FitContext, shape: &[f64], weights: &[f64], _offset: f64) -> Chain {
        Chain::of(
            ComponentBlueprint::new("modified-prandtl-ishlinskii")
                .value("r", scene.thresholds.as_slice())
                .value("w", weights)
                .value("edge", edges(scene).as_slice())
                .value("slope", &shape[1..])
                .value("offset", shape[0]),
        )
    }
}

/// The sum of the slopes of the zones that `x` is in.
fn active(zones: &DeadZones<'_>, x: f64) -> f64 {
    let on = |edge: f64| if edge > 0.0 { x > edge } else { x < edge };
    zones.edges.iter().zip(zones.slopes).filter(|(edge, _)| on(**edge)).map(|(_, s)| s).sum()
}

//! Static Prandtl–Ishlinskii: weights of plays, everything linear.

use components::hysteresis::play::play;
use data::ComponentBlueprint;

use super::{Chain, Method, Scene, Shape, Weights};
use crate::error::Error;

/// The method `prandtl-ishlinskii`.
pub(crate) struct PrandtlIshlinskii;

/// The plays of these thresholds, one column each.
pub(crate) fn plays(thresholds: &[f64], signal: &[f64]) -> Vec<Vec<f64>> {
    let column = |r: &f64| {
        let mut state = 0.0;
        let step = |u: &f64| {
            state = play(*u, *r, state);
            state
        };
        signal.iter().map(step).collect()
    };
    thresholds.iter().map(column).collect()
}

impl Method for PrandtlIshlinskii {
    fn name(&self) -> &'static str {
        "prandtl-ishlinskii"
    }

    fn summary(&self) -> &'static str {
        "Static Prandtl-Ishlinskii: symmetric, independent of rate; weights by least squares"
    }

    fn shape(&self, _scene: &Scene) -> Vec<Shape> {
        Vec::new()
    }

    fn weights(&self, scene: &Scene) -> Weights {
        Weights::plays(&[], scene.thresholds.len())
    }

    fn columns(
        &self,
        scene: &Scene,
        _shape: &[f64],
        signal: &[f64],
        _step: f64,
    ) -> Result<Vec<Vec<f64>>, Error> {
        Ok(plays(&scene.thresholds, signal))
    }

    fn chain(&self, scene: &Scene, _shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        Chain::of(
            ComponentBlueprint::new("prandtl-ishlinskii")
                .value("r", scene.thresholds.as_slice())
                .value("w", weights)
                .value("offset", offset),
        )
    }
}

//! Static Prandtl–Ishlinskii: weights of plays, everything linear.

use components::hysteresis::play::{Drive, Threshold, play};
use data::ComponentBlueprint;

use super::{Bank, Chain, FitContext, Method, Shape, Weights};
use crate::error::Error;

/// The method `prandtl-ishlinskii`.
pub(crate) struct PrandtlIshlinskii;

/// The plays of these thresholds, one column each.
pub(crate) fn plays(thresholds: Vec<f64>) -> Bank<'static> {
    let mut states = vec![0.0; thresholds.len()];
    Box::new(move |u, row| {
        for ((value, state), r) in row.iter_mut().zip(&mut states).zip(&thresholds) {
            *state = play(Drive(u), Threshold(*r), *state);
            *value = *state;
        }
    })
}

impl Method for PrandtlIshlinskii {
    fn name(&self) -> &'static str {
        "prandtl-ishlinskii"
    }

    fn summary(&self) -> &'static str {
        "Static Prandtl-Ishlinskii: symmetric, independent of rate; weights by least squares"
    }

    fn shape(&self, _scene: &FitContext) -> Vec<Shape> {
        Vec::new()
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

    fn least(&self, scene: &FitContext) -> f64 {
        scene.least_slope
    }

    fn tolerance(&self) -> Option<&'static str> {
        Some("w")
    }

    fn chain(&self, scene: &FitContext, _shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        Chain::of(
            ComponentBlueprint::new("prandtl-ishlinskii")
                .value("r", scene.thresholds.as_slice())
                .value("w", weights)
                .value("offset", offset),
        )
    }
}

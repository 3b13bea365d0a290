//! The generalised rate-dependent Prandtl–Ishlinskii model of the elliptical-cutting paper.
//!
//! Weights are linear; the envelopes are searched. A common factor of both slopes is one of all
//! thresholds, so a1 is 1 and b1 is relative to it.

use components::hysteresis::Grpi as Component;
use data::ComponentBlueprint;

use super::rate_dependent_play::growth;
use super::{Bank, Chain, Method, Scene, Shape, Weights, stepped};
use crate::error::Error;
use crate::fit::response::Part;

/// The method `grpi`.
pub(crate) struct Grpi;

impl Method for Grpi {
    fn name(&self) -> &'static str {
        "grpi"
    }

    fn summary(&self) -> &'static str {
        "Generalised rate-dependent Prandtl-Ishlinskii: envelopes with own slopes and rates"
    }

    fn shape(&self, scene: &Scene) -> Vec<Shape> {
        let most = growth(scene).upper;
        vec![
            Shape::new("hysteresis.a2", "s", 0.0, (-most, most)),
            Shape::new("hysteresis.b1", "1", 1.0, (0.8, 1.25)),
            Shape::new("hysteresis.b2", "s", 0.0, (-most, most)),
        ]
    }

    fn starts(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let most = growth(scene).upper;
        [0.0, 1e-4, 1e-3, 1e-2].map(|part| vec![-part * most, 1.0, part * most]).to_vec()
    }

    fn weights(&self, scene: &Scene) -> Weights {
        Weights::plays(&[], &scene.thresholds)
    }

    fn bank<'a>(&'a self, scene: &'a Scene, shape: &[f64], step: f64) -> Result<Bank<'a>, Error> {
        let r = scene.thresholds.as_slice();
        let parameters =
            [r, &vec![1.0; r.len()], &[0.0, 1.0, shape[0], shape[1], shape[2]]].concat();
        let part = Part::new(&Component, &[r.len() as f64], &parameters, step)?;
        Ok(stepped(part, |_, state, row| row.copy_from_slice(&state[..row.len()])))
    }

    fn chain(&self, scene: &Scene, shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        Chain::of(
            ComponentBlueprint::new("grpi")
                .value("r", scene.thresholds.as_slice())
                .value("w", weights)
                .value("offset", offset)
                .value("a1", 1.0)
                .value("a2", shape[0])
                .value("b1", shape[1])
                .value("b2", shape[2]),
        )
    }
}

//! The modified rate-dependent Prandtl–Ishlinskii model of the Gaussian-process paper.
//!
//! Linear and cubic coefficient (any sign) and weights are linear; the factor of all thresholds and
//! their growth with the rate are searched.

use components::hysteresis::Mpi as Component;
use data::ComponentBlueprint;

use super::rate_dependent_play::{above_zero, growth};
use super::{Bank, Chain, Method, PER_COMMAND, Scene, Shape, Weights, stepped};
use crate::error::Error;
use crate::fit::response::Part;

/// The method `mpi`.
pub(crate) struct Mpi;

impl Method for Mpi {
    fn name(&self) -> &'static str {
        "mpi"
    }

    fn summary(&self) -> &'static str {
        "Modified rate-dependent Prandtl-Ishlinskii: plays that widen with the rate, and a cubic"
    }

    fn shape(&self, scene: &Scene) -> Vec<Shape> {
        vec![Shape::new("hysteresis.scale", "1", 1.0, (0.3, 1.5)), growth(scene)]
    }

    fn starts(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let most = growth(scene).upper;
        [0.0, 1e-4, 1e-3, 1e-2].map(|part| vec![1.0, part * most]).to_vec()
    }

    fn weights(&self, scene: &Scene) -> Weights {
        let cubic = "{position}/{command}/{command}/{command}";
        let free = [("hysteresis.linear", PER_COMMAND), ("hysteresis.cubic", cubic)];
        Weights::plays(&free, above_zero(scene))
    }

    fn bank<'a>(&'a self, scene: &'a Scene, shape: &[f64], step: f64) -> Result<Bank<'a>, Error> {
        let r = above_zero(scene);
        let parameters = [r, &vec![1.0; r.len()], &[0.0, 0.0, 0.0, shape[0], shape[1]]].concat();
        let part = Part::new(&Component, &[r.len() as f64], &parameters, step)?;
        Ok(stepped(part, |u, state, row| {
            let (polynomial, plays) = row.split_at_mut(2);
            polynomial.copy_from_slice(&[u, u * u * u]);
            plays.copy_from_slice(&state[..plays.len()]);
        }))
    }

    fn chain(&self, scene: &Scene, shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        Chain::of(
            ComponentBlueprint::new("mpi")
                .value("r", above_zero(scene))
                .value("w", &weights[2..])
                .value("offset", offset)
                .value("linear", weights[0])
                .value("cubic", weights[1])
                .value("scale", shape[0])
                .value("rate", shape[1]),
        )
    }
}

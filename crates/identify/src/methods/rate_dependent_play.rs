//! Rate-dependent Prandtl–Ishlinskii: thresholds that grow with the rate.
//!
//! `y = offset + gain·u + Σ w_i F_i`, thresholds r_i + rate·|u̇|: gain and weights are linear, the rate
//! is searched. The play of threshold 0 is left to the gain.

use components::hysteresis::RateDependentPlay as Component;
use data::ComponentBlueprint;

use super::{Bank, Chain, Method, PER_COMMAND, Scene, Shape, Weights, stepped};
use crate::error::Error;
use crate::fit::response::Part;

/// The method `rate-dependent-play`.
pub(crate) struct RateDependentPlay;

/// Thresholds above 0.
pub(super) fn above_zero(scene: &Scene) -> &[f64] {
    match scene.thresholds.as_slice() {
        [0.0, above @ ..] if !above.is_empty() => above,
        all => all,
    }
}

/// Bounds and start of the growth of thresholds with the rate, in s: a command that crosses its range
/// within the time fitted on may move them by half the range.
pub(super) fn growth(scene: &Scene) -> Shape {
    Shape::new("hysteresis.rate", "s", 0.0, (0.0, 0.05 * scene.duration))
}

impl Method for RateDependentPlay {
    fn name(&self) -> &'static str {
        "rate-dependent-play"
    }

    fn summary(&self) -> &'static str {
        "Rate-dependent Prandtl-Ishlinskii: the loop widens with the command's rate"
    }

    fn shape(&self, scene: &Scene) -> Vec<Shape> {
        vec![growth(scene)]
    }

    fn starts(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let most = growth(scene).upper;
        vec![vec![0.0], vec![1e-4 * most], vec![1e-3 * most], vec![1e-2 * most]]
    }

    fn weights(&self, scene: &Scene) -> Weights {
        let mut weights = Weights::plays(&[], above_zero(scene));
        weights.names.insert(0, ("hysteresis.gain".to_owned(), PER_COMMAND));
        weights
    }

    fn bank<'a>(&'a self, scene: &'a Scene, shape: &[f64], step: f64) -> Result<Bank<'a>, Error> {
        let r = above_zero(scene);
        let parameters = [r, &vec![1.0; r.len()], &[0.0, 0.0, shape[0]]].concat();
        let part = Part::new(&Component, &[r.len() as f64], &parameters, step)?;
        Ok(stepped(part, |u, state, row| {
            let (gain, plays) = row.split_at_mut(1);
            gain[0] = u;
            plays.copy_from_slice(&state[..plays.len()]);
        }))
    }

    fn chain(&self, scene: &Scene, shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        Chain::of(
            ComponentBlueprint::new("rate-dependent-play")
                .value("r", above_zero(scene))
                .value("w", &weights[1..])
                .value("offset", offset)
                .value("gain", weights[0])
                .value("rate", shape[0]),
        )
    }
}

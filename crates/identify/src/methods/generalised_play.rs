//! Generalised (asymmetric, saturating) plays.
//!
//! Weights are linear; the envelopes are searched. A common factor of both envelopes is one of all
//! thresholds and weights, so each envelope has slope 1 at its steepest point; it passes through the
//! middle of the command's range, the falling one `gap` to the right.

use components::hysteresis::GeneralisedPlay as Component;
use data::ComponentBlueprint;

use super::{Bank, Chain, FitContext, Method, Shape, Weights, stepped};
use crate::error::Error;
use crate::fit::response::Part;

/// The method `generalised-play`.
pub(crate) struct GeneralisedPlay;

/// a0 … a3 of the rising and of the falling envelope.
fn envelopes(scene: &FitContext, shape: &[f64]) -> [f64; 8] {
    let (centre, _) = scene.centre();
    let envelope = |steepness: f64, shift: f64, height: f64| {
        let a0 = 1.0 / steepness;
        [a0, steepness, shift - steepness * centre, centre + height - a0 * shift.tanh()]
    };
    let [a, b, c, d] = envelope(shape[0], shape[1], 0.0);
    let [e, f, g, h] = envelope(shape[2], shape[3], shape[4]);
    [a, b, c, d, e, f, g, h]
}

impl Method for GeneralisedPlay {
    fn name(&self) -> &'static str {
        "generalised-play"
    }

    fn summary(&self) -> &'static str {
        "Generalised plays between hyperbolic tangents: asymmetric and saturating"
    }

    fn shape(&self, scene: &FitContext) -> Vec<Shape> {
        let (_, half) = scene.centre();
        let steep = (0.01 / half, 1.0 / half);
        vec![
            Shape::new("hysteresis.left_a1", "1/{command}", 0.2 / half, steep),
            Shape::new("shift of the rising envelope", "1", 0.0, (-1.0, 1.0)),
            Shape::new("hysteresis.right_a1", "1/{command}", 0.2 / half, steep),
            Shape::new("shift of the falling envelope", "1", 0.0, (-1.0, 1.0)),
            Shape::new("gap of the envelopes", "{command}", 0.0, (0.0, 0.5 * half)),
        ]
    }

    fn weights(&self, scene: &FitContext) -> Weights {
        Weights::plays(&[], &scene.thresholds)
    }

    fn bank<'a>(
        &'a self,
        scene: &'a FitContext,
        shape: &[f64],
        step: f64,
    ) -> Result<Bank<'a>, Error> {
        let r = scene.thresholds.as_slice();
        let parameters = [r, &vec![1.0; r.len()], &[0.0], &envelopes(scene, shape)[..]].concat();
        let part = Part::new(&Component, &[r.len() as f64], &parameters, step)?;
        Ok(stepped(part, |_, state, row| row.copy_from_slice(&state[2..2 + row.len()])))
    }

    fn chain(&self, scene: &FitContext, shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        let mut component = ComponentBlueprint::new("generalised-play")
            .value("r", scene.thresholds.as_slice())
            .value("w", weights)
            .value("offset", offset);
        let names = ["a0", "a1", "a2", "a3"];
        let both = ["left", "right"].into_iter().flat_map(|side| names.map(|n| (side, n)));
        for ((side, name), value) in both.zip(envelopes(scene, shape)) {
            component = component.value(&format!("{side}_{name}"), value);
        }
        Chain::of(component)
    }
}

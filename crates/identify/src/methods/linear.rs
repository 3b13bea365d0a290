//! A gain: the model without hysteresis.

use data::ComponentBlueprint;

use super::{Bank, Chain, FitContext, LINEAR, Method, PER_COMMAND, Shape, Weights};
use crate::error::Error;

/// The method `linear`: `y = gain·u + offset`.
pub(crate) struct Linear;

impl Method for Linear {
    fn name(&self) -> &'static str {
        LINEAR
    }

    fn summary(&self) -> &'static str {
        "Gain, delay, lag and mode without hysteresis"
    }

    fn shape(&self, _scene: &FitContext) -> Vec<Shape> {
        Vec::new()
    }

    fn weights(&self, _scene: &FitContext) -> Weights {
        Weights { names: vec![("gain.gain".to_owned(), PER_COMMAND)], ..Weights::default() }
    }

    fn bank<'a>(
        &'a self,
        _scene: &'a FitContext,
        _shape: &[f64],
        _step: f64,
    ) -> Result<Bank<'a>, Error> {
        Ok(Box::new(|u, row| row[0] = u))
    }

    fn least(&self, scene: &FitContext) -> f64 {
        scene.least_slope
    }

    fn chain(&self, _scene: &FitContext, _shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        Chain::of(
            ComponentBlueprint::new("actuator-gain")
                .value("gain", weights[0])
                .value("offset", offset),
        )
    }
}

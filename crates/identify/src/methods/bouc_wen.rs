//! Bouc–Wen, symmetric or asymmetric, with exponent 1.
//!
//! `y = offset + gain·u − slope·h`, h the hysteretic variable for a slope of 1 after a reversal: gain
//! and slope = alpha·gain are linear. Searched are `decay` = beta + gamma, the ratio gamma/beta and
//! delta as a part of the smaller of beta and decay, so that every point of the search is a bounded
//! model.

use components::hysteresis::BoucWen as Component;
use data::ComponentBlueprint;

use super::{Bank, Chain, FitContext, Method, PER_COMMAND, Shape, Weights, stepped};
use crate::error::Error;
use crate::fit::response::Part;

/// The methods `bouc-wen` and `bouc-wen-asymmetric`.
pub(crate) struct BoucWen {
    pub(crate) asymmetric: bool,
}

/// beta, gamma, delta of a shape.
fn law(shape: &[f64]) -> [f64; 3] {
    let &[decay, ratio, ref rest @ ..] = shape else { return [1.0, 0.0, 0.0] };
    let beta = decay / (1.0 + ratio);
    let delta = rest.first().map_or(0.0, |part| part * beta.min(decay));
    [beta, decay - beta, delta]
}

impl Method for BoucWen {
    fn name(&self) -> &'static str {
        if self.asymmetric { "bouc-wen-asymmetric" } else { "bouc-wen" }
    }

    fn summary(&self) -> &'static str {
        if self.asymmetric {
            "Asymmetric Bouc-Wen: seven parameters, rising and falling branch differ"
        } else {
            "Bouc-Wen: six parameters, symmetric, independent of rate"
        }
    }

    fn shape(&self, scene: &FitContext) -> Vec<Shape> {
        let (_, half) = scene.centre();
        let mut all = vec![
            Shape::new("beta + gamma", "1/{command}", 1.5 / half, (0.02 / half, 50.0 / half)),
            Shape::new("gamma/beta", "1", 0.0, (-0.98, 5.0)),
        ];
        if self.asymmetric {
            all.push(Shape::new("delta/min(beta, beta + gamma)", "1", 0.0, (-0.95, 0.95)));
        }
        all
    }

    fn starts(&self, scene: &FitContext) -> Vec<Vec<f64>> {
        let (_, half) = scene.centre();
        let mut all = Vec::new();
        for decay in [0.5, 1.5, 4.0] {
            for ratio in [-0.6, 0.0, 0.5] {
                let mut start = vec![decay / half, ratio];
                start.extend(self.asymmetric.then_some(0.0));
                all.push(start);
            }
        }
        all
    }

    fn weights(&self, _scene: &FitContext) -> Weights {
        let names = ["hysteresis.gain", "hysteresis.alpha*gain"];
        Weights { names: names.map(|n| (n.to_owned(), PER_COMMAND)).to_vec(), ..Weights::default() }
    }

    fn bank<'a>(
        &'a self,
        _scene: &'a FitContext,
        shape: &[f64],
        step: f64,
    ) -> Result<Bank<'a>, Error> {
        let [beta, gamma, delta] = law(shape);
        let part = Part::new(&Component, &[], &[1.0, 1.0, beta, gamma, delta, 1.0, 0.0], step)?;
        Ok(stepped(part, |u, state, row| {
            row.copy_from_slice(&[u, -state.first().copied().unwrap_or(0.0)]);
        }))
    }

    fn chain(&self, _scene: &FitContext, shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        let [beta, gamma, delta] = law(shape);
        let (gain, slope) = (weights[0], weights[1]);
        Chain::of(
            ComponentBlueprint::new("bouc-wen")
                .value("gain", gain)
                .value("alpha", slope / gain)
                .value("beta", beta)
                .value("gamma", gamma)
                .value("delta", delta)
                .value("offset", offset),
        )
    }
}

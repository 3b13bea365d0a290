//! Operators of plays that declare how they are fitted ([`model::Fit`]).
//!
//! `y = offset + Σ c_k·u^k + Σ w_i P_i`: the factors c and the weights w are linear, what the plays depend on beside
//! their thresholds is searched. With a part without memory, the play of threshold 0 is left to that part.

use components::COMPONENTS;
use data::ComponentBlueprint;
use model::{Component, Fit, Quantity, Role, Scale};

use super::{Bank, Chain, FitContext, Method, Shape, Weights, stepped};
use crate::error::Error;
use crate::fit::response::Part;

/// The method of the name of such a component.
pub(crate) struct Declared {
    component: &'static dyn Component,
    fit: &'static Fit,
}

impl Declared {
    /// One per component of the registry that declares it.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let of = |component: &'static dyn Component| Some((component, component.fit()?));
        COMPONENTS.iter().copied().filter_map(of).map(|(component, fit)| Self { component, fit })
    }

    fn quantity(&self, name: &str) -> Option<&'static Quantity> {
        self.component.declaration().parameters.iter().find(|quantity| quantity.name == name)
    }

    fn thresholds<'a>(&self, scene: &'a FitContext) -> &'a [f64] {
        match scene.thresholds.as_slice() {
            [0.0, above @ ..] if !above.is_empty() && !self.fit.powers.is_empty() => above,
            all => all,
        }
    }

    /// What a searched parameter is counted in.
    fn scale(scene: &FitContext, scale: Scale) -> f64 {
        match scale {
            Scale::Own => 1.0,
            Scale::Growth => 0.05 * scene.duration,
        }
    }

    /// Values of the searched parameter of this name.
    fn searched(&self, shape: &[f64], name: &str) -> Option<f64> {
        let at = self.fit.search.iter().position(|searched| searched.name == name)?;
        shape.get(at).copied()
    }
}

impl Method for Declared {
    fn name(&self) -> &'static str {
        let declaration = self.component.declaration();
        declaration.kind
    }

    fn summary(&self) -> &'static str {
        self.fit.summary
    }

    fn shape(&self, scene: &FitContext) -> Vec<Shape> {
        let of = |searched: &model::Search| {
            let scale = Self::scale(scene, searched.scale);
            let unit = self.quantity(searched.name).map_or("1", |quantity| quantity.unit);
            let bounds = (searched.lower * scale, searched.upper * scale);
            Shape::new(
                format!("hysteresis.{}", searched.name),
                unit,
                searched.start * scale,
                bounds,
            )
        };
        self.fit.search.iter().map(of).collect()
    }

    fn starts(&self, scene: &FitContext) -> Vec<Vec<f64>> {
        let scales = || self.fit.search.iter().map(|searched| Self::scale(scene, searched.scale));
        let scaled =
            |start: &&[f64]| start.iter().zip(scales()).map(|(x, scale)| x * scale).collect();
        self.fit.starts.iter().map(scaled).collect()
    }

    fn weights(&self, scene: &FitContext) -> Weights {
        let of = |(name, _): &(&str, i32)| {
            let quantity = self.quantity(name);
            let unit = quantity.map_or("1", |quantity| quantity.unit);
            (
                format!("hysteresis.{name}"),
                unit,
                quantity.is_some_and(|quantity| quantity.min < 0.0),
            )
        };
        let powers: Vec<_> = self.fit.powers.iter().map(of).collect();
        let mut weights = Weights::plays(&[], self.thresholds(scene));
        weights.free = powers.iter().filter(|power| power.2).count();
        weights.names.splice(0..0, powers.into_iter().map(|(name, unit, _)| (name, unit)));
        weights
    }

    fn bank<'a>(
        &'a self,
        scene: &'a FitContext,
        shape: &[f64],
        step: f64,
    ) -> Result<Bank<'a>, Error> {
        let r = self.thresholds(scene);
        let of = |quantity: &Quantity| match quantity.role {
            Some(Role::Threshold) => r.to_vec(),
            Some(Role::Weight) => vec![1.0; r.len()],
            _ if self.fit.powers.iter().any(|power| power.0 == quantity.name) => vec![0.0],
            _ => vec![self.searched(shape, quantity.name).or(quantity.start).unwrap_or(0.0)],
        };
        let declaration = self.component.declaration();
        let parameters: Vec<f64> = declaration.parameters.iter().flat_map(of).collect();
        let part = Part::new(self.component, &[r.len() as f64], &parameters, step)?;
        let powers: Vec<i32> = self.fit.powers.iter().map(|power| power.1).collect();
        Ok(stepped(part, move |u, state, row| {
            let (polynomial, plays) = row.split_at_mut(powers.len());
            for (value, power) in polynomial.iter_mut().zip(&powers) {
                *value = (1..*power).fold(u, |product, _| product * u);
            }
            plays.copy_from_slice(&state[..plays.len()]);
        }))
    }

    fn chain(&self, scene: &FitContext, shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        let (powers, plays) = weights.split_at(self.fit.powers.len());
        let factor = |name: &str| {
            let at = self.fit.powers.iter().position(|power| power.0 == name)?;
            powers.get(at).copied()
        };
        let declaration = self.component.declaration();
        let hysteresis = ComponentBlueprint::new(declaration.kind);
        Chain::of(declaration.parameters.iter().fold(hysteresis, |part, quantity| {
            let name = quantity.name;
            match quantity.role {
                Some(Role::Threshold) => part.value(name, self.thresholds(scene)),
                Some(Role::Weight) => part.value(name, plays),
                _ if name == "offset" => part.value(name, offset),
                _ => match self.searched(shape, name).or_else(|| factor(name)).or(quantity.start) {
                    Some(value) => part.value(name, value),
                    None => part,
                },
            }
        }))
    }
}

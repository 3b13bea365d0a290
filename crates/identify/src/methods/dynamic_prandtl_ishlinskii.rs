//! The dynamic Prandtl–Ishlinskii model of the elliptical-cutting paper: everything is linear.
//!
//! `y = offset + Σ w_i P_i + Σ_s (alpha_s·u̇ + beta_s·ü)·1_s·Σ P_i`. The paper searches alpha and beta by
//! particle swarm; as they enter linearly, least squares finds the same minimum at once.

use components::hysteresis::rate;
use data::ComponentBlueprint;

use super::prandtl_ishlinskii::plays;
use super::{Bank, Chain, FitContext, Method, Shape, Weights};
use crate::error::Error;

/// The method `dynamic-prandtl-ishlinskii`.
pub(crate) struct DynamicPrandtlIshlinskii;

const ALPHA: &str = "{position}.s/{command}/{command}";
const BETA: &str = "{position}.s2/{command}/{command}";

/// Segment (from 0) by the signs of rate and acceleration, as in the component.
pub(crate) fn segment(rate: f64, acceleration: f64) -> usize {
    match (rate >= 0.0, acceleration) {
        (true, a) if a >= 0.0 => 0,
        (true, _) => 1,
        (false, a) if a <= 0.0 => 2,
        (false, _) => 3,
    }
}

impl Method for DynamicPrandtlIshlinskii {
    fn name(&self) -> &'static str {
        "dynamic-prandtl-ishlinskii"
    }

    fn summary(&self) -> &'static str {
        "Dynamic Prandtl-Ishlinskii: weights that follow the command's rate and acceleration"
    }

    fn shape(&self, _scene: &FitContext) -> Vec<Shape> {
        Vec::new()
    }

    fn weights(&self, scene: &FitContext) -> Weights {
        let mut weights = Weights::plays(&[], &scene.thresholds);
        let names = |name: &'static str, unit: &'static str| {
            (1..=4).map(move |s| (format!("hysteresis.{name}[{s}]"), unit))
        };
        weights.free = 8;
        weights.names.splice(0..0, names("alpha", ALPHA).chain(names("beta", BETA)));
        weights
    }

    fn bank<'a>(
        &'a self,
        scene: &'a FitContext,
        _shape: &[f64],
        step: f64,
    ) -> Result<Bank<'a>, Error> {
        let mut plays = plays(scene.thresholds.clone());
        let mut memory = None;
        let mut acceleration = 0.0;
        Ok(Box::new(move |u, row| {
            // The first value is the rest; then as the component does.
            let memory = match &mut memory {
                None => memory.insert(rate::rest(u)),
                Some(memory) => {
                    acceleration = rate::step(memory, u, 1.0 / step).unwrap_or(acceleration);
                    memory
                }
            };
            let rate = memory[1];
            let (dynamic, own) = row.split_at_mut(8);
            plays(u, own);
            let sum: f64 = own.iter().sum();
            let here = segment(rate, acceleration);
            for s in 0..4 {
                let on = if s == here { sum } else { 0.0 };
                (dynamic[s], dynamic[4 + s]) = (on * rate, on * acceleration);
            }
        }))
    }

    fn chain(&self, scene: &FitContext, _shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        Chain::of(
            ComponentBlueprint::new("dynamic-prandtl-ishlinskii")
                .value("r", scene.thresholds.as_slice())
                .value("w", &weights[8..])
                .value("alpha", &weights[..4])
                .value("beta", &weights[4..8])
                .value("offset", offset),
        )
    }
}

//! The dynamic Prandtl–Ishlinskii model of the elliptical-cutting paper: everything is linear.
//!
//! `y = offset + Σ w_i P_i + Σ_s (alpha_s·u̇ + beta_s·ü)·1_s·Σ P_i`. The paper searches alpha and beta by
//! particle swarm; as they enter linearly, least squares finds the same minimum at once.

use components::hysteresis::play::play;
use components::hysteresis::rate;
use data::ComponentBlueprint;

use super::{Chain, Method, Scene, Shape, Weights};
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

    fn shape(&self, _scene: &Scene) -> Vec<Shape> {
        Vec::new()
    }

    fn weights(&self, scene: &Scene) -> Weights {
        let mut weights = Weights::plays(&[], scene.thresholds.len());
        let names = |name: &'static str, unit: &'static str| {
            (1..=4).map(move |s| (format!("hysteresis.{name}[{s}]"), unit))
        };
        weights.free = 8;
        weights.names.splice(0..0, names("alpha", ALPHA).chain(names("beta", BETA)));
        weights
    }

    fn columns(
        &self,
        scene: &Scene,
        _shape: &[f64],
        signal: &[f64],
        step: f64,
    ) -> Result<Vec<Vec<f64>>, Error> {
        let count = scene.thresholds.len();
        let mut columns = vec![Vec::with_capacity(signal.len()); 8 + count];
        let mut plays = vec![0.0; count];
        let mut memory = rate::rest(signal.first().copied().unwrap_or(0.0));
        let mut acceleration = 0.0;
        for (k, &u) in signal.iter().enumerate() {
            // The first value is the rest; then as the component does.
            if k > 0
                && let Some(new) = rate::step(&mut memory, u, 1.0 / step)
            {
                acceleration = new;
            }
            let rate = memory[1];
            for ((p, r), column) in plays.iter_mut().zip(&scene.thresholds).zip(&mut columns[8..]) {
                *p = play(u, *r, *p);
                column.push(*p);
            }
            let sum: f64 = plays.iter().sum();
            let here = segment(rate, acceleration);
            for s in 0..4 {
                let on = if s == here { sum } else { 0.0 };
                columns[s].push(on * rate);
                columns[4 + s].push(on * acceleration);
            }
        }
        Ok(columns)
    }

    fn chain(&self, scene: &Scene, _shape: &[f64], weights: &[f64], offset: f64) -> Chain {
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

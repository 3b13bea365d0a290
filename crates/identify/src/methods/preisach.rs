//! Discrete Preisach: the weights of all relays, by non-negative least squares.
//!
//! A log that lacks first-order reversal curves leaves most relays unknown. The penalty, small beside
//! the data, gives each relay that nothing moves the mean of its neighbours.

use data::ComponentBlueprint;

use super::{Chain, Method, Scene, Shape, Weights};
use crate::error::Error;

/// The method `preisach`.
pub(crate) struct Preisach;

/// Weight of the penalty, in parts of one sample.
const PENALTY: f64 = 0.03;

/// Index of relay (i, j), 1 ≤ j ≤ i.
fn index(i: usize, j: usize) -> usize {
    i * (i - 1) / 2 + j - 1
}

fn relays(levels: usize) -> usize {
    levels * (levels + 1) / 2
}

/// Command range that the levels divide: half a level wider than the commands on both sides.
fn range(scene: &Scene) -> [f64; 2] {
    let [low, high] = scene.command;
    let half = 0.5 * (high - low) / scene.levels as f64;
    [low - half, high + half]
}

/// The component with these weights.
pub(crate) fn preisach_of(mu: &[f64], [low, high]: [f64; 2], offset: f64) -> ComponentBlueprint {
    ComponentBlueprint::new("preisach")
        .value("mu", mu)
        .value("low", low)
        .value("high", high)
        .value("offset", offset)
}

impl Method for Preisach {
    fn name(&self) -> &'static str {
        "preisach"
    }

    fn summary(&self) -> &'static str {
        "Discrete Preisach: relays weighted by non-negative least squares; output in stairs"
    }

    fn shape(&self, _scene: &Scene) -> Vec<Shape> {
        Vec::new()
    }

    fn weights(&self, scene: &Scene) -> Weights {
        let names =
            (1..=relays(scene.levels)).map(|i| (format!("hysteresis.mu[{i}]"), "{position}"));
        Weights { free: 0, names: names.collect() }
    }

    fn columns(
        &self,
        scene: &Scene,
        _shape: &[f64],
        signal: &[f64],
        _step: f64,
    ) -> Result<Vec<Vec<f64>>, Error> {
        let [low, high] = range(scene);
        let levels = scene.levels;
        let per_command = levels as f64 / (high - low);
        let mut on = vec![0.0; relays(levels)];
        let mut columns = vec![Vec::with_capacity(signal.len()); on.len()];
        for &u in signal {
            let level = (((u - low) * per_command).floor() as usize).min(levels);
            for i in 1..=levels {
                for j in 1..=i {
                    if level >= i {
                        on[index(i, j)] = 1.0;
                    } else if level < j {
                        on[index(i, j)] = 0.0;
                    }
                }
            }
            for (column, value) in columns.iter_mut().zip(&on) {
                column.push(*value);
            }
        }
        Ok(columns)
    }

    fn penalty(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let count = relays(scene.levels);
        let mut rows = Vec::new();
        for i in 1..scene.levels {
            for j in 1..=i {
                for neighbour in [index(i + 1, j), index(i + 1, j + 1)] {
                    // The diagonal is the part without memory, no part of the density.
                    if i == j || neighbour == index(i + 1, i + 1) {
                        continue;
                    }
                    let mut row = vec![0.0; count];
                    (row[index(i, j)], row[neighbour]) = (PENALTY, -PENALTY);
                    rows.push(row);
                }
            }
        }
        rows
    }

    fn chain(&self, scene: &Scene, _shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        Chain::of(preisach_of(weights, range(scene), offset))
    }
}

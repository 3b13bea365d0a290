//! Discrete Preisach: the weights of all relays, by non-negative least squares.
//!
//! The density of the relays is constant in cells: `levels` of them to a side are fitted, and each is a square of finer
//! relays with the same weight, [`FINE`] levels in all. So the output has stairs of 1/120 of the range, while the log
//! has to tell a few hundred cells apart only. A cell on the diagonal is the part without memory; its weight lies on
//! the relays that switch on and off at the same command.
//!
//! A log that lacks first-order reversal curves leaves most cells unknown. The penalty, small beside
//! the data, gives each cell that nothing moves the mean of its neighbours.

use data::ComponentBlueprint;

use super::{Bank, Chain, FitContext, Method, Shape, Weights};
use crate::error::Error;

/// The method `preisach`.
pub(crate) struct Preisach;

/// Weight of the penalty, in parts of one sample.
const PENALTY: f64 = 0.03;
/// Most levels of the relays.
const FINE: usize = 120;

/// Index of relay or cell (i, j), 1 ≤ j ≤ i.
fn index(i: usize, j: usize) -> usize {
    i * (i - 1) / 2 + j - 1
}

fn relays(levels: usize) -> usize {
    levels * (levels + 1) / 2
}

/// Relays to the side of a cell.
fn side(levels: usize) -> usize {
    (FINE / levels.max(1)).max(1)
}

/// Command range that the levels divide: half a level wider than the commands on both sides.
fn range(scene: &FitContext) -> [f64; 2] {
    let [low, high] = scene.command;
    let half = 0.5 * (high - low) / (scene.levels * side(scene.levels)) as f64;
    [low - half, high + half]
}

/// The cell of relay (i, j), and the relay's part of its weight; `None` where it has none.
fn cell(i: usize, j: usize, side: usize) -> Option<(usize, f64)> {
    let (row, column) = (i.div_ceil(side), j.div_ceil(side));
    let number = side as f64;
    match (row == column, i == j) {
        (true, false) => None,
        (true, true) => Some((index(row, column), 1.0 / number)),
        (false, _) => Some((index(row, column), 1.0 / (number * number))),
    }
}

/// The weights of the relays from those of the cells.
fn spread(cells: &[f64], levels: usize) -> Vec<f64> {
    let side = side(levels);
    let mut mu = Vec::with_capacity(relays(levels * side));
    for i in 1..=levels * side {
        for j in 1..=i {
            mu.push(cell(i, j, side).map_or(0.0, |(at, part)| part * cells[at]));
        }
    }
    mu
}

/// The relays, and for each cell the part of its weight that is switched on.
struct Relays {
    side: usize,
    levels: usize,
    on: Vec<bool>,
    parts: Vec<f64>,
    level: usize,
}

impl Relays {
    /// All off.
    fn new(levels: usize) -> Self {
        let side = side(levels);
        let fine = levels * side;
        let (on, parts) = (vec![false; relays(fine)], vec![0.0; relays(levels)]);
        Self { side, levels: fine, on, parts, level: 0 }
    }

    fn switch(&mut self, i: usize, j: usize, to: bool) {
        let now = &mut self.on[index(i, j)];
        if *now != to {
            *now = to;
            if let Some((at, part)) = cell(i, j, self.side) {
                self.parts[at] += if to { part } else { -part };
            }
        }
    }

    fn step(&mut self, level: usize) {
        let level = level.min(self.levels);
        for i in self.level + 1..=level {
            (1..=i).for_each(|j| self.switch(i, j, true));
        }
        for j in level + 1..=self.level {
            (j..=self.levels).for_each(|i| self.switch(i, j, false));
        }
        self.level = level;
    }
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
        "Discrete Preisach: relays weighted by non-negative least squares; output in small stairs"
    }

    fn shape(&self, _scene: &FitContext) -> Vec<Shape> {
        Vec::new()
    }

    fn weights(&self, scene: &FitContext) -> Weights {
        let names =
            (1..=relays(scene.levels)).map(|i| (format!("hysteresis.cell[{i}]"), "{position}"));
        Weights { names: names.collect(), ..Weights::default() }
    }

    fn bank<'a>(
        &'a self,
        scene: &'a FitContext,
        _shape: &[f64],
        _step: f64,
    ) -> Result<Bank<'a>, Error> {
        let [low, high] = range(scene);
        let mut relays = Relays::new(scene.levels);
        let per_command = relays.levels as f64 / (high - low);
        Ok(Box::new(move |u, row| {
            relays.step(((u - low) * per_command).floor() as usize);
            row.copy_from_slice(&relays.parts);
        }))
    }

    fn penalty(&self, scene: &FitContext) -> Vec<Vec<f64>> {
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

    fn chain(&self, scene: &FitContext, _shape: &[f64], weights: &[f64], offset: f64) -> Chain {
        Chain::of(preisach_of(&spread(weights, scene.levels), range(scene), offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::response::Part;

    /// The columns with weights are what the component answers, also deep in minor loops and beyond the range.
    #[test]
    fn cells_are_the_relays_of_the_component() {
        for levels in [2, 7, 20, 60] {
            let scene = FitContext {
                command: [-10.0, 30.0],
                position: [0.0, 1.0],
                zero: 0.0,
                duration: 1.0,
                thresholds: vec![0.0],
                levels,
                least_slope: 0.0,
            };
            let wave = |k: i32| {
                let k = f64::from(k);
                10.0 + (22.0 - 0.03 * k) * (0.1 * k).sin() + 3.0 * (0.37 * k).sin()
            };
            let signal: Vec<f64> = (0..600).map(wave).collect();
            let mut bank = Preisach.bank(&scene, &[], 1.0).expect("columns");
            let mut row = vec![0.0; relays(levels)];
            let weights: Vec<f64> = (0..row.len()).map(|i| 0.1 + (i % 7) as f64).collect();
            let mu = spread(&weights, levels);
            let structure = [mu.len() as f64];
            let parameters = [&mu[..], &range(&scene), &[0.5]].concat();
            let component = &components::hysteresis::Preisach;
            let mut part = Part::new(component, &structure, &parameters, 1.0).expect("parameters");
            for (k, u) in signal.iter().enumerate() {
                let found = if k == 0 { part.rest(*u) } else { part.step(*u) };
                bank(*u, &mut row);
                let sum: f64 = row.iter().zip(&weights).map(|(c, w)| c * w).sum();
                assert!(
                    (found - 0.5 - sum).abs() < 1e-9 * weights.iter().sum::<f64>(),
                    "{levels}: {k}"
                );
            }
        }
    }
}

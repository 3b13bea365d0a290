//! The classical Preisach model on a plane of relays, as the stop-operator paper compares with.
//!
//! ```text
//! y = y0 + Σ_ij w_ij γ_ij[u],   γ_ij on from u ≥ α_i, off from u ≤ β_j ≤ α_i,   w_ij ≥ 0
//! ```
//!
//! L levels are n = L(L + 1)/2 relays. Weights by a fixed number of descents, weight by weight from zero: there are more
//! relays than records tell apart, and an exact solution would put all weight on a few. Relays that switch at the same
//! samples of all records have the same weight.

use std::collections::HashMap;

/// A plane of relays with their weights.
pub(crate) struct Relays {
    /// Ends of the cells.
    levels: Vec<f64>,
    /// w_ij, i from 0, j from 0 to i.
    weights: Vec<f64>,
    offset: f64,
}

/// Sweeps over all weights.
const SWEEPS: usize = 300;

/// The relays under one command after the other, from rest at 0, when all are off.
struct Plane<'a> {
    levels: &'a [f64],
    on: Vec<bool>,
}

impl<'a> Plane<'a> {
    fn new(levels: &'a [f64]) -> Self {
        let count = levels.len() * (levels.len() - 1) / 2;
        Self { levels, on: vec![false; count] }
    }

    /// Switches on and off, relay by relay, as a controller without memory of extremes does it.
    fn step(&mut self, u: f64) {
        let mut at = 0;
        for i in 1..self.levels.len() {
            for off in &self.levels[..i] {
                // In the middle of the cell.
                if u >= self.levels[i] {
                    self.on[at] = true;
                } else if u <= *off {
                    self.on[at] = false;
                }
                at += 1;
            }
        }
    }
}

impl Relays {
    /// Number of relays.
    pub(crate) fn count(&self) -> usize {
        self.weights.len()
    }

    /// The model of least squares with so many levels between 0 and `top` over these records of command and position.
    pub(crate) fn fit(levels: usize, top: f64, records: &[(&[f64], &[f64])]) -> Self {
        let levels: Vec<f64> = (0..=levels).map(|k| top * k as f64 / levels as f64).collect();
        let y: Vec<f64> = records.iter().flat_map(|(_, y)| y.iter().copied()).collect();
        let rows = y.len();
        let count = levels.len() * (levels.len() - 1) / 2;
        // Rows at which each relay is on, as bits.
        let words = rows.div_ceil(64);
        let mut bits = vec![vec![0_u64; words]; count];
        let mut row = 0;
        for (u, _) in records {
            let mut plane = Plane::new(&levels);
            for u in *u {
                plane.step(*u);
                for (bits, on) in bits.iter_mut().zip(&plane.on) {
                    bits[row / 64] |= u64::from(*on) << (row % 64);
                }
                row += 1;
            }
        }
        let mut alike: HashMap<&[u64], usize> = HashMap::new();
        let mut group = Vec::with_capacity(count);
        for bits in &bits {
            let next = alike.len();
            group.push(*alike.entry(bits).or_insert(next));
        }
        let mut columns: Vec<Vec<usize>> = vec![Vec::new(); alike.len()];
        for (bits, number) in &alike {
            columns[*number] = (0..rows).filter(|k| bits[k / 64] >> (k % 64) & 1 == 1).collect();
        }
        let mut members = vec![0.0_f64; columns.len()];
        group.iter().for_each(|number| members[*number] += 1.0);
        let (shared, offset) = descended(&columns, &y);
        let weights = group.iter().map(|number| shared[*number] / members[*number]).collect();
        Self { levels, weights, offset }
    }

    /// Positions at the end of each sample, all relays off before the first.
    pub(crate) fn simulate(&self, command: &[f64]) -> Vec<f64> {
        let mut plane = Plane::new(&self.levels);
        let answer = |u: &f64| {
            plane.step(*u);
            self.position(&plane)
        };
        command.iter().map(answer).collect()
    }

    fn position(&self, plane: &Plane<'_>) -> f64 {
        let on = plane.on.iter().zip(&self.weights);
        self.offset + on.map(|(on, w)| if *on { *w } else { 0.0 }).sum::<f64>()
    }

    /// Commands that lead to these positions, level by level and on a line between two levels.
    pub(crate) fn inverse(&self, positions: &[f64]) -> Vec<f64> {
        let mut plane = Plane::new(&self.levels);
        let mut all = Vec::with_capacity(positions.len());
        let mut at = 0.0_f64;
        for wanted in positions {
            let rises = *wanted > self.position(&plane);
            let mut before = (at, self.position(&plane));
            let others: Vec<f64> = match rises {
                true => self.levels.iter().copied().filter(|u| *u > at).collect(),
                false => self.levels.iter().rev().copied().filter(|u| *u < at).collect(),
            };
            for u in others {
                let on = plane.on.clone();
                plane.step(u);
                let y = self.position(&plane);
                if (y >= *wanted) == rises {
                    // Between the two: the relays stay as they were.
                    let part =
                        if y == before.1 { 1.0 } else { (wanted - before.1) / (y - before.1) };
                    at = before.0 + part.clamp(0.0, 1.0) * (u - before.0);
                    plane.on = on;
                    break;
                }
                before = (u, y);
                at = u;
            }
            all.push(at);
        }
        all
    }
}

/// Weights ≥ 0 of columns that are 1 at these rows, and an offset, after [`SWEEPS`] descents from zero.
fn descended(columns: &[Vec<usize>], y: &[f64]) -> (Vec<f64>, f64) {
    let (mut weights, mut offset) = (vec![0.0; columns.len()], 0.0);
    let mut left = y.to_vec();
    for _ in 0..SWEEPS {
        let mean = left.iter().sum::<f64>() / left.len().max(1) as f64;
        offset += mean;
        left.iter_mut().for_each(|e| *e -= mean);
        for (weight, rows) in weights.iter_mut().zip(columns) {
            if rows.is_empty() {
                continue;
            }
            let slope = rows.iter().map(|k| left[*k]).sum::<f64>() / rows.len() as f64;
            let change = slope.max(-*weight);
            if change != 0.0 {
                *weight += change;
                rows.iter().for_each(|k| left[*k] -= change);
            }
        }
    }
    (weights, offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waves(count: usize, top: f64) -> Vec<f64> {
        let wave = |k: usize| {
            let t = k as f64 / 40.0;
            0.5 * top * (1.0 - t.cos()) * (0.6 + 0.4 * (0.13 * t).sin())
        };
        (0..count).map(wave).collect()
    }

    #[test]
    fn relays_follow_a_machine_of_relays_and_their_inverse_leads_to_the_position() {
        let u = waves(1500, 8.0);
        let machine = |u: &[f64]| -> Vec<f64> {
            let levels: Vec<f64> = (0..=40).map(|k| 0.2 * f64::from(k)).collect();
            let mut plane = Plane::new(&levels);
            u.iter()
                .map(|u| {
                    plane.step(*u);
                    0.1 + 0.01 * plane.on.iter().filter(|on| **on).count() as f64
                })
                .collect()
        };
        let y = machine(&u);
        let relays = Relays::fit(40, 8.0, &[(&u, &y)]);
        assert_eq!(relays.count(), 820);
        let range = 8.2;
        let error = |a: &[f64], b: &[f64]| identify::learned::rms_difference(a, b) / range;
        assert!(error(&relays.simulate(&u), &y) < 0.01, "{}", error(&relays.simulate(&u), &y));
        let wanted: Vec<f64> = waves(600, 5.0);
        let led = relays.simulate(&relays.inverse(&wanted));
        // A level is 1/40 of the range.
        assert!(error(&led, &wanted) < 0.03, "{}", error(&led, &wanted));
    }
}

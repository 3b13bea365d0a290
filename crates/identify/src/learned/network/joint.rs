//! Plays, curves, creep and network in one fit, from where the network was learned over plays that stood still.
//!
//! ```text
//! Σ e² + N·(price·STARTS·HEIGHT²·Σ height² + WEIGHT²/STARTS·Σ (weight − first)²) is least,   w_i ≥ 0
//! y = v + half·(curve(η) + F(x)),   ∂y/∂v = S = 1 + curve′ + ∂F/∂η
//! ∂y/∂w_i = S·(P_i + share·Σ z_ij) + Σ ∂F/∂x_j·(P_i − z_ij),   z_ij: play i behind creep j
//! ```
//!
//! by Levenberg–Marquardt. Weights that are 0 and would fall further stay. The bend's column is a difference of two
//! simulations. Every sum is that of the component's own code.

use components::hysteresis::play::{Drive, Threshold, play};
use learned::plays::{INPUTS, unit, unit_slope};
use nalgebra::{DMatrix, DVector};
use numerics::levenberg_marquardt::damped_step;

use super::{BEYOND, EACH, HEIGHT, Plays, STARTS, TrainingRecord, WEIGHT, without_means};
use crate::error::Error;
use crate::observer::Observer;

/// Most steps, and the relative fall of the sum that ends them.
const STEPS: usize = 40;
const FALL: f64 = 1e-4;
/// Change of the bend from which its column is made.
const BEND: f64 = 1e-6;
/// Numbers before the weights of the plays: bend, quadratic, cubic, share, offset.
const OTHERS: usize = 5;
/// First input of a unit that is what a creep lags behind.
const FIRST_CREEP: usize = INPUTS - 3;

/// What is fitted on.
pub(super) struct Joint<'a> {
    pub(super) plays: &'a Plays,
    pub(super) lessons: &'a [TrainingRecord],
    pub(super) step: f64,
    /// What bend, quadratic, cubic and share lie within.
    pub(super) bounds: &'a [(f64, f64)],
    /// What a height costs, over what it costs alone.
    pub(super) price: f64,
    /// One row of this many is met.
    pub(super) every: usize,
}

/// Numbers, their errors over half the range, and the sum.
struct Point {
    numbers: Vec<f64>,
    error: Vec<f64>,
    sum: f64,
}

impl Joint<'_> {
    /// The best plays and network.
    ///
    /// # Errors
    /// [`Error::Model`] where the component refuses the first plays; [`Error::Stopped`].
    pub(super) fn fit(
        &self,
        network: &[f64],
        observer: &mut dyn Observer,
    ) -> Result<(Plays, Vec<f64>), Error> {
        let [offset, bend, _, _, quadratic, cubic, ..] = self.plays.scalars;
        let others =
            [bend, quadratic, cubic, self.plays.share.first().copied().unwrap_or(0.0), offset];
        let mut at = self.point([&others[..], &self.plays.w, network].concat())?;
        let mut damping = 1e-3;
        for step in 0..STEPS {
            observer.progress("plays and network together", step, STEPS);
            if observer.stopped() {
                return Err(Error::Stopped);
            }
            let (normal, gradient) = self.equations(&at)?;
            let before = at.sum;
            while damping < 1e9 {
                let change = damped_step(normal.clone(), &gradient, damping);
                let tried = change.and_then(|change| {
                    let next = at.numbers.iter().zip(change.iter()).map(|(a, d)| a + d);
                    self.point(self.within(next.collect())).ok()
                });
                if let Some(tried) = tried.filter(|tried| tried.sum < at.sum) {
                    at = tried;
                    damping = (0.1 * damping).max(1e-9);
                    break;
                }
                damping *= 10.0;
            }
            if before - at.sum <= FALL * before {
                break;
            }
        }
        let (plays, network) = self.parts(&at.numbers);
        Ok((plays, network.to_vec()))
    }

    /// The numbers, none beyond its bounds.
    fn within(&self, mut numbers: Vec<f64>) -> Vec<f64> {
        for (number, (low, high)) in numbers.iter_mut().zip(self.bounds) {
            *number = number.clamp(*low, *high);
        }
        let weights = numbers.iter_mut().skip(OTHERS).take(self.plays.w.len());
        weights.for_each(|w| *w = w.max(0.0));
        numbers
    }

    fn parts<'n>(&self, numbers: &'n [f64]) -> (Plays, &'n [f64]) {
        let (others, rest) = numbers.split_at(OTHERS);
        let (w, network) = rest.split_at(self.plays.w.len());
        let mut plays = self.plays.clone();
        plays.w = w.to_vec();
        plays.share.fill(others[3]);
        plays.scalars[0] = others[4];
        plays.scalars[1] = others[0];
        plays.scalars[4] = others[1];
        plays.scalars[5] = others[2];
        (plays, network)
    }

    fn point(&self, numbers: Vec<f64>) -> Result<Point, Error> {
        let (plays, network) = self.parts(&numbers);
        let half = plays.scalars[7];
        let mut error = Vec::new();
        for lesson in self.lessons {
            let seen = plays.simulated(network, &lesson.signal, self.step)?;
            let from = error.len();
            error.extend(lesson.rows(self.every).map(|(k, y)| (seen[k].1 - y) / half));
            without_means(&mut error[from..]);
        }
        let count = error.len() as f64;
        let sum = error.iter().map(|e| e * e).sum::<f64>();
        let price: f64 = network
            .iter()
            .zip(self.prices())
            .map(|(p, (from, price))| price * (p - from).powi(2))
            .sum();
        Ok(Point { numbers, error, sum: sum + count * price })
    }

    /// What each number of the network is compared with, and its price.
    fn prices(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let starts = STARTS as f64;
        let begin = (0..STARTS).flat_map(super::first).enumerate();
        begin.map(move |(k, first)| match k % EACH == INPUTS + 1 {
            true => (0.0, self.price * starts * HEIGHT * HEIGHT),
            false => (first, WEIGHT * WEIGHT / starts),
        })
    }

    /// JᵀJ and Jᵀe of that sum; a weight that may not fall has no part in them.
    fn equations(&self, at: &Point) -> Result<(DMatrix<f64>, DVector<f64>), Error> {
        let (plays, network) = self.parts(&at.numbers);
        let (count, size) = (at.error.len(), at.numbers.len());
        let mut jacobian = DMatrix::zeros(count, size);
        let mut from = 0;
        for lesson in self.lessons {
            from = self.columns(&plays, network, lesson, from, &mut jacobian)?;
        }
        let mut from = 0;
        for lesson in self.lessons {
            let rows = lesson.rows(self.every).count();
            for mut column in jacobian.rows_mut(from, rows).column_iter_mut() {
                let mean = column.mean();
                column.add_scalar_mut(-mean);
            }
            from += rows;
        }
        let error = DVector::from_column_slice(&at.error);
        let mut normal = jacobian.tr_mul(&jacobian);
        let mut gradient = jacobian.tr_mul(&error);
        let all = count as f64;
        let first = OTHERS + plays.w.len();
        for (k, (p, (from, price))) in network.iter().zip(self.prices()).enumerate() {
            normal[(first + k, first + k)] += all * price;
            gradient[first + k] += all * price * (p - from);
        }
        for (i, w) in plays.w.iter().enumerate() {
            if *w == 0.0 && gradient[OTHERS + i] > 0.0 {
                fix(&mut normal, &mut gradient, OTHERS + i);
            }
        }
        for k in 0..size {
            if normal[(k, k)] <= 0.0 {
                fix(&mut normal, &mut gradient, k);
            }
        }
        Ok((normal, gradient))
    }

    /// Writes the columns of this lesson from this row on; the row after it.
    fn columns(
        &self,
        plays: &Plays,
        network: &[f64],
        lesson: &TrainingRecord,
        from: usize,
        jacobian: &mut DMatrix<f64>,
    ) -> Result<usize, Error> {
        let share = plays.share.first().copied().unwrap_or(0.0);
        let [_, _, centre, half_command, quadratic, cubic, _, half] = plays.scalars;
        let seen = plays.simulated(network, &lesson.signal, self.step)?;
        let mut bent = plays.clone();
        bent.scalars[1] += BEND;
        let bent = bent.simulated(network, &lesson.signal, self.step)?;
        let mut slopes = Vec::new();
        let mut end = from;
        for (k, _) in lesson.rows(self.every) {
            let (x, y) = &seen[k];
            let mut slope = [0.0; INPUTS];
            for (n, numbers) in network.chunks_exact(EACH).enumerate() {
                let inside = x.iter().zip(numbers).fold(numbers[INPUTS], |sum, (x, a)| sum + a * x);
                let active = unit(inside);
                let turned = numbers[INPUTS + 1] * unit_slope(inside);
                let at = OTHERS + plays.w.len() + n * EACH;
                for (m, x) in x.iter().enumerate() {
                    jacobian[(end, at + m)] = turned * x;
                    slope[m] += turned * numbers[m];
                }
                jacobian[(end, at + INPUTS)] = turned;
                jacobian[(end, at + INPUTS + 1)] = active;
            }
            let eta = x[1];
            let total = 1.0 + (2.0 * quadratic + 3.0 * cubic * eta) * eta + slope[1];
            jacobian[(end, 0)] = (bent[k].1 - y) / (BEND * half);
            jacobian[(end, 1)] = eta * eta;
            jacobian[(end, 2)] = eta * eta * eta;
            jacobian[(end, 4)] = total * (1.0 + plays.share.iter().sum::<f64>()) / half;
            slopes.push((k, total, slope));
            end += 1;
        }
        let place = |u: &f64| ((u - centre) / half_command).clamp(-BEYOND, BEYOND);
        let input: Vec<f64> = lesson
            .signal
            .iter()
            .map(place)
            .map(|place| centre + half_command * (place + plays.scalars[1] * place * place))
            .collect();
        let part = |time: &f64| -(-self.step / time).exp_m1();
        let parts: Vec<f64> = plays.time_constant.iter().map(part).collect();
        for (i, (r, w)) in plays.r.iter().zip(&plays.w).enumerate() {
            let mut rows = slopes.iter().zip(from..).peekable();
            let mut p = 0.0_f64;
            let mut crept = vec![0.0; parts.len()];
            for (k, b) in input.iter().enumerate() {
                p = play(Drive(*b), Threshold(*r), p);
                for (z, part) in crept.iter_mut().zip(&parts) {
                    *z += if k == 0 { p - *z } else { part * (p - *z) };
                }
                let Some(((_, total, slope), row)) = rows.next_if(|((at, ..), _)| *at == k) else {
                    continue;
                };
                let late: f64 = crept.iter().sum();
                let pairs = slope[FIRST_CREEP..].iter().zip(&crept);
                let left: f64 = pairs.map(|(slope, z)| slope * (p - z)).sum();
                jacobian[(row, OTHERS + i)] = (total * (p + share * late) + left) / half;
                jacobian[(row, 3)] += total * w * late / half;
            }
        }
        // Creep of the offset.
        for (at, (_, total, _)) in slopes.iter().enumerate() {
            jacobian[(from + at, 3)] += total * plays.scalars[0] * plays.share.len() as f64 / half;
        }
        Ok(end)
    }
}

/// A number that stays.
fn fix(normal: &mut DMatrix<f64>, gradient: &mut DVector<f64>, k: usize) {
    normal.row_mut(k).fill(0.0);
    normal.column_mut(k).fill(0.0);
    normal[(k, k)] = 1.0;
    gradient[k] = 0.0;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half the sum's slope along each number is the gradient of the equations.
    #[test]
    fn the_gradient_is_that_of_the_sum() {
        let plays = Plays {
            r: vec![0.0, 10.0, 20.0, 35.0],
            w: vec![0.1, 0.02, 0.01, 0.03],
            share: vec![0.01; 3],
            time_constant: vec![0.02, 0.2, 2.0],
            scalars: [0.3, 0.08, 50.0, 50.0, -0.05, 0.02, 8.0, 8.0],
        };
        let signal: Vec<f64> = (0..400)
            .map(|k| 50.0 + 40.0 * (0.05 * k as f64).sin() * (0.011 * k as f64).cos())
            .collect();
        let position = (0..190).map(|k| 8.0 + 5.0 * (0.1 * k as f64).sin()).collect();
        let lessons = [TrainingRecord { signal, substeps: 2, first: 5, position }];
        let bounds = [(-0.3, 0.3), (-0.25, 0.25), (-0.1, 0.1), (0.0, 0.03)];
        let joint = Joint {
            plays: &plays,
            lessons: &lessons,
            step: 1e-3,
            bounds: &bounds,
            price: 0.5,
            every: 1,
        };
        let mut network: Vec<f64> = (0..STARTS).flat_map(super::super::first).collect();
        for (k, number) in network.iter_mut().enumerate() {
            *number += 0.03 * (1.0 + k as f64).sin();
        }
        let [offset, bend, _, _, quadratic, cubic, ..] = plays.scalars;
        let numbers = [&[bend, quadratic, cubic, 0.01, offset][..], &plays.w, &network].concat();
        let at = joint.point(numbers.clone()).unwrap();
        let (_, gradient) = joint.equations(&at).unwrap();
        for (k, gradient) in gradient.iter().enumerate() {
            let sum = |by: f64| {
                let mut moved = numbers.clone();
                moved[k] += by;
                joint.point(moved).unwrap().sum
            };
            let slope = 0.5 * (sum(1e-5) - sum(-1e-5)) / 2e-5;
            let near = 1e-3 * slope.abs() + 1e-4 * at.sum;
            assert!((slope - gradient).abs() < near, "{k}: {slope} {gradient}");
        }
    }
}

//! Weights with which stop operators are added to the command, so that what is curved is a curve of one input.
//!
//! ```text
//! y ≈ S(x),   x = u + Σ p_i z_i        (projected)
//! y ≈ S(u) + Σ w_i z_i                 (side by side)
//! ```
//!
//! S is a cubic spline over even knots; p by Gauss-Newton with S free in each step. Loops that are bent by a
//! curve behind them, as by Kuhnen's dead zones, are of the first kind: a kernel over the bare command sees the
//! bend at another place on each branch, and goes on wrongly beyond the loops that it was shown.
//!
//! Reference: K. Kuhnen, Modeling, identification and compensation of complex hysteretic nonlinearities, European
//! Journal of Control 9 (2003); J. Friedman, W. Stuetzle, Projection pursuit regression, JASA 76 (1981).

use learned::features::Features;
use nalgebra::{DMatrix, DVector};

use super::Frame;
use super::spline::Knots;

/// Intervals of the spline.
const INTERVALS: usize = 24;
/// Stop operators that take part: as many, evenly over the range.
const STOPS: usize = 16;
/// Steps of Gauss-Newton, and halvings of each.
const STEPS: (usize, i32) = (30, 6);
/// Part of the squares that a step must take off, or the search has ended.
const SETTLED: f64 = 1e-4;
/// Part of the squares side by side that the projected curve may leave.
const BETTER: f64 = 0.8;
/// Weight of the curvature of S, and of p, over the mean square of the basis.
const RIDGE: (f64, f64) = (1e-6, 1e-6);
/// Most samples.
const MOST: usize = 3000;

impl Frame {
    /// This frame with the stop operators added to the command, where a curve of their sum follows these rows of the
    /// records, counted through, better than a curve of the command beside them.
    #[must_use]
    pub fn projected(&self, records: &[(&[f64], &[f64])], rows: &[usize]) -> Self {
        let mut projected = self.clone();
        if let Features::StopOperators(stops) = &mut projected.features {
            stops.projection = project(self, records, rows).unwrap_or_default();
        }
        projected
    }
}

/// The weights of all stops of the frame that follow these rows of the records best, in the frame's scaled inputs;
/// `None` where a curve and stops side by side do as well.
fn project(frame: &Frame, records: &[(&[f64], &[f64])], rows: &[usize]) -> Option<Vec<f64>> {
    let Features::StopOperators(stops) = &frame.features else { return None };
    let taken = taken(stops.count);
    let bare = stops.bare();
    let (inputs, targets) = frame.bare(&Features::StopOperators(bare), records);
    let every = rows.len().div_ceil(MOST).max(1);
    let rows: Vec<usize> = rows.iter().copied().step_by(every).collect();
    let scene = Samples::new((&inputs, &targets), &rows, &taken);
    let found = scene.projected().filter(|found| found.left < BETTER * scene.beside())?;
    let mut all = vec![0.0; stops.count];
    taken.iter().zip(found.p).for_each(|(k, p)| all[*k] = p);
    Some(all)
}

/// The stops of `count` that take part.
pub(super) fn taken(count: usize) -> Vec<usize> {
    if count <= STOPS {
        return (0..count).collect();
    }
    (0..STOPS).map(|k| k * count / STOPS).collect()
}

/// Samples: command, the stops that take part, target.
struct Samples {
    command: Vec<f64>,
    stops: Vec<Vec<f64>>,
    target: Vec<f64>,
    knots: Knots,
}

/// A projection, its curve, and the squares that they leave.
struct Found {
    p: Vec<f64>,
    curve: Vec<f64>,
    left: f64,
}

impl Samples {
    fn new((inputs, targets): (&[f64], &[f64]), rows: &[usize], taken: &[usize]) -> Self {
        let d = inputs.len() / targets.len().max(1);
        let of = |row: &usize| &inputs[row * d..(row + 1) * d];
        let command: Vec<f64> = rows.iter().map(|row| of(row)[d - 2]).collect();
        let stops = rows.iter().map(|row| taken.iter().map(|k| of(row)[*k]).collect()).collect();
        let target = rows.iter().map(|row| targets[*row]).collect();
        let knots = Knots::about(command.iter().copied(), INTERVALS);
        Self { command, stops, target, knots }
    }

    fn x(&self, row: usize, p: &[f64]) -> f64 {
        self.command[row] + self.stops[row].iter().zip(p).map(|(z, p)| z * p).sum::<f64>()
    }

    /// Least squares of the targets over splines at `x` and a further column for each stop: the coefficients of the
    /// splines, then those of the columns.
    fn solve(
        &self,
        x: &dyn Fn(usize) -> f64,
        columns: &dyn Fn(usize, &mut [f64]),
    ) -> Option<Vec<f64>> {
        let (of_curve, of_stops) = (self.knots.count(), self.stops.first()?.len());
        let count = of_curve + of_stops;
        let mut normal = DMatrix::<f64>::zeros(count, count);
        let mut right = DVector::<f64>::zeros(count);
        let mut own = vec![0.0; of_stops];
        for row in 0..self.target.len() {
            let (first, values, _) = self.knots.at(x(row));
            columns(row, &mut own);
            let entries = || {
                let curve = values.iter().enumerate().map(|(k, v)| (first + k, *v));
                curve.chain(own.iter().enumerate().map(|(k, v)| (of_curve + k, *v)))
            };
            for (i, a) in entries() {
                right[i] += a * self.target[row];
                for (k, b) in entries() {
                    normal[(i, k)] += a * b;
                }
            }
        }
        let scale = self.target.len() as f64;
        self.knots.stiffen(&mut normal, RIDGE.0 * scale, scale * RIDGE.1 * 1e-3);
        for k in of_curve..count {
            normal[(k, k)] += scale * RIDGE.1;
        }
        Some(normal.cholesky()?.solve(&right).as_slice().to_vec())
    }

    fn squares(&self, value: &dyn Fn(usize) -> f64) -> f64 {
        self.target.iter().enumerate().map(|(row, y)| (y - value(row)).powi(2)).sum()
    }

    fn curve(&self, coefficients: &[f64], x: f64) -> (f64, f64) {
        let (first, values, slopes) = self.knots.at(x);
        let of = |all: [f64; 4]| -> f64 {
            all.iter().zip(&coefficients[first..]).map(|(v, c)| v * c).sum()
        };
        (of(values), of(slopes))
    }

    /// What a curve of the command and the stops side by side leave.
    fn beside(&self) -> f64 {
        let columns = |row: usize, own: &mut [f64]| own.copy_from_slice(&self.stops[row]);
        let found = self.solve(&|row| self.command[row], &columns);
        let Some(found) = found else { return f64::INFINITY };
        let (curve, weights) = found.split_at(self.knots.count());
        self.squares(&|row| {
            let beside: f64 = self.stops[row].iter().zip(weights).map(|(z, w)| z * w).sum();
            self.curve(curve, self.command[row]).0 + beside
        })
    }

    /// The curve that fits best behind this projection.
    fn behind(&self, p: Vec<f64>) -> Option<Found> {
        let none = |_: usize, own: &mut [f64]| own.fill(0.0);
        let found = self.solve(&|row| self.x(row, &p), &none)?;
        let left = self.squares(&|row| self.curve(&found, self.x(row, &p)).0);
        Some(Found { p, curve: found, left })
    }

    /// The projection that fits best.
    fn projected(&self) -> Option<Found> {
        let mut at = self.behind(vec![0.0; self.stops.first()?.len()])?;
        for _ in 0..STEPS.0 {
            let columns = |row: usize, own: &mut [f64]| {
                let slope = self.curve(&at.curve, self.x(row, &at.p)).1;
                own.iter_mut().zip(&self.stops[row]).for_each(|(c, z)| *c = slope * z);
            };
            // The curve moves with p: its coefficients are solved for together with the step.
            let step = self.solve(&|row| self.x(row, &at.p), &columns)?;
            let step = &step[self.knots.count()..];
            let better = (0..STEPS.1).find_map(|halvings| {
                let part = 0.5_f64.powi(halvings);
                let tried = at.p.iter().zip(step).map(|(p, s)| p + part * s).collect();
                self.behind(tried).filter(|tried| tried.left < at.left)
            });
            let Some(better) = better else { break };
            let is_settled = better.left > (1.0 - SETTLED) * at.left;
            at = better;
            if is_settled {
                break;
            }
        }
        Some(at)
    }
}

#[cfg(test)]
mod tests {
    use components::hysteresis::play::Plays;
    use learned::features::StopOperators;

    use super::super::{Recipe, Span};
    use super::*;

    fn wave(top: f64, step: f64, turns: usize) -> Vec<f64> {
        (0..turns)
            .map(|k| {
                let t = step * k as f64;
                0.5 * top * (1.0 - t.cos()) * (0.6 + 0.4 * (0.23 * t).cos())
            })
            .collect()
    }

    /// Plays, and what a curve behind or beside them makes of the command.
    fn machine(u: &[f64], curve: impl Fn(f64) -> f64, behind: bool) -> Vec<f64> {
        let (plays, mut state) = (Plays { r: &[0.5, 1.0, 2.0], w: &[0.1; 3] }, [0.0; 3]);
        u.iter()
            .map(|u| {
                let loops = plays.step(*u, &mut state);
                if behind { curve(u + loops) } else { curve(*u) + loops }
            })
            .collect()
    }

    fn frame(records: &[(&[f64], &[f64])]) -> Frame {
        let stops = StopOperators::new(15, 8.0, 1e-2);
        Frame::new(Features::StopOperators(stops), Span::UNIT, Span::UNIT, Recipe::Plain, records)
    }

    #[test]
    fn a_bend_behind_the_loops_is_projected_and_one_beside_them_is_not() {
        let bend = |x: f64| x + 0.6 * (x - 4.0).max(0.0);
        let u = wave(8.0, 0.07, 900);
        for behind in [true, false] {
            let y = machine(&u, bend, behind);
            let records = [(&u[..], &y[..])];
            let rows: Vec<usize> = (0..u.len()).collect();
            let found = project(&frame(&records), &records, &rows);
            assert_eq!(found.is_some(), behind, "{found:?}");
            let Some(p) = found else { continue };
            // u + Σ p z is the loops' sum up to a scale: z = u − play, so that the weights of the plays over
            // 1 + their sum, −0.1/1.3, stand at their thresholds (numbers 0, 1 and 3 of 15 up to 8). Stop operators that
            // seldom reach their threshold are the command itself.
            for (at, p) in p.iter().enumerate().take(8) {
                let expected = if [0, 1, 3].contains(&at) { -0.1 / 1.3 } else { 0.0 };
                assert!((p - expected).abs() < 0.02, "{at}: {p}");
            }
        }
    }
}

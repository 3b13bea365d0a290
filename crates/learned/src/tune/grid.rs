//! A grid, and the default search: a coarse grid, then a simplex from its best point.

use super::simplex::{Simplex, descend};
use super::{Best, Counted, Watch};

/// Evaluates the function on a grid of the box, `counts` points in each direction.
///
/// `row` is given the first coordinate and all values of the second: work that depends on the first
/// alone is done once.
pub fn grid(
    bounds: &[(f64, f64); 2],
    counts: [usize; 2],
    row: &mut dyn FnMut(f64, &[f64]) -> Vec<f64>,
    watch: Watch<'_>,
) -> Best {
    let mut unused = |_: &[f64]| f64::INFINITY;
    let mut counted = Counted::new(&mut unused, watch);
    rows(&mut counted, bounds, counts, row);
    counted.best
}

fn rows(
    counted: &mut Counted<'_>,
    bounds: &[(f64, f64); 2],
    counts: [usize; 2],
    row: &mut dyn FnMut(f64, &[f64]) -> Vec<f64>,
) {
    let points = |k: usize| -> Vec<f64> {
        let (low, high) = bounds[k];
        let steps = counts[k].max(2) - 1;
        (0..=steps).map(|i| low + (high - low) * i as f64 / steps as f64).collect()
    };
    let second = points(1);
    for first in points(0) {
        if counted.stopped {
            return;
        }
        for (value, x) in row(first, &second).into_iter().zip(&second) {
            counted.note(&[first, *x], value);
        }
    }
}

/// The default search for two settings: 7 × 5 points, then a simplex; about a hundred evaluations.
pub fn grid_then_simplex(
    bounds: &[(f64, f64); 2],
    row: &mut dyn FnMut(f64, &[f64]) -> Vec<f64>,
    watch: Watch<'_>,
) -> Best {
    let mut evaluated = 0;
    let mut best_so_far = f64::INFINITY;
    let mut ended = false;
    let coarse = grid(bounds, [7, 5], row, &mut |n, best| {
        (evaluated, best_so_far) = (n, best);
        ended |= !watch(n, best);
        !ended
    });
    if ended {
        return coarse;
    }
    let mut one = |x: &[f64]| row(x[0], &x[1..]).first().copied().unwrap_or(f64::INFINITY);
    let mut onward = |n: usize, best: f64| watch(evaluated + n, best.min(best_so_far));
    let mut counted = Counted::new(&mut one, &mut onward);
    let simplex = Simplex { edge: 0.08, evaluations: 62, tolerance: 1e-4 };
    descend(&mut counted, bounds, &coarse.point, simplex);
    let fine = counted.best;
    let evaluations = coarse.evaluations + fine.evaluations;
    let best = if fine.value < coarse.value { fine } else { coarse };
    Best { evaluations, ..best }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_search_finds_a_curved_valley_s_bottom_in_a_hundred_evaluations() {
        let mut row = |x: f64, ys: &[f64]| -> Vec<f64> {
            ys.iter().map(|y| 1.0 + (x - 2.3).powi(2) + 3.0 * (y + x - 0.7).powi(2)).collect()
        };
        let best = grid_then_simplex(&[(-4.0, 8.0), (-5.0, 5.0)], &mut row, &mut |_, _| true);
        assert!(best.evaluations <= 100, "{}", best.evaluations);
        assert!(best.value < 1.002, "{best:?}");
    }
}

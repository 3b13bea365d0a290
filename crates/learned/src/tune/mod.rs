//! Searches for the least value of a function within a box.
//!
//! A value that is not a number counts as infinite. All searches run from a seed and give the same
//! answer again; each reports to a [`Watch`] how far it is and ends where that says so.

mod annealing;
mod grid;
mod particle_swarm;
mod random;
mod simplex;

pub use annealing::{Annealing, coupled_annealing};
pub use grid::{grid, grid_then_simplex};
pub use particle_swarm::{Swarm, particle_swarm};
pub use simplex::{Simplex, nelder_mead};

/// The best that a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// Where.
    pub point: Vec<f64>,
    /// The value there.
    pub value: f64,
    /// How often the function was evaluated.
    pub evaluations: usize,
}

/// Receives after each evaluation how many there were and the best value so far; `false` ends the
/// search with the best so far.
pub type Watch<'a> = &'a mut dyn FnMut(usize, f64) -> bool;

/// The function with a count and the best so far.
struct Counted<'a> {
    function: &'a mut dyn FnMut(&[f64]) -> f64,
    watch: Watch<'a>,
    best: Best,
    stopped: bool,
}

impl<'a> Counted<'a> {
    fn new(function: &'a mut dyn FnMut(&[f64]) -> f64, watch: Watch<'a>) -> Self {
        let best = Best { point: Vec::new(), value: f64::INFINITY, evaluations: 0 };
        Self { function, watch, best, stopped: false }
    }

    fn at(&mut self, point: &[f64]) -> f64 {
        if self.stopped {
            return f64::INFINITY;
        }
        let value = (self.function)(point);
        self.note(point, value)
    }

    /// Takes over a value that was computed elsewhere.
    fn note(&mut self, point: &[f64], value: f64) -> f64 {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        self.best.evaluations += 1;
        if self.best.point.is_empty() || value < self.best.value {
            (self.best.point, self.best.value) = (point.to_vec(), value);
        }
        self.stopped |= !(self.watch)(self.best.evaluations, self.best.value);
        value
    }
}

fn clamp(point: &mut [f64], bounds: &[(f64, f64)]) {
    for (x, (low, high)) in point.iter_mut().zip(bounds) {
        *x = x.clamp(*low, *high);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: [(f64, f64); 2] = [(-2.0, 3.0), (-1.0, 4.0)];

    /// A valley with its least value 0 at (1, 1).
    fn rosenbrock(x: &[f64]) -> f64 {
        (1.0 - x[0]).powi(2) + 20.0 * (x[1] - x[0] * x[0]).powi(2)
    }

    fn inside(x: &[f64]) -> bool {
        x.iter().zip(BOX).all(|(x, (low, high))| (low..=high).contains(x))
    }

    #[test]
    fn every_search_finds_the_valley_s_lowest_point_within_the_box() {
        let mut watch = |_: usize, _: f64| true;
        let mut f = |x: &[f64]| {
            assert!(inside(x), "{x:?}");
            rosenbrock(x)
        };
        let swarm = particle_swarm(&BOX, Swarm { seed: 3, ..Swarm::default() }, &mut f, &mut watch);
        assert!(swarm.value < 1e-4 && swarm.evaluations == 3000, "{swarm:?}");
        let cold = coupled_annealing(
            &BOX,
            Annealing { seed: 3, ..Annealing::default() },
            &mut f,
            &mut watch,
        );
        let simplex = nelder_mead(&BOX, &cold.point, Simplex::default(), &mut f, &mut watch);
        assert!(simplex.value < 1e-6 && simplex.value <= cold.value, "{cold:?} {simplex:?}");
    }

    #[test]
    fn a_watch_ends_a_search_with_the_best_so_far() {
        let mut watch = |n: usize, _: f64| n < 50;
        let best = particle_swarm(&BOX, Swarm::default(), &mut |x| rosenbrock(x), &mut watch);
        assert_eq!(best.evaluations, 50);
        assert_eq!(rosenbrock(&best.point), best.value);
    }

    #[test]
    fn what_is_no_number_is_never_the_best() {
        let mut f = |x: &[f64]| if x[0] < 1.0 { f64::NAN } else { x[0] };
        let mut watch = |_: usize, _: f64| true;
        let best = particle_swarm(&BOX, Swarm::default(), &mut f, &mut watch);
        assert!(best.value >= 1.0 && best.value < 1.001);
    }
}

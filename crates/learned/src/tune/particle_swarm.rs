//! Particle swarm, as the nanopositioning paper runs it.
//!
//! ```text
//! v = η v + c1 r1 (p_best − p) + c2 r2 (g_best − p),   p = p + v,   η from 0.9 to 0.4
//! ```
//!
//! Reference: J. Kennedy, R. Eberhart, Particle swarm optimization, Proc. ICNN 1995.

use super::random::Random;
use super::{Best, Counted, Watch, clamp};

/// Size and coefficients of a swarm; the default is the paper's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swarm {
    /// Number of particles.
    pub particles: usize,
    /// Number of iterations; the first one places the particles.
    pub iterations: usize,
    /// Inertia at the first and at the last iteration.
    pub inertia: (f64, f64),
    /// Pull of a particle's own best place.
    pub own: f64,
    /// Pull of the swarm's best place.
    pub common: f64,
    /// Seed.
    pub seed: u64,
}

impl Default for Swarm {
    fn default() -> Self {
        let inertia = (0.9, 0.4);
        Self { particles: 30, iterations: 100, inertia, own: 2.0, common: 2.0, seed: 1 }
    }
}

/// Searches within the box with a swarm.
pub fn particle_swarm(
    bounds: &[(f64, f64)],
    swarm: Swarm,
    function: &mut dyn FnMut(&[f64]) -> f64,
    watch: Watch<'_>,
) -> Best {
    let mut random = Random::new(swarm.seed);
    let mut counted = Counted::new(function, watch);
    let place = |random: &mut Random| bounds.iter().map(|b| random.between(*b)).collect();
    let mut points: Vec<Vec<f64>> = (0..swarm.particles).map(|_| place(&mut random)).collect();
    let mut speeds = vec![vec![0.0; bounds.len()]; swarm.particles];
    let mut own = points.clone();
    let mut values: Vec<f64> = points.iter().map(|p| counted.at(p)).collect();
    for iteration in 1..swarm.iterations {
        let part = iteration as f64 / (swarm.iterations - 1) as f64;
        let inertia = swarm.inertia.0 + part * (swarm.inertia.1 - swarm.inertia.0);
        for k in 0..swarm.particles {
            for d in 0..bounds.len() {
                let (r1, r2) = (random.unit(), random.unit());
                let most = bounds[d].1 - bounds[d].0;
                let speed = inertia * speeds[k][d]
                    + swarm.own * r1 * (own[k][d] - points[k][d])
                    + swarm.common * r2 * (counted.best.point[d] - points[k][d]);
                speeds[k][d] = speed.clamp(-most, most);
                points[k][d] += speeds[k][d];
            }
            clamp(&mut points[k], bounds);
            let value = counted.at(&points[k]);
            if value < values[k] {
                values[k] = value;
                own[k].clone_from(&points[k]);
            }
            if counted.stopped {
                return counted.best;
            }
        }
    }
    counted.best
}

//! Particle swarm: minimises a cost within bounds, as the papers tune their models.
//!
//! ```text
//! v ← inertia·v + c1·ρ1·(own best − x) + c2·ρ2·(swarm's best − x),   x ← x + v, reflected at the bounds
//! ```
//!
//! ρ1, ρ2 uniform on [0, 1) per coordinate. All random numbers are drawn by one generator before a
//! round is evaluated, so that the result depends on the seed and not on the number of threads.
//!
//! Source: J. Kennedy, R. Eberhart, Proc. IEEE ICNN (1995) 1942–1948; inertia: Y. Shi, R. Eberhart,
//! Proc. IEEE ICEC (1998) 69–73.

use numerics::levenberg_marquardt::Unknown;
use numerics::random::SplitMix64;

use crate::error::Error;

/// Settings of a swarm; the default is that of the papers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swarm {
    /// Number of particles.
    pub particles: usize,
    /// Rounds in which every particle moves once.
    pub iterations: usize,
    /// Inertia at the start and at the end, linear in between.
    pub inertia: [f64; 2],
    /// Pull of a particle's own best and of the swarm's best.
    pub pull: [f64; 2],
    /// Seed of the random numbers.
    pub seed: u64,
    /// Threads that evaluate particles side by side.
    pub threads: usize,
}

impl Default for Swarm {
    fn default() -> Self {
        Self {
            particles: 30,
            iterations: 100,
            inertia: [0.9, 0.4],
            pull: [2.0, 2.0],
            seed: 1,
            threads: 1,
        }
    }
}

/// A place and its cost.
pub(crate) type Best = (Vec<f64>, f64);

/// Minimises `costs`, which is given all particles of a round and returns one cost each; a cost that
/// is not finite is never the best. The first particle starts at the unknowns' start. `stop` is asked
/// after each round, with the number of rounds done; the best so far is then the result.
///
/// # Errors
/// [`Error::NoSolution`] where no particle has a finite cost.
pub(crate) fn minimise(
    unknowns: &[Unknown],
    swarm: &Swarm,
    mut costs: impl FnMut(&[Vec<f64>]) -> Vec<f64>,
    mut stop: impl FnMut(usize) -> bool,
) -> Result<Best, Error> {
    let mut random = SplitMix64::new(swarm.seed);
    let mut at = start(unknowns, swarm.particles.max(1), &mut random);
    let mut speed: Vec<Vec<f64>> = at.iter().map(|x| vec![0.0; x.len()]).collect();
    let mut own: Vec<Best> = at.iter().map(|x| (x.clone(), f64::INFINITY)).collect();
    let mut best: Best = (at[0].clone(), f64::INFINITY);
    for round in 0..=swarm.iterations {
        for ((x, own), cost) in at.iter().zip(&mut own).zip(costs(&at)) {
            if cost < own.1 {
                *own = (x.clone(), cost);
            }
            if cost < best.1 {
                best = (x.clone(), cost);
            }
        }
        if stop(round) || round == swarm.iterations {
            break;
        }
        let share = round as f64 / swarm.iterations.max(1) as f64;
        let inertia = swarm.inertia[0] + share * (swarm.inertia[1] - swarm.inertia[0]);
        for ((x, v), own) in at.iter_mut().zip(&mut speed).zip(&own) {
            for (j, unknown) in unknowns.iter().enumerate() {
                let own_pull = swarm.pull[0] * random.uniform() * (own.0[j] - x[j]);
                let common_pull = swarm.pull[1] * random.uniform() * (best.0[j] - x[j]);
                let most = 0.5 * (unknown.upper - unknown.lower);
                v[j] = (inertia * v[j] + own_pull + common_pull).clamp(-most, most);
                x[j] += v[j];
                if x[j] < unknown.lower || x[j] > unknown.upper {
                    let wall = if x[j] < unknown.lower { unknown.lower } else { unknown.upper };
                    x[j] = (2.0 * wall - x[j]).clamp(unknown.lower, unknown.upper);
                    v[j] *= -0.5;
                }
            }
        }
    }
    if best.1.is_finite() { Ok(best) } else { Err(Error::no_solution("no particle has a cost")) }
}

fn start(unknowns: &[Unknown], particles: usize, random: &mut SplitMix64) -> Vec<Vec<f64>> {
    let first = unknowns.iter().map(|u| u.start.clamp(u.lower, u.upper)).collect();
    let mut all = vec![first];
    for _ in 1..particles {
        let place = unknowns.iter().map(|u| u.lower + random.uniform() * (u.upper - u.lower));
        all.push(place.collect());
    }
    all
}

/// The cost of every particle, on `threads` threads, in the order of the particles.
pub(crate) fn side_by_side(
    particles: &[Vec<f64>],
    threads: usize,
    cost: impl Fn(&[f64]) -> f64 + Sync,
) -> Vec<f64> {
    let share = particles.len().div_ceil(threads.max(1)).max(1);
    let cost = &cost;
    std::thread::scope(|scope| {
        let work = |part: &[Vec<f64>]| part.iter().map(|x| cost(x)).collect::<Vec<_>>();
        let mut parts = particles.chunks(share);
        let first = parts.next();
        let others: Vec<_> = parts
            .map(|part| {
                let spawned = std::thread::Builder::new().spawn_scoped(scope, move || work(part));
                (part, spawned)
            })
            .collect();
        let mut all = first.map(work).unwrap_or_default();
        for (part, other) in others {
            all.extend(match other {
                // A thread ends early only by a panic, which is a fault of ours: pass it on.
                Ok(other) => other.join().unwrap_or_else(|p| std::panic::resume_unwind(p)),
                // The system gives no more threads: this one does the work.
                Err(_) => work(part),
            });
        }
        all
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unknowns() -> [Unknown; 3] {
        [Unknown { start: 3.0, lower: -5.0, upper: 5.0 }; 3]
    }

    fn rastrigin(x: &[f64]) -> f64 {
        x.iter().map(|x| x * x + 10.0 - 10.0 * (core::f64::consts::TAU * x).cos()).sum()
    }

    #[test]
    fn finds_the_lowest_of_many_valleys_and_does_not_depend_on_threads() {
        let run = |threads: usize| {
            let swarm = Swarm { particles: 60, iterations: 200, threads, ..Swarm::default() };
            let costs = |all: &[Vec<f64>]| side_by_side(all, threads, rastrigin);
            minimise(&unknowns(), &swarm, costs, |_| false).expect("a minimum")
        };
        let (one, four) = (run(1), run(4));
        assert!(one.1 < 1e-3, "seed 1: {one:?}");
        assert_eq!(one, four);
    }

    #[test]
    fn stays_within_bounds_where_the_minimum_is_outside() {
        let cost = |x: &[f64]| x.iter().map(|x| (x - 7.0).powi(2)).sum();
        let costs = |all: &[Vec<f64>]| side_by_side(all, 1, cost);
        let best = minimise(&unknowns(), &Swarm::default(), costs, |_| false).expect("a minimum");
        assert!(best.0.iter().all(|x| (x - 5.0).abs() < 1e-6), "{best:?}");
    }

    #[test]
    fn a_swarm_without_any_cost_is_an_error_and_stopping_keeps_the_best() {
        let nothing = |all: &[Vec<f64>]| vec![f64::NAN; all.len()];
        assert!(minimise(&unknowns(), &Swarm::default(), nothing, |_| false).is_err());
        let costs = |all: &[Vec<f64>]| side_by_side(all, 1, rastrigin);
        let best = minimise(&unknowns(), &Swarm::default(), costs, |_| true).expect("a start");
        assert!(best.1 <= rastrigin(&[3.0; 3]));
    }
}

//! Gauss–Seidel: slaves step one after the other.

use std::collections::{BTreeSet, HashSet};

use super::Algorithm;
use crate::error::Error;
use crate::problem::{Problem, Problems};
use crate::system::System;

/// Each slave in turn gets its inputs, steps to t_{k+1} and has its outputs read, so that those
/// after it already work with its outputs at t_{k+1}. A connection forward in the order has no
/// delay, one backward delays by one communication step.
///
/// By hand, in fmpy, for slaves `a`, then `b`:
///
/// ```python
/// a.setReal(a_in, b.getReal(b_out))                  # b's output at t_k
/// a.doStep(t, h)
/// b.setReal(b_in, a.getReal(a_out))                  # a's output at t_k + h
/// b.doStep(t, h)
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GaussSeidel {
    order: Vec<usize>,
    /// By slave: its place in the order.
    places: Vec<usize>,
}

impl GaussSeidel {
    /// In the order of these names, which must be all slaves, each once.
    pub fn in_order(system: &System, names: &[&str]) -> Result<Self, Problems> {
        let mut problems = Vec::new();
        let mut order = Vec::new();
        let mut places = vec![usize::MAX; system.len()];
        for name in names {
            match system.position(name) {
                Ok(slave) if places[slave] != usize::MAX => {
                    problems.push(order_problem(name, "comes twice"))
                }
                Ok(slave) => {
                    places[slave] = order.len();
                    order.push(slave);
                }
                Err(problem) => problems.push(problem),
            }
        }
        let left_out = system.names().zip(&places).filter(|(_, place)| **place == usize::MAX);
        problems.extend(left_out.map(|(name, _)| order_problem(name, "is left out")));
        Problems::none_or(problems, GaussSeidel { order, places })
    }

    /// Sources before targets as far as connections allow. Where they form a circle, the slave
    /// that was added first goes first, and the connections to it that close the circle delay.
    pub fn by_dependency(system: &System) -> Self {
        let sources: Vec<HashSet<usize>> = (0..system.len())
            .map(|slave| system.sources_of(slave).filter(|source| *source != slave).collect())
            .collect();
        let mut targets = vec![Vec::new(); system.len()];
        for (target, sources) in sources.iter().enumerate() {
            sources.iter().for_each(|source| targets[*source].push(target));
        }
        // So many sources of each are not placed yet; of those with none the first is next.
        let mut waits: Vec<usize> = sources.iter().map(HashSet::len).collect();
        let mut left: BTreeSet<usize> = (0..system.len()).collect();
        let mut free: BTreeSet<usize> = (0..system.len()).filter(|s| waits[*s] == 0).collect();
        let mut order: Vec<usize> = Vec::with_capacity(system.len());
        while let Some(next) = free.pop_first().or_else(|| left.first().copied()) {
            left.remove(&next);
            order.push(next);
            for target in &targets[next] {
                waits[*target] -= 1;
                if waits[*target] == 0 && left.contains(target) {
                    free.insert(*target);
                }
            }
        }
        let mut places = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, slave)| places[*slave] = place);
        GaussSeidel { order, places }
    }

    /// Places of the slaves, in the order in which they step.
    pub fn order(&self) -> &[usize] {
        &self.order
    }
}

fn order_problem(name: &str, what: &'static str) -> Problem {
    Problem::Order { name: name.to_owned(), what }
}

impl Algorithm for GaussSeidel {
    #[inline]
    fn step(&self, system: &mut System, time: f64, step: f64) -> Result<(), Error> {
        for slave in &self.order {
            system.transfer(*slave)?;
            system.advance(*slave, time, step)?;
            system.read(*slave)?;
        }
        Ok(())
    }

    fn looks_ahead(&self, source: usize, target: usize) -> bool {
        self.places.get(source) < self.places.get(target)
    }

    fn initialization_order(&self, _system: &System) -> Vec<usize> {
        self.order.clone()
    }
}

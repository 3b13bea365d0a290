//! Gauss–Seidel: slaves step one after the other.

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
}

impl GaussSeidel {
    /// In the order of these names, which must be all slaves, each once.
    pub fn in_order(system: &System, names: &[&str]) -> Result<Self, Problems> {
        let mut problems = Vec::new();
        let mut order = Vec::new();
        for name in names {
            match system.position(name) {
                Ok(place) if order.contains(&place) => {
                    problems.push(order_problem(name, "comes twice"))
                }
                Ok(place) => order.push(place),
                Err(problem) => problems.push(problem),
            }
        }
        let left_out = system.names().filter(|name| !names.contains(name));
        problems.extend(left_out.map(|name| order_problem(name, "is left out")));
        Problems::none_or(problems, GaussSeidel { order })
    }

    /// Sources before targets as far as connections allow. Where they form a circle, the slave
    /// that was added first goes first, and the connections to it that close the circle delay.
    pub fn by_dependency(system: &System) -> Self {
        let sources: Vec<Vec<usize>> = (0..system.len())
            .map(|slave| system.sources_of(slave).filter(|source| *source != slave).collect())
            .collect();
        let mut order: Vec<usize> = Vec::with_capacity(system.len());
        let mut placed = vec![false; system.len()];
        // Those before it are all placed.
        let mut first = 0;
        while order.len() < system.len() {
            while placed.get(first) == Some(&true) {
                first += 1;
            }
            let waits = |slave: usize| sources[slave].iter().any(|source| !placed[*source]);
            let free = (first..system.len()).find(|slave| !placed[*slave] && !waits(*slave));
            let next = free.unwrap_or(first);
            placed[next] = true;
            order.push(next);
        }
        GaussSeidel { order }
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
        let place = |slave: usize| self.order.iter().position(|there| *there == slave);
        place(source) < place(target)
    }

    fn initialization_order(&self, _system: &System) -> Vec<usize> {
        self.order.clone()
    }
}

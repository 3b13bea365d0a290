//! Algorithms: in which order slaves exchange values and step.
//!
//! | connection | source acts on the target over \[t_k, t_{k+1}\] with | delay |
//! |---|---|---|
//! | any, [`Jacobi`] | its output at t_k | one step |
//! | any, [`Extrapolation`] | its output and slope at t_k, where the FMUs offer slopes | one step of a held value, none of a straight line |
//! | [`GaussSeidel`], source before target | its output at t_{k+1} | none |
//! | [`GaussSeidel`], source after target | its output at t_k | one step |
//! | any, [`Iteration`] | its output at t_{k+1} | none |
//!
//! *Delay* counts communication steps between the time of the source's value and the end of the
//! target's step that it acts on. A column of the input table is like a source's output at t_k.
//!
//! # Steps of several lengths
//! A slave with a step of m communication steps takes its inputs at t_k, k a multiple of m, and
//! steps to t_{k+m}. With [`Jacobi`], and where it comes after its target, its outputs are seen from
//! t_{k+m} on (delay m). Where it comes before its target in [`GaussSeidel`], they act on the target
//! over \[t_k, t_{k+m}\] (delay 0), as of a sampled controller that holds its command. It sees a
//! faster slave's outputs at t_k, or, if that comes before it, at t_{k+1}.
//!
//! [`Iteration`] solves a loop of slaves with different steps where their steps end together: a slave
//! that steps over \[t_k, t_{k+m}\] takes that step in the last communication step of it, and in that step
//! the values at t_{k+m} of all slaves whose steps end there agree. Until then the faster ones hold what
//! it gave at t_k. What such a loop feeds, directly or not, steps as late. The record shows the inputs of such
//! a step in the row of its last communication step.

mod extrapolation;
mod gauss_seidel;
mod initial;
mod iteration;
mod jacobi;
mod loops;
mod solver;

pub use extrapolation::Extrapolation;
pub use gauss_seidel::GaussSeidel;
pub use iteration::Iteration;
pub use jacobi::Jacobi;
pub use solver::{IterationSettings, Relaxation};

use crate::error::Error;
use crate::system::System;
use solver::Solver;

/// One communication step of a system, made of the moves that [`System`] offers.
pub trait Algorithm {
    /// Steps the whole system from `time` over `step` seconds: transfers, advances and reads each
    /// slave once. Before it the bus holds the values at `time`, after it those at `time + step`.
    fn step(&self, system: &mut System, time: f64, step: f64) -> Result<(), Error>;

    /// Whether the target's step that begins at t_k works with the output that the source has
    /// already reached, instead of its output at t_k. It matters for sources with a longer step.
    fn looks_ahead(&self, source: usize, target: usize) -> bool {
        let _ = (source, target);
        false
    }

    /// Whether a slave with a longer step takes it in the last communication step of it, when its end is
    /// reached, instead of in the first.
    fn steps_late(&self, slave: usize) -> bool {
        let _ = slave;
        false
    }

    /// Order in which the slaves of a circle are asked in initialization mode.
    fn initialization_order(&self, system: &System) -> Vec<usize> {
        (0..system.len()).collect()
    }

    /// In initialization mode: sets inputs and reads outputs until they agree, sources before targets
    /// as the dependencies of the initial unknowns say. Circles are iterated; one that does not
    /// settle is noted in [`System::unsolved`] and begins with what one pass gives.
    fn initialize(&self, system: &mut System) -> Result<(), Error> {
        let order = self.initialization_order(system);
        initial::settle(system, &order, &Solver::default(), false)
    }
}

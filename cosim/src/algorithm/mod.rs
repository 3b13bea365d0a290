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
//! [`Iteration`] wants one step for all slaves of a loop, and refuses others: over the long step
//! \[t_k, t_{k+m}\] the slow slave's output at its end would have to agree with inputs that it takes at
//! m communication points, of which the faster ones hold m values and it can take one, so that there
//! is no equation to solve without saying how the fast values become one. Give the loop one step, or
//! break it where the delay harms least, with [`GaussSeidel`]. Slaves outside of loops may have any
//! step.

mod extrapolation;
mod gauss_seidel;
mod initial;
mod iteration;
mod jacobi;

pub use extrapolation::Extrapolation;
pub use gauss_seidel::GaussSeidel;
pub use iteration::{Iteration, IterationSettings, Relaxation};
pub use jacobi::Jacobi;

use crate::error::Error;
use crate::system::System;

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

    /// Order in which the slaves of a circle are asked in initialization mode.
    fn initialization_order(&self, system: &System) -> Vec<usize> {
        (0..system.len()).collect()
    }

    /// In initialization mode: sets inputs and reads outputs until they agree, sources before targets
    /// as the dependencies of the initial unknowns say. Circles are iterated; one that does not
    /// settle is noted in [`System::unsolved`] and begins with what one pass gives.
    fn initialize(&self, system: &mut System) -> Result<(), Error> {
        let order = self.initialization_order(system);
        initial::settle(system, &order, &Iteration::at_start(), false)
    }
}

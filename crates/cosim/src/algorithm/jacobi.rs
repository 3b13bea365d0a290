//! Jacobi: all slaves step side by side.

use super::Algorithm;
use crate::error::Error;
use crate::system::System;

/// All inputs are set from the outputs at t_k, then all slaves step to t_{k+1}, then all outputs
/// are read. Every connection delays by one communication step; the order of the slaves does not
/// matter.
///
/// By hand, in fmpy, for slaves `a` and `b`:
///
/// ```python
/// ya, yb = a.getReal(a_out), b.getReal(b_out)        # outputs at t_k
/// a.setReal(a_in, yb); b.setReal(b_in, ya)
/// a.doStep(t, h); b.doStep(t, h)
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Jacobi;

impl Algorithm for Jacobi {
    #[inline]
    fn step(&self, system: &mut System, time: f64, step: f64) -> Result<(), Error> {
        for slave in 0..system.len() {
            system.transfer(slave)?;
        }
        for slave in 0..system.len() {
            system.advance(slave, time, step)?;
            // Nobody looks at it before the next communication point.
            system.read(slave)?;
        }
        Ok(())
    }
}

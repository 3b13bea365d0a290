//! Random numbers of a seed.

use std::f64::consts::TAU;

use numerics::random::XorshiftStar64;

pub(crate) struct Random(XorshiftStar64);

impl Random {
    /// From a state that is not 0.
    pub(crate) fn new(state: u64) -> Self {
        Self(XorshiftStar64::from_state(state))
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        self.0.uniform()
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Standard normal (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().max(1e-300).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

//! What the models with a rate share: the command's rate by backward difference.
//!
//! `u̇_n = (u_n − u_{n−1})/T` over the step that ends at n; 0 at rest. As the command is held over
//! each step, this is the rate of the straight line through the samples, half a step late.

/// Two states: the last command and the last rate.
pub(super) type RateState = [f64; 2];

/// The rate over a step to `u`.
#[inline]
pub(super) fn rate(state: &RateState, u: f64, per_period: f64) -> f64 {
    (u - state[0]) * per_period
}

/// The state at rest at `u`.
pub(super) fn rest(u: f64) -> RateState {
    [u, 0.0]
}

//! What the models with a rate share: the command's rate by backward difference.
//!
//! `u̇ = (u_n − u_m)/(k·T)`: the change of the command over the time of k internal steps T that it is held
//! for. A command that is sampled more slowly than the model steps stays the same for k steps between its
//! changes: two equal gaps say so, a shorter one says that k is less, and a single longer one, or one of
//! more than 64 steps, is a pause.
//! The rate stays for k steps and is 0 behind them and at rest. So it is that of the straight line through
//! the samples of the command, half a sample late, whatever internal step divides the sample, and depends
//! on nothing but the command at the steps. With a change at every step it is the difference over the step.

/// What is remembered: the command, its rate, steps since its last change, steps that a command is held
/// for (k), and the gap that would be k if it came again.
pub type RateState = [f64; 5];

/// Most steps that a command is held for; what stays longer the same is at rest between moves.
const LONGEST: f64 = 64.0;

/// Number of its states.
pub const STATES: usize = 5;

/// Takes over the command of a step, per_period being 1/T.
#[inline]
pub fn update(state: &mut RateState, u: f64, per_period: f64) {
    step(state, u, per_period);
}

/// Takes over the command of a step, and returns by how much the rate has changed over the time that the
/// command is held for: ü, where the rate is a new one.
#[inline]
pub fn step(state: &mut RateState, u: f64, per_period: f64) -> Option<f64> {
    let [last, rate, since, held, gap] = state;
    let before = *rate;
    // From here on no gap counts.
    *since = if *since < 1e9 { *since + 1.0 } else { *since };
    if u == *last {
        if *since < *held {
            return None;
        }
        *rate = 0.0;
        return Some((0.0 - before) * per_period / *held);
    }
    if *since < *held || (*since == *gap && *since <= LONGEST) {
        *held = *since;
    }
    (*gap, *since) = (*since, 0.0);
    *rate = (u - *last) * per_period / *held;
    *last = u;
    Some((*rate - before) * per_period / *held)
}

/// The state at rest at `u`.
#[must_use]
pub fn rest(u: f64) -> RateState {
    [u, 0.0, 0.0, 1.0, 0.0]
}

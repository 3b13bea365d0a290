//! Inverses by solving the forward model for the command at each step.
//!
//! The inverse carries a copy of the forward model. At each step it looks for the command at which
//! the model's position is the wanted one, by bracketing between `command_min` and `command_max`;
//! then the copy makes that step itself, so its state stays the machine's, and errors do not add
//! up.
//!
//! A model with a rate would feed the rate of its own command back to itself, which is unstable for
//! short steps. Its rates are therefore those of the wanted position, divided by the mean slope of
//! the model's largest loop between the limits.
//!
//! Error: the bracket ends at 1e-12 of the command range after at most
//! [`EVALUATIONS`](crate::solve::EVALUATIONS) evaluations of the model (usually about 10). For
//! models with a rate, the position is wrong by the effect of the difference between the rates of
//! the command and those estimates. Positions that no command reaches give the nearest limit.

use libm::fmax;
use model::{Component, Declaration, Sizes, Tick, Violation};

use super::play::Plays;
use crate::rules::{WRONG_LENGTH, require};
use crate::solve::rising;

/// The command's rate and acceleration.
pub type Rates = [f64; 2];

/// A hysteresis model whose position rises with the command of the present step while the rates
/// stay the same.
pub trait Forward: Component {
    /// Position after one step to `u` with these rates; the state stays.
    fn frozen(&self, coefficients: &[f64], state: &[f64], rates: Rates, u: f64) -> f64;

    /// Mean slope of the loop between these limits, without rate.
    fn mean_slope(&self, coefficients: &[f64], limits: [f64; 2]) -> f64;

    /// Checks that the position rises with the command between these limits.
    ///
    /// # Errors
    /// The parameter that breaks it.
    fn check(
        &self,
        structure: &[f64],
        parameters: &[f64],
        limits: [f64; 2],
    ) -> Result<(), Violation>;
}

/// The inverse of a [`Forward`] model: its parameters, then `command_min` and `command_max`.
pub struct NumericInverse<M: 'static> {
    pub(super) forward: &'static M,
    pub(super) declaration: &'static Declaration,
}

/// Mean slope of the largest loop of plays and a part without memory between the limits: a play of
/// threshold r moves by the range less 2r.
pub(super) fn mean_slope(plays: Plays<'_>, without_memory: f64, limits: [f64; 2]) -> f64 {
    let range = limits[1] - limits[0];
    let moved = |r: &f64| fmax(range - 2.0 * r, 0.0) / range;
    without_memory + plays.r.iter().zip(plays.w).map(|(r, w)| w * moved(r)).sum::<f64>()
}

impl<M: Forward> Component for NumericInverse<M> {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        let Sizes { coefficients, states } = self.forward.sizes(structure, period);
        Sizes { coefficients: coefficients + 3, states: states + 2 }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (Some((forward, &limits)), Some((inner, bounds))) =
            (parameters.split_last_chunk::<2>(), coefficients.split_last_chunk_mut::<3>())
        else {
            return Err(WRONG_LENGTH);
        };
        require(limits[0] < limits[1], "command_min", limits[0], "must be below command_max")?;
        self.forward.prepare(structure, forward, period, inner)?;
        self.forward.check(structure, forward, limits)?;
        *bounds = [limits[0], limits[1], self.forward.mean_slope(inner, limits)];
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some((inner, &[low, high, _])), &[y], [u], Some((machine, [last, last_rate]))) = (
            coefficients.split_last_chunk::<3>(),
            inputs,
            outputs,
            state.split_last_chunk_mut::<2>(),
        ) else {
            return;
        };
        let mut position = [0.0];
        *u = rising(y, [low, high], |u| {
            self.forward.rest(inner, &[u], machine, &mut position);
            position[0]
        });
        self.forward.rest(inner, &[*u], machine, &mut position);
        (*last, *last_rate) = (y, 0.0);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((inner, &[low, high, slope])), &[y], [u], Some((machine, [last, last_rate]))) = (
            coefficients.split_last_chunk::<3>(),
            inputs,
            outputs,
            state.split_last_chunk_mut::<2>(),
        ) else {
            return;
        };
        let rate = (y - *last) / tick.period;
        let rates = [rate / slope, (rate - *last_rate) / tick.period / slope];
        (*last, *last_rate) = (y, rate);
        *u = rising(y, [low, high], |u| self.forward.frozen(inner, machine, rates, u));
        self.forward.step(inner, machine, tick, &[*u], &mut [0.0]);
    }
}

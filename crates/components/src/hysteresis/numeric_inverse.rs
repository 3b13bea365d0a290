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
//! the command and those estimates: at each step, at any frequency, by no more than
//! `L·||u̇| − |ẏ/slope||`, with L = rate·Σw for `rate-dependent-play` and `mpi`, and
//! L = max(|a2|, |b2|)·Σw for `grpi`, since a play moves no further than its edges do; for
//! `dynamic-prandtl-ishlinskii`, whose plays know no rate, by exactly `|Δφ|·|Σ P_i|`, Δφ the
//! difference of its φ between the command's rates and the estimates. Positions that no command
//! reaches give the nearest limit.

use libm::fmax;
use model::{Component, Declaration, Example, Sizes, Tick, Violation};

use super::play::Plays;
use super::rate;
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

impl<M: Forward> NumericInverse<M> {
    /// The inverse of `forward` under this declaration.
    #[must_use]
    pub const fn new(forward: &'static M, declaration: &'static Declaration) -> Self {
        Self { forward, declaration }
    }
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

    fn example(&self) -> Example {
        self.forward.example()
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        let Sizes { coefficients, states } = self.forward.sizes(structure, period);
        Sizes { coefficients: coefficients + 3, states: states + rate::STATES + 1 }
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
        let (Some((inner, &[low, high, _])), &[y], [u], Some((machine, [memory @ .., change]))) = (
            coefficients.split_last_chunk::<3>(),
            inputs,
            outputs,
            state.split_last_chunk_mut::<{ rate::STATES + 1 }>(),
        ) else {
            return;
        };
        let mut position = [0.0];
        *u = rising(y, [low, high], |u| {
            self.forward.rest(inner, &[u], machine, &mut position);
            position[0]
        });
        self.forward.rest(inner, &[*u], machine, &mut position);
        (*memory, *change) = (rate::rest(y), 0.0);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some((inner, &[low, high, slope])), &[y], [u], Some((machine, [memory @ .., change]))) = (
            coefficients.split_last_chunk::<3>(),
            inputs,
            outputs,
            state.split_last_chunk_mut::<{ rate::STATES + 1 }>(),
        ) else {
            return;
        };
        if let Some(new) = rate::step(memory, y, 1.0 / tick.period) {
            *change = new;
        }
        let rates = [memory[1] / slope, *change / slope];
        *u = rising(y, [low, high], |u| self.forward.frozen(inner, machine, rates, u));
        self.forward.step(inner, machine, tick, &[*u], &mut [0.0]);
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;
    use crate::hysteresis::{
        INVERSE_BOUC_WEN, dynamic_prandtl_ishlinskii, grpi, mpi, rate_dependent_play,
    };
    use crate::testing::Instance;

    const LIMITS: [f64; 2] = [-50.0, 150.0];
    const R: [f64; 3] = [3.0, 8.0, 20.0];
    const W: [f64; 3] = [0.01, 0.02, 0.01];

    /// Greatest error of an inverse over three periods of 1 to 7 um, the greatest part of its bound that
    /// a step takes, and whether a step broke the bound.
    fn errors(
        (forward, inverse): (&'static dyn Component, &'static dyn Component),
        parameters: &[f64],
        (slope, lipschitz): (f64, f64),
        frequency: f64,
    ) -> [f64; 2] {
        let period = 1e-3 / frequency;
        let wanted = |n: u32| 4.0 - 3.0 * (TAU * f64::from(n) * 1e-3).cos();
        let mut forward = Instance::new(forward, &[3.0], parameters, period).unwrap();
        let limited = [parameters, &LIMITS].concat();
        let mut inverse = Instance::new(inverse, &[3.0], &limited, period).unwrap();
        let mut last = inverse.rest(&[wanted(0)]);
        forward.rest(&[last]);
        let (mut greatest, mut worst) = (0.0_f64, 0.0_f64);
        for n in 1..3000 {
            let (y, u) = (wanted(n), inverse.step(&[wanted(n)]));
            let error = (forward.step(&[u]) - y).abs();
            let rate = (u - last).abs() / period;
            let estimate = (y - wanted(n - 1)).abs() / period / slope;
            last = u;
            greatest = greatest.max(error);
            worst = worst.max(error / (lipschitz * (rate - estimate).abs() + 1e-9));
        }
        [greatest, worst]
    }

    #[test]
    fn inverses_with_rate_terms_keep_their_bound_at_every_frequency() {
        let sum = W.iter().sum::<f64>();
        let slope = mean_slope(Plays { r: &R, w: &W }, 0.05, LIMITS);
        for frequency in [0.1, 1.0, 10.0, 50.0, 100.0, 200.0] {
            let growth = 1e-4;
            let p = [&R[..], &W, &[0.3, 0.05, growth]].concat();
            let pair: (&'static dyn Component, &'static dyn Component) =
                (&rate_dependent_play::RateDependentPlay, &rate_dependent_play::INVERSE);
            let [plays, part] = errors(pair, &p, (slope, growth * sum), frequency);
            assert!(part <= 1.0, "plays at {frequency} Hz: {part} of the bound");
            // Slow enough, the iteration's own end is all that is left.
            assert!(frequency > 0.5 || plays < 1e-4, "{plays}");
            let p = [&R[..], &W, &[0.3, 0.05, 0.0, 1.0, growth]].concat();
            let pair: (&'static dyn Component, &'static dyn Component) = (&mpi::Mpi, &mpi::INVERSE);
            let [_, part] = errors(pair, &p, (slope, growth * sum), frequency);
            assert!(part <= 1.0, "mpi at {frequency} Hz: {part} of the bound");
            let (r, w) = ([0.0, 8.0, 20.0], [0.05, 0.02, 0.01]);
            let p = [&r[..], &w, &[0.3, 1.0, -growth, 1.0, 1.5 * growth]].concat();
            let slope = mean_slope(Plays { r: &r, w: &w }, 0.0, LIMITS);
            let lipschitz = 1.5 * growth * w.iter().sum::<f64>();
            let pair: (&'static dyn Component, &'static dyn Component) =
                (&grpi::Grpi, &grpi::INVERSE);
            let [_, part] = errors(pair, &p, (slope, lipschitz), frequency);
            assert!(part <= 1.0, "grpi at {frequency} Hz: {part} of the bound");
        }
    }

    /// The quantity for which an inverse is refused between -64 and 128.
    fn refused(
        inverse: &'static dyn Component,
        structure: &[f64],
        parts: &[&[f64]],
    ) -> Option<(&'static str, Option<usize>)> {
        let parameters = [&parts.concat()[..], &[-64.0, 128.0]].concat();
        let built = Instance::new(inverse, structure, &parameters, 1e-3);
        built.err().map(|violation| (violation.quantity, violation.index))
    }

    #[test]
    fn models_that_have_no_inverse_are_refused() {
        let r = [0.0, 8.0, 20.0];
        let dead = [1.0, 8.0, 20.0];
        let w = [0.05, 0.02, 0.01];
        let weightless = [0.0, 0.02, 0.01];
        let at =
            |inverse, r: &[f64], w: &[f64], rest: &[f64]| refused(inverse, &[3.0], &[r, w, rest]);
        let neutral = [0.3, 1.0, 0.0, 1.0, 0.0];
        assert_eq!(at(&grpi::INVERSE, &r, &w, &neutral), None);
        assert_eq!(at(&grpi::INVERSE, &dead, &w, &neutral), Some(("r", Some(0))));
        assert_eq!(at(&grpi::INVERSE, &r, &weightless, &neutral), Some(("w", Some(0))));

        let dynamic = |r: &[f64], w: &[f64]| {
            let inverse = &dynamic_prandtl_ishlinskii::INVERSE;
            refused(inverse, &[3.0, 4.0], &[r, w, &[0.0; 8], &[0.3]])
        };
        assert_eq!(dynamic(&r, &w), None);
        assert_eq!(dynamic(&dead, &w), Some(("r", Some(0))));
        assert_eq!(dynamic(&r, &weightless), Some(("w", Some(0))));

        let plays = |gain| at(&rate_dependent_play::INVERSE, &R, &W, &[0.3, gain, 1e-4]);
        assert_eq!((plays(0.05), plays(0.0)), (None, Some(("gain", None))));

        // 3 * 2^-20 * 128^2 = 3/64 is the fall of the cubic part's slope.
        let cubic = -(-20.0_f64).exp2();
        let polynomial =
            |linear, cubic| at(&mpi::INVERSE, &R, &W, &[0.3, linear, cubic, 1.0, 1e-4]);
        assert_eq!((polynomial(0.05, cubic), polynomial(0.05, 0.0)), (None, None));
        assert_eq!(polynomial(3.0 / 64.0, cubic), Some(("cubic", None)));
        assert_eq!(polynomial(0.0, 0.0), Some(("linear", None)));

        // alpha*(1 + (0.05 - 0.01 + 0.02)/(0.05 + 0.01 - 0.02)) = 2.5*alpha.
        let bouc_wen = |alpha| {
            let parameters = [1.0, alpha, 0.05, 0.01, 0.02, 1.0, 0.0];
            refused(&INVERSE_BOUC_WEN, &[], &[&parameters])
        };
        assert_eq!((bouc_wen(0.39), bouc_wen(0.41)), (None, Some(("alpha", None))));
    }

    #[test]
    fn a_play_of_a_fourth_of_the_range_adds_half_its_weight() {
        let plays = Plays { r: &[0.0, 50.0, 120.0], w: &[0.01, 0.02, 0.04] };
        assert!((mean_slope(plays, 0.3, LIMITS) - 0.32).abs() < 1e-15);
    }

    #[test]
    fn limits_without_a_range_are_refused() {
        let p = [&R[..], &W, &[0.3, 0.05, 1e-4]].concat();
        let built = |limits: [f64; 2]| {
            let parameters = [&p[..], &limits].concat();
            Instance::new(&rate_dependent_play::INVERSE, &[3.0], &parameters, 1e-3).err()
        };
        assert_eq!(built([5.0, 5.0]).map(|v| (v.quantity, v.value)), Some(("command_min", 5.0)));
        assert!(built([5.0, 5.5]).is_none());
    }
}

//! Transport delay of any length, a fraction of a step included.
//!
//! `y(t) = u(t − delay)`
//!
//! * The input is held over each step, so the delayed input over a step is the value before the
//!   last whole step for a fraction f of it and the value after for the rest. The output is its
//!   mean over the step, `(1 − f)·u[n−d] + f·u[n−d−1]` with delay = (d + f)·period: the linear
//!   interpolation between samples, exact for whole steps and exact in the mean for every signal.
//! * State: a ring of the past inputs, long enough for the structural setting `longest`.
//! * A delay of 0 passes the input on bit for bit.
//!
//! Limits: for a fractional delay the interpolation is a low-pass, in the worst case (f = ½)
//! |cos(π·frequency·period)|: 1 % at frequency·period = 0.045.

use libm::{ceil, floor, round};
use model::{Component, Declaration, Quantity, Sizes, Stage, Structural, Tick, Violation};

use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `delay`.
pub struct Delay;

static DECLARATION: Declaration = Declaration {
    kind: "delay",
    name: "delay",
    summary: "Transport delay (computing, bus, converter), also by a fraction of a step",
    equation: "y(t) = u(t - delay)",
    reference: "K. J. Astrom, B. Wittenmark, Computer-Controlled Systems, 3rd ed. 1997, ch. 2",
    stage: Stage::Timing,
    effect: Some(&effects::DELAY),
    phenomena: &[&phenomena::TRANSPORT_DELAY, &phenomena::ELLIPSE_ERROR],
    structure: &[Structural::real(
        "longest",
        "s",
        "Longest delay that can be set",
        0.01,
        0.0,
        10.0,
    )],
    parameters: &[Quantity::new("delay", "s", "Delay")
        .releases(&effects::DELAY)
        .min(0.0)
        .at_most(0)
        .fitted()],
    ..Declaration::PATH
};

/// Steps up to this relative distance from an integer count as one: a delay and a period that were both
/// rounded to double precision must not leave a fraction of 1e-16 behind.
const INTEGER_TOLERANCE: f64 = 1e-9;

/// Cells that a ring needs for the structural setting `longest`: its position, the delayed inputs,
/// the present one, the one before the fraction, and one for the rounding of the ratio.
pub(crate) fn ring_size(structure: &[f64], period: f64) -> usize {
    let steps = ceil(structure.first().copied().unwrap_or(0.0) / period);
    if steps.is_finite() { steps as usize + 4 } else { 4 }
}

/// Whole steps of a delay and the fraction behind them.
pub(crate) fn steps_of(
    quantity: &'static str,
    delay: f64,
    longest: f64,
    period: f64,
) -> Result<(f64, f64), Violation> {
    require(
        delay <= longest,
        quantity,
        delay,
        "is longer than the structural setting `longest` of the blueprint; raise `longest`",
    )?;
    let steps = delay / period;
    let nearest = round(steps);
    if (steps - nearest).abs() <= INTEGER_TOLERANCE * nearest.max(1.0) {
        return Ok((nearest, 0.0));
    }
    let integer = floor(steps);
    Ok((integer, steps - integer))
}

/// The past inputs: the place of the present one, then the cells.
pub(crate) struct Ring<'a>(pub(crate) &'a mut [f64]);

impl Ring<'_> {
    /// Fills the ring with a held input.
    pub(crate) fn rest(&mut self, u: f64) {
        self.0.fill(u);
        self.0.iter_mut().take(1).for_each(|place| *place = 0.0);
    }

    /// Most whole steps that it goes back, with a fraction behind them.
    pub(super) fn reach(&self) -> usize {
        self.0.len().saturating_sub(3)
    }

    /// Stores the present input and returns the one that lies `integer` steps and a fraction back.
    #[inline]
    pub(crate) fn push(&mut self, u: f64, integer: f64, fraction: f64) -> f64 {
        let Some((place, cells)) = self.0.split_first_mut() else { return u };
        let room = cells.len();
        let last = *place as usize;
        let at = if last < room.saturating_sub(1) { last + 1 } else { 0 };
        *place = at as f64;
        if let Some(cell) = cells.get_mut(at) {
            *cell = u;
        }
        let integer = (integer as usize).min(room);
        let past = |steps: usize| {
            cells.get(if at >= steps { at - steps } else { (at + room).wrapping_sub(steps) })
        };
        let (Some(&newer), Some(&older)) = (past(integer), past(integer + 1)) else { return u };
        if fraction == 0.0 { newer } else { newer + fraction * (older - newer) }
    }
}

impl Component for Delay {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        Sizes { coefficients: 2, states: ring_size(structure, period) }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[longest], &[delay], [integer, fraction]) = (structure, parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        (*integer, *fraction) = steps_of("delay", delay, longest, period)?;
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [y]) = (inputs, outputs) else { return };
        Ring(state).rest(u);
        *y = u;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[integer, fraction], &[u], [y]) = (coefficients, inputs, outputs) else { return };
        *y = Ring(state).push(u, integer, fraction);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, Random};

    fn delayed(delay: f64, period: f64, count: usize) -> (std::vec::Vec<f64>, std::vec::Vec<f64>) {
        let mut model = Instance::new(&Delay, &[0.01], &[delay], period).unwrap();
        let signal = Random::new(11).signal(-1.0, 1.0, count);
        let output = model.response(0.5, &signal);
        (signal, output)
    }

    #[test]
    fn integer_steps_are_exact() {
        // 3 · 0.1 ms and the like are no exact multiples in binary.
        for steps in [0usize, 1, 2, 3, 7, 50, 100] {
            let (signal, output) = delayed(steps as f64 * 1e-4, 1e-4, 400);
            assert!(output[..steps].iter().all(|y| *y == 0.5));
            assert_eq!(&output[steps..], &signal[..400 - steps], "{steps} steps");
        }
    }

    #[test]
    fn a_fraction_interpolates_and_keeps_the_mean() {
        let (signal, output) = delayed(2.25e-4, 1e-4, 300);
        for n in 3..300 {
            let expected = 0.75 * signal[n - 2] + 0.25 * signal[n - 3];
            assert!((output[n] - expected).abs() < 1e-15);
        }
        let mut step = Instance::new(&Delay, &[0.01], &[2.25e-4], 1e-4).unwrap();
        // The integral of a unit step after 10 steps is 10 steps less the delay.
        let sum: f64 = step.response(0.0, &[1.0; 10]).iter().sum();
        assert!((sum - (10.0 - 2.25)).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn constant_inputs_stay_constant_to_the_bit() {
        let mut model = Instance::new(&Delay, &[0.01], &[2.3e-4], 1e-4).unwrap();
        assert!(model.response(0.1, &[0.1; 20]).iter().all(|y| y.to_bits() == 0.1f64.to_bits()));
    }

    #[test]
    fn a_delay_beyond_the_longest_is_refused() {
        let error = Instance::new(&Delay, &[0.01], &[0.0101], 1e-4).err();
        assert_eq!(error.map(|e| (e.quantity, e.value)), Some(("delay", 0.0101)));
        assert!(Instance::new(&Delay, &[0.01], &[0.01], 3e-5).is_ok());
    }
}

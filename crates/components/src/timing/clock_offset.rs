//! Offset and jitter of the sample clock, as a delay that grows and trembles.
//!
//! `y(t) = u(t − d(t))`, `d = initial + offset·t + jitter·n`, t the time since the start
//!
//! * initial in s: delay at the start; offset without unit: relative clock error (1e-6 to 1e-4; >
//!   0: the signal arrives later and later); jitter in s: standard deviation of the independent
//!   normal number n of each step; seed: any number, mixed with the component's place.
//! * d is kept between 0 and the structural setting `longest`. Between samples the input is
//!   interpolated as in `delay`.
//! * State: a ring of the past inputs. The jitter is a function of seed and step.
//!
//! Limits: a clock that runs ahead needs an `initial` to take from; after `longest` the delay
//! stays.

use model::{Component, Declaration, Quantity, Sizes, Stage, Structural, Tick, Violation};

use super::delay::{Ring, ring_size};
use crate::hysteresis::play::between;
use crate::random::normal;
use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `clock-offset`.
pub struct ClockOffset;

static DECLARATION: Declaration = Declaration {
    kind: "clock-offset",
    name: "clock",
    summary: "Offset and jitter of the sample clock, as a delay that changes",
    equation: "y(t) = u(t - d); d = initial + offset*t + jitter*n",
    reference: "IEEE Std 1241, Terminology and Test Methods for Analog-to-Digital Converters",
    stage: Stage::Timing,
    effect: Some(&effects::CLOCK_OFFSET),
    phenomena: &[&phenomena::CLOCK_OFFSET],
    structure: &[Structural::real("longest", "s", "Longest delay", 0.01, 0.0, 10.0)],
    parameters: &[
        Quantity::new("initial", "s", "Delay at the start").start(0.0).min(0.0).at_most(0).fitted(),
        Quantity::new("offset", "1", "Relative clock error").start(0.0).fitted(),
        Quantity::new("jitter", "s", "Standard deviation of the jitter")
            .start(0.0)
            .min(0.0)
            .fitted(),
        Quantity::new("seed", "1", "Seed of the jitter").start(1.0).seed(),
    ],
    ..Declaration::PATH
};

impl Component for ClockOffset {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        Sizes { coefficients: 4, states: ring_size(structure, period) }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[initial, offset, jitter, seed], [first, growth, spread, key]) =
            (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        let longest = structure.first().copied().unwrap_or(0.0);
        let rule = "is longer than the structural setting `longest` of the blueprint; raise it";
        require(initial <= longest, "initial", initial, rule)?;
        (*first, *growth, *spread, *key) = (initial / period, offset, jitter / period, seed);
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
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[first, growth, spread, seed], &[u], [y]) = (coefficients, inputs, outputs) else {
            return;
        };
        let jitter = if spread == 0.0 { 0.0 } else { spread * normal(seed, 0, tick.index) };
        let mut ring = Ring(state);
        let most = ring.reach() as f64;
        let steps = between(0.0, most, first + growth * tick.index as f64 + jitter);
        let integer = steps as usize as f64;
        *y = ring.push(u, integer, steps - integer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn a_late_clock_shifts_a_ramp_by_its_offset_times_the_time() {
        let period = 1e-3;
        let mut clock =
            Instance::new(&ClockOffset, &[0.01], &[2e-3, 1e-4, 0.0, 1.0], period).unwrap();
        clock.rest(&[0.0]);
        for n in 1..20_000 {
            let t = f64::from(n) * period;
            let y = clock.step(&[t]);
            if n > 10 {
                assert!((y - (t - 2e-3 - 1e-4 * t)).abs() < 1e-12, "{t}: {y}");
            }
        }
    }

    #[test]
    fn jitter_has_its_standard_deviation_and_depends_on_the_seed() {
        let period = 1e-3;
        let spread = |seed: f64| {
            let p = [5e-3, 0.0, 2e-4, seed];
            let mut clock = Instance::new(&ClockOffset, &[0.01], &p, period).unwrap();
            clock.rest(&[0.0]);
            let t = |n: u32| f64::from(n) * period;
            let all = (1..20_000).map(|n| (n, clock.step(&[t(n)])));
            let errors: std::vec::Vec<f64> =
                all.filter(|(n, _)| *n > 20).map(|(n, y)| y - t(n) + 5e-3).collect();
            let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
            (variance.sqrt(), errors[0])
        };
        let ((one, first), (other, second)) = (spread(1.0), spread(2.0));
        assert!((one / 2e-4 - 1.0).abs() < 0.03 && (other / 2e-4 - 1.0).abs() < 0.03);
        assert!(first != second);
    }
}

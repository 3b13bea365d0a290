//! Exact discretisation of first- and second-order linear systems whose input is held over a step,
//! and rounding to a resolution.

use core::f64::consts::TAU;

use libm::{cos, exp, expm1, sin, sqrt};

/// The part of the way to its input that a first-order lag of this bandwidth (Hz) goes in one
/// period (s): `1 − exp(−2π·bandwidth·period)`, without cancellation for slow lags.
#[must_use]
pub fn lag_fraction(bandwidth: f64, period: f64) -> f64 {
    -expm1(-TAU * bandwidth * period)
}

/// The part of the way to its input that a first-order lag of this time constant goes in one period, both in s:
/// `1 − exp(−period/time_constant)`.
#[must_use]
pub fn approach(time_constant: f64, period: f64) -> f64 {
    -expm1(-period / time_constant)
}

/// The transition of `e″ + 2ζω e′ + ω² e = 0` over one period, for the state `(e, e′/ω)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// From e to e.
    pub same: f64,
    /// From e′/ω to e, and with the opposite sign from e to e′/ω.
    pub cross: f64,
    /// From e′/ω to e′/ω.
    pub rate: f64,
}

impl Transition {
    /// The transition for a natural frequency in Hz, a damping ratio ζ > 0 and a period in s.
    ///
    /// One formula per side of ζ = 1, both continuous there and free of overflow: for ζ ≥ 1 the two
    /// real exponentials are formed from their own exponents, and never as cosh · exp.
    #[must_use]
    pub fn new(frequency: f64, damping: f64, period: f64) -> Self {
        let angle = TAU * frequency * period;
        let (even, odd) = if damping < 1.0 {
            let root = sqrt((1.0 - damping) * (1.0 + damping));
            let decay = exp(-damping * angle);
            (decay * cos(root * angle), decay * sin(root * angle) / root)
        } else {
            let root = sqrt((damping - 1.0) * (damping + 1.0));
            // ζ − √(ζ²−1) without cancellation.
            let slow = exp(-angle / (damping + root));
            let fast = exp(-angle * (damping + root));
            let odd = if root > 0.0 {
                -slow * expm1(-2.0 * root * angle) / (2.0 * root)
            } else {
                slow * angle
            };
            (0.5 * (slow + fast), odd)
        };
        Self { same: even + damping * odd, cross: odd, rate: even - damping * odd }
    }

    /// The state `(e, e′/ω)` one period later.
    #[inline]
    #[must_use]
    pub fn apply(&self, e: f64, rate: f64) -> (f64, f64) {
        (self.same * e + self.cross * rate, self.rate * rate - self.cross * e)
    }
}

/// A second-order low-pass with a static gain, exact while its input is held: what amplifiers,
/// sensors and modes have in common. Its state is `(x, x′/ω)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondOrder {
    transition: Transition,
    gain: f64,
}

impl SecondOrder {
    /// Number of coefficients.
    pub const COEFFICIENTS: usize = 4;

    /// For a natural frequency in Hz, a damping ratio ζ > 0, a static gain and a period in s.
    #[must_use]
    pub fn new(frequency: f64, damping: f64, gain: f64, period: f64) -> Self {
        Self { transition: Transition::new(frequency, damping, period), gain }
    }

    /// As coefficients of a component.
    #[must_use]
    pub fn to_array(self) -> [f64; Self::COEFFICIENTS] {
        let Transition { same, cross, rate } = self.transition;
        [same, cross, rate, self.gain]
    }

    /// From coefficients of a component.
    #[inline]
    #[must_use]
    pub fn of([same, cross, rate, gain]: [f64; Self::COEFFICIENTS]) -> Self {
        Self { transition: Transition { same, cross, rate }, gain }
    }

    /// Settles under a held input and returns x.
    pub fn rest(&self, input: f64, [x, v]: &mut [f64; 2]) -> f64 {
        (*x, *v) = (self.gain * input, 0.0);
        *x
    }

    /// Goes on by a period and returns x.
    #[inline]
    pub fn step(&self, input: f64, [x, v]: &mut [f64; 2]) -> f64 {
        let target = self.gain * input;
        let (e, rate) = self.transition.apply(*x - target, *v);
        (*x, *v) = (target + e, rate);
        *x
    }
}

/// `x` to the nearest `resolution·(k + phase)` with a whole number k, halves away from zero; values whose number of
/// steps is no longer exact in double precision pass.
#[inline]
#[must_use]
pub fn quantise(x: f64, resolution: f64, phase: f64) -> f64 {
    const EXACT: f64 = (1u64 << 53) as f64;
    let steps = x / resolution - phase;
    if steps.abs() < EXACT {
        let integer = steps as i64 as f64;
        // The difference is exact.
        let up = if (steps - integer).abs() >= 0.5 { 1.0_f64.copysign(steps) } else { 0.0 };
        resolution * (integer + up + phase)
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transition_over_two_periods_is_two_transitions() {
        for damping in [1e-4, 0.02, 0.7, 1.0 - 1e-12, 1.0, 1.0 + 1e-12, 1.5, 50.0] {
            for cycles in [1e-4, 0.3, 7.3] {
                let one = Transition::new(cycles, damping, 1.0);
                let two = Transition::new(cycles, damping, 2.0);
                for start in [(1.0, 0.0), (0.0, 1.0)] {
                    let (e, r) = one.apply(start.0, start.1);
                    let (a, b) = (one.apply(e, r), two.apply(start.0, start.1));
                    let error = (a.0 - b.0).abs().max((a.1 - b.1).abs());
                    assert!(error < 1e-13, "zeta {damping}, {cycles} periods: {error}");
                }
            }
        }
    }

    #[test]
    fn determinant_is_the_decay_of_both_poles() {
        for damping in [3.63e-4, 0.5, 0.999_999, 1.0, 1.000_001, 3.0] {
            let t = Transition::new(40.0, damping, 1e-3);
            let determinant = t.same * t.rate + t.cross * t.cross;
            let expected = exp(-2.0 * damping * TAU * 40.0 * 1e-3);
            assert!((determinant / expected - 1.0).abs() < 1e-12, "zeta {damping}");
        }
    }

    #[test]
    fn quantising_rounds_as_the_definition_does() {
        let mut random = crate::testing::Random::new(9);
        let edges = [0.0, -0.0, 0.5, -0.5, 1.5, 0.499_999_999_999_999_94, 4.5e15, 9.1e15, -2.5];
        let drawn = (0..10_000).map(|_| random.between(-40.0, 40.0));
        for x in edges.into_iter().chain(drawn) {
            assert_eq!(quantise(x, 1.0, 0.0), x.round(), "{x}");
            assert_eq!(quantise(x, 0.5, 0.25), 0.5 * ((2.0 * x - 0.25).round() + 0.25), "{x}");
        }
        assert!(quantise(f64::NAN, 1.0, 0.0).is_nan());
    }

    #[test]
    fn overdamped_limits_do_not_overflow() {
        let t = Transition::new(1e6, 1e6, 1.0);
        assert!(t.same.is_finite() && t.cross.is_finite() && t.rate.is_finite());
        assert!(t.same.abs() < 1.0);
    }
}

//! A mode with a force that depends on its deflection or its velocity, in sub-steps.

use core::f64::consts::TAU;

use libm::ceil;
use model::Violation;

use crate::linear::Transition;
use crate::rules::require;

/// Greatest turn of the stiffest motion in one sub-step, in rad.
const TURN: f64 = 0.05;

/// `x″ + 2ζω x′ + ω²·[x + beyond(x, x′/ω)] = ω²·u`: in each sub-step the linear part is exact and `beyond`
/// is taken at its middle (exponential midpoint rule, second order). A state of equilibrium stays
/// exactly.
///
/// Source: M. Hochbruck, A. Ostermann, Exponential integrators, Acta Numerica 19 (2010) 209–286.
#[derive(Clone, Copy)]
pub(super) struct SubSteps {
    full: Transition,
    half: Transition,
    count: f64,
}

impl SubSteps {
    /// Number of coefficients.
    pub(super) const COEFFICIENTS: usize = 7;

    /// For a mode whose stiffness grows to at most `stiffest`² times that of small motions.
    pub(super) fn new(
        frequency: f64,
        damping: f64,
        stiffest: f64,
        period: f64,
    ) -> Result<Self, Violation> {
        let count = ceil(TAU * frequency * period * stiffest / TURN);
        require(
            count <= 10_000.0,
            "frequency",
            frequency,
            "is too high for the internal step; shorten `step` in the blueprint",
        )?;
        Ok(Self::of_count(frequency, damping, count, period))
    }

    /// A step of `count` sub-steps.
    pub(super) fn of_count(frequency: f64, damping: f64, count: f64, period: f64) -> Self {
        let full = Transition::new(frequency, damping, period / count);
        let half = Transition::new(frequency, damping, 0.5 * period / count);
        Self { full, half, count }
    }

    /// The coefficients of a component.
    pub(super) fn to_array(self) -> [f64; Self::COEFFICIENTS] {
        let Self { full, half, count } = self;
        [full.same, full.cross, full.rate, half.same, half.cross, half.rate, count]
    }

    /// The sub-steps that coefficients of a component stand for.
    #[inline]
    pub(super) fn of([a, b, c, d, e, f, count]: [f64; Self::COEFFICIENTS]) -> Self {
        let full = Transition { same: a, cross: b, rate: c };
        Self { full, half: Transition { same: d, cross: e, rate: f }, count }
    }

    /// Goes on by a period under the held input `u` and returns x; the state is `(x, x′/ω)`.
    #[inline]
    pub(super) fn advance(
        &self,
        u: f64,
        [x, v]: &mut [f64; 2],
        beyond: impl Fn(f64, f64) -> f64,
    ) -> f64 {
        for _ in 0..self.count as usize {
            let target = u - beyond(*x, *v);
            let (middle, turned) = self.half.apply(*x - target, *v);
            let target = u - beyond(target + middle, turned);
            let (deviation, rate) = self.full.apply(*x - target, *v);
            (*x, *v) = (target + deviation, rate);
        }
        *x
    }
}

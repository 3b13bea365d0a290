//! A second-order mode under a force that depends on its position, its velocity or its past.

use core::f64::consts::TAU;

use libm::{ceil, fmax};
use model::Violation;

use crate::linear::Transition;
use crate::rules::require;

/// Greatest angle of the mode in a part of a step, in rad, where the force is smooth and makes the mode at most 1.5² times
/// as stiff as it is for small motions.
pub const SMOOTH: f64 = 0.4;
/// The square root of a stiffness over that of small motions, above which parts are shorter than [`SMOOTH`].
const STIFFEST: f64 = 1.5;

/// `x″ + 2ζω x′ + ω²·[x + pull] = ω²·u` with an input u that is held over a step. A step is cut into parts. In each
/// part the linear motion is exact, and the force acts as a part of the input:
///
/// * A force that is smooth in x and x′ goes into the exact motion by the rule of Runge and Kutta, which is of fourth
///   order (J. D. Lawson, SIAM J. Numer. Anal. 4 (1967) 372–380). A mode is known to 1e-4 and better, and the error of
///   a rule of second order looks like a damping.
/// * Friction is taken at the middle of each part (exponential midpoint rule, second order). At its begin it
///   would come late.
///
/// A state of equilibrium stays. For both rules: M. Hochbruck, A. Ostermann, Acta Numerica 19 (2010) 209–286.
#[derive(Clone, Copy, Debug)]
pub struct ForcedMode {
    full: Transition,
    half: Transition,
    /// Parts of a step.
    parts: f64,
    /// Angle of the mode in a part, in rad, where the force is smooth; else zero.
    smooth: f64,
}

impl ForcedMode {
    /// Number of coefficients.
    pub const COEFFICIENTS: usize = 8;

    /// For this number of parts of a step: frequency in Hz, damping ratio, step in s, whether the force is smooth.
    #[must_use]
    pub fn new(frequency: f64, damping: f64, step: f64, parts: f64, is_smooth: bool) -> Self {
        let part = step / parts;
        let half = Transition::new(frequency, damping, 0.5 * part);
        let smooth = if is_smooth { TAU * frequency * step / parts } else { 0.0 };
        Self { full: Transition::new(frequency, damping, part), half, parts, smooth }
    }

    /// For a smooth force in as many parts as it needs: frequency in Hz, damping ratio, step in s. `stiffest` is the
    /// square root of the greatest stiffness over that of small motions.
    ///
    /// # Errors
    /// A step of more than 10 000 parts.
    pub fn smooth(
        frequency: f64,
        damping: f64,
        step: f64,
        stiffest: f64,
    ) -> Result<Self, Violation> {
        let angle = TAU * frequency * step;
        let parts = fmax(ceil(angle / SMOOTH * fmax(stiffest / STIFFEST, 1.0)), 1.0);
        require(
            parts <= 10_000.0,
            "frequency",
            frequency,
            "is too high for the internal step; shorten `step` in the blueprint",
        )?;
        Ok(Self::new(frequency, damping, step, parts, true))
    }

    /// The coefficients of a component.
    pub(crate) fn to_array(self) -> [f64; Self::COEFFICIENTS] {
        let Self { full, half, parts, smooth } = self;
        [full.same, full.cross, full.rate, half.same, half.cross, half.rate, parts, smooth]
    }

    /// The mode that coefficients of a component stand for.
    #[inline]
    pub(crate) fn of([a, b, c, d, e, f, parts, smooth]: [f64; Self::COEFFICIENTS]) -> Self {
        let full = Transition { same: a, cross: b, rate: c };
        Self { full, half: Transition { same: d, cross: e, rate: f }, parts, smooth }
    }

    /// Goes on by a step under the input `u` that is held, and returns the position. State: position, rate over the
    /// natural frequency, position before. `pull` gives the sum of the forces over the linear stiffness at a
    /// position, the way since the last one, and the rate over the natural frequency. It is told whether the
    /// forces' own states go on with it.
    #[inline]
    pub fn step(
        &self,
        u: f64,
        z: &mut [f64; 3],
        mut pull: impl FnMut((f64, f64, f64), bool) -> f64,
    ) -> f64 {
        let [position, rate, before] = z;
        for _ in 0..self.parts as usize {
            if self.smooth > 0.0 {
                *before = *position;
                (*position, *rate) = self.smoothly(u, (*position, *rate), &mut pull);
                continue;
            }
            let target = u - pull((*position, *position - *before, *rate), true);
            let (e, r) = self.half.apply(*position - target, *rate);
            // A friction's own state goes on with the position that comes out, not with this guess.
            let target = u - pull((target + e, target + e - *position, r), false);
            *before = *position;
            let (e, r) = self.full.apply(*position - target, *rate);
            (*position, *rate) = (target + e, r);
        }
        *position
    }

    /// As [`step`](Self::step), for a component whose force has no state; the state is the position, and the rate over
    /// the natural frequency. `pull` is given both.
    #[inline]
    pub(crate) fn advance(
        &self,
        u: f64,
        [x, v]: &mut [f64; 2],
        pull: impl Fn(f64, f64) -> f64,
    ) -> f64 {
        let mut z = [*x, *v, *x];
        self.step(u, &mut z, |(x, _, rate), _| pull(x, rate));
        [*x, *v, _] = z;
        *x
    }

    /// Position and rate after a part in which the force changes smoothly. A rest stays one: what the force is at its
    /// begin is part of the exact motion.
    #[inline]
    fn smoothly(
        &self,
        u: f64,
        (position, rate): (f64, f64),
        mut pull: impl FnMut((f64, f64, f64), bool) -> f64,
    ) -> (f64, f64) {
        let first = pull((position, 0.0, rate), true);
        let target = u - first;
        let (half, full, angle) = (self.half, self.full, self.smooth);
        // The kick of what the force has changed since the begin.
        let mut kick = |e: f64, r: f64| angle * (first - pull((target + e, 0.0, r), false));
        let (e, r) = half.apply(position - target, rate);
        let second = kick(e, r);
        let third = kick(e, r + 0.5 * second);
        let (e, r) = full.apply(position - target, rate);
        let (late, turned) = half.apply(0.0, third);
        let fourth = kick(e + late, r + turned);
        let (late, turned) = half.apply(0.0, second + third);
        (target + e + late / 3.0, r + turned / 3.0 + fourth / 6.0)
    }
}

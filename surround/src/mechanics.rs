//! The mode of an FMU: taken out behind it, and put in again, as it is or with another force on it.

use components::linear::Transition;
use serde::{Deserialize, Serialize};

/// What is added to the equation of motion of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Force {
    /// Cubic stiffness: `k₃·(x/X)²` of the linear force, X the far end of the range.
    Cubic,
    /// Quadratic and cubic stiffness.
    Uneven,
    /// Dry friction with a pre-sliding distance, over the stiffness.
    Friction,
    /// Damping that grows with the speed: `ratio·(x′/ω)·|x′/ω|/X`, X the far end of the range.
    SpeedDamping,
    /// Coulomb friction `size·tanh(x′/(ω·smooth))`, over the stiffness.
    Coulomb,
}

impl Force {
    /// Number of its parameters.
    #[must_use]
    pub fn count(self) -> usize {
        match self {
            Self::Cubic | Self::SpeedDamping => 1,
            Self::Uneven | Self::Friction | Self::Coulomb => 2,
        }
    }

    /// Parts of a step in which the force is held: friction turns quickly.
    #[must_use]
    pub fn parts(self) -> u8 {
        match self {
            Self::Cubic | Self::Uneven => 1,
            Self::Friction | Self::Coulomb | Self::SpeedDamping => 3,
        }
    }

    /// The force over the linear stiffness, as a displacement: at the position x, `way` after the last
    /// one, with the rate over ω; z is the state of the friction.
    pub fn pull(self, p: &[f64], (x, way, rate): (f64, f64, f64), z: &mut f64, far: f64) -> f64 {
        // The flexure is straight where the position is zero.
        let e = x / far;
        match (self, p) {
            (Self::Cubic, &[cubic]) => x * cubic * e * e,
            (Self::Uneven, &[square, cubic]) => x * (square * e + cubic * e * e),
            (Self::Friction, &[size, distance]) => {
                let decay = (-way.abs() / distance).exp();
                *z = way.signum() * (1.0 - decay) + *z * decay;
                size * *z
            }
            (Self::SpeedDamping, &[ratio]) => ratio * rate * rate.abs() / far,
            (Self::Coulomb, &[size, smooth]) => size * (rate / smooth).tanh(),
            _ => 0.0,
        }
    }

    /// Where a mode rests under the input u: the equilibrium by fixed-point steps.
    pub fn rest(self, p: &[f64], u: f64, z: &mut f64, far: f64) -> f64 {
        (0..50).fold(u, |x, _| u - self.pull(p, (x, 0.0, 0.0), z, far))
    }
}

/// The position of a unit-gain mode; the state is position and rate over the natural frequency.
pub(crate) fn mode((frequency, damping): (f64, f64), x: f64, dt: f64, z: &mut [f64]) -> f64 {
    let [position, rate] = z else { return x };
    if dt > 0.0 {
        let (e, r) = Transition::new(frequency, damping, dt).apply(*position - x, *rate);
        (*position, *rate) = (x + e, r);
    }
    *position
}

/// What must have been held at the input of a unit-gain mode over the step, for its position to be x
/// now. State: as that of the mode.
pub(crate) fn before_mode((frequency, damping): (f64, f64), x: f64, dt: f64, z: &mut [f64]) -> f64 {
    let [position, rate] = z else { return x };
    let transition = Transition::new(frequency, damping, dt);
    // x = u + same·(position − u) + cross·rate.
    let free = 1.0 - transition.same;
    if dt <= 0.0 || free == 0.0 {
        return x;
    }
    let u = (x - transition.same * *position - transition.cross * *rate) / free;
    let (_, r) = transition.apply(*position - u, *rate);
    (*position, *rate) = (x, r);
    u
}

/// The position of a unit-gain mode with a force on it, which acts as a part of the input that is held.
/// State: position, rate over the natural frequency, state of the friction, position before.
pub(crate) fn forced(
    ((frequency, damping), force, far): ((f64, f64), Force, f64),
    p: &[f64],
    u: f64,
    dt: f64,
    z: &mut [f64],
) -> f64 {
    let [position, rate, slide, before] = z else { return u };
    if dt > 0.0 {
        let transition = Transition::new(frequency, damping, dt / f64::from(force.parts()));
        for _ in 0..force.parts() {
            let at = (*position, *position - *before, *rate);
            let target = u - force.pull(p, at, slide, far);
            *before = *position;
            let (e, r) = transition.apply(*position - target, *rate);
            (*position, *rate) = (target + e, r);
        }
    }
    *position
}

/// A displacement behind a pre-sliding spring; the state is its slide, and x before.
pub(crate) fn dahl(size: f64, distance: f64, x: f64, z: &mut [f64]) -> f64 {
    let [slide, before] = z else { return x };
    let way = (x - *before) / distance;
    *before = x;
    // z′ = v/d·(1 − z·sign v), exactly over a step of constant direction.
    let decay = (-way.abs()).exp();
    *slide = way.signum() * (1.0 - decay) + *slide * decay;
    x - size * *slide
}

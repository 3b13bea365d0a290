//! Warmth of an actuator from the power of its drive.

use components::linear::approach;
use serde::{Deserialize, Serialize};

use crate::kernel::{Bank, Step, Wires};

/// What warms an actuator, over its mean in the log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "of", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Loss {
    /// The square of the drive's rate, as in a resistance.
    Rate {
        /// The rate's mean.
        mean: f64,
    },
    /// The rate times the drive, voltage times current.
    Apparent {
        /// The apparent's mean.
        mean: f64,
    },
    /// The rate times the distance from the centre, as the area of loops: the same at every rate of a
    /// loop, f·V².
    Loops {
        /// The loops' mean.
        mean: f64,
        /// The centre.
        centre: f64,
    },
}

impl Loss {
    /// The power at a drive with this rate, over its mean.
    #[inline]
    fn power(self, drive: f64, rate: f64) -> f64 {
        match self {
            Self::Rate { mean } => rate * rate / mean,
            Self::Apparent { mean } => (rate * drive).abs() / mean,
            Self::Loops { mean, centre } => (rate * (drive - centre)).abs() / mean,
        }
    }
}

/// Where warmth goes.
#[derive(Clone, Copy)]
pub(crate) enum Onto {
    /// It adds to the path: over its half range.
    Path(f64),
    /// It changes the gain.
    Gain,
}

/// The warmth T of `τ T′ = P/mean − T` with the power P of the losses grows from 0. State: T, the drive before,
/// the path at rest.
#[derive(Clone)]
pub(crate) struct Heating {
    pub(crate) loss: Loss,
    pub(crate) onto: Onto,
    pub(crate) growth: f64,
    /// τ in s.
    pub(crate) time: f64,
    /// Length of the step in s, and the part of the way to the power in it.
    pub(crate) step: (f64, f64),
}

impl Step<3> for Heating {
    fn set_step(&mut self, dt: f64) {
        self.step = (dt, approach(self.time, dt));
    }

    fn rest(&self, w: Wires) -> ([f64; 3], f64) {
        ([0.0, w.drive, w.x], w.x)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, [warmth, before, rest]: &mut [f64; 3]) -> f64 {
        let (dt, fraction) = self.step;
        let power = self.loss.power(w.drive, (w.drive - *before) / dt);
        *before = w.drive;
        *warmth += fraction * (power - *warmth);
        match self.onto {
            Onto::Path(half) => w.x + self.growth * half * *warmth,
            Onto::Gain => w.x + self.growth * *warmth * (w.x - *rest),
        }
    }
}

/// Several warmths, each with its growth, and a gain that goes with their mean. Shared state: the drive before, the
/// path at rest, the power.
#[derive(Clone)]
pub(crate) struct Warming {
    pub(crate) loss: Loss,
    /// Length of the step in s.
    pub(crate) dt: f64,
}

/// One of several warmths.
#[derive(Clone, Copy)]
pub(crate) struct Warmth {
    /// Time constant in s.
    pub(crate) time: f64,
    /// What the warmth adds to the path.
    pub(crate) growth: f64,
    /// What the warmth adds to the gain.
    pub(crate) gain: f64,
    /// Part of the way to the power in a step.
    pub(crate) fraction: f64,
}

impl Bank<3, 1> for Warming {
    type Element = Warmth;
    /// The power, and the way of the path from rest.
    type Shared = (f64, f64);

    fn set_step(&mut self, dt: f64, elements: &mut [Warmth]) {
        self.dt = dt;
        elements.iter_mut().for_each(|w| w.fraction = approach(w.time, dt));
    }

    fn rest(&self, w: Wires) -> ([f64; 3], [f64; 1]) {
        ([w.drive, w.x, 0.0], [0.0])
    }

    #[inline]
    fn advance(&self, w: Wires, [before, _, power]: &mut [f64; 3]) {
        *power = self.loss.power(w.drive, (w.drive - *before) / self.dt);
        *before = w.drive;
    }

    #[inline]
    fn shared(&self, w: Wires, [_, rest, power]: &[f64; 3]) -> (f64, f64) {
        (*power, w.x - rest)
    }

    #[inline]
    fn add(warmth: &Warmth, (power, way): (f64, f64), [z]: &mut [f64; 1]) -> f64 {
        *z += warmth.fraction * (power - *z);
        *z * (warmth.growth + warmth.gain * way)
    }
}

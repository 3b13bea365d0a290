//! Plays that go with the rate of the drive. Each bank adds `Σ w·(P′[v] − P_r[v])`: what the plays do with the
//! rate less what those inside the original do without it.

use components::hysteresis::play::{Drive, Threshold, play};
use components::linear::approach;
use serde::{Deserialize, Serialize};

use crate::kernel::{Bank, Wires};

/// How thresholds grow with a rate x over that of reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Growth {
    /// `x/(1 + x)`: up to a limit.
    Limited,
    /// `ln(1 + x)`.
    Logarithmic,
}

impl Growth {
    /// The growth at this rate over that of reference.
    #[must_use]
    pub fn at(self, x: f64) -> f64 {
        match self {
            Self::Limited => x / (1.0 + x),
            Self::Logarithmic => libm::log1p(x),
        }
    }
}

/// Moves the changed play and the plain one, and returns what they differ by.
#[inline]
fn two(weight: f64, r: f64, u: f64, [changed, plain]: &mut [f64; 2], wide: f64) -> f64 {
    *changed = play(Drive(u), Threshold(wide), *changed);
    *plain = play(Drive(u), Threshold(r), *plain);
    weight * (*changed - *plain)
}

/// A rate of the drive, smoothed over a time: `ρ ← ρ + (1 − exp(−dt/time))·(v′ − ρ)`. State: the drive before, ρ.
#[derive(Clone)]
pub(crate) struct Smoothed {
    time: f64,
    /// Whether the size of the rate is smoothed, and not the rate with its sign.
    is_size: bool,
    dt: f64,
    fraction: f64,
}

impl Smoothed {
    pub(crate) fn new(time: f64, is_size: bool) -> Self {
        Self { time, is_size, dt: 0.0, fraction: 0.0 }
    }

    fn set_step(&mut self, dt: f64) {
        (self.dt, self.fraction) = (dt, approach(self.time, dt));
    }

    #[inline]
    fn advance(&self, u: f64, [before, rate]: &mut [f64; 2]) {
        let slope = (u - *before) / self.dt;
        let slope = if self.is_size { slope.abs() } else { slope };
        *rate += self.fraction * (slope - *rate);
        *before = u;
    }
}

/// Thresholds `r·(1 + g·f(|ρ|/ρ₀))` with the smoothed rate ρ of the drive.
#[derive(Clone)]
pub(crate) struct GrowingPlays {
    pub(crate) rate: Smoothed,
    /// g.
    pub(crate) growth: f64,
    /// f.
    pub(crate) law: Growth,
    /// ρ₀.
    pub(crate) reference: f64,
}

impl Bank<2, 2> for GrowingPlays {
    type Element = (f64, f64);
    /// The drive, and the factor of the thresholds.
    type Shared = (f64, f64);

    fn set_step(&mut self, dt: f64, _: &mut [(f64, f64)]) {
        self.rate.set_step(dt);
    }

    fn rest(&self, w: Wires) -> ([f64; 2], [f64; 2]) {
        ([w.drive, 0.0], [0.0; 2])
    }

    #[inline]
    fn advance(&self, w: Wires, head: &mut [f64; 2]) {
        self.rate.advance(w.drive, head);
    }

    #[inline]
    fn shared(&self, w: Wires, head: &[f64; 2]) -> (f64, f64) {
        (w.drive, 1.0 + self.growth * self.law.at(head[1].abs() / self.reference))
    }

    #[inline]
    fn add((r, weight): &(f64, f64), (u, factor): (f64, f64), z: &mut [f64; 2]) -> f64 {
        two(*weight, *r, u, z, r * factor)
    }
}

/// `x + T·ρ/half·Σ w·(P_r[v] − v)` with the smoothed size ρ of the rate of the drive v.
#[derive(Clone)]
pub(crate) struct RateMemory {
    pub(crate) rate: Smoothed,
    /// T in s.
    pub(crate) time: f64,
    pub(crate) half: f64,
}

impl Bank<2, 1> for RateMemory {
    type Element = (f64, f64);
    /// The drive, and the factor of the memory.
    type Shared = (f64, f64);

    fn set_step(&mut self, dt: f64, _: &mut [(f64, f64)]) {
        self.rate.set_step(dt);
    }

    fn rest(&self, w: Wires) -> ([f64; 2], [f64; 1]) {
        ([w.drive, 0.0], [0.0])
    }

    #[inline]
    fn advance(&self, w: Wires, head: &mut [f64; 2]) {
        self.rate.advance(w.drive, head);
    }

    #[inline]
    fn shared(&self, w: Wires, head: &[f64; 2]) -> (f64, f64) {
        (w.drive, self.time * head[1] / self.half)
    }

    #[inline]
    fn add((r, weight): &(f64, f64), (u, factor): (f64, f64), [z]: &mut [f64; 1]) -> f64 {
        *z = play(Drive(u), Threshold(*r), *z);
        weight * (*z - u) * factor
    }
}

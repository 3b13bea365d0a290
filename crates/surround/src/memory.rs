//! Plays, and what else remembers the drive whatever its rate.

use components::hysteresis::play::{Drive, Threshold, between, play};

use crate::kernel::{Bank, Step, Wires};
use crate::span::Span;

/// `x + g·v + Σ w·(P_r[v] − v)` of the drive v.
#[derive(Clone)]
pub(crate) struct Plays {
    pub(crate) slope: Option<f64>,
}

impl Bank<0, 1> for Plays {
    type Element = (f64, f64);
    type Shared = f64;

    #[inline]
    fn shared(&self, w: Wires, _: &[f64; 0]) -> f64 {
        w.drive
    }

    #[inline]
    fn direct(&self, w: Wires) -> f64 {
        match self.slope {
            Some(g) => w.x + g * w.drive,
            None => w.x,
        }
    }

    #[inline]
    fn add((r, weight): &(f64, f64), u: f64, [z]: &mut [f64; 1]) -> f64 {
        *z = play(Drive(u), Threshold(*r), *z);
        weight * (*z - u)
    }
}

/// `x + Σ w·(P_r[v] − v)·z` with the place z of the drive v in its range.
#[derive(Clone)]
pub(crate) struct SkewedPlays {
    pub(crate) span: Span,
}

impl Bank<0, 1> for SkewedPlays {
    type Element = (f64, f64);
    /// The drive and its place.
    type Shared = (f64, f64);

    #[inline]
    fn shared(&self, w: Wires, _: &[f64; 0]) -> (f64, f64) {
        (w.drive, self.span.unit(w.drive))
    }

    #[inline]
    fn add((r, weight): &(f64, f64), (u, place): (f64, f64), [z]: &mut [f64; 1]) -> f64 {
        *z = play(Drive(u), Threshold(*r), *z);
        weight * (*z - u) * place
    }
}

/// `Σ w·(P′[v] − P_r[v])` where the threshold of P′ is `r·(1 + curvature·z)`, z the place of v.
#[derive(Clone)]
pub(crate) struct CurvedPlays {
    pub(crate) span: Span,
    pub(crate) curvature: f64,
}

impl Bank<0, 2> for CurvedPlays {
    type Element = (f64, f64);
    /// The drive, and curvature times its place.
    type Shared = (f64, f64);

    #[inline]
    fn shared(&self, w: Wires, _: &[f64; 0]) -> (f64, f64) {
        (w.drive, self.curvature * self.span.unit(w.drive))
    }

    #[inline]
    fn add(
        (r, weight): &(f64, f64),
        (u, bend): (f64, f64),
        [bent, straight]: &mut [f64; 2],
    ) -> f64 {
        // The loop is wider at one end of the range and narrower at the other.
        *bent = play(Drive(u), Threshold((r + r * bend).max(0.0)), *bent);
        *straight = play(Drive(u), Threshold(*r), *straight);
        weight * (*bent - *straight)
    }
}

/// `Σ weight·(P′[v] − P_r[v])` with P′ between the envelopes `v + half·(a·z + b·z² + c·z³ − w) − r` and
/// `v + half·(d·z + e·z² + f·z³ + w) + r`.
#[derive(Clone)]
pub(crate) struct BentPlays {
    pub(crate) span: Span,
    /// a to f, w.
    pub(crate) bends: [f64; 7],
}

impl Bank<0, 2> for BentPlays {
    type Element = (f64, f64);
    /// The drive, and the lower and the upper envelope but for the threshold.
    type Shared = [f64; 3];

    #[inline]
    fn shared(&self, w: Wires, _: &[f64; 0]) -> [f64; 3] {
        let (u, half, [a, b, c, d, e, f, wider]) = (w.drive, self.span.half, self.bends);
        let z = self.span.unit(u);
        let (low, high) = (z * (a + z * (b + z * c)), z * (d + z * (e + z * f)));
        [u, u + half * (low - wider), u + half * (high + wider)]
    }

    #[inline]
    fn add(
        (r, weight): &(f64, f64),
        [u, low, high]: [f64; 3],
        [bent, straight]: &mut [f64; 2],
    ) -> f64 {
        *bent = between(low - r, high + r, *bent);
        *straight = play(Drive(u), Threshold(*r), *straight);
        weight * (*bent - *straight)
    }
}

/// `x + w·(P[v] − v)` of the drive v, P a play of half the width `half·(r₀ + r₁z + r₂z²)`.
#[derive(Clone)]
pub(crate) struct GeneralisedPlay {
    pub(crate) span: Span,
    pub(crate) weight: f64,
    /// r₀, r₁, r₂.
    pub(crate) width: [f64; 3],
}

impl GeneralisedPlay {
    #[inline]
    fn at(&self, w: Wires, z: &mut f64) -> f64 {
        let [constant, linear, square] = self.width;
        let place = self.span.unit(w.drive);
        let width = self.span.half * (constant + place * (linear + place * square)).max(0.0);
        *z = play(Drive(w.drive), Threshold(width), *z);
        w.x + self.weight * (*z - w.drive)
    }
}

impl Step<1> for GeneralisedPlay {
    fn rest(&self, w: Wires) -> ([f64; 1], f64) {
        let mut z = 0.0;
        let y = self.at(w, &mut z);
        ([z], y)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, [z]: &mut [f64; 1]) -> f64 {
        self.at(w, z)
    }
}

/// `x − a·D·h`, `h′ = v′/D·(1 − (β sign(v′h) + 1 − β)·h²)` of the drive v. State: h, and the drive before.
#[derive(Clone)]
pub(crate) struct BoucWen {
    pub(crate) gain: f64,
    pub(crate) width: f64,
    pub(crate) turning: f64,
}

impl Step<2> for BoucWen {
    fn rest(&self, w: Wires) -> ([f64; 2], f64) {
        ([0.0, w.drive], w.x)
    }

    #[inline]
    fn step(&self, w: Wires, _t: f64, [h, before]: &mut [f64; 2]) -> f64 {
        /// Most of the width that is gone through at once.
        const PART: f64 = 0.1;
        let way = (w.drive - *before) / self.width;
        *before = w.drive;
        let parts = (way.abs() / PART).ceil().clamp(1.0, 100.0);
        let d = way / parts;
        for _ in 0..parts as usize {
            *h += d * (1.0 - (self.turning * (d * *h).signum() + 1.0 - self.turning) * *h * *h);
        }
        w.x - self.gain * self.width * *h
    }
}

//! Blocks of plays that go with the rate of the drive. Each adds `Σ w·(P′[v] − P[v])`: what the plays do with the
//! rate less what those inside the original do without it.

use components::hysteresis::rate;
use components::linear::lag_fraction;
use libm::expm1;
use serde::{Deserialize, Serialize};

use crate::block::{Block, Wires};
use crate::memory::play;

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

/// One step of a block of plays that depend on the rate; a `dt` of 0 is rest.
pub(crate) fn step(block: &Block, p: &[f64], w: Wires, dt: f64, z: &mut [f64]) -> f64 {
    let u = w.drive;
    match (block, p) {
        (Block::RatePlays { r, w: weights }, &[time]) => {
            let Some((state, plays)) = z.split_first_chunk_mut::<{ rate::STATES }>() else {
                return w.x;
            };
            if dt > 0.0 {
                rate::update(state, u, 1.0 / dt);
            }
            let grow = time * state[1].abs();
            two(r, weights, plays, w.x, |r, p| play((r + grow).max(0.0), u, p), u)
        }
        (Block::GrowingPlays { r, w: weights, law, scale, smoothing }, &[growth, of_scale, ..]) => {
            let Some((past, plays)) = z.split_first_chunk_mut::<2>() else { return w.x };
            let rate = match (smoothing, p.get(2)) {
                (Some(time), _) => smoothed(past, u, dt, *time, f64::abs),
                (None, Some(time)) => smoothed(past, u, dt, *time, |rate| rate).abs(),
                (None, None) => return w.x,
            };
            let factor = 1.0 + growth * law.at(rate / (of_scale * scale));
            two(r, weights, plays, w.x, |r, p| play(r * factor, u, p), u)
        }
        (Block::LaggedPlays { r, w: weights }, &[bandwidth]) => {
            let Some((late, plays)) = z.split_first_mut() else { return w.x };
            *late += lag_fraction(bandwidth, dt) * (u - *late);
            let late = *late;
            two(r, weights, plays, w.x, |r, p| play(r, late, p), u)
        }
        (Block::RateMemory { r, w: weights, half, smoothing }, &[time]) => {
            let Some((past, plays)) = z.split_first_chunk_mut::<2>() else { return w.x };
            let factor = time * smoothed(past, u, dt, *smoothing, f64::abs) / half;
            let mut y = w.x;
            for ((r, weight), z) in r.iter().zip(weights).zip(plays) {
                *z = play(*r, u, *z);
                y += weight * (*z - u) * factor;
            }
            y
        }
        _ => w.x,
    }
}

/// What is taken of the rate, smoothed over a time, from the value before and what it was.
fn smoothed(past: &mut [f64; 2], u: f64, dt: f64, time: f64, of: impl Fn(f64) -> f64) -> f64 {
    let [before, rate] = past;
    if dt > 0.0 {
        *rate += -expm1(-dt / time) * (of((u - *before) / dt) - *rate);
    }
    *before = u;
    *rate
}

/// Steps two plays for each threshold, one by `other` and one plain, and adds what they differ by.
fn two(
    r: &[f64],
    weights: &[f64],
    z: &mut [f64],
    x: f64,
    other: impl Fn(f64, f64) -> f64,
    u: f64,
) -> f64 {
    let mut y = x;
    for ((r, weight), z) in r.iter().zip(weights).zip(z.chunks_exact_mut(2)) {
        z[0] = other(*r, z[0]);
        z[1] = play(*r, u, z[1]);
        y += weight * (z[0] - z[1]);
    }
    y
}

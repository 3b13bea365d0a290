//! Blocks of plays: hysteresis that is missing, skewed or depends on the rate.

use components::hysteresis::rate;
use components::linear::lag_fraction;
use surround::Growth;

use super::{Span, Wires};

/// Part of the way to the rate of a row by which the smoothed one moves, where thresholds grow up to a limit.
pub(crate) const SATURATING: f64 = 0.3;
/// The same where the loop grows.
pub(crate) const GROWING: f64 = 0.1;

/// Thresholds of plays.
pub(crate) type Bank = Vec<f64>;

/// The memory of the model: thresholds and weights of its plays.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Memory {
    /// Thresholds, above zero.
    pub(crate) r: Vec<f64>,
    /// Weights, of one length with the thresholds.
    pub(crate) w: Vec<f64>,
}

/// One play: `max(u − r, min(u + r, p))`.
#[inline]
fn play(r: f64, u: f64, p: f64) -> f64 {
    (u - r).max((u + r).min(p))
}

/// Adds `weight(n, m)` for the memory part m = P_r\[v\] − v of one play.
fn add_memory(r: f64, v: &[f64], out: &mut [f64], mut weight: impl FnMut(usize, f64) -> f64) {
    let mut state = 0.0;
    for (n, (y, u)) in out.iter_mut().zip(v).enumerate() {
        state = play(r, *u, state);
        *y += weight(n, state - u);
    }
}

pub(super) fn plays(bank: &[f64], gain: bool, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    out.copy_from_slice(w.x);
    let (linear, weights) = if gain { p.split_at(p.len().min(1)) } else { (&p[..0], p) };
    if let &[g] = linear {
        out.iter_mut().zip(w.drive).for_each(|(y, u)| *y += g * u);
    }
    let weighted: Vec<(f64, f64)> = bank.iter().copied().zip(weights.iter().copied()).collect();
    let (fours, others) = weighted.as_chunks::<4>();
    fours.iter().for_each(|four| add_plays(four, w.drive, out));
    others.iter().for_each(|one| add_plays(&[*one], w.drive, out));
}

/// Adds the weighted memory parts of plays, side by side as none waits for another.
fn add_plays<const N: usize>(plays: &[(f64, f64); N], v: &[f64], out: &mut [f64]) {
    let mut states = [0.0; N];
    for (y, u) in out.iter_mut().zip(v) {
        for ((r, weight), state) in plays.iter().zip(&mut states) {
            *state = play(*r, *u, *state);
            *y += weight * (*state - u);
        }
    }
}

pub(super) fn generalised(span: Span, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[weight, constant, linear, square] = p else { return };
    let mut state = 0.0_f64;
    for ((y, x), u) in out.iter_mut().zip(w.x).zip(w.drive) {
        let z = span.unit(*u);
        let width = span.half * (constant + z * (linear + z * square)).max(0.0);
        state = play(width, *u, state);
        *y = x + weight * (state - u);
    }
}

pub(super) fn bouc_wen(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    /// Most of the width that is gone through at once.
    const PART: f64 = 0.1;
    let (&[gain, width, turning], Some(&first)) = (p, w.drive.first()) else { return };
    let (mut h, mut before) = (0.0_f64, first);
    for ((y, x), u) in out.iter_mut().zip(w.x).zip(w.drive) {
        let way = (u - before) / width;
        before = *u;
        let parts = (way.abs() / PART).ceil().clamp(1.0, 100.0);
        let d = way / parts;
        for _ in 0..parts as usize {
            h += d * (1.0 - (turning * (d * h).signum() + 1.0 - turning) * h * h);
        }
        *y = x - gain * width * h;
    }
}

pub(super) fn skewed(bank: &[f64], span: Span, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    out.copy_from_slice(w.x);
    for (r, weight) in bank.iter().zip(p) {
        add_memory(*r, w.drive, out, |n, m| weight * m * span.unit(w.drive[n]));
    }
}

/// Each play gets the envelopes u + c·z² − r and u − c·z² + r (z: place in the range) in the place of
/// u ∓ r; weights are the model's.
pub(super) fn curved(memory: &Memory, span: Span, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[curvature] = p else { return };
    out.copy_from_slice(w.x);
    for (r, weight) in memory.r.iter().zip(&memory.w) {
        let (mut bent, mut straight) = (0.0_f64, 0.0);
        for (y, u) in out.iter_mut().zip(w.drive) {
            let z = span.unit(*u);
            let c = curvature * r * z;
            // The loop is wider at one end of the range and narrower at the other.
            let (low, high) = (u - (r + c).max(0.0), u + (r + c).max(0.0));
            bent = low.max(high.min(bent));
            straight = play(*r, *u, straight);
            *y += weight * (bent - straight);
        }
    }
}

/// Each play gets the envelopes `v + h·(a·z + b·z²) − r` and `v + h·(c·z + d·z²) + r` in the place of v ∓ r;
/// weights are the model's.
pub(super) fn bent(memory: &Memory, span: Span, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[a, b, c, d] = p else { return };
    out.copy_from_slice(w.x);
    for (r, weight) in memory.r.iter().zip(&memory.w) {
        let (mut bent, mut straight) = (0.0_f64, 0.0);
        for (y, u) in out.iter_mut().zip(w.drive) {
            let z = span.unit(*u);
            let low = u + span.half * z * (a + b * z) - r;
            let high = u + span.half * z * (c + d * z) + r;
            bent = low.max(high.min(bent));
            straight = play(*r, *u, straight);
            *y += weight * (bent - straight);
        }
    }
}

/// Thresholds r·(1 + g·f(|ρ|/(k·steepest))), ρ the rate smoothed over a time: g, k, the time.
pub(super) fn growing(
    memory: &Memory,
    (steepest, law): (f64, Growth),
    p: &[f64],
    w: Wires<'_>,
    out: &mut [f64],
) {
    let &[growth, of_steepest, time] = p else { return };
    let fraction = -(-w.step / time).exp_m1();
    let mut before = w.drive.first().copied().unwrap_or(0.0);
    let mut rate = 0.0;
    let factors: Vec<f64> = w
        .drive
        .iter()
        .map(|u| {
            rate += fraction * ((u - before) / w.step - rate);
            before = *u;
            1.0 + growth * law.at(rate.abs() / (of_steepest * steepest))
        })
        .collect();
    out.copy_from_slice(w.x);
    for (r, weight) in memory.r.iter().zip(&memory.w) {
        let (mut wide, mut same) = (0.0, 0.0);
        for ((y, u), factor) in out.iter_mut().zip(w.drive).zip(&factors) {
            wide = play(r * factor, *u, wide);
            same = play(*r, *u, same);
            *y += weight * (wide - same);
        }
    }
}

pub(super) fn rate_plays(memory: &Memory, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[time] = p else { return };
    out.copy_from_slice(w.x);
    for (r, weight) in memory.r.iter().zip(&memory.w) {
        let (mut wide, mut same) = (0.0, 0.0);
        // As the component takes it.
        let mut memory = rate::rest(w.drive.first().copied().unwrap_or(0.0));
        for (y, u) in out.iter_mut().zip(w.drive) {
            rate::update(&mut memory, *u, 1.0 / w.step);
            wide = play((r + time * memory[1].abs()).max(0.0), *u, wide);
            same = play(*r, *u, same);
            *y += weight * (wide - same);
        }
    }
}

pub(super) fn saturating_plays(
    memory: &Memory,
    steepest: f64,
    p: &[f64],
    w: Wires<'_>,
    out: &mut [f64],
) {
    let &[growth, half_rate] = p else { return };
    out.copy_from_slice(w.x);
    let half_rate = half_rate * steepest;
    for (r, weight) in memory.r.iter().zip(&memory.w) {
        let (mut wide, mut same) = (0.0, 0.0);
        let mut before = w.drive.first().copied().unwrap_or(0.0);
        let mut rate = 0.0;
        for (y, u) in out.iter_mut().zip(w.drive) {
            rate += SATURATING * ((u - before).abs() / w.step - rate);
            before = *u;
            let factor = 1.0 + growth * rate / (half_rate + rate);
            wide = play(r * factor, *u, wide);
            same = play(*r, *u, same);
            *y += weight * (wide - same);
        }
    }
}

pub(super) fn lagged_plays(memory: &Memory, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[bandwidth] = p else { return };
    out.copy_from_slice(w.x);
    let fraction = lag_fraction(bandwidth, w.step);
    for (r, weight) in memory.r.iter().zip(&memory.w) {
        let (mut late, mut prompt) = (0.0, 0.0);
        let mut z = w.drive.first().copied().unwrap_or(0.0);
        for (y, u) in out.iter_mut().zip(w.drive) {
            z += fraction * (u - z);
            late = play(*r, z, late);
            prompt = play(*r, *u, prompt);
            *y += weight * (late - prompt);
        }
    }
}

pub(super) fn rate_memory(memory: &Memory, half: f64, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[time] = p else { return };
    out.copy_from_slice(w.x);
    for (r, weight) in memory.r.iter().zip(&memory.w) {
        let mut before = w.drive.first().copied().unwrap_or(0.0);
        let mut smooth = 0.0;
        add_memory(*r, w.drive, out, |n, m| {
            let u = w.drive[n];
            smooth += GROWING * ((u - before).abs() / w.step - smooth);
            before = u;
            weight * m * time * smooth / half
        });
    }
}

pub(super) fn start_memory(memory: &Memory, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let (&[place], Some(&first)) = (p, w.drive.first()) else { return };
    out.copy_from_slice(w.x);
    for (r, weight) in memory.r.iter().zip(&memory.w) {
        let mut told = play(*r, first, 0.0);
        let mut real = first + place * r;
        for (y, u) in out.iter_mut().zip(w.drive) {
            told = play(*r, *u, told);
            real = play(*r, *u, real);
            *y += weight * (real - told);
            if told == real {
                break;
            }
        }
    }
}

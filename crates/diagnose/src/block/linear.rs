//! Linear blocks: lags, modes, creep, feed-through.

use components::linear::{Transition, lag_fraction};

use super::{Block, Wires};

/// The first-order lag of a signal, at rest at its first value.
fn lag_in_place(signal: &mut [f64], fraction: f64) {
    let Some(&first) = signal.first() else { return };
    let mut z = first;
    for y in signal {
        z += fraction * (*y - z);
        *y = z;
    }
}

pub(super) fn lags(order: usize, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[bandwidth] = p else { return };
    out.copy_from_slice(w.x);
    for _ in 0..order {
        lag_in_place(out, lag_fraction(bandwidth, w.step));
    }
}

/// Calls `each` with place and value of a unit-gain mode driven by `x` from rest.
fn mode(frequency: f64, damping: f64, x: &[f64], step: f64, mut each: impl FnMut(usize, f64)) {
    let Some(&first) = x.first() else { return };
    let transition = Transition::new(frequency, damping, step);
    let (mut position, mut rate) = (first, 0.0);
    each(0, position);
    for (n, u) in x.iter().enumerate().skip(1) {
        let (e, r) = transition.apply(position - u, rate);
        (position, rate) = (u + e, r);
        each(n, position);
    }
}

pub(super) fn second_order(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[frequency, damping] = p else { return };
    mode(frequency, damping, w.x, w.step, |n, value| out[n] = value);
}

pub(super) fn parallel_mode(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[gain, frequency, damping] = p else { return };
    mode(frequency, damping, w.x, w.step, |n, value| out[n] = w.x[n] + gain * (value - w.x[n]));
}

/// From rest: x_n = u_n + same·(x_(n−1) − u_n) + cross·rate, solved for u_n.
pub(super) fn before_mode((frequency, damping): (f64, f64), w: Wires<'_>, out: &mut [f64]) {
    let Some(&first) = w.x.first() else { return };
    let transition = Transition::new(frequency, damping, w.step);
    let (mut position, mut rate) = (first, 0.0);
    out[0] = first;
    for (u, x) in out.iter_mut().zip(w.x).skip(1) {
        *u = (x - transition.same * position - transition.cross * rate) / (1.0 - transition.same);
        (_, rate) = transition.apply(position - *u, rate);
        position = *x;
    }
}

/// `(s² + 2ζ_z ω_z s + ω_z²)/(s² + 2ζ_p ω_p s + ω_p²) · ω_p²/ω_z²`: with the unit-gain mode M of the
/// poles it is `x + (1 − ω_p²/ω_z²)·(…)`, written with M and its rate.
pub(super) fn pole_zero(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[pole, pole_damping, ratio, zero_damping] = p else { return };
    let Some(&first) = w.x.first() else { return };
    // G = k²·(x-part) with k = ω_p/ω_z: G = k² + (1 − k²)·M + 2k(ζ_z − k ζ_p)·M′/ω_p.
    let k = 1.0 / ratio;
    let direct = k * k;
    let rate_part = 2.0 * k * (zero_damping - k * pole_damping);
    let transition = Transition::new(pole, pole_damping, w.step);
    let (mut position, mut rate) = (first, 0.0);
    for (n, (y, u)) in out.iter_mut().zip(w.x).enumerate() {
        if n > 0 {
            let (e, r) = transition.apply(position - u, rate);
            (position, rate) = (u + e, r);
        }
        *y = direct * u + (1.0 - direct) * position + rate_part * rate;
    }
}

/// Adds `share·lag(x)` to `out` for each share and time, side by side as none waits for another.
fn add_elements<const N: usize>(elements: &[(f64, f64); N], w: Wires<'_>, out: &mut [f64]) {
    let Some(&first) = w.x.first() else { return };
    let fractions = elements.map(|(_, time)| -(-w.step / time).exp_m1());
    let mut states = [first; N];
    for (y, x) in out.iter_mut().zip(w.x) {
        for (((share, _), fraction), z) in elements.iter().zip(&fractions).zip(&mut states) {
            *z += fraction * (x - *z);
            *y += share * *z;
        }
    }
}

/// Elements of a logarithmic grid, two per decade.
fn grid(shortest: f64, longest: f64) -> impl Iterator<Item = f64> {
    let decades = (longest / shortest).log10().max(0.5);
    let count = (2.0 * decades).round().max(1.0);
    (0..count as usize).map(move |i| shortest * 10f64.powf(decades * (i as f64 + 0.5) / count))
}

/// Share and time constant of each element of a creep block.
pub(super) fn elements(block: &Block, p: &[f64]) -> Option<Vec<(f64, f64)>> {
    match (block, p) {
        (Block::LogCreep { longest }, &[gain, shortest]) => Some(
            grid(shortest, longest.max(3.0 * shortest)).map(|time| (0.5 * gain, time)).collect(),
        ),
        (Block::PowerCreep { shortest, longest }, &[gain, exponent]) => {
            let middle = (shortest * longest).sqrt();
            let share = |time: f64| 0.5 * gain * (time / middle).powf(exponent);
            Some(grid(*shortest, *longest).map(|time| (share(time), time)).collect())
        }
        (Block::FixedCreep(times), p) => {
            Some(times.iter().zip(p).map(|(time, share)| (*share, *time)).collect())
        }
        (Block::FreeCreep(count), p) => {
            Some(p.chunks_exact(2).take(*count).map(|pair| (pair[0], pair[1])).collect())
        }
        _ => None,
    }
}

pub(super) fn creep(block: &Block, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    out.copy_from_slice(w.x);
    let all = elements(block, p).unwrap_or_default();
    let (fours, others) = all.as_chunks::<4>();
    fours.iter().for_each(|four| add_elements(four, w, out));
    others.iter().for_each(|one| add_elements(&[*one], w, out));
}

/// `x + a·s + b·s′` with a signal s in steps.
fn add_signal(a: f64, b: f64, s: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let mut before = s.first().copied().unwrap_or(0.0);
    for ((y, x), s) in out.iter_mut().zip(w.x).zip(s) {
        *y = x + a * s + b * (s - before) / w.step;
        before = *s;
    }
}

pub(super) fn aux(scale: f64, rate: bool, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let (Some(a), b) = (p.first(), p.get(1)) else { return };
    let b = if rate { b.copied().unwrap_or(0.0) } else { 0.0 };
    // The rate's weight is that of a lead of one millisecond.
    add_signal(a / scale, 1e-3 * b / scale, w.aux, w, out);
}

pub(super) fn droop(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let (&[corner, part], Some(&first)) = (p, w.x.first()) else { return };
    let fraction = -(-core::f64::consts::TAU * corner * w.step).exp_m1();
    let mut gone = part * first;
    for (y, x) in out.iter_mut().zip(w.x) {
        *y = x - gone;
        gone += fraction * (x - gone);
    }
}

pub(super) fn lagged_aux(scale: f64, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[a, bandwidth] = p else { return };
    out.copy_from_slice(w.x);
    let element = (a / scale, 1.0 / (core::f64::consts::TAU * bandwidth));
    add_elements(&[element], Wires { x: w.aux, ..w }, out);
}

pub(super) fn modal_aux(scale: f64, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[a, frequency, damping] = p else { return };
    mode(frequency, damping, w.aux, w.step, |n, value| out[n] = w.x[n] + a / scale * value);
}

pub(super) fn feed_through(
    scale: f64,
    time: f64,
    p: &[f64],
    signal: &[f64],
    w: Wires<'_>,
    out: &mut [f64],
) {
    let &[value, rate] = p else { return };
    add_signal(value / scale, rate * time / scale, signal, w, out);
}

//! Blocks in front of the amplifier, and of the clock.

use super::{Span, Wires};

/// The signal at a place between its values, held at its ends.
fn at(x: &[f64], place: f64) -> f64 {
    let (Some(&first), Some(&last)) = (x.first(), x.last()) else { return 0.0 };
    if place.is_nan() || place <= 0.0 {
        return first;
    }
    let whole = place.floor();
    let k = whole as usize;
    match (x.get(k), x.get(k + 1)) {
        (Some(a), Some(b)) => a + (place - whole) * (b - a),
        _ => last,
    }
}

pub(super) fn delay(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[delay] = p else { return };
    let hits = delay / w.step;
    for (n, y) in out.iter_mut().enumerate() {
        *y = at(w.x, n as f64 - hits);
    }
}

/// A smooth signal at a place between its values, held at its ends: Lagrange's polynomial through the six
/// nearest. A sine of eight rows per period is met within 1e-3, where a straight line loses 8 % of it.
fn between(x: &[f64], place: f64) -> f64 {
    /// Places of the values about the one before.
    const NODES: [f64; 6] = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
    /// Products of a node's distances from the others.
    const PRODUCTS: [f64; 6] = [-120.0, 24.0, -12.0, 12.0, -24.0, 120.0];
    let whole = place.floor();
    let rest = place - whole;
    let k = whole as usize;
    match x.get(k.wrapping_sub(2)..k.saturating_add(4)) {
        Some(near) if rest > 0.0 => {
            let distances = NODES.map(|node| rest - node);
            let weight = |i: usize| {
                let others = (0..6).filter(|j| *j != i).map(|j| distances[j]);
                others.product::<f64>() / PRODUCTS[i]
            };
            near.iter().enumerate().map(|(i, value)| weight(i) * value).sum()
        }
        _ => at(x, place),
    }
}

pub(super) fn clock(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[offset] = p else { return };
    for (n, y) in out.iter_mut().enumerate() {
        *y = between(w.x, n as f64 * (1.0 - offset));
    }
}

pub(super) fn quantise(span: Span, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[steps, phase] = p else { return };
    let q = 2.0 * span.half / steps;
    for (y, x) in out.iter_mut().zip(w.x) {
        *y = q * ((x / q - phase).round() + phase);
    }
}

pub(super) fn quantise_with_gaps(
    span: Span,
    (every, missing): (u32, u32),
    p: &[f64],
    w: Wires<'_>,
    out: &mut [f64],
) {
    let &[steps, phase] = p else { return };
    let q = 2.0 * span.half / steps;
    for (y, x) in out.iter_mut().zip(w.x) {
        *y = q * (crate::converter::code(x / q - phase, every, missing) + 0.5 + phase);
    }
}

pub(super) fn slew(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let (&[rate], Some(&first)) = (p, w.x.first()) else { return };
    let most = rate * w.step;
    let mut v = first;
    for (y, x) in out.iter_mut().zip(w.x) {
        v += (x - v).clamp(-most, most);
        *y = v;
    }
}

pub(super) fn uneven_slew(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let (&[rate, ratio], Some(&first)) = (p, w.x.first()) else { return };
    let (up, down) = (rate * w.step, ratio * rate * w.step);
    let mut v = first;
    for (y, x) in out.iter_mut().zip(w.x) {
        v += (x - v).clamp(-down, up);
        *y = v;
    }
}

pub(super) fn soft_slew(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let (&[rate, bandwidth], Some(&first)) = (p, w.x.first()) else { return };
    let most = rate * w.step;
    let fraction = components::linear::lag_fraction(bandwidth, w.step);
    let mut v = first;
    for (y, x) in out.iter_mut().zip(w.x) {
        // z/√(1 + z²): straight at small slopes, never above the limit.
        let z = fraction * (x - v) / most;
        v += most * z / (1.0 + z * z).sqrt();
        *y = v;
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn a_clock_that_is_off_reads_a_smooth_signal_where_it_is() {
        let (step, offset) = (2.5e-4, 7e-5);
        let signal = |t: f64| (TAU * 500.0 * t).sin() + 0.3 * (TAU * 20.0 * t).cos();
        let x: Vec<f64> = (0..20_000).map(|n| signal(f64::from(n) * step)).collect();
        let mut out = vec![0.0; x.len()];
        clock(&[offset], Wires { x: &x, drive: &x, command: &x, aux: &x, step }, &mut out);
        for n in 10..19_990 {
            let expected = signal(f64::from(n) * step * (1.0 - offset));
            let found = out[n as usize];
            assert!((found - expected).abs() < 1.2e-3, "{n}: {found} {expected}");
        }
        clock(&[0.0], Wires { x: &x, drive: &x, command: &x, aux: &x, step }, &mut out);
        assert_eq!(out, x);
    }

    #[test]
    fn a_polynomial_of_the_fifth_order_is_met_between_its_values() {
        let f = |t: f64| 1.0 + t * (0.5 - t * (0.2 - t * (0.03 + t * (0.01 - 0.002 * t))));
        let x: Vec<f64> = (0..12).map(|k| f(f64::from(k) - 5.0)).collect();
        for place in [2.0, 2.25, 5.5, 7.9, 8.0] {
            assert!((between(&x, place) - f(place - 5.0)).abs() < 1e-12, "{place}");
        }
        // Held at the ends.
        assert_eq!([between(&x, -3.0), between(&x, 40.0)], [x[0], x[11]]);
    }
}

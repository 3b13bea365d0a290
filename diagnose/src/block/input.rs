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

pub(super) fn clock(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[offset] = p else { return };
    for (n, y) in out.iter_mut().enumerate() {
        *y = at(w.x, n as f64 * (1.0 - offset));
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

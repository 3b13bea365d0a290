//! Blocks of the mechanics and of heat.

use super::{Loss, Span, Wires};

/// The warmth T of `τ T′ = P/mean − T` with the power P of the losses grows from 0; it adds to the path
/// in a range, or multiplies it.
pub(super) fn heating(span: Option<Span>, loss: Loss, p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let (&[growth, time], Some(&rest)) = (p, w.x.first()) else { return };
    let fraction = -(-w.step / time).exp_m1();
    let mut before = w.drive.first().copied().unwrap_or(0.0);
    let mut warmth = 0.0;
    for ((y, x), u) in out.iter_mut().zip(w.x).zip(w.drive) {
        let rate = (u - before) / w.step;
        before = *u;
        let power = match loss {
            Loss::Rate(mean) => rate * rate / mean,
            Loss::Loops(mean, span) => (rate * (u - span.centre)).abs() / mean,
        };
        warmth += fraction * (power - warmth);
        *y = match span {
            Some(span) => x + growth * span.half * warmth,
            None => x + growth * warmth * (x - rest),
        };
    }
}

pub(super) fn backlash(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let (&[half], Some(&first)) = (p, w.x.first()) else { return };
    let mut state = first;
    for (y, x) in out.iter_mut().zip(w.x) {
        state = (x - half).max((x + half).min(state));
        *y = state;
    }
}

pub(super) fn dahl(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let (&[size, distance], Some(&first)) = (p, w.x.first()) else { return };
    let (mut z, mut before) = (0.0_f64, first);
    for (y, x) in out.iter_mut().zip(w.x) {
        let way = (x - before) / distance;
        before = *x;
        // z′ = v/d·(1 − z·sign v), exactly over a step of constant direction.
        let decay = (-way.abs()).exp();
        z = way.signum() * (1.0 - decay) + z * decay;
        *y = x - size * z;
    }
}

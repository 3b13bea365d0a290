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
        let power = loss.power(*u, (u - before) / w.step);
        before = *u;
        warmth += fraction * (power - warmth);
        *y = match span {
            Some(span) => x + growth * span.half * warmth,
            None => x + growth * warmth * (x - rest),
        };
    }
}

impl Loss {
    /// The power at a drive with this rate, over its mean.
    fn power(self, u: f64, rate: f64) -> f64 {
        match self {
            Self::Rate(mean) => rate * rate / mean,
            Self::Apparent(mean) => (rate * u).abs() / mean,
            Self::Loops(mean, span) => (rate * (u - span.centre)).abs() / mean,
        }
    }
}

/// Several warmths, each with its growth; the last parameter is a gain that goes with their mean.
pub(super) fn warming(
    span: Span,
    loss: Loss,
    times: &[f64],
    p: &[f64],
    w: Wires<'_>,
    out: &mut [f64],
) {
    let (Some((gain, growths)), Some(&rest)) = (p.split_last(), w.x.first()) else { return };
    let fractions: Vec<f64> = times.iter().map(|t| -(-w.step / t).exp_m1()).collect();
    let mut warmth = vec![0.0; times.len()];
    let mut before = w.drive.first().copied().unwrap_or(0.0);
    for ((y, x), u) in out.iter_mut().zip(w.x).zip(w.drive) {
        let power = loss.power(*u, (u - before) / w.step);
        before = *u;
        let (mut grown, mut mean) = (0.0, 0.0);
        for ((z, fraction), growth) in warmth.iter_mut().zip(&fractions).zip(growths) {
            *z += fraction * (power - *z);
            grown += growth * *z;
            mean += *z / times.len() as f64;
        }
        *y = x + span.half * grown + gain * mean * (x - rest);
    }
}

pub(super) fn ageing(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let &[gain, growth] = p else { return };
    for (n, (y, x)) in out.iter_mut().zip(w.x).enumerate() {
        let decades = (1.0 + n as f64 * w.step / 0.1).log10();
        *y = x + (gain + growth * decades) * x;
    }
}

pub(super) fn backlash(p: &[f64], w: Wires<'_>, out: &mut [f64]) {
    let (Some((&half, bridge)), Some(&first)) = (p.split_first(), w.x.first()) else { return };
    let bridge = bridge.first().copied().unwrap_or(0.0);
    let mut state = first;
    for (y, x) in out.iter_mut().zip(w.x) {
        state = (x - half).max((x + half).min(state));
        *y = state + bridge * (x - state);
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

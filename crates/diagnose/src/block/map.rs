//! Static maps: value by value.

use super::{Block, Span};

/// `ln(1 + exp(z))` without overflow.
fn soft_plus(z: f64) -> f64 {
    z.max(0.0) + (-z.abs()).exp().ln_1p()
}

fn sigmoid(span: Span, size: f64, shift: f64, x: f64) -> f64 {
    // x less the part that an S-curve with the same slope in the middle lacks.
    let z = span.unit(x) - shift;
    x - size * span.half * (z - z.tanh()) / (1.0 - 1f64.tanh())
}

/// What the map makes of a value; `rest` is the signal's first value.
pub(super) fn value(block: &Block, p: &[f64], x: f64, rest: f64) -> f64 {
    match (block, p) {
        (Block::ClampHigh, &[limit]) => x.min(limit),
        (Block::ClampLow, &[limit]) => x.max(limit),
        (Block::ClampBoth(s), &[half]) => s.centre + (x - s.centre).clamp(-half, half),
        (Block::SoftHigh, &[limit, width]) => x - width * soft_plus((x - limit) / width),
        (Block::Tanh(s), &[size]) => {
            let a = size * s.half;
            s.centre + a * ((x - s.centre) / a).tanh()
        }
        (Block::Sigmoid(s), &[size, shift]) => sigmoid(*s, size, shift, x),
        (Block::Gain, &[gain]) => x + gain * (x - rest),
        (Block::DeadZones(s), &[high, low]) => {
            let z = s.unit(x);
            x + s.half * (high * (z - 0.3).max(0.0) - low * (-0.3 - z).max(0.0))
        }
        (Block::Polynomial { span, order: _ }, coefficients) => {
            let z = span.unit(x);
            let sum = coefficients.iter().rev().fold(0.0, |sum, c| c + sum * z);
            x + span.half * sum * z * z
        }
        (Block::Sine(s), &[size, cycles, phase]) => {
            let at = |z: f64| (core::f64::consts::PI * cycles * z + phase).sin();
            // Less the chord over the range: a line is a gain, and no nonlinearity.
            let (z, slope) = (s.unit(x), 0.5 * (at(1.0) - at(-1.0)));
            x + size * s.half * (at(z) - slope * z)
        }
        _ => x,
    }
}

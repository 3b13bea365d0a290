//! Maps without memory: value by value.

use libm::{exp, log1p, sin, tanh};

use crate::block::Block;

/// What a map without memory makes of a value.
pub(crate) fn value(block: &Block, p: &[f64], x: f64) -> f64 {
    match (block, p) {
        (Block::Rounding { half }, &[steps, phase]) => {
            let q = 2.0 * half / steps;
            q * ((x / q - phase).round() + phase)
        }
        (Block::MissingCodes { half, every, missing }, &[steps, phase]) => {
            let q = 2.0 * half / steps;
            let code = (x / q - phase).floor();
            let is_missing = code.rem_euclid(f64::from(*every)) == f64::from(*missing);
            q * (if is_missing { code - 1.0 } else { code } + 0.5 + phase)
        }
        (Block::LimitAbove, &[limit]) => x.min(limit),
        (Block::LimitBelow, &[limit]) => x.max(limit),
        (Block::Limits { centre }, &[half]) => centre + (x - centre).clamp(-half, half),
        (Block::SoftLimitAbove, &[limit, width]) => {
            let z = (x - limit) / width;
            x - width * (z.max(0.0) + log1p(exp(-z.abs())))
        }
        (Block::Tanh { centre, half }, &[size]) => {
            let a = size * half;
            centre + a * tanh((x - centre) / a)
        }
        (Block::SCurve { centre, half }, &[size, shift]) => {
            let z = (x - centre) / half - shift;
            x - size * half * (z - tanh(z)) / (1.0 - tanh(1.0))
        }
        (Block::DeadZones { centre, half }, &[high, low]) => {
            let z = (x - centre) / half;
            x + half * (high * (z - 0.3).max(0.0) - low * (-0.3 - z).max(0.0))
        }
        (Block::Polynomial { centre, half }, coefficients) => {
            let z = (x - centre) / half;
            let sum = coefficients.iter().rev().fold(0.0, |sum, c| c + sum * z);
            x + half * sum * z * z
        }
        (Block::Sine { centre, half }, &[size, cycles, phase]) => {
            let at = |z: f64| sin(std::f64::consts::PI * cycles * z + phase);
            // Less the chord over the range: a line is a gain, and no nonlinearity.
            let (z, slope) = ((x - centre) / half, 0.5 * (at(1.0) - at(-1.0)));
            x + size * half * (at(z) - slope * z)
        }
        _ => x,
    }
}

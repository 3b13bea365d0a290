//! Maps without memory: value by value.

use std::f64::consts::PI;

use libm::{exp, log1p, sin, tanh};

use crate::kernel::{Kernel, Map};
use crate::span::Span;

fn kernel(map: impl Fn(f64) -> f64 + Clone + Send + Sync + 'static) -> Kernel {
    Kernel::new(Map(map), 0.0)
}

/// The code below x (in steps), or the one before where it is one of those that are missing.
#[must_use]
pub fn code(x: f64, every: u32, missing: u32) -> f64 {
    let code = x.floor();
    // A remainder of whole numbers takes a tenth of the time of one of floating-point numbers.
    let is_missing = (code as i64).rem_euclid(i64::from(every)) == i64::from(missing);
    if is_missing { code - 1.0 } else { code }
}

pub(crate) fn missing_codes(
    half: f64,
    every: u32,
    missing: u32,
    [steps, phase]: [f64; 2],
) -> Kernel {
    let q = 2.0 * half / steps;
    kernel(move |x| q * (code(x / q - phase, every, missing) + 0.5 + phase))
}

/// `x − width·ln(1 + exp((x − limit)/width))`, without overflow.
pub(crate) fn soft_limit_above(limit: f64, width: f64) -> Kernel {
    kernel(move |x| {
        let z = (x - limit) / width;
        x - width * (z.max(0.0) + log1p(exp(-z.abs())))
    })
}

/// Straight below a knee, above it `knee + width·tanh((x − knee)/width)`.
pub(crate) fn knee_above(knee: f64, width: f64) -> Kernel {
    kernel(move |x| if x > knee { knee + width * tanh((x - knee) / width) } else { x })
}

pub(crate) fn hyperbolic_tangent(span: Span, size: f64) -> Kernel {
    let (centre, a) = (span.centre, size * span.half);
    kernel(move |x| centre + a * tanh((x - centre) / a))
}

/// x less the part that an S-curve with the same slope in the middle lacks.
pub(crate) fn s_curve(span: Span, size: f64, shift: f64) -> Kernel {
    let (size, unit) = (size * span.half, 1.0 - tanh(1.0));
    kernel(move |x| {
        let z = span.unit(x) - shift;
        x - size * (z - tanh(z)) / unit
    })
}

pub(crate) fn dead_zones(span: Span, high: f64, low: f64) -> Kernel {
    /// Where the zones end, in the half range.
    const EDGE: f64 = 0.3;
    kernel(move |x| {
        let z = span.unit(x);
        x + span.half * (high * (z - EDGE).max(0.0) - low * (-EDGE - z).max(0.0))
    })
}

pub(crate) fn polynomial(span: Span, coefficients: Vec<f64>) -> Kernel {
    kernel(move |x| {
        let z = span.unit(x);
        let sum = coefficients.iter().rev().fold(0.0, |sum, c| c + sum * z);
        x + span.half * sum * z * z
    })
}

pub(crate) fn sine(span: Span, [size, cycles, phase]: [f64; 3]) -> Kernel {
    let at = move |z: f64| sin(PI * cycles * z + phase);
    // Less the chord over the range: a line is a gain, and no nonlinearity.
    let (size, slope) = (size * span.half, 0.5 * (at(1.0) - at(-1.0)));
    kernel(move |x| {
        let z = span.unit(x);
        x + size * (at(z) - slope * z)
    })
}

//! Bringing an effect to size.

use crate::effect::Effect;

/// Relative error of a size that is good enough.
const CLOSE: f64 = 0.03;
/// Relative error of a size that is taken where an effect comes in jumps.
const NEAR: f64 = 0.2;
/// Evaluations.
const MOST: usize = 40;

/// An effect cannot have the size that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Unreachable {
    /// Which.
    pub effect: Effect,
    /// What was asked for, over the noise.
    pub size: f64,
    /// The nearest that was found.
    pub nearest: f64,
}

impl std::fmt::Display for Unreachable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}: size {} over the noise cannot be had on this machine, the nearest is {:.2}; \
             draw another machine",
            self.effect.name(),
            self.size,
            self.nearest
        )
    }
}

impl std::error::Error for Unreachable {}

/// The magnitude at which `size_of` is `size`, and the size there: secants on logarithms within a
/// bracket.
///
/// # Errors
/// The size is beyond the effect's reach, or jumps over it.
pub fn magnitude(
    effect: Effect,
    size: f64,
    size_of: impl Fn(f64) -> f64,
) -> Result<(f64, f64), Unreachable> {
    let (lowest, highest) = effect.reach();
    let (mut low, mut high) = (lowest, highest);
    let mut best: Option<(f64, f64)> = None;
    let mut m = (lowest * highest).sqrt();
    for _ in 0..MOST {
        let found = size_of(m);
        let is_over = !found.is_finite() || found > size;
        let error = |s: f64| (s / size).ln().abs();
        if found.is_finite() && found > 0.0 && best.is_none_or(|(_, b)| error(found) < error(b)) {
            best = Some((m, found));
        }
        if found.is_finite() && (found / size - 1.0).abs() < CLOSE {
            break;
        }
        if is_over {
            high = m
        } else {
            low = m
        }
        if high / low < 1.0 + 1e-9 || (!is_over && m >= highest * (1.0 - 1e-9)) {
            break;
        }
        // Sizes grow about in proportion; where that leaves the bracket, halve it.
        let guess = m * (size / found.max(1e-3 * size)).clamp(1e-3, 1e3);
        let is_inside = guess.is_finite() && guess > low * 1.000_001 && guess < high * 0.999_999;
        m = if is_inside {
            guess
        } else if high >= highest && !is_over {
            highest
        } else {
            (low * high).sqrt()
        };
    }
    match best {
        Some((m, s)) if (s / size - 1.0).abs() < NEAR => Ok((m, s)),
        other => {
            Err(Unreachable { effect, size, nearest: other.map_or(0.0, |(_, nearest)| nearest) })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_sizes_of_straight_bent_and_kinked_effects() {
        let cases: [fn(f64) -> f64; 4] =
            [|m| 50.0 * m, |m| 1e3 * m * m, |m| 900.0 * (m - 0.01).max(0.0), |m| 30.0 * m.tanh()];
        for (index, size_of) in cases.into_iter().enumerate() {
            let (m, size) = magnitude(Effect::ResonanceShift, 6.0, size_of).unwrap();
            assert!((size_of(m) / 6.0 - 1.0).abs() < 0.03, "{index}: {m}");
            assert_eq!(size, size_of(m));
        }
    }

    #[test]
    fn names_what_is_out_of_reach() {
        let error = magnitude(Effect::ResonanceShift, 6.0, |m| m).unwrap_err();
        assert!((error.nearest - 0.9).abs() < 1e-9, "{error}");
        let jump = |m: f64| if m < 0.1 { 1.0 } else { 40.0 };
        assert!(magnitude(Effect::ResonanceShift, 6.0, jump).is_err());
        let blows_up = |m: f64| if m > 0.3 { f64::NAN } else { 100.0 * m };
        assert!(magnitude(Effect::ResonanceShift, 6.0, blows_up).is_ok());
    }
}

//! Shapes that several signals share.

use std::f64::consts::PI;

use crate::parameter::DURATION;
use crate::signal_type::Settings;

/// Number of instants n·T in [0, `seconds`), where a length within 1e-9·T of a whole number of
/// sample times counts as that number.
pub(crate) fn instants(settings: &Settings, seconds: f64) -> f64 {
    libm::ceil(seconds / settings.sample_time() - 1e-9)
}

/// Number of samples of a record with a free duration.
pub(crate) fn over_duration(settings: &Settings) -> f64 {
    instants(settings, settings.get(&DURATION))
}

/// sin 2πx, exact in its period: whole turns are taken off before the multiplication by 2π.
pub(crate) fn sin_turns(x: f64) -> f64 {
    libm::sin(2.0 * PI * (x - libm::round(x)))
}

/// cos 2πx, exact in its period.
pub(crate) fn cos_turns(x: f64) -> f64 {
    libm::cos(2.0 * PI * (x - libm::round(x)))
}

/// A wave from `low` (at 0 turns, with zero slope) to `high` (at half a turn) and back.
pub(crate) fn rising_cosine(low: f64, high: f64, turns: f64) -> f64 {
    between(low, high, 0.5 - 0.5 * cos_turns(turns))
}

/// 0 up to x = 0, 1 from x = 1, and a half cosine wave between.
pub(crate) fn smooth_step(x: f64) -> f64 {
    0.5 - 0.5 * libm::cos(PI * x.clamp(0.0, 1.0))
}

/// Triangle wave: 0 at 0 turns, 1 at half a turn.
pub(crate) fn triangle_turns(turns: f64) -> f64 {
    2.0 * (turns - libm::round(turns)).abs()
}

/// Exactly `low` at 0 and `high` at 1, linear between and never outside by rounding.
pub(crate) fn between(low: f64, high: f64, part: f64) -> f64 {
    if part == 1.0 {
        return high;
    }
    (low + (high - low) * part).clamp(low.min(high), low.max(high))
}

/// Straight legs through `corners`, leg i of `ticks(i)` samples; every corner is hit exactly, and
/// the last sample is the last corner.
pub(crate) fn legs(corners: &[f64], ticks: impl Fn(usize) -> usize) -> Vec<f64> {
    let mut values: Vec<f64> = corners.first().copied().into_iter().collect();
    for (leg, ends) in corners.windows(2).enumerate() {
        if let &[from, to] = ends {
            let count = ticks(leg);
            values.extend((1..=count).map(|n| between(from, to, n as f64 / count as f64)));
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_hit_their_ends_after_many_turns() {
        for turns in [0.0, 1.0, 1e6, 1e9] {
            assert_eq!(rising_cosine(2.0, 7.0, turns), 2.0);
            assert_eq!(rising_cosine(2.0, 7.0, turns + 0.5), 7.0);
            assert_eq!(triangle_turns(turns), 0.0);
            assert_eq!(triangle_turns(turns + 0.5), 1.0);
            assert_eq!(triangle_turns(turns + 0.25), 0.5);
            assert_eq!(sin_turns(turns + 0.25), 1.0);
        }
    }

    #[test]
    fn ends_are_exact_where_sums_are_rounded() {
        for (low, high) in [(0.1, 0.3), (-0.1, 0.2), (1e-17, 1.0), (3.0, -1.1), (1e16, 1.0)] {
            assert_eq!((between(low, high, 0.0), between(low, high, 1.0)), (low, high));
        }
    }

    #[test]
    fn legs_hit_every_corner() {
        let values = legs(&[0.0, 1.0, 0.25], |leg| [4, 3][leg]);
        assert_eq!(values, [0.0, 0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25]);
    }

    #[test]
    fn the_smooth_step_stays_put_outside() {
        assert_eq!((smooth_step(-1.0), smooth_step(0.0), smooth_step(2.0)), (0.0, 0.0, 1.0));
        assert!((smooth_step(0.5) - 0.5).abs() < 1e-15);
    }
}

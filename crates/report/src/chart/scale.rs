//! Axes: from values to pixels, and where the ticks stand.

use crate::number::{format_decimals, power_of_ten};

/// How an axis maps values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mapping {
    /// Equal steps.
    Linear,
    /// Equal steps, ticks at the usual parts of a turn, in degrees.
    Degrees,
    /// Equal ratios.
    Log,
}

/// A range of values along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    /// How values are mapped.
    pub(crate) mapping: Mapping,
    /// The value at the beginning.
    pub(crate) low: f64,
    /// The value at the end; larger.
    pub(crate) high: f64,
}

/// A tick: its value and its label without the common power of ten.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tick {
    pub(crate) value: f64,
    pub(crate) label: String,
}

/// The ticks of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ticks {
    /// Labelled ticks.
    pub(crate) major: Vec<Tick>,
    /// Further grid lines of logarithmic axes.
    pub(crate) minor: Vec<f64>,
}

impl Scale {
    /// The scale that holds all finite values, with a margin on linear axes of `margin` of the
    /// range; 0…1 (1…10) if there are none, and some room about a constant.
    pub(crate) fn spanning(
        mapping: Mapping,
        values: impl Iterator<Item = f64>,
        margin: f64,
    ) -> Self {
        let usable = |x: &f64| x.is_finite() && (mapping != Mapping::Log || *x > 0.0);
        let (low, high) = values
            .filter(usable)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let (low, high) = match mapping {
            _ if low > high && mapping == Mapping::Log => (1.0, 10.0),
            _ if low > high => (0.0, 1.0),
            Mapping::Log => widen_log(low, high, margin),
            Mapping::Linear | Mapping::Degrees => widen(low, high, margin),
        };
        Self { mapping, low, high }
    }

    /// Where a value lies: 0 at the beginning, 1 at the end, outside beyond.
    pub(crate) fn fraction(&self, x: f64) -> f64 {
        match self.mapping {
            Mapping::Log if x <= 0.0 => f64::NAN,
            Mapping::Log => (x / self.low).ln() / (self.high / self.low).ln(),
            // Halved, so that a range of nearly all doubles does not overflow.
            _ => (x / 2.0 - self.low / 2.0) / (self.high / 2.0 - self.low / 2.0),
        }
    }

    /// What the labels leave out of every value, for a short stretch far from zero; mostly 0.
    pub(crate) fn offset(&self) -> f64 {
        let range = self.high - self.low;
        let largest = self.low.abs().max(self.high.abs());
        if self.mapping != Mapping::Linear || !range.is_finite() || largest < 1e4 * range {
            return 0.0;
        }
        let step = 10_f64.powf(range.log10().ceil());
        let offset = (self.low / step).floor() * step;
        if offset.is_finite() { offset } else { 0.0 }
    }

    /// The power of ten, a multiple of three, by which the labels are to be multiplied: 0 where
    /// plain decimals are short enough.
    pub(crate) fn exponent(&self) -> i32 {
        let offset = self.offset();
        let largest = (self.low - offset).abs().max((self.high - offset).abs());
        if self.mapping == Mapping::Log || (0.01..1e5).contains(&largest) || largest == 0.0 {
            return 0;
        }
        // Powers are kept where 10^exponent is a normal double.
        ((largest.log10() / 3.0).floor() as i32 * 3).clamp(-300, 300)
    }

    /// At most about `wanted` ticks at round values.
    pub(crate) fn ticks(&self, wanted: usize) -> Ticks {
        match self.mapping {
            Mapping::Log => self.log_ticks(wanted),
            Mapping::Linear => {
                self.even_ticks(round_step(self.high / 2.0 - self.low / 2.0, wanted))
            }
            Mapping::Degrees => self.even_ticks(degree_step(self.high - self.low, wanted)),
        }
    }

    fn even_ticks(&self, step: f64) -> Ticks {
        let first = (self.low / step - 1e-9).ceil();
        let values: Vec<f64> = (0..60)
            .map(|k| (first + f64::from(k)) * step)
            .take_while(|x| *x <= self.high + 1e-9 * step)
            .filter(|x| x.is_finite())
            .collect();
        let unit = 10_f64.powi(self.exponent());
        let offset = self.offset();
        let decimals = decimals_of(step / unit);
        let major = values
            .iter()
            .map(|&value| Tick { value, label: format_decimals((value - offset) / unit, decimals) })
            .collect();
        Ticks { major, minor: Vec::new() }
    }

    fn log_ticks(&self, wanted: usize) -> Ticks {
        let (from, to) = (self.low.log10(), self.high.log10());
        let decades = to - from;
        let multiples: &[f64] = match decades {
            d if d < 0.7 => return self.crowded_log_ticks(wanted),
            d if d < 2.0 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        let stride = ((decades / wanted.max(1) as f64).ceil() as i32).max(1);
        let inside = |x: f64| x >= self.low * (1.0 - 1e-9) && x <= self.high * (1.0 + 1e-9);
        let exponents = || (from.floor() as i32)..=(to.ceil() as i32);
        let plain = from >= -3.3 && to <= 5.3;
        let major = exponents()
            .filter(|k| k.rem_euclid(stride) == 0)
            .flat_map(|k| multiples.iter().map(move |m| (*m, k)))
            .filter(|(m, k)| inside(m * 10_f64.powi(*k)))
            .map(|(m, k)| Tick { value: m * 10_f64.powi(k), label: log_label(m, k, plain) })
            .collect();
        let minor = if stride > 1 || decades > 7.0 {
            Vec::new()
        } else {
            exponents()
                .flat_map(|k| (2..10).map(move |m| f64::from(m) * 10_f64.powi(k)))
                .filter(|x| inside(*x))
                .collect()
        };
        Ticks { major, minor }
    }

    /// Less than a decade: the ticks of a linear axis.
    fn crowded_log_ticks(&self, wanted: usize) -> Ticks {
        self.even_ticks(round_step(self.high / 2.0 - self.low / 2.0, wanted))
    }
}

fn widen(low: f64, high: f64, margin: f64) -> (f64, f64) {
    let limit = |x: f64| x.clamp(-f64::MAX, f64::MAX);
    // A range of rounding errors is a constant.
    if high / 2.0 - low / 2.0 <= 1e-12 * low.abs().max(high.abs()) {
        let room = if low == 0.0 { 1.0 } else { (low.abs() * 0.1).max(f64::MIN_POSITIVE) };
        return (limit(low - room), limit(high + room));
    }
    let room = (high / 2.0 - low / 2.0) * 2.0 * margin;
    let room = if room.is_finite() { room } else { 0.0 };
    (limit(low - room), limit(high + room))
}

/// At most twelve decades below the largest value are shown: what lies deeper is rounding.
fn widen_log(low: f64, high: f64, margin: f64) -> (f64, f64) {
    let high = high.clamp(1e-290, 1e290);
    let low = low.clamp(high * 1e-12, high);
    if high / low < 1.0 + 1e-6 {
        return (low / 2.0, high * 2.0);
    }
    let room = (high / low).powf(margin);
    (low / room, high * room)
}

/// A step of 1, 2 or 5 times a power of ten that gives at most `wanted` steps in twice `half`.
fn round_step(half: f64, wanted: usize) -> f64 {
    let raw = half / (wanted.max(1) as f64) * 2.0;
    let power = 10_f64.powf(raw.log10().floor());
    let step = match raw / power {
        r if r < 1.001 => power,
        r if r < 2.001 => 2.0 * power,
        r if r < 5.001 => 5.0 * power,
        _ => 10.0 * power,
    };
    if step.is_finite() && step > 0.0 { step } else { half.max(f64::MIN_POSITIVE) }
}

fn degree_step(range: f64, wanted: usize) -> f64 {
    const STEPS: [f64; 12] =
        [1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0, 720.0, 1440.0];
    let enough = |step: &f64| range / step <= wanted as f64 + 1.0;
    if range < wanted as f64 {
        return round_step(range / 2.0, wanted);
    }
    STEPS.into_iter().find(enough).unwrap_or_else(|| round_step(range / 2.0, wanted))
}

fn decimals_of(step: f64) -> usize {
    (-(step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize
}

fn log_label(multiple: f64, exponent: i32, plain: bool) -> String {
    if plain {
        format_decimals(multiple * 10_f64.powi(exponent), usize::try_from(-exponent).unwrap_or(0))
    } else if multiple > 1.0 {
        format!("{multiple}·{}", power_of_ten(exponent))
    } else {
        power_of_ten(exponent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, wanted: usize) -> Vec<String> {
        scale.ticks(wanted).major.into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        let scale = Scale { mapping: Mapping::Linear, low: -0.05, high: 1.05 };
        assert_eq!(labels(scale, 6), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        let small = Scale { mapping: Mapping::Linear, low: 0.0, high: 3e-6 };
        assert_eq!(small.exponent(), -6);
        assert_eq!(labels(small, 3), ["0", "1", "2", "3"]);
    }

    #[test]
    fn a_short_stretch_far_from_zero_has_an_offset() {
        let scale = Scale { mapping: Mapping::Linear, low: 1.7e9, high: 1.7e9 + 30.0 };
        assert_eq!(scale.offset(), 1.7e9);
        assert_eq!(labels(scale, 3), ["0", "10", "20", "30"]);
    }

    #[test]
    fn log_ticks_stand_on_decades() {
        let scale = Scale { mapping: Mapping::Log, low: 0.08, high: 1200.0 };
        assert_eq!(labels(scale, 6), ["0.1", "1", "10", "100", "1000"]);
        let wide = Scale { mapping: Mapping::Log, low: 1e-12, high: 1.0 };
        assert_eq!(labels(wide, 4), ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰"]);
    }

    #[test]
    fn degrees_use_parts_of_a_turn() {
        let scale = Scale { mapping: Mapping::Degrees, low: -190.0, high: 10.0 };
        assert_eq!(labels(scale, 5), ["−180", "−135", "−90", "−45", "0"]);
    }

    #[test]
    fn any_range_has_finite_ticks_and_places() {
        let extremes = [
            (0.0, 0.0),
            (5.0, 5.0),
            (1e15, 1e15 + 0.1),
            (-f64::MAX, f64::MAX),
            (0.0, f64::MIN_POSITIVE),
            (5e-324, 5e-324),
            (f64::NAN, f64::INFINITY),
        ];
        for (low, high) in extremes {
            for mapping in [Mapping::Linear, Mapping::Degrees, Mapping::Log] {
                let scale = Scale::spanning(mapping, [low, high].into_iter(), 0.05);
                assert!(scale.low < scale.high, "{scale:?}");
                let ticks = scale.ticks(5);
                assert!(ticks.major.len() <= 60, "{scale:?}");
                for tick in ticks.major {
                    assert!(scale.fraction(tick.value).is_finite(), "{scale:?} {tick:?}");
                }
            }
        }
    }
}

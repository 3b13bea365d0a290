//! Values as text of fixed width, three characters each.
//!
//! A value becomes its place on a grid of 262 142 steps between two ends, in base 64: a third of
//! what decimals take. On a logarithmic axis the grid is one of ratios. The last code is a gap.

use super::scale::Mapping;

const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
/// The code of a gap.
const GAP: u32 = (1 << 18) - 1;
/// Steps between the ends.
const STEPS: f64 = GAP as f64 - 1.0;

/// The ends of a grid, as they are mapped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ends {
    log: bool,
    low: f64,
    high: f64,
}

impl Ends {
    /// The least and the greatest of the values that have a place on an axis of this mapping.
    pub(super) fn of<'a>(mapping: Mapping, values: impl Iterator<Item = &'a f64>) -> Self {
        let log = mapping == Mapping::Log;
        let mapped = values.filter_map(|x| place(log, *x));
        let (low, high) = mapped
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        if low <= high { Self { log, low, high } } else { Self { log, low: 0.0, high: 0.0 } }
    }

    /// Both ends, mapped: of a logarithmic axis their logarithms.
    pub(super) fn pair(self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// The values as text.
    pub(super) fn text(self, values: &[f64]) -> String {
        // Halves, so that no difference exceeds the range of a double.
        let half = self.high / 2.0 - self.low / 2.0;
        let code = |x: &f64| match place(self.log, *x) {
            None => GAP,
            Some(_) if half <= 0.0 => 0,
            Some(x) => ((x / 2.0 - self.low / 2.0) / half * STEPS).round().clamp(0.0, STEPS) as u32,
        };
        let letter = |code: u32, shift: u32| LETTERS[((code >> shift) & 63) as usize] as char;
        values.iter().map(code).flat_map(|c| [12, 6, 0].map(|shift| letter(c, shift))).collect()
    }
}

/// Where a value lies, if it has a place.
fn place(log: bool, x: f64) -> Option<f64> {
    let mapped = if log { x.ln() } else { x };
    mapped.is_finite().then_some(mapped)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the page does.
    fn unpack(text: &str, ends: Ends) -> Vec<f64> {
        let digit = |c: &u8| LETTERS.iter().position(|l| l == c).unwrap() as u32;
        let codes = text.as_bytes().chunks(3).map(|c| c.iter().fold(0, |n, c| (n << 6) | digit(c)));
        let value = |code: u32| {
            let f = f64::from(code) / STEPS;
            let mapped = ends.low * (1.0 - f) + ends.high * f;
            if ends.log { mapped.exp() } else { mapped }
        };
        codes.map(|code| if code == GAP { f64::NAN } else { value(code) }).collect()
    }

    #[test]
    fn values_come_back_within_half_a_step() {
        let values = [-3.5, 0.0, 1e-3, f64::NAN, 7.25];
        let ends = Ends::of(Mapping::Linear, values.iter());
        assert_eq!(ends.pair(), [-3.5, 7.25]);
        let again = unpack(&ends.text(&values), ends);
        for (x, y) in values.iter().zip(&again) {
            assert_eq!(x.is_nan(), y.is_nan());
            assert!(x.is_nan() || (x - y).abs() <= 0.51 * 10.75 / STEPS, "{x} {y}");
        }
        let ends = Ends::of(Mapping::Log, [1e-3, 1.0, 1e6, -1.0].iter());
        let again = unpack(&ends.text(&[1e-3, 1.0, 1e6, -1.0]), ends);
        assert!((again[1] - 1.0).abs() < 5e-5 && again[3].is_nan(), "{again:?}");
    }

    #[test]
    fn odd_values_have_codes_too() {
        for values in [vec![], vec![f64::NAN], vec![4.0; 3], vec![f64::MAX, f64::MIN]] {
            let ends = Ends::of(Mapping::Linear, values.iter());
            let again = unpack(&ends.text(&values), ends);
            for (x, y) in values.iter().zip(&again) {
                assert!(x == y || x.is_nan() && y.is_nan(), "{x} {y}");
            }
        }
    }
}

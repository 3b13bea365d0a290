//! Times as whole numbers that have too many digits for a double, as nanoseconds since 1970 have: the first one is
//! taken off as a whole number, so that nothing of the others is lost.

use std::fmt;

use super::cell::{Broken, parse};

/// Whole numbers up to here are exact as doubles.
pub(super) const EXACT: f64 = 9_007_199_254_740_992.0;
/// Whole numbers from here on lose digits in s: of a double's 53 bits, four are left for a part of a tick.
const LONG: u128 = 1 << 49;

/// What is taken off all numbers of a column; nothing where it is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Base(i128);

impl Base {
    /// The base of times that begin with this one: none where doubles have digits enough.
    pub(super) fn of(first: i128) -> Self {
        if first.unsigned_abs() >= LONG { Self(first) } else { Self::default() }
    }

    pub(super) fn is_none(self) -> bool {
        self.0 == 0
    }

    /// The nearest double.
    pub(super) fn value(self) -> f64 {
        self.0 as f64
    }

    /// A whole number without the base.
    pub(super) fn off(self, number: i128) -> f64 {
        (number - self.0) as f64
    }

    /// The number in a text without the base, and how long it is.
    pub(super) fn off_text(self, text: &[u8]) -> Option<(f64, usize)> {
        let (integer, part, length) = number(text)?;
        Some((self.off(integer.into()) + part, length))
    }

    /// The number in a cell without the base.
    pub(super) fn cell(self, cell: &[u8]) -> Result<f64, Broken> {
        let cell = cell.trim_ascii();
        parse(cell)?;
        let off = self.off_text(cell).filter(|(_, length)| *length == cell.len());
        let way_out = "write all numbers of this column alike, without exponents";
        off.map(|(off, _)| off).ok_or(("is not written as the first one is", way_out))
    }

    /// The number that was there before the base was taken off.
    pub(super) fn back(self, rest: f64) -> f64 {
        match rest.fract() == 0.0 && rest.abs() <= EXACT {
            true => (self.0 + rest as i128) as f64,
            false => self.value() + rest,
        }
    }
}

/// What was taken off all numbers of a column.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Start {
    /// Nothing.
    #[default]
    None,
    /// A long whole number, in the unit of the column.
    Long(Base),
    /// The first date, in ticks since 1970, and ticks per second.
    #[cfg_attr(not(feature = "formats"), expect(dead_code, reason = "of NumPy's dates"))]
    Date(i64, f64),
}

impl Start {
    /// Of columns that both count from a date the earlier one, else the first.
    pub(super) fn earlier(self, other: Self) -> Self {
        if other.after(self).is_some_and(|later| later < 0.0) { other } else { self }
    }

    /// By how much this is later than another, in the unit of the column; none where they cannot be compared.
    pub(super) fn after(self, other: Self) -> Option<f64> {
        match (self, other) {
            (Self::None, Self::None) => Some(0.0),
            (Self::Long(Base(at)), Self::Long(Base(from))) => Some((at - from) as f64),
            (Self::Date(at, ticks), Self::Date(from, others)) => {
                // In 1e-12 s, of which all ticks are whole numbers.
                let fine = |at: i64, ticks: f64| i128::from(at) * (1e12 / ticks).round() as i128;
                Some((fine(at, ticks) - fine(from, others)) as f64 / 1e12)
            }
            _ => None,
        }
    }
}

impl fmt::Display for Base {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// The whole part of the number that a cell holds, if it is written without an exponent.
pub(super) fn integer(cell: &[u8]) -> Option<i128> {
    let cell = cell.trim_ascii();
    let (integer, _, length) = number(cell)?;
    (length == cell.len()).then(|| integer.into())
}

/// The whole part of a number that the text begins with, the part behind its point, and its length.
fn number(text: &[u8]) -> Option<(i64, f64, usize)> {
    let is_negative = text.first() == Some(&b'-');
    let start = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let digits = text[start..].iter().take_while(|c| c.is_ascii_digit()).count();
    if digits == 0 {
        return None;
    }
    let mut integer = 0_i64;
    for digit in &text[start..start + digits] {
        integer = integer.checked_mul(10)?.checked_add(i64::from(digit - b'0'))?;
    }
    let (mut part, mut end) = (0.0, start + digits);
    if text.get(end) == Some(&b'.') {
        let behind = text[end + 1..].iter().take_while(|c| c.is_ascii_digit()).count();
        if behind > 0 {
            part = fast_float2::parse(&text[end..=end + behind]).ok()?;
        }
        end += 1 + behind;
    }
    if matches!(text.get(end), Some(b'e' | b'E')) {
        return None;
    }
    Some(if is_negative { (-integer, -part, end) } else { (integer, part, end) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_compared_by_the_tick() {
        let dates = [Start::Date(1_700_000_000_000_000_001, 1e9), Start::Date(1_700_000_000, 1.0)];
        assert_eq!((dates[0].after(dates[1]), dates[0].earlier(dates[1])), (Some(1e-9), dates[1]));
        let long = |first: i128| Start::Long(Base::of(first));
        assert_eq!(long(1 << 60).after(long((1 << 60) - 3)), Some(3.0));
        assert_eq!(long(1 << 60).after(dates[0]), None);
    }

    #[test]
    fn long_times_keep_their_last_digit() {
        let base = Base::of(integer(b" 1700000000000000000 ").unwrap());
        let off = |text: &str| base.off_text(text.as_bytes());
        assert_eq!(off("1700000000000000001,"), Some((1.0, 19)));
        assert_eq!(off("1699999999999999999\n"), Some((-1.0, 19)));
        assert_eq!(off("1700000000000001000.25"), Some((1000.25, 22)));
        assert_eq!(off("1700000000000001000."), Some((1000.0, 20)));
        for other in ["1.7e18", "17e17", "", "-", "x", "99999999999999999999"] {
            assert_eq!(off(other), None, "{other}");
        }
        let negative = Base::of(integer(b"-1700000000000000000").unwrap());
        assert_eq!(negative.off_text(b"-1699999999999999999.5"), Some((0.5, 22)));
        assert!(Base::of(1_000_000_000_000).is_none() && integer(b"1e18").is_none());
        assert_eq!((base.back(1.0), base.to_string()), (1.7e18, "1700000000000000000".into()));
    }
}

//! Dates and clock times, as instruments, pandas and spreadsheets write them.

use crate::log::ColumnUnit;
use crate::log::units::SECOND;

/// Nanoseconds of a day.
const DAY: i64 = 86_400_000_000_000;

/// What a cell says about an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Instant {
    /// Days since 1970-01-01.
    Date(i64),
    /// Nanoseconds since midnight.
    Clock(i64),
    /// Nanoseconds since 1970-01-01, of the zone that the text is in, or UTC where it says the zone.
    Both(i64),
}

impl Instant {
    /// `2026-11-25`, `2026-11-25 03:00:00.001`, `2026-11-25T03:00:00,5+01:00`, `25.11.2026 03:00`, `11/25/2026
    /// 3:00:00 PM`, `03:00:00.25`. With slashes the month is first unless it is above 12.
    pub(in super::super) fn parse(cell: &str) -> Option<Self> {
        let cell = cell.trim();
        if !cell.starts_with(|c: char| c.is_ascii_digit()) || cell.len() > 40 {
            return None;
        }
        if let Some(duration) = duration(cell) {
            return Some(Self::Both(duration));
        }
        if let Some(clock) = clock(cell) {
            return Some(Self::Clock(clock));
        }
        let (day, rest) = match cell.split_once(['T', ' ']) {
            Some((day, rest)) => (date(day)?, rest.trim()),
            None => return date(cell).map(Self::Date),
        };
        // A zone: Z, +01:00, -0500.
        let rest = rest.strip_suffix(" UTC").or_else(|| rest.strip_suffix('Z')).unwrap_or(rest);
        let (rest, zone) = match rest.rfind(['+', '-']) {
            Some(at) => {
                let digits: String = rest[at + 1..].chars().filter(|c| *c != ':').collect();
                // What is no digit may be several bytes long.
                let (hours, minutes) = digits.split_at_checked(2)?;
                let (hours, minutes): (i64, i64) = match minutes.len() {
                    0 => (hours.parse().ok()?, 0),
                    2 => (hours.parse().ok()?, minutes.parse().ok()?),
                    _ => return None,
                };
                let sign = if rest[at..].starts_with('-') { -1 } else { 1 };
                (rest[..at].trim(), sign * (hours * 60 + minutes) * 60_000_000_000)
            }
            None => (rest, 0),
        };
        let clock = clock(rest)?;
        day.checked_mul(DAY)?.checked_add(clock)?.checked_sub(zone).map(Self::Both)
    }
}

/// Nanoseconds of a number with a unit of time behind it, as MATLAB writes durations: `0.001 sec`.
fn duration(cell: &str) -> Option<i64> {
    let (number, unit) = cell.split_once(' ')?;
    let unit = ColumnUnit::parse(unit).ok().filter(|unit| unit.unit.is_compatible(&SECOND))?.unit;
    let nanoseconds = unit.convert(number.parse().ok()?, &SECOND)? * 1e9;
    (nanoseconds.abs() < 9e18).then_some(nanoseconds.round() as i64)
}

/// Days since 1970-01-01.
fn date(text: &str) -> Option<i64> {
    let separator = ['-', '/', '.'].into_iter().find(|c| text.contains(*c))?;
    let parts: Vec<&str> = text.split(separator).collect();
    let [first, second, third] = parts.as_slice() else { return None };
    let number = |text: &str| {
        let is_short = (1..=4).contains(&text.len()) && text.bytes().all(|c| c.is_ascii_digit());
        if is_short { text.parse::<i64>().ok() } else { None }
    };
    let (a, b, c) = (number(first)?, number(second)?, number(third)?);
    let (year, month, day) = match separator {
        _ if first.len() == 4 => (a, b, c),
        _ if third.len() != 4 => return None,
        '/' if a <= 12 => (c, a, b),
        _ => (c, b, a),
    };
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // Howard Hinnant, "chrono-Compatible Low-Level Date Algorithms", days_from_civil.
    let year = year - i64::from(month <= 2);
    let era = year.div_euclid(400);
    let of_era = year.rem_euclid(400);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    Some(era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468)
}

/// Nanoseconds since midnight: `3:00`, `03:00:00`, `03:00:00.123456789`, `3:00:00,5 PM`.
fn clock(text: &str) -> Option<i64> {
    let upper = text.to_ascii_uppercase();
    let (text, later) = match (upper.strip_suffix("PM"), upper.strip_suffix("AM")) {
        (Some(rest), _) => (rest.trim(), Some(12)),
        (_, Some(rest)) => (rest.trim(), Some(0)),
        _ => (upper.as_str(), None),
    };
    let mut parts = text.split(':');
    let two = |text: &str| {
        let is_short = (1..=2).contains(&text.len()) && text.bytes().all(|c| c.is_ascii_digit());
        if is_short { text.parse::<i64>().ok() } else { None }
    };
    let (hours, minutes) = (two(parts.next()?)?, two(parts.next()?)?);
    let (seconds, nanoseconds) = match parts.next() {
        None => (0, 0),
        Some(text) => {
            let (integer, part) = text.split_once(['.', ',']).unwrap_or((text, ""));
            if !part.bytes().all(|c| c.is_ascii_digit()) {
                return None;
            }
            (two(integer)?, format!("{part:0<9.9}").parse::<i64>().ok()?)
        }
    };
    let hours = later.map_or(hours, |later| hours % 12 + later);
    if parts.next().is_some() || hours > 23 || minutes > 59 || seconds > 60 {
        return None;
    }
    Some(((hours * 60 + minutes) * 60 + seconds) * 1_000_000_000 + nanoseconds)
}

/// Times in s after the first instant of a column; a clock that passes midnight goes on.
#[derive(Debug, Default)]
pub(in super::super) struct Since {
    first: Option<i64>,
    last: i64,
    midnights: i64,
}

impl Since {
    /// The time in s of a row with these cells: a date, a clock, or both in one or two cells.
    pub(in super::super) fn seconds(&mut self, cell: &[u8], day: Option<&[u8]>) -> Option<f64> {
        let instant = |cell: &[u8]| std::str::from_utf8(cell).ok().and_then(Instant::parse);
        let nanoseconds = match (instant(cell)?, day.map(instant)) {
            (Instant::Both(at), _) => at,
            (Instant::Date(day), _) => day.checked_mul(DAY)?,
            (Instant::Clock(clock), Some(day)) => match day? {
                Instant::Date(day) => day.checked_mul(DAY)?.checked_add(clock)?,
                _ => return None,
            },
            (Instant::Clock(clock), None) => {
                if clock + DAY / 2 < self.last {
                    self.midnights += 1;
                }
                self.last = clock;
                self.midnights.checked_mul(DAY)?.checked_add(clock)?
            }
        };
        let first = *self.first.get_or_insert(nanoseconds);
        Some(nanoseconds.checked_sub(first)? as f64 / 1e9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_clocks_of_the_field() {
        const NOON: i64 = 12 * 3_600_000_000_000;
        let day = 20_782; // 2026-11-25
        for text in ["2026-11-25", "25.11.2026", "11/25/2026", "25/11/2026", "2026/11/25"] {
            assert_eq!(Instant::parse(text), Some(Instant::Date(day)), "{text}");
        }
        for text in [
            "2026-11-25 12:00:00",
            "2026-11-25T12:00:00.000Z",
            "2026-11-25T13:00:00,0+01:00",
            "2026-11-25 07:00:00-0500",
            "25.11.2026 12:00",
            "11/25/2026 12:00:00 PM",
        ] {
            assert_eq!(Instant::parse(text), Some(Instant::Both(day * DAY + NOON)), "{text}");
        }
        assert_eq!(Instant::parse("00:00:01.5"), Some(Instant::Clock(1_500_000_000)));
        assert_eq!(Instant::parse("0.25 sec"), Some(Instant::Both(250_000_000)));
        assert_eq!(Instant::parse("1970-01-01"), Some(Instant::Date(0)));
        assert_eq!(Instant::parse("2000-02-29"), Some(Instant::Date(11_016)));
        for text in [
            "1.5",
            "12",
            "1-2",
            "25:00:00",
            "x",
            "",
            "2026-13-01",
            "1.2.3",
            "1e-5",
            "99999-1-1",
            "2026-11-25T12:00-0µm",
            "2026-11-25T12:00+é",
            "2026-11-25T12:00-050",
        ] {
            assert_eq!(Instant::parse(text), None, "{text}");
        }
    }

    #[test]
    fn a_clock_passes_midnight() {
        let mut since = Since::default();
        let times =
            ["23:59:59.5", "00:00:00.5", "00:00:01"].map(|t| since.seconds(t.as_bytes(), None));
        assert_eq!(times, [Some(0.0), Some(1.0), Some(1.5)]);
    }
}

//! The time stamp of generated files.

use std::time::{SystemTime, UNIX_EPOCH};

use crate::write::WriteError;

/// Now, as `YYYY-MM-DDThh:mm:ssZ`; the time in `SOURCE_DATE_EPOCH` if that is set, so that builds
/// can be reproduced (<https://reproducible-builds.org/specs/source-date-epoch/>).
///
/// # Errors
/// If `SOURCE_DATE_EPOCH` is set and is no number of seconds.
pub fn generation_time() -> Result<String, WriteError> {
    let seconds = match std::env::var("SOURCE_DATE_EPOCH") {
        Ok(value) => parse_epoch(&value)?,
        Err(_) => SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| now.as_secs()),
    };
    Ok(date_and_time(seconds))
}

/// The year 9999 ends at this second; `xs:dateTime` of four-digit years goes no further.
const LAST_SECOND: u64 = 253_402_300_799;

fn parse_epoch(value: &str) -> Result<u64, WriteError> {
    let parsed = value.parse().ok().filter(|&seconds| seconds <= LAST_SECOND);
    parsed.ok_or_else(|| WriteError::SourceDateEpoch { value: value.to_owned() })
}

/// Seconds since 1970-01-01T00:00:00Z as text.
fn date_and_time(seconds: u64) -> String {
    let (year, month, day) = civil_date(seconds / 86_400);
    let of_day = seconds % 86_400;
    let (hour, minute, second) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

/// Year, month and day of a day counted from 1970-01-01, in the Gregorian calendar.
///
/// Counts from 1 March of year 0, so that leap days end a year (H. Hinnant,
/// "chrono-compatible low-level date algorithms").
fn civil_date(days: u64) -> (u64, u64, u64) {
    let days = days + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    (year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_instants() {
        // From `date -u -d @…`.
        for (seconds, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_164_800, "2024-02-29T00:00:00Z"),
            (1_763_700_000, "2025-11-21T04:40:00Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
            (LAST_SECOND, "9999-12-31T23:59:59Z"),
        ] {
            assert_eq!(date_and_time(seconds), text);
        }
    }

    #[test]
    fn epoch_must_be_seconds() {
        assert_eq!(parse_epoch("951782400"), Ok(951_782_400));
        for bad in ["", "now", "-1", "1.5", "253402300800"] {
            let error = parse_epoch(bad).unwrap_err();
            assert!(error.to_string().contains(&format!("\"{bad}\"")), "{error}");
        }
    }
}

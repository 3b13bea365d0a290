//! Which column holds the time.

use super::ColumnUnit;
use super::header_cell::{split, split_unit};
use super::text::Kind;
use super::units::SECOND;

/// What columns of time are called, in small letters without signs between them.
const NAMES: [&str; 31] = [
    "time",
    "t",
    "timestamps",
    "timestamp",
    "tout",
    "xaxis",
    "xvalue",
    "timeaxis",
    "timevector",
    "timevalue",
    "elapsedtime",
    "elapsed",
    "timeelapsed",
    "relativetime",
    "reltime",
    "testtime",
    "totaltime",
    "runtime",
    "simtime",
    "datetime",
    "dateandtime",
    "datetimes",
    "timestring",
    "zeit",
    "uhrzeit",
    "zeitstempel",
    "messzeit",
    "temps",
    "tiempo",
    "seconds",
    "second",
];
/// Endings of such names that are units.
const ENDINGS: [(&str, &str); 9] = [
    ("s", "s"),
    ("sec", "s"),
    ("seconds", "s"),
    ("ms", "ms"),
    ("msec", "ms"),
    ("us", "us"),
    ("ns", "ns"),
    ("min", "min"),
    ("h", "h"),
];

/// Whether a column of time may be called this, and the unit that its name ends with.
pub(super) fn of_name(name: &str) -> Option<Option<&'static str>> {
    let plain = |text: &str| -> String {
        text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
    };
    // Our records write a signal `time` as `time_`.
    let is_known = |text: &str| !text.ends_with('_') && NAMES.contains(&plain(text).as_str());
    if is_known(name) {
        return Some(None);
    }
    let (before, ending) = name.rsplit_once(['_', ' ', '.', '-'])?;
    let (_, unit) = ENDINGS.iter().find(|(known, _)| ending.eq_ignore_ascii_case(known))?;
    is_known(before).then_some(Some(unit))
}

/// The column of time among those with these names and units: by its name, else by its unit where it is one of the
/// first two, else the first one of instants.
pub(super) fn find<'a>(
    columns: impl Iterator<Item = (&'a str, Option<&'a str>)> + Clone,
    kinds: &[Kind],
) -> Option<usize> {
    let kind = |at: usize| kinds.get(at).copied().unwrap_or(Kind::Number);
    let named = |wanted: Kind| {
        let mut columns = columns.clone().enumerate();
        columns.find(|(at, (name, _))| of_name(name).is_some() && kind(*at) == wanted)
    };
    let of_time = || {
        columns.clone().take(2).enumerate().find(|(at, (_, unit))| {
            let unit = unit.and_then(|unit| ColumnUnit::parse(unit).ok());
            kind(*at) == Kind::Number && unit.is_some_and(|unit| unit.unit.is_compatible(&SECOND))
        })
    };
    let found = named(Kind::Number).or_else(|| named(Kind::Instant)).or_else(of_time);
    found.map(|(at, _)| at).or_else(|| kinds.iter().position(|kind| *kind == Kind::Instant))
}

/// Whether a table with this header pairs each signal with a time of its own: several columns of time.
pub(super) fn has_several(cells: &[String]) -> bool {
    // Our own records begin with `time`; whatever else is called like a time there is a signal.
    let mut exact = cells.iter().map(|cell| split(cell).0 == "time");
    if exact.next() == Some(true) && !exact.any(|is| is) {
        return false;
    }
    cells
        .iter()
        .filter(|cell| {
            of_name(split_unit(split(cell).0).map_or(split(cell).0, |(name, _)| name)).is_some()
        })
        .count()
        > 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_times() {
        assert_eq!(of_name("time_"), None);
        for name in [
            "time",
            "Time",
            "TIME",
            "t",
            "timestamps",
            "tout",
            "x-axis",
            "X_Value",
            "Zeit",
            "Elapsed Time",
        ] {
            assert_eq!(of_name(name), Some(None), "{name}");
        }
        assert_eq!(of_name("time_ms"), Some(Some("ms")));
        assert_eq!(of_name("t_us"), Some(Some("us")));
        for name in ["u", "x", "", "temperature", "y_ms", "times", "T1"] {
            assert_eq!(of_name(name), None, "{name}");
        }
    }
}

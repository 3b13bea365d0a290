//! Name and unit in a cell of the header.

use super::ColumnUnit;
use super::units::SECOND;

/// Name and unit of a cell of the header: `y [um]` and `y[um]` are y in um; `position[1]` is a name.
pub(super) fn split(cell: &str) -> (&str, Option<&str>) {
    let trimmed = cell.trim();
    let Some((name, unit)) = trimmed.strip_suffix(']').and_then(|rest| rest.rsplit_once('['))
    else {
        return (trimmed, None);
    };
    let is_index = unit.chars().all(|c| c.is_ascii_digit() || matches!(c, ',' | ' '));
    let is_apart = name.ends_with(char::is_whitespace);
    if name.trim().is_empty() || (is_index && !is_apart) {
        return (trimmed, None);
    }
    (name.trim_end(), Some(unit.trim()))
}

/// Name and unit of a cell of the header, with the unit in brackets, in parentheses or behind a stroke.
pub(super) fn name_and_unit(cell: &str) -> (&str, Option<&str>) {
    let (name, unit) = split(cell);
    match split_unit(name).filter(|_| unit.is_none()) {
        Some((name, unit)) => (name, Some(unit)),
        None => (name, unit),
    }
}

/// Name and unit where the unit stands in parentheses or behind a stroke: `CH1 (V)`, `CH1(V)`, `t / s`, `U in V`. A
/// unit of time without a name, as in `in s` or `[s]`, is that of the time.
pub(super) fn split_unit(name: &str) -> Option<(&str, &str)> {
    let between = |open: char, close: char| name.strip_prefix(open)?.strip_suffix(close);
    let alone =
        name.strip_prefix("in ").or_else(|| between('[', ']')).or_else(|| between('(', ')'));
    if let Some(unit) = alone.map(str::trim) {
        let is_time = ColumnUnit::parse(unit).is_ok_and(|unit| unit.unit.is_compatible(&SECOND));
        return is_time.then_some(("time", unit));
    }
    let in_parentheses = name.strip_suffix(')').and_then(|rest| rest.rsplit_once('('));
    let behind = || name.rsplit_once(" / ").or_else(|| name.rsplit_once(" in "));
    let (name, unit) = in_parentheses.or_else(behind)?;
    let (name, unit) = (name.trim(), unit.trim());
    let is_unit = !unit.is_empty() && (unit == "S" || ColumnUnit::parse(unit).is_ok());
    (is_unit && !name.is_empty()).then_some((name, unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distinguishes_units_from_indices() {
        assert_eq!(split("y [um]"), ("y", Some("um")));
        assert_eq!(split("y[um]"), ("y", Some("um")));
        assert_eq!(split(" position[1] "), ("position[1]", None));
        assert_eq!(split("position[1] [um]"), ("position[1]", Some("um")));
        assert_eq!(split("x[1,2]"), ("x[1,2]", None));
        assert_eq!(split("ratio [1]"), ("ratio", Some("1")));
        assert_eq!(split("[um]"), ("[um]", None));
        assert_eq!(split("plain"), ("plain", None));
    }

    #[test]
    fn units_in_parentheses_and_behind_strokes() {
        assert_eq!(split_unit("Time(S)"), Some(("Time", "S")));
        assert_eq!(split_unit("Channel 1 (V)"), Some(("Channel 1", "V")));
        assert_eq!(split_unit("t / s"), Some(("t", "s")));
        assert_eq!(split_unit("Weg in µm"), Some(("Weg", "µm")));
        assert_eq!(split_unit("in s"), Some(("time", "s")));
        assert_eq!(split_unit("[ms]"), Some(("time", "ms")));
        for name in ["in V", "[V]", "y (filtered)", "der(x)", "(V)", "u", "a/b"] {
            assert_eq!(split_unit(name), None, "{name}");
        }
    }
}

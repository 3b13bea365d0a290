//! One cell of a log: a finite number, or what is wrong with it.

/// A rule that a cell breaks, and the way out.
pub(super) type Broken = (&'static str, &'static str);

/// The number in a cell. Truth values, as fmpy writes them, are 0 and 1.
pub(super) fn parse(cell: &[u8]) -> Result<f64, Broken> {
    let cell = cell.trim_ascii();
    fast_float2::parse(cell).map_or_else(|_| other(cell), check)
}

/// The number in a cell of a text with decimal commas.
pub(super) fn parse_with_comma(cell: &[u8]) -> Result<f64, Broken> {
    if cell.contains(&b'.') {
        return Err((
            "has a decimal point in a text with decimal commas",
            "write all numbers alike",
        ));
    }
    if !cell.contains(&b',') {
        return parse(cell);
    }
    let points: Vec<u8> = cell.iter().map(|c| if *c == b',' { b'.' } else { *c }).collect();
    parse(&points)
}

/// The number itself, where a log can hold it.
pub(super) fn check(number: f64) -> Result<f64, Broken> {
    match number {
        _ if number.is_finite() => Ok(number),
        _ if number.is_nan() => Err(GAP),
        _ => Err(("is not finite", "give a finite number, or leave the row out")),
    }
}

/// The rule that a word breaks.
pub(super) const NO_NUMBER: &str = "is no number";

const GAP: Broken = (
    "is a gap: a model cannot be driven by, or compared with, what was not measured",
    "leave the row out and begin a new record behind it, or fill it in beforehand",
);

fn other(cell: &[u8]) -> Result<f64, Broken> {
    match cell {
        b"True" | b"true" | b"TRUE" => Ok(1.0),
        b"False" | b"false" | b"FALSE" => Ok(0.0),
        b"" => Err(GAP),
        _ if cell.eq_ignore_ascii_case(b"na") || cell.eq_ignore_ascii_case(b"n/a") => Err(GAP),
        _ if is_number_with(cell, b',') => Err((
            "has a decimal comma",
            "save the file with decimal points and commas between cells",
        )),
        _ if is_number_with(cell, b' ') => {
            Err(("holds several numbers", "give each element of an array its own column"))
        }
        _ => Err((NO_NUMBER, "give a number with a decimal point, as in 1.5e-3")),
    }
}

/// Whether the cell has only characters of numbers and `separator`, which occurs.
fn is_number_with(cell: &[u8], separator: u8) -> bool {
    cell.contains(&separator)
        && cell.iter().all(|c| c.is_ascii_digit() || b"+-.eE".contains(c) || *c == separator)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_numbers_and_truth_values() {
        assert_eq!(parse(b" 1.5e-3 "), Ok(1.5e-3));
        assert_eq!(parse(b"-0"), Ok(0.0));
        assert_eq!(parse(b"True"), Ok(1.0));
        assert_eq!(parse(b"false"), Ok(0.0));
    }

    #[test]
    fn names_what_is_wrong() {
        let rule = |cell: &[u8]| parse(cell).unwrap_err().0;
        for gap in ["", "  ", "NaN", "nan", "N/A"] {
            assert!(rule(gap.as_bytes()).starts_with("is a gap"), "{gap}");
        }
        assert_eq!(rule(b"inf"), "is not finite");
        assert_eq!(rule(b"1e999"), "is not finite");
        assert_eq!(rule(b"1,5"), "has a decimal comma");
        assert_eq!(rule(b"1 2"), "holds several numbers");
        assert_eq!(rule(b"abc"), "is no number");
        assert_eq!(rule(&[0xff, 0x31]), "is no number");
    }
}

//! Numbers as text.

/// Appends the shortest text that reads back to the same bits, with an exponent where that is shorter:
/// `0`, `-1.5`, `1e-6`; infinities and NaN as `inf`, `-inf`, `NaN`.
pub fn push_number(line: &mut String, value: f64) {
    let mut room = zmij::Buffer::new();
    let text = match value {
        _ if value.is_finite() => room.format_finite(value),
        _ if value.is_nan() => "NaN",
        _ if value > 0.0 => "inf",
        _ => "-inf",
    };
    let text = text.strip_suffix(".0").unwrap_or(text);
    // `1e16`, not `1e+16`.
    let (before, after) = text.split_once('+').unwrap_or((text, ""));
    line.push_str(before);
    line.push_str(after);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn text(value: f64) -> String {
        let mut line = String::new();
        push_number(&mut line, value);
        line
    }

    #[test]
    fn numbers_are_written_as_the_standard_library_writes_them() {
        for value in [0.0, -0.0, 1.0, 1e15, 123e13, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            assert_eq!(text(value), value.to_string());
        }
        for value in [1e-6, 1.5e-300, -2e16, 123e14, 1e300, 5e-324] {
            assert_eq!(text(value), format!("{value:e}"));
        }
        assert_eq!([text(1e-5), text(9.9e-6)], ["0.00001", "9.9e-6"]);
    }

    proptest! {
        #[test]
        fn numbers_read_back_to_their_bits(value in prop::num::f64::ANY) {
            let back: f64 = text(value).parse().expect("a number");
            prop_assert!(back.to_bits() == value.to_bits() || back.is_nan() && value.is_nan());
        }

        #[test]
        fn usual_numbers_are_the_shortest(value in -1e6..1e6_f64) {
            let shortest = if value.abs() < 1e-5 && value != 0.0 { format!("{value:e}") } else { value.to_string() };
            prop_assert_eq!(text(value), shortest);
        }
    }
}

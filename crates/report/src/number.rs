//! Numbers and units as a reader wants them.

/// A number with `digits` significant digits: `0.0123`, `12 300`, `1.23·10⁻⁷`, `−4.5`.
///
/// Trailing zeros are dropped, the minus is a real minus, groups of three are set apart from
/// 10 000 on, and powers of ten are used below 10⁻³ and from 10⁷ on. A value that is not finite is
/// a dash.
pub fn format_number(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return "–".to_owned();
    }
    if x == 0.0 {
        return "0".to_owned();
    }
    let digits = digits.clamp(1, 17);
    // Rounding first: 9.9996 with four digits is 10, one power of ten further.
    let scientific = format!("{:.*e}", digits - 1, x);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-3..7).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        let rounded = if exponent >= digits as i32 { x.round() } else { x };
        decorate(trim_zeros(&format!("{rounded:.decimals$}")))
    } else {
        format!("{}·10{}", decorate(trim_zeros(mantissa)), superscript(exponent))
    }
}

/// A number with a fixed number of decimals; very large ones fall back to powers of ten.
pub(crate) fn format_decimals(x: f64, decimals: usize) -> String {
    if !x.is_finite() || x.abs() >= 1e12 {
        return format_number(x, 4);
    }
    let text = format!("{x:.*}", decimals.min(17));
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    decorate(if is_zero { text.trim_start_matches('-') } else { &text })
}

/// A whole number, groups of three set apart from 10 000 on.
pub(crate) fn format_integer(n: i64) -> String {
    decorate(&n.to_string())
}

/// A power of ten: `10⁻³`.
pub(crate) fn power_of_ten(exponent: i32) -> String {
    format!("10{}", superscript(exponent))
}

/// A unit as it is printed: `um` → `µm`, `1` → nothing, `um/V` → `µm/V`.
pub fn format_unit(unit: &str) -> String {
    match unit.trim() {
        "1" | "-" => String::new(),
        unit => unit.split('/').map(one_unit).collect::<Vec<_>>().join("/"),
    }
}

fn one_unit(unit: &str) -> String {
    match unit {
        "degC" => "°C".to_owned(),
        "deg" => "°".to_owned(),
        "ohm" | "Ohm" => "Ω".to_owned(),
        "um" | "us" | "urad" | "uV" | "uA" | "uF" | "uN" | "uH" | "um^2" | "um2" => {
            format!("µ{}", one_unit(&unit[1..]))
        }
        _ => unit.replace("^2", "²").replace("^3", "³"),
    }
}

fn superscript(n: i32) -> String {
    n.to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
        })
        .collect()
}

fn trim_zeros(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// Sets groups of three apart (narrow no-break space) and writes a real minus.
fn decorate(text: &str) -> String {
    let (sign, digits) = text.strip_prefix('-').map_or(("", text), |rest| ("−", rest));
    let (complete, fraction) = digits.split_once('.').map_or((digits, None), |(w, f)| (w, Some(f)));
    let mut out = sign.to_owned();
    for (i, c) in complete.chars().enumerate() {
        if complete.len() > 4 && i > 0 && (complete.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    if let Some(fraction) = fraction {
        out.push('.');
        out.push_str(fraction);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_are_kept_and_zeros_dropped() {
        for (x, text) in [
            (0.0, "0"),
            (0.61, "0.61"),
            (12.3456, "12.35"),
            (-4.5, "−4.5"),
            (9.9996, "10"),
            (1234.0, "1234"),
            (12345.6, "12\u{202f}346"),
            (0.0012344, "0.001234"),
            (1.234e-7, "1.234·10⁻⁷"),
            (-6.02214e23, "−6.022·10²³"),
            (f64::NAN, "–"),
            (f64::MIN_POSITIVE, "2.225·10⁻³⁰⁸"),
        ] {
            assert_eq!(format_number(x, 4), text);
        }
    }

    #[test]
    fn fixed_decimals_have_no_negative_zero() {
        assert_eq!(format_decimals(-0.0004, 3), "0.000");
        assert_eq!(format_decimals(-1.5, 3), "−1.500");
        assert_eq!(format_integer(1_234_567), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn units_are_set_as_the_si_brochure_does() {
        for (unit, text) in [
            ("um", "µm"),
            ("um/V", "µm/V"),
            ("1", ""),
            ("degC", "°C"),
            ("% of range", "% of range"),
        ] {
            assert_eq!(format_unit(unit), text);
        }
    }
}

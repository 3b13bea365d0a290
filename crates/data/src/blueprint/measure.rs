//! Numbers with a unit as texts, as in `2.1 kHz`.

use model::Unit;

/// A rule that a text breaks, and the way out.
pub(super) type Broken = (String, String);

/// The value of `text` in the unit `target`, whose text is `target_text`.
pub(super) fn in_unit(text: &str, target: &Unit, target_text: &str) -> Result<f64, Broken> {
    let (number, unit_text) = split(text).ok_or_else(|| {
        let way_out = format!("write a number and a unit of the kind of {target_text}");
        ("is no number with a unit".to_string(), way_out)
    })?;
    if unit_text.starts_with(',') {
        let way_out = "write a decimal point, as in \"2.1 kHz\"".to_string();
        return Err(("has a decimal comma".to_string(), way_out));
    }
    if unit_text.is_empty() {
        let way_out = format!("write it without quotation marks, in {target_text}, or add a unit");
        return Err(("is a text without a unit".to_string(), way_out));
    }
    let unit = Unit::parse(unit_text)
        .map_err(|error| (format!("unit \"{unit_text}\": {error}"), expected(target_text)))?;
    if let Some(power) = power_of_ten(&unit, target) {
        return Ok(shifted(number, power));
    }
    unit.convert(number, target).ok_or_else(|| {
        let rule = format!("the unit {unit_text} does not measure the same as {target_text}");
        (rule, expected(target_text))
    })
}

/// The power of ten that converts one unit to another, where it is one.
fn power_of_ten(unit: &Unit, target: &Unit) -> Option<i32> {
    if !unit.is_compatible(target) || unit.offset != 0.0 || target.offset != 0.0 {
        return None;
    }
    let ratio = unit.factor / target.factor;
    let power = ratio.log10().round();
    // Read as a number, it is the nearest one on each platform.
    let exact: f64 = format!("1e{}", power as i32).parse().ok()?;
    let is_power = power.abs() < 300.0 && (ratio / exact - 1.0).abs() < 1e-12;
    is_power.then_some(power as i32)
}

/// `number · 10^power`, rounded once as a decimal number is, so that "20 us" is 20e-6.
fn shifted(number: f64, power: i32) -> f64 {
    let text = format!("{number:e}");
    let parts = text.split_once('e').and_then(|(digits, e)| Some((digits, e.parse::<i32>().ok()?)));
    parts
        .and_then(|(digits, exponent)| format!("{digits}e{}", exponent + power).parse().ok())
        .unwrap_or(number)
}

/// A value with its unit, as messages show it.
pub(super) fn shown(value: f64, unit: &str) -> String {
    if unit == "1" { value.to_string() } else { format!("{value} {unit}") }
}

fn expected(target_text: &str) -> String {
    format!("give a unit that converts to {target_text}")
}

/// The longest number at the start, and the rest.
fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let ends = (1..=text.len()).rev().filter(|end| text.is_char_boundary(*end));
    for end in ends {
        let (number, unit) = text.split_at(end);
        if let Ok(number) = number.trim_end().parse() {
            return Some((number, unit.trim_start()));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, target: &str) -> Result<f64, Broken> {
        in_unit(text, &Unit::parse(target).unwrap(), target)
    }

    #[test]
    fn converts_to_the_unit_wanted() {
        assert_eq!(read("2.1 kHz", "Hz"), Ok(2100.0));
        assert_eq!(read("2.1kHz", "kHz"), Ok(2.1));
        assert_eq!(read(" 1e3 mV ", "V"), Ok(1.0));
        assert_eq!(read("5 %", "1"), Ok(0.05));
        assert_eq!(read("0.3 um/V", "um/V"), Ok(0.3));
        assert_eq!(read("20 us", "s"), Ok(20e-6));
        assert_eq!(read("0.1 us", "s"), Ok(1e-7));
        assert_eq!(read("1.7 mm", "um"), Ok(1700.0));
        assert_eq!(read("-3 min", "s"), Ok(-180.0));
        assert_eq!(read("20 degC", "K"), Ok(293.15));
        assert!(read("inf us", "s").unwrap().is_infinite());
    }

    #[test]
    fn names_what_is_wrong() {
        let rule = |text, target| read(text, target).unwrap_err().0;
        assert_eq!(rule("2,1 kHz", "Hz"), "has a decimal comma");
        assert_eq!(rule("2.1", "Hz"), "is a text without a unit");
        assert_eq!(rule("fast", "Hz"), "is no number with a unit");
        assert_eq!(rule("", "Hz"), "is no number with a unit");
        assert_eq!(rule("2 um", "Hz"), "the unit um does not measure the same as Hz");
        assert!(rule("2 furlong", "um").starts_with("unit \"furlong\": no unit symbol"));
    }
}

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
    unit.convert(number, target).ok_or_else(|| {
        let rule = format!("the unit {unit_text} does not measure the same as {target_text}");
        (rule, expected(target_text))
    })
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
    }

    #[test]
    fn says_what_is_wrong() {
        let rule = |text, target| read(text, target).unwrap_err().0;
        assert_eq!(rule("2,1 kHz", "Hz"), "has a decimal comma");
        assert_eq!(rule("2.1", "Hz"), "is a text without a unit");
        assert_eq!(rule("fast", "Hz"), "is no number with a unit");
        assert_eq!(rule("", "Hz"), "is no number with a unit");
        assert_eq!(rule("2 um", "Hz"), "the unit um does not measure the same as Hz");
        assert!(rule("2 furlong", "um").starts_with("unit \"furlong\": no unit symbol"));
    }
}

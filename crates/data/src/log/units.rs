//! Units as instruments, calibration files and spreadsheets write them.

use model::{Unit, UnitError};

use super::ColumnUnit;

/// The unit of time.
pub(super) const SECOND: Unit =
    Unit { exponents: [0, 0, 1, 0, 0, 0, 0, 0], factor: 1.0, offset: 0.0 };

impl ColumnUnit {
    /// Reads a unit: symbols as [`Unit::parse`] takes them, and the words and signs of the field, as in
    /// `Volts`, `hours`, `°C`, `m/s²`; `-`, `hex`, `bool` and the like are 1. The text that is kept is one
    /// that [`Unit::parse`] takes.
    ///
    /// # Errors
    /// The text is no unit.
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        let plain = |text: &str| Unit::parse(text).map(|unit| Self { text: text.into(), unit });
        plain(text).or_else(|error| plain(&symbols(text)).map_err(|_| error))
    }
}

/// The unit in symbols, as far as its words are known.
fn symbols(text: &str) -> String {
    let text = text.trim();
    let inside = text.strip_prefix(['(', '[']).and_then(|rest| rest.strip_suffix([')', ']']));
    let text = inside.unwrap_or(text).trim();
    if let Some(symbol) = word(text) {
        return symbol.into();
    }
    let mut out = String::new();
    let mut part = String::new();
    // "m/s²", "N·m", "kg m^2", "1/min", "m s**-2".
    let text = text
        .replace(" /", "/")
        .replace("/ ", "/")
        .replace("**", "^")
        .replace('²', "2")
        .replace('³', "3")
        .replace("⁻¹", "-1");
    for c in text.chars().chain(['\0']) {
        if !matches!(c, '.' | '/' | '*' | '·' | '⋅' | ' ' | '\0') {
            part.push(c);
            continue;
        }
        if part.is_empty() {
            continue;
        }
        out.push_str(word(&part).unwrap_or(&part));
        part.clear();
        match c {
            '\0' => {}
            '/' => out.push('/'),
            _ => out.push('.'),
        }
    }
    out.trim_end_matches('.').to_owned()
}

/// The symbol of a word or sign.
fn word(text: &str) -> Option<&'static str> {
    let sign = match text {
        "°" => "deg",
        "°C" | "℃" | "º C" | "° C" => "degC",
        "°/s" => "deg/s",
        "\u{3a9}" | "\u{2126}" => "Ohm",
        "k\u{3a9}" | "k\u{2126}" => "kOhm",
        "M\u{3a9}" | "M\u{2126}" => "MOhm",
        "µ" | "μ" => "um",
        "U/min" | "1/min" | "r/min" | "rev/min" | "min-1" | "min^-1" => "rpm",
        "Nm" => "N.m",
        "mNm" => "mN.m",
        "Ah" => "A.h",
        "kph" | "km/h" | "kmh" | "Km/h" => "km/h",
        "S/s" | "Sa/s" => "Hz",
        _ => "",
    };
    if !sign.is_empty() {
        return Some(sign);
    }
    Some(match text.to_lowercase().as_str() {
        "-" | "--" | "none" | "n/a" | "na" | "hex" | "dec" | "bin" | "bool" | "boolean" | "bit"
        | "bits" | "byte" | "bytes" | "count" | "counts" | "cnt" | "cnts" | "digit" | "digits"
        | "lsb" | "enum" | "index" | "sample" | "samples" | "sequence" | "a.u." | "arb"
        | "arb." | "arb. unit" | "unitless" | "dimensionless" | "ratio" | "logic" | "state"
        | "step" | "steps" | "#" | "no unit" | "no_unit" | "nounit" => "1",
        "percent" | "pct" | "prozent" => "%",
        "second" | "seconds" | "sec" | "secs" | "sekunden" => "s",
        "millisecond" | "milliseconds" | "msec" | "msecs" | "millis" => "ms",
        "microsecond" | "microseconds" | "usec" | "usecs" | "µsec" | "micros" => "us",
        "nanosecond" | "nanoseconds" | "nsec" | "nanos" => "ns",
        "minute" | "minutes" | "mins" => "min",
        "hour" | "hours" | "hrs" | "hr" | "stunden" => "h",
        "volt" | "volts" | "vdc" | "volt dc" => "V",
        "millivolt" | "millivolts" => "mV",
        "kilovolt" | "kilovolts" => "kV",
        "ampere" | "amperes" | "amp" | "amps" => "A",
        "milliampere" | "milliamp" | "milliamps" => "mA",
        "ohm" | "ohms" => "Ohm",
        "watt" | "watts" => "W",
        "joule" | "joules" => "J",
        "hertz" => "Hz",
        "kilohertz" => "kHz",
        "newton" | "newtons" => "N",
        "pascal" | "pascals" => "Pa",
        "farad" => "F",
        "henry" => "H",
        "coulomb" => "C",
        "kelvin" => "K",
        "celsius" | "deg c" | "deg_c" | "degc" | "degree celsius" | "degrees celsius" => "degC",
        "degree" | "degrees" | "degs" => "deg",
        "radian" | "radians" => "rad",
        "meter" | "meters" | "metre" | "metres" => "m",
        "millimeter" | "millimeters" | "millimetre" | "millimetres" => "mm",
        "micrometer" | "micrometers" | "micrometre" | "micrometres" | "micron" | "microns" => "um",
        "nanometer" | "nanometers" | "nanometre" | "nanometres" => "nm",
        "gram" | "grams" => "g",
        "kilogram" | "kilograms" => "kg",
        "rpm" => "rpm",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_field_are_their_symbols() {
        for (words, symbol) in [
            ("Volts", "V"),
            ("V ", "V"),
            ("(mV)", "mV"),
            ("hours", "h"),
            ("°C", "degC"),
            ("°", "deg"),
            ("µm", "µm"),
            ("1/min", "1/min"),
            ("U/min", "rpm"),
            ("RPM", "rpm"),
            ("-", "1"),
            ("hex", "1"),
            ("kΩ", "kOhm"),
            ("m/s²", "m/s2"),
            ("N·m", "N.m"),
            ("kg m^2", "kg.m^2"),
            ("Amps / second", "A/s"),
            ("Sa/s", "Hz"),
        ] {
            let unit = ColumnUnit::parse(words).unwrap_or_else(|e| panic!("{words}: {e}"));
            assert_eq!(unit.text, symbol, "{words}");
            assert_eq!(Unit::parse(&unit.text), Ok(unit.unit), "{words}");
        }
        assert!(ColumnUnit::parse("furlong").is_err());
    }

    #[test]
    fn the_second_is_the_model_s() {
        assert_eq!(Unit::parse("s"), Ok(SECOND));
    }
}

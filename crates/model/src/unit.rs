//! Units of measurement: a factor (and offset) to SI and the exponents of the SI base units.

use core::fmt;

/// Names of the base units, in the order of [`Unit::exponents`]; it is the order and spelling of
/// the attributes of `BaseUnit` in FMI 2.0.5 (§2.2.2) and 3.0 (§2.4.3).
pub const BASE_UNITS: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// A unit: `value in SI base units = factor · value + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Exponents of kg, m, s, A, K, mol, cd, rad.
    pub exponents: [i8; 8],
    /// Factor to the SI base units.
    pub factor: f64,
    /// Offset in SI base units (only degC has one).
    pub offset: f64,
}

/// A text that is no unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitError {
    /// No symbol of this name is known; byte range in the text.
    Unknown {
        /// First byte of the symbol.
        start: usize,
        /// One past its last byte.
        end: usize,
    },
    /// An exponent that is not a whole number from −9 to 9, or a misplaced sign.
    Syntax {
        /// Byte position in the text.
        at: usize,
    },
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { start, end } => write!(
                f,
                "no unit symbol at characters {}..{end}; known are m, g, s, A, K, mol, cd, rad, deg, \
                 V, N, Hz, C, F, H, W, J, Pa, Ohm, S, T, Wb, bar, min, h, rpm, degC, % and 1, with the prefixes \
                 p n u m c k M G, combined as in um/V, N.s/m, V/s2",
                start + 1
            ),
            Self::Syntax { at } => write!(
                f,
                "character {}: a unit is written as symbols joined by . or /, each with an optional \
                 whole exponent, as in um/V, N.s/m, V/s2",
                at + 1
            ),
        }
    }
}

impl core::error::Error for UnitError {}

impl Unit {
    /// The dimensionless unit 1.
    pub const ONE: Self = Self { exponents: [0; 8], factor: 1.0, offset: 0.0 };

    /// Reads a unit: symbols joined by `.`, `*` or `/`, each with an optional exponent, for example
    /// `um/V`, `N.s/m`, `V/s2`, `1/s`, `m.s-2`. An empty text and `1` are dimensionless.
    ///
    /// A `/` applies to the one symbol behind it.
    ///
    /// # Errors
    /// [`UnitError`] with the place in the text.
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        let mut unit = Self::ONE;
        if text.trim().is_empty() {
            return Ok(unit);
        }
        let mut sign = 1;
        let mut start = 0;
        let single = !text.contains(['.', '/', '*']);
        for (at, c) in text.char_indices().chain([(text.len(), '.')]) {
            if !matches!(c, '.' | '/' | '*') {
                continue;
            }
            let factor = Self::factor_of(text, start, at)?;
            unit = unit.times(factor, sign);
            if single {
                unit.offset = factor.offset;
            }
            sign = if c == '/' { -1 } else { 1 };
            start = at + c.len_utf8();
        }
        Ok(unit)
    }

    /// One symbol with its exponent, `text[start..end]`.
    fn factor_of(text: &str, start: usize, end: usize) -> Result<Self, UnitError> {
        let part = &text[start..end];
        let symbol_end = match part.find(|c: char| c.is_ascii_digit() || c == '-' || c == '^') {
            Some(0) if part == "1" => return Ok(Self::ONE),
            Some(at) if at > 0 => at,
            None if !part.is_empty() => part.len(),
            _ => return Err(UnitError::Syntax { at: start }),
        };
        let (symbol, exponent) = part.split_at(symbol_end);
        let exponent = exponent.strip_prefix('^').unwrap_or(exponent);
        let power: i8 = if exponent.is_empty() {
            1
        } else {
            exponent.parse().map_err(|_| UnitError::Syntax { at: start + symbol_end })?
        };
        if !(-9..=9).contains(&power) {
            return Err(UnitError::Syntax { at: start + symbol_end });
        }
        let unit =
            Self::symbol(symbol).ok_or(UnitError::Unknown { start, end: start + symbol_end })?;
        Ok(if power == 1 { unit } else { Self::ONE.times(unit, power) })
    }

    /// A symbol without exponent: as it stands, else with its first character as a prefix.
    fn symbol(text: &str) -> Option<Self> {
        if let Some(unit) = Self::base_symbol(text) {
            return Some(unit);
        }
        let prefix = text.chars().next()?;
        let scale = match prefix {
            'p' => 1e-12,
            'n' => 1e-9,
            'u' | 'µ' | 'μ' => 1e-6,
            'm' => 1e-3,
            'c' => 1e-2,
            'k' => 1e3,
            'M' => 1e6,
            'G' => 1e9,
            _ => return None,
        };
        let rest = &text[prefix.len_utf8()..];
        if matches!(rest, "1" | "%" | "deg" | "degC" | "min" | "h" | "kg" | "") {
            return None;
        }
        // 1e-3 for the gram and 1e3 for k give exactly 1 for kg.
        Self::base_symbol(rest).map(|u| {
            if text == "kg" {
                Self { factor: 1.0, ..u }
            } else {
                Self { factor: scale * u.factor, ..u }
            }
        })
    }

    fn base_symbol(text: &str) -> Option<Self> {
        const fn unit(factor: f64, exponents: [i8; 8]) -> Unit {
            Unit { exponents, factor, offset: 0.0 }
        }
        //                          kg  m  s  A  K mol cd rad
        Some(match text {
            "1" => Self::ONE,
            "%" => unit(1e-2, [0; 8]),
            "g" => unit(1e-3, [1, 0, 0, 0, 0, 0, 0, 0]),
            "m" => unit(1.0, [0, 1, 0, 0, 0, 0, 0, 0]),
            "s" => unit(1.0, [0, 0, 1, 0, 0, 0, 0, 0]),
            "min" => unit(60.0, [0, 0, 1, 0, 0, 0, 0, 0]),
            "h" => unit(3600.0, [0, 0, 1, 0, 0, 0, 0, 0]),
            "A" => unit(1.0, [0, 0, 0, 1, 0, 0, 0, 0]),
            "K" => unit(1.0, [0, 0, 0, 0, 1, 0, 0, 0]),
            "degC" => Self { offset: 273.15, ..unit(1.0, [0, 0, 0, 0, 1, 0, 0, 0]) },
            "mol" => unit(1.0, [0, 0, 0, 0, 0, 1, 0, 0]),
            "cd" => unit(1.0, [0, 0, 0, 0, 0, 0, 1, 0]),
            "rad" => unit(1.0, [0, 0, 0, 0, 0, 0, 0, 1]),
            "deg" => unit(core::f64::consts::PI / 180.0, [0, 0, 0, 0, 0, 0, 0, 1]),
            "rpm" => unit(core::f64::consts::PI / 30.0, [0, 0, -1, 0, 0, 0, 0, 1]),
            "Hz" => unit(1.0, [0, 0, -1, 0, 0, 0, 0, 0]),
            "N" => unit(1.0, [1, 1, -2, 0, 0, 0, 0, 0]),
            "Pa" => unit(1.0, [1, -1, -2, 0, 0, 0, 0, 0]),
            "bar" => unit(1e5, [1, -1, -2, 0, 0, 0, 0, 0]),
            "J" => unit(1.0, [1, 2, -2, 0, 0, 0, 0, 0]),
            "W" => unit(1.0, [1, 2, -3, 0, 0, 0, 0, 0]),
            "C" => unit(1.0, [0, 0, 1, 1, 0, 0, 0, 0]),
            "V" => unit(1.0, [1, 2, -3, -1, 0, 0, 0, 0]),
            "F" => unit(1.0, [-1, -2, 4, 2, 0, 0, 0, 0]),
            "H" => unit(1.0, [1, 2, -2, -2, 0, 0, 0, 0]),
            "Ohm" => unit(1.0, [1, 2, -3, -2, 0, 0, 0, 0]),
            "S" => unit(1.0, [-1, -2, 3, 2, 0, 0, 0, 0]),
            "Wb" => unit(1.0, [1, 2, -2, -1, 0, 0, 0, 0]),
            "T" => unit(1.0, [1, 0, -2, -1, 0, 0, 0, 0]),
            _ => return None,
        })
    }

    /// This unit times `other` to the power `power` (offsets are dropped).
    #[must_use]
    pub fn times(self, other: Self, power: i8) -> Self {
        let mut exponents = self.exponents;
        for (mine, theirs) in exponents.iter_mut().zip(other.exponents) {
            *mine = mine.saturating_add(theirs.saturating_mul(power));
        }
        let mut factor = self.factor;
        for _ in 0..power.unsigned_abs() {
            if power > 0 {
                factor *= other.factor;
            } else {
                factor /= other.factor;
            }
        }
        Self { exponents, factor, offset: 0.0 }
    }

    /// Whether both measure the same dimension.
    #[must_use]
    pub fn is_compatible(&self, other: &Self) -> bool {
        self.exponents == other.exponents
    }

    /// `value` of this unit in SI base units.
    #[must_use]
    pub fn to_si(&self, value: f64) -> f64 {
        value * self.factor + self.offset
    }

    /// `value` in SI base units, expressed in this unit.
    #[must_use]
    pub fn from_si(&self, value: f64) -> f64 {
        (value - self.offset) / self.factor
    }

    /// `value` of this unit expressed in `target`; `None` where the dimensions differ. Equal units
    /// return `value` bit for bit.
    #[must_use]
    pub fn convert(&self, value: f64, target: &Self) -> Option<f64> {
        if self == target {
            return Some(value);
        }
        self.is_compatible(target).then(|| target.from_si(self.to_si(value)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(text: &str) -> Unit {
        Unit::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    #[test]
    fn reads_the_units_of_the_field() {
        assert_eq!(unit("um/V").exponents, [-1, -1, 3, 1, 0, 0, 0, 0]);
        assert_eq!(unit("um/V").factor, 1e-6);
        assert_eq!(unit("N.s/m"), unit("kg/s"));
        assert_eq!(unit("V/s2"), unit("V.s-2"));
        assert_eq!(unit("V/s2"), unit("V/s/s"));
        assert_eq!(unit("kHz").factor, 1e3);
        assert_eq!(unit("Ohm.F"), unit("s"));
        assert_eq!(unit("T.m2"), unit("Wb"));
        assert_eq!(unit("S.Wb"), unit("C"));
        assert_eq!(unit("1/s"), unit("Hz"));
        assert_eq!(unit(""), Unit::ONE);
        assert_eq!(unit("%").factor, 0.01);
        assert_eq!(unit("µm"), unit("um"));
        assert_eq!(unit("kg").factor, 1.0);
        assert_eq!(unit("min").factor, 60.0);
        assert_eq!(unit("mm").factor, 1e-3);
        assert_eq!(unit("rpm").convert(60.0, &unit("rad/s")), Some(core::f64::consts::TAU));
    }

    #[test]
    fn converts_between_compatible_units_only() {
        assert_eq!(unit("um").convert(1500.0, &unit("mm")), Some(1.5));
        assert_eq!(unit("degC").convert(20.0, &unit("K")), Some(293.15));
        assert_eq!(unit("um").convert(1.0, &unit("V")), None);
        let odd = 0.1 + 0.2;
        assert_eq!(unit("um").convert(odd, &unit("um")), Some(odd));
    }

    #[test]
    fn refuses_what_is_no_unit_and_says_where() {
        assert_eq!(Unit::parse("um/furlong"), Err(UnitError::Unknown { start: 3, end: 10 }));
        assert_eq!(Unit::parse("um//V"), Err(UnitError::Syntax { at: 3 }));
        assert_eq!(Unit::parse("V/s99"), Err(UnitError::Syntax { at: 3 }));
        assert_eq!(Unit::parse("3m"), Err(UnitError::Syntax { at: 0 }));
        assert!(Unit::parse("m%").is_err());
    }
}

//! Conversion between units.

use modeldescription::description::{BaseUnit, Unit};
use modeldescription::ssp::Linear;

/// How values change on their way: `y = factor · x + offset`, or not at all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Conversion {
    /// The value goes as it is, bit for bit.
    Same,
    /// `y = factor · x + offset`.
    Linear {
        /// The factor.
        factor: f64,
        /// The offset, in the target's unit.
        offset: f64,
    },
}

impl Conversion {
    /// From one unit to another; a side without a unit takes the other's.
    ///
    /// `differences` tells that the values are differences (`relativeQuantity`): offsets between
    /// scales, as between K and °C, do not apply.
    ///
    /// # Errors
    /// A sentence that says why the units do not convert.
    pub fn between(
        from: Option<&Unit>,
        to: Option<&Unit>,
        differences: bool,
    ) -> Result<Self, String> {
        let (Some(from), Some(to)) = (from, to) else { return Ok(Conversion::Same) };
        match (from.base, to.base) {
            (Some(a), Some(b)) => convert(&a, &b, differences),
            _ if from.name == to.name => Ok(Conversion::Same),
            (None, _) => Err(no_base(&from.name)),
            (_, None) => Err(no_base(&to.name)),
        }
    }

    /// The value in the target's unit.
    #[inline]
    pub fn apply(self, value: f64) -> f64 {
        match self {
            Conversion::Same => value,
            Conversion::Linear { factor, offset } => factor * value + offset,
        }
    }
}

impl Conversion {
    /// This conversion, then another.
    pub fn then(self, next: Conversion) -> Self {
        match (self, next) {
            (Conversion::Same, other) | (other, Conversion::Same) => other,
            (
                Conversion::Linear { factor, offset },
                Conversion::Linear { factor: g, offset: c },
            ) => Conversion::Linear { factor: g * factor, offset: g * offset + c },
        }
    }
}

/// What happens to values from a source to its target, beside the conversion of the units of both:
/// the steps of an SSP's connections. Empty: nothing else.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transformations(pub Vec<Linear>);

impl Transformations {
    /// A factor and an offset, applied after unit conversion, or, if that is suppressed, instead.
    pub fn scaled(factor: f64, offset: f64, suppress_unit_conversion: bool) -> Self {
        let transformation = Some((factor, offset)).filter(|scale| *scale != (1.0, 0.0));
        Transformations(vec![Linear {
            from: None,
            to: None,
            suppress_unit_conversion,
            transformation,
        }])
    }

    /// The whole conversion from the source's unit to the target's, through the units that
    /// connectors on the way state.
    pub(crate) fn conversion(
        &self,
        source: Option<&Unit>,
        target: Option<&Unit>,
        differences: bool,
    ) -> Result<Conversion, String> {
        let between = |from, to| Conversion::between(from, to, differences);
        let mut total = Conversion::Same;
        let mut at = source;
        for (i, step) in self.0.iter().enumerate() {
            let is_last = i + 1 == self.0.len();
            total = total.then(between(at, step.from.as_ref())?);
            let before = step.from.as_ref().or(at);
            let after = step.to.as_ref().or(if is_last { target } else { None });
            if !step.suppress_unit_conversion {
                total = total.then(between(before, after)?);
            }
            if let Some((factor, offset)) = step.transformation {
                total = total.then(Conversion::Linear { factor, offset });
            }
            // A transformed value without a stated unit is in no known one.
            let changed = step.suppress_unit_conversion || step.transformation.is_some();
            at = after.or(if changed { None } else { before });
        }
        Ok(total.then(between(at, target)?))
    }
}

/// SI value = factor · value + offset on both sides.
fn convert(from: &BaseUnit, to: &BaseUnit, differences: bool) -> Result<Conversion, String> {
    if from.exponents() != to.exponents() {
        return Err(format!("{} is not {}", si(from), si(to)));
    }
    let shift = if differences { 0.0 } else { (from.offset - to.offset) / to.factor };
    if from.factor == to.factor && shift == 0.0 {
        return Ok(Conversion::Same);
    }
    Ok(Conversion::Linear { factor: from.factor / to.factor, offset: shift })
}

fn no_base(name: &str) -> String {
    format!("the model description does not say what {name} is in SI units (BaseUnit)")
}

/// A unit's dimension, such as `kg.m.s-2`.
fn si(unit: &BaseUnit) -> String {
    let factors: Vec<String> = unit
        .exponents()
        .into_iter()
        .filter(|(_, exponent)| *exponent != 0)
        .map(|(name, exponent)| match exponent {
            1 => name.to_owned(),
            exponent => format!("{name}{exponent}"),
        })
        .collect();
    if factors.is_empty() { "a number without dimension".to_owned() } else { factors.join(".") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(name: &str, base: Option<BaseUnit>) -> Unit {
        Unit { name: name.to_owned(), base, display_units: Vec::new(), line: Default::default() }
    }

    fn length(name: &str, factor: f64) -> Unit {
        unit(name, Some(BaseUnit { m: 1, factor, ..BaseUnit::default() }))
    }

    #[test]
    fn micrometres_to_metres_and_back() {
        let (um, m) = (length("um", 1e-6), length("m", 1.0));
        let there = Conversion::between(Some(&um), Some(&m), false).unwrap();
        assert_eq!(there.apply(3.0), 3e-6);
        let back = Conversion::between(Some(&m), Some(&um), false).unwrap();
        assert!((back.apply(3e-6) - 3.0).abs() < 1e-15);
    }

    #[test]
    fn celsius_to_kelvin_has_an_offset_but_differences_have_none() {
        let kelvin = unit("K", Some(BaseUnit { k: 1, ..BaseUnit::default() }));
        let celsius = unit("degC", Some(BaseUnit { k: 1, offset: 273.15, ..BaseUnit::default() }));
        let absolute = Conversion::between(Some(&celsius), Some(&kelvin), false).unwrap();
        assert_eq!(absolute.apply(20.0), 293.15);
        let difference = Conversion::between(Some(&celsius), Some(&kelvin), true).unwrap();
        assert_eq!(difference, Conversion::Same);
    }

    #[test]
    fn equal_units_leave_every_bit() {
        let um = length("um", 1e-6);
        let same = Conversion::between(Some(&um), Some(&length("µm", 1e-6)), false).unwrap();
        assert_eq!(same.apply(-0.0).to_bits(), (-0.0_f64).to_bits());
        assert_eq!(Conversion::between(None, Some(&um), false), Ok(Conversion::Same));
    }

    #[test]
    fn incompatible_or_undefined_units_are_refused() {
        let volt = unit("V", Some(BaseUnit { kg: 1, m: 2, s: -3, a: -1, ..BaseUnit::default() }));
        let why = Conversion::between(Some(&volt), Some(&length("um", 1e-6)), false).unwrap_err();
        assert_eq!(why, "kg.m2.s-3.A-1 is not m");
        let odd = unit("odd", None);
        assert!(Conversion::between(Some(&odd), Some(&volt), false).unwrap_err().contains("odd"));
        assert_eq!(Conversion::between(Some(&odd), Some(&odd), false), Ok(Conversion::Same));
    }
}

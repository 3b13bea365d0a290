//! Checks that components share, and the words of their refusals.

use core::f64::consts::TAU;

use model::Violation;

/// Slices that do not have the lengths of the declaration; a built system never passes such.
pub(crate) const WRONG_LENGTH: Violation = Violation {
    quantity: "parameters",
    index: None,
    value: 0.0,
    rule: "the number of values differs from the declaration; give as many as it declares",
};

/// The coefficients are the parameters.
pub(crate) fn kept(parameters: &[f64], coefficients: &mut [f64]) -> Result<(), Violation> {
    if coefficients.len() != parameters.len() {
        return Err(WRONG_LENGTH);
    }
    coefficients.copy_from_slice(parameters);
    Ok(())
}

/// Refuses `quantity` with `rule` unless `holds`.
pub(crate) fn require(
    holds: bool,
    quantity: &'static str,
    value: f64,
    rule: &'static str,
) -> Result<(), Violation> {
    if holds { Ok(()) } else { Err(Violation { quantity, index: None, value, rule }) }
}

/// Refuses element `index` (from 0) of `quantity` with `rule` unless `holds`.
pub(crate) fn require_at(
    holds: bool,
    quantity: &'static str,
    index: usize,
    value: f64,
    rule: &'static str,
) -> Result<(), Violation> {
    if holds { Ok(()) } else { Err(Violation { quantity, index: Some(index), value, rule }) }
}

/// Refuses a bandwidth or natural frequency that is not above zero.
pub(crate) fn positive_frequency(quantity: &'static str, value: f64) -> Result<(), Violation> {
    require(
        value > 0.0,
        quantity,
        value,
        "must be above zero; to disable the component, set enabled = false",
    )
}

/// Refuses values that are not strictly increasing, and the first where it is below zero.
pub(crate) fn increasing(
    quantity: &'static str,
    values: &[f64],
    rule: &'static str,
) -> Result<(), Violation> {
    let mut last = f64::NEG_INFINITY;
    for (index, &value) in values.iter().enumerate() {
        require_at(value >= 0.0 && value > last, quantity, index, value, rule)?;
        last = value;
    }
    Ok(())
}

/// Refuses a natural frequency and a damping ratio that make no mode.
pub(crate) fn second_order(frequency: f64, damping: f64, period: f64) -> Result<(), Violation> {
    positive_frequency("frequency", frequency)?;
    require(
        damping > 0.0,
        "damping",
        damping,
        "must be above zero: an undamped mode never comes to rest; give 0.001 for a light one",
    )?;
    require(
        (TAU * frequency * period).is_finite(),
        "frequency",
        frequency,
        "is beyond what can be computed; lower it",
    )
}

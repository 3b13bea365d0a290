//! The variables that a build declares.

use alloc::format;
use alloc::string::{String, ToString};

use crate::quantity::unit_on_axis;
use crate::{Causality, DataType, Declaration, Quantity, Unit, Variability, Variable};

/// The units that stand for `{command}` and `{position}`.
#[derive(Clone, Copy)]
pub(super) struct Units<'a> {
    pub(super) command: &'a str,
    pub(super) position: &'a str,
}

impl Units<'_> {
    /// A declared unit with the axis' own put in.
    pub(super) fn of(&self, unit: &str) -> String {
        unit_on_axis(unit, self.command, self.position)
    }
}

/// An input that is a real number, without short name and bounds.
pub(super) fn input_variable(
    name: String,
    description: String,
    unit: String,
    start: f64,
) -> Variable {
    Variable {
        causality: Causality::Input,
        start: Some(start),
        ..output_variable(name, description, unit)
    }
}

pub(super) fn output_variable(name: String, description: String, unit: String) -> Variable {
    let si = Unit::parse(&unit).unwrap_or(Unit::ONE);
    Variable {
        name,
        alias: None,
        description,
        data_type: DataType::Real,
        unit,
        si,
        causality: Causality::Output,
        discrete: false,
        start: None,
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        fit: false,
        initial_dependencies: None,
    }
}

pub(super) fn parameter_variable(
    name: String,
    quantity: &Quantity,
    value: f64,
    units: &Units<'_>,
    (min, max): (f64, f64),
) -> Variable {
    let unit = units.of(quantity.unit);
    Variable {
        si: Unit::parse(&unit).unwrap_or(Unit::ONE),
        name,
        alias: None,
        description: quantity.description.to_string(),
        data_type: DataType::Real,
        unit,
        causality: match quantity.variability {
            Variability::Fixed => Causality::FixedParameter,
            Variability::Tunable => Causality::TunableParameter,
        },
        discrete: false,
        start: Some(value),
        min,
        max,
        fit: quantity.fit,
        initial_dependencies: None,
    }
}

pub(super) fn enabled_variable(place: &str, declaration: &Declaration, value: f64) -> Variable {
    Variable {
        name: format!("{place}.enabled"),
        alias: None,
        description: format!("Switches {} on", declaration.kind),
        data_type: DataType::Boolean,
        unit: String::new(),
        si: Unit::ONE,
        causality: Causality::FixedParameter,
        discrete: true,
        start: Some(value),
        min: 0.0,
        max: 1.0,
        fit: false,
        initial_dependencies: None,
    }
}

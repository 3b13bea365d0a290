//! Values for variables, set by name before a run.

use std::fmt;

use modeldescription::FmiVersion;
use modeldescription::variable::{Causality, DataType, Initial, Variability, Variable};

/// A value of any type.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Value {
    /// A real number.
    Real(f64),
    /// A whole number or the number of an enumeration's item.
    Integer(i128),
    /// True or false.
    Boolean(bool),
    /// A text.
    Text(String),
}

impl Value {
    /// Reads a value as a person writes it, for a variable of this type.
    ///
    /// # Errors
    /// A sentence that says what the type takes.
    pub fn parse(text: &str, data_type: DataType) -> Result<Self, String> {
        let trimmed = text.trim();
        let wrong = |takes: &str| format!("a variable of type {} takes {takes}", data_type.name());
        match data_type {
            DataType::Float32 | DataType::Float64 => {
                trimmed.parse().map(Value::Real).map_err(|_| wrong("a number, such as 2.5e-3"))
            }
            DataType::Boolean => match trimmed.to_ascii_lowercase().as_str() {
                "true" | "1" => Ok(Value::Boolean(true)),
                "false" | "0" => Ok(Value::Boolean(false)),
                _ => Err(wrong("true or false")),
            },
            DataType::String => Ok(Value::Text(text.to_owned())),
            DataType::Binary | DataType::Clock => Err(wrong("no value from here")),
            _ => trimmed.parse().map(Value::Integer).map_err(|_| wrong("a whole number")),
        }
    }

    /// The value as the variable's type wants it: a whole real is an integer, an integer a real.
    pub(crate) fn fit(&self, data_type: DataType) -> Option<Value> {
        let integer = |value: f64| {
            let integers = value as i128;
            (integers as f64 == value).then_some(integers)
        };
        match (data_type, self) {
            (DataType::Float32 | DataType::Float64, Value::Real(_)) => Some(self.clone()),
            (DataType::Float32 | DataType::Float64, Value::Integer(value)) => {
                Some(Value::Real(*value as f64))
            }
            (DataType::Boolean, Value::Boolean(_)) | (DataType::String, Value::Text(_)) => {
                Some(self.clone())
            }
            (DataType::Boolean, Value::Integer(value @ (0 | 1))) => {
                Some(Value::Boolean(*value == 1))
            }
            (
                DataType::Boolean
                | DataType::String
                | DataType::Binary
                | DataType::Clock
                | DataType::Float32
                | DataType::Float64,
                _,
            ) => None,
            (_, Value::Integer(_)) => Some(self.clone()),
            (_, Value::Real(value)) => integer(*value).map(Value::Integer),
            _ => None,
        }
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Value::Real(value)
    }
}

impl From<i64> for Value {
    fn from(value: i64) -> Self {
        Value::Integer(value.into())
    }
}

impl From<bool> for Value {
    fn from(value: bool) -> Self {
        Value::Boolean(value)
    }
}

impl From<&str> for Value {
    fn from(value: &str) -> Self {
        Value::Text(value.to_owned())
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Real(value) => write!(f, "{value}"),
            Value::Integer(value) => write!(f, "{value}"),
            Value::Boolean(value) => write!(f, "{value}"),
            Value::Text(value) => write!(f, "\"{value}\""),
        }
    }
}

/// When a start value can be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Settable {
    /// Before initialization mode, after the experiment is set up.
    Instantiated,
    /// In initialization mode.
    Initialization,
    /// Never.
    Never,
}

/// When a variable takes a start value (section 2.2.7, note 1 of the table of `initial`):
/// inputs and variables with `initial` exact or approx before initialization, computed tunable
/// ones during it.
pub(crate) fn settable(variable: &Variable, version: FmiVersion) -> Settable {
    let variability = variable.variability(version);
    let given = matches!(variable.initial(version), Some(Initial::Exact | Initial::Approx));
    match variable.causality {
        Causality::Input => Settable::Instantiated,
        _ if variability == Variability::Constant => Settable::Never,
        _ if given => Settable::Instantiated,
        Causality::Output | Causality::Local if variability == Variability::Tunable => {
            Settable::Initialization
        }
        _ => Settable::Never,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_by_type() {
        assert_eq!(Value::parse(" 2.5e-3", DataType::Float64), Ok(Value::Real(2.5e-3)));
        assert_eq!(Value::parse("true", DataType::Boolean), Ok(Value::Boolean(true)));
        assert_eq!(Value::parse("7", DataType::Enumeration), Ok(Value::Integer(7)));
        assert!(Value::parse("7.5", DataType::Int32).unwrap_err().contains("whole number"));
    }

    #[test]
    fn numbers_fit_where_they_can() {
        assert_eq!(Value::Integer(3).fit(DataType::Float64), Some(Value::Real(3.0)));
        assert_eq!(Value::Real(3.0).fit(DataType::Int32), Some(Value::Integer(3)));
        assert_eq!(Value::Real(3.5).fit(DataType::Int32), None);
        assert_eq!(Value::Integer(2).fit(DataType::Boolean), None);
        assert_eq!(Value::from("a").fit(DataType::Float64), None);
    }
}

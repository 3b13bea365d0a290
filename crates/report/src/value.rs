//! Values, targets and outcomes: the small words of a report.

use serde::{Deserialize, Serialize};

/// A value of a key figure or a table cell.
///
/// A number that is not finite becomes [`Value::Missing`] (not a number) or text (an infinity), so
/// that the JSON never holds anything that JSON cannot say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// A whole number, such as a count.
    Integer(i64),
    /// A finite number.
    Number(f64),
    /// Text, shown as it is.
    Text(String),
    /// No value; shown as a dash.
    Missing,
}

impl Value {
    /// The value as a number, if it is one.
    pub fn as_f64(&self) -> Option<f64> {
        match self {
            Self::Integer(n) => Some(*n as f64),
            Self::Number(x) => Some(*x),
            Self::Text(_) | Self::Missing => None,
        }
    }
}

impl From<f64> for Value {
    fn from(x: f64) -> Self {
        if x.is_finite() {
            Self::Number(x)
        } else if x.is_nan() {
            Self::Missing
        } else if x > 0.0 {
            Self::Text("∞".to_owned())
        } else {
            Self::Text("−∞".to_owned())
        }
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<bool> for Value {
    fn from(yes: bool) -> Self {
        Self::from(if yes { "yes" } else { "no" })
    }
}

impl From<i64> for Value {
    fn from(n: i64) -> Self {
        Self::Integer(n)
    }
}

impl From<i32> for Value {
    fn from(n: i32) -> Self {
        Self::Integer(n.into())
    }
}

impl From<u32> for Value {
    fn from(n: u32) -> Self {
        Self::Integer(n.into())
    }
}

impl From<u64> for Value {
    /// Beyond `i64::MAX` the digits are kept as text.
    fn from(n: u64) -> Self {
        i64::try_from(n).map_or_else(|_| Self::Text(n.to_string()), Self::Integer)
    }
}

impl From<usize> for Value {
    fn from(n: usize) -> Self {
        Self::from(n as u64)
    }
}

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

/// How a figure, a verdict or a check came out.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The target is met.
    Pass,
    /// The target is not met.
    Fail,
    /// Neither: look at it.
    Caution,
    /// There is no target.
    #[default]
    None,
}

/// What a value is held against.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "relation")]
pub enum Target {
    /// `value <= limit`.
    AtMost {
        /// The upper limit, in the value's unit.
        limit: f64,
    },
    /// `value >= limit`.
    AtLeast {
        /// The lower limit, in the value's unit.
        limit: f64,
    },
    /// `low <= value <= high`.
    Within {
        /// The lower limit, in the value's unit.
        low: f64,
        /// The upper limit, in the value's unit.
        high: f64,
    },
}

impl Target {
    fn is_finite(&self) -> bool {
        match *self {
            Self::AtMost { limit } | Self::AtLeast { limit } => limit.is_finite(),
            Self::Within { low, high } => low.is_finite() && high.is_finite(),
        }
    }

    /// Whether `value` meets the target; a missing value never does.
    pub fn outcome(&self, value: Option<f64>) -> Outcome {
        let met = value.is_some_and(|x| match *self {
            Self::AtMost { limit } => x <= limit,
            Self::AtLeast { limit } => x >= limit,
            Self::Within { low, high } => low <= x && x <= high,
        });
        if met { Outcome::Pass } else { Outcome::Fail }
    }
}

/// One figure that matters, shown large at the top of the page.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KeyFigure {
    /// What the key figure is, in a few words.
    pub label: String,
    /// The value.
    pub value: Value,
    /// The key figure's unit as the tool writes units (`um`, `Hz`, `% of range`); empty for none.
    pub unit: String,
    /// What the key figure is held against, if anything.
    pub target: Option<Target>,
    /// Whether it meets the target.
    pub outcome: Outcome,
    /// One sentence more, if needed: on which data, how.
    pub note: Option<String>,
}

impl KeyFigure {
    /// A figure without a target.
    pub fn new(label: impl Into<String>, value: impl Into<Value>, unit: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            value: value.into(),
            unit: unit.into(),
            target: None,
            outcome: Outcome::None,
            note: None,
        }
    }

    /// Holds the figure against a target; a missing value fails it. A limit that is not finite
    /// decides the outcome and is not shown.
    #[must_use]
    pub fn target(mut self, target: Target) -> Self {
        self.outcome = target.outcome(self.value.as_f64());
        self.target = target.is_finite().then_some(target);
        self
    }

    /// Target `value <= limit`.
    #[must_use]
    pub fn at_most(self, limit: f64) -> Self {
        self.target(Target::AtMost { limit })
    }

    /// Target `value >= limit`.
    #[must_use]
    pub fn at_least(self, limit: f64) -> Self {
        self.target(Target::AtLeast { limit })
    }

    /// Target `low <= value <= high`.
    #[must_use]
    pub fn within(self, low: f64, high: f64) -> Self {
        self.target(Target::Within { low, high })
    }

    /// Sets the outcome where no single limit decides it.
    #[must_use]
    pub fn outcome(mut self, outcome: Outcome) -> Self {
        self.outcome = outcome;
        self
    }

    /// Adds one sentence below the figure.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = Some(note.into());
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_is_met_on_its_limit_and_missed_beyond() {
        assert_eq!(KeyFigure::new("e", 0.8, "%").at_most(0.8).outcome, Outcome::Pass);
        assert_eq!(KeyFigure::new("e", 0.81, "%").at_most(0.8).outcome, Outcome::Fail);
        assert_eq!(KeyFigure::new("e", 3, "").at_least(3.0).outcome, Outcome::Pass);
        assert_eq!(KeyFigure::new("e", 2.5, "").within(1.0, 2.0).outcome, Outcome::Fail);
    }

    #[test]
    fn a_missing_value_fails_its_target() {
        assert_eq!(KeyFigure::new("e", f64::NAN, "%").at_most(0.8).outcome, Outcome::Fail);
    }

    #[test]
    fn values_survive_json() {
        for value in
            [Value::from(3_usize), 0.5.into(), "a".into(), Value::from(f64::NAN), u64::MAX.into()]
        {
            let text = serde_json::to_string(&value).unwrap();
            assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), value, "{text}");
        }
    }
}

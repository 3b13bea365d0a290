//! Figures and what is asked of them.

use serde::{Deserialize, Serialize};

use crate::statistics::Rate;

/// What a figure is held against.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// `value ≥ limit`.
    AtLeast(f64),
    /// `value ≤ limit`.
    AtMost(f64),
    /// Nothing.
    None,
}

/// One figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// What the figure is.
    pub name: String,
    /// The counts, where it is a share of cases.
    pub rate: Option<Rate>,
    /// The value; a share for counts; `None` where no case says anything.
    pub value: Option<f64>,
    /// What the figure is held against.
    pub goal: Goal,
}

impl Figure {
    /// A share of cases.
    #[must_use]
    pub fn rate(name: &str, rate: Rate, goal: Goal) -> Self {
        Self { name: name.into(), value: rate.share(), rate: Some(rate), goal }
    }

    /// A value of its own.
    #[must_use]
    pub fn value(name: &str, value: Option<f64>, goal: Goal) -> Self {
        Self { name: name.into(), value, rate: None, goal }
    }

    /// Whether the goal is met; `None` where there is no goal or no value.
    #[must_use]
    pub fn is_met(&self) -> Option<bool> {
        match (self.goal, self.value?) {
            (Goal::AtLeast(limit), value) => Some(value >= limit),
            (Goal::AtMost(limit), value) => Some(value <= limit),
            (Goal::None, _) => None,
        }
    }

    /// The value with its interval.
    #[must_use]
    pub fn text(&self) -> String {
        match (self.rate, self.value) {
            (Some(rate), _) => rate.to_string(),
            (None, Some(value)) => format!("{value:.3}"),
            (None, None) => "no case".into(),
        }
    }

    /// The goal, as in `≥ 97 %`.
    #[must_use]
    pub fn goal_text(&self) -> String {
        let limit = |x: f64| match self.rate {
            Some(_) => format!("{:.0} %", 100.0 * x),
            None => format!("{x}"),
        };
        match self.goal {
            Goal::AtLeast(x) => format!("≥ {}", limit(x)),
            Goal::AtMost(x) => format!("≤ {}", limit(x)),
            Goal::None => String::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_met_missed_or_without_an_answer() {
        let figure = |hits, of| Figure::rate("x", Rate::new(hits, of), Goal::AtLeast(0.97));
        assert_eq!(figure(97, 100).is_met(), Some(true));
        assert_eq!(figure(96, 100).is_met(), Some(false));
        assert_eq!(figure(0, 0).is_met(), None);
        assert_eq!(figure(97, 100).goal_text(), "≥ 97 %");
        let set = Figure::value("y", Some(1.5), Goal::AtMost(1.4));
        assert_eq!((set.is_met(), set.goal_text().as_str()), (Some(false), "≤ 1.4"));
        assert_eq!(Figure::value("y", Some(1.5), Goal::None).is_met(), None);
    }
}

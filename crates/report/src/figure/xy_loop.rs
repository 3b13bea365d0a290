//! One quantity over another: hysteresis loops, paths in a plane.

use serde::{Deserialize, Serialize};

use super::{Axis, CURVE_POINTS, Role, note_lengths, note_not_finite};
use crate::reduce;
use crate::summary::Summary;

/// One quantity over another, such as position over command: a hysteresis loop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct XyLoop {
    /// The title.
    pub title: String,
    /// A text below the figure.
    pub caption: Option<String>,
    /// What the horizontal axis shows.
    pub x: Axis,
    /// What the vertical axis shows.
    pub y: Axis,
    /// The loops.
    pub loops: Vec<Loop>,
    /// One scale for both axes: for paths in a plane.
    pub equal_scale: bool,
    /// What could not be drawn as given.
    pub notes: Vec<String>,
}

/// One line through points in the order in which they were passed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Loop {
    /// The loop's name.
    pub name: String,
    /// What the loop stands for.
    pub role: Role,
    /// Horizontal coordinates of the points kept.
    #[serde(with = "crate::finite")]
    pub x: Vec<f64>,
    /// Vertical coordinates of the points kept.
    #[serde(with = "crate::finite")]
    pub y: Vec<f64>,
    /// Statistics of the horizontal coordinate over all samples.
    pub x_summary: Summary,
    /// Statistics of the vertical coordinate over all samples.
    pub y_summary: Summary,
}

impl XyLoop {
    /// A figure without loops.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            caption: None,
            x,
            y,
            loops: Vec::new(),
            equal_scale: false,
            notes: Vec::new(),
        }
    }

    /// Adds a measured loop.
    #[must_use]
    pub fn measured(self, name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        self.line(Role::Measured, name, x, y)
    }

    /// Adds a simulated loop.
    #[must_use]
    pub fn model(self, name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        self.line(Role::Model, name, x, y)
    }

    /// Adds a loop.
    #[must_use]
    pub fn line(mut self, role: Role, name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        let name = name.into();
        note_lengths(&mut self.notes, &name, y.len(), ("horizontal coordinates", x.len()));
        let n = x.len().min(y.len());
        let (x, y) = (&x[..n], &y[..n]);
        let missing = x.iter().zip(y).filter(|(x, y)| !(x.is_finite() && y.is_finite())).count();
        note_not_finite(&mut self.notes, &name, missing, n);
        let kept = reduce::shape(x, y, CURVE_POINTS);
        let pick = |values: &[f64]| {
            reduce::short(&kept.iter().filter_map(|&i| values.get(i).copied()).collect::<Vec<_>>())
        };
        self.loops.push(Loop {
            name,
            role,
            x: pick(x),
            y: pick(y),
            x_summary: Summary::of(x),
            y_summary: Summary::of(y),
        });
        self
    }

    /// Uses one scale for both axes.
    #[must_use]
    pub fn equal_scale(mut self) -> Self {
        self.equal_scale = true;
        self
    }

    /// Sets the text below the figure.
    #[must_use]
    pub fn caption(mut self, text: impl Into<String>) -> Self {
        self.caption = Some(text.into());
        self
    }
}

//! Signals over one time axis.

use serde::{Deserialize, Serialize};

use super::{
    Axis, Band, Limit, Marker, Role, TIME_POINTS, note_lengths, note_not_finite, push_finite,
};
use crate::number::{format_number, format_unit};
use crate::reduce::{self, Buckets};
use crate::summary::Summary;

/// Signals over one time axis (or lag, or any increasing quantity), in one panel per unit.
///
/// Signals of the same unit share a panel unless [`TimeSeries::panel`] begins a new one. All panels
/// share the time axis and, on the page, zoom and cursor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimeSeries {
    /// The title.
    pub title: String,
    /// A text below the figure.
    pub caption: Option<String>,
    /// What the horizontal axis shows.
    pub x: Axis,
    /// The time series' values: all of them, or two per stretch where samples were left out.
    #[serde(with = "crate::finite")]
    pub time: Vec<f64>,
    /// How many samples each signal had.
    pub samples: usize,
    /// The panels, from top to bottom.
    pub panels: Vec<Panel>,
    /// Stretches of time that are marked.
    pub bands: Vec<Band>,
    /// Points in time that are marked.
    pub markers: Vec<Marker>,
    /// What could not be drawn as given.
    pub notes: Vec<String>,
}

/// Signals that share a vertical axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Panel {
    /// What the vertical axis shows; empty: the unit alone says it.
    pub label: String,
    /// The unit of all its signals; `None` until the first signal comes.
    pub unit: Option<String>,
    /// The signals.
    pub traces: Vec<Trace>,
    /// Horizontal lines.
    pub limits: Vec<Limit>,
}

/// One signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trace {
    /// The trace's name.
    pub name: String,
    /// What the trace stands for.
    pub role: Role,
    /// The trace's values at [`TimeSeries::time`]; where samples were left out, the smallest and the
    /// largest of each stretch in the order in which they occur.
    #[serde(with = "crate::finite")]
    pub values: Vec<f64>,
    /// Statistics over all samples.
    pub summary: Summary,
}

impl TimeSeries {
    /// A figure without signals, over `time` in s.
    pub fn new(title: impl Into<String>, time: &[f64]) -> Self {
        Self::over(title, Axis::new("time", "s"), time)
    }

    /// A figure without signals, over any increasing quantity.
    ///
    /// Values that are not finite or do not increase cannot be an axis: the signals are then drawn
    /// over the sample number, and a note says so.
    pub fn over(title: impl Into<String>, x: Axis, values: &[f64]) -> Self {
        let mut figure = Self {
            title: title.into(),
            caption: None,
            x,
            time: Vec::new(),
            samples: values.len(),
            panels: Vec::new(),
            bands: Vec::new(),
            markers: Vec::new(),
            notes: Vec::new(),
        };
        match first_disorder(values) {
            None => figure.time = figure.reduced_axis(values),
            Some(row) => {
                figure.notes.push(format!(
                    "The {} does not increase at sample {row}; the signals are drawn over the sample number.",
                    figure.x.label
                ));
                figure.x = Axis::new("sample", "");
                let numbers: Vec<f64> = (0..values.len()).map(|i| i as f64).collect();
                figure.time = figure.reduced_axis(&numbers);
            }
        }
        figure
    }

    fn reduced_axis(&self, values: &[f64]) -> Vec<f64> {
        match self.buckets() {
            Some(buckets) => reduce::short(&buckets.times(values)),
            None => values.to_vec(),
        }
    }

    fn buckets(&self) -> Option<Buckets> {
        Buckets::new(self.samples, TIME_POINTS)
    }

    /// Begins a new panel with a label, such as `error`; the next signal gives its unit.
    #[must_use]
    pub fn panel(mut self, label: impl Into<String>) -> Self {
        self.panels.push(Panel {
            label: label.into(),
            unit: None,
            traces: Vec::new(),
            limits: Vec::new(),
        });
        self
    }

    /// Adds a measured signal.
    #[must_use]
    pub fn measured(self, name: impl Into<String>, unit: &str, values: &[f64]) -> Self {
        self.signal(Role::Measured, name, unit, values)
    }

    /// Adds a simulated signal.
    #[must_use]
    pub fn model(self, name: impl Into<String>, unit: &str, values: &[f64]) -> Self {
        self.signal(Role::Model, name, unit, values)
    }

    /// Adds a reference.
    #[must_use]
    pub fn reference(self, name: impl Into<String>, unit: &str, values: &[f64]) -> Self {
        self.signal(Role::Reference, name, unit, values)
    }

    /// Adds an error or residual.
    #[must_use]
    pub fn residual(self, name: impl Into<String>, unit: &str, values: &[f64]) -> Self {
        self.signal(Role::Residual, name, unit, values)
    }

    /// Adds any other signal.
    #[must_use]
    pub fn other(self, name: impl Into<String>, unit: &str, values: &[f64]) -> Self {
        self.signal(Role::Other, name, unit, values)
    }

    /// Adds a signal to the last panel if the unit is the same, else to a new one.
    #[must_use]
    pub fn signal(
        mut self,
        role: Role,
        name: impl Into<String>,
        unit: &str,
        values: &[f64],
    ) -> Self {
        let name = name.into();
        note_lengths(&mut self.notes, &name, values.len(), ("points in time", self.samples));
        let values = values.get(..self.samples).unwrap_or(values);
        let summary = Summary::of(values);
        note_not_finite(&mut self.notes, &name, summary.not_finite, summary.samples);
        if let (Some(min), Some(0.0)) = (summary.min, summary.range())
            && summary.samples > 1
        {
            let value = format_number(min, 6);
            let unit = format_unit(unit);
            self.notes.push(format!("“{name}” is constant: {value} {unit}").trim_end().to_owned());
        }
        let values = match self.buckets() {
            Some(buckets) => reduce::short(&buckets.extremes(values)),
            None => reduce::short(values),
        };
        self.panel_for(unit).traces.push(Trace { name, role, values, summary });
        self
    }

    fn panel_for(&mut self, unit: &str) -> &mut Panel {
        let fits = |panel: &Panel| panel.unit.as_deref().is_none_or(|own| own == unit);
        if !self.panels.last().is_some_and(fits) {
            self.panels.push(Panel {
                label: String::new(),
                unit: None,
                traces: Vec::new(),
                limits: Vec::new(),
            });
        }
        let last = self.panels.len() - 1;
        let panel = &mut self.panels[last];
        panel.unit.get_or_insert_with(|| unit.to_owned());
        panel
    }

    /// Adds a horizontal line to the last panel.
    #[must_use]
    pub fn limit(mut self, value: f64, label: impl Into<String>) -> Self {
        if let Some(panel) = self.panels.last_mut() {
            let limit = Limit { value, label: label.into() };
            push_finite(&mut panel.limits, limit, &mut self.notes);
        }
        self
    }

    /// Marks a stretch of time.
    #[must_use]
    pub fn band(mut self, from: f64, to: f64, label: impl Into<String>) -> Self {
        let band = Band { from, to, label: label.into() };
        push_finite(&mut self.bands, band, &mut self.notes);
        self
    }

    /// Marks a point in time.
    #[must_use]
    pub fn marker(mut self, at: f64, label: impl Into<String>) -> Self {
        push_finite(&mut self.markers, Marker { at, label: label.into() }, &mut self.notes);
        self
    }

    /// Sets the text below the figure.
    #[must_use]
    pub fn caption(mut self, text: impl Into<String>) -> Self {
        self.caption = Some(text.into());
        self
    }
}

/// The first value, counted from 1, that is not finite or not larger than the one before.
fn first_disorder(values: &[f64]) -> Option<usize> {
    let ordered = |pair: &[f64]| pair[0] < pair[1] && pair[1].is_finite();
    match values.first() {
        Some(first) if !first.is_finite() => Some(1),
        _ => values.windows(2).position(|pair| !ordered(pair)).map(|i| i + 2),
    }
}

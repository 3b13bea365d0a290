//! Magnitudes over frequency.

use serde::{Deserialize, Serialize};

use super::{Axis, Band, CURVE_POINTS, Limit, Marker, Role, note_lengths, push_finite};
use crate::reduce;

/// Magnitudes over frequency, both on logarithmic axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Spectrum {
    /// The title.
    pub title: String,
    /// A text below the figure.
    pub caption: Option<String>,
    /// What the vertical axis shows, such as the amplitude density in um/Hz^0.5.
    pub y: Axis,
    /// A linear vertical axis, for values in dB or shares.
    pub linear: bool,
    /// The curves.
    pub traces: Vec<SpectrumTrace>,
    /// Horizontal lines.
    pub limits: Vec<Limit>,
    /// Frequency bands that are marked.
    pub bands: Vec<Band>,
    /// Frequencies that are marked.
    pub markers: Vec<Marker>,
    /// What could not be drawn as given.
    pub notes: Vec<String>,
}

/// One curve of a [`Spectrum`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpectrumTrace {
    /// The spectrum trace's name.
    pub name: String,
    /// What the spectrum trace stands for.
    pub role: Role,
    /// Frequencies of the lines kept, increasing, in Hz.
    pub frequency: Vec<f64>,
    /// Values at these lines.
    pub values: Vec<f64>,
    /// How many lines there were.
    pub lines: usize,
    /// Frequency and value of the largest line.
    pub peak: Option<(f64, f64)>,
}

impl Spectrum {
    /// A figure without curves.
    pub fn new(title: impl Into<String>, y: Axis) -> Self {
        Self {
            title: title.into(),
            caption: None,
            y,
            linear: false,
            traces: Vec::new(),
            limits: Vec::new(),
            bands: Vec::new(),
            markers: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Makes the vertical axis linear; to be called before curves are added.
    #[must_use]
    pub fn linear(mut self) -> Self {
        self.linear = true;
        self
    }

    /// Adds a curve over its own frequencies, in Hz.
    ///
    /// Lines that have no place on the axes (values that are not finite or, on a logarithmic axis,
    /// not positive) are left out, and a note says how many; a line at 0 Hz goes without saying.
    #[must_use]
    pub fn trace(
        mut self,
        role: Role,
        name: impl Into<String>,
        frequency: &[f64],
        values: &[f64],
    ) -> Self {
        let name = name.into();
        note_lengths(&mut self.notes, &name, values.len(), ("frequencies", frequency.len()));
        let lines = frequency.len().min(values.len());
        let drawable = |f: f64, y: f64| on_log(f) && y.is_finite() && (self.linear || y > 0.0);
        let pairs = frequency.iter().copied().zip(values.iter().copied());
        let mut points: Vec<(f64, f64)> = pairs.filter(|&(f, y)| drawable(f, y)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let constant = frequency.iter().take(lines).filter(|f| **f == 0.0).count();
        note_left_out(&mut self.notes, &name, points.len(), lines - constant);
        let (f, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
        let kept = reduce::log_extremes(&f, &[&y], CURVE_POINTS);
        self.traces.push(SpectrumTrace {
            name,
            role,
            frequency: reduce::short_relative(&pick(&f, &kept)),
            values: reduce::short_relative(&pick(&y, &kept)),
            lines,
            peak: points.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)),
        });
        self
    }

    /// Adds the amplitude density of a signal that was sampled every `period` s: Welch's method,
    /// segments that overlap by half, Hann's window; one-sided, in the signal's unit per √Hz.
    #[must_use]
    pub fn density(self, role: Role, name: impl Into<String>, values: &[f64], period: f64) -> Self {
        let (frequency, density) = numerics::spectrum::welch(values, period);
        self.trace(role, name, &frequency, &density)
    }

    /// Adds a horizontal line.
    #[must_use]
    pub fn limit(mut self, value: f64, label: impl Into<String>) -> Self {
        push_finite(&mut self.limits, Limit { value, label: label.into() }, &mut self.notes);
        self
    }

    /// Marks a frequency band, in Hz.
    #[must_use]
    pub fn band(mut self, from: f64, to: f64, label: impl Into<String>) -> Self {
        let band = Band { from, to, label: label.into() };
        push_finite(&mut self.bands, band, &mut self.notes);
        self
    }

    /// Marks a frequency, in Hz.
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

/// Whether a value has a place on a logarithmic axis.
pub(super) fn on_log(x: f64) -> bool {
    x.is_finite() && x > 0.0
}

/// Says how many of the lines are left out, if any.
pub(super) fn note_left_out(notes: &mut Vec<String>, name: &str, drawn: usize, of: usize) {
    if of == 0 {
        notes.push(format!("“{name}” holds no lines; there is nothing to draw."));
    } else if drawn == 0 {
        notes.push(format!("“{name}”: none of its {of} lines can be drawn on these axes."));
    } else if drawn < of {
        notes.push(format!(
            "“{name}”: {} of {of} lines are not drawn (zero, negative or not finite on a logarithmic axis).",
            of - drawn
        ));
    }
}

/// The values at the given indices.
pub(super) fn pick(values: &[f64], indices: &[usize]) -> Vec<f64> {
    indices.iter().filter_map(|&i| values.get(i).copied()).collect()
}

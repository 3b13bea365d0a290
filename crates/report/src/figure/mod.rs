//! Figures: what is drawn, already reduced to what a page can show.

mod bode;
mod histogram;
mod spectrum;
mod time_series;
mod xy_loop;

use serde::{Deserialize, Serialize};

pub use bode::{Bode, Response};
pub use histogram::{Histogram, SampleSet};
pub use spectrum::{Spectrum, SpectrumTrace};
pub use time_series::{Panel, TimeSeries, Trace};
pub use xy_loop::{Loop, XyLoop};

/// Points kept per trace over time; the interactive layer zooms into these.
pub(crate) const TIME_POINTS: usize = 4000;
/// Points kept per loop, spectrum or response.
pub(crate) const CURVE_POINTS: usize = 2000;

/// Any figure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Figure {
    /// Signals over one time axis.
    TimeSeries(TimeSeries),
    /// One quantity over another.
    XyLoop(XyLoop),
    /// Magnitudes over frequency.
    Spectrum(Spectrum),
    /// Frequency responses: magnitude, phase, coherence.
    Bode(Bode),
    /// Counts of values.
    Histogram(Histogram),
}

impl Figure {
    /// The figure's title.
    pub fn title(&self) -> &str {
        match self {
            Self::TimeSeries(figure) => &figure.title,
            Self::XyLoop(figure) => &figure.title,
            Self::Spectrum(figure) => &figure.title,
            Self::Bode(figure) => &figure.title,
            Self::Histogram(figure) => &figure.title,
        }
    }

    /// What could not be drawn as given, one sentence each.
    pub fn notes(&self) -> &[String] {
        match self {
            Self::TimeSeries(figure) => &figure.notes,
            Self::XyLoop(figure) => &figure.notes,
            Self::Spectrum(figure) => &figure.notes,
            Self::Bode(figure) => &figure.notes,
            Self::Histogram(figure) => &figure.notes,
        }
    }

    /// The text below the figure, if any.
    pub fn caption(&self) -> Option<&str> {
        match self {
            Self::TimeSeries(figure) => figure.caption.as_deref(),
            Self::XyLoop(figure) => figure.caption.as_deref(),
            Self::Spectrum(figure) => figure.caption.as_deref(),
            Self::Bode(figure) => figure.caption.as_deref(),
            Self::Histogram(figure) => figure.caption.as_deref(),
        }
    }
}

macro_rules! figure_from {
    ($($kind:ident),*) => {
        $(impl From<$kind> for Figure {
            fn from(figure: $kind) -> Self {
                Self::$kind(figure)
            }
        })*
    };
}
figure_from!(TimeSeries, XyLoop, Spectrum, Bode, Histogram);

/// What an axis shows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Axis {
    /// The quantity, such as `time` or `command`.
    pub label: String,
    /// The axis' unit as the tool writes units; empty for none.
    pub unit: String,
}

impl Axis {
    /// An axis of a quantity in a unit.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into() }
    }
}

/// What a curve stands for; it looks the same in every figure of every report.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Measured on the machine.
    Measured,
    /// Computed by the model.
    Model,
    /// The reference that is to be followed.
    Reference,
    /// A difference: error, residual, gap.
    Residual,
    /// Anything else; curves of this role differ from one another.
    #[default]
    Other,
}

/// A horizontal line: a limit, a tolerance, a noise floor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// The value, in the panel's unit.
    pub value: f64,
    /// What the limit is.
    pub label: String,
}

/// A stretch of the horizontal axis: the held-out part of a log, a frequency band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Where it begins, in the axis' unit.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// What the band is.
    pub label: String,
}

/// A vertical line: an event, a resonance, the mains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// Where it is, in the axis' unit.
    pub at: f64,
    /// What the marker is.
    pub label: String,
}

/// A line or stretch that is drawn over the curves.
pub(crate) trait Annotation {
    /// Whether it has a place on an axis.
    fn is_finite(&self) -> bool;
    /// What the annotation is.
    fn label(&self) -> &str;
}

impl Annotation for Limit {
    fn is_finite(&self) -> bool {
        self.value.is_finite()
    }
    fn label(&self) -> &str {
        &self.label
    }
}

impl Annotation for Marker {
    fn is_finite(&self) -> bool {
        self.at.is_finite()
    }
    fn label(&self) -> &str {
        &self.label
    }
}

impl Annotation for Band {
    fn is_finite(&self) -> bool {
        self.from.is_finite() && self.to.is_finite()
    }
    fn label(&self) -> &str {
        &self.label
    }
}

/// Keeps an annotation that has a place on the axis, and says so if it has none.
pub(crate) fn push_finite<T: Annotation>(list: &mut Vec<T>, item: T, notes: &mut Vec<String>) {
    if item.is_finite() {
        list.push(item);
    } else {
        notes.push(format!("The mark “{}” is not drawn: its place is not finite.", item.label()));
    }
}

/// Says how many values are left out, if any.
pub(crate) fn note_not_finite(notes: &mut Vec<String>, name: &str, missing: usize, of: usize) {
    if of == 0 {
        notes.push(format!("“{name}” holds no samples; there is nothing to draw."));
    } else if missing == of {
        notes.push(format!("“{name}”: none of its {of} samples is a finite number."));
    } else if missing > 0 {
        notes.push(format!(
            "“{name}”: {missing} of {of} samples are not finite numbers; they are drawn as gaps and left out of the statistics."
        ));
    }
}

/// Says that two lists should have been equally long.
pub(crate) fn note_lengths(notes: &mut Vec<String>, name: &str, values: usize, of: (&str, usize)) {
    if values != of.1 {
        notes.push(format!(
            "“{name}” holds {values} values for {} {}; only the first {} are drawn.",
            of.1,
            of.0,
            values.min(of.1)
        ));
    }
}

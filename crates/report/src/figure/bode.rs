//! Frequency responses.

use serde::{Deserialize, Serialize};

use super::spectrum::{note_left_out, on_log, pick};
use super::{Band, CURVE_POINTS, Marker, Role, note_lengths, push_finite};
use crate::reduce;

/// Frequency responses: magnitude and phase, and the coherence where it is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bode {
    /// The title.
    pub title: String,
    /// A text below the figure.
    pub caption: Option<String>,
    /// Unit of the magnitude, such as `um/V`.
    pub unit: String,
    /// The responses.
    pub responses: Vec<Response>,
    /// Frequency bands that are marked.
    pub bands: Vec<Band>,
    /// Frequencies that are marked.
    pub markers: Vec<Marker>,
    /// What could not be drawn as given.
    pub notes: Vec<String>,
}

/// One frequency response.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// The response's name.
    pub name: String,
    /// What the response stands for.
    pub role: Role,
    /// Frequencies of the lines kept, increasing, in Hz.
    pub frequency: Vec<f64>,
    /// Magnitudes, in the figure's unit.
    pub magnitude: Vec<f64>,
    /// Phases, in rad, as given: unwrapped or not.
    #[serde(with = "crate::finite")]
    pub phase: Vec<f64>,
    /// Magnitude-squared coherence, 0…1.
    #[serde(with = "crate::finite::optional")]
    pub coherence: Option<Vec<f64>>,
    /// How many lines there were.
    pub lines: usize,
    /// Frequency and value of the largest magnitude.
    pub peak: Option<(f64, f64)>,
    /// Frequency and value of the smallest coherence.
    pub least_coherence: Option<(f64, f64)>,
}

impl Bode {
    /// A figure without responses; `unit` is that of the magnitude.
    pub fn new(title: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            caption: None,
            unit: unit.into(),
            responses: Vec::new(),
            bands: Vec::new(),
            markers: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Adds a response over its own frequencies: `frequency` in Hz, `phase` in rad, `coherence`
    /// as magnitude squared.
    ///
    /// Lines without a positive, finite frequency and magnitude are left out, and a note says how
    /// many; a line at 0 Hz goes without saying.
    #[must_use]
    pub fn response(
        mut self,
        role: Role,
        name: impl Into<String>,
        frequency: &[f64],
        magnitude: &[f64],
        phase: &[f64],
        coherence: Option<&[f64]>,
    ) -> Self {
        let name = name.into();
        let lengths = [magnitude.len(), phase.len(), coherence.map_or(usize::MAX, <[f64]>::len)];
        let lines = lengths.into_iter().fold(frequency.len(), usize::min);
        for values in [Some(magnitude), Some(phase), coherence].into_iter().flatten() {
            note_lengths(&mut self.notes, &name, values.len(), ("frequencies", frequency.len()));
        }
        let mut order: Vec<usize> =
            (0..lines).filter(|&i| on_log(frequency[i]) && on_log(magnitude[i])).collect();
        order.sort_by(|&a, &b| frequency[a].total_cmp(&frequency[b]));
        let constant = frequency.iter().take(lines).filter(|f| **f == 0.0).count();
        note_left_out(&mut self.notes, &name, order.len(), lines - constant);
        let f = pick(frequency, &order);
        let magnitude = pick(magnitude, &order);
        let phase = pick(phase, &order);
        let coherence = coherence.map(|values| pick(values, &order));
        self.responses.push(Response::reduced(name, role, lines, f, magnitude, phase, coherence));
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

impl Response {
    /// Keeps the lines that matter; all lists are equally long and sorted by frequency.
    fn reduced(
        name: String,
        role: Role,
        lines: usize,
        frequency: Vec<f64>,
        magnitude: Vec<f64>,
        phase: Vec<f64>,
        coherence: Option<Vec<f64>>,
    ) -> Self {
        let mut curves: Vec<&[f64]> = vec![&magnitude, &phase];
        curves.extend(coherence.as_deref());
        let kept = reduce::log_extremes(&frequency, &curves, CURVE_POINTS);
        let finite_pairs = |values: &[f64]| -> Vec<(f64, f64)> {
            let pairs = frequency.iter().copied().zip(values.iter().copied());
            pairs.filter(|(_, y)| y.is_finite()).collect()
        };
        let by_value = |a: &(f64, f64), b: &(f64, f64)| a.1.total_cmp(&b.1);
        Self {
            name,
            role,
            lines,
            peak: finite_pairs(&magnitude).into_iter().max_by(by_value),
            least_coherence: coherence
                .as_deref()
                .and_then(|values| finite_pairs(values).into_iter().min_by(by_value)),
            frequency: reduce::short_relative(&pick(&frequency, &kept)),
            magnitude: reduce::short_relative(&pick(&magnitude, &kept)),
            phase: reduce::short(&pick(&phase, &kept)),
            coherence: coherence.map(|values| reduce::short_relative(&pick(&values, &kept))),
        }
    }
}

//! Counts of values.

use serde::{Deserialize, Serialize};

use super::{Axis, Marker, Role, note_not_finite, push_finite};
use crate::summary::Summary;

/// Most bins of a histogram.
const MAX_BINS: usize = 60;

/// How often values fall into bins of equal width, for one or more sets of values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    /// The title.
    pub title: String,
    /// A text below the figure.
    pub caption: Option<String>,
    /// What is counted.
    pub x: Axis,
    /// Edges of the bins, increasing; one more than there are bins. A value on an inner edge
    /// belongs to the bin above it.
    pub edges: Vec<f64>,
    /// The sets.
    pub sets: Vec<SampleSet>,
    /// Values that are marked, such as a limit.
    pub markers: Vec<Marker>,
    /// What could not be drawn as given.
    pub notes: Vec<String>,
}

/// One set of values of a [`Histogram`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SampleSet {
    /// The sample set's name.
    pub name: String,
    /// What the sample set stands for.
    pub role: Role,
    /// Values per bin.
    pub counts: Vec<usize>,
    /// Statistics over all values.
    pub summary: Summary,
}

impl Histogram {
    /// Counts the values of all sets in common bins.
    ///
    /// The bin width follows Freedman and Diaconis (1981), 2 IQR n^(-1/3), of all values together,
    /// with at most 60 bins.
    pub fn new(title: impl Into<String>, x: Axis, sets: &[(Role, &str, &[f64])]) -> Self {
        let mut notes = Vec::new();
        let mut pooled: Vec<f64> = Vec::new();
        for (_, name, values) in sets {
            let before = pooled.len();
            pooled.extend(values.iter().filter(|x| x.is_finite()));
            let missing = values.len() - (pooled.len() - before);
            note_not_finite(&mut notes, name, missing, values.len());
        }
        pooled.sort_by(f64::total_cmp);
        let edges = bin_edges(&pooled);
        let sets = sets
            .iter()
            .map(|(role, name, values)| SampleSet {
                name: (*name).to_owned(),
                role: *role,
                counts: count(&edges, values),
                summary: Summary::of(values),
            })
            .collect();
        Self { title: title.into(), caption: None, x, edges, sets, markers: Vec::new(), notes }
    }

    /// Marks a value.
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

/// Edges of the bins over sorted, finite values; none without values.
fn bin_edges(sorted: &[f64]) -> Vec<f64> {
    let (Some(&low), Some(&high)) = (sorted.first(), sorted.last()) else {
        return Vec::new();
    };
    let span = high - low;
    if span < f64::MIN_POSITIVE || !span.is_finite() {
        // All values are equal (or span more than a double can hold): one bin around them.
        let half = if low.abs() < f64::MIN_POSITIVE {
            0.5
        } else {
            (low.abs() / 2.0).max(high.abs() / 2.0)
        };
        return [low - half, high + half].map(|edge| edge.clamp(-f64::MAX, f64::MAX)).to_vec();
    }
    let quantile = |q: f64| sorted[((sorted.len() - 1) as f64 * q).round() as usize];
    let width = 2.0 * (quantile(0.75) - quantile(0.25)) / (sorted.len() as f64).cbrt();
    let wanted = if width > 0.0 { (span / width).ceil() } else { MAX_BINS as f64 };
    let bins = (wanted.clamp(1.0, MAX_BINS as f64) as usize).max(1);
    (0..=bins).map(|k| low + span * (k as f64 / bins as f64)).collect()
}

fn count(edges: &[f64], values: &[f64]) -> Vec<usize> {
    let bins = edges.len().saturating_sub(1);
    let mut counts = vec![0; bins];
    for value in values.iter().filter(|x| x.is_finite()) {
        let above = edges.partition_point(|edge| edge <= value);
        let bin = above.saturating_sub(1).min(bins.saturating_sub(1));
        if let Some(slot) = counts.get_mut(bin) {
            *slot += 1;
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn histogram(values: &[f64]) -> Histogram {
        Histogram::new("h", Axis::new("error", "um"), &[(Role::Residual, "e", values)])
    }

    #[test]
    fn every_finite_value_is_counted_once() {
        let values: Vec<f64> = (0..1000).map(|i| f64::from(i * i % 997)).collect();
        let figure = histogram(&values);
        assert_eq!(figure.sets[0].counts.iter().sum::<usize>(), 1000);
        assert!(figure.edges.len() > 5 && figure.edges.len() <= MAX_BINS + 1);
    }

    #[test]
    fn degenerate_values_have_a_bin_or_none() {
        assert_eq!(histogram(&[3.0; 5]).sets[0].counts, [5]);
        assert_eq!(histogram(&[0.0]).edges, [-0.5, 0.5]);
        assert!(histogram(&[]).edges.is_empty());
        assert_eq!(histogram(&[f64::NAN]).notes.len(), 1);
        assert_eq!(histogram(&[-1e308, 1e308]).sets[0].counts.iter().sum::<usize>(), 2);
        assert_eq!(histogram(&[0.0, 0.0, 0.0, 0.0, 9.0]).sets[0].counts.len(), MAX_BINS);
    }
}

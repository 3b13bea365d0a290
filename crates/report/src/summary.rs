//! Statistics of a signal, over all its samples.

use serde::{Deserialize, Serialize};

/// Statistics of a signal over all its samples, in the signal's unit.
///
/// They are taken before anything is left out for drawing. Without a finite sample, or where a sum
/// exceeds the range of a double, the value is `None`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Number of samples.
    pub samples: usize,
    /// How many of them are not finite; they are left out of everything below.
    pub not_finite: usize,
    /// Smallest value.
    pub min: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
    /// Arithmetic mean.
    pub mean: Option<f64>,
    /// Root of the mean square.
    pub rms: Option<f64>,
    /// Standard deviation about the mean (divided by n).
    pub std: Option<f64>,
}

impl Summary {
    /// The statistics of `values`.
    pub fn of(values: &[f64]) -> Self {
        let finite = || values.iter().copied().filter(|x| x.is_finite());
        let n = finite().count();
        let mut summary =
            Self { samples: values.len(), not_finite: values.len() - n, ..Self::default() };
        if n == 0 {
            return summary;
        }
        let mean_of = |sum: f64| sum / n as f64;
        let mean = mean_of(finite().sum());
        let keep = |x: f64| x.is_finite().then_some(x);
        summary.min = finite().reduce(f64::min);
        summary.max = finite().reduce(f64::max);
        summary.mean = keep(mean);
        summary.rms = keep(mean_of(finite().map(|x| x * x).sum()).sqrt());
        summary.std = keep(mean_of(finite().map(|x| (x - mean) * (x - mean)).sum()).sqrt());
        summary
    }

    /// Largest minus smallest value.
    pub fn range(&self) -> Option<f64> {
        Some(self.max? - self.min?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_statistics() {
        let summary = Summary::of(&[1.0, f64::NAN, 3.0, f64::INFINITY]);
        assert_eq!((summary.samples, summary.not_finite), (4, 2));
        assert_eq!((summary.min, summary.max, summary.mean), (Some(1.0), Some(3.0), Some(2.0)));
        assert_eq!((summary.rms, summary.std), (Some(5.0_f64.sqrt()), Some(1.0)));
        assert_eq!(summary.range(), Some(2.0));
    }

    #[test]
    fn nothing_finite_gives_nothing() {
        assert_eq!(Summary::of(&[]), Summary::default());
        assert_eq!(Summary::of(&[f64::NAN]).mean, None);
        assert_eq!(Summary::of(&[1e308, 1e308]).mean, None);
    }
}

//! Figures of agreement between a measured and a simulated signal.

/// Figures of agreement over one window of N samples. With the measured signal y, the simulated one
/// ŷ and the error `e_k = ŷ_k − y_k`:
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Number of samples N.
    pub samples: usize,
    /// Mean error `b = (1/N)·Σ e_k`: the one constant that is taken out of the figures below, in the
    /// signal's unit.
    pub offset: f64,
    /// Root mean square of what remains, `sqrt((1/N)·Σ (e_k − b)²)`, in the signal's unit.
    pub rmse: f64,
    /// Greatest remainder `max |e_k − b|`, in the signal's unit.
    pub max_error: f64,
    /// Range of the measured signal in the window, `max y − min y`, in its unit.
    pub range: f64,
    /// `rmse / range`; not a number where the measured signal is constant.
    pub nrmse: f64,
    /// Share of the signal that is explained, in percent:
    /// `100·(1 − ‖e − b‖ / ‖y − ȳ‖)`; 100 for a perfect model, 0 for a constant, negative for worse;
    /// not a number where the measured signal is constant.
    pub fit_percent: f64,
    /// Root mean square error with the offset left in, `sqrt((1/N)·Σ e_k²)`.
    pub raw_rmse: f64,
}

/// Why two signals cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// Two lengths.
    #[error(
        "the measured signal has {measured} samples, the simulated one {simulated}; compare the same rows"
    )]
    Lengths {
        /// Samples of the measured signal.
        measured: usize,
        /// Samples of the simulated signal.
        simulated: usize,
    },
    /// No samples.
    #[error("the window has no samples; choose one inside the log")]
    Empty,
    /// A value that is not finite.
    #[error("sample {index} of the window (from 1) is not finite; leave it out")]
    NotFinite {
        /// The not finite's number, from 1.
        index: usize,
    },
}

impl Fit {
    /// Compares two signals of the same length and unit.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn of(measured: &[f64], simulated: &[f64]) -> Result<Self, FitError> {
        let samples = measured.len();
        if samples != simulated.len() {
            return Err(FitError::Lengths { measured: samples, simulated: simulated.len() });
        }
        if samples == 0 {
            return Err(FitError::Empty);
        }
        let pairs = || measured.iter().zip(simulated);
        if let Some(at) = pairs().position(|(y, s)| !y.is_finite() || !s.is_finite()) {
            return Err(FitError::NotFinite { index: at + 1 });
        }
        let n = samples as f64;
        let errors = || pairs().map(|(y, s)| s - y);
        let offset = errors().sum::<f64>() / n;
        let squares: f64 = errors().map(|e| (e - offset).powi(2)).sum();
        let raw: f64 = errors().map(|e| e * e).sum();
        let mean = measured.iter().sum::<f64>() / n;
        let spread: f64 = measured.iter().map(|y| (y - mean).powi(2)).sum();
        let max = measured.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let range = max - measured.iter().copied().fold(f64::INFINITY, f64::min);
        let rmse = (squares / n).sqrt();
        let is_constant = range == 0.0;
        Ok(Self {
            samples,
            offset,
            rmse,
            max_error: errors().map(|e| (e - offset).abs()).fold(0.0, f64::max),
            range,
            nrmse: if is_constant { f64::NAN } else { rmse / range },
            fit_percent: if is_constant {
                f64::NAN
            } else {
                100.0 * (1.0 - (squares / spread).sqrt())
            },
            raw_rmse: (raw / n).sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * b.abs().max(1.0)
    }

    #[test]
    fn figures_of_a_hand_calculation() {
        // e = 1, 3: offset 2, remainders −1 and 1; y = 0, 4: mean 2, ‖y − ȳ‖ = √8.
        let fit = Fit::of(&[0.0, 4.0], &[1.0, 7.0]).unwrap();
        assert_eq!((fit.samples, fit.offset, fit.rmse, fit.max_error), (2, 2.0, 1.0, 1.0));
        assert_eq!((fit.range, fit.nrmse), (4.0, 0.25));
        assert!(close(fit.fit_percent, 50.0));
        assert!(close(fit.raw_rmse, 5.0_f64.sqrt()));
    }

    #[test]
    fn a_constant_offset_is_no_error() {
        let y = [0.0, 1.0, -2.0, 5.0];
        let fit = Fit::of(&y, &y.map(|y| y + 3.0)).unwrap();
        assert_eq!((fit.offset, fit.rmse, fit.fit_percent), (3.0, 0.0, 100.0));
    }

    #[test]
    fn a_constant_model_explains_nothing() {
        let fit = Fit::of(&[1.0, 2.0, 6.0], &[3.0; 3]).unwrap();
        assert!(fit.fit_percent.abs() < 1e-12);
    }

    #[test]
    fn a_constant_measurement_has_no_relative_figures() {
        let fit = Fit::of(&[2.0; 3], &[1.0, 2.0, 3.0]).unwrap();
        assert!(fit.nrmse.is_nan() && fit.fit_percent.is_nan() && fit.range == 0.0);
    }

    #[test]
    fn refuses_what_cannot_be_compared() {
        let lengths = FitError::Lengths { measured: 1, simulated: 0 };
        assert_eq!(Fit::of(&[1.0], &[]), Err(lengths));
        assert_eq!(Fit::of(&[], &[]), Err(FitError::Empty));
        let index = 2;
        assert_eq!(Fit::of(&[1.0, f64::NAN], &[1.0, 1.0]), Err(FitError::NotFinite { index }));
    }
}

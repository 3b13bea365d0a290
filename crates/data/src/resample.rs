//! Signals on uniform grids, and from one grid to another.

/// A signal on the grid `start + k·period`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uniform<'a> {
    /// Time of the first value in s.
    pub start: f64,
    /// Sample time in s.
    pub period: f64,
    /// The values.
    pub values: &'a [f64],
}

/// What a signal does between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// Keeps its value until the next sample: commands.
    Zero,
    /// Goes straight to the next sample: measured positions.
    Linear,
}

/// Why a signal cannot be resampled.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ResampleError {
    /// A period that is not positive, or a start that is not finite.
    #[error(
        "a grid from {start} s with a sample time of {period} s is none; give finite times and a positive sample time"
    )]
    Grid {
        /// Start in s.
        start: f64,
        /// Sample time in s.
        period: f64,
    },
    /// The new grid reaches beyond the signal.
    #[error(
        "the time {time} s lies outside the signal, {first} s to {last} s; choose a grid inside"
    )]
    Outside {
        /// The first time outside, in s.
        time: f64,
        /// First time of the signal in s.
        first: f64,
        /// Last time at which the signal is known, in s.
        last: f64,
    },
}

/// Parts of a sample time by which two instants may differ and still be the same.
const SAME: f64 = 1e-9;

impl Uniform<'_> {
    /// `count` values on the grid `start + k·period`.
    ///
    /// The signal is known from its first sample to its last one, and with [`Hold::Zero`] for one
    /// sample time more. An instant within 1e-9 sample times of a sample is that sample, so that
    /// rounding neither delays a held value nor changes one bit on the same grid. There is no
    /// filter: resampling to a longer sample time folds whatever is faster.
    ///
    /// # Errors
    /// [`ResampleError`].
    pub fn onto(
        &self,
        start: f64,
        period: f64,
        count: usize,
        hold: Hold,
    ) -> Result<Vec<f64>, ResampleError> {
        for (start, period) in [(self.start, self.period), (start, period)] {
            if !(start.is_finite() && period.is_finite() && period > 0.0) {
                return Err(ResampleError::Grid { start, period });
            }
        }
        let times = (0..count).map(|k| start + k as f64 * period);
        times.map(|time| self.at(time, hold).ok_or_else(|| self.outside(time, hold))).collect()
    }

    /// The value at `time`, `None` outside.
    fn at(&self, time: f64, hold: Hold) -> Option<f64> {
        let position = (time - self.start) / self.period;
        let nearest = position.round();
        if nearest >= 0.0 && (position - nearest).abs() <= SAME {
            if let Some(value) = self.values.get(nearest as usize) {
                return Some(*value);
            }
            return None;
        }
        if position < 0.0 {
            return None;
        }
        let index = position as usize;
        let value = *self.values.get(index)?;
        match hold {
            Hold::Zero => Some(value),
            Hold::Linear => {
                let next = *self.values.get(index + 1)?;
                Some(value + (position - index as f64) * (next - value))
            }
        }
    }

    fn outside(&self, time: f64, hold: Hold) -> ResampleError {
        let steps = self.values.len() as f64 - if hold == Hold::Zero { 0.0 } else { 1.0 };
        ResampleError::Outside { time, first: self.start, last: self.start + steps * self.period }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RAMP: Uniform<'static> =
        Uniform { start: 1.0, period: 0.1, values: &[0.0, 1.0, 2.0, 3.0] };

    #[test]
    fn the_same_grid_returns_the_same_bits() {
        let odd = [0.1 + 0.2, 1.0 / 3.0, 1e-300];
        let signal = Uniform { start: 0.3, period: 0.1, values: &odd };
        assert_eq!(signal.onto(0.3, 0.1, 3, Hold::Linear), Ok(odd.to_vec()));
        // 0.3 + 2·0.1 is not the double 0.5, and still the same instant.
        assert_eq!(signal.onto(0.5, 0.1, 1, Hold::Zero), Ok(vec![odd[2]]));
    }

    #[test]
    fn holds_and_interpolates() {
        let held = RAMP.onto(1.0, 0.05, 8, Hold::Zero).unwrap();
        assert_eq!(held, [0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0]);
        let straight = RAMP.onto(1.0, 0.05, 7, Hold::Linear).unwrap();
        for (k, value) in straight.iter().enumerate() {
            assert!((value - 0.5 * k as f64).abs() < 1e-12, "{k}: {value}");
        }
    }

    #[test]
    fn reports_what_lies_outside() {
        assert!(RAMP.onto(1.0, 0.05, 9, Hold::Zero).is_err());
        assert!(RAMP.onto(1.0, 0.05, 8, Hold::Linear).is_err());
        assert!(RAMP.onto(0.9, 0.1, 1, Hold::Zero).is_err());
        assert!(RAMP.onto(1.0, 0.0, 1, Hold::Zero).is_err());
        assert!(RAMP.onto(f64::NAN, 0.1, 1, Hold::Zero).is_err());
        let error = RAMP.onto(1.0, 0.1, 5, Hold::Linear).unwrap_err().to_string();
        assert!(error.starts_with("the time 1.4 s lies outside the signal, 1 s to 1.3"), "{error}");
    }
}

//! Communication points.

use crate::problem::Problem;

/// A step that misses a whole number of steps by less than this part of a step counts as whole.
const ROUNDING: f64 = 1e-6;

/// The communication points t_0 < t_1 < … < t_N of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Points<'a> {
    /// t_n = start + n·step (multiplied, never accumulated); the last one is `stop` exactly.
    Uniform {
        /// t_0, s.
        start: f64,
        /// t_N, s.
        stop: f64,
        /// The step, s.
        step: f64,
        /// N.
        steps: usize,
    },
    /// The rows of a table.
    Rows(&'a [f64]),
}

impl<'a> Points<'a> {
    /// Points from `start` to `stop`, `step` apart; the last step is shorter if the span is not a
    /// whole number of steps.
    pub fn uniform(start: f64, stop: f64, step: f64) -> Result<Points<'static>, Problem> {
        if !(start.is_finite() && stop.is_finite() && step.is_finite() && step > 0.0) {
            return Err(Problem::Time(format!(
                "start {start} s, stop {stop} s, step {step} s: all must be finite and the step \
                 greater than 0"
            )));
        }
        let count = (stop - start) / step;
        if !(0.0..=9e15).contains(&count) {
            return Err(Problem::Time(format!(
                "from {start} s to {stop} s in steps of {step} s is not a run: the stop time must \
                 not be before the start time, nor more than 9e15 steps away"
            )));
        }
        let steps = (count - ROUNDING).ceil().max(0.0) as usize;
        Ok(Points::Uniform { start, stop, step, steps })
    }

    /// The times of a table's rows, which must be finite and strictly increasing.
    pub fn rows(times: &'a [f64]) -> Result<Self, Problem> {
        if let Some(row) = times.iter().position(|t| !t.is_finite()) {
            let time = times[row];
            return Err(Problem::Time(format!(
                "row {row} has the time {time}, which is no number"
            )));
        }
        if let Some(row) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
            return Err(Problem::Time(format!(
                "time must increase from row to row, but row {row} is at {} s and the next at {} s",
                times[row],
                times[row + 1]
            )));
        }
        match times {
            [] => Err(Problem::Time("there is no row, so there is no start time".to_owned())),
            times => Ok(Points::Rows(times)),
        }
    }

    /// N, the number of steps; there are N + 1 points.
    pub fn steps(&self) -> usize {
        match self {
            Points::Uniform { steps, .. } => *steps,
            Points::Rows(times) => times.len().saturating_sub(1),
        }
    }

    /// t_n in s; beyond the end the last point.
    #[inline]
    pub fn at(&self, n: usize) -> f64 {
        match self {
            Points::Uniform { start, stop, step, steps } => {
                if n < *steps {
                    start + n as f64 * step
                } else {
                    *stop
                }
            }
            Points::Rows(times) => times.get(n).or(times.last()).copied().unwrap_or(f64::NAN),
        }
    }

    /// Start of the run, s.
    pub fn start(&self) -> f64 {
        self.at(0)
    }

    /// End of the run, s.
    pub fn stop(&self) -> f64 {
        self.at(self.steps())
    }

    /// The one step, if all steps are equal but for the rounding of the times; else what is not.
    pub fn equal_steps(&self) -> Result<f64, String> {
        let steps = self.steps();
        let nominal = match self {
            Points::Uniform { step, .. } => *step,
            Points::Rows(_) => (self.stop() - self.start()) / steps.max(1) as f64,
        };
        let unequal = (0..steps).find(|n| {
            let h = self.at(n + 1) - self.at(*n);
            (h - nominal).abs() > ROUNDING * nominal
        });
        match unequal {
            None => Ok(nominal),
            Some(n) => Err(format!(
                "the step from {} s to {} s differs from {nominal} s",
                self.at(n),
                self.at(n + 1)
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_multiplied_and_the_last_is_exact() {
        let points = Points::uniform(0.5, 0.8, 0.1).unwrap();
        let times: Vec<f64> = (0..=points.steps()).map(|n| points.at(n)).collect();
        assert_eq!(times, [0.5, 0.5 + 0.1, 0.5 + 2.0 * 0.1, 0.8]);
        assert_eq!(points.equal_steps(), Ok(0.1));
    }

    #[test]
    fn a_remainder_makes_a_shorter_last_step() {
        let points = Points::uniform(0.0, 0.25, 0.1).unwrap();
        assert_eq!((points.steps(), points.at(2), points.at(3)), (3, 0.2, 0.25));
        assert!(points.equal_steps().unwrap_err().contains("from 0.2 s to 0.25 s"));
    }

    #[test]
    fn a_run_may_have_no_length() {
        assert_eq!(Points::uniform(1.0, 1.0, 0.1).unwrap().steps(), 0);
        assert_eq!(Points::rows(&[3.0]).unwrap().steps(), 0);
    }

    #[test]
    fn nonsense_is_refused() {
        for (start, stop, step) in
            [(0.0, 1.0, 0.0), (0.0, 1.0, -0.1), (1.0, 0.0, 0.1), (0.0, f64::NAN, 0.1)]
        {
            assert!(Points::uniform(start, stop, step).is_err(), "{start} {stop} {step}");
        }
        assert!(Points::rows(&[]).is_err());
        assert!(Points::rows(&[0.0, 0.0]).is_err());
        assert!(Points::rows(&[0.0, f64::INFINITY]).is_err());
    }
}

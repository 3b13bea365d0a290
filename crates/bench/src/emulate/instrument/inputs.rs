//! Input signals of an emulated controller: the sensors of its axes, then as many analog inputs. Each can give the
//! target of an axis, in place of every other source.
//!
//! ```text
//! normalized = 10 · volts, from −100 to 100;  scaled = offset + gain · normalized
//! target of the axis = scaled + analog target offset
//! ```
//!
//! As delivered an analog input spans the travel of its axis. One to which nothing is led is wired to a second sensor.
//!
//! Source: PI, E-727 user manual E727T0005, pages 87 to 93.

use super::Travel;

/// Most volts at an analog input.
const MOST_VOLTS: f64 = 10.0;

/// What is led to the analog inputs: voltages over time, each held until the next, again and again.
#[derive(Clone, Debug, PartialEq)]
pub struct Signals {
    /// Time between two values in s.
    pub period: f64,
    /// In V, a column for each analog input; at those behind the last there are 0 V.
    pub columns: Vec<Vec<f64>>,
}

impl Signals {
    fn at(&self, input: usize, seconds: f64) -> f64 {
        let Some(column) = self.columns.get(input).filter(|column| !column.is_empty()) else {
            return 0.0;
        };
        // Rows lie on multiples of the period, to the digits of a product.
        let row = (seconds / self.period + 1e-6) as u64 % column.len() as u64;
        column[row as usize].clamp(-MOST_VOLTS, MOST_VOLTS)
    }
}

/// How the inputs are used: lost at power-off where it is not saved.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Usage {
    /// Offset and gain of each input signal.
    pub(super) scales: Vec<[f64; 2]>,
    /// Of each axis: the number of the input signal that gives its target; 0: none does.
    pub(super) sources: Vec<usize>,
    /// Of each axis: what is added to that.
    pub(super) offsets: Vec<f64>,
}

/// The input signals.
#[derive(Clone, Debug)]
pub(super) struct Inputs {
    pub(super) signals: Option<Signals>,
    pub(super) now: Usage,
    pub(super) saved: Usage,
}

impl Inputs {
    pub(super) fn new(travel: &[Travel]) -> Self {
        let scale = |travel: &Travel| {
            let [least, greatest] = travel.range();
            [0.5 * (least + greatest), 0.005 * (greatest - least)]
        };
        let scales: Vec<[f64; 2]> = travel.iter().chain(travel).map(scale).collect();
        let axes = travel.len();
        let now = Usage { scales, sources: vec![0; axes], offsets: vec![0.0; axes] };
        Inputs { signals: None, saved: now.clone(), now }
    }

    /// What is led to an analog input, from 0, in V; nothing: 0 V.
    pub(super) fn volts(&self, input: usize, seconds: f64) -> f64 {
        self.signals.as_ref().map_or(0.0, |signals| signals.at(input, seconds))
    }

    /// An analog input, from 0, normalized: what is led to it, or a second sensor.
    pub(super) fn normalized(&self, input: usize, seconds: f64, sensor: f64) -> f64 {
        self.signals.as_ref().map_or(sensor, |signals| 10.0 * signals.at(input, seconds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voltages_are_held_and_repeated() {
        let signals = Signals { period: 0.1, columns: vec![vec![1.0, -20.0, 3.0]] };
        let at = |seconds: f64| signals.at(0, seconds);
        assert_eq!([0.0, 0.05, 0.1, 0.3, 0.5].map(at), [1.0, 1.0, -10.0, 1.0, 3.0]);
        assert_eq!((at(3.0 * 0.1), signals.at(1, 0.0)), (1.0, 0.0));
    }
}

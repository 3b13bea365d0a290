//! Signals from outside: tables of inputs over time.

use modeldescription::description::Unit;

use crate::problem::Problem;
use crate::time::Points;

/// One record of a table: columns over time. Row k acts from t_k until t_{k+1} (zero-order hold),
/// the first also before and the last also after.
#[derive(Clone, Debug, Default)]
pub struct Signals<'a> {
    /// Times of the rows in s, strictly increasing.
    pub time: &'a [f64],
    /// The columns.
    pub columns: Vec<Signal<'a>>,
}

/// One column of a table.
#[derive(Clone, Debug)]
pub struct Signal<'a> {
    /// The signal's name.
    pub name: String,
    /// The signal's unit, if known; without one the values are in the unit of the variable they feed.
    pub unit: Option<Unit>,
    /// One value per row.
    pub values: &'a [f64],
}

impl<'a> Signals<'a> {
    /// A table without columns.
    pub fn new(time: &'a [f64]) -> Self {
        Signals { time, columns: Vec::new() }
    }

    /// Adds a column.
    pub fn with(mut self, name: impl Into<String>, values: &'a [f64]) -> Self {
        self.columns.push(Signal { name: name.into(), unit: None, values });
        self
    }

    /// Everything that is wrong with the table.
    pub(crate) fn problems(&self, record: usize) -> Vec<Problem> {
        let mut problems = Vec::new();
        let mut add = |what: String| problems.push(Problem::Table { record, what });
        if let Err(problem) = Points::rows(self.time) {
            add(problem.to_string());
        }
        for column in &self.columns {
            let (rows, values) = (self.time.len(), column.values.len());
            if rows != values {
                add(format!("column `{}` has {values} values for {rows} rows", column.name));
            }
            if let Some(row) = column.values.iter().position(|value| !value.is_finite()) {
                let value = column.values[row];
                add(format!(
                    "column `{}` is {value} in row {row}; every value must be finite",
                    column.name
                ));
            }
        }
        problems
    }
}

/// Rounding of times, as a part of the distance of two rows.
const ROUNDING: f64 = 1e-9;

/// Reads some columns of a table along a run that goes forward.
pub(crate) struct Held<'a> {
    time: &'a [f64],
    columns: Vec<&'a [f64]>,
    row: usize,
}

impl<'a> Held<'a> {
    pub(crate) fn new(time: &'a [f64], columns: Vec<&'a [f64]>) -> Self {
        Held { time, columns, row: 0 }
    }

    /// The values that act from `time` on. A row whose time is reached but for rounding is reached.
    #[inline]
    pub(crate) fn at(&mut self, time: f64, values: &mut [f64]) {
        while let Some([now, next]) = self.time.get(self.row..self.row + 2) {
            if next - time > ROUNDING * (next - now) {
                break;
            }
            self.row += 1;
        }
        for (value, column) in values.iter_mut().zip(&self.columns) {
            if let Some(held) = column.get(self.row) {
                *value = *held;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_held() {
        let mut held = Held::new(&[0.0, 0.1, 0.3], vec![&[1.0, 2.0, 3.0]]);
        let expected = [(-1.0, 1.0), (0.0, 1.0), (0.05, 1.0), (0.1, 2.0), (0.2, 2.0), (0.3, 3.0)];
        for (t, u) in expected.into_iter().chain([(9.0, 3.0)]) {
            let mut value = [0.0];
            held.at(t, &mut value);
            assert_eq!(value, [u], "at {t}");
        }
    }

    #[test]
    fn an_ulp_too_early_is_not_too_early() {
        let time: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-4).collect();
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        let mut held = Held::new(&time, vec![&values]);
        for (t, u) in time.iter().zip(&values) {
            let mut value = [0.0];
            held.at(t.next_down(), &mut value);
            assert_eq!(value, [*u]);
        }
    }

    #[test]
    fn every_problem_of_a_table_is_reported() {
        let signals = Signals::new(&[0.0, 0.0]).with("u", &[1.0]).with("v", &[1.0, f64::NAN]);
        let texts: Vec<String> = signals.problems(2).iter().map(ToString::to_string).collect();
        assert_eq!(texts.len(), 3, "{texts:?}");
        assert!(texts.iter().all(|text| text.starts_with("record 2 of the input table: ")));
        assert!(texts[1].contains("`u` has 1 values for 2 rows"));
    }
}

//! How an array is cut into signals, and what these are called.

use super::Array;
use crate::log::group::Raw;

/// How an array is cut into signals: `count` of them with `rows` values each.
pub(super) struct Signals {
    pub(super) rows: usize,
    pub(super) count: usize,
    /// Whether one time's values are next to each other.
    pub(super) by_time: bool,
    pub(super) is_transposed: bool,
}

/// How an array is cut; `rows` is the number of times where it is known. `None` for arrays with no index of times.
pub(super) fn signals(array: &Array, rows: Option<usize>) -> Option<Signals> {
    let of = |rows: usize, by_time, is_transposed| {
        let count = array.values.len().checked_div(rows)?;
        (rows > 1).then_some(Signals { rows, count, by_time, is_transposed })
    };
    if let Some(vector) = array.vector() {
        return of(vector.len(), false, false);
    }
    let (first, last) = (*array.size.first()?, *array.size.last()?);
    match (array.size.len(), rows) {
        (2, Some(rows)) if rows != first && rows == last => of(rows, true, true),
        (2, _) => of(first, false, false),
        // Signals of several dimensions have their times last, as Simulink writes them.
        (_, Some(rows)) if rows == last => of(rows, true, false),
        (_, Some(rows)) if rows == first => of(rows, false, false),
        _ => None,
    }
}

/// How the columns of a matrix are called.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Style {
    /// `y[1]`, as axes are in blueprints and in FMUs.
    Index,
    /// `yout_1`, as Simulink calls the elements of a logged signal.
    Simulink,
}

/// The columns of an array.
pub(super) fn named(name: &str, array: &Array, signals: &Signals, style: Style) -> Vec<Raw> {
    let Signals { rows, count, by_time, .. } = *signals;
    let column = |at: usize| -> Vec<f64> {
        match by_time {
            false => array.values[at * rows..(at + 1) * rows].to_vec(),
            true => (0..rows).map(|row| array.values[row * count + at]).collect(),
        }
    };
    (0..count)
        .map(|at| {
            let name = match (count, style) {
                (1, _) => name.to_owned(),
                (_, Style::Index) => format!("{name}[{}]", at + 1),
                (_, Style::Simulink) => format!("{name}_{}", at + 1),
            };
            Raw::new(name, array.unit.clone(), column(at))
        })
        .collect()
}

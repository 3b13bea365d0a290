//! MATLAB's files: versions 4, 5 (`save -v7` and older) and 7.3 (HDF5), and plain HDF5. Each gives
//! variables; what is the same in all is which of them are times and signals.

mod dymola;
mod hdf5;
mod scope;
mod signals;
mod simulink;
pub(in crate::log::formats) mod v4;
mod v5;

use std::path::Path;

use super::broken;
use super::budget::Budget;
use crate::log::group::{Found, Refusal};

/// The value of a variable.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    /// Real numbers.
    Numbers(Array),
    /// A structure: its fields, each with one value for each element.
    Structure(Vec<(String, Vec<Value>)>),
    Text(String),
    /// What cannot be a signal, in words.
    Other(String),
}

/// Real numbers, the first index running fastest.
#[derive(Clone, Debug, Default, PartialEq)]
struct Array {
    size: Vec<usize>,
    values: Vec<f64>,
    unit: Option<String>,
}

type Variables = Vec<(String, Value)>;

impl Value {
    /// The value of a field of a structure of one element.
    fn field(&self, name: &str) -> Option<&Value> {
        let Self::Structure(fields) = self else { return None };
        match fields.iter().find(|(own, _)| own == name)?.1.as_slice() {
            [only] => Some(only),
            _ => None,
        }
    }

    /// Complex numbers: a structure of their parts, as HDF5 has them.
    fn complex(real: Self, imag: Self) -> Self {
        Self::Structure(vec![("real".to_owned(), vec![real]), ("imag".to_owned(), vec![imag])])
    }

    fn numbers(&self) -> Option<&Array> {
        match self {
            Self::Numbers(array) => Some(array),
            _ => None,
        }
    }

    fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text.trim()).filter(|text| !text.is_empty()),
            _ => None,
        }
    }

    /// Why it is left out: "it is a text".
    fn why(&self) -> String {
        match self {
            Self::Numbers(array) => array.why(),
            Self::Structure(_) => "is a structure of several elements".into(),
            Self::Text(_) => "is a text".into(),
            Self::Other(why) => why.clone(),
        }
    }
}

impl Array {
    /// The values where all but one index have one value only.
    fn vector(&self) -> Option<&[f64]> {
        let is_one = self.size.iter().filter(|length| **length != 1).count() <= 1;
        (is_one && self.values.len() > 1).then_some(&self.values)
    }

    fn why(&self) -> String {
        let size: Vec<String> = self.size.iter().map(usize::to_string).collect();
        match self.values.len() {
            0 => "is empty".into(),
            1 => "is a single number".into(),
            _ => format!("is an array of {}, which has no index of times", size.join(" × ")),
        }
    }

    /// Whether it is a vector whose values grow, as times do.
    fn grows(&self) -> bool {
        self.vector().is_some_and(grow)
    }
}

/// Whether numbers are finite and do not go back; two rows at one time are an event.
fn grow(values: &[f64]) -> bool {
    let is_finite = values.iter().all(|value| value.is_finite());
    let first_last = values.first().zip(values.last());
    is_finite
        && first_last.is_some_and(|(first, last)| first < last)
        && values.windows(2).all(|pair| pair[0] <= pair[1])
}

/// MATLAB 5; `is_timed` where the caller says the sample rate.
pub(super) fn version_5(
    path: &Path,
    budget: &mut Budget,
    is_timed: bool,
) -> Result<Found, Refusal> {
    let bytes = std::fs::read(path).map_err(|error| broken("MATLAB 5", error))?;
    found(v5::read(&bytes, budget)?, is_timed)
}

/// MATLAB 4, and results of Dymola and OpenModelica.
pub(super) fn version_4(
    path: &Path,
    budget: &mut Budget,
    is_timed: bool,
) -> Result<Found, Refusal> {
    let bytes = std::fs::read(path).map_err(|error| broken("MATLAB 4", error))?;
    let matrices = v4::read(&bytes, budget)?;
    match dymola::read(&matrices, budget)? {
        Some(found) => Ok(found),
        None => found(matrices.into_iter().map(v4::Matrix::variable).collect(), is_timed),
    }
}

/// MATLAB 7.3 and other HDF5.
pub(super) fn version_7_3(
    path: &Path,
    budget: &mut Budget,
    is_timed: bool,
) -> Result<Found, Refusal> {
    found(hdf5::read(path, budget)?, is_timed)
}

fn found(variables: Variables, is_timed: bool) -> Result<Found, Refusal> {
    let mut reader = scope::Reader { is_timed, ..scope::Reader::default() };
    reader.read("", variables, None);
    let scope::Reader { mut found, left_out, .. } = reader;
    // Times alone are no log where there are signals.
    if found.groups.iter().any(|group| group.columns.len() > 1) {
        found.groups.retain(|group| group.columns.len() > 1 || group.columns[0].name != "time");
    }
    let Some(first) = found.groups.first_mut() else {
        let others: Vec<String> =
            left_out.iter().map(|(name, why)| format!("{name} {why}")).collect();
        let others = if others.is_empty() { "nothing".into() } else { shortened(&others) };
        let rule = format!("has no columns of real numbers, one value per time; it has: {others}");
        let how = left_out.iter().find_map(|(name, why)| exported(name, why));
        let how = how.unwrap_or_else(|| "time = ts.Time; y = ts.Data".to_owned());
        return Err((rule, format!("save plain arrays, as in {how}; save(f, 'time', 'y')")));
    };
    for (name, why) in left_out {
        let why = exported(&name, &why).map_or(why.clone(), |how| format!("{why}: save {how}"));
        first.leave_out(name, why);
    }
    Ok(found)
}

/// The commands that make plain arrays of an object of MATLAB, whose values stand in a form that is its own.
fn exported(name: &str, why: &str) -> Option<String> {
    match why.strip_prefix("is an object of class ")? {
        "timeseries" => Some(format!("time = {name}.Time; y = {name}.Data")),
        "timetable" => {
            let times = format!("{name}.Properties.RowTimes");
            Some(format!("time = seconds({times} - {times}(1)); y = {name}.Variables"))
        }
        "Simulink.SimulationData.Dataset" => {
            Some(format!("ts = {name}.get(1).Values; time = ts.Time; y = ts.Data"))
        }
        _ => None,
    }
}

/// A list, of which the first ones are shown.
fn shortened(list: &[String]) -> String {
    const SHOWN: usize = 12;
    match list.len() {
        0..=SHOWN => list.join(", "),
        more => format!("{} and {} more", list[..SHOWN].join(", "), more - SHOWN),
    }
}

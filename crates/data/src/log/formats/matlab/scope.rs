//! Which variables of a scope (the file, a structure, a group of HDF5) are times and signals.

use std::collections::HashMap;

use super::signals::{Signals, Style, named, signals};
use super::{Array, Value, Variables, grow, simulink};
use crate::log::group::{Found, Group, Raw};

/// The fields of a structure, each with one value for each element.
type Fields = Vec<(String, Vec<Value>)>;

/// The parts of complex numbers, which stand as a structure; its fields where it is another one.
fn parts(mut fields: Fields) -> Result<[Array; 2], Fields> {
    if let [(real, a), (imag, b)] = fields.as_mut_slice()
        && matches!([real.as_str(), imag.as_str()], ["real", "imag"] | ["r", "i"])
        && let ([Value::Numbers(a)], [Value::Numbers(b)]) = (a.as_mut_slice(), b.as_mut_slice())
        && a.size == b.size
        && a.values.len() > 1
    {
        return Ok([std::mem::take(a), std::mem::take(b)]);
    }
    Err(fields)
}

/// What a vector of times is called, in small letters; the first that there is.
const TIMES: [&str; 10] =
    ["time", "tout", "t", "timestamps", "timestamp", "time_s", "t_s", "times", "time_vec", "tvec"];

/// Goes through the variables of scopes.
#[derive(Default)]
pub(super) struct Reader {
    /// Whether the user gives the sample rate, so that no times are looked for.
    pub(super) is_timed: bool,
    pub(super) found: Found,
    /// What can be no signal, and why.
    pub(super) left_out: Vec<(String, String)>,
}

impl Reader {
    /// Adds the groups of a scope. Arrays of one length are one group, named by it; a matrix with as many
    /// columns as there are times is taken transposed; a matrix without times beside it has them in
    /// its first row (Simulink's To File) or column. What is assumed is noted.
    /// `outer` are the times of the outer scope, which signals of their length have too.
    pub(super) fn read(&mut self, scope: &str, variables: Variables, outer: Option<&Array>) {
        let full = |name: &str| match scope {
            "" => name.to_owned(),
            scope => format!("{scope}.{name}"),
        };
        let (mut arrays, mut structures) = (Vec::new(), Vec::new());
        for (name, value) in variables {
            match value {
                Value::Numbers(array) if array.values.len() > 1 => arrays.push((name, array)),
                Value::Structure(fields) => match parts(fields) {
                    Ok([real, imag]) => {
                        arrays.push((format!("{name}.real"), real));
                        arrays.push((format!("{name}.imag"), imag));
                    }
                    Err(fields) => structures.push((name, Value::Structure(fields))),
                },
                other => self.left_out.push((full(&name), other.why())),
            }
        }
        let times = times_of(&arrays);
        let mut groups = Lengths { scope, groups: Vec::new(), by_rows: HashMap::new() };
        let outer = outer.filter(|_| times.is_none());
        let rows = times.as_ref().map(|(_, rows)| *rows).or(outer.map(|times| times.values.len()));
        let own =
            times.as_ref().and_then(|(times, _)| arrays.iter().find(|(name, _)| name == times));
        let inherited =
            own.map(|(_, array)| array).or(outer).cloned().filter(|_| !structures.is_empty());
        let is_simulink = times.as_ref().is_some_and(|(name, _)| name.eq_ignore_ascii_case("tout"));
        let style = if is_simulink { Style::Simulink } else { Style::Index };
        let mut transposed = Vec::new();
        for (name, array) in arrays {
            if times.as_ref().is_some_and(|(times, _)| *times == name) {
                let is_renamed = name != "time" && !self.is_timed;
                if is_renamed {
                    self.found.notes.push(format!("{} is taken as the time", full(&name)));
                }
                let name = if is_renamed { "time".into() } else { name };
                groups.add(Raw::new(name, array.unit, array.values), true);
            } else if rows.is_some()
                || self.is_timed
                || !self.with_times(&full(&name), &name, &array)
            {
                let Some(signals) = signals(&array, rows) else {
                    self.left_out.push((full(&name), array.why()));
                    continue;
                };
                if signals.is_transposed {
                    transposed.push(full(&name));
                }
                for raw in named(&name, &array, &signals, style) {
                    groups.add(raw, false);
                }
            }
        }
        if !transposed.is_empty() {
            let list = super::shortened(&transposed);
            self.found.notes.push(format!("{list}: a column per time, taken transposed"));
        }
        for (name, value) in structures {
            match simulink::read(&full(&name), &value, rows, &mut self.found, &mut self.left_out) {
                Some(columns) => columns.into_iter().for_each(|raw| groups.add(raw, false)),
                None => self.structure(full(&name), value, inherited.as_ref()),
            }
        }
        for group in groups.groups.iter_mut().filter(|group| Some(group.rows()) == rows) {
            let times = outer.map(|o| Raw::new("time", o.unit.clone(), o.values.clone()));
            group.columns.splice(..0, times);
        }
        if let ([only], false) = (groups.groups.as_mut_slice(), scope.is_empty()) {
            only.name = scope.to_owned();
        }
        self.found.groups.extend(groups.groups);
    }

    /// A structure of one element is a scope of its own.
    fn structure(&mut self, name: String, value: Value, times: Option<&Array>) {
        match value {
            Value::Structure(fields) if fields.iter().all(|(_, values)| values.len() == 1) => {
                let inner = fields.into_iter().flat_map(|(field, values)| {
                    values.into_iter().map(move |value| (field.clone(), value))
                });
                self.read(&name, inner.collect(), times);
            }
            other => self.left_out.push((name, other.why())),
        }
    }

    /// A matrix that holds its own times, in its first row or column; false where it does not.
    fn with_times(&mut self, full: &str, name: &str, array: &Array) -> bool {
        let [rows, columns] = *array.size.as_slice() else { return false };
        if rows.min(columns) < 2 {
            return false;
        }
        let first_row = || array.values.iter().step_by(rows).copied().collect::<Vec<f64>>();
        let (signals, place) = if columns > rows && grow(&first_row()) {
            (Signals { rows: columns, count: rows, by_time: true, is_transposed: false }, "row")
        } else if rows > columns && grow(&array.values[..rows]) {
            (Signals { rows, count: columns, by_time: false, is_transposed: false }, "column")
        } else {
            return false;
        };
        let mut columns = named(name, array, &signals, Style::Simulink);
        for (column, number) in columns.iter_mut().zip(0..) {
            column.name = match (number, signals.count) {
                (0, _) => "time".into(),
                (_, 2) => name.to_owned(),
                _ => format!("{name}_{number}"),
            };
        }
        let names: Vec<String> = columns.iter().skip(1).map(|column| column.name.clone()).collect();
        let names = super::shortened(&names);
        let note =
            format!("{full}: the first {place} is taken as the time, the others are {names}");
        self.found.notes.push(note);
        self.found.groups.push(Group::new(full, columns));
        true
    }
}

/// The vector of times of a scope: its name and its length.
fn times_of(arrays: &[(String, Array)]) -> Option<(String, usize)> {
    TIMES.iter().find_map(|wanted| {
        let (name, array) =
            arrays.iter().find(|(name, array)| name.to_lowercase() == *wanted && array.grows())?;
        Some((name.clone(), array.values.len()))
    })
}

/// Groups by length.
struct Lengths<'a> {
    scope: &'a str,
    groups: Vec<Group>,
    by_rows: HashMap<usize, usize>,
}

impl Lengths<'_> {
    fn add(&mut self, raw: Raw, is_first: bool) {
        let rows = raw.values.len();
        let at = *self.by_rows.entry(rows).or_insert(self.groups.len());
        if at == self.groups.len() {
            let name = match self.scope {
                "" => rows.to_string(),
                scope => format!("{scope}/{rows}"),
            };
            self.groups.push(Group::new(name, Vec::new()));
        }
        let columns = &mut self.groups[at].columns;
        columns.insert(if is_first { 0 } else { columns.len() }, raw);
    }
}

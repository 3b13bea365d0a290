//! Structures that Simulink logs into, and what is left of a `timeseries` made a structure.

use super::super::names::Names;
use super::signals::{Style, named, signals};
use super::{Array, Value};
use crate::log::group::{Found, Group, Raw};

/// Adds the group of a "Structure with time" or a `timeseries`; the columns of a structure without time,
/// whose times stand elsewhere (`rows` of them), are the result. `None` where it is none of these.
pub(super) fn read(
    name: &str,
    value: &Value,
    rows: Option<usize>,
    found: &mut Found,
    left_out: &mut Vec<(String, String)>,
) -> Option<Vec<Raw>> {
    if let Some(signals) = value.field("signals") {
        return with_signals(name, value.field("time"), signals, rows, found, left_out);
    }
    let data = ["Data", "data", "Values"].iter().find_map(|field| value.field(field)?.numbers())?;
    let time = ["Time", "time"].iter().find_map(|field| value.field(field)?.numbers())?;
    let times = time.vector().filter(|_| time.grows())?;
    let own = value.field("Name").and_then(Value::text).unwrap_or(name);
    let signals = signals(data, Some(times.len())).filter(|s| s.rows == times.len())?;
    let mut columns = vec![Raw::new("time", time.unit.clone(), times.to_vec())];
    columns.extend(named(own, data, &signals, Style::Simulink));
    found.notes.push(format!("{name} is read as a time series"));
    found.groups.push(Group::new(name, columns));
    Some(Vec::new())
}

/// One value in each element: `signals(k).values`, `.label`.
fn with_signals(
    name: &str,
    time: Option<&Value>,
    value: &Value,
    rows: Option<usize>,
    found: &mut Found,
    left_out: &mut Vec<(String, String)>,
) -> Option<Vec<Raw>> {
    let Value::Structure(fields) = value else { return None };
    let field = |wanted: &str| fields.iter().find(|(own, _)| own == wanted);
    let (_, values) = field("values")?;
    let label = |at: usize| field("label").and_then(|(_, labels)| labels.get(at)?.text());
    let time = time.and_then(Value::numbers).filter(|time| time.grows());
    let rows = time.map(|time| time.values.len()).or(rows);
    let mut columns: Vec<Raw> = Vec::new();
    for (at, value) in values.iter().enumerate() {
        let title = match (label(at), values.len()) {
            (Some(label), _) => label.to_owned(),
            (None, 1) => name.to_owned(),
            (None, _) => format!("{name}_{}", at + 1),
        };
        let logged = value.numbers().and_then(|array| {
            let signals = signals(array, rows)?;
            let length = rows.or_else(|| Some(columns.first()?.values.len()));
            let fits = length.is_none_or(|rows| rows == signals.rows);
            fits.then(|| named(&title, array, &signals, Style::Simulink))
        });
        match logged {
            Some(logged) => columns.extend(logged),
            None => left_out.push((format!("{name}.signals({})", at + 1), value.why())),
        }
    }
    if columns.is_empty() {
        return None;
    }
    // Signals of several blocks can have one label.
    let mut given = Names::default();
    columns.iter_mut().for_each(|column| column.name = given.free(&column.name));
    let names: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
    let kind = if time.is_some() { "structure with time" } else { "structure without time" };
    found.notes.push(format!("{name} is a {kind} of {}", super::shortened(&names)));
    let Some(Array { unit, values, .. }) = time else { return Some(columns) };
    columns.insert(0, Raw::new("time", unit.clone(), values.clone()));
    found.groups.push(Group::new(name, columns));
    Some(Vec::new())
}

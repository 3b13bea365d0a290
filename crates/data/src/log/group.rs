//! From the columns of a file to a log.

use std::collections::HashSet;

use super::dataset::Dataset;
use super::header::{Context, Header, Role};
use super::header_cell::split;
use super::lines::Place;
use super::notes::LeftOut;
use super::table::{Grid, Table};
use super::ticks::{Base, Start};
use super::{ColumnUnit, Log, ReadOptions, join, time_column};
use crate::{Problem, Problems, counted, nearest};

/// The rule that a file breaks, and the way out.
pub(super) type Refusal = (String, String);

/// What a reader found in a file.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub(super) groups: Vec<Group>,
    /// Sentences about the file: what was recognised, assumed, skipped, without the file's name.
    pub(super) notes: Vec<String>,
}

impl From<Vec<Group>> for Found {
    fn from(groups: Vec<Group>) -> Self {
        Self { groups, notes: Vec::new() }
    }
}

impl Found {
    /// The log that is meant.
    pub(super) fn log(
        self,
        origin: &str,
        options: &ReadOptions,
        datasets: &[Dataset],
    ) -> Result<Log, Problems> {
        let refuse = |(rule, way_out): Refusal| Problems::from(Problem::new(origin, rule, way_out));
        let mut notes = self.notes;
        let mut groups =
            choose(self.groups, options.group.as_deref(), &mut notes).map_err(refuse)?;
        let mut log = match (groups.len(), options.resample) {
            (1, _) => groups.swap_remove(0).log(origin, options, datasets)?,
            (_, Some(resample)) => {
                align(&mut groups).map_err(refuse)?;
                let mut options = options.clone();
                let units = std::mem::take(&mut options.units);
                let logs = groups.into_iter().map(|group| {
                    let mut options = options.clone();
                    let has = |name: &String| group.columns.iter().any(|raw| raw.name == *name);
                    options.units =
                        units.clone().into_iter().filter(|(name, _)| has(name)).collect();
                    let name = group.name.clone();
                    group.log(origin, &options, &[]).map(|log| (name, log))
                });
                let logs = logs.collect::<Result<Vec<_>, _>>()?;
                join::groups(origin, logs, resample, options.memory)?
            }
            _ => return Err(refuse(different(&groups))),
        };
        log.remarks.notes.splice(..0, notes);
        log.remarks.is_chosen = options.group.is_some();
        Ok(log)
    }
}

/// Columns of one length.
#[derive(Debug, Default)]
pub(super) struct Group {
    /// Name by which a user chooses it.
    pub(super) name: String,
    /// The columns; that of time, if there is one, has the name `time` or what the file calls it.
    pub(super) columns: Vec<Raw>,
    /// Columns of it that are no numbers, or that nobody can use for another reason.
    pub(super) left_out: Vec<LeftOut>,
}

/// A column as the file has it.
#[derive(Debug)]
pub(super) struct Raw {
    pub(super) name: String,
    pub(super) unit: Option<String>,
    pub(super) values: Vec<f64>,
    /// What was taken off the values.
    pub(super) start: Start,
}

impl Raw {
    pub(super) fn new(name: impl Into<String>, unit: Option<String>, values: Vec<f64>) -> Self {
        let unit = unit.filter(|unit| !unit.trim().is_empty());
        Self { name: name.into(), unit, values, start: Start::default() }
    }

    /// The column with what was taken off its values.
    pub(super) fn after(self, start: Start) -> Self {
        Self { start, ..self }
    }

    /// Name and unit as the header of a text has them.
    fn header(&self) -> String {
        // "AI0 [V]" is AI0 in V, also where a property says the unit.
        let (name, own) = match split(&self.name) {
            (name, Some(own)) if ColumnUnit::parse(own).is_ok() => (name, Some(own)),
            _ => (self.name.as_str(), None),
        };
        match self.unit.as_deref().or(own) {
            Some(unit) => format!("{name} [{unit}]"),
            None => name.to_owned(),
        }
    }
}

impl Group {
    /// A group whose columns can all be used.
    pub(super) fn new(name: impl Into<String>, columns: Vec<Raw>) -> Self {
        Self { name: name.into(), columns, left_out: Vec::new() }
    }

    /// Leaves a column out and keeps why, as in `holds texts`; behind `; ` what to do about it.
    pub(super) fn leave_out(&mut self, name: impl Into<String>, why: impl Into<String>) {
        self.left_out.push(LeftOut::new(name, why));
    }

    pub(super) fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// The column of time, by its name or by its unit.
    fn time_at(&self) -> Option<usize> {
        let exact = self.columns.iter().position(|raw| raw.name == "time");
        exact.or_else(|| {
            self.columns.iter().position(|raw| time_column::of_name(&raw.name).is_some())
        })
    }

    fn time(&self) -> Option<&Raw> {
        self.columns.get(self.time_at()?)
    }

    /// The log: names, units and rows under the same rules as those of a text.
    fn log(
        mut self,
        origin: &str,
        options: &ReadOptions,
        datasets: &[Dataset],
    ) -> Result<Log, Problems> {
        let cells: Vec<String> = self.columns.iter().map(Raw::header).collect();
        let context = Context { file: origin, line: None, options, datasets, layout: None };
        let Header { heads, problems, notes } = context.heads(&cells);
        if !problems.is_empty() {
            // Where there is no time, the column that was meant may be one that is left out.
            let has_time = heads.iter().any(|head| matches!(head.role, Role::Time(_)));
            let meant = self
                .left_out
                .iter()
                .filter(|column| !has_time && time_column::of_name(&column.name).is_some());
            let meant = meant.map(|column| {
                let (rule, way_out) = column.why.split_once("; ").unwrap_or((&column.why, ""));
                let way_out = if way_out.is_empty() { "save it as numbers in s" } else { way_out };
                Problem::new(origin, format!("is left out: it {rule}"), way_out).at(&column.name)
            });
            return Err(Problems::new(meant.chain(problems).collect()));
        }
        let mut base = Base::default();
        for (raw, head) in self.columns.iter_mut().zip(&heads) {
            if let Start::Long(start) = raw.start {
                // Only times are counted from the first one.
                match head.role {
                    Role::Time(_) => base = start,
                    _ => raw.values.iter_mut().for_each(|value| *value = start.back(*value)),
                }
            }
        }
        let grid = Grid::at_rate(context.rate());
        let mut table = Table::new(origin, heads, grid).with_base(base);
        for row in 0..self.rows() {
            let cells = self.columns.iter().map(|column| column.values[row]);
            table.numbers(cells, Place::Row(row + 1));
        }
        let mut log = table.finish()?;
        log.remarks.left_out.extend(self.left_out);
        log.remarks.notes.splice(..0, notes);
        Ok(log)
    }
}

/// The group that is meant: that of the name; without one, all groups with the same times, or the
/// only one.
fn choose(
    groups: Vec<Group>,
    name: Option<&str>,
    notes: &mut Vec<String>,
) -> Result<Vec<Group>, Refusal> {
    let mut groups: Vec<Group> = groups.into_iter().filter(|group| group.rows() > 0).collect();
    if let Some(name) = name {
        let names: Vec<String> = groups.iter().map(|group| group.name.clone()).collect();
        let at = groups.iter().position(|group| group.name == name).ok_or_else(|| {
            let near = nearest(name, names.iter().map(String::as_str))
                .map_or_else(String::new, |near| format!("did you mean \"{near}\"? "));
            let rule = format!("has no group \"{name}\" with numbers");
            (rule, format!("{near}its groups are {}", names.join(", ")))
        })?;
        return Ok(vec![groups.swap_remove(at)]);
    }
    let mut merged: Vec<Group> = Vec::new();
    let mut names: Vec<HashSet<String>> = Vec::new();
    for group in groups {
        let Some(at) = merged.iter().position(|other| same_times(other, &group)) else {
            names.push(group.columns.iter().map(|raw| raw.name.clone()).collect());
            merged.push(group);
            continue;
        };
        let time = group.time_at();
        for (position, mut raw) in group.columns.into_iter().enumerate() {
            // Parts of a file that number the records of both.
            let is_record = raw.name == "record"
                && merged[at]
                    .columns
                    .iter()
                    .any(|other| other.name == raw.name && other.values == raw.values);
            if Some(position) == time || is_record {
                continue;
            }
            if !names[at].insert(raw.name.clone()) {
                let full = format!("{}.{}", group.name, raw.name);
                notes.push(format!("{} of group \"{}\" is called {full}", raw.name, group.name));
                raw.name = full;
            }
            merged[at].columns.push(raw);
        }
        merged[at].left_out.extend(group.left_out);
    }
    match merged.len() {
        0 => Err((
            "has no columns of real numbers".into(),
            "save one-dimensional arrays of numbers, one per signal".into(),
        )),
        _ => Ok(merged),
    }
}

/// Puts times that count from the first one of their own group onto the earliest of these.
fn align(groups: &mut [Group]) -> Result<(), Refusal> {
    let starts = groups.iter().filter_map(|group| Some(group.time()?.start));
    let Some(least) = starts.reduce(Start::earlier) else { return Ok(()) };
    for group in groups {
        let Some(at) = group.time_at() else { continue };
        let time = &mut group.columns[at];
        let Some(later) = time.start.after(least) else {
            let rule =
                format!("times of group \"{}\" count from another date than others'", group.name);
            return Err((rule, "choose one: --group NAME; or save all times alike".into()));
        };
        time.values.iter_mut().for_each(|value| *value += later);
        time.start = least;
    }
    Ok(())
}

fn different(groups: &[Group]) -> Refusal {
    let list = groups.iter().map(|g| format!("\"{}\" ({})", g.name, counted(g.rows(), "row")));
    let list = list.collect::<Vec<_>>().join(", ");
    let rule = format!("has {} groups with different times: {list}", groups.len());
    (rule, "choose one: --group NAME; or join them: --resample".into())
}

/// Whether two groups were sampled at the same times, by the bit.
fn same_times(left: &Group, right: &Group) -> bool {
    match (left.time(), right.time()) {
        (Some(left), Some(right)) => {
            left.values == right.values && left.unit == right.unit && left.start == right.start
        }
        _ => false,
    }
}

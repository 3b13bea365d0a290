//! From the columns of a file to a log.

use std::collections::HashSet;

use super::dataset::Dataset;
use super::header::Context;
use super::notes::LeftOut;
use super::table::{Place, Table};
use super::{Log, ReadOptions};
use crate::{Problem, Problems, nearest};

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
        let group = choose(self.groups, options.group.as_deref(), &mut notes).map_err(refuse)?;
        let mut log = group.log(origin, options, datasets)?;
        log.remarks.notes.splice(..0, notes);
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
}

impl Raw {
    pub(super) fn new(name: impl Into<String>, unit: Option<String>, values: Vec<f64>) -> Self {
        let unit = unit.filter(|unit| !unit.trim().is_empty());
        Self { name: name.into(), unit, values }
    }

    /// Name and unit as the header of a text has them.
    fn header(&self) -> String {
        match &self.unit {
            Some(unit) => format!("{} [{unit}]", self.name),
            None => self.name.clone(),
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

    fn time(&self) -> Option<&Raw> {
        self.columns.iter().find(|column| column.name == "time")
    }

    /// The log: names, units and rows under the same rules as those of a text.
    fn log(
        self,
        origin: &str,
        options: &ReadOptions,
        datasets: &[Dataset],
    ) -> Result<Log, Problems> {
        let cells: Vec<String> = self.columns.iter().map(Raw::header).collect();
        let context = Context { file: origin, line: None, options, datasets };
        let (heads, problems) = context.heads(&cells);
        if !problems.is_empty() {
            return Err(Problems::new(problems));
        }
        let mut table = Table::new(origin, heads, context.rate());
        for row in 0..self.rows() {
            let cells = self.columns.iter().map(|column| column.values[row]);
            table.numbers(cells, Place::Row(row + 1));
        }
        let mut log = table.finish()?;
        log.remarks.left_out.extend(self.left_out);
        Ok(log)
    }
}

/// The group that is meant: that of the name; without one, all groups with the same times, or the
/// only one.
fn choose(
    groups: Vec<Group>,
    name: Option<&str>,
    notes: &mut Vec<String>,
) -> Result<Group, Refusal> {
    let mut groups: Vec<Group> = groups.into_iter().filter(|group| group.rows() > 0).collect();
    if let Some(name) = name {
        let names: Vec<String> = groups.iter().map(|group| group.name.clone()).collect();
        let at = groups.iter().position(|group| group.name == name).ok_or_else(|| {
            let near = nearest(name, names.iter().map(String::as_str))
                .map_or_else(String::new, |near| format!("did you mean \"{near}\"? "));
            let rule = format!("has no group \"{name}\" with numbers");
            (rule, format!("{near}its groups are {}", names.join(", ")))
        })?;
        return Ok(groups.swap_remove(at));
    }
    let mut merged: Vec<Group> = Vec::new();
    let mut names: Vec<HashSet<String>> = Vec::new();
    for group in groups {
        let Some(at) = merged.iter().position(|other| same_times(other, &group)) else {
            names.push(group.columns.iter().map(|raw| raw.name.clone()).collect());
            merged.push(group);
            continue;
        };
        for mut raw in group.columns.into_iter().filter(|raw| raw.name != "time") {
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
        1 => Ok(merged.swap_remove(0)),
        _ => {
            let list = merged.iter().map(|g| format!("\"{}\" ({} rows)", g.name, g.rows()));
            let list = list.collect::<Vec<_>>().join(", ");
            let rule = format!("has {} groups with different times: {list}", merged.len());
            Err((rule, "choose one: --group NAME".into()))
        }
    }
}

/// Whether two groups were sampled at the same times, by the bit.
fn same_times(left: &Group, right: &Group) -> bool {
    match (left.time(), right.time()) {
        (Some(left), Some(right)) => left.values == right.values && left.unit == right.unit,
        _ => false,
    }
}

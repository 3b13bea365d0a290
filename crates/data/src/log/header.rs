//! The header row: names, units in brackets, and which column plays which part.

use std::collections::BTreeSet;

use model::Unit;

use super::dataset::Dataset;
use super::header_cell::{name_and_unit, split};
use super::text::{Kind, Layout};
use super::units::SECOND;
use super::{ColumnUnit, ReadOptions, time_column};
use crate::nearest::did_you_mean;
use crate::{Problem, nearest};

/// Names of the column that separates records.
const RECORD: [&str; 2] = ["record", "realization"];
/// Names of a first column that counts rows (an empty one is how pandas writes it).
const INDEX: [&str; 9] = ["", "n", "k", "i", "index", "sample", "samples", "frame", "step"];

/// The part of a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Role {
    /// Time, in this unit.
    Time(Unit),
    /// Dates or clock times; where they are clock times, the position of a column of days.
    Instant(Option<usize>),
    /// Whole numbers that grow, one per sample period.
    Index,
    /// Number of the record.
    Record,
    /// A signal.
    Signal,
    /// None of these: why it cannot be used; empty for what nobody misses.
    LeftOut(String),
}

/// A column before its values are known.
#[derive(Clone, Debug)]
pub(super) struct Head {
    pub(super) name: String,
    pub(super) role: Role,
    pub(super) unit: Option<ColumnUnit>,
    pub(super) description: String,
}

/// Whether logs use this name for something that is no signal.
pub(super) fn is_reserved(name: &str) -> bool {
    name == "time" || RECORD.contains(&name)
}

/// Whether a name can be written to a log and read again, by this program and by fmpy.
pub(super) fn check_name(name: &str) -> Result<(), (String, &'static str)> {
    let problem = |rule: &str, way_out| Err((rule.to_string(), way_out));
    if name.is_empty() {
        return problem("a column has no name", "give it one");
    }
    if name.contains('\u{feff}') || name.chars().any(char::is_control) {
        let way_out = "rename it: line ends and other control characters separate columns";
        return problem("is no name that every reader of logs takes", way_out);
    }
    if name != name.trim() || split(name).1.is_some() {
        let way_out = "rename it: blanks at its ends and a unit in brackets are not part of a name";
        return problem("would be read as another name", way_out);
    }
    Ok(())
}

/// A name like this one that can be written to a log and read again.
pub(super) fn writable(name: &str) -> String {
    let plain = |c: char| if c.is_control() || c == '\u{feff}' { '_' } else { c };
    let mut name = name.chars().map(plain).collect::<String>().trim().to_owned();
    if split(&name).1.is_some() {
        name = name.replace('[', "(").replace(']', ")");
    }
    if name.is_empty() || is_reserved(&name) {
        name.push('_');
    }
    name
}

/// What is known about the columns beside the header.
pub(super) struct Context<'a> {
    pub(super) file: &'a str,
    /// Line of the header, where the file has lines.
    pub(super) line: Option<usize>,
    pub(super) options: &'a ReadOptions,
    /// Nearest first.
    pub(super) datasets: &'a [Dataset],
    /// What was found in a text that is no plain table.
    pub(super) layout: Option<&'a Layout>,
}

/// What the header says.
pub(super) struct Header {
    pub(super) heads: Vec<Head>,
    /// Everything that is wrong with it.
    pub(super) problems: Vec<Problem>,
    /// What was assumed.
    pub(super) notes: Vec<String>,
}

impl Context<'_> {
    fn problem(&self, place: &str, rule: impl Into<String>, way_out: impl Into<String>) -> Problem {
        let problem = Problem::new(self.file, rule, way_out).at(place);
        match self.line {
            Some(line) => problem.line(line),
            None => problem,
        }
    }

    /// Sample rate for logs without times: the caller's goes before that of a dataset, and that before the preamble's.
    pub(super) fn rate(&self) -> Option<f64> {
        let of_dataset = || self.datasets.iter().find_map(|dataset| dataset.rate);
        self.options.rate.or_else(of_dataset).or_else(|| self.layout?.preamble.rate)
    }

    /// Name of the column of time.
    fn time_name(&self) -> &str {
        let in_dataset = || self.datasets.iter().find_map(|d| d.time_column.as_deref());
        self.options.time.as_deref().or_else(in_dataset).unwrap_or("time")
    }

    /// The columns that the header names, and everything that is wrong with them.
    pub(super) fn heads(&self, cells: &[String]) -> Header {
        // Logs that this program wrote have a column `time`; there a name may end with parentheses.
        let is_own = cells.iter().any(|cell| split(cell).0 == self.time_name());
        let read = if is_own { split } else { name_and_unit };
        let named: Vec<(&str, Option<&str>)> = cells.iter().map(|cell| read(cell)).collect();
        let time = self.time_at(&named);
        let mut header = Header { heads: Vec::new(), problems: Vec::new(), notes: Vec::new() };
        let Header { heads, problems, notes } = &mut header;
        let mut seen = BTreeSet::new();
        for (at, (name, unit)) in named.into_iter().enumerate() {
            let role = self.role(at, name, time);
            let needs_name = matches!(role, Role::Signal | Role::Record);
            if name.is_empty() && needs_name {
                let place = format!("column {}", at + 1);
                let way_out = "give it one, or remove a comma at the end of the line";
                problems.push(self.problem(&place, "has no name", way_out));
            } else if !name.is_empty() && !seen.insert(name) {
                let way_out = "give each column its own name";
                problems.push(self.problem(name, "is the name of two columns", way_out));
            }
            let is_time = time == Some(at);
            let unit = match &role {
                Role::LeftOut(_) | Role::Instant(_) => Ok(None),
                _ => self.unit(name, unit, is_time, problems),
            };
            let is_plain = name == self.time_name() || name.eq_ignore_ascii_case("time");
            if is_time
                && !(is_plain && matches!(role, Role::Time(_)))
                && matches!(role, Role::Time(_) | Role::Instant(_))
            {
                let how = match (&role, &unit) {
                    (Role::Instant(_), _) => ", in s after the first row",
                    (_, Ok(None)) => ", in s",
                    _ => "",
                };
                notes.push(format!("\"{name}\" is taken as the time{how}"));
            }
            let (role, unit) = match (role, unit) {
                (Role::Time(_), Ok(Some(unit))) => (Role::Time(unit.unit), Some(unit)),
                // Nobody need know the unit of what is not used.
                (Role::Signal, Err(why)) => (Role::LeftOut(why), None),
                (role, Ok(unit)) => (role, unit),
                (role, Err(why)) => {
                    let (rule, way_out) = why.split_once("; ").unwrap_or((&why, ""));
                    problems.push(self.problem(name, rule, way_out));
                    (role, None)
                }
            };
            let description = self
                .datasets
                .iter()
                .filter_map(|d| d.columns.get(name))
                .find(|about| !about.description.is_empty())
                .map_or_else(String::new, |about| about.description.clone());
            heads.push(Head { name: name.into(), role, unit, description });
        }
        self.check_roles(heads, problems);
        self.check_units_given(heads, problems);
        header
    }

    /// The column of time.
    fn time_at(&self, named: &[(&str, Option<&str>)]) -> Option<usize> {
        let exact = named.iter().position(|(name, _)| *name == self.time_name());
        let is_stated = self.options.time.is_some()
            || self.datasets.iter().any(|dataset| dataset.time_column.is_some());
        if exact.is_some() || is_stated {
            return exact;
        }
        // Who gives a rate means it; only a column of the exact name goes before that of a dataset.
        if self.options.rate.is_none() && self.datasets.iter().any(|dataset| dataset.rate.is_some())
        {
            return None;
        }
        if self.options.rate.is_some() {
            // A binary file has no column of row numbers; what is called t there stays a signal.
            let first = named.first().filter(|_| self.line.is_some()).map_or("", |(name, _)| name);
            return time_column::of_name(first).map(|_| 0);
        }
        let kinds = self.layout.map_or(&[][..], |layout| &layout.kinds);
        time_column::find(named.iter().copied(), kinds)
    }

    fn role(&self, at: usize, name: &str, time: Option<usize>) -> Role {
        let kind =
            self.layout.and_then(|layout| layout.kinds.get(at)).copied().unwrap_or(Kind::Number);
        let sample =
            self.layout.and_then(|layout| layout.samples.get(at)).map_or("", String::as_str);
        let sample: String = sample.chars().filter(|c| !c.is_control()).take(30).collect();
        // The day of a clock time stands in another cell.
        let day = self.layout.filter(|layout| time.is_some_and(|time| layout.is_clock(time)));
        let day = day.and_then(|layout| (0..layout.kinds.len()).find(|at| layout.is_day(*at)));
        if time == Some(at) {
            return match (self.options.rate, kind) {
                (Some(_), Kind::Instant | Kind::Text) => {
                    let why = "holds no numbers of rows: times are made from the sample rate that was given";
                    Role::LeftOut(why.into())
                }
                (Some(_), _) => Role::Index,
                (None, Kind::Instant) => Role::Instant(day),
                (None, _) => Role::Time(SECOND),
            };
        }
        let is_index = || {
            let is_counter = self
                .layout
                .is_some_and(|layout| layout.is_counter && layout.preamble.rate.is_some());
            INDEX.contains(&name.to_lowercase().as_str()) || is_counter
        };
        match kind {
            Kind::Empty if name.is_empty() => Role::LeftOut(String::new()),
            _ if at == 0 && name.is_empty() && time.is_some() => {
                Role::LeftOut("has no name, as pandas writes its numbers of rows".into())
            }
            Kind::Empty => Role::LeftOut("is empty".into()),
            Kind::Instant if day == Some(at) => Role::LeftOut(String::new()),
            Kind::Instant => {
                Role::LeftOut(format!("holds dates or clock times, as in \"{sample}\""))
            }
            // Keys beside the first rows.
            Kind::Text if name.is_empty() => Role::LeftOut(String::new()),
            Kind::Text if self.layout.is_some_and(|layout| layout.may_leave_out(at)) => {
                Role::LeftOut(format!("holds texts, as in \"{sample}\""))
            }
            _ if RECORD.contains(&name) => Role::Record,
            _ if at == 0 && time.is_none() && self.rate().is_some() && is_index() => Role::Index,
            _ => Role::Signal,
        }
    }

    /// The unit of a column: the caller's, the header's, a dataset's; why it is none where nobody knows it.
    fn unit(
        &self,
        name: &str,
        in_header: Option<&str>,
        is_time: bool,
        problems: &mut Vec<Problem>,
    ) -> Result<Option<ColumnUnit>, String> {
        let in_dataset = self.datasets.iter().find_map(|dataset| {
            let text = if is_time { dataset.time_unit.as_deref() } else { None };
            let text = text.or_else(|| dataset.columns.get(name)?.unit.as_deref());
            text.map(|text| (text, dataset))
        });
        let by_caller = self.options.units.get(name).map(String::as_str);
        let in_header = match in_header {
            Some("S") if is_time => Some("s"),
            None if is_time => time_column::of_name(name).flatten(),
            text => text,
        };
        let Some(text) = by_caller.or(in_header).or(in_dataset.map(|(text, _)| text)) else {
            return Ok(None);
        };
        let unit = ColumnUnit::parse(text).map_err(|_| {
            format!("has a unit that is not known, \"{text}\"; say it: --unit {name}=um")
        })?;
        if let (None, Some(header), Some((other, dataset))) = (by_caller, in_header, in_dataset)
            && ColumnUnit::parse(other).ok().map(|other| other.unit) != Some(unit.unit)
        {
            let rule = format!("the header says {header}, but {} says {other}", dataset.file);
            let way_out = format!("correct one of them, or decide: --unit {name}={header}");
            problems.push(self.problem(name, rule, way_out));
        }
        Ok(Some(unit))
    }

    fn check_roles(&self, heads: &[Head], problems: &mut Vec<Problem>) {
        let count = |wanted: fn(&Role) -> bool| heads.iter().filter(|h| wanted(&h.role)).count();
        if count(|role| *role == Role::Record) > 1 {
            let way_out = "keep record or realization, not both";
            problems.push(self.problem("record", "two columns number the records", way_out));
        }
        for head in heads {
            if let Role::Time(unit) = head.role
                && !unit.is_compatible(&SECOND)
            {
                let rule = "has a unit that is none of time";
                problems.push(self.problem(&head.name, rule, "write it as in s, ms or us"));
            }
        }
        if count(|role| matches!(role, Role::Time(_) | Role::Instant(_))) == 0
            && self.rate().is_none()
        {
            problems.push(self.no_time(heads));
        }
    }

    fn no_time(&self, heads: &[Head]) -> Problem {
        let wanted = self.time_name();
        let names = || heads.iter().map(|head| head.name.as_str());
        let way_out = match nearest(wanted, names()) {
            Some(near) => format!(
                "rename \"{near}\", write time = {{ column = \"{near}\", unit = \"s\" }} into a \
                 dataset.toml beside the file, or give the sample rate: --rate HZ"
            ),
            None => "name the column of time \"time\", or give the sample rate: --rate HZ".into(),
        };
        self.problem(wanted, "is missing: a log has times in s", way_out)
    }

    /// Reports units for columns that do not exist.
    fn check_units_given(&self, heads: &[Head], problems: &mut Vec<Problem>) {
        let names: Vec<&str> = heads.iter().map(|head| head.name.as_str()).collect();
        let explain = |name: &str| {
            let near = did_you_mean(name, names.iter().copied());
            format!("{near}the columns are {}", names.join(", "))
        };
        let known: BTreeSet<&str> = names.iter().copied().collect();
        for name in self.options.units.keys().filter(|name| !known.contains(name.as_str())) {
            problems.push(
                Problem::new(self.file, "has a unit but is no column of this log", explain(name))
                    .at(name),
            );
        }
        for dataset in self.datasets.iter().filter(|dataset| dataset.is_sidecar) {
            for (name, about) in &dataset.columns {
                if !known.contains(name.as_str()) {
                    let rule = format!("is no column of {}", self.file);
                    let problem = Problem::new(&dataset.file, rule, explain(name));
                    problems.push(problem.line(about.line).at(format!("columns.{name}")));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_names_that_would_not_be_read_again() {
        assert!(check_name("axis[1].hysteresis.w[3]").is_ok());
        // Legal names of FMI, which are quoted.
        assert!(["A[1,1]", "a\"b"].iter().all(|name| check_name(name).is_ok()));
        for (bad, like) in [
            ("", "_"),
            ("a\nb", "a_b"),
            (" a", "a"),
            ("y [um]", "y (um)"),
            ("y[um]", "y(um)"),
            ("\u{feff}time ", "_time"),
        ] {
            assert!(check_name(bad).is_err(), "{bad:?}");
            assert_eq!(writable(bad), like);
            assert!(check_name(&writable(bad)).is_ok());
        }
        assert_eq!((writable("time"), writable("record")), ("time_".into(), "record_".into()));
    }
}

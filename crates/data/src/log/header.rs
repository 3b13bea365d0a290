//! The header row: names, units in brackets, and which column plays which part.

use model::Unit;

use super::dataset::Dataset;
use super::{ColumnUnit, ReadOptions};
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
    /// Whole numbers that grow, one per sample period.
    Index,
    /// Number of the record.
    Record,
    /// A signal.
    Signal,
    /// None of these: why it cannot be used.
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

/// Name and unit of a cell of the header: `y [um]` and `y[um]` are y in um; `position[1]` is a name.
pub(super) fn split(cell: &str) -> (&str, Option<&str>) {
    let whole = cell.trim();
    let Some((name, unit)) = whole.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) else {
        return (whole, None);
    };
    let is_index = unit.chars().all(|c| c.is_ascii_digit() || matches!(c, ',' | ' '));
    let is_apart = name.ends_with(char::is_whitespace);
    if name.trim().is_empty() || (is_index && !is_apart) {
        return (whole, None);
    }
    (name.trim_end(), Some(unit.trim()))
}

/// What is known about the columns beside the header.
pub(super) struct Context<'a> {
    pub(super) file: &'a str,
    /// Line of the header, where the file has lines.
    pub(super) line: Option<usize>,
    pub(super) options: &'a ReadOptions,
    /// Nearest first.
    pub(super) datasets: &'a [Dataset],
}

impl Context<'_> {
    fn problem(&self, place: &str, rule: impl Into<String>, way_out: impl Into<String>) -> Problem {
        let problem = Problem::new(self.file, rule, way_out).at(place);
        match self.line {
            Some(line) => problem.line(line),
            None => problem,
        }
    }

    /// Sample rate for logs without times: the caller's goes before that of a dataset.
    pub(super) fn rate(&self) -> Option<f64> {
        self.options.rate.or_else(|| self.datasets.iter().find_map(|dataset| dataset.rate))
    }

    /// Name of the column of time.
    fn time_name(&self) -> &str {
        self.datasets.iter().find_map(|d| d.time_column.as_deref()).unwrap_or("time")
    }

    /// The columns that the header names, and everything that is wrong with them.
    pub(super) fn heads(&self, cells: &[String]) -> (Vec<Head>, Vec<Problem>) {
        let mut problems = Vec::new();
        let mut heads: Vec<Head> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        for (cell, number) in cells.iter().zip(1..) {
            let (name, unit) = split(cell);
            let role = self.role(name, number == 1);
            if name.is_empty() && role != Role::Index {
                let place = format!("column {number}");
                let way_out = "give it one, or remove a comma at the end of the line";
                problems.push(self.problem(&place, "has no name", way_out));
            } else if !seen.insert(name) {
                let way_out = "give each column its own name";
                problems.push(self.problem(name, "is the name of two columns", way_out));
            }
            let unit = self.unit(name, unit, &mut problems);
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
        self.check_roles(&heads, &mut problems);
        self.check_units_given(&heads, &mut problems);
        (heads, problems)
    }

    fn role(&self, name: &str, is_first: bool) -> Role {
        let is_time = name == self.time_name();
        match self.options.rate {
            Some(_) if is_time => Role::Index,
            _ if is_time => Role::Time(SECOND),
            _ if RECORD.contains(&name) => Role::Record,
            _ if is_first && self.rate().is_some() && INDEX.contains(&name) => Role::Index,
            _ => Role::Signal,
        }
    }

    /// The unit of a column: the caller's, the header's, a dataset's; why it is none where nobody knows it.
    fn unit(
        &self,
        name: &str,
        in_header: Option<&str>,
        problems: &mut Vec<Problem>,
    ) -> Result<Option<ColumnUnit>, String> {
        let in_dataset = self.datasets.iter().find_map(|dataset| {
            let text = if name == self.time_name() { dataset.time_unit.as_deref() } else { None };
            let text = text.or_else(|| dataset.columns.get(name)?.unit.as_deref());
            text.map(|text| (text, dataset))
        });
        let by_caller = self.options.units.get(name).map(String::as_str);
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
        if count(|role| matches!(role, Role::Time(_))) == 0 && self.rate().is_none() {
            problems.push(self.no_time(heads));
        }
    }

    fn no_time(&self, heads: &[Head]) -> Problem {
        let wanted = self.time_name();
        let names = || heads.iter().map(|head| head.name.as_str());
        let aliases = ["t", "Time", "TIME", "time_s", "t_s", "timestamp"];
        let near = nearest(wanted, names()).or_else(|| names().find(|n| aliases.contains(n)));
        let way_out = match near {
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
        for name in self.options.units.keys().filter(|name| !names.contains(&name.as_str())) {
            problems.push(
                Problem::new(self.file, "has a unit but is no column of this log", explain(name))
                    .at(name),
            );
        }
        for dataset in self.datasets.iter().filter(|dataset| dataset.is_sidecar) {
            for (name, about) in &dataset.columns {
                if !names.contains(&name.as_str()) {
                    let rule = format!("is no column of {}", self.file);
                    let problem = Problem::new(&dataset.file, rule, explain(name));
                    problems.push(problem.line(about.line).at(format!("columns.{name}")));
                }
            }
        }
    }
}

/// The unit of time.
pub(super) const SECOND: Unit =
    Unit { exponents: [0, 0, 1, 0, 0, 0, 0, 0], factor: 1.0, offset: 0.0 };

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tells_units_from_indices() {
        assert_eq!(split("y [um]"), ("y", Some("um")));
        assert_eq!(split("y[um]"), ("y", Some("um")));
        assert_eq!(split(" position[1] "), ("position[1]", None));
        assert_eq!(split("position[1] [um]"), ("position[1]", Some("um")));
        assert_eq!(split("x[1,2]"), ("x[1,2]", None));
        assert_eq!(split("ratio [1]"), ("ratio", Some("1")));
        assert_eq!(split("[um]"), ("[um]", None));
        assert_eq!(split("plain"), ("plain", None));
    }

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

    #[test]
    fn the_second_is_the_model_s() {
        assert_eq!(Unit::parse("s"), Ok(SECOND));
    }
}

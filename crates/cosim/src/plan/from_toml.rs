//! A plan from TOML.

use std::path::Path;

use data::{Problem, Problems};
use modeldescription::ssp::ParameterValue;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{Coupling, Master, Plan, PlannedConnection, PlannedFmu, PlannedInput, PlannedStart};
use crate::algorithm::IterationSettings;
use crate::error::Error;
use crate::unit::Transformations;

impl Plan {
    pub(super) fn read_toml(path: &Path) -> Result<Self, Error> {
        let text = files::read_text(path).map_err(|error| Error::Package {
            path: path.to_path_buf(),
            reason: format!("it cannot be read: {error}"),
        })?;
        Plan::parse_toml(&text, path)
    }

    /// Reads a plan from a text; paths in it are relative to the folder of `origin`.
    ///
    /// # Errors
    /// Everything that is wrong, with its lines.
    pub fn parse_toml(text: &str, origin: &Path) -> Result<Self, Error> {
        let mut reader = Reader::new(text, origin);
        let (document, errors) = DeTable::parse_recoverable(text);
        for error in errors.iter().take(MOST_REPORTED) {
            let rule = format!("is not valid TOML: {}", error.message());
            let at = error.span().map_or(0, |span| span.start);
            reader.report(at, "", "", &rule, "correct this line");
        }
        if errors.len() > MOST_REPORTED {
            let rule =
                format!("is not valid TOML in {} further places", errors.len() - MOST_REPORTED);
            reader.report(0, "", "", &rule, "is this the file that you meant?");
        }
        let plan = reader.plan(document.get_ref(), origin);
        if reader.problems.is_empty() {
            return Ok(plan);
        }
        // Where it is another file altogether, its keys say nothing more.
        let other = data::of_another_kind(text, "a system of FMUs");
        if let Some(rule) = other.strip_suffix(": ") {
            let problem =
                Problem::new(reader.file, rule, "give a file with [fmus] and [connections]");
            return Err(Error::File(problem.into()));
        }
        Err(Error::File(Problems::new(reader.problems)))
    }
}

/// Places that are no TOML and are reported one by one.
const MOST_REPORTED: usize = 3;

type Value<'i> = Spanned<DeValue<'i>>;

struct Reader {
    file: String,
    /// Byte at which each line starts.
    lines: Vec<usize>,
    problems: Vec<Problem>,
}

impl Reader {
    fn new(text: &str, origin: &Path) -> Self {
        let behind = text.match_indices('\n').map(|(at, _)| at + 1);
        let lines = std::iter::once(0).chain(behind).collect();
        Reader { file: origin.display().to_string(), lines, problems: Vec::new() }
    }

    fn line(&self, byte: usize) -> usize {
        self.lines.partition_point(|start| *start <= byte)
    }

    /// File and line of a value.
    fn place<T>(&self, value: &Spanned<T>) -> String {
        format!("{}:{}", self.file, self.line(value.span().start))
    }

    fn report(&mut self, byte: usize, place: &str, value: &str, rule: &str, way_out: &str) {
        let problem = Problem::new(&self.file, rule, way_out).line(self.line(byte));
        self.problems.push(problem.at(place).value(value));
    }

    fn plan(&mut self, root: &DeTable<'_>, origin: &Path) -> Plan {
        let tables = ["fmus", "connections", "inputs", "record", "iteration"];
        let keys = ["name", "start", "stop", "step", "algorithm", "order"];
        self.only(root, "", &[&keys[..], &tables[..]].concat());
        let stem = origin.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let folder = origin.parent().unwrap_or(Path::new(""));
        let mut plan = Plan {
            name: self.text(root, "", "name").or(stem).unwrap_or_default(),
            origin: origin.to_path_buf(),
            fmus: Vec::new(),
            connections: Vec::new(),
            inputs: Vec::new(),
            starts: Vec::new(),
            record: Vec::new(),
            master: self.master(root),
            notes: Vec::new(),
            undirected: false,
            names: Default::default(),
            _ssp: None,
        };
        for (name, value) in self.table(root, "fmus") {
            self.fmu(&mut plan, folder, &name, value);
        }
        if plan.fmus.is_empty() && self.problems.is_empty() {
            let way_out = "write, as in\n  [fmus]\n  plant = \"plant.fmu\"";
            self.report(0, "fmus", "", "a system has FMUs", way_out);
        }
        for (to, value) in self.table(root, "connections") {
            self.connection(&mut plan, &to, value);
        }
        for (to, value) in self.table(root, "inputs") {
            let Some(to) = self.port(&plan, "inputs", &to, value) else { continue };
            let Some(column) = self.is_text(value, "inputs") else { continue };
            let place = self.place(value);
            plan.inputs.push(PlannedInput { column, to, way: Transformations::default(), place });
        }
        for (name, value) in self.table(root, "record") {
            let Some(text) = self.is_text(value, "record") else { continue };
            let Some(port) = self.port(&plan, "record", &text, value) else { continue };
            plan.record.push((port, name));
        }
        plan
    }

    fn master(&mut self, root: &DeTable<'_>) -> Master {
        let coupling =
            self.text(root, "", "algorithm").map(|name| (Coupling::from_name(&name), name));
        if let Some((None, name)) = &coupling {
            let at = root.get("algorithm").map_or(0, |value| value.span().start);
            let rule =
                "must be \"gauss-seidel\", \"jacobi\", \"jacobi-extrapolated\" or \"iteration\"";
            self.report(at, "algorithm", name, rule, "correct the name");
        }
        let order = match root.get("order").map(|value| (value, value.get_ref())) {
            Some((_, DeValue::Array(names))) => {
                names.iter().filter_map(|name| self.is_text(name, "order")).collect()
            }
            Some((value, _)) => {
                let at = value.span().start;
                self.report(
                    at,
                    "order",
                    "",
                    "must be a list of names",
                    "write order = [\"a\", \"b\"]",
                );
                Vec::new()
            }
            None => Vec::new(),
        };
        let step = self.number(root, "", "step");
        if let Some(wrong) = step.filter(|step| *step <= 0.0) {
            let at = root.get("step").map_or(0, |value| value.span().start);
            self.report(at, "step", &wrong.to_string(), "must be greater than 0 s", "correct it");
        }
        Master {
            start: self.number(root, "", "start"),
            stop: self.number(root, "", "stop"),
            step,
            coupling: coupling.and_then(|(coupling, _)| coupling).unwrap_or_default(),
            order,
            iteration: self.iteration(root),
        }
    }

    fn iteration(&mut self, root: &DeTable<'_>) -> IterationSettings {
        let default = IterationSettings::default();
        let Some(value) = root.get("iteration") else { return default };
        let DeValue::Table(table) = value.get_ref() else {
            self.report(
                value.span().start,
                "iteration",
                "",
                "must be a table",
                "write [iteration]",
            );
            return default;
        };
        self.only(table, "iteration", &["relaxation", "tolerance", "iterations"]);
        let number = |this: &mut Self, key: &str| this.number(table, "iteration", key);
        IterationSettings {
            relaxation: super::relaxation(number(self, "relaxation")),
            tolerance: number(self, "tolerance").unwrap_or(default.tolerance),
            iterations: number(self, "iterations").map_or(default.iterations, |n| n as usize),
        }
    }

    fn fmu(&mut self, plan: &mut Plan, folder: &Path, name: &str, value: &Value<'_>) {
        let table = match value.get_ref() {
            DeValue::String(file) => {
                let path = folder.join(&**file);
                let place = self.place(value);
                plan.fmus.push(PlannedFmu { name: name.to_owned(), path, place, step: None });
                return;
            }
            DeValue::Table(table) => table,
            _ => {
                let rule = "must be a file or a table with file, step and start";
                let way_out = "write the path of the FMU in quotes";
                return self.report(value.span().start, &format!("fmus.{name}"), "", rule, way_out);
            }
        };
        let place = format!("fmus.{name}");
        self.only(table, &place, &["file", "step", "start"]);
        let Some(file) = self.text(table, &place, "file") else {
            let way_out = "add file = \"….fmu\"";
            return self.report(value.span().start, &place, "", "names no file", way_out);
        };
        let step = self.number(table, &place, "step");
        plan.fmus.push(PlannedFmu {
            name: name.to_owned(),
            path: folder.join(file),
            place: self.place(value),
            step,
        });
        for (variable, value) in self.table(table, "start") {
            let at = format!("{place}.start.{variable}");
            let Some(value_of) = self.value(value, &at) else { continue };
            plan.starts.push(PlannedStart {
                to: (name, variable).into(),
                value: value_of,
                way: Transformations::default(),
                place: format!("{}:{}: {at}", self.file, self.line(value.span().start)),
                optional: false,
            });
        }
    }

    fn connection(&mut self, plan: &mut Plan, to: &str, value: &Value<'_>) {
        let place = format!("connections.\"{to}\"");
        let Some(to) = self.port(plan, "connections", to, value) else { return };
        let (from, way) = match value.get_ref() {
            DeValue::Table(table) => {
                self.only(table, &place, &["from", "factor", "offset", "convert"]);
                let factor = self.number(table, &place, "factor").unwrap_or(1.0);
                let offset = self.number(table, &place, "offset").unwrap_or(0.0);
                let convert = self.flag(table, &place, "convert").unwrap_or(true);
                let Some(from) = self.text(table, &place, "from") else {
                    let way_out = "add from = \"fmu.variable\"";
                    return self.report(value.span().start, &place, "", "has no source", way_out);
                };
                (from, Transformations::scaled(factor, offset, !convert))
            }
            _ => match self.is_text(value, &place) {
                Some(from) => (from, Transformations::default()),
                None => return,
            },
        };
        let Some(from) = self.port(plan, &place, &from, value) else { return };
        let place = self.place(value);
        plan.connections.push(PlannedConnection { from, to, way, place });
    }

    fn port(
        &mut self,
        plan: &Plan,
        place: &str,
        text: &str,
        value: &Value<'_>,
    ) -> Option<crate::Port> {
        let port = plan.port(text);
        if port.is_none() {
            let there: Vec<&str> = plan.fmus.iter().map(|fmu| fmu.name.as_str()).collect();
            let rule = format!("must be fmu.variable with one of the FMUs {}", there.join(", "));
            self.report(value.span().start, place, text, &rule, "correct the name");
        }
        port
    }

    fn value(&mut self, value: &Value<'_>, place: &str) -> Option<ParameterValue> {
        match value.get_ref() {
            DeValue::Boolean(truth) => Some(ParameterValue::Boolean(vec![*truth])),
            DeValue::String(text) => Some(ParameterValue::Text(vec![text.to_string()])),
            DeValue::Integer(number) => {
                let parsed = i64::from_str_radix(number.as_str(), number.radix()).ok();
                parsed.map(|number| ParameterValue::Integer(vec![number]))
            }
            _ => self.is_number(value, place).map(|number| ParameterValue::Real(vec![number])),
        }
    }

    /// The entries of a table below another one.
    fn table<'t, 'i>(&mut self, root: &'t DeTable<'i>, key: &str) -> Vec<(String, &'t Value<'i>)> {
        match root.get(key).map(|value| (value, value.get_ref())) {
            Some((_, DeValue::Table(table))) => {
                let mut entries: Vec<_> =
                    table.iter().map(|(key, value)| (key.get_ref().to_string(), value)).collect();
                // In the order of the file: it decides who steps first among equals.
                entries.sort_by_key(|(_, value)| value.span().start);
                entries
            }
            Some((value, _)) => {
                let way_out = format!("write [{key}]");
                self.report(value.span().start, key, "", "must be a table", &way_out);
                Vec::new()
            }
            None => Vec::new(),
        }
    }

    fn only(&mut self, table: &DeTable<'_>, place: &str, known: &[&str]) {
        for (key, _) in table.iter() {
            let name: &str = key.get_ref();
            if !known.contains(&name) {
                let near = data::nearest(name, known.iter().copied());
                let way_out = near.map_or_else(
                    || format!("known here: {}", known.join(", ")),
                    |near| format!("did you mean {near}?"),
                );
                let place =
                    if place.is_empty() { name.to_owned() } else { format!("{place}.{name}") };
                self.report(key.span().start, &place, "", "is no key", &way_out);
            }
        }
    }

    fn text(&mut self, table: &DeTable<'_>, place: &str, key: &str) -> Option<String> {
        let place = joined(place, key);
        table.get(key).and_then(|value| self.is_text(value, &place))
    }

    fn number(&mut self, table: &DeTable<'_>, place: &str, key: &str) -> Option<f64> {
        let place = joined(place, key);
        table.get(key).and_then(|value| self.is_number(value, &place))
    }

    fn flag(&mut self, table: &DeTable<'_>, place: &str, key: &str) -> Option<bool> {
        let value = table.get(key)?;
        if let DeValue::Boolean(truth) = value.get_ref() {
            return Some(*truth);
        }
        let place = joined(place, key);
        self.report(value.span().start, &place, "", "must be true or false", "correct it");
        None
    }

    fn is_text(&mut self, value: &Value<'_>, place: &str) -> Option<String> {
        if let DeValue::String(text) = value.get_ref() {
            return Some(text.to_string());
        }
        self.report(value.span().start, place, "", "must be a text", "write it in quotes");
        None
    }

    fn is_number(&mut self, value: &Value<'_>, place: &str) -> Option<f64> {
        let number = match value.get_ref() {
            DeValue::Integer(n) => {
                i64::from_str_radix(n.as_str(), n.radix()).ok().map(|n| n as f64)
            }
            DeValue::Float(x) => x.as_str().parse().ok(),
            _ => None,
        };
        let number: Option<f64> = number.filter(|number: &f64| number.is_finite());
        if number.is_none() {
            self.report(value.span().start, place, "", "must be a finite number", "correct it");
        }
        number
    }
}

fn joined(place: &str, key: &str) -> String {
    if place.is_empty() { key.to_owned() } else { format!("{place}.{key}") }
}

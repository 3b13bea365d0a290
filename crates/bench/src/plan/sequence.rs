//! What is played, one step after the other, as rows of one cycle each.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use data::{Log, ReadOptions};
use serde::Deserialize;

use super::{Plan, PlanError};

/// One step of a sequence.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Step {
    /// Stays for a time.
    Rest {
        /// How long, s.
        seconds: f64,
        /// Where, axis by axis; default: where the step before ended (at the begin 0).
        at: Option<Vec<f64>>,
    },
    /// A test signal of `piezoloop signal`.
    Signal {
        /// The signal's name.
        name: String,
        /// The name's parameters.
        #[serde(default)]
        set: BTreeMap<String, f64>,
        /// The axis that plays it, from 1; default: channel i on axis i. The others stay.
        axis: Option<usize>,
        /// Factor on its values.
        gain: Option<f64>,
        /// Added to its values.
        offset: Option<f64>,
    },
    /// A trajectory from a log, with a column for each axis, or for some.
    Log {
        /// The file.
        file: PathBuf,
    },
    /// The next experiment of a diagnosis.
    Experiment {
        /// The experiment's `gap.json`.
        file: PathBuf,
    },
}

/// How the values of an axis are called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Channel {
    pub(super) name: String,
    pub(super) unit: Option<String>,
}

/// Longest table that is made: rows times axes.
const MOST_VALUES: usize = 200_000_000;

/// Rows of the steps of a plan.
pub(super) struct Table<'a> {
    plan: &'a Plan,
    channels: &'a [Channel],
    period: f64,
    /// Between two rows of a source: a line, not a step.
    interpolates: bool,
    last: Vec<f64>,
    values: Vec<f64>,
    /// What was assumed about logs and left out of them.
    notes: Vec<String>,
}

/// A source of one step: its own times, and values for some axes.
struct Source {
    time: Vec<f64>,
    axes: Vec<(usize, Vec<f64>)>,
    /// How long its last row lasts, s.
    tail: f64,
}

impl<'a> Table<'a> {
    pub(super) fn new(
        plan: &'a Plan,
        channels: &'a [Channel],
        period: f64,
        interpolates: bool,
    ) -> Self {
        let last = vec![0.0; channels.len()];
        Table { plan, channels, period, interpolates, last, values: Vec::new(), notes: Vec::new() }
    }

    /// Row by row, axis by axis; and what was said about the logs.
    ///
    /// # Errors
    /// Every step that cannot be played.
    pub(super) fn rows(mut self) -> Result<(Vec<f64>, Vec<String>), PlanError> {
        let mut problems = Vec::new();
        for (index, step) in self.plan.sequence.iter().enumerate() {
            if let Err(problem) = self.add(step) {
                let name = self.plan.name();
                problems.push(format!("{name}: step {} of the sequence: {problem}", index + 1));
            }
        }
        if self.values.is_empty() && problems.is_empty() {
            problems.push(format!(
                "{}: nothing is played; give [[sequence]] in the plan, or --reference FILE",
                self.plan.name()
            ));
        }
        if problems.is_empty() { Ok((self.values, self.notes)) } else { Err(PlanError(problems)) }
    }

    fn add(&mut self, step: &Step) -> Result<(), String> {
        match step {
            Step::Rest { seconds, at } => self.rest(*seconds, at.as_deref()),
            Step::Signal { name, set, axis, gain, offset } => {
                let source = self.signal(name, set, *axis)?;
                let (gain, offset) = (gain.unwrap_or(1.0), offset.unwrap_or(0.0));
                self.play(source, gain, offset)
            }
            Step::Log { file } => {
                let source = self.log(&self.plan.beside(file))?;
                self.play(source, 1.0, 0.0)
            }
            Step::Experiment { file } => {
                let source = self.experiment(&self.plan.beside(file))?;
                self.play(source, 1.0, 0.0)
            }
        }
    }

    fn rest(&mut self, seconds: f64, at: Option<&[f64]>) -> Result<(), String> {
        if let Some(at) = at {
            if at.len() != self.channels.len() {
                return Err(format!("at has {} values for {} axes", at.len(), self.channels.len()));
            }
            self.last = at.to_vec();
        }
        if !(seconds.is_finite() && seconds >= 0.0) {
            return Err(format!("seconds = {seconds} must be 0 or more"));
        }
        let rows = (seconds / self.period).round() as usize;
        self.room(rows)?;
        for _ in 0..rows {
            self.values.extend(&self.last);
        }
        Ok(())
    }

    fn room(&self, rows: usize) -> Result<(), String> {
        let total = rows.saturating_mul(self.channels.len()).saturating_add(self.values.len());
        if total > MOST_VALUES {
            return Err(format!(
                "the sequence would have {total} values; at most {MOST_VALUES} are played at once"
            ));
        }
        Ok(())
    }

    fn signal(
        &self,
        name: &str,
        set: &BTreeMap<String, f64>,
        axis: Option<usize>,
    ) -> Result<Source, String> {
        let kind = signals::lookup(name).map_err(|error| error.to_string())?;
        let given: Vec<(&str, f64)> =
            set.iter().map(|(key, value)| (key.as_str(), *value)).collect();
        let signal = kind.generate(&given).map_err(|error| error.to_string())?;
        let count = self.channels.len();
        let first = match axis {
            Some(axis) if (1..=count).contains(&axis) => axis - 1,
            Some(axis) => return Err(format!("axis = {axis}: there are axes 1 to {count}")),
            None => 0,
        };
        if first + signal.channels.len() > count {
            return Err(format!(
                "{name} has {} channels, from axis {} on there are {}",
                signal.channels.len(),
                first + 1,
                count - first
            ));
        }
        let time = (0..signal.len()).map(|n| signal.time(n)).collect();
        let channels = signal.channels.into_iter().map(|channel| channel.values);
        Ok(Source { time, axes: (first..).zip(channels).collect(), tail: signal.period })
    }

    fn log(&mut self, path: &Path) -> Result<Source, String> {
        let log = Log::read(path, &ReadOptions::default()).map_err(|e| e.to_string())?;
        self.notes.extend(log.notes());
        if log.records().len() != 1 {
            let count = log.records().len();
            return Err(format!("{}: has {count} records; give them one by one", path.display()));
        }
        let mut axes = Vec::new();
        for (axis, channel) in self.channels.iter().enumerate() {
            // One column for one axis needs no name in common: a diagnosis calls a command `u`.
            let name = match (log.columns(), self.channels) {
                ([only], [_]) => &only.name,
                _ => &channel.name,
            };
            if log.column(name).is_none() {
                continue;
            }
            let values = match &channel.unit {
                Some(unit) => log.convert(name, unit).map_err(|e| e.to_string())?,
                None => log.require(name).map_err(|e| e.to_string())?.values.clone(),
            };
            axes.push((axis, values));
        }
        if axes.is_empty() {
            let has: Vec<&str> = log.columns().iter().map(|column| column.name.as_str()).collect();
            return Err(format!(
                "{}: has none of the columns {}; it has {}; name them in the plan with [[axis]] {}",
                path.display(),
                self.names(),
                has.join(", "),
                self.key()
            ));
        }
        let time = log.time().to_vec();
        let tail = match time[..] {
            [.., before, last] => last - before,
            _ => self.period,
        };
        Ok(Source { time, axes, tail })
    }

    /// The key of a plan that names its columns.
    fn key(&self) -> &'static str {
        if self.interpolates { "reference = …" } else { "command = …" }
    }

    fn names(&self) -> String {
        let names: Vec<&str> = self.channels.iter().map(|channel| channel.name.as_str()).collect();
        names.join(", ")
    }

    fn experiment(&self, path: &Path) -> Result<Source, String> {
        #[derive(Deserialize)]
        struct Gap {
            next_experiment: Option<Next>,
        }
        #[derive(Deserialize)]
        struct Next {
            period: Option<f64>,
            columns: BTreeMap<String, Vec<f64>>,
        }
        let text = files::read_text(path)
            .map_err(|error| format!("{}: cannot be read: {error}", path.display()))?;
        let gap: Gap = serde_json::from_str(&text)
            .map_err(|error| format!("{}: is no gap.json: {error}", path.display()))?;
        let next = gap
            .next_experiment
            .ok_or_else(|| format!("{}: proposes no next experiment", path.display()))?;
        let period = next.period.filter(|period| *period > 0.0).unwrap_or(self.period);
        let mut axes = Vec::new();
        let alone = next.columns.len() == 1 && self.channels.len() == 1;
        for (name, values) in next.columns {
            match self.channels.iter().position(|channel| alone || channel.name == name) {
                Some(axis) => axes.push((axis, values)),
                None => {
                    return Err(format!(
                        "{}: its column {name} is none of {}; an experiment of a plant plays \
                         commands: leave `controller` out, and name the columns with [[axis]] {}",
                        path.display(),
                        self.names(),
                        self.key()
                    ));
                }
            }
        }
        let rows = axes.iter().map(|(_, values)| values.len()).min().unwrap_or(0);
        if rows == 0 {
            return Err(format!("{}: its next experiment has no samples to play", path.display()));
        }
        let time = (0..rows).map(|k| k as f64 * period).collect();
        Ok(Source { time, axes, tail: period })
    }

    fn play(&mut self, source: Source, gain: f64, offset: f64) -> Result<(), String> {
        let (Some(first), Some(last)) = (source.time.first(), source.time.last()) else {
            return Err("has no rows".to_owned());
        };
        let rows = ((last - first + source.tail) / self.period).round() as usize;
        self.room(rows)?;
        let mut place = 0;
        for row in 0..rows {
            let time = first + row as f64 * self.period;
            // A row whose time is reached but for rounding is reached.
            let reached = time + 1e-6 * self.period;
            while source.time.get(place + 1).is_some_and(|next| *next <= reached) {
                place += 1;
            }
            for (axis, values) in &source.axes {
                let value = self.value(&source.time, values, place, time);
                self.last[*axis] = offset + gain * value;
            }
            self.values.extend(&self.last);
        }
        Ok(())
    }

    fn value(&self, times: &[f64], values: &[f64], place: usize, time: f64) -> f64 {
        let held = values.get(place).copied().unwrap_or_default();
        let (Some(next), true) = (values.get(place + 1), self.interpolates) else { return held };
        let (from, to) = (times[place], times[place + 1]);
        let part = ((time - from) / (to - from)).clamp(0.0, 1.0);
        if part < 1e-6 { held } else { held + part * (next - held) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channels() -> Vec<Channel> {
        let unit = Some("um".to_owned());
        ["reference[1]", "reference[2]"]
            .map(|name| Channel { name: name.to_owned(), unit: unit.clone() })
            .into()
    }

    fn rows(text: &str, folder: &Path, period: f64, lines: bool) -> Result<Vec<f64>, PlanError> {
        let mut plan = Plan::parse(text, "plan.toml")?;
        plan.origin = Some(folder.join("plan.toml"));
        Table::new(&plan, &channels(), period, lines).rows().map(|(rows, _)| rows)
    }

    #[test]
    fn steps_follow_each_other() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("r.csv"), "time,reference[2] [nm]\n0,1000\n0.2,3000\n")
            .unwrap();
        let text = "[[sequence]]\nkind = \"rest\"\nseconds = 0.2\nat = [5, 6]\n\
                    [[sequence]]\nkind = \"log\"\nfile = \"r.csv\"\n\
                    [[sequence]]\nkind = \"rest\"\nseconds = 0.1\n";
        let found = rows(text, folder.path(), 0.1, true).unwrap();
        let expected = [5.0, 6.0, 5.0, 6.0, 5.0, 1.0, 5.0, 2.0, 5.0, 3.0, 5.0, 3.0, 5.0, 3.0];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
        assert_eq!(found.len(), expected.len());
        // Commands are held, not interpolated.
        let held = rows(text, folder.path(), 0.1, false).unwrap();
        assert!((held[7] - 1.0).abs() < 1e-9);
    }

    #[test]
    fn signals_and_experiments() {
        let folder = tempfile::tempdir().unwrap();
        let gap = r#"{"next_experiment": {"period": 0.1, "columns": {"reference[1]": [1, 2, 3]}}}"#;
        std::fs::write(folder.path().join("gap.json"), gap).unwrap();
        let text = "[[sequence]]\nkind = \"experiment\"\nfile = \"gap.json\"\n";
        let found = rows(text, folder.path(), 0.1, false).unwrap();
        assert_eq!(found, [1.0, 0.0, 2.0, 0.0, 3.0, 0.0]);
        let text = "[[sequence]]\nkind = \"signal\"\nname = \"p3-chirp\"\naxis = 2\n\
                    gain = 0.5\nset = { duration = 0.1 }\n";
        let found = rows(text, folder.path(), 50e-6, true).unwrap();
        assert_eq!(found.len(), 2 * 2000);
        assert!(found.chunks(2).all(|row| row[0] == 0.0) && found[3] != found[1]);
    }

    #[test]
    fn one_column_for_one_axis_needs_no_name() {
        let folder = tempfile::tempdir().unwrap();
        let gap = r#"{"next_experiment": {"period": 0.1, "columns": {"u": [1, 2]}}}"#;
        std::fs::write(folder.path().join("gap.json"), gap).unwrap();
        std::fs::write(folder.path().join("next.csv"), "time [s],u [V]\n0,3\n0.1,4\n").unwrap();
        let text = "[[sequence]]\nkind = \"experiment\"\nfile = \"gap.json\"\n\
                    [[sequence]]\nkind = \"log\"\nfile = \"next.csv\"\n";
        let mut plan = Plan::parse(text, "plan.toml").unwrap();
        plan.origin = Some(folder.path().join("plan.toml"));
        let one = [Channel { name: "command[1]".into(), unit: Some("V".into()) }];
        assert_eq!(Table::new(&plan, &one, 0.1, false).rows().unwrap().0, [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn every_step_that_cannot_be_played_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("r.csv"), "time,x\n0,1\n1,2\n").unwrap();
        std::fs::write(folder.path().join("gap.json"), r#"{"next_experiment": null}"#).unwrap();
        let text = "[[sequence]]\nkind = \"rest\"\nseconds = -1\n\
                    [[sequence]]\nkind = \"log\"\nfile = \"r.csv\"\n\
                    [[sequence]]\nkind = \"signal\"\nname = \"p3-chirpp\"\n\
                    [[sequence]]\nkind = \"signal\"\nname = \"p3-chirp\"\naxis = 3\n\
                    [[sequence]]\nkind = \"experiment\"\nfile = \"gap.json\"\n";
        let problems = rows(text, folder.path(), 0.1, true).unwrap_err().0;
        assert_eq!(problems.len(), 5, "{problems:?}");
        for (problem, word) in problems.iter().zip(["seconds", "it has x", "p3-chirp", "1 to 2"]) {
            assert!(problem.contains(word), "{problem}");
        }
    }
}

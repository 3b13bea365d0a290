//! The file of a sweep.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use data::{Problem, Problems};
use serde::Deserialize;
use toml::Spanned;

/// A sweep as its file describes it; what varies is checked against the FMUs by
/// [`Design`](crate::Design).
///
/// ```toml
/// runs = 10000                       # of each combination of what stands under `grid`
/// seed = 7                           # of all that is drawn
///
/// [loop]                             # or [system], [identify], [diagnose]
/// plant = "evc"
/// controller = "controller.toml"
/// reference = "reference.csv"
///
/// [vary]
/// "plant.axis[1].mechanics.frequency" = { tolerance = 0.05 }
/// "controller.axis[1].pid.kp" = { grid = [0.01, 0.02] }
/// ```
#[derive(Clone, Debug)]
pub struct Plan {
    /// The file.
    pub origin: PathBuf,
    /// The plan's text.
    pub text: String,
    /// Runs of each combination of the grids.
    pub runs: Option<u64>,
    /// Seed of all that is drawn.
    pub seed: u64,
    /// What a run is.
    pub kind: Kind,
    /// What differs from run to run, in the order of the file: name, line, law.
    pub vary: Vec<(String, usize, Law)>,
    /// What is kept of a run's signals, in the order of the file: name, line, figure.
    pub measure: Vec<(String, usize, Measure)>,
}

/// What a run is.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A plant and a controller in a closed loop.
    Loop(ClosedLoop),
    /// A system of any FMUs.
    System(SystemRun),
    /// A log, measured or simulated, that is identified.
    Identify(Campaign),
    /// A log, measured or simulated, that is diagnosed.
    Diagnose(Campaign),
}

/// A closed loop, as `piezoloop simulate --loop` runs it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ClosedLoop {
    /// FMU, blueprint or rig.
    pub plant: String,
    /// FMU or blueprint.
    pub controller: String,
    /// Log with the references.
    pub reference: String,
    /// Controller input = column of the log.
    #[serde(default)]
    pub map: BTreeMap<String, String>,
    /// Unit of a column of the log.
    #[serde(default)]
    pub unit: BTreeMap<String, String>,
    /// Who steps first.
    #[serde(default)]
    pub coupling: Coupling,
    /// Communication step in s.
    pub step: Option<f64>,
    /// End of a run in s.
    pub stop: Option<f64>,
    /// Time in s from which runs are judged.
    #[serde(default)]
    pub from: f64,
    /// Every effect of the library is in the plant, switched off.
    #[serde(default)]
    pub all_effects: bool,
    /// Start values of all runs: plant.NAME or controller.NAME.
    #[serde(default)]
    pub start: BTreeMap<String, Scalar>,
    /// A new instance for each run, for FMUs that `fmi2Reset` does not lead back.
    #[serde(default)]
    pub new_instances: bool,
}

/// Who steps first in a loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coupling {
    /// The command acts at once.
    #[default]
    ControllerFirst,
    /// The command acts one step later.
    SideBySide,
}

/// A system, as `piezoloop system` runs it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SystemRun {
    /// The system: .toml or .ssp.
    pub file: String,
    /// The input table.
    pub input: Option<String>,
    /// Parameter sets (SSV).
    #[serde(default)]
    pub parameters: Vec<String>,
    /// Input = column of the table.
    #[serde(default)]
    pub map: BTreeMap<String, String>,
    /// Unit of a column of the table.
    #[serde(default)]
    pub unit: BTreeMap<String, String>,
    /// Communication step in s.
    pub step: Option<f64>,
    /// End of a run in s.
    pub stop: Option<f64>,
    /// Time in s from which runs are judged.
    #[serde(default)]
    pub from: f64,
    /// Start values of all runs: FMU.NAME.
    #[serde(default)]
    pub start: BTreeMap<String, Scalar>,
    /// A new instance for each run, for FMUs that `fmi2Reset` does not lead back.
    #[serde(default)]
    pub new_instances: bool,
}

/// A campaign of identifications or diagnoses.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Campaign {
    /// FMU, blueprint or rig that is played: its parameters may vary as machine.NAME.
    pub machine: Option<String>,
    /// Logs of the campaign: what drives the machine, or, without one, measured logs.
    #[serde(default)]
    pub logs: Vec<String>,
    /// Logs that are only used to judge a diagnosis.
    #[serde(default)]
    pub holdout: Vec<String>,
    /// FMU, blueprint or rig that is diagnosed.
    pub model: Option<String>,
    /// Variable of machine or model = column of the logs.
    #[serde(default)]
    pub map: BTreeMap<String, String>,
    /// Unit of a column of the logs.
    #[serde(default)]
    pub unit: BTreeMap<String, String>,
    /// Start values of all runs: machine.NAME.
    #[serde(default)]
    pub start: BTreeMap<String, Scalar>,
    /// Further options of the command, as in ["--plays", "10"].
    #[serde(default)]
    pub options: Vec<String>,
}

/// A value of any type.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Scalar {
    /// True or false.
    Truth(bool),
    /// A whole number.
    Integer(i64),
    /// A real number.
    Real(f64),
    /// A text.
    Text(String),
}

impl std::fmt::Display for Scalar {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Scalar::Truth(value) => write!(f, "{value}"),
            Scalar::Integer(value) => write!(f, "{value}"),
            Scalar::Real(value) => write!(f, "{value}"),
            Scalar::Text(value) => f.write_str(value),
        }
    }
}

/// How a value differs from run to run.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// Normal around the start value, with this part of it as standard deviation.
    Tolerance(f64),
    /// Uniform within this part of the start value, up and down.
    Within(f64),
    /// Normal: mean, standard deviation.
    Normal([f64; 2]),
    /// Uniform: least, greatest.
    Uniform([f64; 2]),
    /// Uniform in the logarithm: least, greatest.
    LogUniform([f64; 2]),
    /// A whole number, uniform: least, greatest.
    #[serde(rename = "whole")]
    Integer([i64; 2]),
    /// One of these, each as likely.
    Choice(Vec<Scalar>),
    /// Each of these, with each combination of the other grids.
    Grid(Vec<Scalar>),
}

/// A figure of a recorded signal.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Column of the record.
    pub column: String,
    /// Column that is taken off, value by value.
    pub minus: Option<String>,
    /// What is taken of it.
    pub take: Take,
}

/// What is taken of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Take {
    /// Root mean square.
    Rms,
    /// Mean.
    Mean,
    /// Least value.
    Min,
    /// Greatest value.
    Max,
    /// Greatest absolute value.
    Peak,
    /// Last value.
    Last,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    runs: Option<Spanned<u64>>,
    #[serde(default = "one")]
    seed: u64,
    #[serde(rename = "loop")]
    closed_loop: Option<ClosedLoop>,
    system: Option<SystemRun>,
    identify: Option<Campaign>,
    diagnose: Option<Campaign>,
    #[serde(default)]
    vary: BTreeMap<Spanned<String>, Law>,
    #[serde(default)]
    measure: BTreeMap<Spanned<String>, Measure>,
}

fn one() -> u64 {
    1
}

impl Plan {
    /// Reads a plan from its text; `origin` is its file, for messages.
    ///
    /// # Errors
    /// What is wrong with the text, with its line.
    pub fn parse(text: &str, origin: &Path) -> Result<Self, Problems> {
        let file = origin.display().to_string();
        let ends: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).collect();
        let line = |byte: usize| 1 + ends.partition_point(|end| *end < byte);
        let read: Text = toml::from_str(text).map_err(|error| {
            let way_out = "docs/sweep.md and `piezoloop sweep --help` have a plan with every key";
            let at = error.span().map_or(1, |span| line(span.start));
            let other = data::of_another_kind(text, "a plan of a sweep");
            let rule = format!("{other}{}", error.message());
            Problems::from(Problem::new(&file, rule, way_out).line(at))
        })?;
        let kinds = [
            read.closed_loop.map(Kind::Loop),
            read.system.map(Kind::System),
            read.identify.map(Kind::Identify),
            read.diagnose.map(Kind::Diagnose),
        ];
        let mut kinds: Vec<Kind> = kinds.into_iter().flatten().collect();
        let (Some(kind), true) = (kinds.pop(), kinds.is_empty()) else {
            let other = data::of_another_kind(text, "a plan of a sweep");
            let rule = format!(
                "{other}a plan has one of the tables [loop], [system], [identify], [diagnose]"
            );
            return Err(Problem::new(&file, rule, "say what a run is").into());
        };
        if let Some(runs) = read.runs.as_ref().filter(|runs| *runs.get_ref() == 0) {
            let problem = Problem::new(&file, "must be at least 1", "say how many runs there are");
            return Err(problem.line(line(runs.span().start)).at("runs").value(0).into());
        }
        Ok(Plan {
            origin: origin.to_owned(),
            text: text.to_owned(),
            runs: read.runs.map(Spanned::into_inner),
            seed: read.seed,
            kind,
            vary: in_order(read.vary, line),
            measure: in_order(read.measure, line),
        })
    }

    /// A problem of this plan at a line (0: none) and place.
    #[must_use]
    pub fn problem(&self, line: usize, place: &str, rule: &str, way_out: &str) -> Problem {
        let problem = Problem::new(self.origin.display().to_string(), rule, way_out).at(place);
        if line > 0 { problem.line(line) } else { problem }
    }
}

/// The entries of a table in the order of the file, with their lines.
fn in_order<T>(
    table: BTreeMap<Spanned<String>, T>,
    line: impl Fn(usize) -> usize,
) -> Vec<(String, usize, T)> {
    let mut entries: Vec<_> = table.into_iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    let named = |(name, value): (Spanned<String>, T)| {
        let at = line(name.span().start);
        (name.into_inner(), at, value)
    };
    entries.into_iter().map(named).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOP: &str = "[loop]\nplant = \"evc\"\ncontroller = \"c.toml\"\nreference = \"r.csv\"\n";

    fn parsed(text: &str) -> Result<Plan, String> {
        Plan::parse(text, Path::new("plan.toml")).map_err(|problems| problems.to_string())
    }

    #[test]
    fn a_plan_is_read_in_its_order() {
        let vary = "[vary]\n\"plant.b\" = { tolerance = 0.05 }\n\"plant.a\" = { grid = [1, 2.5] }\n\
                    \"c\" = { choice = [true, \"x\"] }\n\"d\" = { log-uniform = [1, 10] }\n";
        let plan = parsed(&format!("runs = 7\n{LOOP}{vary}")).unwrap();
        let names: Vec<_> =
            plan.vary.iter().map(|(name, line, _)| (name.as_str(), *line)).collect();
        assert_eq!(names, [("plant.b", 7), ("plant.a", 8), ("c", 9), ("d", 10)]);
        assert_eq!(plan.vary[1].2, Law::Grid(vec![Scalar::Integer(1), Scalar::Real(2.5)]));
        assert_eq!((plan.runs, plan.seed), (Some(7), 1));
        assert!(matches!(plan.kind, Kind::Loop(ClosedLoop { from: 0.0, .. })));
    }

    #[test]
    fn what_is_wrong_is_reported_with_its_line() {
        for (text, words) in [
            (format!("{LOOP}cotroller = 1\n"), ["plan.toml:5:", "cotroller"]),
            (format!("{LOOP}[vary]\nx = {{ unform = [1, 2] }}\n"), ["plan.toml:6:", "log-uniform"]),
            (format!("runs = 0\n{LOOP}"), ["plan.toml:1: runs = 0:", "at least 1"]),
            ("runs = 3\n".to_owned(), ["[diagnose]", "what a run is"]),
            (format!("{LOOP}[system]\nfile = \"a.ssp\"\n"), ["one of the tables", "[loop]"]),
            ("runs = \n".to_owned(), ["plan.toml:1:", "docs/sweep.md"]),
            (
                format!("{LOOP}[measure]\na = {{ column = \"x\", take = \"rsm\" }}\n"),
                [":6:", "peak"],
            ),
        ] {
            let messages = parsed(&text).unwrap_err();
            assert!(words.iter().all(|word| messages.contains(word)), "{text}: {messages}");
        }
    }
}

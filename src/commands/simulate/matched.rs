//! Which columns of a log and which inputs of an FMU have found each other.

use cosim::Fmu;
use data::{Log, NameMap};
use modeldescription::variable::{Causality, Variability};

use crate::fmus::Addresses;

/// Names that a note lists.
const LISTED: usize = 8;

/// What has not found its counterpart.
#[derive(Clone, Debug, Default)]
pub(super) struct Matched {
    /// Columns that neither feed a variable nor measure an output.
    pub(super) unused_columns: Vec<String>,
    /// Inputs that no column feeds.
    pub(super) unfed_inputs: Vec<String>,
}

impl Matched {
    /// Holds the log against the FMU; `map` says which column feeds which variable.
    ///
    /// # Errors
    /// The log has columns and the FMU inputs, but nothing fits.
    pub(super) fn of(
        fmu: &Fmu,
        addresses: &Addresses,
        names: &NameMap,
        map: &[(String, String)],
        log: &Log,
    ) -> anyhow::Result<Self> {
        let inputs = fmu.names(Causality::Input);
        let outputs = fmu.names(Causality::Output);
        let measures: Vec<String> =
            outputs.iter().filter_map(|o| addresses.measured_column(o, names, log)).collect();
        let version = fmu.description().fmi_version;
        // The column of a tunable parameter's name feeds it, too.
        let tunes = |column: &str| {
            let found = fmu.variable(column).ok();
            found.is_some_and(|v| {
                v.causality == Causality::Parameter
                    && v.variability(version) == Variability::Tunable
            })
        };
        let is_fed = |input: &&String| map.iter().any(|(variable, _)| variable == *input);
        let feeds = |column: &str| map.iter().any(|(_, from)| from == column) || tunes(column);
        let columns = || log.columns().iter().map(|column| column.name.as_str());
        let unused = columns().filter(|c| !feeds(c) && !measures.iter().any(|m| m == c));
        let matched = Matched {
            unused_columns: unused.map(str::to_owned).collect(),
            unfed_inputs: inputs.iter().filter(|input| !is_fed(input)).cloned().collect(),
        };
        if !inputs.is_empty()
            && columns().next().is_some()
            && matched.unused_columns.len() == columns().count()
        {
            let near = inputs.iter().find_map(|input| {
                let column = columns().find(|column| column.eq_ignore_ascii_case(input))?;
                Some(format!("--map {input}={column}"))
            });
            let first = inputs.first().map(String::as_str).unwrap_or_default();
            let example = columns().next().unwrap_or_default();
            anyhow::bail!(
                "{}: no column feeds an input of the FMU, and none measures an output: the columns are {}, the \
                 inputs {}; assign a column with {}",
                log.origin(),
                list(&matched.unused_columns),
                list(&inputs),
                near.unwrap_or_else(|| format!("--map {first}={example}"))
            );
        }
        Ok(matched)
    }

    /// What has not found its counterpart, as sentences.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.unfed_inputs.is_empty() {
            let (s, keep) =
                if self.unfed_inputs.len() == 1 { ("", "keeps its") } else { ("s", "keep their") };
            notes.push(format!(
                "no column feeds the input{s} {}, which {keep} start value{s}; assign a column with --map INPUT=COLUMN",
                list(&self.unfed_inputs)
            ));
        }
        if !self.unused_columns.is_empty() {
            let (s, feed) =
                if self.unused_columns.len() == 1 { ("", "feeds") } else { ("s", "feed") };
            notes.push(format!(
                "the column{s} {} {feed} no input and no output",
                list(&self.unused_columns)
            ));
        }
        notes
    }
}

/// Names, not more than one can read.
pub(crate) fn list(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().take(LISTED).map(|name| format!("`{name}`")).collect();
    match names.len().saturating_sub(LISTED) {
        0 => quoted.join(", "),
        more => format!("{} and {more} more", quoted.join(", ")),
    }
}

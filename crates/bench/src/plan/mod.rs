//! The bench plan: what is run, how fast, within which limits, and what is played.

mod prepare;
mod sequence;

use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use crate::gateway::ProcessData;

pub use prepare::Prepared;
pub use sequence::Step;

/// A bench plan, as its file says it:
///
/// ```toml
/// rate = 10000                        # Hz
/// gateway = "udp://127.0.0.1:9000"
/// controller = "controller.fmu"       # none: the sequence is the commands
/// record = "run.parquet"
///
/// [start]                             # start values of the controller
/// "pid[1].k" = 2.0
///
/// [[axis]]                            # one for each channel, in the units of the FMU
/// command_limits = [0, 120]
/// tracking_error = 2.0
///
/// [watch]                             # cycles
/// hold = 5
///
/// [[sequence]]
/// kind = "rest"
/// seconds = 0.5
///
/// [[sequence]]
/// kind = "signal"
/// name = "multisine-odd"
/// axis = 1
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Cycles per second.
    pub rate: Option<f64>,
    /// Address of the machine.
    pub gateway: Option<String>,
    /// Own address, for UDP beyond this computer.
    pub bind: Option<std::net::SocketAddr>,
    /// The controller FMU; none: the sequence is the commands.
    pub controller: Option<PathBuf>,
    /// Where the record goes.
    pub record: Option<PathBuf>,
    /// Seconds in the state ready before it starts; default 0.1.
    pub settle: Option<f64>,
    /// Seconds of the approach from where the machine is to the first row; default 0.2.
    pub approach: Option<f64>,
    /// Seconds over which the controller takes over; default 0.1.
    pub blend: Option<f64>,
    /// Seconds without a machine before it gives up; default 10.
    pub patience: Option<f64>,
    /// Start values of the controller.
    #[serde(default)]
    pub start: std::collections::BTreeMap<String, toml::Value>,
    /// The axes; none: as many as the controller has commands, without limits of their own.
    #[serde(default, rename = "axis")]
    pub axes: Vec<AxisPlan>,
    /// What holds for axes that are not in the plan.
    #[serde(skip)]
    pub other_axes: AxisPlan,
    /// What is watched.
    #[serde(default)]
    pub watch: WatchPlan,
    /// Where the channels stand, for a gateway ethercat://INTERFACE.
    pub ethercat: Option<ProcessData>,
    /// What is played.
    #[serde(default)]
    pub sequence: Vec<Step>,
    /// The file, for messages and for what it names.
    #[serde(skip)]
    pub origin: Option<PathBuf>,
}

/// One axis. Names default to those of the axis' number.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisPlan {
    /// Output of the controller; default `command[i]`.
    pub command: Option<String>,
    /// Input of the controller for the position; default `measured[i]`.
    pub measured: Option<String>,
    /// Input of the controller for the reference; default `reference[i]`.
    pub reference: Option<String>,
    /// Name of the position in the record; default `position[i]`.
    pub position: Option<String>,
    /// Unit of the command, where no FMU says it.
    pub command_unit: Option<String>,
    /// Unit of the position, where no FMU says it.
    pub position_unit: Option<String>,
    /// Least and greatest command; default: those of the FMU's variable.
    pub command_limits: Option<[f64; 2]>,
    /// Fastest change of the command, per second.
    pub command_rate: Option<f64>,
    /// Least and greatest position.
    pub position_limits: Option<[f64; 2]>,
    /// Fastest change of the position, per second.
    pub position_rate: Option<f64>,
    /// Greatest distance of position and reference.
    pub tracking_error: Option<f64>,
    /// Command of the safe state; default 0, or the limit next to it.
    pub safe: Option<f64>,
    /// How fast the command goes there, per second; default: over the whole range in 0.1 s.
    pub safe_rate: Option<f64>,
}

/// What is watched, in cycles; see `safety::Watch`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WatchPlan {
    /// Cycles without a good sample over which the controller drives on.
    pub hold: Option<u32>,
    /// Greatest age of a sample.
    pub max_age: Option<u32>,
    /// Cycles in a row with too great a tracking error.
    pub tracking: Option<u32>,
    /// Cycles in a row with a position of the same bits.
    pub stuck: Option<u32>,
    /// Cycles in a row with a command at its limit.
    pub saturated: Option<u32>,
    /// Cycles that may be missed in one go.
    pub overrun: Option<u32>,
}

/// Everything that is wrong with a plan.
#[derive(Debug, Error)]
#[error("{}", .0.join("\n"))]
pub struct PlanError(pub Vec<String>);

impl PlanError {
    fn one(problem: impl Into<String>) -> Self {
        PlanError(vec![problem.into()])
    }
}

impl Plan {
    /// Reads a plan.
    ///
    /// # Errors
    /// The file cannot be read, or is no plan; with its line.
    pub fn read(path: &Path) -> Result<Self, PlanError> {
        let text = files::read_text(path).map_err(|error| {
            PlanError::one(format!("{}: cannot be read: {error}", path.display()))
        })?;
        let mut plan = Plan::parse(&text, &path.display().to_string())?;
        plan.origin = Some(path.to_owned());
        Ok(plan)
    }

    /// Reads the text of a plan; `origin` is what messages call it.
    ///
    /// # Errors
    /// It is no plan; with the line.
    pub fn parse(text: &str, origin: &str) -> Result<Self, PlanError> {
        toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            let other = data::of_another_kind(text, "a plan of the bench");
            PlanError::one(format!("{origin}:{line}: {other}{}", error.message()))
        })
    }

    /// A file that the plan names: relative to the plan's own folder.
    #[must_use]
    pub fn beside(&self, file: &Path) -> PathBuf {
        let folder = self.origin.as_deref().and_then(Path::parent);
        folder.map_or_else(|| file.to_owned(), |folder| folder.join(file))
    }

    /// How messages call it.
    #[must_use]
    pub fn name(&self) -> String {
        self.origin.as_ref().map_or_else(|| "plan".to_owned(), |path| path.display().to_string())
    }
}

/// Reads a rate as a command line gives it: `10k`, `2.5kHz`, `500`.
///
/// # Errors
/// It is none.
pub fn parse_rate(text: &str) -> Result<f64, String> {
    let bare = text.trim().trim_end_matches("Hz").trim_end();
    let (number, factor) = match bare.strip_suffix('k') {
        Some(number) => (number, 1e3),
        None => (bare, 1.0),
    };
    let rate = number.trim().parse::<f64>().map(|number| number * factor);
    match rate {
        Ok(rate) if (0.1..=200e3).contains(&rate) => Ok(rate),
        Ok(rate) => Err(format!("a rate is 0.1 Hz to 200 kHz, not {rate} Hz")),
        Err(_) => Err("write a rate as 10k, 2.5kHz or 500".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_read() {
        for (text, rate) in [("10k", 1e4), ("2.5 kHz", 2500.0), ("500", 500.0), ("50Hz", 50.0)] {
            assert_eq!(parse_rate(text), Ok(rate));
        }
        assert!(parse_rate("0").is_err() && parse_rate("1M").is_err() && parse_rate("-1").is_err());
    }

    #[test]
    fn a_plan_is_read_and_its_problems_have_lines() {
        let text = "rate = 1000\n[[axis]]\ncommand_limits = [0, 120]\n[[sequence]]\n\
                    kind = \"rest\"\nseconds = 1\n";
        let plan = Plan::parse(text, "p.toml").unwrap();
        assert_eq!(plan.axes[0].command_limits, Some([0.0, 120.0]));
        for (text, line, word) in [
            ("rate = 1000\nrat = 3\n", "p.toml:2", "rat"),
            ("[[axis]]\ncommand_limits = [0]\n", "p.toml:2", "length"),
            ("rate = \n", "p.toml:1", ""),
        ] {
            let message = Plan::parse(text, "p.toml").unwrap_err().to_string();
            assert!(message.starts_with(line) && message.contains(word), "{message}");
        }
    }
}

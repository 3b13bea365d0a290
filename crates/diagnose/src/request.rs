//! What is asked: a model, logs, and what is known about both.

use std::path::PathBuf;

use data::{CheckedBlueprint, ComponentBlueprint, Log, NameMap};

use crate::between::{Between, Course, Reading};
use crate::error::Error;

/// The model that does not match.
#[derive(Clone, Debug)]
pub enum Model {
    /// A white box: effects go in at their physical place on the path.
    Blueprint(Box<CheckedBlueprint>),
    /// A black box, FMI co-simulation of any vendor: effects go in before and behind it, and before its
    /// mode where its answer to a step shows one.
    Fmu(PathBuf),
}

/// How far a parameter may be off before it counts as an effect of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Tolerance {
    /// Name of the parameter, with `*` for any text: `axis[1].mechanics.frequency`, `*.damping`.
    pub name: String,
    /// One standard deviation.
    pub deviation: Deviation,
}

/// A standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deviation {
    /// Of the parameter's value.
    Relative(f64),
    /// In the parameter's unit.
    Absolute(f64),
}

/// What is known about the noise of an output.
#[derive(Clone, Debug, Default)]
pub enum Noise {
    /// Nothing: estimated from the logs.
    #[default]
    Estimated,
    /// Standard deviations in the log's unit: of one output by name, or of all (`None`).
    Given(Vec<(Option<String>, f64)>),
    /// A record of the machine at rest.
    Rest(Box<Log>),
}

/// A question to [`diagnose`](crate::diagnose).
#[derive(Clone, Debug)]
pub struct Request {
    /// The model.
    pub model: Model,
    /// Measured logs.
    pub logs: Vec<Log>,
    /// Logs that are only used to judge; none: the last 30 % of each record of `logs`.
    pub holdout: Vec<Log>,
    /// Run-in in s from the start of each record: simulated, neither fitted nor judged; none: as long as the
    /// residual shows that a record begins during a motion.
    pub drop: Option<f64>,
    /// What the commands do between the rows; none: held, unless the logs of a white box say otherwise.
    pub between: Option<Between>,
    /// When the readings of rows are taken; none: before a held command acts, at the instant of one that moves,
    /// unless the logs of a white box say otherwise.
    pub reading: Option<Reading>,
    /// How the logs are read first where both are none: as the model was identified from them.
    pub first: (Between, Reading),
    /// What is good enough, as a root mean square over the range of the output; 0: the noise.
    pub accuracy: f64,
    /// Which variable of the model reads which column.
    pub names: NameMap,
    /// Outputs that are looked at; empty: all that the logs have a column for.
    pub outputs: Vec<String>,
    /// Parameters that may be off, before what a blueprint says.
    pub tolerances: Vec<Tolerance>,
    /// Relative standard deviation of each output's gain.
    pub gain_tolerance: f64,
    /// The noise.
    pub noise: Noise,
    /// Most effects that are named per output.
    pub max_effects: usize,
    /// Effects that are taken out of the library.
    pub without: Vec<String>,
    /// Number of threads; 0: one per processor. Results do not depend on it.
    pub threads: usize,
    /// Seed of the resampling of blocks.
    pub seed: u64,
    /// Runs an FMU in processes of its own, so that one that crashes or hangs is an error; none: it
    /// runs in this process.
    pub worker: Option<cosim::Worker>,
}

impl Request {
    /// A question about this model and these logs, with the defaults of the command line.
    #[must_use]
    pub fn new(model: Model, logs: Vec<Log>) -> Self {
        Self {
            model,
            logs,
            holdout: Vec::new(),
            drop: None,
            between: None,
            reading: None,
            first: (Between::Zoh, Reading::Before),
            accuracy: 0.0,
            names: NameMap::default(),
            outputs: Vec::new(),
            tolerances: Vec::new(),
            gain_tolerance: 0.01,
            noise: Noise::Estimated,
            max_effects: 3,
            without: Vec::new(),
            threads: 0,
            seed: 1,
            worker: None,
        }
    }

    /// How the logs are read first.
    pub(crate) fn first_course(&self) -> Course {
        match (self.between, self.reading) {
            (None, None) => {
                let (between, reading) = self.first;
                Course { between, reading, is_stepped: false }
            }
            (between, reading) => Course::given(between, reading),
        }
    }
}

impl Tolerance {
    /// The tolerances that a blueprint states, under the names that its variables have.
    #[must_use]
    pub fn of_blueprint(blueprint: &CheckedBlueprint) -> Vec<Self> {
        let (spec, given) = (blueprint.spec(), blueprint.blueprint());
        let mut all = Vec::new();
        let mut add = |path: String, component: &ComponentBlueprint| {
            for (parameter, relative) in &component.tolerance {
                // A number, or each of a list.
                for end in ["", "[*"] {
                    let name = format!("{path}.{parameter}{end}");
                    all.push(Self { name, deviation: Deviation::Relative(*relative) });
                }
            }
        };
        for (number, (axis, given)) in (1..).zip(spec.axes.iter().zip(&given.axes)) {
            for (node, component) in axis.components.iter().zip(&given.components) {
                add(format!("axis[{number}].{}", node.name), component);
            }
        }
        for (coupling, given) in spec.connections.couplings.iter().zip(&given.couplings) {
            add(format!("coupling.{}", coupling.node.name), &given.component);
        }
        all
    }

    /// Reads `GLOB=REL` or `NAME=+-ABS`.
    ///
    /// # Errors
    /// [`Error::Option`] where the text is neither.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let bad = |rule: &str| Error::Option {
            option: "--tune",
            value: text.to_owned(),
            message: format!(
                "{rule}; write GLOB=REL, as in *.frequency=0.02, or NAME=+-ABS, as in gain=+-0.1"
            ),
        };
        let (name, value) = text.rsplit_once('=').ok_or_else(|| bad("has no ="))?;
        let (name, value) = (name.trim(), value.trim());
        if name.is_empty() {
            return Err(bad("names no parameter"));
        }
        let absolute = value.strip_prefix("+-").or_else(|| value.strip_prefix('±'));
        let number = absolute.unwrap_or(value);
        let number: f64 = number.trim().parse().map_err(|_| bad("the tolerance is no number"))?;
        if !(number.is_finite() && number > 0.0) {
            return Err(bad("the tolerance must be finite and above zero"));
        }
        let deviation = match absolute {
            Some(_) => Deviation::Absolute(number),
            None => Deviation::Relative(number),
        };
        Ok(Self { name: name.to_owned(), deviation })
    }

    /// Whether this is about the parameter of this name.
    #[must_use]
    pub fn is_for(&self, name: &str) -> bool {
        data::fits_pattern(&self.name, name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_are_read_and_match_by_glob() {
        let t = Tolerance::parse("*.frequency=0.02").unwrap();
        assert_eq!(t.deviation, Deviation::Relative(0.02));
        assert!(t.is_for("axis[1].mode.frequency") && !t.is_for("axis[1].mode.damping"));
        let t = Tolerance::parse("axis[1].lag.bandwidth=+-50").unwrap();
        assert_eq!(t.deviation, Deviation::Absolute(50.0));
        for bad in ["x", "=0.1", "x=", "x=-0.1", "x=+-0", "x=nan"] {
            let message = Tolerance::parse(bad).unwrap_err().to_string();
            assert!(message.contains("--tune") && message.contains(bad), "{message}");
        }
    }
}

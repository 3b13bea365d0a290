//! What may be chosen about an identification.

use data::AxisBlueprint;

use crate::error::{Error, Problem, SettingsProblem};
use crate::fit::operator::Search;
use crate::learned::{Seek, Selection};
use crate::methods::{self, FitContext, LINEAR, METHODS, STATIC, Strategy};
use crate::record::{Record, Rows, common_period};

/// Choices of an identification; [`Settings::default`] suits a log of some periods of a large slow
/// motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Number of plays, with thresholds spread evenly from 0 to the command's half range.
    pub plays: usize,
    /// Thresholds in the command's unit in the place of the even grid; the first is 0.
    pub thresholds: Option<Vec<f64>>,
    /// Run-in from the start of each record in s, which is simulated but neither fitted nor judged.
    pub drop: f64,
    /// Part of each record's time, at its end, that is held out of the fit to judge it.
    pub hold_out: f64,
    /// Longest delay that is searched, in s; `None`: 8 samples, at most 10 s.
    pub longest_delay: Option<f64>,
    /// Least weight of the play of threshold 0, relative to the range of the output over that of
    /// the input. It keeps the inverse of the model from being arbitrarily steep.
    pub least_slope: f64,
    /// Which linear parts are looked for.
    pub dynamics: Dynamics,
    /// Which hysteresis models are tried.
    pub methods: Methods,
    /// Levels of a Preisach model.
    pub levels: usize,
    /// How the shape of a hysteresis is searched.
    pub search: Search,
    /// What is chosen about learned machines.
    pub learning: Learning,
}

/// Choices about learned machines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Learning {
    /// What their settings are judged by, and how these are sought; none: by the evidence (stop operators), in
    /// simulation of the last third (past outputs), by the likelihood (processes).
    pub selection: Option<(Selection, Seek)>,
    /// Support vectors that pruning leaves; none: the fewest centres on which a projection errs hardly more.
    pub prune: Option<usize>,
    /// The inputs of a machine.
    pub features: FeatureChoice,
    /// Whether the plant of a process has the standard deviation that it predicts as an output.
    pub deviation: bool,
}

/// The inputs of a learned machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeatureChoice {
    /// What its family takes by itself.
    #[default]
    Usual,
    /// The command's rate too, beside stop operators and the command.
    Rate,
    /// So many inputs of a process: 2, 6, 9 or 12.
    Inputs(usize),
    /// The command, and past values of a hysteresis term.
    Command,
    /// The position, and past values of a hysteresis term.
    Position,
    /// Command and position, and past values of a hysteresis term.
    Both,
}

/// Which hysteresis models are tried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Methods {
    /// A model without hysteresis and all operators of [`methods`](crate::methods), none that is learned.
    Sensible,
    /// These, by name; the best of them is returned.
    Named(Vec<String>),
}

impl Default for Methods {
    /// The static Prandtl–Ishlinskii model.
    fn default() -> Self {
        Self::Named(vec![STATIC.name().to_owned()])
    }
}

/// Which linear parts are looked for beside the delay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dynamics {
    /// An amplifier lag and a mode, each kept where the held-out error falls by at least 10 %.
    #[default]
    Automatic,
    /// None.
    Static,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            plays: 30,
            thresholds: None,
            drop: 0.0,
            hold_out: 0.5,
            longest_delay: None,
            least_slope: 0.01,
            dynamics: Dynamics::Automatic,
            methods: Methods::default(),
            levels: 20,
            search: Search::LevenbergMarquardt,
            learning: Learning::default(),
        }
    }
}

/// What the blueprint says beside the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Name of the model.
    pub model: String,
    /// Provenance, free text.
    pub source: String,
    /// The axis with its name, units, short names and bounds, and no components. Bounds that are
    /// not given become the range of the log's command.
    pub axis: AxisBlueprint,
}

/// Samples of the longest delay that is searched where none is given.
const LONGEST_DELAY: f64 = 8.0;
/// Longest delay in s that a component has room for.
pub(crate) const MOST_DELAY: f64 = 10.0;
/// Fewest rows fitted on, per play.
const ROWS_PER_PLAY: usize = 5;
/// Fewest rows to judge on.
const FEWEST_JUDGED: usize = 20;
/// Most plays that a blueprint can hold.
const MOST_PLAYS: usize = 4096;

/// Settings that fit the records, with every choice made.
#[derive(Clone)]
pub(crate) struct Plan {
    pub(crate) period: f64,
    pub(crate) thresholds: Vec<f64>,
    pub(crate) fitted: Vec<Rows>,
    pub(crate) judged: Vec<Rows>,
    pub(crate) longest_delay: f64,
    /// In position per command.
    pub(crate) least_slope: f64,
    pub(crate) dynamics: Dynamics,
    /// Half the range of the command in the rows fitted on.
    pub(crate) half_range: f64,
    pub(crate) methods: Vec<Strategy>,
    /// Whether the best of the methods is returned and not the static model.
    pub(crate) named: bool,
    /// Whether a model without hysteresis may be returned.
    pub(crate) linear: bool,
    pub(crate) levels: usize,
    pub(crate) search: Search,
    pub(crate) learning: Learning,
}

impl Plan {
    /// What methods know of the rows fitted on.
    pub(crate) fn scene(&self, records: &[Record]) -> FitContext {
        let rows = || records.iter().zip(&self.fitted);
        let duration = rows().map(|(record, rows)| rows.len() as f64 * record.period());
        let span = |column: fn(&Record) -> &[f64]| {
            let values = || rows().flat_map(|(record, rows)| rows.of(column(record))).copied();
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        };
        let (command, position) = (span(Record::input), span(Record::output));
        FitContext {
            command,
            position,
            zero: FitContext::zero_of(command, position),
            duration: duration.fold(0.0, f64::max),
            thresholds: self.thresholds.clone(),
            levels: self.levels,
            least_slope: self.least_slope,
        }
    }
}

impl Settings {
    /// Checks the settings, by themselves and against the records.
    ///
    /// # Errors
    /// [`Error::Settings`] or [`Error::Unsuitable`] with every problem.
    pub(crate) fn plan(&self, records: &[Record]) -> Result<Plan, Error> {
        let period = common_period(records)?;
        let wrong = self.problems();
        if !wrong.is_empty() {
            return Err(Error::Settings(wrong));
        }
        let fitted: Vec<Rows> = records.iter().map(|r| self.rows(r).0).collect();
        let judged: Vec<Rows> = records.iter().map(|r| self.rows(r).1).collect();
        let unsuitable = self.unsuitable(records, &fitted, &judged);
        if !unsuitable.is_empty() {
            return Err(Error::Unsuitable(unsuitable));
        }
        let half_range = 0.5
            * records.iter().zip(&fitted).map(|(r, w)| range(w.of(r.input()))).fold(0.0, f64::max);
        let thresholds = self.thresholds.clone().unwrap_or_else(|| {
            (0..self.plays).map(|i| half_range * i as f64 / self.plays as f64).collect()
        });
        let slope = records
            .iter()
            .zip(&fitted)
            .map(|(r, w)| range(w.of(r.output())) / range(w.of(r.input())))
            .fold(0.0, f64::max);
        let methods = self.chosen()?;
        Ok(Plan {
            period,
            thresholds,
            fitted,
            judged,
            longest_delay: self.longest_delay.unwrap_or((LONGEST_DELAY * period).min(MOST_DELAY)),
            least_slope: self.least_slope * slope,
            dynamics: self.dynamics,
            half_range,
            linear: methods.iter().any(|method| method.name() == LINEAR),
            methods,
            named: matches!(self.methods, Methods::Named(_)),
            levels: self.levels,
            search: self.search,
            learning: self.learning,
        })
    }

    /// The methods that are tried.
    fn chosen(&self) -> Result<Vec<Strategy>, Error> {
        match &self.methods {
            Methods::Sensible => Ok(METHODS.iter().copied().map(Strategy::Operator).collect()),
            Methods::Named(names) => {
                let unknown = |name: &String| {
                    let names = methods::methods().map(|(name, _)| name).collect::<Vec<_>>();
                    Error::NoMethod { name: name.clone(), names: names.join(", ") }
                };
                let find = |name: &String| methods::find(name).ok_or_else(|| unknown(name));
                names.iter().map(find).collect()
            }
        }
    }

    /// Rows fitted on and rows held out.
    fn rows(&self, record: &Record) -> (Rows, Rows) {
        let first = record.row_at(self.drop);
        let middle = record.row_at((1.0 - self.hold_out) * record.duration()).max(first);
        (Rows { first, end: middle }, Rows { first: middle, end: record.len() })
    }

    fn play_count(&self) -> usize {
        self.thresholds.as_ref().map_or(self.plays, Vec::len)
    }

    fn problems(&self) -> Vec<SettingsProblem> {
        let mut problems = Vec::new();
        let mut require = |holds: bool, setting: &'static str, value: f64, rule: &'static str| {
            if !holds {
                problems.push(SettingsProblem { setting, value, rule });
            }
        };
        let plays = self.play_count();
        require(
            (1..=MOST_PLAYS).contains(&plays),
            "plays",
            plays as f64,
            "a model has 1 to 4096 plays; 20 to 40 suit most actuators",
        );
        require(
            self.drop.is_finite() && self.drop >= 0.0,
            "drop",
            self.drop,
            "the run-in is a time of 0 s or more from the start of the record",
        );
        require(
            self.hold_out > 0.0 && self.hold_out < 1.0,
            "hold_out",
            self.hold_out,
            "the part held out lies between 0 and 1, both excluded; 0.5 judges on the second half",
        );
        require(
            self.least_slope > 0.0 && self.least_slope < 1.0,
            "least_slope",
            self.least_slope,
            "lies between 0 and 1, both excluded; 0.01 lets the inverse be 100 times as steep as \
             the mean",
        );
        require(
            (2..=60).contains(&self.levels),
            "levels",
            self.levels as f64,
            "a Preisach model of 2 to 60 levels (3 to 1830 relays) is fitted; 20 suit most logs",
        );
        if let Some(longest) = self.longest_delay {
            require(
                (0.0..=MOST_DELAY).contains(&longest),
                "longest_delay",
                longest,
                "is a time from 0 s to 10 s",
            );
        }
        for (index, r) in self.thresholds.iter().flatten().enumerate() {
            let before = self.thresholds.as_ref().and_then(|all| all.get(index.wrapping_sub(1)));
            let increasing = before.map_or(*r == 0.0, |before| r > before);
            require(
                increasing && r.is_finite(),
                "thresholds",
                *r,
                "thresholds start with 0 and are strictly increasing; sort them and remove equal ones",
            );
        }
        problems
    }

    fn unsuitable(&self, records: &[Record], fitted: &[Rows], judged: &[Rows]) -> Vec<Problem> {
        let needed = ROWS_PER_PLAY * self.play_count();
        let mut problems = Vec::new();
        for ((record, fitted), judged) in records.iter().zip(fitted).zip(judged) {
            let parts = [("to fit on", fitted, needed), ("to judge on", judged, FEWEST_JUDGED)];
            for (part, rows, needed) in parts {
                let (name, found) = (record.name().to_owned(), rows.len());
                if found < needed {
                    problems.push(Problem::TooShort { record: name, part, found, needed });
                    continue;
                }
                let columns = [
                    (record.input_name(), record.input()),
                    (record.output_name(), record.output()),
                ];
                for (column, values) in columns {
                    let values = rows.of(values);
                    if range(values) <= 1e-12 * values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
                    {
                        problems.push(Problem::Constant {
                            record: record.name().to_owned(),
                            column: column.to_owned(),
                            value: values[0],
                            part,
                        });
                    }
                }
            }
        }
        problems
    }
}

/// Greatest less least value.
pub(crate) fn range(values: &[f64]) -> f64 {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    (high - low).max(0.0)
}

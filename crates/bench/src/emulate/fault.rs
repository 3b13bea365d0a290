//! Faults by script.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A script of faults, in TOML:
///
/// ```toml
/// seed = 7
///
/// [[fault]]
/// kind = "loss"            # see FaultKind
/// probability = 0.01
/// direction = "both"       # "measurement" (default), "command", "both"
/// from = 1.0               # s of the machine's time; default: from the begin
/// to = 2.0                 # default: to the end
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Script {
    /// Seed of all that is random.
    #[serde(default)]
    pub seed: u64,
    /// The faults; several may act at once.
    #[serde(default, rename = "fault")]
    pub faults: Vec<Fault>,
}

/// One fault and when it acts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    /// What the fault is.
    #[serde(flatten)]
    pub kind: FaultKind,
    /// Which packets it acts on, for faults of packets.
    #[serde(default)]
    pub direction: Direction,
    /// Begin in s of the machine's time.
    #[serde(default)]
    pub from: f64,
    /// End in s; none: it stays.
    pub to: Option<f64>,
}

/// Which packets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// From the machine to the runner.
    #[default]
    Measurement,
    /// From the runner to the machine.
    Command,
    /// Both.
    Both,
}

/// What goes wrong. Axes are counted from 1; without an axis all are meant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum FaultKind {
    /// Packets take so many seconds longer.
    Delay {
        /// s
        seconds: f64,
    },
    /// Packets take up to so many seconds longer, evenly distributed; their order stays.
    Jitter {
        /// s
        seconds: f64,
    },
    /// Packets vanish.
    Loss {
        /// 0 to 1
        probability: f64,
    },
    /// Packets are held back, so that later ones overtake them.
    Reorder {
        /// 0 to 1
        probability: f64,
        /// How long, in s.
        seconds: f64,
    },
    /// Packets come twice.
    Duplicate {
        /// 0 to 1
        probability: f64,
    },
    /// One to four bytes of a packet are changed.
    Corrupt {
        /// 0 to 1
        probability: f64,
    },
    /// The sensor repeats its last value.
    Stuck {
        /// Axis.
        axis: Option<usize>,
    },
    /// The sensor sends NaN.
    Nan {
        /// Axis.
        axis: Option<usize>,
    },
    /// The sensor ends at these values.
    Saturation {
        /// Axis.
        axis: Option<usize>,
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// The sensor rounds.
    Quantisation {
        /// Axis.
        axis: Option<usize>,
        /// Distance of its values.
        step: f64,
    },
    /// The sensor is off by so much.
    Offset {
        /// Axis.
        axis: Option<usize>,
        /// How much.
        value: f64,
    },
    /// The machine says that its samples are not valid.
    Invalid,
    /// The machine's power is off.
    PowerLoss,
    /// The machine counts its packets anew, once.
    Restart,
}

/// Everything that is wrong with a script.
#[derive(Debug, Error)]
#[error("{}", .0.join("\n"))]
pub struct ScriptError(pub Vec<String>);

impl Script {
    /// Reads a script; `origin` is what messages call it.
    ///
    /// # Errors
    /// Every problem of the text.
    pub fn parse(text: &str, origin: &str) -> Result<Self, ScriptError> {
        let script: Script = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            let other = data::of_another_kind(text, "a script of faults");
            ScriptError(vec![format!("{origin}:{line}: {other}{}", error.message())])
        })?;
        let mut problems = unknown_keys(text, origin, &script);
        problems.extend(script.problems(origin));
        if problems.is_empty() { Ok(script) } else { Err(ScriptError(problems)) }
    }

    /// Reads one fault as a command line gives it: `loss,probability=0.01,from=1,to=2`.
    ///
    /// # Errors
    /// The text is none.
    pub fn parse_fault(text: &str) -> Result<Fault, ScriptError> {
        let mut words = text.split(',');
        let kind = words.next().unwrap_or_default().trim();
        let mut lines = format!("[[fault]]\nkind = {kind:?}\n");
        for word in words {
            let Some((key, value)) = word.split_once('=') else {
                return Err(ScriptError(vec![format!(
                    "--inject {text}: `{word}` is no KEY=VALUE; write it as in loss,probability=0.01,from=1"
                )]));
            };
            let (key, value) = (key.trim(), value.trim());
            let number = value.parse::<f64>().is_ok();
            let value = if number { value.to_owned() } else { format!("{value:?}") };
            lines += &format!("{key} = {value}\n");
        }
        let origin = format!("--inject {text}");
        let mut script = Script::parse(&lines, &origin)?;
        script.faults.pop().ok_or_else(|| ScriptError(vec![format!("{origin}: no fault")]))
    }

    /// Reads faults from tables, as a campaign has them.
    pub(crate) fn of_tables(
        tables: &[toml::Table],
        origin: &str,
    ) -> Result<Vec<Fault>, ScriptError> {
        let mut problems = Vec::new();
        let mut script = Script::default();
        for (index, table) in tables.iter().enumerate() {
            match Fault::deserialize(toml::Value::Table(table.clone())) {
                Ok(fault) => {
                    let unknown = unknown_keys_of(table, &place(origin, index, &fault), &fault);
                    problems.extend(unknown);
                    script.faults.push(fault);
                }
                Err(error) => {
                    problems.push(format!("{origin}: fault {}: {}", index + 1, error.message()));
                }
            }
        }
        problems.extend(script.problems(origin));
        if problems.is_empty() { Ok(script.faults) } else { Err(ScriptError(problems)) }
    }

    fn problems(&self, origin: &str) -> Vec<String> {
        let faults = self.faults.iter().enumerate();
        faults
            .flat_map(|(index, fault)| {
                let place = place(origin, index, fault);
                fault.problems().into_iter().map(move |problem| format!("{place}: {problem}"))
            })
            .collect()
    }

    /// What acts at this time in s.
    pub(crate) fn activate(&self, time: f64, active: &mut Active) {
        let was = std::mem::take(&mut active.sensors);
        *active = Active { sensors: was, ..Active::default() };
        active.sensors.clear();
        let acts = |fault: &&Fault| time >= fault.from && fault.to.is_none_or(|to| time < to);
        for fault in self.faults.iter().filter(acts) {
            active.add(fault);
        }
    }
}

fn place(origin: &str, index: usize, fault: &Fault) -> String {
    format!("{origin}: fault {} ({})", index + 1, fault.kind.name())
}

/// Keys that no fault of its kind has; the reader of flattened tables lets them pass.
fn unknown_keys(text: &str, origin: &str, script: &Script) -> Vec<String> {
    let table: toml::Table = toml::from_str(text).unwrap_or_default();
    let tables = table.get("fault").and_then(toml::Value::as_array).into_iter().flatten();
    let faults = script.faults.iter().enumerate().zip(tables);
    let of = |((index, fault), table): ((usize, &Fault), &toml::Value)| {
        let table = table.as_table().cloned().unwrap_or_default();
        unknown_keys_of(&table, &place(origin, index, fault), fault)
    };
    faults.flat_map(of).collect()
}

fn unknown_keys_of(table: &toml::Table, place: &str, fault: &Fault) -> Vec<String> {
    let known: Vec<&str> =
        ["kind", "direction", "from", "to"].iter().chain(fault.kind.keys()).copied().collect();
    let unknown = table.keys().filter(|key| !known.contains(&key.as_str()));
    let text = |key| format!("{place}: there is no `{key}`; it takes {}", known.join(", "));
    unknown.map(text).collect()
}

impl FaultKind {
    fn keys(self) -> &'static [&'static str] {
        match self {
            FaultKind::Delay { .. } | FaultKind::Jitter { .. } => &["seconds"],
            FaultKind::Loss { .. } | FaultKind::Duplicate { .. } | FaultKind::Corrupt { .. } => {
                &["probability"]
            }
            FaultKind::Reorder { .. } => &["probability", "seconds"],
            FaultKind::Stuck { .. } | FaultKind::Nan { .. } => &["axis"],
            FaultKind::Saturation { .. } => &["axis", "min", "max"],
            FaultKind::Quantisation { .. } => &["axis", "step"],
            FaultKind::Offset { .. } => &["axis", "value"],
            FaultKind::Invalid | FaultKind::PowerLoss | FaultKind::Restart => &[],
        }
    }

    fn name(self) -> &'static str {
        match self {
            FaultKind::Delay { .. } => "delay",
            FaultKind::Jitter { .. } => "jitter",
            FaultKind::Loss { .. } => "loss",
            FaultKind::Reorder { .. } => "reorder",
            FaultKind::Duplicate { .. } => "duplicate",
            FaultKind::Corrupt { .. } => "corrupt",
            FaultKind::Stuck { .. } => "stuck",
            FaultKind::Nan { .. } => "nan",
            FaultKind::Saturation { .. } => "saturation",
            FaultKind::Quantisation { .. } => "quantisation",
            FaultKind::Offset { .. } => "offset",
            FaultKind::Invalid => "invalid",
            FaultKind::PowerLoss => "power-loss",
            FaultKind::Restart => "restart",
        }
    }

    fn axis(self) -> Option<usize> {
        match self {
            FaultKind::Stuck { axis }
            | FaultKind::Nan { axis }
            | FaultKind::Saturation { axis, .. }
            | FaultKind::Quantisation { axis, .. }
            | FaultKind::Offset { axis, .. } => axis,
            _ => None,
        }
    }
}

impl Fault {
    fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        let mut must = |holds: bool, text: String| {
            if !holds {
                problems.push(text);
            }
        };
        if let FaultKind::Loss { probability }
        | FaultKind::Reorder { probability, .. }
        | FaultKind::Duplicate { probability }
        | FaultKind::Corrupt { probability } = self.kind
        {
            let rule = format!("probability = {probability} must be 0 to 1");
            must((0.0..=1.0).contains(&probability), rule);
        }
        if let FaultKind::Delay { seconds }
        | FaultKind::Jitter { seconds }
        | FaultKind::Reorder { seconds, .. } = self.kind
        {
            must((0.0..=60.0).contains(&seconds), format!("seconds = {seconds} must be 0 to 60"));
        }
        if let FaultKind::Saturation { min, max, .. } = self.kind {
            must(min < max, format!("min = {min} must be less than max = {max}"));
        }
        if let FaultKind::Quantisation { step, .. } = self.kind {
            let rule = format!("step = {step} must be finite and greater than 0");
            must(step.is_finite() && step > 0.0, rule);
        }
        must(self.kind.axis() != Some(0), "axis = 0: axes are counted from 1".to_owned());
        let to = self.to.unwrap_or(f64::INFINITY);
        let span = format!("from = {}, to = {to}: it must end after it begins", self.from);
        must(self.from >= 0.0 && to > self.from, span);
        problems
    }
}

/// What acts on the packets of one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct OnPackets {
    pub(crate) delay: f64,
    pub(crate) jitter: f64,
    pub(crate) loss: f64,
    pub(crate) reorder: (f64, f64),
    pub(crate) duplicate: f64,
    pub(crate) corrupt: f64,
}

/// Everything that acts at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Active {
    pub(crate) commands: OnPackets,
    pub(crate) measurements: OnPackets,
    pub(crate) sensors: Vec<FaultKind>,
    pub(crate) invalid: bool,
    pub(crate) power_loss: bool,
    pub(crate) restart: bool,
}

impl Active {
    fn add(&mut self, fault: &Fault) {
        match fault.kind {
            FaultKind::Invalid => self.invalid = true,
            FaultKind::PowerLoss => self.power_loss = true,
            FaultKind::Restart => self.restart = true,
            kind @ (FaultKind::Stuck { .. }
            | FaultKind::Nan { .. }
            | FaultKind::Saturation { .. }
            | FaultKind::Quantisation { .. }
            | FaultKind::Offset { .. }) => self.sensors.push(kind),
            kind => {
                if fault.direction != Direction::Command {
                    self.measurements.add(kind);
                }
                if fault.direction != Direction::Measurement {
                    self.commands.add(kind);
                }
            }
        }
    }

    /// What the sensor of an axis (from 0) says; `held` is what it said last.
    pub(crate) fn sense(&self, axis: usize, value: f64, held: &mut f64) -> f64 {
        let mut messages = value;
        let here = |kind: &&FaultKind| kind.axis().is_none_or(|one| one == axis + 1);
        for kind in self.sensors.iter().filter(here) {
            messages = match *kind {
                FaultKind::Stuck { .. } => *held,
                FaultKind::Nan { .. } => f64::NAN,
                FaultKind::Saturation { min, max, .. } => messages.clamp(min, max),
                FaultKind::Quantisation { step, .. } => (messages / step).round() * step,
                FaultKind::Offset { value, .. } => messages + value,
                _ => messages,
            };
        }
        *held = messages;
        messages
    }
}

impl OnPackets {
    fn add(&mut self, kind: FaultKind) {
        // Two independent losses of p and q lose 1 - (1 - p)(1 - q).
        let both = |p: f64, q: f64| p + q - p * q;
        match kind {
            FaultKind::Delay { seconds } => self.delay += seconds,
            FaultKind::Jitter { seconds } => self.jitter += seconds,
            FaultKind::Loss { probability } => self.loss = both(self.loss, probability),
            FaultKind::Reorder { probability, seconds } => {
                self.reorder = (both(self.reorder.0, probability), self.reorder.1.max(seconds));
            }
            FaultKind::Duplicate { probability } => {
                self.duplicate = both(self.duplicate, probability);
            }
            FaultKind::Corrupt { probability } => self.corrupt = both(self.corrupt, probability),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_script_is_read() {
        let text = "seed = 3\n[[fault]]\nkind = \"reorder\"\nprobability = 0.1\nseconds = 1e-3\n\
                    direction = \"both\"\nfrom = 1\nto = 2\n[[fault]]\nkind = \"power-loss\"\n";
        let script = Script::parse(text, "faults.toml").unwrap();
        assert_eq!(script.seed, 3);
        let mut active = Active::default();
        script.activate(1.5, &mut active);
        assert_eq!(active.commands.reorder, (0.1, 1e-3));
        assert!(active.power_loss);
        script.activate(2.0, &mut active);
        assert_eq!(active.commands, OnPackets::default());
    }

    #[test]
    fn a_fault_of_the_command_line() {
        let fault = Script::parse_fault("loss, probability=0.01, direction=command, to=3").unwrap();
        assert_eq!(fault.kind, FaultKind::Loss { probability: 0.01 });
        assert_eq!((fault.direction, fault.from, fault.to), (Direction::Command, 0.0, Some(3.0)));
        let message = Script::parse_fault("loss,0.1").unwrap_err().to_string();
        assert!(message.contains("KEY=VALUE"), "{message}");
    }

    #[test]
    fn every_problem_is_reported() {
        let text = "[[fault]]\nkind = \"loss\"\nprobability = 2\nfrom = 3\nto = 2\n\
                    [[fault]]\nkind = \"quantisation\"\nstep = 0\naxis = 0\n";
        let problems = Script::parse(text, "f.toml").unwrap_err().0;
        assert_eq!(problems.len(), 4, "{problems:?}");
        assert!(problems[0].starts_with("f.toml: fault 1 (loss): probability = 2"));
        let unknown = Script::parse("[[fault]]\nkind = \"lost\"\n", "f.toml").unwrap_err();
        assert!(unknown.to_string().starts_with("f.toml:"), "{unknown}");
        assert!(unknown.to_string().contains("lost"), "{unknown}");
        let text = "[[fault]]\nkind = \"nan\"\naxis = 1\nform = 2\n";
        let message = Script::parse(text, "f.toml").unwrap_err().to_string();
        assert!(
            message.contains("no `form`; it takes kind, direction, from, to, axis"),
            "{message}"
        );
        // A sensor that ends nowhere would be no fault.
        let same = "[[fault]]\nkind = \"saturation\"\nmin = 1\nmax = 1\n";
        assert!(Script::parse(same, "f.toml").is_err());
    }

    #[test]
    fn sensors_lie_as_scripted() {
        let mut active = Active::default();
        let mut held = 0.25;
        assert_eq!(active.sense(0, 1.26, &mut held), 1.26);
        active.sensors = vec![
            FaultKind::Quantisation { axis: Some(1), step: 0.5 },
            FaultKind::Saturation { axis: None, min: 0.0, max: 1.0 },
        ];
        assert_eq!(active.sense(0, 0.8, &mut held), 1.0);
        assert_eq!(active.sense(1, 0.8, &mut held), 0.8);
        active.sensors = vec![FaultKind::Stuck { axis: None }];
        assert_eq!(active.sense(0, 7.0, &mut held), 0.8);
    }
}

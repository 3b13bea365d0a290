//! `piezoloop signal`: a test signal as a log.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;
use cli::{Answer, Screen, rounded};
use data::{Log, UnitPlace};
use serde::Serialize;
use signals::SignalType;

use crate::inputs;

/// Writes a test signal as a log: signals of the papers, and general ones
///
/// Without a name it lists the signals. --about shows the parameters of one.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop signal\n  piezoloop signal p0-train-h -o train.csv\n  piezoloop signal ellipse --about\n  piezoloop signal multisine-odd --set lowest_frequency=1 --set highest_frequency=200 -o excitation.csv"
)]
pub(crate) struct Signal {
    /// Name of the signal; none: list all
    name: Option<String>,
    /// A parameter of the signal, in its unit (may be given several times)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
    /// Rename a channel, so that the log fits a plant (may be given several times)
    #[arg(long = "rename", value_name = "CHANNEL=NAME")]
    renames: Vec<String>,
    /// Print equation, source and parameters of the signal, and write nothing
    #[arg(long)]
    about: bool,
    /// The log to write [default: the signal's name with .csv]
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
}

/// What was written, or what is known.
#[derive(Serialize)]
#[serde(untagged)]
enum Generated {
    List(Vec<Row>),
    About(About),
    Written {
        signal: &'static str,
        file: PathBuf,
        samples: usize,
        sample_time_s: f64,
        channels: Vec<ChannelRow>,
    },
}

/// A line of the list of signals.
#[derive(Serialize)]
pub(crate) struct Row {
    family: &'static str,
    name: &'static str,
    summary: &'static str,
}

#[derive(Serialize)]
struct About {
    name: &'static str,
    summary: &'static str,
    source: &'static str,
    equation: &'static str,
    parameters: Vec<ParameterRow>,
    rules: Vec<String>,
}

#[derive(Serialize)]
struct ParameterRow {
    name: &'static str,
    unit: &'static str,
    start: f64,
    min: f64,
    max: f64,
    description: &'static str,
}

#[derive(Serialize)]
struct ChannelRow {
    name: String,
    unit: String,
    min: f64,
    max: f64,
}

impl Signal {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let Some(name) = &self.name else {
            if self.about || self.out.is_some() || !self.settings.is_empty() {
                bail!("name a signal; `piezoloop signal` alone lists them");
            }
            return screen.show(&Generated::List(list()));
        };
        let kind = signals::lookup(name).map_err(|unknown| {
            let near = inputs::meant(name, signals::all().map(|signal| signal.name));
            anyhow::anyhow!("no signal is named `{name}`; {near}known are {}", unknown.known)
        })?;
        if self.about {
            return screen.show(&Generated::About(about(kind)));
        }
        screen.show(&self.write(kind)?)
    }

    fn write(&self, kind: &'static SignalType) -> anyhow::Result<Generated> {
        let settings =
            self.settings.iter().map(|text| setting(text)).collect::<Result<Vec<_>, _>>()?;
        let given: Vec<(&str, f64)> = settings.iter().map(|(key, value)| (*key, *value)).collect();
        let mut signal = kind.generate(&given)?;
        for text in &self.renames {
            let Some((channel, name)) = text.split_once('=') else {
                bail!("--rename {text}: write CHANNEL=NAME, as in u=command[1]");
            };
            let known: Vec<_> = signal.channels.iter().map(|c| c.name.clone()).collect();
            let channel =
                signal.channels.iter_mut().find(|c| c.name == channel).with_context(|| {
                    format!("--rename {text}: the signal has the channels {}", known.join(", "))
                })?;
            name.clone_into(&mut channel.name);
        }
        let file = inputs::output(self.out.clone(), kind.name, "csv");
        cli::can_write_as(&file, inputs::CSV)?;
        let time = (0..signal.len()).map(|n| signal.time(n)).collect();
        let mut log = Log::new(&file.display().to_string(), time)?;
        let mut channels = Vec::new();
        for channel in &signal.channels {
            log.add_column(&channel.name, Some(&channel.unit), channel.values.clone())?;
            let (min, max) = (channel.minimum(), channel.maximum());
            channels.push(ChannelRow {
                name: channel.name.clone(),
                unit: channel.unit.clone(),
                min,
                max,
            });
        }
        log.write(&file, UnitPlace::Sidecar)?;
        let (samples, sample_time_s) = (signal.len(), signal.period);
        Ok(Generated::Written { signal: kind.name, file, samples, sample_time_s, channels })
    }
}

/// A `KEY=VALUE`.
fn setting(text: &str) -> anyhow::Result<(&str, f64)> {
    let parsed = text.split_once('=').and_then(|(key, value)| {
        let value: f64 = value.trim().parse().ok()?;
        value.is_finite().then_some((key.trim(), value))
    });
    parsed
        .with_context(|| format!("--set {text}: write KEY=VALUE with a number, as in frequency=2"))
}

/// All signals.
pub(crate) fn list() -> Vec<Row> {
    let families = signals::FAMILIES.iter();
    let row = |family: &'static signals::Family, signal: &'static SignalType| Row {
        family: family.title,
        name: signal.name,
        summary: signal.summary,
    };
    families.flat_map(|family| family.signals.iter().map(move |s| row(family, s))).collect()
}

/// Writes the list for a person.
pub(crate) fn write_list(rows: &[Row], out: &mut dyn Write) -> io::Result<()> {
    let mut family = "";
    for row in rows {
        if row.family != family {
            writeln!(out, "{}", row.family)?;
            family = row.family;
        }
        writeln!(out, "  {:28} {}", row.name, row.summary)?;
    }
    writeln!(
        out,
        "\nParameters of one: piezoloop signal p0-train-h --about; write it: piezoloop signal p0-train-h -o train.csv"
    )
}

fn about(kind: &'static SignalType) -> About {
    let parameter = |p: &'static signals::Parameter| ParameterRow {
        name: p.name,
        unit: p.unit,
        start: p.start,
        min: p.min,
        max: p.max,
        description: p.description,
    };
    About {
        name: kind.name,
        summary: kind.summary,
        source: kind.source,
        equation: kind.equation,
        parameters: kind.parameters.iter().map(parameter).collect(),
        rules: kind.rules.iter().map(|rule| format!("{} {}", rule.parameter, rule.text)).collect(),
    }
}

impl Answer for Generated {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::List(rows) => write_list(rows, out),
            Self::About(about) => {
                writeln!(out, "{}\n    {}", about.name, about.summary)?;
                writeln!(out, "    source: {}\n    {}", about.source, about.equation)?;
                for p in &about.parameters {
                    writeln!(
                        out,
                        "    {} = {} [{}], {} to {}  {}",
                        p.name, p.start, p.unit, p.min, p.max, p.description
                    )?;
                }
                about.rules.iter().try_for_each(|rule| writeln!(out, "    {rule}"))
            }
            Self::Written { signal, file, samples, sample_time_s, channels } => {
                writeln!(
                    out,
                    "{}: written, {signal}, {}, sample time {sample_time_s} s",
                    file.display(),
                    data::counted(*samples, "row")
                )?;
                for c in channels {
                    let (min, max) = (rounded(c.min), rounded(c.max));
                    writeln!(out, "  {}: {min} to {max} {}", c.name, c.unit)?;
                }
                Ok(())
            }
        }
    }
}

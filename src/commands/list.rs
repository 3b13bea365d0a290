//! `piezoloop list`: rigs, records, effects, models, signals, options.

use std::collections::BTreeMap;
use std::io::{self, Write};

use anyhow::Context;
use clap::Args;
use cli::{Answer, Screen};
use serde::Serialize;

use crate::commands::signal;
use crate::{inputs, ranges, usage};

/// Lists rigs, records, effects, models, signals or options
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop list rigs\n  piezoloop list rigs --show evc > evc.toml\n  piezoloop list models --json"
)]
pub(crate) struct List {
    /// What to list
    what: What,
    /// Print the blueprint of this rig, or this record
    #[arg(long, value_name = "NAME")]
    show: Option<String>,
}

#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    /// Blueprints of known machines
    Rigs,
    /// Values of known specimens with their sources, for a component's key `record`
    Records,
    /// Physical effects by their fixed identifiers
    Effects,
    /// Component types that a blueprint may use
    Models,
    /// Test signals by name
    Signals,
    /// Every option of every command, with the range of its numbers
    Options,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Listing {
    Rigs(Vec<RigRow>),
    Records(Vec<RecordRow>),
    Effects(Vec<EffectRow>),
    Models(Vec<ModelRow>),
    Signals(Vec<signal::Row>),
    Options(Vec<OptionRow>),
    Text { name: &'static str, blueprint: &'static str },
}

#[derive(Serialize)]
struct RigRow {
    name: &'static str,
    summary: &'static str,
}

#[derive(Serialize)]
struct OptionRow {
    command: String,
    option: String,
    /// What the option row takes; none: it is a switch.
    value: Option<String>,
    range: Option<String>,
}

#[derive(Serialize)]
struct RecordRow {
    name: &'static str,
    description: String,
    components: Vec<String>,
}

#[derive(Serialize)]
struct EffectRow {
    name: &'static str,
    stage: &'static str,
    group: Option<&'static str>,
    components: Vec<&'static str>,
    signature: &'static str,
}

#[derive(Serialize)]
struct ModelRow {
    r#type: &'static str,
    stage: &'static str,
    summary: &'static str,
    equation: &'static str,
    effect: Option<&'static str>,
    structure: Vec<QuantityRow>,
    parameters: Vec<QuantityRow>,
    /// Values by name on an axis in V and um, where the component declares an example.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    example: BTreeMap<&'static str, &'static [f64]>,
}

#[derive(Serialize)]
struct QuantityRow {
    name: &'static str,
    unit: &'static str,
    description: &'static str,
    start: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
    /// The structural setting that says how many values it has; none: one value.
    length: Option<&'static str>,
}

impl List {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let listing = match (self.what, &self.show) {
            (What::Rigs, Some(name)) => {
                let rig = rigs::find(name).with_context(|| {
                    let known: Vec<_> = rigs::RIGS.iter().map(|r| r.name).collect();
                    let near = inputs::meant(name, known.iter().copied());
                    format!("no rig is named \"{name}\"; {near}known are {}", known.join(", "))
                })?;
                Listing::Text { name: rig.name, blueprint: rig.blueprint }
            }
            (What::Records, Some(name)) => {
                let record = rigs::record(name).with_context(|| {
                    let known: Vec<_> = rigs::RECORDS.iter().map(|r| r.name).collect();
                    format!("no record is named \"{name}\"; known are {}", known.join(", "))
                })?;
                Listing::Text { name: record.name, blueprint: record.text }
            }
            (_, Some(_)) => {
                anyhow::bail!(
                    "--show prints a rig's blueprint or a record: use it with `list rigs` or `list \
                     records`"
                )
            }
            (What::Rigs, None) => Listing::Rigs(
                rigs::RIGS.iter().map(|r| RigRow { name: r.name, summary: r.summary }).collect(),
            ),
            (What::Records, None) => Listing::Records(records()?),
            (What::Effects, None) => Listing::Effects(effects()),
            (What::Models, None) => Listing::Models(models()),
            (What::Signals, None) => Listing::Signals(signal::list()),
            (What::Options, None) => {
                let mut tool = usage::command();
                // Settles which of them take values.
                tool.build();
                let mut rows = Vec::new();
                options(&tool, "", &mut rows);
                Listing::Options(rows)
            }
        };
        screen.show(&listing)
    }
}

fn records() -> anyhow::Result<Vec<RecordRow>> {
    let row = |file: &'static rigs::Record| {
        let record = data::ParameterRecord::parse(file.text, file.name)?;
        let components = record.components.into_iter().map(|(kind, _)| kind).collect();
        Ok(RecordRow { name: file.name, description: record.description, components })
    };
    rigs::RECORDS.iter().map(row).collect()
}

/// The options of a command and of those below it.
fn options(command: &clap::Command, way: &str, rows: &mut Vec<OptionRow>) {
    let is_tool = way.is_empty();
    let own = |arg: &&clap::Arg| is_tool || !arg.is_global_set();
    for arg in command.get_arguments().filter(own) {
        let Some(long) = arg.get_long() else { continue };
        let names = arg.get_value_names().unwrap_or_default();
        let takes = arg.get_num_args().is_some_and(|count| count.takes_values());
        rows.push(OptionRow {
            command: way.trim().to_owned(),
            option: format!("--{long}"),
            value: takes.then(|| names.first().map_or_else(String::new, ToString::to_string)),
            range: ranges::of(arg),
        });
    }
    // Each command has one that shows its help.
    for below in command.get_subcommands().filter(|below| below.get_name() != "help") {
        options(below, &format!("{way} {}", below.get_name()), rows);
    }
}

fn effects() -> Vec<EffectRow> {
    let row = |effect: &'static model::Effect| EffectRow {
        name: effect.name,
        stage: effect.stage.name(),
        group: effect.group.map(group_name),
        components: learned::COMPONENTS
            .iter()
            .map(|c| c.declaration())
            .filter(|d| d.effect.is_some_and(|e| e.name == effect.name))
            .map(|d| d.kind)
            .collect(),
        signature: effect.signature,
    };
    components::effects::EFFECTS.iter().copied().map(row).collect()
}

fn group_name(group: model::Group) -> &'static str {
    match group {
        model::Group::Lag => "lag",
        model::Group::Gain => "gain",
        model::Group::Slow => "slow",
        model::Group::StaticMap => "static_map",
    }
}

fn models() -> Vec<ModelRow> {
    let row =
        |component: &'static dyn model::Component| model_row(component, component.declaration());
    learned::COMPONENTS.iter().copied().map(row).collect()
}

fn model_row(component: &'static dyn model::Component, d: &'static model::Declaration) -> ModelRow {
    ModelRow {
        r#type: d.kind,
        stage: d.stage.name(),
        summary: d.summary,
        equation: d.equation,
        effect: d.effect.map(|e| e.name),
        structure: d
            .structure
            .iter()
            .map(|s| QuantityRow {
                name: s.name,
                unit: s.unit,
                description: s.description,
                start: s.start,
                min: bound(s.min),
                max: bound(s.max),
                length: None,
            })
            .collect(),
        parameters: d
            .parameters
            .iter()
            .map(|q| QuantityRow {
                name: q.name,
                unit: q.unit,
                description: q.description,
                start: q.start,
                min: bound(q.min),
                max: bound(q.max),
                length: match q.shape {
                    model::Shape::Scalar => None,
                    model::Shape::Array(at) => d.structure.get(at).map(|s| s.name),
                },
            })
            .collect(),
        example: component.example().iter().copied().collect(),
    }
}

/// A bound, none where it is infinite: JSON has no infinity.
fn bound(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

impl Answer for Listing {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Text { blueprint, .. } => write!(out, "{blueprint}"),
            Self::Rigs(rows) => {
                for row in rows {
                    writeln!(out, "{:12} {}", row.name, row.summary)?;
                }
                writeln!(
                    out,
                    "\nShow one: piezoloop list rigs --show evc; pack one: piezoloop pack evc -o evc.fmu"
                )
            }
            Self::Records(rows) => {
                for row in rows {
                    let components = row.components.join(", ");
                    writeln!(out, "{:14} {}: values for {components}", row.name, row.description)?;
                }
                writeln!(
                    out,
                    "\nA component takes them by `record = \"p-752-21c\"`; show one: piezoloop list \
                     records --show p-752-21c"
                )
            }
            Self::Signals(rows) => signal::write_list(rows, out),
            Self::Options(rows) => rows.iter().try_for_each(|row| {
                let OptionRow { command, option, value, range } = row;
                let value = value.as_ref().map_or_else(String::new, |value| format!(" <{value}>"));
                let range = range.as_ref().map_or_else(String::new, |range| format!("  {range}"));
                writeln!(out, "{:60}{range}", format!("{command} {option}{value}").trim_start())
            }),
            Self::Effects(rows) => {
                writeln!(out, "{:26} {:12} {:11} component types", "effect", "stage", "group")?;
                for row in rows {
                    let group = row.group.unwrap_or("-");
                    let components = row.components.join(", ");
                    writeln!(out, "{:26} {:12} {group:11} {components}", row.name, row.stage)?;
                }
                Ok(())
            }
            Self::Models(rows) => {
                for row in rows {
                    writeln!(out, "{} ({})", row.r#type, row.stage)?;
                    writeln!(out, "    {}", row.summary)?;
                    for quantity in row.structure.iter().chain(&row.parameters) {
                        let start = quantity.start.map_or(String::new(), |s| format!(" = {s}"));
                        writeln!(
                            out,
                            "    {}{start} [{}]  {}",
                            quantity.name, quantity.unit, quantity.description
                        )?;
                    }
                }
                Ok(())
            }
        }
    }
}

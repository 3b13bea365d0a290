//! `piezoloop invert`: plant blueprint → controller blueprint.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use clap::builder::PossibleValue;
use cli::{PageOptions, Screen};
use control::{Along, CommandActs, ControlSettings, Damping, Feedback, Feedforward};
use data::CheckedBlueprint;

use crate::inputs::{self, LogOptions};
use crate::results::invert::{DampingOption, Inverted, Shown, Ways};
use crate::{pages, progress, ranges};

/// Most samples of a reference.
const MOST_POINTS: f64 = 1e6;

/// Designs the controller of a plant: inverse feedforward and PID
///
/// The feedforward inverts hysteresis, creep, amplifier and sensor, each with the inverse that its component declares
/// or with a model fitted to the plant. The kind of feedforward with the least error on the plant itself is used. The
/// PID gains are the largest that keep the sensitivity of the linearised loop below its limit. Coupled axes get a
/// coordinator. The controller is tested on the plant before it is written.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop invert plant.toml -o controller.toml\n  piezoloop invert evc --period 2e-5 -o controller.toml --report controller.html\n  piezoloop invert p2 --list\n  piezoloop invert p2 --feedforward inverse-free --feedback pi -o controller.toml\n  piezoloop invert p4-machine --damping nrc --sensitivity 2 -o beyond.toml\n  piezoloop invert p0 --period 5e-3 --system 2 -o coordinated.toml\n  piezoloop invert p0 --period 5e-3 --reference path.csv -o controller.toml"
)]
pub(crate) struct Invert {
    /// The plant's blueprint, or the name of a rig
    plant: PathBuf,
    /// Sample time of the controller in s [default: that of a learned model, otherwise the plant's internal step]
    #[arg(long, value_name = "S", value_parser = ranges::step())]
    period: Option<f64>,
    /// Highest frequency in Hz of the waves from which the inverse of a learned plant is learned [default: the
    /// bandwidth of its linear part, at most 1/50 of its sample rate]
    #[arg(long, value_name = "HZ", value_parser = ranges::above(0.0, 1e12))]
    band: Option<f64>,
    /// Largest allowed sensitivity |1/(1+L)| of the loop
    #[arg(long, value_name = "M", value_parser = ranges::above(1.0, 100.0), default_value_t = ControlSettings::default().sensitivity)]
    sensitivity: f64,
    /// Largest allowed amplification of sensor noise by the controller (command noise, converted to position,
    /// relative to the sensor noise)
    #[arg(long, value_name = "RATIO", value_parser = ranges::above(0.0, 1e9), default_value_t = ControlSettings::default().noise)]
    noise: f64,
    /// Kind of feedforward
    #[arg(long, value_name = "WAY", value_parser = feedforwards(), default_value = "automatic")]
    feedforward: String,
    /// Control law
    #[arg(long, value_name = "LAW", value_parser = feedbacks(), default_value = "pid")]
    feedback: String,
    /// Damp the first resonance in an inner loop, so that the bandwidth can exceed it; use it with --sensitivity 2. The
    /// loop is stable and within --sensitivity for modes 10 % off, with half and with twice the damping. --feedback
    /// must be pid or pi
    #[arg(long, value_name = "LAW", value_parser = dampings(), default_value = "none")]
    damping: String,
    /// When a command acts on the plant. at-once allows larger gains, but the loop may become unstable if the command
    /// acts later
    #[arg(long, value_name = "WHEN", value_parser = acts(), default_value = "either")]
    command_acts: String,
    /// No feedforward; the same as --feedforward none
    #[arg(long, conflicts_with = "feedforward")]
    feedback_only: bool,
    /// One of the four control systems for two mirrors with two axes each: 1 PID, each mirror uses its own sensor; 2
    /// PID, coordinated; 3 feedforward, coordinated; 4 both, coordinated
    #[arg(long, value_name = "N", value_parser = ranges::integers(1_u8, 4), conflicts_with_all = ["feedforward", "feedback", "feedback_only", "damping"])]
    system: Option<u8>,
    /// Also run the controller on the plant along this reference (a log with the columns reference[i] or the axes'
    /// own names), and report where it needs commands beyond their limits
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Show the result of each kind of feedforward on this plant; write nothing
    #[arg(long)]
    list: bool,
    /// Write the controller even if its error on its own plant is larger than that of feedback alone
    #[arg(long)]
    force: bool,
    /// Name of the controller [default: the plant's name with _controller appended]
    #[arg(long)]
    name: Option<String>,
    /// The blueprint to write
    #[arg(short = 'o', long = "out", value_name = "FILE", default_value = "controller.toml")]
    out: PathBuf,
    #[command(flatten)]
    page: PageOptions,
}

fn feedforwards() -> clap::builder::PossibleValuesParser {
    let values = Feedforward::ALL.map(|way| PossibleValue::new(way.name()).help(way.summary()));
    values.to_vec().into()
}

fn feedbacks() -> clap::builder::PossibleValuesParser {
    let values = Feedback::ALL.map(|law| PossibleValue::new(law.name()).help(law.summary()));
    values.to_vec().into()
}

fn dampings() -> clap::builder::PossibleValuesParser {
    let values =
        Damping::ALL.map(|damping| PossibleValue::new(damping.name()).help(damping.summary()));
    values.to_vec().into()
}

fn acts() -> clap::builder::PossibleValuesParser {
    let values = CommandActs::ALL.map(|acts| PossibleValue::new(acts.name()).help(acts.summary()));
    values.to_vec().into()
}

impl Invert {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        if self.list {
            if self.page.is_asked() {
                bail!(
                    "--list designs no controller that a page could show; leave out --list, or --report and --plot"
                );
            }
            return screen.show(&self.ways(screen)?);
        }
        self.page.can_write()?;
        let answer = self.execute(screen)?;
        let files: Vec<(&str, &Path)> =
            [("plant", Some(&self.plant)), ("reference", self.reference.as_ref())]
                .into_iter()
                .filter_map(|(role, file)| Some((role, file?.as_path())))
                .filter(|(_, file)| file.is_file())
                .collect();
        self.page
            .finish(screen, &answer, || Ok(pages::inversion(&answer, pages::provenance(&files)?)))
    }

    /// Every way of feedforward on this plant.
    fn ways(&self, screen: &Screen) -> anyhow::Result<Ways> {
        let plant = inputs::blueprint(&self.plant)?.blueprint.check(learned::COMPONENTS)?;
        let mut ways = Vec::new();
        for way in Feedforward::ALL.into_iter().filter(|way| *way != Feedforward::Automatic) {
            let settings = ControlSettings { feedforward: way, force: true, ..self.settings() };
            let observer = &mut progress::Stages::new(screen, "invert");
            let (axes, reason) = match control::invert(&plant, &settings, observer) {
                Ok(found) => (found.axes, None),
                Err(control::Error::NotInvertible(reasons)) => {
                    let all: Vec<String> = reasons.iter().map(ToString::to_string).collect();
                    (Vec::new(), Some(all.join("; ")))
                }
                Err(error) => return Err(error.into()),
            };
            ways.push(DampingOption { name: way.name(), summary: way.summary(), axes, reason });
        }
        Ok(Ways { ways })
    }

    fn settings(&self) -> ControlSettings {
        let way = |way: &Feedforward| way.name() == self.feedforward;
        let law = |law: &Feedback| law.name() == self.feedback;
        let chosen = Feedforward::ALL.into_iter().find(way).unwrap_or_default();
        let feedforward = match self.system {
            Some(1 | 2) => Feedforward::None,
            _ if self.feedback_only => Feedforward::None,
            _ => chosen,
        };
        let feedback = match self.system {
            Some(3) => Feedback::None,
            _ => Feedback::ALL.into_iter().find(law).unwrap_or_default(),
        };
        ControlSettings {
            name: self.name.clone(),
            period: self.period,
            band: self.band,
            sensitivity: self.sensitivity,
            noise: self.noise,
            feedforward,
            feedback,
            damping: Damping::ALL
                .into_iter()
                .find(|damping| damping.name() == self.damping)
                .unwrap_or_default(),
            acts: CommandActs::ALL
                .into_iter()
                .find(|acts| acts.name() == self.command_acts)
                .unwrap_or_default(),
            independent: self.system == Some(1),
            force: self.force,
        }
    }

    /// Makes and writes the controller.
    pub(crate) fn execute(&self, screen: &Screen) -> anyhow::Result<Inverted> {
        cli::can_write_as(&self.out, inputs::BLUEPRINT)?;
        let plant = inputs::blueprint(&self.plant)?.blueprint.check(learned::COMPONENTS)?;
        let log =
            self.reference.as_deref().map(|file| LogOptions::default().read(file)).transpose()?;
        let observer = &mut progress::Stages::new(screen, "invert");
        let inversion = control::invert(&plant, &self.settings(), observer)?;
        if self.system.is_some() && inversion.coordinators.is_empty() {
            bail!(
                "{}: --system chooses among the controllers of axes that are coupled, and no coupling joins these; leave it \
                 out",
                self.plant.display()
            );
        }
        let controller = inversion.controller;
        let along = match &log {
            Some(log) => along(log, &plant, &controller)?,
            None => Vec::new(),
        };
        let responses = if self.page.is_asked() {
            let acts = self.settings().acts;
            let found = control::responses(&plant, &controller, &inversion.axes, acts)?;
            let units = plant.blueprint().axes.iter();
            let units = units.map(|axis| [axis.command.unit.clone(), axis.position.unit.clone()]);
            let allowed = self.sensitivity;
            let each = found.into_iter().zip(units);
            each.map(|(responses, units)| Shown { responses, units, allowed }).collect()
        } else {
            Vec::new()
        };
        controller.write(&self.out)?;
        let period_s = controller.spec().period;
        Ok(Inverted {
            blueprint: self.out.clone(),
            period_s,
            axes: inversion.axes,
            coordinators: inversion.coordinators,
            along,
            responses,
        })
    }
}

/// Plant and controller along a reference, at the controller's period.
fn along(
    log: &data::Log,
    plant: &CheckedBlueprint,
    controller: &CheckedBlueprint,
) -> anyhow::Result<Vec<Along>> {
    let (time, period) = (log.time(), controller.spec().period);
    let (Some(first), Some(last)) = (time.first(), time.last()) else {
        bail!("{}: the reference has no rows", log.origin());
    };
    let points = ((last - first) / period + 1e-6).floor() + 1.0;
    if points > MOST_POINTS {
        bail!(
            "{}: {points:.3e} samples of {period} s; give a reference of at most {MOST_POINTS:.0e}",
            log.origin()
        );
    }
    let row = |point: usize| {
        let at = first + (point as f64 + 1e-6) * period;
        time.partition_point(|t| *t <= at).saturating_sub(1)
    };
    let mut references = Vec::new();
    for (number, axis) in (1..).zip(&plant.blueprint().axes) {
        let usual = format!("reference[{number}]");
        let own = &axis.position.name;
        let names = [usual.clone(), format!("{own}_reference"), own.clone(), axis.name.clone()];
        let has = |name: &&String| log.column(name).is_some();
        let Some(name) = names.iter().find(has) else {
            bail!(
                "{}: has no column \"{usual}\" for axis {}, nor one of its name or its position's",
                log.origin(),
                axis.name
            );
        };
        let values = match &log.require(name)?.unit {
            Some(_) => log.convert(name, &axis.position.unit)?,
            None => log.require(name)?.values.clone(),
        };
        references.push((0..points as usize).map(|point| values[row(point)]).collect());
    }
    Ok(control::along(plant, controller, &references, period)?)
}

//! `piezoloop invert`: plant blueprint → controller blueprint.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValue;
use control::{ControlSettings, Coordinator, Feedback, Feedforward, LoopFigures};
use serde::Serialize;

use crate::answer::{Answer, Screen};
use crate::{inputs, interrupt, progress};

/// Error of a learned inverse, in parts of the range, from which it is pointed out.
const NOTED: f64 = 0.01;

/// Makes the controller of a plant: inverse feedforward and PID
///
/// The feedforward undoes what the plant does: hysteresis, creep, amplifier and sensor, each as its component
/// declares, or by a model that is fitted to the plant; the one that errs least on the plant itself is taken.
/// The PID gains are the largest that keep the sensitivity of the linearised loop below its limit. Axes that are
/// coupled get a coordinator. The controller is run on the plant before it is written.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop invert plant.toml -o controller.toml\n  piezoloop invert evc --period 2e-5 -o controller.toml\n  piezoloop invert p2 --list\n  piezoloop invert p2 --feedforward inverse-free --feedback pi -o controller.toml"
)]
pub(crate) struct Invert {
    /// The plant's blueprint, or the name of a rig
    plant: PathBuf,
    /// Sample time of the controller in s [default: the learned model's, else the plant's internal
    /// step]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    period: Option<f64>,
    /// Greatest frequency in Hz of the waves that the inverse of a learned plant is learned from
    /// [default: the bandwidth of its linear part, at most 1/50 of its sample rate]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    band: Option<f64>,
    /// Largest sensitivity |1/(1+L)| that the loop may have
    #[arg(long, allow_negative_numbers = true, value_name = "M", default_value_t = ControlSettings::default().sensitivity)]
    sensitivity: f64,
    /// Most that sensor noise may be amplified on its way to the command, seen as position
    #[arg(long, allow_negative_numbers = true, value_name = "RATIO", default_value_t = ControlSettings::default().noise)]
    noise: f64,
    /// How the feedforward is made
    #[arg(long, value_name = "WAY", value_parser = feedforwards(), default_value = "automatic")]
    feedforward: String,
    /// The law that acts on the error
    #[arg(long, value_name = "LAW", value_parser = feedbacks(), default_value = "pid")]
    feedback: String,
    /// Leave the feedforward out: --feedforward none
    #[arg(long, conflicts_with = "feedforward")]
    feedback_only: bool,
    /// Show what each way of feedforward does on this plant; nothing is written
    #[arg(long)]
    list: bool,
    /// Write a controller that errs more than feedback alone on its own plant all the same
    #[arg(long)]
    force: bool,
    /// Name of the controller [default: the plant's with _controller behind it]
    #[arg(long)]
    name: Option<String>,
    /// The blueprint to write
    #[arg(short = 'o', long = "out", value_name = "FILE", default_value = "controller.toml")]
    out: PathBuf,
}

fn feedforwards() -> clap::builder::PossibleValuesParser {
    let values = Feedforward::ALL.map(|way| PossibleValue::new(way.name()).help(way.summary()));
    values.to_vec().into()
}

fn feedbacks() -> clap::builder::PossibleValuesParser {
    let values = Feedback::ALL.map(|law| PossibleValue::new(law.name()).help(law.summary()));
    values.to_vec().into()
}

#[derive(Serialize)]
pub(crate) struct Inverted {
    blueprint: PathBuf,
    period_s: f64,
    pub(crate) axes: Vec<LoopFigures>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    coordinators: Vec<Coordinator>,
}

/// What each way of feedforward does on a plant.
#[derive(Serialize)]
struct Ways {
    ways: Vec<Way>,
}

#[derive(Serialize)]
struct Way {
    name: &'static str,
    summary: &'static str,
    /// Of each axis; empty where the way does not suit.
    axes: Vec<LoopFigures>,
    /// Why it does not suit.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

impl Invert {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        if self.list {
            return screen.show(&self.ways(screen)?);
        }
        screen.show(&self.execute(screen)?)
    }

    /// Every way of feedforward on this plant.
    fn ways(&self, screen: &Screen) -> anyhow::Result<Ways> {
        interrupt::listen()?;
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
            ways.push(Way { name: way.name(), summary: way.summary(), axes, reason });
        }
        Ok(Ways { ways })
    }

    fn settings(&self) -> ControlSettings {
        let way = |way: &Feedforward| way.name() == self.feedforward;
        let law = |law: &Feedback| law.name() == self.feedback;
        let feedforward = Feedforward::ALL.into_iter().find(way).unwrap_or_default();
        ControlSettings {
            name: self.name.clone(),
            period: self.period,
            band: self.band,
            sensitivity: self.sensitivity,
            noise: self.noise,
            feedforward: if self.feedback_only { Feedforward::None } else { feedforward },
            feedback: Feedback::ALL.into_iter().find(law).unwrap_or_default(),
            force: self.force,
        }
    }

    /// Makes and writes the controller.
    pub(crate) fn execute(&self, screen: &Screen) -> anyhow::Result<Inverted> {
        interrupt::listen()?;
        inputs::not_over(&self.out, &[&self.plant])?;
        let plant = inputs::blueprint(&self.plant)?.blueprint.check(learned::COMPONENTS)?;
        let observer = &mut progress::Stages::new(screen, "invert");
        let inversion = control::invert(&plant, &self.settings(), observer)?;
        let controller = inversion.controller;
        inputs::write_blueprint(&controller, &self.out, &[&self.plant])?;
        let period_s = controller.spec().period;
        Ok(Inverted {
            blueprint: self.out.clone(),
            period_s,
            axes: inversion.axes,
            coordinators: inversion.coordinators,
        })
    }
}

impl Answer for Inverted {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for axis in &self.axes {
            write_axis(axis, out)?;
        }
        for coordinator in &self.coordinators {
            writeln!(
                out,
                "{} ({}): coordinated through their Jacobian, condition number {:.3}{}{}",
                coordinator.axes.join(", "),
                coordinator.couplings.join(", "),
                coordinator.condition,
                if coordinator.note.is_empty() { "" } else { "; " },
                coordinator.note
            )?;
        }
        writeln!(out, "{}: written, sample time {} s", self.blueprint.display(), self.period_s)
    }
}

impl Answer for Ways {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for way in &self.ways {
            writeln!(out, "{}: {}", way.name, way.summary)?;
            if let Some(reason) = &way.reason {
                writeln!(out, "  does not suit: {reason}")?;
            }
            for axis in &way.axes {
                writeln!(out, "  axis {}: {}", axis.axis, axis.feedforward)?;
                write_checks(axis, out)?;
            }
        }
        Ok(())
    }
}

fn write_axis(axis: &LoopFigures, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "axis {}: {}", axis.axis, axis.shape)?;
    writeln!(out, "  feedforward: {}", axis.feedforward)?;
    writeln!(
        out,
        "  kp {:.6} ki {:.6} kd {:.6} (command per position, per second, times second)",
        axis.kp, axis.ki, axis.kd
    )?;
    writeln!(
        out,
        "  bandwidth {:.2} Hz, gain margin {:.2}, phase margin {:.1}°, sensitivity {:.2}, delay {:.3} ms, reach {:.4} to {:.4}",
        axis.bandwidth,
        axis.gain_margin,
        axis.phase_margin,
        axis.sensitivity,
        1e3 * axis.delay,
        axis.reach.0,
        axis.reach.1
    )?;
    write_checks(axis, out)?;
    for left in &axis.left_to_feedback {
        writeln!(out, "  note: {left}")?;
    }
    let Some(inverse) = &axis.inverse else { return Ok(()) };
    writeln!(
        out,
        "  inverse: {} support vectors, learned from {} waves of {:.4} to {:.4} Hz; on {} others the \
         position that it leads to errs by {:.3} % of the range, at most {:.2} %",
        inverse.centres,
        inverse.waves,
        inverse.band[0],
        inverse.band[1],
        inverse.judged,
        100.0 * inverse.error,
        100.0 * inverse.greatest
    )?;
    if inverse.error > NOTED {
        writeln!(
            out,
            "  note: that is more than {:.0} % of the range; try another --band, or a log with loops of \
             more sizes",
            100.0 * NOTED
        )?;
    }
    Ok(())
}

/// What the controller does on its own plant.
fn write_checks(axis: &LoopFigures, out: &mut dyn Write) -> io::Result<()> {
    for check in &axis.checks {
        let alone = check.feedforward.map_or_else(String::new, |error| {
            format!(", feedforward alone {:.4} %", 100.0 * error)
        });
        writeln!(
            out,
            "  on its own plant, {:.4} Hz over {:.0} % of the reach: rms error {:.4} % of it{alone}, feedback \
             alone {:.4} %",
            check.frequency,
            100.0 * check.swing,
            100.0 * check.closed_loop,
            100.0 * check.feedback
        )?;
    }
    Ok(())
}

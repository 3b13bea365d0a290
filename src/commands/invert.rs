//! `piezoloop invert`: plant blueprint → controller blueprint.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use control::{ControlSettings, LoopFigures};
use serde::Serialize;

use crate::answer::{Answer, Screen};
use crate::{inputs, interrupt, progress};

/// Error of a learned inverse, in parts of the range, from which it is pointed out.
const TOLD: f64 = 0.01;

/// Makes the controller of a plant: inverse feedforward and PID
///
/// The feedforward is the inverse of the plant's hysteresis: exact for plays, learned for
/// lssvm-stops, from what the plant answers to waves over its range. The PID gains are the largest that
/// keep the sensitivity of the linearised loop below its limit.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop invert plant.toml -o controller.toml\n  piezoloop invert evc --period 2e-5 -o controller.toml"
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
    /// Leave the feedforward out
    #[arg(long)]
    feedback_only: bool,
    /// Name of the controller [default: the plant's with _controller behind it]
    #[arg(long)]
    name: Option<String>,
    /// The blueprint to write
    #[arg(short = 'o', long = "out", value_name = "FILE", default_value = "controller.toml")]
    out: PathBuf,
}

#[derive(Serialize)]
pub(crate) struct Inverted {
    blueprint: PathBuf,
    period_s: f64,
    pub(crate) axes: Vec<LoopFigures>,
}

impl Invert {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        screen.show(&self.execute(screen)?)
    }

    /// Makes and writes the controller.
    pub(crate) fn execute(&self, screen: &Screen) -> anyhow::Result<Inverted> {
        interrupt::listen()?;
        inputs::not_over(&self.out, &[&self.plant])?;
        let plant = inputs::blueprint(&self.plant)?.blueprint.check(learned::COMPONENTS)?;
        let settings = ControlSettings {
            name: self.name.clone(),
            period: self.period,
            band: self.band,
            sensitivity: self.sensitivity,
            noise: self.noise,
        };
        let observer = &mut progress::Stages::new(screen, "invert");
        let inversion = control::invert(&plant, &settings, observer)?;
        let mut controller = inversion.controller;
        if self.feedback_only {
            let mut alone = controller.blueprint().clone();
            for axis in &mut alone.axes {
                axis.components.retain(|component| component.kind == "pid");
            }
            alone.tables.clear();
            controller = alone.check(learned::COMPONENTS)?;
        }
        inputs::write_blueprint(&controller, &self.out, &[&self.plant])?;
        let period_s = controller.spec().period;
        Ok(Inverted { blueprint: self.out.clone(), period_s, axes: inversion.axes })
    }
}

impl Answer for Inverted {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for axis in &self.axes {
            writeln!(out, "axis {}: {}", axis.axis, axis.shape)?;
            writeln!(
                out,
                "  kp {:.6} ki {:.6} kd {:.6} (command per position, per second, times second)",
                axis.kp, axis.ki, axis.kd
            )?;
            writeln!(
                out,
                "  bandwidth {:.2} Hz, gain margin {:.2}, phase margin {:.1}°, sensitivity {:.2}, reach {:.4} to {:.4}",
                axis.bandwidth,
                axis.gain_margin,
                axis.phase_margin,
                axis.sensitivity,
                axis.reach.0,
                axis.reach.1
            )?;
            let Some(inverse) = &axis.inverse else { continue };
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
            if inverse.error > TOLD {
                writeln!(
                    out,
                    "  note: that is more than {:.0} % of the range; try another --band, or a log with loops of \
                     more sizes",
                    100.0 * TOLD
                )?;
            }
        }
        writeln!(out, "{}: written, sample time {} s", self.blueprint.display(), self.period_s)
    }
}

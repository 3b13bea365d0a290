//! `piezoloop tune`: PID gains from experiments on a plant FMU.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use cli::{PageOptions, Screen};
use control::Gains;

use crate::fmus::{self, Isolation};
use crate::results::tune::{Tuned, TunedLoop};
use crate::{pages, ranges};

/// Finds PID gains by experiments on a plant FMU: Ziegler-Nichols gains and robust gains
///
/// An experiment around --middle, with a relay or proportional control, gives the ultimate gain K_u and period T_u;
/// the Ziegler-Nichols rules follow from them. A step response gives the linear response, for which the robust gains
/// are designed and the margins of both are computed.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop tune plant.fmu --period 5e-3 --middle 75 --amplitude 10\n  piezoloop tune p1-truth --period 2e-3 --middle 5 --amplitude 0.5 --experiment gain"
)]
pub(crate) struct Tune {
    /// The plant: an FMU, a blueprint, or the name of a rig
    plant: PathBuf,
    /// Axis to tune, from 1; the others stay at --middle
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = ranges::count(1, 1000))]
    axis: usize,
    /// Period of the controller in s
    #[arg(long, value_name = "S", value_parser = ranges::step())]
    period: f64,
    /// Command around which the experiments are made
    #[arg(long, value_name = "COMMAND", value_parser = ranges::signal())]
    middle: f64,
    /// Greatest deviation of the command from --middle
    #[arg(long, value_name = "COMMAND", value_parser = ranges::above(0.0, 1e15))]
    amplitude: f64,
    /// Experiment that finds the ultimate gain
    #[arg(long, value_enum, default_value_t = Experiment::Relay)]
    experiment: Experiment,
    /// Largest sensitivity |1/(1+L)| of the robust gains
    #[arg(long, value_name = "M", default_value_t = 1.5, value_parser = ranges::above(1.0, 100.0))]
    sensitivity: f64,
    /// Largest allowed amplification of sensor noise by the controller (command noise, converted to position,
    /// relative to the sensor noise)
    #[arg(long, value_name = "RATIO", default_value_t = 10.0, value_parser = ranges::above(0.0, 1e9))]
    noise: f64,
    /// Samples of the step response
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = ranges::count(1, 200_000))]
    samples: usize,
    #[command(flatten)]
    isolation: Isolation,
    #[command(flatten)]
    page: PageOptions,
}

#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Experiment {
    /// Relay: the loop oscillates by itself
    Relay,
    /// Proportional gain, by bisection up to the limit of stability
    Gain,
}

impl Tune {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let files = [("plant", self.plant.as_path())];
        let read = if self.plant.exists() { &files[..] } else { &[] };
        self.page.can_write()?;
        let fmus::Opened { fmu, folder, .. } =
            fmus::open_in(&self.plant, self.isolation.worker()?.as_ref())?;
        let mut bed = cosim::Bed::new(fmu, folder, &self.plant)?;
        let axes = bed.axes();
        if !(1..=axes).contains(&self.axis) {
            bail!("--axis {}: the plant has axes 1 to {axes}", self.axis);
        }
        let at = self.axis - 1;
        let mut commands = vec![self.middle; axes];
        bed.rest(&commands, self.period)?;
        let mut machine = |u: f64| {
            commands[at] = u;
            let moved = bed.step(&commands).map(|positions| positions[at]);
            moved.map_err(|e| identify::Error::Tuning { message: e.to_string() })
        };
        let point = [self.middle, self.amplitude];
        let found = match self.experiment {
            Experiment::Relay => control::relay(&mut machine, self.period, point, 20),
            Experiment::Gain => control::ultimate_by_gain(&mut machine, self.period, point),
        };
        let impulse = control::impulse_of(&mut machine, point, self.samples.max(10), 4)?;
        let frequencies: Vec<f64> = [0.001, 0.01, 0.1].map(|part| part / self.period).to_vec();
        let judge = |name, gains: Gains| TunedLoop {
            name,
            gains,
            verdict: control::judge_loop(&impulse, self.period, &gains, false, &frequencies),
        };
        let mut loops = Vec::new();
        if let Ok(ultimate) = &found {
            loops.push(judge("Ziegler-Nichols", control::ziegler_nichols(ultimate)));
        }
        let robust = control::robust(&impulse, self.period, self.sensitivity, self.noise)?;
        loops.push(judge("robust", robust));
        let answer = Tuned {
            axis: self.axis,
            period_s: self.period,
            slope: impulse.iter().sum(),
            why_not: found.as_ref().err().map(ToString::to_string),
            ultimate: found.ok(),
            loops,
            impulse,
        };
        self.page.finish(screen, &answer, || Ok(pages::tuning(&answer, pages::provenance(read)?)))
    }
}

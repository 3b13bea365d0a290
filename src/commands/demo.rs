//! `piezoloop demo`: the main job from end to end, by the commands that a user would type.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, bail};
use clap::{Args, Parser};
use cli::{Answer, PageOptions, Screen};
use cosim::{Experiment, Fmu, InstanceOptions, Selection};
use data::{Log, UnitPlace};
use serde::Serialize;
use signals::Signal;

use super::Command;
use crate::results::identify::Identified;
use crate::results::simulate::{OutputFit, Simulated};

mod page;

/// Runs the complete chain on a built-in machine: identify, pack, close the loop; prints figures and writes one page
///
/// The machine is the rig evc-truth: two axes with asymmetric hysteresis, creep and sensor noise, which the
/// identified model lacks. The demo records a log of it, identifies a plant, designs its controller, packs both, and
/// closes the loop on the machine with and without feedforward.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  piezoloop demo -o my-demo")]
pub(crate) struct Demo {
    /// Folder for all results
    #[arg(short = 'o', long = "out", value_name = "FOLDER", default_value = "piezoloop-demo")]
    out: PathBuf,
    #[command(flatten)]
    page: PageOptions,
}

/// The figures of the demo.
#[derive(Serialize)]
pub(crate) struct Demonstration {
    pub(crate) page: PathBuf,
    pub(crate) axes: Vec<AxisFigures>,
    pub(crate) do_step_ns: f64,
    pub(crate) seconds: f64,
}

/// What came out for one axis.
#[derive(Serialize)]
pub(crate) struct AxisFigures {
    pub(crate) axis: String,
    /// Held-out error of the identified plant, % of range.
    pub(crate) identified_percent: f64,
    /// Held-out error of a straight line, % of range.
    pub(crate) line_percent: f64,
    /// Largest error over peak-to-peak of the reference in %, PID alone.
    pub(crate) pid_percent: f64,
    /// Largest error over peak-to-peak of the reference in %, with the inverse as feedforward.
    pub(crate) inverse_and_pid_percent: f64,
    /// Least and greatest command of the loop with feedforward while it was judged, and whether it
    /// reached a bound.
    pub(crate) command_range: (f64, f64),
    pub(crate) saturated: bool,
}

/// Largest error over peak-to-peak of the reference that the paper reaches, in %.
pub(crate) const PAPER_PERCENT: f64 = 6.2;
/// By how much the feedforward must reduce the error.
pub(crate) const LEAST_GAIN: f64 = 3.0;
/// Sample time of the controller in s.
const PERIOD: &str = "2e-5";
/// Time in s from which the loops are judged; before it the ellipse grows.
const JUDGED_FROM: f64 = 0.1;
/// Bounds of the command of both axes in V.
const COMMAND: (f64, f64) = (0.0, 120.0);

impl Demo {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let begin = Instant::now();
        self.page.can_write()?;
        files::own_folder(&self.out, &["index.html", "machine.fmu"])
            .with_context(|| format!("the folder {} cannot be used", self.out.display()))?;
        let stage = Stage { folder: &self.out, screen };
        stage.say("The machine: rig evc-truth, packed as an FMU");
        stage.pack("evc-truth", "machine.fmu")?;
        stage.say("Measure it: decaying triangles, then a chirp, twice");
        excitation()?.write(&stage.file("excitation.csv"), UnitPlace::Sidecar)?;
        stage.drive()?;
        stage.say("Identify a plant from the measured log");
        let identified = stage.identify()?;
        stage.say("Invert it: feedforward and PID; and the same PID alone");
        stage.invert(&["-o", "controller.toml"])?;
        stage.invert(&["--feedback-only", "--name", "pid_alone", "-o", "pid.toml"])?;
        stage.say("Pack");
        for (blueprint, fmu) in [
            ("plant.toml", "plant.fmu"),
            ("controller.toml", "controller.fmu"),
            ("pid.toml", "pid.fmu"),
        ] {
            stage.pack(&stage.file(blueprint).to_string_lossy(), fmu)?;
        }
        stage.say("Close the loop on the machine: an ellipse at 100 Hz, Y 1 to 5 um, Z 1 to 8 um");
        reference()?.write(&stage.file("reference.csv"), UnitPlace::Sidecar)?;
        let pid = stage.close("pid.fmu", "run-pid.csv")?;
        let both = stage.close("controller.fmu", "run.csv")?;
        let mut result = Demonstration {
            page: stage.file("index.html"),
            axes: figures(&identified, &pid, &both)?,
            do_step_ns: do_step_time(&stage)?,
            seconds: 0.0,
        };
        result.seconds = begin.elapsed().as_secs_f64();
        let report = page::page(&result, &identified, &pid, &both, &stage.file("measured.csv"))?;
        report.write_html(&result.page)?;
        let pages = self.page.write(|| Ok(report))?;
        self.page.with_own(pages, &result.page).show(screen, &result)
    }
}

/// Where the demo plays.
struct Stage<'a> {
    folder: &'a Path,
    screen: &'a Screen,
}

impl Stage<'_> {
    fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn say(&self, line: &str) {
        self.screen.say(&format!("\n{line}"));
    }

    /// Says and parses a command line. Files of the demo are named as they lie in its folder.
    fn parse(&self, arguments: &[&str]) -> anyhow::Result<Command> {
        let here = |a: &&str| -> String {
            let is_file = [".fmu", ".toml", ".csv", ".html"].iter().any(|e| a.ends_with(e));
            match is_file && !Path::new(a).starts_with(self.folder) {
                true => self.file(a).to_string_lossy().into_owned(),
                false => (*a).to_owned(),
            }
        };
        let all: Vec<String> = arguments.iter().map(here).collect();
        self.screen.say(&format!("$ piezoloop {}", all.join(" ")));
        let words = std::iter::once("piezoloop".to_owned()).chain(all);
        Ok(crate::Cli::try_parse_from(words)?.command)
    }

    fn show(&self, answer: &impl Answer) -> anyhow::Result<()> {
        if !self.screen.json {
            self.screen.show(answer)?;
        }
        Ok(())
    }

    fn pack(&self, blueprint: &str, fmu: &str) -> anyhow::Result<()> {
        match self.parse(&["pack", blueprint, "-o", fmu])? {
            Command::Pack(command) => self.show(&command.execute()?),
            _ => bail!("not a pack command"),
        }
    }

    fn drive(&self) -> anyhow::Result<()> {
        let arguments =
            ["simulate", "machine.fmu", "--log", "excitation.csv", "-o", "measured.csv"];
        match self.parse(&arguments)? {
            Command::Simulate(command) => self.show(&command.execute(self.screen)?),
            _ => bail!("not a simulate command"),
        }
    }

    fn identify(&self) -> anyhow::Result<Identified> {
        let arguments = [
            "identify",
            "--log",
            "measured.csv",
            "--model",
            "prandtl-ishlinskii",
            "--input",
            "u_y",
            "--output",
            "y",
            "--input",
            "u_z",
            "--output",
            "z",
            "--map",
            "u_y=command[1]",
            "--map",
            "y=position[1]",
            "--map",
            "u_z=command[2]",
            "--map",
            "z=position[2]",
            "-o",
            "plant.toml",
        ];
        match self.parse(&arguments)? {
            Command::Identify(command) => {
                let result = command.execute(self.screen)?;
                self.show(&result)?;
                Ok(result)
            }
            _ => bail!("not an identify command"),
        }
    }

    fn invert(&self, more: &[&str]) -> anyhow::Result<()> {
        let mut arguments = vec!["invert", "plant.toml", "--period", PERIOD];
        arguments.extend(more);
        match self.parse(&arguments)? {
            Command::Invert(command) => self.show(&command.execute(self.screen)?),
            _ => bail!("not an invert command"),
        }
    }

    fn close(&self, controller: &str, run: &str) -> anyhow::Result<Simulated> {
        let arguments = [
            "simulate",
            "--loop",
            "machine.fmu",
            controller,
            "--reference",
            "reference.csv",
            "--drop",
            "0.1",
            "-o",
            run,
        ];
        match self.parse(&arguments)? {
            Command::Simulate(command) => {
                let result = command.execute(self.screen)?;
                self.show(&result)?;
                Ok(result)
            }
            _ => bail!("not a simulate command"),
        }
    }
}

/// Sample time of the measurement in s.
const SAMPLE_TIME: f64 = 2e-4;

/// Commands of the measurement at 5 kHz: decaying triangles, a chirp over the resonances, twice with
/// other amplitudes, so that what is held out differs from what is fitted.
fn excitation() -> anyhow::Result<Log> {
    let mut command = Vec::new();
    for (high, top) in [(115.0, 6.0), (108.0, 5.0)] {
        let triangle = [
            ("low", 0.0),
            ("high", high),
            ("frequency", 4.0),
            ("cycles", 5.0),
            ("sample_time", SAMPLE_TIME),
        ];
        join(&mut command, one("triangle-decaying", &triangle)?);
        let middle = command.last().copied().unwrap_or(0.0);
        let chirp = [
            ("low", middle),
            ("high", middle + top),
            ("start_frequency", 5.0),
            ("end_frequency", 700.0),
            ("sample_time", SAMPLE_TIME),
            ("duration", 1.0),
        ];
        join(&mut command, one("chirp-linear", &chirp)?);
    }
    let time = (0..command.len()).map(|k| k as f64 * SAMPLE_TIME).collect();
    let mut log = Log::new("excitation.csv", time)?;
    log.add_column("u_y", Some("V"), command.clone())?;
    log.add_column("u_z", Some("V"), command)?;
    Ok(log)
}

/// Appends a signal, with a ramp of 0.1 s to where it starts.
fn join(command: &mut Vec<f64>, signal: Vec<f64>) {
    if let (Some(&from), Some(&to)) = (command.last(), signal.first()) {
        let rows = (0.1 / SAMPLE_TIME) as usize;
        command.extend((1..rows).map(|k| from + (to - from) * k as f64 / rows as f64));
    }
    command.extend(signal);
}

fn one(name: &str, settings: &[(&str, f64)]) -> anyhow::Result<Vec<f64>> {
    let signal = signals::lookup(name)?.generate(settings)?;
    Ok(signal.channels.into_iter().next().map(|c| c.values).unwrap_or_default())
}

/// The ellipse.
fn reference() -> anyhow::Result<Log> {
    let Signal { period, channels, .. } =
        signals::lookup("p4-ellipse")?.generate(&[("duration", 0.2)])?;
    let rows = channels.first().map_or(0, |c| c.values.len());
    let mut log = Log::new("reference.csv", (0..rows).map(|k| k as f64 * period).collect())?;
    for (channel, number) in channels.into_iter().zip(1..) {
        log.add_column(&format!("reference[{number}]"), Some(&channel.unit), channel.values)?;
    }
    Ok(log)
}

fn figures(
    identified: &Identified,
    pid: &Simulated,
    both: &Simulated,
) -> anyhow::Result<Vec<AxisFigures>> {
    let mut all = Vec::new();
    for (number, axis) in (1..).zip(&identified.axes) {
        let record = axis.identification.records.first().context("no record was identified")?;
        let name = format!("position[{number}]");
        let command = both.signals.values(&format!("command[{number}]")).unwrap_or_default();
        let judged = both.signals.time().partition_point(|t| *t < JUDGED_FROM);
        let command = command.get(judged..).unwrap_or_default();
        let low = command.iter().copied().fold(f64::INFINITY, f64::min);
        let high = command.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        all.push(AxisFigures {
            axis: axis.name.clone(),
            identified_percent: 100.0 * record.held_out.nrmse,
            line_percent: 100.0 * record.baseline_held_out.nrmse,
            pid_percent: relative(pid, &name)?,
            inverse_and_pid_percent: relative(both, &name)?,
            command_range: (low, high),
            saturated: low <= COMMAND.0 || high >= COMMAND.1,
        });
    }
    Ok(all)
}

/// Largest error over peak-to-peak of the reference, in %; no offset is taken out.
fn relative(run: &Simulated, position: &str) -> anyhow::Result<f64> {
    let fit: &OutputFit = run
        .fits
        .iter()
        .find(|fit| fit.output == position)
        .with_context(|| format!("{position} was not recorded"))?;
    Ok(100.0 * fit.raw_max_error / fit.range)
}

/// Median time of setting both commands and one `fmi2DoStep` of rig evc (two axes, ten plays and one
/// mode each) over one internal step, in ns, through the C interface.
fn do_step_time(stage: &Stage<'_>) -> anyhow::Result<f64> {
    stage.pack("evc", "evc.fmu")?;
    let fmu = Fmu::open(stage.file("evc.fmu"))?;
    let mut slave = fmu.instantiate("timed", &InstanceOptions::default())?;
    let step = fmu
        .description()
        .default_experiment
        .as_ref()
        .and_then(|e| e.step_size)
        .context("the FMU has a default step")?;
    let mut commands = Selection::default();
    for name in ["command[1]", "command[2]"] {
        let variable = fmu.description().variable(name).context("rig evc has two axes")?;
        commands.add("timed", variable)?;
    }
    slave.setup(&Experiment { start: 0.0, stop: None, tolerance: None })?;
    slave.enter_initialization()?;
    slave.exit_initialization()?;
    let mut medians = Vec::new();
    let mut n = 0u64;
    for _ in 0..50 {
        let begin = Instant::now();
        for _ in 0..2000 {
            let t = n as f64 * step;
            slave.set(&commands, &[(n % 120) as f64, (n % 100) as f64])?;
            slave.step(t, (n + 1) as f64 * step - t)?;
            n += 1;
        }
        medians.push(begin.elapsed().as_nanos() as f64 / 2000.0);
    }
    medians.sort_by(f64::total_cmp);
    Ok(medians[medians.len() / 2])
}

impl Demonstration {
    /// Whether every figure is as it must be.
    pub(crate) fn reached(&self) -> bool {
        self.axes.iter().all(|axis| {
            axis.inverse_and_pid_percent < PAPER_PERCENT
                && axis.pid_percent >= LEAST_GAIN * axis.inverse_and_pid_percent
                && !axis.saturated
        })
    }
}

impl Answer for Demonstration {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out)?;
        for axis in &self.axes {
            writeln!(
                out,
                "axis {}: error of the identified plant on held-out rows {:.2} % of range (a straight line {:.2} %)",
                axis.axis, axis.identified_percent, axis.line_percent
            )?;
            writeln!(
                out,
                "        closed loop at 100 Hz, max|e| / peak-to-peak: PID alone {:.2} %, inverse + PID {:.2} % ({:.1} times less; paper {PAPER_PERCENT} %), command {:.1} to {:.1} V",
                axis.pid_percent,
                axis.inverse_and_pid_percent,
                axis.pid_percent / axis.inverse_and_pid_percent,
                axis.command_range.0,
                axis.command_range.1
            )?;
        }
        writeln!(out, "one doStep of rig evc through the C interface: {:.0} ns", self.do_step_ns)?;
        writeln!(out, "{}: the page, after {:.1} s", self.page.display(), self.seconds)
    }

    fn exit_code(&self) -> u8 {
        u8::from(!self.reached())
    }
}

//! `piezoloop check`: every problem of an FMU, with the section of the standard.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use clap::Args;
use cosim::Worker;
use modeldescription::Package;
use modeldescription::problem::{Problem, Severity, Topic};
use serde::Serialize;

use crate::answer::{Answer, Screen};
use crate::reference::{self, Replay};

/// Checks FMUs of any vendor against the letter of FMI 2.0 or 3.0
///
/// Prints every problem with file, line, value, rule, way out and the section of the standard. The
/// exit code is 1 where there are errors. Reference results that travel with an FMU are replayed, in a
/// process of its own; no other code of an FMU is run.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  piezoloop check plant.fmu")]
pub(crate) struct Check {
    /// FMUs: .fmu files or unpacked folders
    #[arg(required = true, value_name = "FMU")]
    fmus: Vec<PathBuf>,
    /// Let warnings count as errors
    #[arg(long)]
    strict: bool,
    /// Run no code of the FMUs: leave reference results alone
    #[arg(long)]
    no_replay: bool,
}

/// So long one call of a replayed FMU may take.
const PATIENCE: Duration = Duration::from_secs(60);

#[derive(Serialize)]
struct Checked {
    fmus: Vec<Fmu>,
    #[serde(skip)]
    strict: bool,
}

#[derive(Serialize)]
struct Fmu {
    path: PathBuf,
    model: Option<String>,
    fmi_version: Option<&'static str>,
    platforms: Vec<String>,
    errors: usize,
    warnings: usize,
    problems: Vec<Problem>,
    /// What the repetition of its reference results gave, where it has some.
    replay: Option<Replay>,
}

impl Check {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let fmus = self.fmus.iter().map(|path| check(path, !self.no_replay));
        let fmus = fmus.collect::<anyhow::Result<_>>()?;
        screen.show(&Checked { fmus, strict: self.strict })
    }
}

fn check(path: &Path, runs: bool) -> anyhow::Result<Fmu> {
    let mut problems = modeldescription::check(path)?;
    let package = Package::open(path).ok();
    let mut replay = None;
    // Where there is no library for this machine, there is nothing to repeat.
    let can_run = |p: &&Package| runs && reference::has_one(p.folder()) && p.binary().is_ok();
    if let Some(package) = package.as_ref().filter(can_run) {
        match repeat(package) {
            Ok(done) => {
                problems.extend(differences(package, &done));
                replay = Some(done);
            }
            Err(error) => problems.push(not_repeated(package, &error)),
        }
    }
    let description = package.as_ref().map(Package::description);
    let count = |severity| problems.iter().filter(|p| p.severity == severity).count();
    Ok(Fmu {
        path: path.to_owned(),
        model: description.map(|d| d.model_name.clone()),
        fmi_version: description.map(|d| d.fmi_version.text()),
        platforms: package.as_ref().map(Package::platforms).unwrap_or_default(),
        errors: count(Severity::Error),
        warnings: count(Severity::Warning),
        problems,
        replay,
    })
}

/// Repeats the reference results in a process of its own.
fn repeat(package: &Package) -> anyhow::Result<Replay> {
    let worker = Worker::this_program(super::WORKER, PATIENCE)
        .context("this program does not find itself to start the FMU in its own process")?;
    reference::replay(&cosim::Fmu::open_isolated(package.folder(), &worker)?)
}

fn problem(package: &Package, file: &str, found: String) -> Problem {
    let entry = format!("extra/{}/{file}", reference::FOLDER);
    Problem::in_entry(package.description().fmi_version, Topic::Extra, &entry, found)
}

fn differences(package: &Package, replay: &Replay) -> Vec<Problem> {
    let far = replay.outputs.iter().filter(|output| !output.is_within);
    let said = far.map(|output| {
        let found = format!(
            "output \"{}\" differs by {:.3e} of its peak-to-peak value, at {} s",
            output.name, output.difference, output.at
        );
        problem(package, "output.csv", found)
            .rule(format!("reference results are repeated within {}", replay.tolerance))
            .way_out("pack the FMU again, or find out which of blueprint, tables and library was exchanged")
    });
    said.collect()
}

fn not_repeated(package: &Package, error: &anyhow::Error) -> Problem {
    problem(
        package,
        "reference.toml",
        format!("the reference results cannot be repeated: {error:#}"),
    )
    .rule("reference results that travel with an FMU can be repeated with it")
    .way_out("pack the FMU again, or check with --no-replay")
}

impl Answer for Checked {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for fmu in &self.fmus {
            for problem in &fmu.problems {
                writeln!(out, "{}: {problem}", fmu.path.display())?;
            }
            let what = match (&fmu.model, fmu.fmi_version) {
                (Some(model), Some(version)) => {
                    format!("\"{model}\", FMI {version}, for {}: ", fmu.platforms.join(", "))
                }
                _ => String::new(),
            };
            let verdict = match (fmu.errors, fmu.warnings) {
                (0, 0) => "no problem".to_owned(),
                (errors, warnings) => {
                    let several = |count: usize| if count == 1 { "" } else { "s" };
                    let (e, w) = (several(errors), several(warnings));
                    format!("{errors} error{e}, {warnings} warning{w}")
                }
            };
            let replayed = fmu.replay.as_ref().map_or(String::new(), |replay| {
                let worst = replay.outputs.iter().map(|o| o.difference).fold(0.0, f64::max);
                format!("; reference results repeated, largest difference {worst:.1e} of the range")
            });
            writeln!(out, "{}: {what}{verdict}{replayed}", fmu.path.display())?;
        }
        Ok(())
    }

    fn exit_code(&self) -> u8 {
        let bad = |f: &Fmu| f.errors > 0 || (self.strict && f.warnings > 0);
        u8::from(self.fmus.iter().any(bad))
    }
}

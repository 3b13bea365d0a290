//! `piezoloop check`: every problem of an FMU, with the section of the standard.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use clap::Args;
use cli::{Answer, Screen};
use cosim::Worker;
use modeldescription::Package;
use modeldescription::problem::{Problem, Severity, Topic};
use serde::Serialize;

use crate::reference::{self, Replay};

/// Checks FMUs of any vendor strictly against FMI 2.0 or 3.0
///
/// Prints every problem with file, line, value, rule, how to fix it, and the section of the standard. The exit code
/// is 1 if there are errors, and 2 if something could not be checked. The code of an FMU runs only with --replay.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  piezoloop check plant.fmu")]
pub(crate) struct Check {
    /// FMUs: .fmu files or unpacked folders
    #[arg(required = true, value_name = "FMU")]
    fmus: Vec<PathBuf>,
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
    /// Repeat the reference run that an FMU contains: runs its code in a separate process
    #[arg(long)]
    replay: bool,
    /// Time limit of the reference run of one FMU in s
    #[arg(
        long,
        value_name = "S",
        default_value_t = 60.0,
        requires = "replay",
        value_parser = crate::ranges::above(0.0, crate::ranges::LONGEST)
    )]
    timeout: f64,
}

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
    /// Whether it has C sources.
    sources: bool,
    errors: usize,
    warnings: usize,
    problems: Vec<Problem>,
    /// Why it could not be checked, or not as a whole.
    unchecked: Option<String>,
    /// Whether it has reference results.
    has_reference: bool,
    /// Whether it has a library for this machine.
    runs_here: bool,
    /// What the repetition of its reference results gave, where it was asked for.
    replay: Option<Replay>,
}

impl Check {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        if !(self.timeout > 0.0 && self.timeout < 1e9) {
            bail!("--timeout {}: give a time in s, greater than 0", self.timeout);
        }
        let patience = self.replay.then(|| Duration::from_secs_f64(self.timeout));
        // One that cannot be read is no reason to be silent about the others.
        let fmus: Vec<Fmu> = self.fmus.iter().map(|path| check(path, patience)).collect();
        if let [Fmu { path, unchecked: Some(why), problems, .. }] = &fmus[..]
            && problems.is_empty()
        {
            let name = path.display().to_string();
            if why.contains(&name) { bail!("{why}") } else { bail!("{name}: {why}") }
        }
        screen.show(&Checked { fmus, strict: self.strict })
    }
}

fn check(path: &Path, patience: Option<Duration>) -> Fmu {
    let (mut problems, mut unchecked) = match modeldescription::check(path) {
        Ok(problems) => (problems, None),
        Err(error) => (Vec::new(), Some(error.to_string())),
    };
    let has_error = problems.iter().any(|problem| problem.severity == Severity::Error);
    let package = match Package::open(path) {
        Ok(package) => Some(package),
        Err(error) => {
            // What is wrong with the FMU was said; anything else is said here.
            if !has_error && unchecked.is_none() {
                unchecked = Some(format!("it cannot be opened: {error}"));
            }
            None
        }
    };
    let has_reference = package.as_ref().is_some_and(|p| reference::has_one(p.folder()));
    let mut replay = None;
    // Where there is no library for this machine, there is nothing to repeat.
    let runs_here = package.as_ref().is_some_and(|package| package.binary().is_ok());
    let can_run = |_: &&Package| has_reference && runs_here;
    if let (Some(package), Some(patience)) = (package.as_ref().filter(can_run), patience) {
        match repeat(package, patience) {
            Ok(done) => {
                problems.extend(differences(package, &done));
                replay = Some(done);
            }
            Err(error) if is_of_the_system(&error) => {
                unchecked = Some(format!("its reference results are not repeated: {error:#}"));
            }
            Err(error) => problems.push(not_repeated(package, &error)),
        }
    }
    let description = package.as_ref().map(Package::description);
    let count = |severity| problems.iter().filter(|p| p.severity == severity).count();
    Fmu {
        path: path.to_owned(),
        model: description.map(|d| d.model_name.clone()),
        fmi_version: description.map(|d| d.fmi_version.text()),
        platforms: package.as_ref().map(Package::platforms).unwrap_or_default(),
        sources: package.as_ref().is_some_and(Package::has_sources),
        errors: count(Severity::Error),
        warnings: count(Severity::Warning),
        problems,
        unchecked,
        has_reference,
        runs_here,
        replay,
    }
}

/// Repeats the reference results in a process of its own, which ends with this one; all of it within
/// this time.
fn repeat(package: &Package, patience: Duration) -> anyhow::Result<Replay> {
    let worker = Worker::this_program(super::WORKER, patience)
        .context("this program does not find itself to start the FMU in its own process")?;
    let folder = package.folder().to_path_buf();
    let (send, receive) = std::sync::mpsc::channel();
    let spawned = std::thread::Builder::new().spawn(move || {
        let open = cosim::Fmu::open_isolated(folder, &worker);
        // Nobody waits any more where this comes too late.
        let _ = send.send(open.map_err(Into::into).and_then(|fmu| reference::replay(&fmu)));
    });
    spawned.map_err(numerics::threads::refused)?;
    receive.recv_timeout(patience).unwrap_or_else(|_| {
        bail!("it takes longer than {} s; --timeout S allows it more", patience.as_secs_f64())
    })
}

/// Whether the FMU has no part in an error: the system gives no thread or no process.
fn is_of_the_system(error: &anyhow::Error) -> bool {
    let is_limit = |cause: &std::io::Error| cause.kind() == io::ErrorKind::WouldBlock;
    error.chain().any(|cause| {
        cause.downcast_ref().is_some_and(is_limit)
            || matches!(cause.downcast_ref(), Some(cosim::Error::NoProcess { .. }))
    })
}

fn problem(package: &Package, file: &str, found: String) -> Problem {
    let entry = format!("extra/{}/{file}", reference::FOLDER);
    Problem::in_entry(package.description().fmi_version, Topic::Extra, &entry, found)
}

fn differences(package: &Package, replay: &Replay) -> Vec<Problem> {
    let far = replay.outputs.iter().filter(|output| !output.is_within);
    let message = far.map(|output| {
        let found = format!(
            "output \"{}\" differs by {:.3e} of its peak-to-peak value, at {} s",
            output.name, output.difference, output.at
        );
        problem(package, "output.csv", found)
            .rule(format!("reference results are repeated within {}", replay.tolerance))
            .way_out("pack the FMU again, or find out which of blueprint, tables and library was exchanged")
    });
    message.collect()
}

fn not_repeated(package: &Package, error: &anyhow::Error) -> Problem {
    problem(
        package,
        "reference.toml",
        format!("the reference results cannot be repeated: {error:#}"),
    )
    .rule("reference results that travel with an FMU can be repeated with it")
    .way_out("pack the FMU again, or check without --replay")
}

impl Fmu {
    /// What the FMU runs on, for people.
    fn targets(&self) -> String {
        let sources = self.sources.then(|| "compilers of its C sources".to_owned());
        let all: Vec<_> = self.platforms.iter().cloned().chain(sources).collect();
        all.join(", ")
    }
}

impl Answer for Checked {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for fmu in &self.fmus {
            for problem in &fmu.problems {
                // A problem of the file as a whole names it already.
                let (file, text) = (fmu.path.display().to_string(), problem.to_string());
                let names = text.strip_prefix(&file).is_some_and(|rest| rest.starts_with(':'));
                match names {
                    true => writeln!(out, "{text}")?,
                    false => writeln!(out, "{file}: {text}")?,
                }
            }
            let what = match (&fmu.model, fmu.fmi_version) {
                (Some(model), Some(version)) => {
                    format!("\"{model}\", FMI {version}, for {}: ", fmu.targets())
                }
                _ => String::new(),
            };
            let found =
                [data::counted(fmu.errors, "error"), data::counted(fmu.warnings, "warning")];
            let found = found.join(", ");
            let verdict = match (fmu.errors + fmu.warnings, &fmu.unchecked) {
                (0, Some(why)) => format!("not checked: {why}"),
                (0, None) => "no problem".to_owned(),
                (_, None) => found,
                (_, Some(why)) => {
                    format!("{found}, not all was checked: {why}")
                }
            };
            if fmu.has_reference && fmu.replay.is_none() && fmu.errors == 0 {
                let path = fmu.path.display();
                let how = match (fmu.platforms.is_empty() && fmu.sources, fmu.runs_here) {
                    (true, _) => {
                        "to be repeated with --replay where its sources have been compiled"
                    }
                    (_, true) => "--replay runs its code and repeats them",
                    (_, false) => "no library for this machine is there to repeat them with",
                };
                writeln!(out, "{path}: has reference results; {how}")?;
            }
            let replayed = fmu.replay.as_ref().map_or(String::new(), |replay| {
                let worst = replay.outputs.iter().map(|o| o.difference).fold(0.0, f64::max);
                format!("; reference results repeated, largest difference {worst:.1e} of the range")
            });
            writeln!(out, "{}: {what}{verdict}{replayed}", fmu.path.display())?;
        }
        Ok(())
    }

    fn exit_code(&self) -> u8 {
        if self.fmus.iter().any(|fmu| fmu.unchecked.is_some()) {
            return 2;
        }
        let bad = |f: &Fmu| f.errors > 0 || (self.strict && f.warnings > 0);
        u8::from(self.fmus.iter().any(bad))
    }
}

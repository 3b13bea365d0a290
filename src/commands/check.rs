//! `piezoloop check`: every problem of an FMU, with the section of the standard.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use modeldescription::Package;
use modeldescription::problem::{Problem, Severity};
use serde::Serialize;

use crate::answer::{Answer, Screen};

/// Checks FMUs of any vendor against the letter of FMI 2.0 or 3.0
///
/// Prints every problem with file, line, value, rule, way out and the section of the standard. The
/// exit code is 1 where there are errors. No code of the FMU is run.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  piezoloop check plant.fmu")]
pub(crate) struct Check {
    /// FMUs: .fmu files or unpacked folders
    #[arg(required = true, value_name = "FMU")]
    fmus: Vec<PathBuf>,
    /// Let warnings count as errors
    #[arg(long)]
    strict: bool,
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
    errors: usize,
    warnings: usize,
    problems: Vec<Problem>,
}

impl Check {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let fmus = self.fmus.iter().map(check).collect::<anyhow::Result<_>>()?;
        screen.show(&Checked { fmus, strict: self.strict })
    }
}

fn check(path: &PathBuf) -> anyhow::Result<Fmu> {
    let problems = modeldescription::check(path)?;
    let package = Package::open(path).ok();
    let description = package.as_ref().map(Package::description);
    let count = |severity| problems.iter().filter(|p| p.severity == severity).count();
    Ok(Fmu {
        path: path.clone(),
        model: description.map(|d| d.model_name.clone()),
        fmi_version: description.map(|d| d.fmi_version.text()),
        platforms: package.as_ref().map(Package::platforms).unwrap_or_default(),
        errors: count(Severity::Error),
        warnings: count(Severity::Warning),
        problems,
    })
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
            writeln!(out, "{}: {what}{verdict}", fmu.path.display())?;
        }
        Ok(())
    }

    fn exit_code(&self) -> u8 {
        let bad = |f: &Fmu| f.errors > 0 || (self.strict && f.warnings > 0);
        u8::from(self.fmus.iter().any(bad))
    }
}

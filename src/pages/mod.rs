//! Results as pages: what each command shows, where it goes, and who opens it.

mod bench;
mod calibrate;
mod estimate;
mod frequency_response;
mod identify;
mod invert;
mod open;
mod simulate;
mod system;
mod tune;

use std::path::{Path, PathBuf};

use ::identify::frequency::Complex;
use anyhow::Context;
use clap::Args;
use diagnose::figures::unwrapped;
use report::{InputFile, Provenance, Report};

pub(crate) use bench::{Rows, campaign, run as bench_run};
pub(crate) use calibrate::calibration;
pub(crate) use estimate::estimation;
pub(crate) use frequency_response::frequency_response;
pub(crate) use identify::{identification, picture, sections};
pub(crate) use invert::inversion;
pub(crate) use simulate::simulation;
pub(crate) use system::system;
pub(crate) use tune::tuning;

use crate::answer::{ErasedAnswer, Screen};
use crate::{inputs, interrupt};

/// Where a result goes as a page.
#[derive(Args, Debug, Clone, Default)]
pub(crate) struct PageOptions {
    /// Write the result as one self-contained HTML page; FILE.json: the content of the page as JSON (may be given
    /// several times)
    #[arg(long = "report", value_name = "FILE")]
    reports: Vec<PathBuf>,
    /// Open the page in the browser
    #[arg(long)]
    plot: bool,
}

/// Pages that were written.
pub(crate) struct Pages {
    /// The files that were asked for.
    pub(crate) files: Vec<PathBuf>,
    shown: Option<PathBuf>,
}

impl PageOptions {
    /// Whether there is anything to write.
    pub(crate) fn is_asked(&self) -> bool {
        self.plot || !self.reports.is_empty()
    }

    /// Whether the pages can be written, told before the work.
    pub(crate) fn can_write(&self) -> anyhow::Result<()> {
        self.reports.iter().try_for_each(|file| inputs::can_write_as(file, inputs::REPORT))
    }

    /// Writes what was asked for; `page` is made only then.
    pub(crate) fn write(
        &self,
        page: impl FnOnce() -> anyhow::Result<Report>,
    ) -> anyhow::Result<Pages> {
        if !self.is_asked() {
            return Ok(Pages { files: Vec::new(), shown: None });
        }
        let page = page()?;
        for file in &self.reports {
            if is_json(file) {
                page.write_json(file)?;
            } else {
                page.write_html(file)?;
            }
        }
        let own = self.reports.iter().find(|file| !is_json(file)).cloned();
        let shown = match (self.plot, own) {
            (false, _) => None,
            (true, Some(file)) => Some(file),
            (true, None) => {
                let file = temporary(&page.command)?;
                page.write_html(&file)?;
                Some(file)
            }
        };
        Ok(Pages { files: self.reports.clone(), shown })
    }

    /// Shows a page that the command writes anyway.
    pub(crate) fn with_own(&self, mut pages: Pages, file: &Path) -> Pages {
        pages.shown = self.plot.then(|| file.to_owned());
        pages
    }

    /// Writes the pages, shows the answer, and opens the page where that was asked for.
    pub(crate) fn finish(
        &self,
        screen: &Screen,
        answer: &dyn ErasedAnswer,
        page: impl FnOnce() -> anyhow::Result<Report>,
    ) -> anyhow::Result<u8> {
        let pages = self.write(page)?;
        pages.show(screen, answer)
    }
}

impl Pages {
    /// Shows the answer, then opens the page where that was asked for.
    pub(crate) fn show(&self, screen: &Screen, answer: &dyn ErasedAnswer) -> anyhow::Result<u8> {
        let code = screen.show(answer)?;
        if let Some(file) = &self.shown {
            screen.say(&format!("page: {}", file.display()));
            open::open(file)?;
        }
        Ok(code)
    }
}

fn is_json(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json"))
}

/// A new file for a page that nobody gave a name; it stays.
fn temporary(command: &str) -> anyhow::Result<PathBuf> {
    let prefix = format!("piezoloop-{command}-");
    let file = tempfile::Builder::new()
        .prefix(&prefix)
        .suffix(".html")
        .tempfile_in(interrupt::lasting_folder());
    let kept = file.context("no temporary file can be made for the page; give --report FILE")?;
    Ok(kept.into_temp_path().keep()?)
}

/// Provenance of this call: tool, version, command line, files.
pub(crate) fn provenance(files: &[(&str, &Path)]) -> anyhow::Result<Provenance> {
    let mut all = Provenance::new("piezoloop", crate::VERSION).command_line(std::env::args());
    for (role, path) in files {
        all = all.file(InputFile::read(*role, path)?);
    }
    Ok(all)
}

/// Magnitudes, and phases without jumps.
fn polar(values: &[Complex]) -> (Vec<f64>, Vec<f64>) {
    let phase = unwrapped(values.iter().map(|z| z.arg()).collect());
    (values.iter().map(|z| z.norm()).collect(), phase)
}

/// |1/(1 + L)| of an open loop L.
fn sensitivities(open: &[Complex]) -> Vec<f64> {
    open.iter().map(|l| 1.0 / (Complex::new(1.0, 0.0) + l).norm()).collect()
}

/// Root mean square of the finite values.
fn rms(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|x| x.is_finite());
    let (count, squares): (f64, f64) = finite.fold((0.0, 0.0), |(n, s), x| (n + 1.0, s + x * x));
    if count > 0.0 { (squares / count).sqrt() } else { f64::NAN }
}

/// Greatest absolute finite value.
fn greatest(values: &[f64]) -> f64 {
    values.iter().filter(|x| x.is_finite()).fold(0.0, |most, x| most.max(x.abs()))
}

/// Differences, value by value.
fn differences(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

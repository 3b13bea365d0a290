//! A result as a page: the options that say where it goes, and who opens it.

mod open;

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use report::Report;

use crate::{ErasedAnswer, Screen, interrupt, output};

/// Where a result goes as a page.
#[derive(Args, Debug, Clone, Default)]
pub struct PageOptions {
    /// Write the result as one self-contained HTML page; FILE.json: the content of the page as JSON (may be given
    /// several times)
    #[arg(long = "report", value_name = "FILE")]
    reports: Vec<PathBuf>,
    /// Open the page in the browser
    #[arg(long)]
    plot: bool,
}

/// Pages that were written.
pub struct Pages {
    /// The files that were asked for.
    pub files: Vec<PathBuf>,
    shown: Option<PathBuf>,
}

impl PageOptions {
    /// Whether there is anything to write.
    pub fn is_asked(&self) -> bool {
        self.plot || !self.reports.is_empty()
    }

    /// Whether the pages can be written, told before the work.
    pub fn can_write(&self) -> anyhow::Result<()> {
        self.reports.iter().try_for_each(|file| output::can_write_as(file, output::REPORT))
    }

    /// Writes what was asked for; `page` is made only then.
    pub fn write(&self, page: impl FnOnce() -> anyhow::Result<Report>) -> anyhow::Result<Pages> {
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
    pub fn with_own(&self, mut pages: Pages, file: &Path) -> Pages {
        pages.shown = self.plot.then(|| file.to_owned());
        pages
    }

    /// Writes the pages, shows the answer, and opens the page where that was asked for.
    pub fn finish(
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
    pub fn show(&self, screen: &Screen, answer: &dyn ErasedAnswer) -> anyhow::Result<u8> {
        let code = screen.show(answer)?;
        if let Some(file) = &self.shown {
            screen.say(&format!("page: {}", file.display()));
            open::open(file)?;
        }
        Ok(code)
    }
}

fn is_json(file: &Path) -> bool {
    output::ends_in(file, "json")
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

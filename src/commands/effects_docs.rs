//! `piezoloop effects-docs`: writes docs/effects.md and its figures (hidden: for who builds the tool).

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use cli::{Answer, Screen};
use serde::Serialize;

use crate::effects_docs;

/// Writes the pages about effects and components
#[derive(Args, Debug)]
pub(crate) struct EffectsDocs {
    /// The folder of the documentation
    folder: PathBuf,
}

#[derive(Serialize)]
struct Pages {
    folder: PathBuf,
    files: usize,
}

impl EffectsDocs {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let pages = effects_docs::pages()?;
        for (file, text) in &pages {
            let path = self.folder.join(file);
            let parent = path.parent().context("a page has a folder")?;
            std::fs::create_dir_all(parent)
                .with_context(|| format!("{} cannot be made", parent.display()))?;
            data::AtomicFile::write_all_of(&path, text.as_bytes())
                .with_context(|| format!("{} cannot be written", path.display()))?;
        }
        screen.show(&Pages { folder: self.folder, files: pages.len() })
    }
}

impl Answer for Pages {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{}: {} files written", self.folder.display(), self.files)
    }
}

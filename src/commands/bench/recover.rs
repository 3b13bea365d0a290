//! `piezoloop bench recover`: the record of a run that was killed.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::bail;
use bench::record::{Converted, Format, JournalReader, convert};
use clap::Args;
use cli::{Answer, Screen};
use serde::Serialize;

/// Recovers a log from the journal of a killed run
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  piezoloop bench recover run.parquet.journal -o run.parquet")]
pub(crate) struct Recover {
    /// The journal: the record's name with .journal
    journal: PathBuf,
    /// The log to write: .parquet, .csv or .mf4 [default: the journal's name without .journal]
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
#[serde(transparent)]
struct Recovered(Converted);

impl Recover {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        if JournalReader::open(&self.journal)?.block()?.is_none() {
            let journal = self.journal.display();
            bail!("{journal}: has no row; the run was killed before its first: delete it");
        }
        let (out, is_named) = match self.out {
            Some(out) => (out, true),
            None => (self.journal.with_extension(""), false),
        };
        let format = Format::of(&out).map_err(anyhow::Error::msg)?;
        cli::can_write(&out)?;
        if !is_named && out.symlink_metadata().is_ok() {
            bail!(
                "{}: is there; name the log with -o FILE, also where it is to take the place of this one",
                out.display()
            );
        }
        let more = serde_json::json!({ "recovered": true });
        let more = more.as_object().cloned().unwrap_or_default();
        screen.show(&Recovered(convert(&self.journal, &out, format, &more)?))
    }
}

impl Answer for Recovered {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let Converted { file, rows, cut_off_bytes } = &self.0;
        writeln!(out, "{}: written, {rows} rows", file.display())?;
        if *cut_off_bytes > 0 {
            writeln!(
                out,
                "  {cut_off_bytes} bytes at the end were cut off in the middle of a write"
            )?;
        }
        Ok(())
    }
}

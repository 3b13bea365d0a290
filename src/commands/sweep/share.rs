//! A sweep in parts: merged from shards, bundled for other machines, served to another program.

use std::io::{self, BufRead, Write};
use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::{Args, Subcommand};
use cli::{Answer, Screen};
use serde::Serialize;
use sweep::{Journal, Table, Worker, frame};

use super::job::Job;
use super::materials::Materials;
use super::results::Swept;
use crate::inputs;

/// What is done with parts of a sweep.
#[derive(Subcommand, Debug)]
pub(super) enum Share {
    Merge(Merge),
    Bundle(Bundle),
    #[command(hide = true)]
    Serve(Serve),
}

/// Combines the tables of all shards
///
/// The result has the same bytes as the table of a single process.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  piezoloop sweep merge plan.*-of-8.parquet -o plan.parquet")]
pub(super) struct Merge {
    /// The tables, in any order
    #[arg(required = true)]
    parts: Vec<PathBuf>,
    /// The table to write
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: PathBuf,
}

/// Packs a plan and all its files into one file, for workers on other machines
///
/// Says which runs of the table are still to be done. The Python package uses it for Dask.
#[derive(Args, Debug)]
#[command(
    after_help = "Example:\n  piezoloop sweep bundle plan.toml --table plan.parquet -o plan.bundle"
)]
pub(super) struct Bundle {
    /// The plan
    plan: PathBuf,
    /// Seed, instead of the plan's
    #[arg(long, value_name = "S", value_parser = crate::ranges::seed())]
    seed: Option<u64>,
    /// The table that will be written; runs that it or its journal has are done
    #[arg(long, value_name = "FILE")]
    table: PathBuf,
    /// The file to write
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: PathBuf,
}

/// Runs what another program asks for
///
/// Reads lines `FIRST END` from the standard input and answers each with the number of bytes as text,
/// a line break, and the rows of the runs FIRST to END − 1 as they stand in a journal.
#[derive(Args, Debug)]
pub(super) struct Serve {
    /// The bundle
    bundle: PathBuf,
}

/// What was bundled.
#[derive(Serialize)]
struct Bundled {
    bundle: PathBuf,
    bytes: usize,
    runs: u64,
    /// Runs that are to be done, as pairs: first, and behind the last.
    todo: Vec<(u64, u64)>,
    /// Where rows are added.
    journal: PathBuf,
}

impl Share {
    pub(super) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        match self {
            Share::Merge(merge) => merge.run(screen),
            Share::Bundle(bundle) => bundle.run(screen),
            Share::Serve(serve) => serve.run(),
        }
    }
}

impl Merge {
    fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        cli::can_write_as(&self.out, inputs::TABLE)?;
        let read = self.parts.iter().map(|path| Ok((path.clone(), Table::read(path)?)));
        let table = Table::merge(read.collect::<Result<_, sweep::Error>>()?)?;
        table.write(&self.out)?;
        screen.show(&Swept::of(&table, self.out, Vec::new()))
    }
}

impl Bundle {
    fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        cli::can_write(&self.out)?;
        let materials = Materials::gather(&self.plan, self.seed)?;
        let job = Job::new(&materials, None)?;
        let runs = job.design.runs();
        let journal = super::journal_of(&self.table);
        let todo = match super::finished(&job, &(0..runs), &self.table) {
            Some(_) => Vec::new(),
            None => {
                let (_, kept) = Journal::open(&journal, &job.fingerprint)?;
                let rows = super::known(&job, &(0..runs), kept);
                ranges((0..runs).filter(|run| !rows.contains_key(run)))
            }
        };
        let bytes = materials.to_bytes()?;
        data::AtomicFile::write_all_of(&self.out, &bytes)
            .with_context(|| format!("{} cannot be written", self.out.display()))?;
        screen.show(&Bundled { bundle: self.out, bytes: bytes.len(), runs, todo, journal })
    }
}

impl Serve {
    fn run(self) -> anyhow::Result<u8> {
        files::note_read(&self.bundle);
        let bytes = std::fs::read(&self.bundle)
            .with_context(|| format!("{} cannot be read", self.bundle.display()))?;
        let job = Job::new(&Materials::from_bytes(&bytes)?, None)?;
        let mut worker = job.hire()?;
        // The master reads it: what FMUs print must not stand between.
        cli::keep_standard_output()?;
        let mut out = cli::standard_output();
        // Tells that everything is set up.
        writeln!(out, "{}", job.design.runs())?;
        out.flush()?;
        for line in io::stdin().lock().lines() {
            let line = line?;
            let asked =
                line.split_once(' ').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
            let Some((first, end)) =
                asked.filter(|&(a, b): &(u64, u64)| a <= b && b <= job.design.runs())
            else {
                bail!("\"{line}\": write FIRST END, runs from 0 to {}", job.design.runs());
            };
            let rows: Vec<u8> = (first..end).flat_map(|run| frame(&worker.run(run))).collect();
            writeln!(out, "{}", rows.len())?;
            out.write_all(&rows)?;
            out.flush()?;
        }
        Ok(0)
    }
}

/// Neighbouring numbers as ranges.
fn ranges(runs: impl Iterator<Item = u64>) -> Vec<(u64, u64)> {
    let mut ranges: Vec<(u64, u64)> = Vec::new();
    for run in runs {
        match ranges.last_mut() {
            Some((_, end)) if *end == run => *end += 1,
            _ => ranges.push((run, run + 1)),
        }
    }
    ranges
}

impl Answer for Bundled {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let todo: u64 = self.todo.iter().map(|(first, end)| end - first).sum();
        writeln!(
            out,
            "{}: written, {} kB; {todo} of {} runs are to be done",
            self.bundle.display(),
            self.bytes.div_ceil(1000),
            self.runs
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_ranges() {
        assert_eq!(ranges([0, 1, 2, 5, 7, 8].into_iter()), [(0, 3), (5, 6), (7, 9)]);
        assert!(ranges([].into_iter()).is_empty());
    }
}

//! `piezoloop sweep`: many runs from one plan, here or in parts on many machines.

mod campaign;
mod figures;
mod job;
mod materials;
mod page;
mod results;
mod share;
mod signals;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, bail};
use clap::Args;
use cli::{PageOptions, Screen};
use sweep::{Cell, Design, Journal, Row, Shard, Table, work};

use crate::fmus::Isolation;
use crate::inputs;
use job::Job;
use materials::Materials;
use results::Swept;

/// Runs a plan of many runs: Monte Carlo, grids, campaigns
///
/// Varies tolerances, gains and effects in closed loops and systems of FMUs, or logs, machines and options in
/// identifications and diagnoses.
///
/// The results are one Parquet table with a row per run. If a sweep was stopped or killed, the same command resumes
/// it. The table has the same bytes for any number of threads and shards, and after interruptions.
#[derive(Args, Debug)]
#[command(after_help = AFTER_HELP, args_conflicts_with_subcommands = true)]
#[command(subcommand_negates_reqs = true)]
pub(crate) struct Sweep {
    #[command(subcommand)]
    command: Option<share::Share>,
    /// The plan
    #[arg(required = true)]
    plan: Option<PathBuf>,
    /// Run only part I of N, counted from 1; `sweep merge` combines the parts
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Seed, instead of the plan's
    #[arg(long, value_name = "S", value_parser = crate::ranges::seed())]
    seed: Option<u64>,
    /// Number of threads; 0: one per processor
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = crate::ranges::threads())]
    threads: usize,
    /// The table to write [default: the plan's name with .parquet, and the shard]
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    isolation: Isolation,
    #[command(flatten)]
    page: PageOptions,
}

const AFTER_HELP: &str = "\
Examples:
  piezoloop sweep plan.toml
  piezoloop sweep plan.toml --shard $SLURM_ARRAY_TASK_ID/8
  piezoloop sweep merge plan.*-of-8.parquet -o plan.parquet

A plan:
  runs = 1000                            # of each combination of the grids
  seed = 7

  [loop]                                 # as `piezoloop simulate --loop`
  plant = \"evc\"                          # FMU, blueprint or rig
  controller = \"controller.toml\"
  reference = \"reference.csv\"
  from = 0.1                             # judged from 0.1 s on

  [vary]                                 # * stands for any characters
  \"plant.*.mechanics.frequency\" = { tolerance = 0.05 }  # normal, 1 sigma of the start value
  \"plant.axis[1].gain\" = { uniform = [0.9, 1.1] }       # or within, normal, log-uniform,
                                                        # whole, choice
  \"controller.*.pid.kp\" = { grid = [0.01, 0.02] }       # each value with each of other grids

docs/sweep.md has systems, campaigns, figures of your own, Slurm, Kubernetes and Dask.";

impl Sweep {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        if let Some(command) = self.command {
            return command.run(screen);
        }
        let plan = self.plan.as_deref().context("give the plan of the sweep")?;
        let materials = Materials::gather(plan, self.seed)?;
        let out = self.out.clone().unwrap_or_else(|| default_out(plan, self.shard));
        cli::can_write_as(&out, inputs::TABLE)?;
        self.page.can_write()?;
        let job = Job::new(&materials, self.isolation.worker()?)?;
        let part = self.shard.map_or(0..job.design.runs(), |shard| shard.range(job.design.runs()));
        let (table, answer) = match finished(&job, &part, &out) {
            Some(table) => {
                let notes = vec!["these runs were there already".to_owned()];
                let answer = Swept::of(&table, out, notes);
                (table, answer)
            }
            None => {
                let began = Instant::now();
                let (table, fresh, threads) = self.rows(&job, part, &out, screen)?;
                let mut answer = Swept::of(&table, out, Vec::new());
                answer.took(fresh, threads, began.elapsed().as_secs_f64());
                (table, answer)
            }
        };
        self.page.finish(screen, &answer, || page::page(&table, &answer, &[("plan", plan)]))
    }

    /// Runs what is not done yet, and writes the table.
    fn rows(
        &self,
        job: &Job,
        part: Range<u64>,
        out: &Path,
        screen: &Screen,
    ) -> anyhow::Result<(Table, usize, usize)> {
        let path = journal_of(out);
        // Another's it refuses by its content.
        files::check_beside(&path, || true)
            .with_context(|| format!("{} cannot be written", path.display()))?;
        let (mut journal, kept) = Journal::open(&path, &job.fingerprint)?;
        let mut rows = known(job, &part, kept);
        let todo: Vec<u64> = part.clone().filter(|run| !rows.contains_key(run)).collect();
        let threads = match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        };
        cli::interrupt::listen()?;
        let bar = cli::bar(screen, "sweep", part.end - part.start);
        bar.set_position(rows.len() as u64);
        bar.reset_eta();
        let outcome = work(
            &todo,
            threads,
            || job.hire(),
            cli::interrupt::asked,
            |row| {
                journal.add(&row)?;
                bar.inc(1);
                rows.insert(row.run, row);
                Ok(())
            },
        );
        bar.finish_and_clear();
        outcome?;
        let all = part.end - part.start;
        if (rows.len() as u64) < all {
            bail!(
                "stopped after {} of {all} runs; the same command resumes ({} keeps them)",
                rows.len(),
                path.display()
            );
        }
        let table = Table { about: job.about(&part), rows: rows.into_values().collect() };
        table.write(out)?;
        journal.remove()?;
        Ok((table, todo.len(), threads.min(todo.len().max(1))))
    }
}

/// The rows of a journal that belong to this part, each run once.
fn known(job: &Job, part: &Range<u64>, rows: Vec<Row>) -> BTreeMap<u64, Row> {
    let of_part = |row: &Row| part.contains(&row.run) && job.takes(row);
    rows.into_iter().filter(of_part).map(|row| (row.run, row)).collect()
}

/// The journal beside a table.
fn journal_of(out: &Path) -> PathBuf {
    let mut name = out.as_os_str().to_owned();
    name.push(".journal");
    PathBuf::from(name)
}

/// The table, where it is there already and no run is missing.
fn finished(job: &Job, part: &Range<u64>, out: &Path) -> Option<Table> {
    // Not a FIFO or a device, which would keep us waiting.
    let table = out.is_file().then(|| Table::read(out).ok())??;
    let about = &table.about;
    let same = about.fingerprint == job.fingerprint && (about.first..about.end) == *part;
    (same && table.rows.len() as u64 == part.end - part.start).then_some(table)
}

fn default_out(plan: &Path, shard: Option<Shard>) -> PathBuf {
    let stem = plan.file_stem().unwrap_or_default().to_string_lossy();
    PathBuf::from(match shard {
        None => format!("{stem}.parquet"),
        Some(shard) => format!("{stem}.{}-of-{}.parquet", shard.index(), shard.count()),
    })
}

/// The row of a run: its values, its results or nothing, and what went wrong.
fn row_of(
    design: &Design,
    results: usize,
    run: u64,
    attempt: impl FnOnce(&[Cell]) -> anyhow::Result<Vec<Cell>>,
) -> Row {
    let (mut cells, outcome) = match design.point(run) {
        Ok(point) => {
            let outcome = attempt(&point);
            (point, outcome)
        }
        Err(error) => (vec![Cell::Missing; design.variables().len()], Err(anyhow::anyhow!(error))),
    };
    let (values, error) = match outcome {
        Ok(values) => (values, Cell::Missing),
        Err(error) => (Vec::new(), Cell::Text(cli::sentence(&error))),
    };
    let width = cells.len() + results;
    cells.extend(values);
    cells.resize(width, Cell::Missing);
    cells.push(error);
    Row { run, cells }
}

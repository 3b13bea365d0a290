//! `piezoloop gap-bench`: the withheld-effect benchmark of `diagnose`.

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context;
use clap::Args;
use gap_bench::{Folders, Plan, Program, Scores, Settings};
use serde::Serialize;

use crate::answer::{Answer, Screen};
use crate::pages::{self, PageOptions};
use crate::{interrupt, progress};

/// How well does diagnose name what a machine does and its model does not?
///
/// Machines with withheld effects are drawn, measured and diagnosed, each by a call of this program
/// that sees the model and the logs and not the label. Ctrl-C ends it after the cases that are under way and scores
/// what is answered, in a random order of the plan; the same command goes on where it was.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop gap-bench --short\n  piezoloop gap-bench --cases 300 -o bench\n  piezoloop gap-bench --cases pair:40,unknown --seed 2 -o bench-2\n  piezoloop gap-bench --cases single/creep:6 -o creep\n  piezoloop gap-bench --seed 2 --cases dd146315 --keep -o one"
)]
pub(crate) struct GapBench {
    /// Fewer cases and shorter records
    #[arg(long)]
    short: bool,
    /// A number of cases, families with or without an effect and a number, or names of cases; the full benchmark
    /// takes hours
    #[arg(long, value_name = "N|FAMILY[/EFFECT][:N]|CASE,…")]
    cases: Option<String>,
    /// Seed of the machines
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Cases at the same time, at most 1024; 0: one per processor
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = crate::inputs::count(0, crate::inputs::MOST_THREADS))]
    threads: usize,
    /// Also repair by a diagnosis that is told the effect, to compare with
    #[arg(long)]
    oracle: bool,
    /// Keep the logs of all cases (a full benchmark needs tens of GB)
    #[arg(long)]
    keep: bool,
    /// Another program to test, with the commands diagnose, pack and simulate
    #[arg(long, value_name = "FILE")]
    tool: Option<PathBuf>,
    /// Folder for cases, labels, scores.json and index.html
    #[arg(short = 'o', long = "out", value_name = "FOLDER", default_value = "gap-bench")]
    out: PathBuf,
    #[command(flatten)]
    page: PageOptions,
}

/// Longest time for one diagnosis.
const PATIENCE: Duration = Duration::from_secs(900);

/// The scores, and where they are.
#[derive(Serialize)]
struct Benchmarked {
    page: PathBuf,
    /// Whether Ctrl-C came before all cases were answered.
    stopped: bool,
    /// Cases that were asked for.
    planned: usize,
    #[serde(flatten)]
    scores: Scores,
}

impl GapBench {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let plan = Plan { seed: self.seed, is_short: self.short };
        let cases = gap_bench::select(plan.cases(), self.cases.as_deref())?;
        std::fs::create_dir_all(&self.out)
            .with_context(|| format!("the folder {} cannot be made", self.out.display()))?;
        let root = self.out.canonicalize()?;
        let settings = Settings {
            folders: Folders { root: root.clone() },
            threads: self.threads,
            keeps_logs: self.keep,
            has_oracle: self.oracle,
        };
        let tool = Program { path: self.program()?, patience: PATIENCE };
        let bar = progress::bar(screen, "diagnosing", cases.len() as u64);
        interrupt::listen()?;
        let go_on = |done: usize| {
            bar.set_position(done as u64);
            !interrupt::asked()
        };
        let outcomes = gap_bench::run(plan, &cases, &settings, &tool, &go_on)?;
        bar.finish_and_clear();
        let scores = Scores::of(&outcomes);
        let page = root.join("index.html");
        let provenance = pages::provenance(&[])?.seed(self.seed);
        let report = scores.page().provenance(provenance);
        report.write_html(&page)?;
        let pages = self.page.write(|| Ok(report))?;
        let json = serde_json::to_vec_pretty(&scores)?;
        data::WholeFile::write_all_of(&root.join("scores.json"), &json)?;
        let pages = self.page.with_own(pages, &page);
        let drawn = cases.len();
        pages.show(
            screen,
            &Benchmarked { page, stopped: outcomes.len() < drawn, planned: drawn, scores },
        )
    }

    fn program(&self) -> anyhow::Result<PathBuf> {
        match &self.tool {
            Some(path) => path
                .canonicalize()
                .with_context(|| format!("--tool {}: there is no such program", path.display())),
            None => {
                std::env::current_exe().context("this program does not find itself; use --tool")
            }
        }
    }
}

impl Answer for Benchmarked {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        if self.stopped {
            writeln!(
                out,
                "stopped before all of {} cases; the same command goes on",
                self.planned
            )?;
        }
        self.scores.write_text(out)?;
        writeln!(out, "\n{}: written", self.page.display())
    }
}

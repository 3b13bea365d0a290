//! `piezoloop gap-bench`: the withheld-effect benchmark of `diagnose`.

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context;
use clap::{Args, Subcommand};
use cli::{Answer, PageOptions, Screen};
use gap_bench::{Folders, Plan, Program, Real, Scores, Settings};
use serde::Serialize;

use crate::pages;
use crate::ranges;

/// Measures how well diagnose finds effects that were withheld from the model
///
/// Random machines with withheld effects are generated, measured and diagnosed. Each diagnosis is a call of this
/// program that gets the model and the logs, but not the label. Ctrl-C finishes the current cases and scores the
/// answers so far (the plan is in random order); the same command resumes.
#[derive(Args, Debug)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Examples:\n  piezoloop gap-bench --short\n  piezoloop gap-bench --cases 300 -o bench\n  piezoloop gap-bench --cases pair:40,unknown --seed 2 -o bench-2\n  piezoloop gap-bench --cases single/creep:6 -o creep\n  piezoloop gap-bench --seed 2 --cases dd146315 --keep -o one\n  piezoloop gap-bench real machines -o machines-bench"
)]
pub(crate) struct GapBench {
    #[command(subcommand)]
    of: Option<Of>,
    /// Fewer cases and shorter records
    #[arg(long)]
    short: bool,
    /// A number of cases, families (with an optional effect and number), or names of cases; the full benchmark takes
    /// hours
    #[arg(long, value_name = "N|FAMILY[/EFFECT][:N]|CASE,…")]
    cases: Option<String>,
    /// Seed of the machines
    #[arg(long, value_name = "S", default_value_t = 1, value_parser = ranges::seed())]
    seed: u64,
    /// Number of cases in parallel; 0: one per processor
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = ranges::threads())]
    threads: usize,
    /// Also repair with a diagnosis that gets the true effect, for comparison
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

/// Other machines than those that are drawn.
#[derive(Subcommand, Debug)]
enum Of {
    Real(Documented),
}

/// Measures how well diagnose names the documented effects of measured machines
///
/// Each subfolder with a machine.toml is a machine. Keys: model (a blueprint or an FMU), logs, holdout, drop, options
/// of diagnose, right (documented effects; empty: every name is wrong) and also (names that may be given in
/// addition). Paths are relative to the subfolder. Exit code 1: a wrong name has a probability of 0.8 or more, or
/// there is no answer.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop gap-bench real machines\n  piezoloop gap-bench real machines --only silverbox -o one"
)]
pub(crate) struct Documented {
    /// Folder of machines
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Only the machine of this name; may be repeated
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Another program to test, with the command diagnose
    #[arg(long, value_name = "FILE")]
    tool: Option<PathBuf>,
    /// Folder for answers, repaired models, scores.json and index.html
    #[arg(short = 'o', long = "out", value_name = "FOLDER", default_value = "gap-bench-real")]
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
        if let Some(Of::Real(documented)) = self.of {
            return documented.run(screen);
        }
        let plan = Plan { seed: self.seed, is_short: self.short };
        let cases = gap_bench::select(plan.cases(), self.cases.as_deref())?;
        files::own_folder(&self.out, &["plan.json"])
            .with_context(|| format!("the folder {} cannot be used", self.out.display()))?;
        let root = self.out.canonicalize()?;
        let settings = Settings {
            folders: Folders { root: root.clone() },
            threads: self.threads,
            keeps_logs: self.keep,
            has_oracle: self.oracle,
        };
        let tool = Program { path: program(self.tool.as_ref())?, patience: PATIENCE };
        let bar = cli::bar(screen, "diagnosing", cases.len() as u64);
        cli::interrupt::listen()?;
        let go_on = |done: usize| {
            bar.set_position(done as u64);
            !cli::interrupt::asked()
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
        data::AtomicFile::write_all_of(&root.join("scores.json"), &json)?;
        let pages = self.page.with_own(pages, &page);
        let drawn = cases.len();
        pages.show(
            screen,
            &Benchmarked { page, stopped: outcomes.len() < drawn, planned: drawn, scores },
        )
    }
}

/// The program that is tested.
fn program(tool: Option<&PathBuf>) -> anyhow::Result<PathBuf> {
    match tool {
        Some(path) => path
            .canonicalize()
            .with_context(|| format!("--tool {}: there is no such program", path.display())),
        None => std::env::current_exe().context("this program does not find itself; use --tool"),
    }
}

/// What measured machines gave, and where it is.
#[derive(Serialize)]
struct OfReal {
    page: PathBuf,
    #[serde(flatten)]
    real: Real,
}

impl Documented {
    fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let folder = self.folder.canonicalize().with_context(|| {
            format!("{}: there is no such folder of machines", self.folder.display())
        })?;
        files::own_folder(&self.out, &["scores.json"])
            .with_context(|| format!("the folder {} cannot be used", self.out.display()))?;
        let root = self.out.canonicalize()?;
        let tool = Program { path: program(self.tool.as_ref())?, patience: PATIENCE };
        cli::interrupt::listen()?;
        let go_on = |_: usize| !cli::interrupt::asked();
        let real = gap_bench::real(&folder, &self.only, &root, &tool, &go_on)?;
        let page = root.join("index.html");
        let report = real.page().provenance(pages::provenance(&[])?);
        report.write_html(&page)?;
        let pages = self.page.write(|| Ok(report))?;
        let json = serde_json::to_vec_pretty(&real)?;
        data::AtomicFile::write_all_of(&root.join("scores.json"), &json)?;
        let is_broken = |m: &gap_bench::Measured| m.judgement == gap_bench::Judgement::Broken;
        let is_bad = real.sure_and_invented() > 0 || real.machines.iter().any(is_broken);
        let pages = self.page.with_own(pages, &page);
        pages.show(screen, &OfReal { page, real })?;
        Ok(u8::from(is_bad))
    }
}

impl Answer for OfReal {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        self.real.write_text(out)?;
        writeln!(out, "\n{}: written", self.page.display())
    }
}

impl Answer for Benchmarked {
    /// A wrong answer is a figure; no answer is a failed check.
    fn exit_code(&self) -> u8 {
        u8::from(!self.scores.failed.is_empty())
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        if self.stopped {
            writeln!(
                out,
                "stopped before all of {} cases; the same command resumes",
                self.planned
            )?;
        }
        self.scores.write_text(out)?;
        writeln!(out, "\n{}: written", self.page.display())
    }
}

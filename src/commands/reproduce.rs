//! `piezoloop reproduce`: the papers' tables on our machines.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::Context;
use clap::{Args, Parser};
use data::UnitPlace;
use papers::Tool;
use papers::reproduce::{self, Aim, Effort, Reproduction, Verdict};
use serde::Serialize;

use crate::answer::{Answer, Screen};
use crate::commands::{Command, pack};
use crate::pages::{self, PageOptions};
use crate::{bed, inputs};

/// Reproduces the tables of a paper: paper | its method here | ours | another way | verdict
///
/// The machine is built after the paper's (`piezoloop list rigs --match` shows how closely), the signals are the
/// paper's. A method is judged by its ratio to the paper's reference method, or by its figure. Control experiments
/// run with packed FMUs; the printed gains are tried first.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop reproduce p0\n  piezoloop reproduce p4 --part control --report p4.html\n  piezoloop reproduce all"
)]
pub(crate) struct Reproduce {
    /// p0, p1, p2, p3, p4 or all; none: all of them
    papers: Vec<String>,
    /// What is reproduced
    #[arg(long, value_enum, default_value_t = Part::All)]
    part: Part,
    #[command(flatten)]
    page: PageOptions,
    /// Also run the papers' own searches (3000 trainings of a particle swarm), in addition to the default one
    #[arg(long, conflicts_with = "quick")]
    searches: bool,
    /// Run only the papers' own methods and those they are compared with; the answer lists what is omitted
    #[arg(long)]
    quick: bool,
    /// Leave logs, blueprints, tables and FMUs in this folder, those of each paper in a folder of its name
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
}

/// Parts of a paper.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    /// Its models
    Modelling,
    /// Its control experiments
    Control,
    /// Both
    All,
}

/// What the experiments take from this tool.
const TOOL: Tool = Tool { open: bed::open, identify };

fn identify(arguments: &[&str]) -> anyhow::Result<()> {
    let words = ["piezoloop", "identify"].iter().chain(arguments);
    let quiet = Screen { json: false, quiet: true };
    match crate::Cli::try_parse_from(words)?.command {
        Command::Identify(command) => command.execute(&quiet).map(drop),
        _ => anyhow::bail!("not an identify command"),
    }
}

/// All that was asked for.
#[derive(Serialize)]
struct Reproductions(Vec<Reproduction>);

impl Reproduce {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        const ALL: [&str; 5] = ["p0", "p1", "p2", "p3", "p4"];
        let complete = self.papers.is_empty() || self.papers.iter().any(|paper| paper == "all");
        let papers = if complete { ALL.map(String::from).to_vec() } else { self.papers.clone() };
        let effort = match (self.quick, self.searches) {
            (true, _) => Effort::Quick,
            (_, true) => Effort::Searches,
            _ => Effort::Full,
        };
        let mut jobs = Vec::new();
        for paper in &papers {
            let (models, loops) = (
                reproduce::PAPERS.contains(&paper.as_str()),
                reproduce::control::PAPERS.contains(&paper.as_str()),
            );
            if self.part != Part::Control && (models || !loops) {
                jobs.push((paper.as_str(), Part::Modelling));
            }
            if self.part != Part::Modelling && (loops || self.part == Part::Control && !complete) {
                jobs.push((paper.as_str(), Part::Control));
            }
        }
        if let Some(folder) = &self.keep {
            fs::create_dir_all(folder)
                .with_context(|| format!("{} cannot be made", folder.display()))?;
        }
        let all = done(&jobs, effort, screen)?;
        if let Some(folder) = &self.keep {
            for one in &all {
                keep(one, folder)?;
            }
        }
        let all = Reproductions(all);
        let page = || papers::page::reproduction(&all.0, pages::provenance(&[])?);
        self.page.finish(screen, &all, page)
    }
}

/// Runs all jobs, as many at once as there are processors; the answers in the order of the jobs.
fn done(
    jobs: &[(&str, Part)],
    effort: Effort,
    screen: &Screen,
) -> anyhow::Result<Vec<Reproduction>> {
    let next = AtomicUsize::new(0);
    let answers: Vec<Mutex<Option<anyhow::Result<Reproduction>>>> =
        jobs.iter().map(|_| Mutex::new(None)).collect();
    let work = || {
        while let Some((number, (paper, part))) =
            Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|n| Some((n, jobs.get(n)?)))
        {
            let say = |line: &str| screen.say(&format!("{paper}: {line}"));
            let answer = match part {
                Part::Control => reproduce::control::run(paper, effort, &TOOL, &say),
                _ => reproduce::run(paper, effort, &say),
            };
            // Nothing more is begun where one has failed.
            if answer.is_err() {
                next.store(jobs.len(), Ordering::Relaxed);
            }
            if let Ok(mut place) = answers[number].lock() {
                *place = Some(answer);
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(jobs.len());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    let mut all = Vec::new();
    for answer in answers {
        match answer.into_inner() {
            Ok(Some(Ok(answer))) => all.push(answer),
            Ok(Some(Err(error))) => return Err(error),
            // Not begun: one behind it failed, and says so.
            _ => {}
        }
    }
    Ok(all)
}

/// Leaves what others may run in a folder of the paper's name: logs, blueprints with their tables, their FMUs, and the figures
/// and orders as tables.
fn keep(one: &Reproduction, folder: &Path) -> anyhow::Result<()> {
    let folder = folder.join(one.paper);
    fs::create_dir_all(&folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    for (name, log) in one.kept.logs() {
        log.write(&folder.join(format!("{name}.csv")), UnitPlace::Sidecar)?;
    }
    for (name, blueprint) in one.kept.blueprints() {
        let file = folder.join(format!("{name}.toml"));
        inputs::write_blueprint(&blueprint.check(learned::COMPONENTS)?, &file)?;
        let fmu = file.with_extension("fmu");
        pack::pack(&inputs::blueprint(&file)?, pack::PACKED_WITH, &[], &fmu)?;
    }
    let mut figures = String::from("figure,unit,paper,its method here,ours,another way,verdict\n");
    let number = |x: f64| if x.is_nan() { String::new() } else { x.to_string() };
    for row in &one.rows {
        let [ours, other] = [row.ours, row.other].map(|x| x.map_or_else(String::new, number));
        let (paper, own) = (number(row.paper), number(row.own));
        let verdict = word(row.verdict);
        figures +=
            &format!("\"{}\",{},{paper},{own},{ours},{other},{verdict}\n", row.what, row.unit);
    }
    let mut orders = String::from("order,holds\n");
    for order in &one.orders {
        orders += &format!("\"{}\",{}\n", order.what, order.holds);
    }
    for (name, text) in [("figures", figures), ("orders", orders)] {
        let file = folder.join(format!("{}-{name}.csv", one.part));
        data::WholeFile::write_all_of(&file, text.as_bytes())
            .with_context(|| format!("{} cannot be written", file.display()))?;
    }
    Ok(())
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Reached => "reached",
        Verdict::NotReached => "not reached",
        Verdict::Matched => "as the paper's",
        Verdict::NotMatched => "not as the paper's",
        Verdict::NotJudged => "-",
    }
}

impl Answer for Reproductions {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for one in &self.0 {
            write_one(one, out)?;
        }
        Ok(())
    }

    fn exit_code(&self) -> u8 {
        let missed = |one: &Reproduction| {
            one.rows.iter().any(|r| r.verdict == Verdict::NotReached)
                || one.orders.iter().any(|o| !o.holds)
        };
        u8::from(self.0.iter().any(missed))
    }
}

fn write_one(one: &Reproduction, out: &mut dyn Write) -> io::Result<()> {
    let (matched, remarks): (Vec<&String>, Vec<&String>) =
        one.remarks.iter().partition(|remark| remark.starts_with("match"));
    for line in matched {
        writeln!(out, "{line}")?;
    }
    for what in &one.left_out {
        writeln!(out, "{}, {}, left out by --quick: {what}", one.paper, one.part)?;
    }
    writeln!(
        out,
        "\n{:58} {:>8} {:>8} {:>8} {:>8} {:>13}  verdict",
        "figure", "paper", "its way", "ours", "other", "of baseline"
    )?;
    for row in &one.rows {
        let verdict = word(row.verdict);
        let what = format!("{} {} [{}]", row.paper_id, row.what, row.unit);
        let paper = if row.paper.is_nan() { "-".to_owned() } else { row.paper.to_string() };
        let described = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.4}"));
        let ratio = match row.aim {
            Aim::Ratio { paper, own } => format!("{paper:.2} > {own:.2}"),
            _ => String::new(),
        };
        let (ours, other) = (described(row.ours), described(row.other));
        let own = described((!row.own.is_nan()).then_some(row.own));
        writeln!(out, "{what:58} {paper:>8} {own:>8} {ours:>8} {other:>8} {ratio:>13}  {verdict}")?;
    }
    for order in &one.orders {
        let verdict = if order.holds { "holds" } else { "does not hold" };
        writeln!(out, "{} order: {}: {verdict}", order.paper_id, order.what)?;
    }
    for remark in remarks {
        writeln!(out, "  {remark}")?;
    }
    Ok(())
}

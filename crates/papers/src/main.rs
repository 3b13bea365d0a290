//! `piezoloop-papers`: the papers' tables on our machines.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::Context;
use clap::Parser;
use cli::{Answer, PageOptions, Screen, interrupt};
use data::UnitPlace;
use papers::matching::{self, Figure};
use papers::reproduce::{self, Aim, Effort, Reproduction, Verdict};
use papers::{Tool, page};
use report::Provenance;
use serde::Serialize;

/// Reproduces the tables of a paper: paper | its method here | ours | another way | verdict
///
/// The machine is built after the paper's (--match shows how closely), the signals are the
/// paper's. A method is judged by its ratio to the paper's reference method, or by its figure. Control experiments
/// run with packed FMUs; the printed gains are tried first.
#[derive(Parser, Debug)]
#[command(name = "piezoloop-papers", version, after_help = EXAMPLES)]
struct Papers {
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
    /// Compare the machines with the figures that the papers publish of their own machines; no method is run
    #[arg(long = "match", conflicts_with_all = ["papers", "part", "quick", "searches", "keep", "reports", "plot"])]
    matching: bool,
    /// Leave logs, blueprints, tables and FMUs in this folder, those of each paper in a folder of its name
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
    /// The program that packs and identifies [default: piezoloop in the folder of this program]
    #[arg(long, value_name = "PROGRAM")]
    tool: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short, conflicts_with = "json")]
    quiet: bool,
}

const EXAMPLES: &str = "Examples:\n  piezoloop-papers p0\n  piezoloop-papers p4 --part control --report p4.html\n  piezoloop-papers all\n  piezoloop-papers --match";

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

/// All that was asked for.
#[derive(Serialize)]
struct Reproductions(Vec<Reproduction>);

/// The machines beside the papers'.
#[derive(Serialize)]
struct Matched(Vec<Figure>);

fn main() -> ExitCode {
    let papers = Papers::parse();
    let screen = Screen::new(papers.json, papers.quiet);
    let named: Vec<PathBuf> = papers.keep.iter().chain(&papers.tool).cloned().collect();
    let _tidy = interrupt::begin();
    exits::guard(cosim::instances, cosim::called);
    let kept = if papers.json { cli::keep_standard_output() } else { Ok(()) };
    let outcome = kept.and_then(|()| papers.run(&screen));
    interrupt::wait_if_ending();
    exits::finished();
    outcome.map_or_else(
        |error| {
            screen.error(&error, &named);
            ExitCode::from(2)
        },
        ExitCode::from,
    )
}

impl Papers {
    fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        if self.matching {
            return screen.show(&Matched(match_all(screen)?));
        }
        self.page.can_write()?;
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
        // Models need no tool, as long as nothing is kept.
        let tool = || Tool::find(self.tool.as_deref());
        let controls = jobs.iter().any(|(_, part)| *part == Part::Control);
        let tool = if controls || self.keep.is_some() { Some(tool()?) } else { None };
        if let Some(folder) = &self.keep {
            fs::create_dir_all(folder)
                .with_context(|| format!("{} cannot be made", folder.display()))?;
        }
        let all = done(&jobs, effort, tool.as_ref(), screen)?;
        if let (Some(folder), Some(tool)) = (&self.keep, &tool) {
            for one in &all {
                keep(one, tool, folder)?;
            }
        }
        let all = Reproductions(all);
        let page = || {
            let version = env!("CARGO_PKG_VERSION");
            let by = Provenance::new("piezoloop-papers", version).command_line(std::env::args());
            page::reproduction(&all.0, by)
        };
        self.page.finish(screen, &all, page)
    }
}

/// Runs all jobs, as many at once as there are processors; the answers in the order of the jobs.
fn done(
    jobs: &[(&str, Part)],
    effort: Effort,
    tool: Option<&Tool>,
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
            let answer = match (part, tool) {
                (Part::Control, Some(tool)) => reproduce::control::run(paper, effort, tool, &say),
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
fn keep(one: &Reproduction, tool: &Tool, folder: &Path) -> anyhow::Result<()> {
    let folder = folder.join(one.paper);
    fs::create_dir_all(&folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    for (name, log) in one.kept.logs() {
        log.write(&folder.join(format!("{name}.csv")), UnitPlace::Sidecar)?;
    }
    for (name, blueprint) in one.kept.blueprints() {
        tool.pack(blueprint, &folder.join(format!("{name}.fmu")))?;
    }
    let mut figures = String::from("figure,unit,paper,its method here,ours,another way,verdict\n");
    let number = |x: f64| if x.is_nan() { String::new() } else { x.to_string() };
    for row in &one.rows {
        let [ours, other] = [row.ours, row.other].map(|x| x.map_or_else(String::new, number));
        let (paper, own) = (number(row.paper), number(row.own));
        let verdict = row.verdict.words().unwrap_or("-");
        figures +=
            &format!("\"{}\",{},{paper},{own},{ours},{other},{verdict}\n", row.what, row.unit);
    }
    let mut orders = String::from("order,holds\n");
    for order in &one.orders {
        orders += &format!("\"{}\",{}\n", order.what, order.holds);
    }
    for (name, text) in [("figures", figures), ("orders", orders)] {
        let file = folder.join(format!("{}-{name}.csv", one.part));
        data::AtomicFile::write_all_of(&file, text.as_bytes())
            .with_context(|| format!("{} cannot be written", file.display()))?;
    }
    Ok(())
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
        let verdict = row.verdict.words().unwrap_or("-");
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

/// All figures of all papers' machines.
fn match_all(screen: &Screen) -> anyhow::Result<Vec<Figure>> {
    let bar = cli::bar(screen, "running the baselines", matching::TABLES.len() as u64);
    let mut all = Vec::new();
    for table in matching::TABLES {
        all.extend(table()?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(all)
}

/// The table of figures, and the verdict on each rig.
fn write_match(figures: &[Figure], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{:10} {:58} {:>8} {:>8}  verdict", "rig", "figure", "paper", "ours")?;
    for f in figures {
        let verdict = if f.within { "matched" } else { "not matched" };
        let note = if f.note.is_empty() { String::new() } else { format!(" ({})", f.note) };
        let what = format!("{} [{}]", f.what, f.unit);
        writeln!(out, "{:10} {what:58} {:>8} {:>8.3}  {verdict}{note}", f.rig, f.paper, f.ours)?;
    }
    let within = figures.iter().filter(|f| f.within).count();
    let beyond = figures.len() - within;
    writeln!(out, "\n{within} figures within 25 % of the paper's, {beyond} beyond")
}

impl Answer for Matched {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        write_match(&self.0, out)
    }
}

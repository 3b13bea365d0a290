//! `piezoloop reproduce`: the papers' tables on our machines.

use std::io::{self, Write};

use clap::{Args, Parser};
use papers::Tool;
use papers::reproduce::{self, Aim, Reproduction, Verdict};
use serde::Serialize;

use crate::answer::{Answer, Screen};
use crate::bed;
use crate::commands::Command;
use crate::pages::{self, PageOptions};

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
    #[arg(long)]
    searches: bool,
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
        let whole = self.papers.is_empty() || self.papers.iter().any(|paper| paper == "all");
        let papers = if whole { ALL.map(String::from).to_vec() } else { self.papers.clone() };
        let mut all = Vec::new();
        for paper in &papers {
            let say = |line: &str| screen.say(&format!("{paper}: {line}"));
            let (models, loops) = (
                reproduce::PAPERS.contains(&paper.as_str()),
                reproduce::control::PAPERS.contains(&paper.as_str()),
            );
            if self.part != Part::Control && (models || !loops) {
                all.push(reproduce::run(paper, self.searches, &say)?);
            }
            if self.part != Part::Modelling && (loops || self.part == Part::Control && !whole) {
                all.push(reproduce::control::run(paper, &TOOL, &say)?);
            }
        }
        let all = Reproductions(all);
        let page = || papers::page::reproduction(&all.0, pages::provenance(&[])?);
        self.page.finish(screen, &all, page)
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
    writeln!(
        out,
        "\n{:58} {:>8} {:>8} {:>8} {:>8} {:>13}  verdict",
        "figure", "paper", "its way", "ours", "other", "of baseline"
    )?;
    for row in &one.rows {
        let verdict = match row.verdict {
            Verdict::Reached => "reached",
            Verdict::NotReached => "not reached",
            Verdict::Matched => "as the paper's",
            Verdict::NotMatched => "not as the paper's",
            Verdict::NotJudged => "-",
        };
        let what = format!("{} {} [{}]", row.paper_id, row.what, row.unit);
        let paper = if row.paper.is_nan() { "-".to_owned() } else { row.paper.to_string() };
        let told = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.4}"));
        let ratio = match row.aim {
            Aim::Ratio { paper, own } => format!("{paper:.2} > {own:.2}"),
            _ => String::new(),
        };
        let (ours, other) = (told(row.ours), told(row.other));
        let own = told((!row.own.is_nan()).then_some(row.own));
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

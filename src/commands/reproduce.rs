//! `piezoloop reproduce`: the papers' tables on our machines.

use std::io::{self, Write};

use clap::Args;
use serde::Serialize;

use crate::answer::{Answer, Screen};
use crate::reproduce::{self, Reproduction, Verdict};

/// Reproduces the modelling of a paper: paper | ours | verdict
///
/// The machine is our matched one (`piezoloop list rigs --match`), the signals are the paper's.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  piezoloop reproduce p0")]
pub(crate) struct Reproduce {
    /// p0, p1, p2 or p3; none: all of them
    papers: Vec<String>,
    /// Run the papers' own searches too (3000 trainings of a swarm), beside the default one
    #[arg(long)]
    searches: bool,
}

/// All that was asked for.
#[derive(Serialize)]
struct Reproductions(Vec<Reproduction>);

impl Reproduce {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let papers = if self.papers.is_empty() {
            reproduce::PAPERS.map(String::from).to_vec()
        } else {
            self.papers
        };
        let mut all = Vec::new();
        for paper in &papers {
            let say = |line: &str| screen.say(&format!("{paper}: {line}"));
            all.push(reproduce::run(paper, self.searches, &say)?);
        }
        screen.show(&Reproductions(all))
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
    writeln!(out, "\n{:66} {:>8} {:>8}  verdict", "figure", "paper", "ours")?;
    for row in &one.rows {
        let verdict = match row.verdict {
            Verdict::Reached => "reached",
            Verdict::NotReached => "not reached",
            Verdict::Matched => "as the paper's",
            Verdict::NotMatched => "not as the paper's",
            Verdict::NotJudged => "-",
        };
        let what = format!("{} {} [{}]", row.paper_id, row.what, row.unit);
        writeln!(out, "{what:66} {:>8} {:>8.4}  {verdict}", row.paper, row.ours)?;
    }
    for order in &one.orders {
        let verdict = if order.holds { "holds" } else { "does not hold" };
        writeln!(out, "{} order: {}: {verdict}", order.paper_id, order.what)?;
    }
    for remark in &one.remarks {
        writeln!(out, "  {remark}")?;
    }
    Ok(())
}

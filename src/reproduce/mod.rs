//! The papers' tables again, on our matched machines: modelling.

pub(crate) mod control;
pub(crate) mod figures;
mod p0;
mod p1;
mod p2;
mod p3;
mod p4;
pub(crate) mod stand_ins;

use serde::Serialize;

use identify::learned::Arx;

use crate::matching;

/// One number of a paper beside ours.
#[derive(Serialize)]
pub(crate) struct Row {
    pub(crate) paper_id: &'static str,
    pub(crate) what: String,
    pub(crate) unit: &'static str,
    pub(crate) paper: f64,
    pub(crate) ours: f64,
    pub(crate) aim: Aim,
    pub(crate) verdict: Verdict,
}

/// What a number is for.
#[derive(Serialize, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Aim {
    /// To be reached or beaten.
    Reach,
    /// A method that the paper compares with; within 25 % the machine is as the paper's.
    Baseline,
    /// For comparison only.
    Told,
}

#[derive(Serialize, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Verdict {
    Reached,
    NotReached,
    Matched,
    NotMatched,
    NotJudged,
}

/// An order of methods that a paper reports.
#[derive(Serialize)]
pub(crate) struct Order {
    pub(crate) paper_id: &'static str,
    pub(crate) what: String,
    pub(crate) holds: bool,
}

/// What a paper's reproduction gives.
#[derive(Serialize, Default)]
pub(crate) struct Reproduction {
    pub(crate) rows: Vec<Row>,
    pub(crate) orders: Vec<Order>,
    /// What stands in, and what the figures mean.
    pub(crate) remarks: Vec<String>,
    /// `p0`, `p1`, …
    pub(crate) paper: &'static str,
    /// `modelling` or `control`.
    pub(crate) part: &'static str,
    /// The rig that stands in for the paper's machine.
    pub(crate) rig: &'static str,
    /// The machine beside the paper's, without the paper's method.
    #[serde(skip)]
    pub(crate) matched: Vec<matching::Figure>,
    /// What was seen.
    #[serde(skip)]
    pub(crate) chapters: Vec<figures::Chapter>,
}

/// The papers with a reproduction of their modelling.
pub(crate) const PAPERS: [&str; 5] = ["p0", "p1", "p2", "p3", "p4"];

/// Runs the reproduction of a paper's modelling; `searches`: also by the paper's own long searches.
pub(crate) fn run(paper: &str, searches: bool, say: &dyn Fn(&str)) -> anyhow::Result<Reproduction> {
    let answer = match paper {
        "p0" => p0::run(say),
        "p1" => p1::run(searches, say),
        "p2" => p2::run(say),
        "p3" => p3::run(say),
        "p4" => p4::run(say),
        other => anyhow::bail!("no paper \"{other}\"; known are {}", PAPERS.join(", ")),
    };
    Ok(answer?.of(paper, "modelling"))
}

/// Papers, and the rigs that stand in for their machines.
const RIGS: [(&str, &str); 5] = [
    ("p0", "p0-truth"),
    ("p1", "p1-truth"),
    ("p2", "p2-truth"),
    ("p3", "p3-truth"),
    ("p4", "p4-truth"),
];

impl Reproduction {
    /// The same, of this part of a paper.
    fn of(mut self, paper: &str, part: &'static str) -> Self {
        if let Some((paper, rig)) = RIGS.iter().find(|(known, _)| *known == paper) {
            (self.paper, self.rig) = (paper, rig);
        }
        self.part = part;
        self
    }
}

impl Row {
    fn new(
        paper_id: &'static str,
        what: impl Into<String>,
        unit: &'static str,
        paper: f64,
        ours: f64,
        aim: Aim,
    ) -> Self {
        let near = (ours / paper - 1.0).abs() <= 0.25;
        let verdict = match aim {
            Aim::Reach if ours <= paper => Verdict::Reached,
            Aim::Reach => Verdict::NotReached,
            Aim::Baseline if near => Verdict::Matched,
            Aim::Baseline => Verdict::NotMatched,
            Aim::Told => Verdict::NotJudged,
        };
        Self { paper_id, what: what.into(), unit, paper, ours, aim, verdict }
    }
}

/// The command of an axis and the position at the end of each of its samples.
pub(crate) struct Response {
    pub(crate) command: Vec<f64>,
    /// One more than commands: the position before the first.
    pub(crate) position: Vec<f64>,
    pub(crate) period: f64,
}

/// The poles of a linear part: frequencies in Hz, and dampings of pairs.
pub(crate) fn poles(linear: &Arx, period: f64) -> String {
    let told = linear.poles().into_iter().filter(|p| p.im >= 0.0).map(|p| {
        let s = p.ln() / period;
        let hz = s.norm() / std::f64::consts::TAU;
        match p.im > 0.0 {
            true => format!("{hz:.1} Hz with damping {:.3}", -s.re / s.norm()),
            false => format!("{hz:.2} Hz"),
        }
    });
    told.collect::<Vec<String>>().join(", ")
}

/// What axis 1 of a truth rig does under a paper's signal, times `gain`; the last command is held for
/// one sample more.
pub(crate) fn response(
    rig: &str,
    name: &str,
    settings: &[(&str, f64)],
    gain: f64,
) -> anyhow::Result<Response> {
    response_of(rig, 1, name, settings, gain)
}

/// The same of an axis, from 1.
fn response_of(
    rig: &str,
    axis: usize,
    name: &str,
    settings: &[(&str, f64)],
    gain: f64,
) -> anyhow::Result<Response> {
    let (u, period) = matching::signal(name, settings)?;
    let mut command: Vec<f64> = u.iter().map(|u| gain * u).collect();
    command.push(command.last().copied().unwrap_or(0.0));
    let position = matching::response(&mut matching::rig(rig)?, axis, &command, period)?;
    command.pop();
    Ok(Response { command, position, period })
}

impl Response {
    /// The position at the end of each sample.
    pub(crate) fn after(&self) -> &[f64] {
        &self.position[1..]
    }
}

//! The papers' tables again, on our matched machines: modelling.

pub mod control;
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
pub struct Row {
    /// The paper's table or figure.
    pub paper_id: &'static str,
    /// What the number is.
    pub what: String,
    /// Unit of both numbers.
    pub unit: &'static str,
    /// The paper's number; not a number where it prints none.
    pub paper: f64,
    /// Ours.
    pub ours: f64,
    /// What it is for.
    pub aim: Aim,
    /// How they compare.
    pub verdict: Verdict,
}

/// What a number is for.
#[derive(Serialize, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Aim {
    /// To be reached or beaten.
    Reach,
    /// A method that the paper compares with; within 25 % the machine is as the paper's.
    Baseline,
    /// For comparison only.
    Told,
}

/// How a number compares with the paper's.
#[derive(Serialize, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Reached or beaten.
    Reached,
    /// Not reached.
    NotReached,
    /// A baseline within 25 % of the paper's.
    Matched,
    /// A baseline farther from the paper's.
    NotMatched,
    /// For comparison only, or on a machine that is not matched.
    NotJudged,
}

/// An order of methods that a paper reports.
#[derive(Serialize)]
pub struct Order {
    /// The paper's table or figure.
    pub paper_id: &'static str,
    /// The order.
    pub what: String,
    /// Whether it holds on our machine.
    pub holds: bool,
}

/// What a paper's reproduction gives.
#[derive(Serialize, Default)]
pub struct Reproduction {
    /// The figures.
    pub rows: Vec<Row>,
    /// The orders of methods.
    pub orders: Vec<Order>,
    /// What stands in, and what the figures mean.
    pub remarks: Vec<String>,
    /// `p0`, `p1`, …
    pub paper: &'static str,
    /// `modelling` or `control`.
    pub part: &'static str,
    /// The rig that stands in for the paper's machine.
    pub rig: &'static str,
    /// The machine beside the paper's, without the paper's method.
    #[serde(skip)]
    pub(crate) matched: Vec<matching::Figure>,
    /// What was seen.
    #[serde(skip)]
    pub(crate) chapters: Vec<figures::Chapter>,
}

/// The papers with a reproduction of their modelling.
pub const PAPERS: [&str; 5] = ["p0", "p1", "p2", "p3", "p4"];

/// Runs the reproduction of a paper's modelling; `searches`: also by the paper's own long searches; what
/// it is at goes to `say`.
///
/// # Errors
/// For an unknown paper, and where a model cannot be found.
pub fn run(paper: &str, searches: bool, say: &dyn Fn(&str)) -> anyhow::Result<Reproduction> {
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

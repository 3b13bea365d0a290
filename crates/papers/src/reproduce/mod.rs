//! The papers' tables again, on machines that could exist: modelling.

pub mod control;
pub(crate) mod figures;
mod p0;
pub(crate) mod p1;
mod p2;
mod p3;
mod p4;
pub(crate) mod relays;
pub(crate) mod stand_ins;

use serde::Serialize;

use identify::learned::Arx;

use crate::keep::Kept;
use crate::{machines, matching};

/// One number of a paper beside that of the same method on our machine.
#[derive(Serialize)]
pub struct Row {
    /// The paper's table or figure.
    pub paper_id: &'static str,
    /// What the number is.
    pub what: String,
    /// Unit of all numbers.
    pub unit: &'static str,
    /// The paper's number; not a number where it prints none.
    pub paper: f64,
    /// The number of the paper's own method on our machine; not a number in a row of one of our ways alone.
    pub own: f64,
    /// The best of this project's own ways.
    pub ours: Option<f64>,
    /// Another way, for comparison.
    pub other: Option<f64>,
    /// What the row is for.
    pub aim: Aim,
    /// How they compare.
    pub verdict: Verdict,
}

/// What a number is for.
#[derive(Serialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub enum Aim {
    /// To be reached or beaten.
    Reach,
    /// To be as much below the method that the paper compares with as in the paper, within a quarter.
    Ratio {
        /// The paper's number over that of its baseline.
        paper: f64,
        /// The method's number over that of its baseline on our machine.
        own: f64,
    },
    /// A method that the paper compares with; within 25 % the machine is as the paper's.
    Baseline,
    /// For comparison only.
    #[serde(rename = "told")]
    ForComparison,
}

/// How a number compares with the paper's.
#[derive(Serialize, Clone, Copy, Debug, PartialEq, Eq)]
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
    /// For comparison only.
    NotJudged,
}

impl Verdict {
    /// The verdict in words; none where nothing is judged.
    #[must_use]
    pub fn words(self) -> Option<&'static str> {
        Some(match self {
            Self::Reached => "reached",
            Self::NotReached => "not reached",
            Self::Matched => "as the paper's",
            Self::NotMatched => "not as the paper's",
            Self::NotJudged => return None,
        })
    }
}

/// How much more of its baseline than in the paper a method may leave.
const RATIO: f64 = 1.25;

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

impl Order {
    /// That the first of two errors is the smaller one, or that it is not, as the paper's numbers have it.
    fn of_numbers(
        paper_id: &'static str,
        what: String,
        here: (f64, f64),
        paper: (f64, f64),
    ) -> Self {
        let swapped = paper.0 > paper.1;
        let what = if swapped { format!("{what}: not so in the paper") } else { what };
        Self { paper_id, what, holds: (here.0 < here.1) != swapped }
    }
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
    /// What a quick reproduction leaves out, or does with less.
    pub left_out: Vec<&'static str>,
    /// Logs and blueprints.
    #[serde(skip)]
    pub kept: Kept,
    /// The machine beside the paper's, without the paper's method.
    #[serde(skip)]
    pub(crate) matched: Vec<matching::Figure>,
    /// What was seen.
    #[serde(skip)]
    pub(crate) chapters: Vec<figures::Chapter>,
}

/// How much is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// The papers' own methods and what they are judged by, on smaller trainings where these are long.
    Quick,
    /// All rows.
    Full,
    /// All rows, and the papers' own long searches beside the default one.
    Searches,
}

impl Effort {
    fn is_quick(self) -> bool {
        self == Self::Quick
    }
}

/// The papers with a reproduction of their modelling.
pub const PAPERS: [&str; 5] = ["p0", "p1", "p2", "p3", "p4"];

/// Runs the reproduction of a paper's modelling; what it is at goes to `say`.
///
/// # Errors
/// For an unknown paper, and where a model cannot be found.
pub fn run(
    paper: &str,
    effort: Effort,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<Reproduction> {
    let answer = match paper {
        "p0" => p0::run(effort, say),
        "p1" => p1::run(effort, say),
        "p2" => p2::run(effort, say),
        "p3" => p3::run(effort, say),
        "p4" => p4::run(effort, say),
        other => anyhow::bail!("no paper \"{other}\"; known are {}", PAPERS.join(", ")),
    };
    Ok(answer?.of(paper, "modelling"))
}

/// Papers, and the rigs that stand in for their machines.
const RIGS: [(&str, &str); 5] = [
    ("p0", machines::P0),
    ("p1", machines::P1),
    ("p2", machines::P2),
    ("p3", machines::P3),
    ("p4", machines::P4),
];

impl Reproduction {
    /// Leaves something out, or does it with less, where it is to be quick; whether it is.
    fn leaves_out(&mut self, effort: Effort, what: &'static str) -> bool {
        if effort.is_quick() {
            self.left_out.push(what);
        }
        effort.is_quick()
    }

    /// Adds what a part of it gave.
    fn append(&mut self, part: Self) {
        self.rows.extend(part.rows);
        self.orders.extend(part.orders);
        self.remarks.extend(part.remarks);
        self.left_out.extend(part.left_out);
        self.matched.extend(part.matched);
        self.chapters.extend(part.chapters);
        self.kept.append(part.kept);
    }

    /// With the paper, its rig and its part.
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
        own: f64,
        aim: Aim,
    ) -> Self {
        let near = (own / paper - 1.0).abs() <= 0.25;
        let verdict = match aim {
            Aim::Reach if own <= paper => Verdict::Reached,
            Aim::Ratio { paper, own } if own <= RATIO * paper => Verdict::Reached,
            Aim::Reach | Aim::Ratio { .. } => Verdict::NotReached,
            Aim::Baseline if near => Verdict::Matched,
            Aim::Baseline => Verdict::NotMatched,
            Aim::ForComparison => Verdict::NotJudged,
        };
        let (ours, other) = (None, None);
        Self { paper_id, what: what.into(), unit, paper, own, ours, other, aim, verdict }
    }

    /// A row judged by the ratio to a baseline, the paper's and that on our machine.
    fn ratio(
        paper_id: &'static str,
        what: impl Into<String>,
        unit: &'static str,
        [paper, paper_baseline]: [f64; 2],
        [own, own_baseline]: [f64; 2],
    ) -> Self {
        let aim = Aim::Ratio { paper: paper / paper_baseline, own: own / own_baseline };
        Self::new(paper_id, what, unit, paper, own, aim)
    }

    /// A row of one of our ways alone, which is not judged as the paper's.
    fn of_ours(
        paper_id: &'static str,
        what: impl Into<String>,
        unit: &'static str,
        paper: f64,
        ours: f64,
    ) -> Self {
        Self::new(paper_id, what, unit, paper, f64::NAN, Aim::ForComparison).ours(ours)
    }

    fn ours(self, ours: f64) -> Self {
        Self { ours: Some(ours), ..self }
    }

    fn other(self, other: f64) -> Self {
        Self { other: Some(other), ..self }
    }
}

/// The poles of a linear part: frequencies in Hz, and dampings of pairs.
pub(crate) fn poles(linear: &Arx, period: f64) -> String {
    let described = linear.poles().into_iter().filter(|p| p.im >= 0.0).map(|p| {
        let s = p.ln() / period;
        let hz = s.norm() / std::f64::consts::TAU;
        match p.im > 0.0 {
            true => format!("{hz:.1} Hz with damping {:.3}", -s.re / s.norm()),
            false => format!("{hz:.2} Hz"),
        }
    });
    described.collect::<Vec<String>>().join(", ")
}

//! The papers' control experiments on machines that could be theirs, through packed FMUs.

mod bed;
mod inverse;
pub mod learning;
mod p0;
mod p1;
mod p2;
mod p3;
mod p4;
pub mod single;

pub use bed::{Bed, Tracked};
pub(crate) use inverse::{Linear, arx_component, linear};

use anyhow::Context;

use super::{Aim, Effort, Order, Reproduction, Row};
use crate::{Tool, matching};

/// The papers with control experiments here.
pub const PAPERS: [&str; 5] = ["p0", "p1", "p2", "p3", "p4"];

/// Runs the control experiments of a paper; its match table comes first. What it is at goes to `say`.
///
/// # Errors
/// For an unknown paper, and where an experiment fails.
pub fn run(
    paper: &str,
    effort: Effort,
    tool: &Tool,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<Reproduction> {
    let mut answer = match paper {
        "p0" => p0::run(effort, tool, say)?,
        "p1" => p1::run(effort, tool, say)?,
        "p2" => p2::run(effort, tool, say)?,
        "p3" => p3::run(effort, tool, say)?,
        "p4" => p4::run(effort, tool, say)?,
        other => {
            anyhow::bail!("no control experiments of \"{other}\"; there are {}", PAPERS.join(", "))
        }
    };
    let rig = PAPERS.iter().position(|known| *known == paper);
    let rig =
        rig.and_then(|at| matching::TABLES.get(at)).context("each paper has a match table")?;
    let matched = rig()?;
    with_match(&matched, &mut answer);
    answer.matched = matched;
    Ok(answer.of(paper, "control"))
}

/// Puts the match table in front.
fn with_match(figures: &[matching::Figure], answer: &mut Reproduction) {
    let within = figures.iter().filter(|figure| figure.within).count();
    let rig = figures.first().map_or("the rig", |figure| figure.rig);
    let mut lines = vec![format!(
        "match of {rig}: {} figures of the machine without the paper's method, {within} within 25 %",
        figures.len()
    )];
    for matching::Figure { what, unit, paper, ours, .. } in figures {
        lines.push(format!("match: {what}: paper {paper} {unit}, ours {ours:.4} {unit}"));
    }
    lines.append(&mut answer.remarks);
    answer.remarks = lines;
}

/// Root mean square of some axes' errors together, from row `from` on.
fn rms_of(errors: &[Vec<f64>], axes: &[usize], from: usize) -> f64 {
    let rows = errors.iter().map(Vec::len).min().unwrap_or(0).saturating_sub(from).max(1);
    let squares = axes.iter().flat_map(|axis| &errors[*axis][from..]).map(|e| e * e);
    (squares.sum::<f64>() / rows as f64).sqrt()
}

//! The papers' control experiments on our matched machines, through packed FMUs.

mod bed;
mod inverse;
mod p0;
mod p1;
mod p2;
mod p3;
mod p4;
mod single;

pub(crate) use bed::Bed;

use super::{Aim, Order, Reproduction, Row};
use crate::matching;

/// The papers with control experiments here.
pub(crate) const PAPERS: [&str; 5] = ["p0", "p1", "p2", "p3", "p4"];

/// Runs the control experiments of a paper; its match table comes first.
pub(crate) fn run(paper: &str, say: &dyn Fn(&str)) -> anyhow::Result<Reproduction> {
    let mut answer = match paper {
        "p0" => p0::run(say)?,
        "p1" => p1::run(say)?,
        "p2" => p2::run(say)?,
        "p3" => p3::run(say)?,
        "p4" => p4::run(say)?,
        other => {
            anyhow::bail!("no control experiments of \"{other}\"; there are {}", PAPERS.join(", "))
        }
    };
    let rig = if paper == "p4" { "evc-truth".to_owned() } else { format!("{paper}-truth") };
    judge_by_match(&rig, &mut answer)?;
    Ok(answer)
}

/// Puts the match table in front, and takes the verdicts back where the rig is not matched.
fn judge_by_match(rig: &str, answer: &mut Reproduction) -> anyhow::Result<()> {
    let figures = matching::figures()?;
    let own: Vec<_> = figures.iter().filter(|figure| figure.rig == rig).collect();
    let beyond: Vec<_> = own.iter().filter(|figure| figure.within == Some(false)).collect();
    let judged = own.iter().filter(|figure| figure.within.is_some()).count();
    let mut lines = vec![format!(
        "match of {rig}: {judged} figures of the machine without the paper's method, {} within 25 %, \
         {} not judged",
        judged - beyond.len(),
        own.len() - judged
    )];
    for figure in &own {
        if let Some(ours) = figure.ours {
            let (what, unit, paper) = (&figure.what, figure.unit, figure.paper);
            lines.push(format!("match: {what}: paper {paper} {unit}, ours {ours:.4} {unit}"));
        }
    }
    if !beyond.is_empty() {
        lines.push("the machine is not matched: no verdicts".into());
        for row in &mut answer.rows {
            row.verdict = super::Verdict::NotJudged;
        }
        answer.orders.clear();
    }
    lines.append(&mut answer.remarks);
    answer.remarks = lines;
    Ok(())
}

/// Root mean square of some axes' errors together, from row `from` on.
fn rms_of(errors: &[Vec<f64>], axes: &[usize], from: usize) -> f64 {
    let rows = errors.iter().map(Vec::len).min().unwrap_or(0).saturating_sub(from).max(1);
    let squares = axes.iter().flat_map(|axis| &errors[*axis][from..]).map(|e| e * e);
    (squares.sum::<f64>() / rows as f64).sqrt()
}

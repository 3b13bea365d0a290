//! Other ways inside the paper's method, and the loop as printed.

use super::super::Aim;
use super::super::Order;
use super::super::Reproduction;
use super::super::Row;
use super::super::bed::Bed;
use super::CASES;
use super::Case;
use super::FREQUENCY;
use super::GROWING;
use super::ID;
use super::Identified;
use super::OWN;
use super::PART;
use super::PERIOD;
use super::Parts;
use super::Spans;
use super::TURNS;
use super::controller;
use super::identified;
use super::identified_in;
use super::measured;
use super::reference;
use super::spans;
use super::worst;
use crate::Tool;
use crate::machines;
use anyhow::Context;
use control::Gains;
use data::Blueprint;
use std::f64::consts::TAU;
use std::path::Path;

/// Dynamic models that are identified in other ways, by what is other.
pub(super) type Tries = Vec<(&'static str, Blueprint)>;

pub(super) fn tries(
    tool: &Tool,
    bed: &mut Bed,
    folder: &Path,
    greatest: f64,
) -> anyhow::Result<Tries> {
    let model = "dynamic-prandtl-ishlinskii";
    // Of the log that the others are identified from.
    let finer = identified(tool, &folder.join("measured.csv"), model, "20")?;
    let only = folder.join("only");
    std::fs::create_dir_all(&only)?;
    let log = only.join("measured.csv");
    let rows = (12.0 / FREQUENCY / PERIOD).round() as usize;
    let wave = |part: f64| {
        move |k: usize| 0.5 * greatest * (1.0 - part * (TAU * FREQUENCY * PERIOD * k as f64).cos())
    };
    let loops = |scale: f64| {
        let large = (0..rows).map(wave(scale));
        large.chain((0..rows).map(wave(PART * scale))).collect::<Vec<f64>>()
    };
    // Both halves have both sizes, as identification fits on the first one.
    measured(bed, &[loops(1.0), loops(0.96)].concat(), &log)?;
    let fast = identified(tool, &log, model, "10")?;
    Ok(vec![("20 plays", finer), ("identified from loops of 100 Hz alone", fast)])
}

/// The paper's own method with these models, and without a lead in front of its inverse; printed gains.
pub(super) fn tried(
    bed: &Bed,
    tries: &Tries,
    (models, parts): (&Identified, Parts<'_>),
    (case, size): (&Case, &str),
    references: &[Vec<f64>],
    answer: &mut Reproduction,
) -> anyhow::Result<()> {
    let mut all: Vec<(&str, Parts<'_>)> = (tries.iter())
        .map(|(name, model)| (*name, Parts { model: Some(model), ..parts }))
        .collect();
    if !tries.is_empty() {
        let model = Some(&models.dynamic);
        all.push(("no lead in front of the inverse", Parts { model, leads: false, ..parts }));
    }
    for (name, parts) in all {
        let run = bed.track(&controller(&models.inverted, parts)?, references, PERIOD, 0)?;
        for ((axis, error), paper) in
            ["Y", "Z"].iter().zip(worst(&run, TURNS - GROWING)).zip(case.paper)
        {
            let what = format!("tried: {}, {size}, {name}, {axis}: greatest error", case.name);
            answer.rows.push(Row::new(ID, what, "um", paper, error, Aim::ForComparison));
        }
    }
    Ok(())
}

/// Greatest command in V of the printed ellipses, and their half spans on Y and Z in um: 1 to 6 and 1 to 11, 1 to 5 and 1 to 9.
pub(super) const RAISED: f64 = 150.0;

pub(super) const PRINTED: [[f64; 2]; 2] = [[2.5, 5.0], [2.0, 4.0]];

/// The ellipses as printed, 5 x 10 and 4 x 8 um, on the same machine whose commands may go up to 150 V, as the printed weights ask
/// for 147.6 V.
pub(super) fn as_printed(
    tool: &Tool,
    gains: [Gains; 2],
    answer: &mut Reproduction,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<()> {
    say("the printed ellipses, commands up to 150 V");
    let folder = tempfile::tempdir()?;
    let rig = rigs::find(machines::P4).context("a rig")?;
    let mut raised = Blueprint::parse(rig.blueprint, rig.name)?;
    for axis in &mut raised.axes {
        axis.command.max = Some(RAISED.into());
    }
    let file = folder.path().join("raised.toml");
    raised.write(&file)?;
    let mut bed = Bed::open(tool, &file)?;
    let models = identified_in(tool, &mut bed, folder.path(), RAISED)?;
    let tries = tries(tool, &mut bed, folder.path(), RAISED)?;
    let room = spans(&mut bed, RAISED)?;
    for (case, half) in CASES.iter().zip(PRINTED) {
        let references = reference(case, Spans { half, ..room }, TURNS);
        let size = format!("{:.0} x {:.0} um", 2.0 * half[0], 2.0 * half[1]);
        let mut found = Vec::new();
        for (name, model) in [
            (OWN, Some(&models.dynamic)),
            ("inverse static PI and PID, printed gains", Some(&models.plain)),
            ("PID alone, printed gains", None),
        ] {
            let parts = Parts { model, gains, greatest: RAISED, leads: true };
            let blueprint = controller(&models.inverted, parts)?;
            let run = bed.track(&blueprint, &references, PERIOD, 0)?;
            let errors = worst(&run, TURNS - GROWING);
            let reach = name == OWN;
            for ((axis, error), paper) in ["Y", "Z"].iter().zip(errors).zip(case.paper) {
                let what = format!("{}, {size}, {name}, {axis}: greatest error", case.name);
                let aim = if reach { Aim::Reach } else { Aim::ForComparison };
                answer.rows.push(Row::new(ID, what, "um", paper, error, aim));
            }
            if reach {
                let relative =
                    (0..2).map(|a| 100.0 * errors[a] / (2.0 * half[a])).fold(0.0, f64::max);
                let what = format!("{}, {size}, {name}: greatest error of range", case.name);
                answer.rows.push(Row::new(ID, what, "%", 6.2, relative, Aim::Reach));
                let last = run.command.iter().flat_map(|u| &u[u.len() / 2..]);
                let top = last.fold(0.0_f64, |top, u| top.max(*u));
                answer.remarks.push(format!("{}, {size}: commands up to {top:.1} V", case.name));
                answer.kept.run(&format!("{}-{size}", case.name), &run, PERIOD)?;
            }
            found.push(errors);
        }
        let parts = Parts { model: None, gains, greatest: RAISED, leads: true };
        tried(&bed, &tries, (&models, parts), (case, &size), &references, answer)?;
        let holds = (0..2).all(|axis| found[0][axis] < found[1][axis]);
        let what = format!(
            "{}, {size}, printed gains: the dynamic model's inverse better than the static one's",
            case.name
        );
        answer.orders.push(Order { paper_id: ID, what, holds });
    }
    Ok(())
}

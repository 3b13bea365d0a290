//! The printed calibration, and what goes beyond the paper.

use super::super::Aim;
use super::super::Order;
use super::super::Reproduction;
use super::super::Row;
use super::super::bed::Bed;
use super::super::learning::Learning;
use super::super::learning::learn as learn_passes;
use super::AXES;
use super::Design;
use super::GREATEST;
use super::ID;
use super::Inverse;
use super::NAMES;
use super::PASS_FROM;
use super::PASSES;
use super::PERIOD;
use super::RANGES;
use super::controller;
use super::errors;
use super::trajectory;
use crate::reproduce::figures::Chapter;
use crate::reproduce::figures::Runs;
use control::Calibration;
use control::Gains;

/// J as printed, in um per angle, and p0 in um.
pub(super) const PRINTED_J: [[f64; AXES]; AXES] = [
    [504.693, 3.33402, 0.0, 0.0],
    [14.4123, -515.344, 0.0, 0.0],
    [210.358, -12.0015, -129.337, 7.85753],
    [1.18470, 217.263, -3.04729, -142.002],
];

pub(super) const PRINTED_P0: [f64; AXES] = [-261.625, 272.281, -46.6467, -39.1210];

/// Entries of J from which on they are held against the paper's.
pub(super) const LARGE: f64 = 100.0;

pub(super) fn kinematics(calibration: &Calibration, answer: &mut Reproduction) {
    for ((fit, printed), offset) in calibration.coordinates.iter().zip(&PRINTED_J).zip(PRINTED_P0) {
        for ((name, paper), here) in NAMES.iter().zip(printed).zip(&fit.row) {
            let aim = if paper.abs() > LARGE { Aim::Baseline } else { Aim::ForComparison };
            let what = format!("calibrated J, {} by {name}", fit.coordinate);
            answer.rows.push(Row::new(ID, what, "um", *paper, *here, aim));
        }
        let what = format!("calibrated p0, {}", fit.coordinate);
        answer.rows.push(Row::new(ID, what, "um", offset, fit.offset, Aim::Baseline));
    }
    answer.remarks.push(format!(
        "calibration: condition number of J {:.2}, of the motions {:.2}, delay {:.2} rows; the angles \
         are normalised by each axis' own range, as in the paper, so J differs from the printed one by \
         the machine's own range",
        calibration.condition.unwrap_or(f64::NAN),
        calibration.motion_condition,
        calibration.delay
    ));
}

/// The printed gains in both readings of their unit, on system 2 at rate 1.
pub(super) fn printed(
    bed: &Bed,
    base: &Design<'_>,
    inverses: &[Inverse],
    calibration: &Calibration,
    answer: &mut Reproduction,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<()> {
    let references = trajectory(1)?;
    for (reading, unit) in [("command normalised to 1", GREATEST), ("command in V", 1.0)] {
        say(&format!("printed gains, {reading}"));
        let gains = Gains {
            kp: 4.5 * unit,
            ki: 0.4 * unit / PERIOD,
            kd: 4.0 * unit * PERIOD,
            derivative_filter: 0.0,
        };
        let blueprint = controller(&Design { gains, ..*base }, inverses, calibration)?;
        let run = bed.track(&blueprint, &references, PERIOD, 0)?;
        let swings = run.command[0][PASS_FROM..].windows(2).filter(|u| (u[1] - u[0]).abs() > 75.0);
        let part = 100.0 * swings.count() as f64 / (run.command[0].len() - PASS_FROM) as f64;
        let error = errors(&run, PASS_FROM);
        answer.remarks.push(format!(
            "printed gains 4.5, 0.4, 4.0, {reading}: the errors of system 2 at rate 1 are {:.1} % and {:.1} % of range; its command jumps by more than 75 V in {part:.0} % of the rows: {}",
            100.0 * error[0] / RANGES[0],
            100.0 * error[1] / RANGES[1],
            if part > 5.0 {
                "unstable on this machine"
            } else {
                "too slow to act within the pass"
            }
        ));
    }
    Ok(())
}

/// Learning over passes, beside the best of the paper's systems.
pub(super) fn beyond(
    bed: &Bed,
    (rate, best): (usize, [f64; 2]),
    both: &Design<'_>,
    inverses: &[Inverse],
    calibration: &Calibration,
    answer: &mut Reproduction,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<()> {
    let references = trajectory(rate)?;
    say(&format!("rate {rate}, beyond the paper: learning over {PASSES} passes"));
    let (lead, pass): (Vec<_>, Vec<_>) =
        references.iter().map(|r| (r[..PASS_FROM].to_vec(), r[PASS_FROM..].to_vec())).unzip();
    let learning = Learning {
        lead: &lead,
        pass: &pass,
        turns: 1,
        judged: pass[0].len(),
        period: PERIOD,
        preview: both.preview,
        passes: PASSES,
        probe: 0.01,
        band: 20.0,
    };
    let blueprint = controller(both, inverses, calibration)?;
    let learned = learn_passes(bed, &blueprint, &learning)?;
    answer.remarks.push(learned.described(&format!("rate {rate}")));
    let error = errors(&learned.run, learned.from);
    let seen = Runs {
        runs: vec![("system 4 and learning", &learned.run)],
        period: PERIOD,
        from: learned.from,
        unit: "um",
    };
    answer.chapters.push(
        Chapter::new(
            format!("learning at rate {rate}"),
            "Beyond the paper: passes with a learned correction of the reference; the last one is judged.",
        )
        .figure(seen.distances("Distance on PSD 1, pass by pass", [0, 1]))
        .figure(seen.distances("Distance on PSD 2, pass by pass", [2, 3])),
    );
    for psd in 0..2 {
        let what = format!("rate {rate}, beyond: system 4 and learning, PSD {}", psd + 1);
        let relative = 100.0 * error[psd] / RANGES[psd];
        answer.rows.push(Row::new(ID, what, "%", f64::NAN, relative, Aim::ForComparison));
        answer.orders.push(Order {
            paper_id: ID,
            what: format!(
                "rate {rate}, PSD {}: learning at least halves system 4's error ({:.2} times less)",
                psd + 1,
                best[psd] / error[psd]
            ),
            holds: 2.0 * error[psd] <= best[psd],
        });
    }
    let still = bed.track(
        &blueprint,
        &references.iter().map(|r| vec![r[PASS_FROM]; 1600]).collect::<Vec<_>>(),
        PERIOD,
        both.preview,
    )?;
    let floor = errors(&still, 1200);
    answer.remarks.push(format!(
        "noise floor, the same loop held at a point: {:.4} % on PSD 1, {:.4} % on PSD 2",
        100.0 * floor[0] / RANGES[0],
        100.0 * floor[1] / RANGES[1]
    ));
    Ok(())
}

//! Table 7 of the stop-operator paper: feedforward by the inverse LS-SVM, and with incremental PID.

use std::path::Path;

use control::Gains;
use data::{Blueprint, ComponentBlueprint};
use identify::learned::{
    Arx, Frame, Machine, Recipe, Run, SEED, Seek, Series, Span, Teaches, Waves, rms_difference,
};
use learned::features::{Features, Narx, StopOperators};
use learned::lssvm::Settings;
use model::Kind;

use super::bed::Bed;
use super::inverse::{Wanted, arx_component, hysteresis_inverse, learned_inverse};
use super::learning::{Learning, learn};
use super::single::{Design, impulse, is_unstable, rmse, ultimate, with_rest};
use super::{Aim, Effort, Order, Reproduction, Row};
use crate::Tool;
use crate::machines;
use crate::matching;
use crate::reproduce::figures::{Chapter, Runs, open_loop};
use crate::reproduce::p1::{
    Parts, RANGE, SETTINGS, STOPS, is_command, milliseconds, series, stops_and_rate, tuned,
};
use crate::reproduce::relays::Relays;

const ID: &str = "P1";
const PERIOD: f64 = 2e-3;
/// Greatest command of the paper, in V.
const GREATEST: f64 = 8.5;
const COMMAND: (f64, f64) = (-2.0, 12.0);
/// Rows of rest in front of each reference.
const REST: usize = 250;
/// For the inverse: no training signal is as large and as fast as the references, and where these fall to 0
/// the filter that is undone asks for less. The swing is the widest stop's.
const WAVES: Waves = Waves {
    count: 32,
    rows: 500,
    period: PERIOD,
    band: [1.0, 20.0],
    range: [-0.3, GREATEST - 0.3],
    seed: SEED,
};
/// Greatest |1/(1 + L)| of the robust gains.
const SENSITIVITY: f64 = 2.0;
/// Bandwidth of the disturbance observer in Hz.
const OBSERVED: f64 = 30.0;
/// Passes of the references that learn.
const PASSES: usize = 8;

/// The paper's own inverse: trained on the measured positions as inputs and the commands as outputs, settings as the
/// model's.
fn own_inverse(count: usize, runs: &[Run<'_>]) -> anyhow::Result<Machine> {
    let pairs: Vec<(&[f64], &[f64])> = runs.iter().map(|run| (run.position, run.command)).collect();
    let top = pairs.iter().flat_map(|(y, _)| *y).fold(0.0_f64, |top, y| top.max(y.abs()));
    let volts = Span { low: 0.0, high: GREATEST };
    let frame = stops_and_rate(count, (top, volts, PERIOD), &pairs);
    Ok(tuned(&frame, &pairs, Seek::Grid, Parts::InTurn)?.0)
}

/// Other ways inside the paper's method to train its inverse: how the samples are dealt out to the parts of the
/// cross-validation, and printed settings.
fn tried_inverses(
    runs: &[Run<'_>],
    tables: &mut Blueprint,
) -> anyhow::Result<Vec<(&'static str, ComponentBlueprint)>> {
    let pairs: Vec<(&[f64], &[f64])> = runs.iter().map(|run| (run.position, run.command)).collect();
    let top = pairs.iter().flat_map(|(y, _)| *y).fold(0.0_f64, |top, y| top.max(y.abs()));
    let volts = Span { low: 0.0, high: GREATEST };
    let frame = stops_and_rate(STOPS, (top, volts, PERIOD), &pairs);
    let [_, (_, gamma, sigma2)] = SETTINGS;
    let all = [
        ("in blocks", tuned(&frame, &pairs, Seek::Grid, Parts::Blocks)?.0),
        ("a part for each signal", tuned(&frame, &pairs, Seek::Grid, Parts::Signals)?.0),
        (
            "printed C and sigma by the swarm",
            Machine::train(frame.clone(), &pairs, Settings { gamma, sigma2 })?.0,
        ),
    ];
    let mut components = Vec::new();
    for (number, (name, machine)) in all.into_iter().enumerate() {
        components.push((name, learned_inverse(tables, &format!("tried{number}"), &machine)?));
    }
    Ok(components)
}

/// What else is played on E: how a reference becomes a command.
type Feedforward<'a> = (String, f64, Box<dyn Fn(&[f64]) -> Vec<f64> + 'a>);

/// Tables 6 and 7 on E: the inverse over fewer stop operators, that of NARX inputs, that of a Preisach model. Commands are played as
/// they follow from the reference, a row ahead.
fn on_e(
    bed: &mut Bed,
    (reference, part): (&[f64], f64),
    runs: &[Run<'_>],
    answer: &mut Reproduction,
) -> anyhow::Result<()> {
    let mut all: Vec<Feedforward<'_>> = Vec::new();
    for (count, paper, time) in TABLE_6 {
        let machine = own_inverse(count, runs)?;
        let step = milliseconds(reference.len(), &|| machine.simulate(reference, 0.0));
        let what = format!("time of a step of the inverse over {count} stop operators");
        answer.rows.push(Row::new(ID, what, "ms", time, step, Aim::ForComparison));
        let what = format!("inverse LS-SVM alone, {count} stop operators, E");
        all.push((what, paper, Box::new(move |r| machine.simulate(r, 0.0))));
    }
    let pairs: Vec<(&[f64], &[f64])> = runs.iter().map(|run| (run.position, run.command)).collect();
    let narx = Features::Narx(Narx { commands: 3, outputs: 3 });
    let volts = Span { low: 0.0, high: GREATEST };
    let narx = Frame::new(narx, Span::UNIT, volts, Recipe::Standardised, &pairs);
    let narx = tuned(&narx, &pairs, Seek::Grid, Parts::InTurn)?.0;
    all.push(("inverse NARX alone, E".into(), 0.1572, Box::new(move |r| narx.simulate(r, 0.0))));
    let forward: Vec<(&[f64], &[f64])> =
        runs.iter().map(|run| (run.command, run.position)).collect();
    let relays = Relays::fit(50, RANGE, &forward);
    let what = format!("inverse Preisach alone, {} relays, E", relays.count());
    all.push((what, 0.4981, Box::new(move |r| relays.inverse(r))));
    let from = (reference.len() as f64 * (1.0 - part)) as usize;
    for (what, paper, command) in all {
        // The command of a row leads to the position at its end.
        let ahead: Vec<f64> =
            (1..=reference.len()).map(|k| reference[k.min(reference.len() - 1)]).collect();
        let u: Vec<f64> =
            command(&ahead).into_iter().map(|u| u.clamp(COMMAND.0, COMMAND.1)).collect();
        let y = bed.response(0, &u, 0.0, PERIOD)?;
        let error = rms_difference(&y[from..reference.len()], &reference[from..]);
        answer.rows.push(Row::new(ID, what, "um", paper, error, Aim::ForComparison));
    }
    Ok(())
}

/// Number of stop operators, error on E in um and time of a step in ms.
const TABLE_6: [(usize, f64, f64); 3] =
    [(21, 0.0483, 0.55), (28, 0.0456, 0.84), (36, 0.0413, 1.21)];

pub(super) fn run(
    effort: Effort,
    tool: &Tool,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<Reproduction> {
    let mut bed = Bed::open(tool, Path::new(machines::P1))?;
    let mut answer = Reproduction::default();
    answer.kept.rig("plant", machines::P1)?;
    let mut record = |letter: char| -> anyhow::Result<(Vec<f64>, Vec<f64>)> {
        let (name, given) = machines::p1(letter);
        let (u, _) = matching::signal(&name, given)?;
        let y = bed.response(0, &u, 0.0, PERIOD)?;
        Ok((u, y))
    };
    let train = ['a', 'b', 'c'].into_iter().map(&mut record).collect::<Result<Vec<_>, _>>()?;
    let zero = train[0].1[0];
    let named: Vec<_> =
        ["A", "B", "C"].iter().zip(&train).map(|(name, (u, y))| (*name, &u[..], &y[1..])).collect();
    let text = "The machine under the training signals: its loop widens with the rate, most of it by the \
                anti-alias filter.";
    answer.chapters.push(Chapter::new("the machine", text).figure(open_loop(
        "Training signals",
        "um",
        &named,
    )));
    let runs: Vec<Run<'_>> = train
        .iter()
        .map(|(u, y)| Run {
            command: u,
            position: &y[1..],
            start: y[0],
            first: 0,
            teaches: Teaches::Both,
        })
        .collect();
    let quick = answer.leaves_out(effort, "our inverse, tables 6 and 7 on E, learning over passes");
    let mut tables = Blueprint::new(Kind::Controller, "tables", PERIOD);
    say("the paper's inverse, of measured positions");
    let own = own_inverse(STOPS, &runs)?;
    answer.remarks.push(format!(
        "the paper's inverse: {} support vectors over stop operators of the position, the position and its rate, trained on \
         the measured positions; its reference runs one row ahead too",
        own.machine.count()
    ));
    let printed_inverse = [learned_inverse(&mut tables, "own", &own)?];
    let tried_inverses = match quick {
        true => Vec::new(),
        false => {
            say("tried: other inverses");
            tried_inverses(&runs, &mut tables)?
        }
    };
    let inverse = match quick {
        true => None,
        false => Some(our_inverse(&runs, &mut tables, &mut answer, say)?),
    };
    let design = Design {
        period: PERIOD,
        command: COMMAND,
        start: zero,
        preview: 1,
        incremental: true,
        notch: None,
    };
    let response = impulse(&mut bed, [5.0, 0.5], PERIOD, 150, None)?;
    let gain: f64 = response.iter().sum();
    let printed = Gains { kp: 35.0, ki: 715.0, kd: 0.43, derivative_filter: 0.0 };
    let found = ultimate(&mut bed, [5.0, 0.5], PERIOD, None)?;
    let rules = control::ziegler_nichols(&found);
    let robust = control::robust(&response, PERIOD, SENSITIVITY, 20.0)?;
    for (name, gains) in [("printed", printed), ("Ziegler-Nichols", rules), ("robust", robust)] {
        let verdict = control::judge_loop(&response, PERIOD, &gains, false, &[5.0, 20.0]);
        answer.remarks.push(format!(
            "{name} gains kp {:.3} V/um, ki {:.2} V/(um s), kd {:.2e} V s/um: {}",
            gains.kp,
            gains.ki,
            gains.kd,
            if verdict.stable {
                format!(
                    "gain margin {:.2}, phase margin {:.0}°, |1/(1 + L)| {:.2} at 5 Hz and {:.2} at 20 Hz",
                    verdict.gain_margin,
                    verdict.phase_margin,
                    verdict.disturbance[0].1,
                    verdict.disturbance[1].1
                )
            } else {
                "unstable on this machine".into()
            }
        ));
    }
    answer.remarks.push(format!(
        "relay: K_u = {:.3} V/um, T_u = {:.4} s (the paper's gains follow from 58.33 and 0.0979 s, in a unit \
         that it does not state; the machine's gain is {gain:.3} um/V)",
        found.gain, found.period
    ));
    let paper_ff = [0.0258, 0.0361, 0.0236, 0.0415];
    let paper_both = [0.0214, 0.0267, 0.0195, 0.0250];
    answer.kept.blueprint("controller", design.controller(&tables, &printed_inverse, &robust));
    for (k, letter) in ['d', 'e', 'f', 'g'].into_iter().enumerate() {
        let upper = letter.to_ascii_uppercase();
        say(&format!("signal {upper}"));
        let (u, y) = {
            let (name, given) = machines::p1(letter);
            let (u, _) = matching::signal(&name, given)?;
            let y = bed.response(0, &u, 0.0, PERIOD)?;
            (u, y)
        };
        let (low, high) = matching::extremes(&u);
        let (y_low, y_high) = matching::extremes(&y);
        let scale = (y_high - y_low) / (high - low);
        let shape: Vec<f64> = u.iter().map(|x| y[0] + scale * (x - u[0])).collect();
        let reference = with_rest(&shape, REST);
        let part = shape.len() as f64 / reference.len() as f64;
        let none = Gains::default();
        let of = |parts: &[ComponentBlueprint], gains: &Gains| {
            let blueprint = design.controller(&tables, parts, gains);
            bed.track(&blueprint, std::slice::from_ref(&reference), PERIOD, design.preview)
        };
        let own_alone = of(&printed_inverse, &none)?;
        let own_compound = of(&printed_inverse, &robust)?;
        let tried = of(&printed_inverse, &printed)?;
        let own_printed = rmse(&tried, part);
        if is_unstable(&tried, COMMAND) && k == 0 {
            answer.remarks.push("printed gains, in V and um: unstable in the loop too".into());
        }
        let feedback_alone = of(&[], &robust)?;
        let feedback = rmse(&feedback_alone, part);
        // Alone, with the printed gains, re-tuned, and with a disturbance observer.
        let ours = match &inverse {
            None => None,
            Some(inverse) => {
                let (alone, tried) = (of(inverse, &none)?, of(inverse, &printed)?);
                Some([alone, tried, of(inverse, &robust)?, of(&observed(inverse), &none)?])
            }
        };
        let our_errors = ours.as_ref().map(|runs| runs.each_ref().map(|run| rmse(run, part)));
        let (own_ff, own_both) = (rmse(&own_alone, part), rmse(&own_compound, part));
        answer.kept.run(&format!("{upper}-inverse-alone"), &own_alone, PERIOD)?;
        answer.kept.run(&format!("{upper}-inverse-and-pid"), &own_compound, PERIOD)?;
        let mut played = vec![
            ("the paper's inverse alone", &own_alone),
            ("the paper's inverse and PID", &own_compound),
            ("PID alone", &feedback_alone),
        ];
        played.extend(ours.as_ref().map(|runs| ("our inverse and PID", &runs[2])));
        let seen = Runs { runs: played, period: PERIOD, from: REST, unit: "um" };
        answer.chapters.push(
            Chapter::new(
                format!("signal {upper}"),
                "Reference, position, error and command; position over reference is a line where the \
                 hysteresis is taken out.",
            )
            .figure(seen.straightness(format!("Position over reference, signal {upper}"), 0))
            .figure(seen.loops(format!("Position over command, signal {upper}"), 0))
            .figure(seen.tracking(format!("Signal {upper}"), 0)),
        );
        // Ours is over stop operators with the linear part undone in front.
        let mut row = |what: &str, paper: f64, own: f64, number: usize, aim: Aim| {
            let row = Row::new(ID, format!("{what}, {upper}"), "um", paper, own, aim);
            answer.rows.push(Row { ours: our_errors.map(|errors| errors[number]), ..row });
        };
        row("inverse LS-SVM alone", paper_ff[k], own_ff, 0, Aim::Reach);
        let what = "inverse LS-SVM and incremental PID, printed gains";
        row(what, paper_both[k], own_printed, 1, Aim::ForComparison);
        let what = "inverse LS-SVM and incremental PID, re-tuned";
        row(what, paper_both[k], own_both, 2, Aim::Reach);
        let what = format!("incremental PID alone, re-tuned, {upper}");
        answer.rows.push(Row::new(ID, what, "um", f64::NAN, feedback, Aim::ForComparison));
        for (name, inverse) in &tried_inverses {
            for (with, gains, paper) in
                [("alone", &none, paper_ff[k]), ("and PID", &robust, paper_both[k])]
            {
                let error = rmse(&of(std::slice::from_ref(inverse), gains)?, part);
                let what = format!("tried: inverse LS-SVM {with}, {name}, {upper}");
                answer.rows.push(Row::new(ID, what, "um", paper, error, Aim::ForComparison));
            }
        }
        if !quick {
            for sensitivity in [1.3, 3.0] {
                let gains = control::robust(&response, PERIOD, sensitivity, 20.0)?;
                let error = rmse(&of(&printed_inverse, &gains)?, part);
                let what = format!(
                    "tried: inverse LS-SVM and PID, gains for a sensitivity of {sensitivity}, {upper}"
                );
                answer.rows.push(Row::new(
                    ID,
                    what,
                    "um",
                    paper_both[k],
                    error,
                    Aim::ForComparison,
                ));
            }
        }
        let mut order = |what: &str, holds: bool| {
            answer.orders.push(Order { paper_id: ID, what: format!("{what}, {upper}"), holds });
        };
        order("with PID better than the inverse alone", own_both < own_ff);
        order("with the inverse better than PID alone", own_both < feedback);
        let (Some(inverse), Some([feedforward, _, both, watched])) = (&inverse, our_errors) else {
            continue;
        };
        order("ours: with PID better than the inverse alone", both < feedforward);
        order("ours: with the inverse better than PID alone", both < feedback);
        let what = format!("beyond: inverse LS-SVM and disturbance observer, {upper}");
        answer.rows.push(Row::of_ours(ID, what, "um", paper_both[k], watched));
        if letter == 'e' {
            say("tables 6 and 7 on E");
            on_e(&mut bed, (&reference, part), &runs, &mut answer)?;
        }
        // The shape again and again, joined where it ends.
        say(&format!("signal {upper}, beyond the paper: learning over {PASSES} passes"));
        let mut complete = shape.clone();
        let join = 50;
        let (from, to) = (shape[shape.len() - 1], shape[0]);
        for n in 1..=join {
            let x = n as f64 / (join + 1) as f64;
            complete.push(from + (to - from) * x * x * (3.0 - 2.0 * x));
        }
        let learning = Learning {
            lead: &[vec![shape[0]; REST]],
            pass: std::slice::from_ref(&complete),
            turns: 1,
            judged: shape.len(),
            period: PERIOD,
            preview: design.preview,
            passes: PASSES,
            probe: 0.01,
            band: 200.0,
        };
        let blueprint = design.controller(&tables, inverse, &robust);
        let run = learn(&bed, &blueprint, &learning)?;
        answer.remarks.push(run.described(&format!("signal {upper}")));
        let learned = run.errors[run.errors.len() - 1];
        let what = format!("beyond: with learning over passes, {upper}");
        answer.rows.push(Row::of_ours(ID, what, "um", paper_both[k], learned));
        answer.orders.push(Order {
            paper_id: ID,
            what: format!(
                "learning at least halves the paper's best row, {upper} ({:.1} times less; {:.1} times less than \
                 the paper's way on this machine)",
                paper_both[k] / learned,
                own_both / learned
            ),
            holds: paper_both[k] >= 2.0 * learned,
        });
    }
    answer.remarks.push(
        "references have the shapes of the signals, over the range that the position has under them; signals C, F and G are assumed, as the paper gives their bands only"
            .into(),
    );
    Ok(answer)
}

/// Our inverse: the linear part undone, then an inverse over stop operators.
fn our_inverse(
    runs: &[Run<'_>],
    tables: &mut Blueprint,
    answer: &mut Reproduction,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<[ComponentBlueprint; 2]> {
    let (forward, described) = series(runs, PERIOD, say)?;
    answer.remarks.push(described);
    say("inverse LS-SVM over 55 stop operators");
    let (machine, before) = inverted(&forward, runs)?;
    let first = runs[0].command;
    let simulated = forward.machine.simulate(first, runs[0].start);
    answer.remarks.push(format!(
        "our inverse: {} support vectors, trained on what the forward model simulates of the training signals and of {} \
         waves of 1 to 20 Hz over its range; its error is {:.4} V on signal A. The linear part is compensated before it. The reference runs one row ahead, so that the \
         command of a row leads to the position at its end",
        machine.machine.count(),
        WAVES.count,
        rms_difference(&machine.simulate(&simulated, 0.0), first)
    ));
    Ok([arx_component(&before, PERIOD), learned_inverse(tables, "inverse", &machine)?])
}

/// A disturbance observer in front of the inverse, behind which the machine is a sample late.
fn observed(inverse: &[ComponentBlueprint]) -> Vec<ComponentBlueprint> {
    let observer = ComponentBlueprint::new("disturbance-observer")
        .value("bandwidth", OBSERVED)
        .value("limit", 2.0);
    [&[observer], inverse].concat()
}

/// The inverse of a hysteresis and of its linear part: the first learned from samples that the forward model
/// simulates, the second exact.
fn inverted(forward: &Series, runs: &[Run<'_>]) -> anyhow::Result<(Machine, Arx)> {
    let commands: Vec<&[f64]> = runs.iter().map(|run| run.command).collect();
    let wanted = Wanted {
        stops: StopOperators::new(STOPS, 0.0, PERIOD),
        span: Span { low: 0.0, high: GREATEST },
        waves: WAVES,
        group: &is_command,
        begin: (&[30.0, 0.05], 1e5),
    };
    let machine = hysteresis_inverse(&forward.machine, runs[0].start, &commands, &wanted)?;
    let before = forward.linear.inverse();
    anyhow::ensure!(before.is_stable(), "the linear part has no stable inverse");
    Ok((machine, before))
}

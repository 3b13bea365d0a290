//! Tables 2 and 3 of the Gaussian process paper: inverse compensator open loop, and with PI.

mod printed;

use std::path::Path;

use anyhow::Context;
use control::Gains;
use data::{Blueprint, ComponentBlueprint};
use identify::learned::{Frame, Machine, Recipe, SEED, Search, Span, Waves, rms_difference};
use learned::features::{Derivatives, Features, StopOperators};
use model::Kind;

use self::printed::{Printed, TESTS, Test};
use super::bed::{Bed, Tracked};
use super::inverse::{Wanted, arx_component, hysteresis_inverse, learned_inverse, linear};
use super::learning::{Learning, learn};
use super::single::{Design, is_unstable};
use super::{Aim, Effort, Order, Reproduction, Row};
use crate::Tool;
use crate::keep::UNITS;
use crate::machines;
use crate::matching::{self, Response};
use crate::reproduce::figures::{Chapter, Runs, open_loop};
use crate::reproduce::p3::{COUNT, SEARCH, Training, group, series, top};

const ID: &str = "P3";
const PERIOD: f64 = 50e-6;
const COMMAND: (f64, f64) = (-1.0, 10.0);
const AMPLIFIER: f64 = 15.0;
const RANGE: f64 = 10.0;
const HALF: usize = 3;
const CUTOFF: f64 = 0.25;
/// Rows of one pass of the learning, and passes that learn.
const PASS: usize = 800;
const PASSES: usize = 8;
/// Centres that a step has time for.
const CENTRES: usize = 600;

// One of the printed figures is 6.28.
/// References of a quick reproduction.
const QUICK: [&str; 3] = ["100 Hz", "1 kHz", "four tones"];

/// How the compensators are trained: behind the first rise, below which no compensator without memory knows a way.
const OWN: Training = Training { settled: true, on_a_line: false, one_length: false, half: HALF };
/// Other ways inside the paper's method, and on which references they are tried.
const TRIED: [(&str, Training); 4] = [
    ("one length for all inputs", Training { one_length: true, ..OWN }),
    ("on the whole chirp", Training { settled: false, ..OWN }),
    ("no low-pass", Training { half: 0, ..OWN }),
    ("on the whole chirp, no low-pass", Training { settled: false, half: 0, ..OWN }),
];
const TRIED_ON: [&str; 5] = ["100 Hz", "200 Hz", "300 Hz", "400 Hz", "four tones"];

/// The inverse compensator of this many inputs.
fn trained(dimension: usize, u: &[f64], y: &[f64], way: Training) -> anyhow::Result<Machine> {
    let derivatives =
        Derivatives::new(dimension, way.half, CUTOFF, [1.0; 4]).context("a dimension")?;
    let peak = if way.settled { top(y) } else { 0 };
    let (y, u) = (&y[peak..], &u[peak..]);
    let pairs = [(y, u)];
    let features = Features::Derivatives(derivatives);
    // The component holds its command within twice the output's span.
    let frame = Frame::new(features, Span::UNIT, Span::of(u), Recipe::Standardised, &pairs);
    let samples = frame.samples(&pairs)?;
    let process = way.process(&samples, &Search { signal: 2.0, ..SEARCH })?;
    let complete = Machine::of_process(frame, &process);
    let own = rms_difference(&complete.simulate(y, u[0]), u);
    Ok(complete.compress(&pairs, CENTRES, 1.05 * own).unwrap_or(complete))
}

/// For the inverse over stop operators: the band of the chirp, over its range.
const WAVES: Waves = Waves {
    count: 24,
    rows: 600,
    period: PERIOD,
    band: [50.0, 1000.0],
    range: [0.0, 2.0],
    seed: SEED,
};
/// Of the inverse's rate of the position, in um/s.
const RATE: f64 = 16_000.0;
/// Most rows that the inverse's linear part may look ahead.
const AHEAD: usize = 6;

/// The inverse of the model with memory: rows that the reference runs ahead, and its parts.
fn of_stops(chirp: &Response, tables: &mut Blueprint) -> anyhow::Result<(Inverse, String)> {
    let (forward, _) = series(chirp)?;
    let wanted = Wanted {
        stops: StopOperators::new(COUNT, 0.0, PERIOD).rated(RATE),
        span: Span { low: 0.0, high: 2.0 },
        waves: WAVES,
        group: &group,
        begin: (&[100.0, 1.0, 2.0], 1e5),
    };
    let start = chirp.position[0];
    let machine = hysteresis_inverse(&forward.machine, start, &[&chirp.command], &wanted)?;
    let inner = forward.machine.simulate(&chirp.command, start);
    let cancelled = linear(chirp.after(), &inner, PERIOD, AHEAD).context("no linear part")?;
    let described = format!(
        "inverse over stop operators: {} support vectors; the linear part is undone {} rows ahead, within {:.4} um",
        machine.machine.count(),
        cancelled.ahead,
        cancelled.error
    );
    let parts =
        vec![arx_component(&cancelled.arx, PERIOD), learned_inverse(tables, "stops", &machine)?];
    Ok(((cancelled.ahead + 1, parts), described))
}

/// The inverse of the paper's baseline.
fn of_mpi(chirp: &Response) -> anyhow::Result<ComponentBlueprint> {
    let plant = matching::p3::mpi(chirp)?;
    // What declares an inverse is the hysteresis; its blueprint stands at the same place.
    let mut nodes =
        plant.spec().axes[0].components.iter().zip(&plant.blueprint().axes[0].components);
    let cancelled = |node: &model::NodeSpec| node.component.inverses().first().copied();
    let found = nodes.find_map(|(node, own)| cancelled(node).map(|inverse| (own.clone(), inverse)));
    let (mut inverse, undoing) = found.context("an MPI model with an inverse")?;
    inverse.kind = undoing.kind.into();
    let ends = [("command_min", COMMAND.0), ("command_max", COMMAND.1)];
    Ok(ends.into_iter().fold(inverse, |inverse, (name, end)| inverse.value(name, end)))
}

/// Rows that the reference runs ahead, and components.
type Inverse = (usize, Vec<ComponentBlueprint>);

/// PI with these gains, behind a compensator where there is one.
fn control(tables: &Blueprint, start: f64, inverse: Option<&Inverse>, gains: &Gains) -> Blueprint {
    let preview = inverse.map_or(0, |(ahead, _)| *ahead);
    let design = Design {
        period: PERIOD,
        command: COMMAND,
        start,
        preview,
        incremental: false,
        notch: None,
    };
    design.controller(tables, inverse.map_or(&[][..], |(_, parts)| parts), gains)
}

/// Numbers of inputs of the compensators.
const DIMENSIONS: [usize; 4] = [2, 6, 9, 12];

/// Compensators in the order of the paper's tables, and ours behind them.
struct Compensators {
    /// MPI; 2, 6, 9, 12 inputs.
    printed: Vec<Inverse>,
    /// Over stop operators.
    stops: Option<Inverse>,
}

/// Errors of a loop in percent of the reference's span: rms and greatest.
fn percent(run: &Tracked, from: usize, reach: f64) -> Printed {
    let greatest = run.error[0][from..].iter().fold(0.0_f64, |top, e| top.max(e.abs()));
    [100.0 * super::rms_of(&run.error, &[0], from) / reach, 100.0 * greatest / reach]
}

/// What a reference is played over.
struct Stage {
    zero: f64,
    /// Lowest point of the references, and their span.
    bottom: f64,
    reach: f64,
}

pub(super) fn run(
    effort: Effort,
    tool: &Tool,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<Reproduction> {
    let mut bed = Bed::open(tool, Path::new(machines::P3))?;
    let mut answer = Reproduction::default();
    answer.kept.rig("plant", machines::P3)?;
    let (u, _) = matching::signal("p3-chirp", &[])?;
    let u: Vec<f64> = u.iter().map(|u| u / AMPLIFIER).collect();
    let y = bed.response(0, &u, 0.0, PERIOD)?;
    answer.chapters.push(
        Chapter::new("the machine", "The stage under the training chirp of 25 to 1025 Hz.")
            .figure(open_loop("Training chirp", "um", &[("machine", &u, &y[1..])])),
    );
    let (zero, full) = (bed.rest(&[0.0], PERIOD)?[0], bed.rest(&[RANGE], PERIOD)?[0]);
    // The loops of the chirp behind its first rise: below them no compensator without memory knows a way.
    let (low, high) = matching::extremes(&y[top(&y)..]);
    let stage = Stage { zero, bottom: low + 0.02 * (high - low), reach: 0.95 * (high - low) };
    // V per um, as command and position are scaled equally in the paper.
    let scale = RANGE / (full - zero);
    let mut tables = Blueprint::new(Kind::Controller, "tables", PERIOD);
    let chirp = Response { command: u.clone(), position: y.clone(), period: PERIOD };
    answer.kept.record("chirp", UNITS, &chirp, None)?;
    let mut printed: Vec<Inverse> = vec![(1, vec![of_mpi(&chirp)?])];
    let few = answer.leaves_out(
        effort,
        "compensators of 6 and 9 inputs and ours over stop operators, ten of the thirteen references, learning over passes",
    );
    for dimension in DIMENSIONS {
        if few && (dimension == 6 || dimension == 9) {
            continue;
        }
        say(&format!("inverse compensator of {dimension} inputs"));
        let machine = trained(dimension, &u, &y[1..], OWN)?;
        answer.remarks.push(format!(
            "inverse of {dimension} inputs: {} centres; late by {} rows, which the reference runs ahead",
            machine.machine.count(),
            machine.frame.features.delay() + 1
        ));
        let delay = machine.frame.features.delay();
        let inverse = learned_inverse(&mut tables, &format!("gp{dimension}"), &machine)?;
        printed.push((delay + 1, vec![inverse]));
    }
    let stops = match few {
        true => None,
        false => {
            say("inverse over stop operators");
            let (stops, described) = of_stops(&chirp, &mut tables)?;
            answer.remarks.push(described);
            Some(stops)
        }
    };
    let all = Compensators { printed, stops };
    let gains = Gains { kp: 0.3 * scale, ki: 20_000.0 * scale, kd: 0.0, derivative_filter: 0.0 };
    if let Some(own) = all.printed.last() {
        answer.kept.blueprint("controller", control(&tables, zero, Some(own), &gains));
    }
    for test in TESTS.iter().filter(|test| !few || QUICK.contains(&test.name)) {
        say(test.name);
        tracked(&bed, test, (&tables, &all, &gains), (&stage, few), &mut answer)?;
    }
    if !few {
        tried(&bed, &stage, (&u, &y[1..]), &mut answer, say)?;
    }
    if let Some(stops) = &all.stops {
        let still = bed.track(
            &control(&tables, zero, Some(stops), &gains),
            &[vec![stage.bottom + 0.5 * stage.reach; PASS]],
            PERIOD,
            stops.0,
        )?;
        answer.remarks.push(format!(
            "noise floor, the loop of the learning held at a point: {:.4} % of {:.2} um",
            100.0 * super::rms_of(&still.error, &[0], PASS / 2) / stage.reach,
            stage.reach
        ));
    }
    answer.remarks.push(format!(
        "references span {:.2} to {:.2} um: the loops of the training chirp of 30 V on this machine, without its \
         first rise",
        stage.bottom,
        stage.bottom + stage.reach
    ));
    answer.remarks.push(
        "the paper only cites the plays of its MPI model: those of Al Janaideh and Krejci are used. With a preview of the reference, a compensator in the loop has a smaller error than in the paper, which had none"
            .into(),
    );
    Ok(answer)
}

/// The compensator of 12 inputs trained in other ways, without PI.
fn tried(
    bed: &Bed,
    stage: &Stage,
    (u, y): (&[f64], &[f64]),
    answer: &mut Reproduction,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<()> {
    for (way, training) in TRIED {
        say(&format!("tried: 12 inputs, {way}"));
        let machine = trained(12, u, y, training)?;
        let ahead = machine.frame.features.delay() + 1;
        let mut tables = Blueprint::new(Kind::Controller, "tables", PERIOD);
        let inverse = (ahead, vec![learned_inverse(&mut tables, "tried", &machine)?]);
        let blueprint = control(&tables, stage.zero, Some(&inverse), &Gains::default());
        for test in TESTS.iter().filter(|test| TRIED_ON.contains(&test.name)) {
            let (reference, scaled) = reference(test, stage)?;
            let run = bed.track(&blueprint, &[reference], PERIOD, ahead)?;
            let [error, _] = percent(&run, 400 + scaled.len() / 3, stage.reach);
            let what = format!("tried: open loop, 12 inputs, {way}, {}", test.name);
            answer.rows.push(Row::new(ID, what, "%", test.open[4][0], error, Aim::ForComparison));
        }
    }
    Ok(())
}

/// The reference of a test from rest: the first row at the bottom, a quarter wave of rise, then the signal; and the signal.
fn reference(test: &Test, stage: &Stage) -> anyhow::Result<(Vec<f64>, Vec<f64>)> {
    let (shape, _) = matching::signal(test.signal, test.settings)?;
    let (low, high) = matching::extremes(&shape);
    let scaled: Vec<f64> =
        shape.iter().map(|x| stage.bottom + stage.reach * (x - low) / (high - low)).collect();
    let rise = (0..400).map(|n| {
        let x = f64::from(n) / 400.0;
        stage.zero + (scaled[0] - stage.zero) * x * x * (3.0 - 2.0 * x)
    });
    Ok((rise.chain(scaled.iter().copied()).collect(), scaled))
}

/// All controllers on one reference.
fn tracked(
    bed: &Bed,
    test: &Test,
    (tables, all, printed): (&Blueprint, &Compensators, &Gains),
    (stage, few): (&Stage, bool),
    answer: &mut Reproduction,
) -> anyhow::Result<()> {
    let (name, reach) = (test.name, stage.reach);
    let (reference, scaled) = reference(test, stage)?;
    let from = 400 + scaled.len() / 3;
    let of = |inverse: Option<&Inverse>, gains: &Gains| {
        let preview = inverse.map_or(0, |(ahead, _)| *ahead);
        let blueprint = control(tables, stage.zero, inverse, gains);
        bed.track(&blueprint, std::slice::from_ref(&reference), PERIOD, preview)
    };
    let none = Gains::default();
    let alone = of(None, printed)?;
    if is_unstable(&alone, COMMAND) {
        answer.remarks.push(format!("{name}: PI with the printed gains is unstable here"));
    }
    let runs = |gains: &Gains| -> anyhow::Result<Vec<Tracked>> {
        all.printed.iter().chain(&all.stops).map(|inverse| of(Some(inverse), gains)).collect()
    };
    let (open_runs, closed_runs) = (runs(&none)?, runs(printed)?);
    let errors = |runs: &[Tracked]| -> Vec<Printed> {
        runs.iter().map(|run| percent(run, from, reach)).collect()
    };
    let (open, closed) = (errors(&open_runs), errors(&closed_runs));
    // MPI, then the processes of so many inputs; ours is the last.
    let own = all.printed.len() - 1;
    let ours = all.stops.is_some().then_some(own + 1);
    let kept = format!("{name}-12-inputs");
    answer.kept.run(&format!("open-{kept}"), &open_runs[own], PERIOD)?;
    answer.kept.run(&format!("closed-{kept}"), &closed_runs[own], PERIOD)?;
    let mut played = vec![
        ("PI alone", &alone),
        ("12 inputs, open loop", &open_runs[own]),
        ("12 inputs and PI", &closed_runs[own]),
    ];
    played.extend(ours.map(|ours| ("stops and PI", &closed_runs[ours])));
    let seen = Runs { runs: played, period: PERIOD, from, unit: "um" };
    answer.chapters.push(
        Chapter::new(name, "Position over reference and over command, errors, tracking.")
            .figure(seen.straightness(format!("Position over reference, {name}"), 0))
            .figure(seen.loops(format!("Position over command, {name}"), 0))
            .figure(seen.tracking(format!("Tracking, {name}"), 0)),
    );
    let alone = percent(&alone, from, reach);
    let measures = ["", ", greatest error"];
    // Columns of the paper that were played, in its order.
    let column = |number: usize| match (number, few) {
        (0, _) => Some(0),
        (1, true) => Some(1),
        (4, true) => Some(2),
        (_, true) => None,
        (number, false) => Some(number),
    };
    let named = |number: usize| match number {
        0 => "MPI".to_owned(),
        number => format!("{} inputs", DIMENSIONS[number - 1]),
    };
    for (measure, of) in measures.iter().enumerate() {
        let mut row = |what: &str, paper: f64, here: f64, aim: Aim| {
            answer.rows.push(Row::new(ID, format!("{what}, {name}{of}"), "%", paper, here, aim));
        };
        row("PI alone", test.closed[0][measure], alone[measure], Aim::Baseline);
        for number in 0..test.open.len() {
            let Some(here) = column(number) else { continue };
            let aim = if number == 4 { Aim::Reach } else { Aim::ForComparison };
            let what = named(number);
            row(
                &format!("open loop, {what}"),
                test.open[number][measure],
                open[here][measure],
                aim,
            );
            let paper = test.closed[number + 1][measure];
            row(&format!("closed loop, {what}"), paper, closed[here][measure], aim);
        }
        let mut row = |what: &str, paper: f64, here: f64| {
            let what = format!("{what}, {name}{of}");
            answer.rows.push(Row::of_ours(ID, what, "%", paper, here));
        };
        if let Some(ours) = ours {
            row("open loop, stops", test.open[4][measure], open[ours][measure]);
            row("closed loop, stops", test.closed[5][measure], closed[ours][measure]);
        }
    }
    let mut order = |what: &str, here: (f64, f64), paper: (f64, f64)| {
        answer.orders.push(Order::of_numbers(ID, format!("{what}, {name}"), here, paper));
    };
    let (best, two, mpi) = (closed[own][0], closed[1][0], closed[0][0]);
    let paper = test.closed.map(|[rms, _]| rms);
    order("closed loop: 12 inputs better than PI alone", (best, alone[0]), (paper[5], paper[0]));
    order("closed loop: 12 inputs better than 2", (best, two), (paper[5], paper[2]));
    order("closed loop: 12 inputs better than MPI", (best, mpi), (paper[5], paper[1]));
    order("closed loop: MPI better than PI alone", (mpi, alone[0]), (paper[1], paper[0]));
    let paper = test.open.map(|[rms, _]| rms);
    order("open loop: 12 inputs better than 2", (open[own][0], open[1][0]), (paper[4], paper[1]));
    order("open loop: 12 inputs better than MPI", (open[own][0], open[0][0]), (paper[4], paper[0]));
    if let (true, Some(stops)) = (test.learns, &all.stops) {
        let learning = Learning {
            lead: &[reference[..400].to_vec()],
            pass: &[scaled[..PASS].to_vec()],
            turns: 1,
            judged: PASS,
            period: PERIOD,
            preview: stops.0,
            passes: PASSES,
            probe: 0.01,
            band: 4000.0,
        };
        let both = control(tables, stage.zero, Some(stops), printed);
        let learned = learn(bed, &both, &learning)?;
        answer.remarks.push(learned.described(name));
        let learned = 100.0 * learned.errors[learned.errors.len() - 1] / reach;
        let paper = test.closed[5][0];
        let what = format!("beyond: closed loop, stops and learning, {name}");
        answer.rows.push(Row::of_ours(ID, what, "%", paper, learned));
        let what = format!(
            "learning at least halves the paper's best row ({:.1} times less; {:.1} times less than the 12 inputs on \
             this machine), {name}",
            paper / learned,
            best / learned
        );
        answer.orders.push(Order { paper_id: ID, what, holds: paper >= 2.0 * learned });
    }
    Ok(())
}

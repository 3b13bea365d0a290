//! Laser beam pointing: LS-SVM hysteresis with NARX inputs, pruned, and a linear part behind it.

mod method;
mod tried;

use anyhow::Context;
use identify::learned::{
    Arx, Machine, Run, SEED, Span, SyntheticData, Teaches, Waves, rms_difference,
};
use learned::lssvm::{LsSvm, Pruning, prune};

pub(super) use self::method::stops;
use self::method::{Method, OWN, PERIOD, narx, narx_in_simulation, stops_in_turn};
use self::tried::tried;
use super::control::{Linear, linear};
use super::figures::{self, Chapter};
use super::{Aim, Effort, Order, Reproduction, Row};
use crate::machines;
use crate::matching::baseline::{self, Baseline};
use crate::matching::{Response, driven};

const ID: &str = "P0";
const LEAST: usize = 40;
/// Orders of the paper's linear part.
const ZEROS: usize = 2;
const POLES: usize = 3;
/// These, or smaller ones where those are not stable.
const ORDERS: [(usize, usize); 5] = [(ZEROS, POLES), (2, 2), (1, 1), (0, 1), (0, 0)];

/// A record as normalised command and normalised angle.
struct Record {
    u: Vec<f64>,
    theta: Vec<f64>,
    theta0: f64,
}

impl Record {
    /// The record as a response.
    fn response(&self) -> Response {
        let position = std::iter::once(self.theta0).chain(self.theta.iter().copied()).collect();
        Response { command: self.u.clone(), position, period: PERIOD }
    }

    /// Every so many rows: the command of the first, and the angle at the end of the last.
    fn every(&self, rows: usize) -> Self {
        let ends = self.theta.chunks_exact(rows).map(|chunk| chunk[rows - 1]);
        let u = self.u.chunks_exact(rows).map(|chunk| chunk.iter().sum::<f64>() / rows as f64);
        Self { u: u.collect(), theta: ends.collect(), theta0: self.theta0 }
    }

    fn run(&self, teaches: Teaches) -> Run<'_> {
        let (command, position) = (&self.u[..], &self.theta[..]);
        Run { command, position, start: self.theta0, first: 0, teaches }
    }
}

struct Records {
    train_h: Record,
    train_d: Record,
    tests: [Record; 2],
}

/// θ = (d − d_min)/(d_max − d_min) with the extremes of the training signal, rising with the command.
fn records() -> anyhow::Result<Records> {
    let train = driven(machines::P0, "p0-train-h", &[], 1.0)?;
    let rising = train.position[train.position.len() / 20] > train.position[0];
    let sign = if rising { 1.0 } else { -1.0 };
    let signed: Vec<f64> = train.position.iter().map(|d| sign * d).collect();
    let span = Span::of(&signed);
    let record = |response: Response| {
        let theta = |d: &f64| (sign * d - span.low) / (span.high - span.low);
        Record {
            u: response.command.iter().map(|u| u / 150.0).collect(),
            theta: response.after().iter().map(theta).collect(),
            theta0: theta(&response.position[0]),
        }
    };
    let of = |name: &str| driven(machines::P0, name, &[], 1.0).map(record);
    Ok(Records {
        train_d: of("p0-train-d")?,
        tests: [of("p0-test-1")?, of("p0-test-2")?],
        train_h: record(train),
    })
}

fn percent(a: &[f64], b: &[f64]) -> f64 {
    100.0 * rms_difference(a, b)
}

/// A hysteresis with its linear part.
struct Model {
    hysteresis: Machine,
    linear: Arx,
}

impl Model {
    /// `from` is what comes in, `to` what goes out, of the record for the linear part.
    fn new(hysteresis: Machine, from: &[f64], to: &[f64], to0: f64) -> anyhow::Result<Self> {
        let h = hysteresis.simulate(from, to0);
        let fits = ORDERS.iter().filter_map(|(zeros, poles)| Arx::fit(&h, to, *zeros, *poles).ok());
        let linear = fits.into_iter().find(Arx::is_stable);
        Ok(Self { hysteresis, linear: linear.context("no stable linear part")? })
    }

    fn simulate(&self, from: &[f64], to0: f64) -> Vec<f64> {
        self.linear.simulate(&self.hysteresis.simulate(from, to0), to0)
    }

    fn error(&self, from: &[f64], to: &[f64], to0: f64) -> f64 {
        percent(&self.simulate(from, to0), to)
    }

    /// Without the linear part.
    fn error_without(&self, from: &[f64], to: &[f64], to0: f64) -> f64 {
        percent(&self.hysteresis.simulate(from, to0), to)
    }
}

/// What a method leaves, in percent.
struct Left {
    unpruned: f64,
    pruned: f64,
    without: f64,
    with: f64,
    tests: [f64; 2],
    /// Without and with the linear part on the frequency-varying signal, then the tests.
    inverse: [f64; 4],
    /// The inverse learned from simulated and from measured angles, on signal H.
    from: [f64; 2],
}

pub(super) fn run(effort: Effort, say: &(dyn Fn(&str) + Sync)) -> anyhow::Result<Reproduction> {
    let records = records()?;
    let mut answer = Reproduction::default();
    let quick = answer.leaves_out(
        effort,
        "cross-validation by blocks (figure 8a), ours over stop operators, what was tried",
    );
    let other = match quick {
        true => None,
        false => {
            let blocks = narx(&records, &mut answer, say)?;
            Some(forward(&blocks, &records, &mut answer, say)?)
        }
    };
    let simulated = narx_in_simulation(&records, &mut answer, say)?;
    let own = forward(&simulated, &records, &mut answer, say)?;
    let ours = match quick {
        true => None,
        false => Some(forward(&stops_in_turn(&records, say)?, &records, &mut answer, say)?),
    };
    let mut rows = Vec::new();
    let beside = |row: Row, of: &dyn Fn(&Left) -> f64| Row {
        ours: ours.as_ref().map(of),
        other: other.as_ref().map(of),
        ..row
    };
    let mut add_row = |what: &str, paper: f64, of: &dyn Fn(&Left) -> f64, aim: Aim| {
        rows.push(beside(Row::new(ID, what, "%", paper, of(&own), aim), of));
    };
    add_row("unpruned, training signal H", 0.426, &|l| l.unpruned, Aim::Reach);
    add_row("without D, frequency-varying", 2.25, &|l| l.without, Aim::Baseline);
    add_row("with D, test 1", 0.925, &|l| l.tests[0], Aim::Reach);
    add_row("with D, test 2", 1.18, &|l| l.tests[1], Aim::Reach);
    add_row("inverse without D, frequency-varying", 5.38, &|l| l.inverse[0], Aim::Baseline);
    add_row("inverse with D, test 1", 1.13, &|l| l.inverse[2], Aim::Reach);
    add_row("inverse with D, test 2", 2.51, &|l| l.inverse[3], Aim::Reach);
    add_row("inverse of simulated angles, signal H", 1.17, &|l| l.from[0], Aim::Reach);
    add_row("inverse of measured angles, signal H", 44.62, &|l| l.from[1], Aim::ForComparison);
    add_row("pruned, signal H", 0.607, &|l| l.pruned, Aim::Reach);
    let mut ratio = |what: &str, paper: [f64; 2], of: &dyn Fn(&Left) -> [f64; 2]| {
        rows.push(beside(Row::ratio(ID, what, "%", paper, of(&own)), &|l| of(l)[0]));
    };
    let what = "with D, frequency-varying (of without)";
    ratio(what, [0.957, 2.25], &|l| [l.with, l.without]);
    let what = "inverse with D, frequency-varying (of without)";
    ratio(what, [1.25, 5.38], &|l| [l.inverse[1], l.inverse[0]]);
    let [without, with, ..] = own.inverse;
    answer.rows.splice(..0, rows);
    let mut order = |what: &str, holds: bool| {
        answer.orders.push(Order { paper_id: ID, what: what.into(), holds });
    };
    order("D improves the model on the frequency-varying signal", own.with < own.without);
    order("D improves the inverse on the frequency-varying signal", with < without);
    order(
        "the inverse of simulated angles is better than that of measured ones",
        own.from[0] < own.from[1],
    );
    if !quick {
        plays(&mut answer, say)?;
        tried(&records, &simulated, &mut answer, say)?;
    }
    answer.remarks.push(
        "the paper's method: NARX inputs, settings in simulation mode, Algorithm 1 with its tau or what the machine allows, the \
         linear part by output error, an inverse that looks ahead as few rows as a stable one can. With settings by ten blocks of 2 s (third column) the model diverges over 20 s; with those of the complete record, which have a smaller gamma, it does not. \"Ours\": stop operators (P1's, without the rate), trained in turn with the linear part, \
         and an inverse that looks up to three rows ahead"
            .into(),
    );
    Ok(answer)
}

/// Plays of our other model.
const PLAYS: usize = 20;

/// Ours: plays between two curves, with creep, delay and lag, fitted to records H and D, in simulation as all.
fn plays(answer: &mut Reproduction, say: &(dyn Fn(&str) + Sync)) -> anyhow::Result<()> {
    say("plays between two curves");
    let of = |name: &str| driven(machines::P0, name, &[], 1.0);
    let (h, d) = (of("p0-train-h")?, of("p0-train-d")?);
    let tests = [of("p0-test-1")?, of("p0-test-2")?];
    let ours = Baseline {
        method: Some("curved-prandtl-ishlinskii"),
        thresholds: (0..PLAYS).map(|i| 75.0 * i as f64 / PLAYS as f64).collect(),
        levels: 2,
        dynamic: true,
    };
    let plant = ours.fit(&[&h, &d])?;
    let span = Span::of(&h.position);
    let judged = [
        ("signal H", 0.607, &h),
        ("frequency-varying", 0.957, &d),
        ("test 1", 0.925, &tests[0]),
        ("test 2", 1.18, &tests[1]),
    ];
    let mut halves = true;
    for (on, paper, run) in judged {
        let error = 100.0 * baseline::error(&plant, run)? / (span.high - span.low);
        let what = format!("ours: plays between two curves, {on}");
        answer.rows.push(Row::of_ours(ID, what, "%", paper, error));
        halves &= 2.0 * error <= paper;
    }
    let what = "ours, plays between two curves: at most half of the paper's errors".into();
    answer.orders.push(Order { paper_id: ID, what, holds: halves });
    answer.remarks.push(
        "plays between two curves: their weights, creep, curves, delay and lag, all fitted to records H and D together. The \
         machine's own hysteresis is also of plays and a curve, which flatters them"
            .into(),
    );
    Ok(())
}

/// Trains, prunes, adds the linear part; then the inverse.
fn forward(
    method: &Method,
    records: &Records,
    answer: &mut Reproduction,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<Left> {
    let name = method.name;
    say(&format!("{name}: training on 4000 samples, and pruning"));
    let (h, d) = (&records.train_h, &records.train_d);
    let pairs = [(&h.u[..], &method.targets[..])];
    let (complete, report) = Machine::train(method.frame.clone(), &pairs, method.forward)?;
    let error = percent(&complete.simulate(&h.u, h.theta0), &method.targets);
    // τ of the paper, or what this machine allows.
    let limit = 0.0061_f64.max(1.05 * error / 100.0);
    let pruned = |most_error: f64, least_count: usize| -> anyhow::Result<Machine> {
        let pruning = Pruning { most_error, least_count, ..Pruning::default() };
        Ok(Machine::prune(method.frame.clone(), &pairs, method.forward, pruning)?.0)
    };
    let small = pruned(limit, LEAST)?;
    let count = small.machine.count();
    answer.remarks.push(format!(
        "{name}: {count} of {} samples stay with tau = {:.2} % (the paper: 551); exact residual \
         {:.1e}",
        h.u.len(),
        100.0 * limit,
        report.residual
    ));
    let model = Model::new(small.clone(), &d.u, &d.theta, d.theta0)?;
    // What the hysteresis was trained on: with the linear part, where the two were trained in turn.
    let on_h = match method.in_turn {
        true => model.error(&h.u, &h.theta, h.theta0),
        false => model.error_without(&h.u, &h.theta, h.theta0),
    };
    answer.chapters.push(seen(name, records, &model));
    if name == OWN {
        keep(records, &model, answer)?;
    }
    let few = pruned(f64::INFINITY, 551)?;
    let many = pruned(f64::INFINITY, 2059)?;
    table(method, records, &[&few, &many], answer)?;
    say(&format!("{name}: inverse"));
    let (inverse, from) = inverse(method, records, &complete, answer)?;
    Ok(Left {
        unpruned: error,
        pruned: on_h,
        without: model.error_without(&d.u, &d.theta, d.theta0),
        with: model.error(&d.u, &d.theta, d.theta0),
        tests: records.tests.each_ref().map(|r| model.error(&r.u, &r.theta, r.theta0)),
        inverse,
        from,
    })
}

/// Keeps the records in normalised commands and angles, and the paper's own model.
fn keep(records: &Records, model: &Model, answer: &mut Reproduction) -> anyhow::Result<()> {
    let [one, two] = &records.tests;
    let all = [
        ("train-h", &records.train_h),
        ("train-d", &records.train_d),
        ("test-1", one),
        ("test-2", two),
    ];
    for (name, record) in all {
        let simulated = model.simulate(&record.u, record.theta0);
        answer.kept.record(name, ["1"; 2], &record.response(), Some(&simulated))?;
    }
    let linear = Some(&model.linear);
    answer.kept.machine("p0_model", ["1"; 2], &model.hysteresis, linear, PERIOD)
}

/// The test signals, measured and simulated.
fn seen(name: &str, records: &Records, model: &Model) -> Chapter {
    let text = "Normalised angle over normalised command, and over time; the model is simulated from the command alone.";
    let mut chapter = Chapter::new(format!("{name} on the test signals"), text);
    for (record, number) in records.tests.iter().zip(1..) {
        let simulated = model.simulate(&record.u, record.theta0);
        chapter = chapter.figure(figures::over(
            format!("Test {number}: angle over command"),
            &record.u,
            [("machine", &record.theta), ("model", &simulated)],
        ));
    }
    for (record, number) in records.tests.iter().zip(1..) {
        let simulated = model.simulate(&record.u, record.theta0);
        let models = [("model", &simulated[..])];
        let title = format!("Test {number}");
        chapter = chapter.figure(figures::model(title, "1", 5e-3, &record.theta, &models));
    }
    chapter
}

/// Table I: proposed against plain machines on the first N samples, which the paper trains on positions and runs
/// without a linear part, and against no linear part.
fn table(
    method: &Method,
    records: &Records,
    machines: &[&Machine],
    answer: &mut Reproduction,
) -> anyhow::Result<()> {
    let (h, d) = (&records.train_h, &records.train_d);
    let name = method.name;
    // Proposed, plain, without D, on each test.
    let mut errors = Vec::new();
    for (at, machine) in machines.iter().enumerate() {
        let count = machine.machine.count();
        let first = count.min(h.u.len());
        let pairs = [(&h.u[..first], &h.theta[..first])];
        let (plain, _) = Machine::train(method.frame.clone(), &pairs, method.forward)?;
        let ours = Model::new((**machine).clone(), &d.u, &d.theta, d.theta0)?;
        let of = records.tests.each_ref().map(|test| {
            let without = ours.error_without(&test.u, &test.theta, test.theta0);
            let plain = percent(&plain.simulate(&test.u, test.theta0), &test.theta);
            [ours.error(&test.u, &test.theta, test.theta0), plain, without]
        });
        for ([proposed, plain, without], number) in of.iter().zip(1..) {
            if name == OWN {
                // The numbers of the table are a picture in the paper's text but for two.
                let known = if at == 0 { [0.925, 1.18][number - 1] } else { f64::NAN };
                let all = [
                    ("proposed", *proposed, known),
                    ("plain", *plain, f64::NAN),
                    ("without D", *without, f64::NAN),
                ];
                for (what, error, paper) in all {
                    let what = format!("table I, test {number}, {count} support vectors, {what}");
                    answer.rows.push(Row::new(ID, what, "%", paper, error, Aim::ForComparison));
                }
            }
            answer.remarks.push(format!(
                "{name}, test {number} with {count} support vectors: proposed {proposed:.3} %, plain on the \
                 first samples {plain:.3} %, without D {without:.3} %"
            ));
        }
        errors.push(of);
    }
    if let ([few, many], OWN) = (&errors[..], method.name) {
        for ((few, many), number) in few.iter().zip(many).zip(1..) {
            let mut order = |what: &str, holds: bool| {
                let what = format!("test {number}: {what}");
                answer.orders.push(Order { paper_id: ID, what, holds });
            };
            order("proposed better than plain", few[0] < few[1] && many[0] < many[1]);
            order("proposed better than without D", few[0] < few[2] && many[0] < many[2]);
            order("more support vectors are better", many[0] <= few[0]);
        }
    }
    Ok(())
}

/// For the inverse over stop operators: signal H begins at rest at 0, the tests do not.
const WAVES: Waves = Waves {
    count: 8,
    rows: 4000,
    period: PERIOD,
    band: [0.35, 2.0],
    range: [0.0, 1.0],
    seed: SEED,
};

/// The inverse, learned from samples that the unpruned forward hysteresis simulates, and what undoes the linear part in front
/// of it. On the frequency-varying signal without and with that part, then on the tests; and on signal H the inverse of
/// simulated and of measured angles.
fn inverse(
    method: &Method,
    records: &Records,
    complete: &Machine,
    answer: &mut Reproduction,
) -> anyhow::Result<([f64; 4], [f64; 2])> {
    let (h, d) = (&records.train_h, &records.train_d);
    let ours = method.in_turn;
    let synthetic =
        SyntheticData::new(&[&h.u], ours.then_some(WAVES), |u| complete.simulate(u, h.theta0))?;
    let pairs = synthetic.pairs();
    let (clean, _) = pairs[0];
    let (frame, settings) = match ours {
        true => stops(&pairs, [Span::UNIT; 2])?,
        false => (method.frame.clone(), method.inverse),
    };
    let samples = synthetic.samples(&frame, if ours { 2 } else { 1 }, 16)?;
    let (trained, report) = Machine::train_on(frame.clone(), &samples, settings)?;
    let judge = |machine: &LsSvm| rms_difference(&frame.simulate(machine, clean, h.u[0]), &h.u);
    let own = judge(&trained.machine);
    // τ of the paper, or what this machine allows.
    let most_error = 5e-5_f64.max(1.05 * own);
    let pruning = Pruning { least_count: LEAST, most_error, ..Pruning::default() };
    let pruned = prune(&samples, settings, pruning, judge)?;
    let small = Machine { machine: pruned.model, frame: frame.clone() };
    let (name, count) = (method.name, small.machine.count());
    let complete_answer = complete.simulate(&d.u, d.theta0);
    // The paper's is causal; what this machine is late by a stable filter cannot undo, so it looks ahead as little as it may.
    let cancelled = match ours {
        true => linear(&d.theta, &complete_answer, PERIOD, 3),
        false => (0..=3).find_map(|ahead| linear(&d.theta, &complete_answer, PERIOD, ahead)),
    };
    let looks = match &cancelled {
        Some(cancelled) => {
            format!("what undoes the linear part looks {} rows ahead", cancelled.ahead)
        }
        None => {
            "no stable linear part undoes this machine's, not with three rows ahead: it is left out"
                .into()
        }
    };
    answer.remarks.push(format!(
        "{name}, inverse: unpruned {:.4} % in simulation (residual {:.1e}), {count} support vectors \
         with tau = {:.4} % (the paper: 350 with 0.005 %); {looks}",
        100.0 * own,
        report.residual,
        100.0 * most_error
    ));
    let error = |record: &Record, cancelled: Option<&Linear>| {
        let theta = match cancelled {
            Some(cancelled) => cancelled.simulate(&record.theta, record.theta[0]),
            None => record.theta.clone(),
        };
        percent(&small.simulate(&theta, record.u[0]), &record.u)
    };
    let [one, two] = &records.tests;
    let left = [
        error(d, None),
        error(d, cancelled.as_ref()),
        error(one, cancelled.as_ref()),
        error(two, cancelled.as_ref()),
    ];
    // Both are asked for what the machine's measured angles were made by.
    let measured = [(&h.theta[..], &h.u[..])];
    let (of_measured, _) = Machine::train(frame, &measured, settings)?;
    let from = [error(h, None), percent(&of_measured.simulate(&h.theta, h.u[0]), &h.u)];
    Ok((left, from))
}

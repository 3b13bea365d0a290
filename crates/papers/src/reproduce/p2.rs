//! Piezo bimorph: LS-SVM for the hysteresis term of a second-order model, with three sets of inputs.
//!
//! ```text
//! ÿ + 2ξω ẏ + ω² y = d·u + h,   ĥ_k = f(u_k … u_{k−2}, y_k … y_{k−2}, ĥ_{k−1}, ĥ_{k−2})
//! ```
//!
//! h is an affine function of u and y at one instant, so that a model that is told both solves an identity. Here
//! each model is told one of them and asked for the other: I (u, h) gives y; II (y, h) gives u, as the
//! paper's feedforward does; III (u, y, h) gives y from the positions up to one sample before, measured ones as in the paper, or
//! its own.

use std::ops::Range;

use learned::lssvm::{LsSvm, Samples, Settings, leave_one_out};
use learned::tune::grid_then_simplex;

use super::figures::{self, Chapter};
use super::{Aim, Effort, Order, Reproduction, Row};
use crate::keep::UNITS;
use crate::machines;
use crate::matching::baseline::{Baseline, simulated};
use crate::matching::driven;

const ID: &str = "P2";
/// 2ξω, ω², d of the printed G(s), in um and V.
const DAMPING: f64 = 1.847;
const STIFFNESS: f64 = 6.477e6;
const GAIN: f64 = 1.247e8;
/// Past values m = n = l.
const PAST: usize = 2;

/// Where a model has the positions among its inputs from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Positions {
    /// There are none.
    None,
    /// Measured, from the present one on: what is asked for is the command.
    Measured,
    /// From the one before on, measured or its own.
    Before,
}

/// Which signals a model is told.
#[derive(Clone, Copy, PartialEq)]
struct Inputs {
    name: &'static str,
    command: bool,
    position: Positions,
    /// Whether the positions before are its own; else they are measured.
    runs_free: bool,
    /// Past values m = n = l.
    past: usize,
}

const MODELS: [Inputs; 3] = [
    Inputs {
        name: "model I (u, h)",
        command: true,
        position: Positions::None,
        runs_free: true,
        past: PAST,
    },
    Inputs {
        name: "model II (y, h)",
        command: false,
        position: Positions::Measured,
        runs_free: true,
        past: PAST,
    },
    Inputs {
        name: "model III (u, y, h)",
        command: true,
        position: Positions::Before,
        runs_free: false,
        past: PAST,
    },
];

/// A record with its hysteresis term, all of order one.
struct Record {
    /// Sample time in s.
    period: f64,
    u: Vec<f64>,
    y: Vec<f64>,
    h: Vec<f64>,
    range: f64,
    way: Scaling,
}

/// What u, y and h are divided by, and the gain d.
#[derive(Clone, Copy)]
struct Scaling {
    scales: [f64; 3],
    gain: f64,
}

/// d of the printed G(s).
const PRINTED: Scaling = Scaling { scales: SCALES, gain: GAIN };

/// Scales that make u, y and h of order one: 10 V, 200 um, and ω² times 30 um.
const SCALES: [f64; 3] = [10.0, 200.0, 30.0 * STIFFNESS];

fn record(name: &str, way: Scaling) -> anyhow::Result<Record> {
    let run = driven(machines::P2, name, &[], 1.0)?;
    let y: Vec<f64> = run.after().iter().map(|y| y - run.position[0]).collect();
    let (u, t) = (run.command, run.period);
    let at = |k: isize| y[k.clamp(0, y.len() as isize - 1) as usize];
    let h = (0..y.len() as isize).map(|k| {
        let acceleration = (at(k + 1) - 2.0 * at(k) + at(k - 1)) / (t * t);
        let rate = (at(k + 1) - at(k - 1)) / (2.0 * t);
        let own = k as usize;
        (acceleration + DAMPING * rate + STIFFNESS * y[own] - way.gain * u[own]) / way.scales[2]
    });
    let range = y.iter().copied().fold(0.0, f64::max) - y.iter().copied().fold(0.0, f64::min);
    Ok(Record {
        period: t,
        h: h.collect(),
        u: u.iter().map(|u| u / way.scales[0]).collect(),
        y: y.iter().map(|y| y / way.scales[1]).collect(),
        range,
        way,
    })
}

impl Inputs {
    fn dimension(self) -> usize {
        let signals = usize::from(self.command) + usize::from(self.position != Positions::None);
        (self.past + 1) * signals + self.past
    }

    /// x_k with these positions and past values of h.
    fn at(self, record: &Record, k: usize, y: &[f64], h: &[f64]) -> Vec<f64> {
        let mut x = Vec::with_capacity(self.dimension());
        if self.command {
            x.extend((0..=self.past).map(|i| record.u[k.saturating_sub(i)]));
        }
        let late = match self.position {
            Positions::None => None,
            Positions::Measured => Some(0),
            Positions::Before => Some(1),
        };
        if let Some(late) = late {
            x.extend((0..=self.past).map(|i| y[k.saturating_sub(i + late)]));
        }
        x.extend(h);
        x
    }

    fn samples(self, record: &Record) -> Result<Samples, learned::Error> {
        let h = &record.h;
        let x = (0..h.len()).flat_map(|k| {
            let past: Vec<f64> = (1..=self.past).map(|i| h[k.saturating_sub(i)]).collect();
            self.at(record, k, &record.y, &past)
        });
        Samples::new(self.dimension(), x.collect(), h.clone())
    }

    /// ĥ with its own past values, over these rows from what was measured before them.
    fn run(self, model: &LsSvm, record: &Record, rows: Range<usize>) -> Vec<f64> {
        let (f, mut room) = (model.kernel_sum(), vec![0.0; self.dimension()]);
        let before = |i: usize| record.h[rows.start.saturating_sub(i)];
        let mut past: Vec<f64> = (1..=self.past).map(before).collect();
        let mut y = record.y.clone();
        let mut all = Vec::with_capacity(rows.len());
        for k in rows {
            let h = f.value(&self.at(record, k, &y, &past), &mut room).clamp(-1e3, 1e3);
            if self.position == Positions::Before && self.runs_free {
                // The derivatives of (5) are 2·10⁻⁵ of its other terms.
                let [command, position, term] = record.way.scales;
                y[k] =
                    (record.way.gain * command * record.u[k] + term * h) / (STIFFNESS * position);
            }
            past.rotate_right(1);
            past[0] = h;
            all.push(h);
        }
        all
    }

    /// Error of what is asked for, in percent of the range: of y, or of u times the gain d/ω². Both are the error of
    /// ĥ/ω², where the derivatives of (5) are left out.
    fn error(self, model: &LsSvm, record: &Record) -> f64 {
        let run = self.run(model, record, 0..record.h.len());
        let rms = identify::learned::rms_difference(&run, &record.h);
        100.0 * rms * record.way.scales[2] / STIFFNESS / record.range
    }

    /// Error of ĥ in percent of the range of h.
    fn error_of_term(self, model: &LsSvm, record: &Record) -> f64 {
        let run = self.run(model, record, 0..record.h.len());
        let span = identify::learned::Span::of(&record.h);
        100.0 * identify::learned::rms_difference(&run, &record.h) / (span.high - span.low)
    }
}

/// ln σ² and ln γ.
const BOUNDS: [(f64, f64); 2] = [(-2.0, 6.0), (2.0, 20.0)];

fn settings(point: &[f64]) -> Settings {
    Settings { sigma2: point[0].exp(), gamma: point[1].exp() }
}

/// A greatest γ that is tried.
const MODEST: f64 = 1e6;

/// Settings of least leave-one-out error, as the paper has it.
fn left_out(samples: &Samples, bounds: &[(f64, f64); 2]) -> anyhow::Result<(LsSvm, Settings)> {
    let mut row = |s: f64, gammas: &[f64]| -> Vec<f64> {
        let error = |g: &f64| {
            let squares = |errors: Vec<f64>| errors.iter().map(|e| e * e).sum::<f64>();
            leave_one_out(samples, settings(&[s, *g])).map_or(f64::INFINITY, squares)
        };
        gammas.iter().map(error).collect()
    };
    let best = grid_then_simplex(bounds, &mut row, &mut |_, _| true);
    let settings = settings(&best.point);
    Ok((LsSvm::train(samples, settings)?.0, settings))
}

/// Blocks of the cross-validation in simulation mode.
const BLOCKS: usize = 5;

/// Settings of least error over blocks of the training record that are left out in turn, each simulated with the model's own
/// past from there on. A one-step error knows nothing of how an error goes on.
fn in_simulation(
    inputs: Inputs,
    samples: &Samples,
    record: &Record,
) -> anyhow::Result<(LsSvm, Settings)> {
    let count = record.h.len();
    let block = |part: usize| part * count / BLOCKS..(part + 1) * count / BLOCKS;
    let others: Vec<Samples> = (0..BLOCKS)
        .map(|part| {
            let kept: Vec<usize> = (0..count).filter(|k| !block(part).contains(k)).collect();
            samples.subset(&kept)
        })
        .collect();
    let mut row = |s: f64, gammas: &[f64]| -> Vec<f64> {
        let left = |gamma: f64| -> Option<f64> {
            let mut sum = 0.0;
            for (part, others) in others.iter().enumerate() {
                let (model, _) = LsSvm::train(others, settings(&[s, gamma])).ok()?;
                let run = inputs.run(&model, record, block(part));
                let error = identify::learned::rms_difference(&run, &record.h[block(part)]);
                sum += error * error;
            }
            Some(sum)
        };
        gammas.iter().map(|gamma| left(*gamma).unwrap_or(f64::INFINITY)).collect()
    };
    let best = grid_then_simplex(&BOUNDS, &mut row, &mut |_, _| true);
    let settings = settings(&best.point);
    Ok((LsSvm::train(samples, settings)?.0, settings))
}

/// The Bouc–Wen model fitted to the training record: its errors in percent of the range.
fn bouc_wen() -> anyhow::Result<[f64; 3]> {
    let of = |name: &str| driven(machines::P2, name, &[], 1.0);
    let runs = [of("p2-train")?, of("p2-test-1")?, of("p2-test-2")?];
    let baseline = Baseline {
        method: Some("bouc-wen"),
        thresholds: vec![0.0, 1.0],
        levels: 2,
        dynamic: false,
    };
    let plant = baseline.fit(&[&runs[0]])?;
    let mut errors = [0.0; 3];
    for (error, run) in errors.iter_mut().zip(&runs) {
        let model = simulated(&plant, run)?;
        let span = identify::learned::Span::of(&run.position);
        let rms = identify::learned::rms_difference(&model, &run.position[..model.len()]);
        *error = 100.0 * rms / (span.high - span.low);
    }
    Ok(errors)
}

/// Plays of our model.
const PLAYS: usize = 30;

/// Ours: plays between two curves, told the same as model III: the command, and the measured position one sample before, from
/// which it goes on. Its errors in percent of the range.
fn plays_and_position() -> anyhow::Result<[f64; 3]> {
    let of = |name: &str| driven(machines::P2, name, &[], 1.0);
    let runs = [of("p2-train")?, of("p2-test-1")?, of("p2-test-2")?];
    // From 0 to half the range of the command, 10 V.
    let thresholds = (0..PLAYS).map(|i| 5.0 * i as f64 / PLAYS as f64).collect();
    let baseline = Baseline {
        method: Some("curved-prandtl-ishlinskii"),
        thresholds,
        levels: 2,
        dynamic: true,
    };
    let plant = baseline.fit(&[&runs[0]])?;
    let mut errors = [0.0; 3];
    for (error, run) in errors.iter_mut().zip(&runs) {
        let model = simulated(&plant, run)?;
        let left: Vec<f64> = model.iter().zip(&run.position).map(|(m, y)| y - m).collect();
        // What is wrong one sample before is wrong now.
        let ahead: Vec<f64> = left.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let span = identify::learned::Span::of(&run.position);
        let zero = vec![0.0; ahead.len()];
        let rms = identify::learned::rms_difference(&ahead, &zero);
        *error = 100.0 * rms / (span.high - span.low);
    }
    Ok(errors)
}

/// The hysteresis term, as it follows from the measured signals and as the models simulate it.
fn seen(records: &[Record; 3], models: &[(Inputs, LsSvm)]) -> Chapter {
    let text = "The hysteresis term h of the second-order model, as a displacement h/ω².";
    let mut chapter = Chapter::new("the hysteresis term", text);
    let scale = SCALES[2] / STIFFNESS;
    let displacement = |h: &[f64]| h.iter().map(|h| h * scale).collect::<Vec<f64>>();
    for (record, name) in records.iter().zip(["training", "test 1", "test 2"]) {
        let simulated: Vec<(&str, Vec<f64>)> = models
            .iter()
            .map(|(inputs, model)| {
                (inputs.name, displacement(&inputs.run(model, record, 0..record.h.len())))
            })
            .collect();
        let models: Vec<(&str, &[f64])> = simulated.iter().map(|(n, h)| (*n, &h[..])).collect();
        let measured = displacement(&record.h);
        let title = format!("h, {name}");
        chapter = chapter.figure(figures::model(title, "um", record.period, &measured, &models));
    }
    chapter
}

/// Error in percent of the range from which on a model has run off.
const RUN_OFF: f64 = 50.0;
/// The paper's errors of y in percent: Bouc–Wen, and model III.
const BOUC_WEN: [f64; 3] = [1.9, 2.8, 1.9];
const THIRD: [f64; 3] = [1.05, 0.35, 0.50];
/// Errors of h of model III, as far as the text has them.
const TERM: [f64; 3] = [f64::NAN, 0.27, 0.15];

/// Training and both tests.
fn records(way: Scaling) -> anyhow::Result<[Record; 3]> {
    Ok([record("p2-train", way)?, record("p2-test-1", way)?, record("p2-test-2", way)?])
}

/// Other ways inside the paper's method, each with the settings of least leave-one-out error.
fn tried(
    records: &[Record; 3],
    answer: &mut Reproduction,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<()> {
    let of = |values: &[f64], scale: f64| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64;
        scale * square.sqrt()
    };
    let training = &records[0];
    let [command, position, term] = SCALES;
    let deviations = [of(&training.u, command), of(&training.y, position), of(&training.h, term)];
    // The line of least squares of y over u, through 0 as the printed G(s) goes.
    let (uy, uu) = training.u.iter().zip(&training.y).fold((0.0, 0.0), |(uy, uu), (u, y)| {
        (uy + u * y * command * position, uu + u * u * command * command)
    });
    let fitted = Scaling { gain: STIFFNESS * uy / uu, ..PRINTED };
    let [sigma2, (least, _)] = BOUNDS;
    let modest = [sigma2, (least, MODEST.ln())];
    for (what, way, past, bounds) in [
        ("gamma up to 1e6", PRINTED, PAST, modest),
        ("three past values of each", PRINTED, 3, BOUNDS),
        (
            "signals divided by their standard deviations",
            Scaling { scales: deviations, ..PRINTED },
            PAST,
            BOUNDS,
        ),
        ("d by least squares", fitted, PAST, BOUNDS),
    ] {
        let records = self::records(way)?;
        for inputs in MODELS {
            say(&format!("tried: {}, {what}", inputs.name));
            let inputs = Inputs { past, ..inputs };
            let (model, _) = left_out(&inputs.samples(&records[0])?, &bounds)?;
            for (k, name) in ["training", "test 1", "test 2"].into_iter().enumerate() {
                let what = format!("tried: {}, {what}, {name}", inputs.name);
                let paper = if inputs.position == Positions::Before { THIRD[k] } else { f64::NAN };
                let error = inputs.error(&model, &records[k]);
                answer.rows.push(Row::new(ID, what, "%", paper, error, Aim::ForComparison));
            }
        }
    }
    Ok(())
}

pub(super) fn run(effort: Effort, say: &(dyn Fn(&str) + Sync)) -> anyhow::Result<Reproduction> {
    let records = records(PRINTED)?;
    let mut answer = Reproduction::default();
    for name in ["p2-train", "p2-test-1", "p2-test-2"] {
        answer.kept.record(&name[3..], UNITS, &driven(machines::P2, name, &[], 1.0)?, None)?;
    }
    let quick =
        answer.leaves_out(effort, "ours, settings in simulation mode and what else was tried");
    say("Bouc-Wen");
    let baseline = bouc_wen()?;
    let ours = match quick {
        true => None,
        false => {
            say("plays and the last position");
            Some(plays_and_position()?)
        }
    };
    let (mut own, mut blocks) = (Vec::new(), Vec::new());
    let mut models = Vec::new();
    // Of the last one, model III: the term itself.
    let mut terms = [f64::NAN; 3];
    // Model III of the paper's settings with its own positions.
    let mut free = [f64::NAN; 3];
    for inputs in MODELS {
        say(inputs.name);
        let samples = inputs.samples(&records[0])?;
        let (by_paper, paper_settings) = left_out(&samples, &BOUNDS)?;
        let held = match quick {
            true => None,
            false => Some(in_simulation(inputs, &samples, &records[0])?),
        };
        let errors = |model: &LsSvm| records.each_ref().map(|record| inputs.error(model, record));
        own.push(errors(&by_paper));
        terms = records.each_ref().map(|record| inputs.error_of_term(&by_paper, record));
        let own_positions = Inputs { runs_free: true, ..inputs };
        free = records.each_ref().map(|record| own_positions.error(&by_paper, record));
        blocks.push(held.as_ref().map(|(held, _)| errors(held)));
        let of = |s: Settings| format!("sigma^2 = {:.3}, gamma = {:.2e}", s.sigma2, s.gamma);
        let mut signals = format!("{}: leave-one-out takes {}", inputs.name, of(paper_settings));
        if let Some((_, settings)) = &held {
            signals += &format!("; five blocks in simulation mode take {}", of(*settings));
        }
        answer.remarks.push(signals);
        models.push((inputs, held.map_or(by_paper, |(held, _)| held)));
    }
    answer.chapters.push(seen(&records, &models));
    let names = ["training", "test 1", "test 2"];
    for (k, name) in names.iter().enumerate() {
        let what = format!("Bouc-Wen fitted, {name}");
        answer.rows.push(Row::new(ID, what, "%", BOUC_WEN[k], baseline[k], Aim::Baseline));
        for (n, inputs) in MODELS.iter().enumerate() {
            let what = format!("{}, {name}", inputs.name);
            let row = if n == 2 {
                Row::ratio(ID, what, "%", [THIRD[k], BOUC_WEN[k]], [own[n][k], baseline[k]])
            } else {
                Row::new(ID, what, "%", f64::NAN, own[n][k], Aim::ForComparison)
            };
            let ours = ours.map(|errors| errors[k]);
            answer.rows.push(if n == 2 { Row { ours, ..row.other(free[k]) } } else { row });
            if let Some(errors) = blocks[n] {
                let what = format!(
                    "tried: {}, settings by five blocks in simulation, {name}",
                    inputs.name
                );
                let paper = if n == 2 { THIRD[k] } else { f64::NAN };
                answer.rows.push(Row::new(ID, what, "%", paper, errors[k], Aim::ForComparison));
            }
        }
        let what = format!("model III, the term h of its own range, {name}");
        answer.rows.push(Row::new(ID, what, "%", TERM[k], terms[k], Aim::ForComparison));
        // Of two models that run off neither is better.
        let mut order = |what: &str, better: f64, worse: f64| {
            let (what, holds) = (format!("{name}: {what}"), better < worse && better < RUN_OFF);
            answer.orders.push(Order { paper_id: ID, what, holds });
        };
        order("model III better than Bouc-Wen", own[2][k], baseline[k]);
        order("model III better than model II", own[2][k], own[1][k]);
        order("model II better than model I", own[1][k], own[0][k]);
    }
    if !quick {
        tried(&records, &mut answer, say)?;
    }
    answer.remarks.push(
        "the inputs of the paper's model III are u_k and y_k, and its output h_k is an affine function of the two: an identity, so there is no row. Model I computes y from u; II computes u from y, as the feedforward does; III computes y from u and the measured positions up to one sample before; its own past h is fed back, as in the paper. \"Ours\" is told the same as model III: plays between two curves, fitted to the training signal, plus what was wrong one sample before. In the third column model III uses its own positions as well, a simulation. Test signals 1 and 2 replace figures"
            .into(),
    );
    Ok(answer)
}

#[cfg(test)]
mod tests;

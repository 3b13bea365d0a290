//! From records to a plant: baseline, hysteresis with delay, linear parts, and the choice.

use data::CheckedBlueprint;

use crate::error::{Error, Problem};
use crate::estimates;
use crate::fit::delay::{self, Delay};
use crate::fit::linear_part::{self, Deviations, Structure};
use crate::fit::response::LinearPart;
use crate::fit::weights::{Fitted, Task, independent_samples, mean};
use crate::identification::{Candidate, Identification, RULES, RecordFit};
use crate::judge::{compare, simulate};
use crate::observer::Observer;
use crate::plant::{Actuator, Plant};
use crate::record::{Record, Rows};
use crate::settings::{Dynamics, Plan, Settings, Target};

/// Relative fall of the held-out error from which a linear part is kept.
pub const SIGNIFICANT_FALL: f64 = 0.10;
/// Correlation of input and output below which the output is taken to fall where the input rises.
const CLEARLY_NEGATIVE: f64 = -0.3;

/// Identifies a plant from records of one axis.
///
/// 1. A straight line is fitted, the baseline, and a straight line with delay.
/// 2. Weights of a Prandtl–Ishlinskii model by non-negative least squares, with one offset per
///    record and the delay searched jointly.
/// 3. An amplifier lag, a mode, and both, each with weights and delay in one output-error fit. The
///    one with the least held-out error is kept if that is at least 10 % below the error
///    without it ([`SIGNIFICANT_FALL`]); among structures that do not differ so much the simpler one
///    is returned.
///
/// Every error is that of the plant that is returned, simulated ([`RULES`]).
///
/// # Errors
/// [`Error`], with all problems of records and settings at once.
pub fn identify(
    records: &[Record],
    target: &Target,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Identification, Error> {
    let plan = settings.plan(records)?;
    check_sign(records, &plan)?;
    let mut session = Session { records, target, plan, observer };
    let baseline = session.line()?;
    let delayed_line = session.delayed_line()?;
    let (static_model, static_fit) = session.static_model()?;
    let mut candidates = vec![
        candidate(&baseline, "the baseline, for comparison"),
        candidate(
            &delayed_line,
            "for comparison: at one frequency and amplitude a delay passes for hysteresis",
        ),
        candidate(&static_model, "the simplest model with hysteresis"),
    ];
    let mut best = static_model;
    if session.plan.dynamics == Dynamics::Automatic {
        session.linear_parts(&static_fit, &mut best, &mut candidates)?;
    }
    let chosen = best.structure.clone();
    for candidate in &mut candidates {
        candidate.accepted = candidate.structure == chosen;
    }
    Ok(session.result(baseline, best, candidates))
}

/// A model with its simulations.
#[derive(Clone)]
struct Tried {
    structure: String,
    plant: CheckedBlueprint,
    simulations: Vec<Vec<f64>>,
    /// Over all rows held out, in the position's unit.
    held_out_rmse: f64,
    fitted: Fitted,
    delay: Delay,
    deviations: Deviations,
}

struct Session<'a> {
    records: &'a [Record],
    target: &'a Target,
    plan: Plan,
    observer: &'a mut dyn Observer,
}

impl<'a> Session<'a> {
    fn task(&self, thresholds: Vec<f64>) -> Task<'a> {
        Task {
            records: self.records,
            rows: self.plan.fitted.clone(),
            period: self.plan.period,
            substeps: 1,
            thresholds,
            least_slope: self.plan.least_slope,
        }
    }

    /// The best straight line.
    fn line(&self) -> Result<Tried, Error> {
        let task = self.task(vec![0.0]);
        let fitted = task.solve(LinearPart::default())?;
        self.with_gain(&task, fitted, Delay::default())
    }

    /// The best straight line with delay.
    fn delayed_line(&mut self) -> Result<Tried, Error> {
        let task = self.task(vec![0.0]);
        let longest = self.plan.longest_delay;
        let observer = &mut *self.observer;
        let mut report = |done, total| observer.progress("straight line with delay", done, total);
        let (delay, fitted) = delay::search(&task, longest, &mut report)?;
        self.with_gain(&task, fitted, delay)
    }

    fn with_gain(&self, task: &Task<'_>, fitted: Fitted, delay: Delay) -> Result<Tried, Error> {
        let gain = fitted.weights.first().copied().unwrap_or(0.0);
        self.tried(task, Actuator::Linear { gain }, fitted, delay, Deviations::default())
    }

    fn static_model(&mut self) -> Result<(Tried, Fitted), Error> {
        let task = self.task(self.plan.thresholds.clone());
        let longest = self.plan.longest_delay;
        let observer = &mut *self.observer;
        let mut report = |done, total| observer.progress("hysteresis and delay", done, total);
        let (delay, fitted) = delay::search(&task, longest, &mut report)?;
        let deviations = Deviations { delay: Some(delay.deviation), ..Deviations::default() };
        let tried = self.with_plays(&task, fitted.clone(), delay, deviations)?;
        Ok((tried, fitted))
    }

    fn linear_parts(
        &mut self,
        static_fit: &Fitted,
        best: &mut Tried,
        candidates: &mut Vec<Candidate>,
    ) -> Result<(), Error> {
        let without = best.held_out_rmse;
        let mut with_mode = static_fit.linear;
        for (lag, mode) in [(true, false), (false, true), (true, true)] {
            let structure = Structure { lag, mode };
            let known = if lag && mode { with_mode } else { static_fit.linear };
            let tried = match self.linear_part(structure, &known) {
                Ok(tried) => tried,
                // A structure that the data do not support is no reason to return nothing.
                Err(error @ Error::NoSolution { .. }) => {
                    candidates.push(Candidate {
                        structure: name_of(structure).to_owned(),
                        held_out_rmse: None,
                        accepted: false,
                        reason: error.to_string(),
                    });
                    continue;
                }
                Err(error) => return Err(error),
            };
            if mode {
                with_mode = tried.fitted.linear;
            }
            let fall = 1.0 - tried.held_out_rmse / best.held_out_rmse;
            let needed = 100.0 * SIGNIFICANT_FALL;
            let against =
                if best.held_out_rmse < without { "the best so far" } else { "no lag and no mode" };
            let reason = format!(
                "held-out error {:+.1} % against {against} ({needed} % less is needed)",
                -100.0 * fall
            );
            candidates.push(candidate(&tried, &reason));
            if fall >= SIGNIFICANT_FALL {
                *best = tried;
            }
        }
        Ok(())
    }

    fn linear_part(&mut self, structure: Structure, known: &LinearPart) -> Result<Tried, Error> {
        let mut task = self.task(self.plan.thresholds.clone());
        let longest = self.plan.longest_delay;
        let observer = &mut *self.observer;
        let stage = name_of(structure);
        let mut report = |done, total| observer.progress(stage, done, total);
        let (fitted, deviations) =
            linear_part::fit(&mut task, structure, longest, known, &mut report)?;
        let deviation = deviations.delay.unwrap_or(f64::INFINITY);
        let delay = Delay { value: fitted.linear.delay, deviation };
        self.with_plays(&task, fitted, delay, deviations)
    }

    fn with_plays(
        &self,
        task: &Task<'_>,
        fitted: Fitted,
        delay: Delay,
        deviations: Deviations,
    ) -> Result<Tried, Error> {
        let (r, w) = (task.thresholds.clone(), fitted.weights.clone());
        let relative_deviation = estimates::relative_deviation(&fitted);
        let actuator = Actuator::Plays { r: &r, w: &w, relative_deviation };
        self.tried(task, actuator, fitted, delay, deviations)
    }

    fn tried(
        &self,
        task: &Task<'_>,
        actuator: Actuator<'_>,
        fitted: Fitted,
        delay: Delay,
        deviations: Deviations,
    ) -> Result<Tried, Error> {
        let structure = describe(&actuator, &fitted.linear);
        let plant = Plant {
            actuator,
            offset: mean(&fitted.offsets),
            linear: fitted.linear,
            deviations,
            step: task.period / task.substeps as f64,
        };
        let names: Vec<&str> = self.records.iter().map(Record::name).collect();
        let description = format!("{structure}, identified from {}", names.join(", "));
        let plant = plant.blueprint(self.target, self.records, description)?;
        let simulations = self
            .records
            .iter()
            .map(|record| simulate(&plant, record))
            .collect::<Result<Vec<_>, _>>()?;
        let held_out_rmse = self.pooled(&simulations);
        Ok(Tried { structure, plant, simulations, held_out_rmse, fitted, delay, deviations })
    }

    /// Root mean square error over all rows held out.
    fn pooled(&self, simulations: &[Vec<f64>]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for ((record, rows), simulation) in
            self.records.iter().zip(&self.plan.judged).zip(simulations)
        {
            let figures = compare(record.output(), simulation, *rows);
            sum += figures.rmse.powi(2) * rows.len() as f64;
            count += rows.len();
        }
        (sum / count.max(1) as f64).sqrt()
    }

    fn result(self, baseline: Tried, best: Tried, candidates: Vec<Candidate>) -> Identification {
        let parameters = estimates::of(
            &self.plan,
            &self.target.axis,
            &best.fitted,
            best.delay,
            best.deviations,
            independent_samples(&best.fitted.residual),
        );
        let records = (0..self.records.len())
            .map(|k| {
                let (fitted, judged) = (self.plan.fitted[k], self.plan.judged[k]);
                let (model, line) = (&best.simulations[k], &baseline.simulations[k]);
                record_fit(&self.records[k], fitted, judged, model, line)
            })
            .collect();
        Identification {
            plant: best.plant,
            unit: self.target.axis.position.unit.clone(),
            rules: RULES,
            records,
            candidates,
            parameters,
        }
    }
}

fn record_fit(
    record: &Record,
    fitted: Rows,
    judged: Rows,
    simulation: &[f64],
    line: &[f64],
) -> RecordFit {
    let output = record.output();
    let held_out = compare(output, simulation, judged);
    let baseline_held_out = compare(output, line, judged);
    let residual = |simulation: &[f64], offset: f64| {
        output.iter().zip(simulation).map(|(y, s)| y - s - offset).collect()
    };
    RecordFit {
        record: record.name().to_owned(),
        fitted: compare(output, simulation, fitted),
        held_out,
        baseline_fitted: compare(output, line, fitted),
        baseline_held_out,
        simulation: simulation.to_vec(),
        residual: residual(simulation, held_out.offset),
        baseline_residual: residual(line, baseline_held_out.offset),
    }
}

fn candidate(tried: &Tried, reason: &str) -> Candidate {
    Candidate {
        structure: tried.structure.clone(),
        held_out_rmse: Some(tried.held_out_rmse),
        accepted: false,
        reason: reason.to_owned(),
    }
}

fn name_of(structure: Structure) -> &'static str {
    match (structure.lag, structure.mode) {
        (true, false) => "delay, amplifier-lag, prandtl-ishlinskii",
        (false, true) => "delay, prandtl-ishlinskii, mode",
        (true, true) => "delay, amplifier-lag, prandtl-ishlinskii, mode",
        (false, false) => "delay, prandtl-ishlinskii",
    }
}

fn describe(actuator: &Actuator<'_>, linear: &LinearPart) -> String {
    match actuator {
        Actuator::Linear { .. } if linear.delay > 0.0 => "delay, actuator-gain".to_owned(),
        Actuator::Linear { .. } => "actuator-gain".to_owned(),
        Actuator::Plays { .. } => {
            let structure =
                Structure { lag: linear.bandwidth.is_some(), mode: linear.mode.is_some() };
            name_of(structure).to_owned()
        }
    }
}

/// A log whose output falls where its input rises is told apart from one that cannot be fitted.
fn check_sign(records: &[Record], plan: &Plan) -> Result<(), Error> {
    for (record, rows) in records.iter().zip(&plan.fitted) {
        let input = rows.of(record.input());
        let output = rows.of(record.output());
        let (u_mean, y_mean) = (mean(input), mean(output));
        // The output at a row belongs to the input of the row before.
        let pairs =
            || input.iter().zip(output.iter().skip(1)).map(|(u, y)| (u - u_mean, y - y_mean));
        let cross: f64 = pairs().map(|(u, y)| u * y).sum();
        let (uu, yy) = pairs().fold((0.0, 0.0), |(uu, yy), (u, y)| (uu + u * u, yy + y * y));
        if cross < CLEARLY_NEGATIVE * (uu * yy).sqrt() {
            return Err(Error::NegativeGain {
                record: record.name().to_owned(),
                input: record.input_name().to_owned(),
                output: record.output_name().to_owned(),
                gain: cross / uu,
            });
        }
    }
    if plan.half_range > 0.0 { Ok(()) } else { Err(Error::Unsuitable(vec![Problem::NoRecord])) }
}

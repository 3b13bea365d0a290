//! From records to a plant: baseline, hysteresis with delay, linear parts, and the choice.

mod other_methods;
mod outcome;

use data::CheckedBlueprint;

use crate::error::Error;
use crate::estimates;
use crate::fit::delay::{self, Delay};
use crate::fit::linear_part::{self, Deviations, Structure};
use crate::fit::response::LinearPart;
use crate::fit::weights::{Fitted, Task, independent_samples, mean};
use crate::identification::{Candidate, Estimate, Identification, Predicted};
use crate::judge::simulate;
use crate::methods::{LINEAR, Scene};
use crate::observer::Observer;
use crate::plant::{Actuator, Plant};
use crate::record::{Record, Rows};
use crate::settings::{Dynamics, Plan, Settings, Target};
use crate::structure;

/// Relative fall of the held-out error from which a linear part is kept.
pub const SIGNIFICANT_FALL: f64 = 0.10;
/// Part of the measured range that a model must move by.
const STILL: f64 = 1e-6;
/// Name of the static model's method.
const STATIC: &str = "prandtl-ishlinskii";

/// Identifies a plant from records of one axis.
///
/// 1. A straight line is fitted, the baseline, and a straight line with delay; where all methods are tried, or
///    `linear` is asked for, with a lag and a mode too, by the rule of 3.
/// 2. Weights of a Prandtl–Ishlinskii model by non-negative least squares, with one offset per
///    record and the delay searched jointly.
/// 3. An amplifier lag, a mode, and both, each with weights and delay in one output-error fit. The
///    one with the least held-out error is kept if that is at least 10 % below the error
///    without it ([`SIGNIFICANT_FALL`]); among structures that do not differ so much the simpler one
///    is returned: where plays do not err 10 % less than the best model without hysteresis, that one.
/// 4. The other methods that were asked for, each with the linear parts found so far as its start,
///    the simplest first, by the same rule. Methods that are named are not compared with the static
///    model: the best of them is returned, and an error where none has a model. A model that nothing moves is never
///    taken.
///
/// Every error is that of the plant that is returned, simulated ([`RULES`](crate::RULES)). Where the observer asks to
/// stop, the best of what is finished is returned.
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
    structure::check_sign(records, &plan)?;
    let offsets = vec![0.0; records.len()];
    let mut session = Session { records, target, plan, observer, offsets };
    let baseline = session.line()?;
    let delayed_line = session.delayed_line()?;
    let mut linear = delayed_line.clone();
    let (static_model, static_fit) = session.static_model()?;
    session.offsets.clone_from(&static_fit.offsets);
    let mut candidates = vec![
        session.candidate(&baseline, "the baseline, for comparison"),
        session.candidate(
            &delayed_line,
            "for comparison: at one frequency and amplitude a delay passes for hysteresis",
        ),
        session.candidate(&static_model, "the simplest model with hysteresis"),
    ];
    let mut best = static_model;
    let mut stopped = session.observer.stopped();
    if session.plan.linear && session.plan.dynamics == Dynamics::Automatic && !stopped {
        match session.linear_parts(Plays::None, &mut linear, &mut candidates) {
            Ok(()) => {}
            Err(Error::Stopped) => stopped = true,
            Err(error) => return Err(error),
        }
    }
    if session.plan.dynamics == Dynamics::Automatic && !stopped {
        match session.linear_parts(Plays::All, &mut best, &mut candidates) {
            Ok(()) => {}
            Err(Error::Stopped) => stopped = true,
            Err(error) => return Err(error),
        }
    }
    if session.plan.linear && !session.plan.named {
        let fall = 1.0 - best.held_out_rmse / linear.held_out_rmse;
        if fall.is_nan() || fall < SIGNIFICANT_FALL {
            best = linear.clone();
            let mut all = candidates.iter_mut();
            if let Some(taken) = all.find(|c| is_of(c, &best)) {
                taken.reason = format!(
                    "plays err {:+.1} % against it on the rows held out ({:.0} % less is needed)",
                    -100.0 * fall,
                    100.0 * SIGNIFICANT_FALL
                );
            }
        }
    }
    if !stopped {
        stopped = session.other_methods(&linear, &mut best, &mut candidates)?;
    }
    for candidate in &mut candidates {
        candidate.accepted = is_of(candidate, &best);
    }
    Ok(session.result(baseline, best, candidates, stopped))
}

fn is_of(candidate: &Candidate, tried: &Tried) -> bool {
    candidate.method == tried.method && candidate.structure == tried.structure
}

/// What linear parts are looked for around.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Plays {
    /// A gain.
    None,
    /// The static model.
    All,
}

/// A model with its simulations.
#[derive(Clone)]
struct Tried {
    method: Option<&'static str>,
    structure: String,
    plant: CheckedBlueprint,
    simulations: Vec<Vec<f64>>,
    /// Over all rows held out, in the position's unit.
    held_out_rmse: f64,
    linear: LinearPart,
    parameters: Vec<Estimate>,
    /// Numbers that were fitted or learned, where these are not the parameters.
    numbers: Option<usize>,
    /// Of a Gaussian process.
    predicted: Option<Predicted>,
    /// How it was learned.
    training_note: Option<String>,
    seconds: f64,
}

impl Tried {
    /// How many numbers were fitted or learned.
    fn count(&self) -> usize {
        self.numbers.unwrap_or(self.parameters.len())
    }
}

struct Session<'a> {
    records: &'a [Record],
    target: &'a Target,
    plan: Plan,
    observer: &'a mut dyn Observer,
    /// Of each record, by the static model.
    offsets: Vec<f64>,
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
        let mut tried = self.with_gain(&task, fitted, Delay::default(), Deviations::default())?;
        // It is there to compare with.
        tried.method = None;
        Ok(tried)
    }

    /// The best straight line with delay.
    fn delayed_line(&mut self) -> Result<Tried, Error> {
        let task = self.task(vec![0.0]);
        let longest = self.plan.longest_delay;
        let observer = &mut *self.observer;
        let mut report = |done, total| observer.progress("straight line with delay", done, total);
        let (delay, fitted) = delay::search(&task, longest, &mut report)?;
        self.with_gain(&task, fitted, delay, Deviations::default())
    }

    fn with_gain(
        &self,
        task: &Task<'_>,
        fitted: Fitted,
        delay: Delay,
        deviations: Deviations,
    ) -> Result<Tried, Error> {
        let gain = fitted.weights.first().copied().unwrap_or(0.0);
        let actuator = Actuator::Linear { gain };
        let (name, offset) = (Some(LINEAR), mean(&fitted.offsets));
        let mut tried =
            self.tried(name, &actuator, offset, fitted.linear, deviations, task.substeps)?;
        tried.parameters = self.estimates(&fitted, delay, deviations);
        // The weight of the only play is the gain.
        if let Some(weight) = tried.parameters.last_mut() {
            "gain.gain".clone_into(&mut weight.name);
        }
        Ok(tried)
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

    /// Lag, mode and both around the static model or a gain; the best so far is where they begin.
    fn linear_parts(
        &mut self,
        plays: Plays,
        best: &mut Tried,
        candidates: &mut Vec<Candidate>,
    ) -> Result<(), Error> {
        let (without, first) = (best.held_out_rmse, best.linear);
        let mut with_mode = first;
        for (lag, mode) in [(true, false), (false, true), (true, true)] {
            let structure = Structure { lag, mode };
            let known = if lag && mode { with_mode } else { first };
            let tried = match self.linear_part(plays, structure, &known) {
                Ok(tried) => tried,
                // A structure that the data do not support is no reason to return nothing.
                Err(error @ Error::NoSolution { .. }) => {
                    let (method, name) = match plays {
                        Plays::All => (STATIC, structure::name_of(structure).to_owned()),
                        Plays::None => (LINEAR, format!("gain: {}", structure::name_of(structure))),
                    };
                    candidates.push(Candidate::failed(Some(method), name, &error));
                    continue;
                }
                Err(error) => return Err(error),
            };
            if mode {
                with_mode = tried.linear;
            }
            let fall = 1.0 - tried.held_out_rmse / best.held_out_rmse;
            let needed = 100.0 * SIGNIFICANT_FALL;
            let against =
                if best.held_out_rmse < without { "the best so far" } else { "no lag and no mode" };
            let reason = format!(
                "held-out error {:+.1} % against {against} ({needed} % less is needed)",
                -100.0 * fall
            );
            candidates.push(self.candidate(&tried, &reason));
            if fall >= SIGNIFICANT_FALL {
                *best = tried;
            }
        }
        Ok(())
    }

    fn linear_part(
        &mut self,
        plays: Plays,
        structure: Structure,
        known: &LinearPart,
    ) -> Result<Tried, Error> {
        let mut task = self.task(match plays {
            Plays::None => vec![0.0],
            Plays::All => self.plan.thresholds.clone(),
        });
        let longest = self.plan.longest_delay;
        let observer = &mut *self.observer;
        let stage = structure::name_of(structure);
        let mut report = |done, total| observer.progress(stage, done, total);
        let (fitted, deviations) =
            linear_part::fit(&mut task, structure, longest, known, &mut report)?;
        if self.observer.stopped() {
            return Err(Error::Stopped);
        }
        let deviation = deviations.delay.unwrap_or(f64::INFINITY);
        let delay = Delay { value: fitted.linear.delay, deviation };
        match plays {
            Plays::None => self.with_gain(&task, fitted, delay, deviations),
            Plays::All => self.with_plays(&task, fitted, delay, deviations),
        }
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
        let (offset, linear) = (mean(&fitted.offsets), fitted.linear);
        let mut tried =
            self.tried(Some(STATIC), &actuator, offset, linear, deviations, task.substeps)?;
        tried.parameters = self.estimates(&fitted, delay, deviations);
        Ok(tried)
    }

    fn estimates(&self, fitted: &Fitted, delay: Delay, deviations: Deviations) -> Vec<Estimate> {
        let independent = independent_samples(&fitted.residual);
        estimates::of(&self.plan, &self.target.axis, fitted, delay, deviations, independent)
    }

    fn tried(
        &self,
        method: Option<&'static str>,
        actuator: &Actuator<'_>,
        offset: f64,
        linear: LinearPart,
        deviations: Deviations,
        substeps: usize,
    ) -> Result<Tried, Error> {
        let structure = structure::describe(method, actuator, &linear);
        let step = self.plan.period / substeps as f64;
        let actuator = actuator.clone();
        let plant = Plant { actuator, offset, linear, deviations, step, table: None };
        self.written(method, structure, &plant)
    }

    /// What is found, simulated as it will be written.
    fn written(
        &self,
        method: Option<&'static str>,
        structure: String,
        plant: &Plant<'_>,
    ) -> Result<Tried, Error> {
        let linear = plant.linear;
        let names: Vec<&str> = self.records.iter().map(Record::name).collect();
        let description = format!("{structure}, identified from {}", names.join(", "));
        let plant = plant.blueprint(self.target, self.records, description)?;
        let simulations = self
            .records
            .iter()
            .map(|record| simulate(&plant, record))
            .collect::<Result<Vec<_>, _>>()?;
        let held_out_rmse = self.pooled(&simulations);
        let parameters = Vec::new();
        Ok(Tried {
            method,
            structure,
            plant,
            simulations,
            held_out_rmse,
            linear,
            parameters,
            numbers: None,
            predicted: None,
            training_note: None,
            seconds: 0.0,
        })
    }

    fn scene(&self) -> Scene {
        let rows = || self.records.iter().zip(&self.plan.fitted);
        let duration = rows().map(|(record, rows)| rows.len() as f64 * record.period());
        let span = |column: fn(&Record) -> &[f64]| {
            let part = |(record, rows): (&'a Record, &Rows)| rows.of(column(record));
            let values = || rows().flat_map(part).copied();
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        };
        let (command, position) = (span(Record::input), span(Record::output));
        Scene {
            command,
            position,
            zero: Scene::zero_of(command, position),
            duration: duration.fold(0.0, f64::max),
            thresholds: self.plan.thresholds.clone(),
            levels: self.plan.levels,
        }
    }
}

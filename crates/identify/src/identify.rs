//! From records to a plant: baseline, hysteresis with delay, linear parts, and the choice.

mod outcome;

use std::time::Instant;

use data::CheckedBlueprint;

use crate::error::Error;
use crate::estimates;
use crate::fit::delay::{self, Delay};
use crate::fit::linear_part::{self, Deviations, Structure};
use crate::fit::operator::{Operator, through};
use crate::fit::response::{LinearPart, before_hysteresis};
use crate::fit::weights::{Fitted, Task, independent_samples, mean};
use crate::identification::{Candidate, Estimate, Identification, Predicted, Verdict};
use crate::judge::simulate;
use crate::learned::network;
use crate::learned::plant::{Family, Learned, Lesson};
use crate::methods::{CURVED, Chain, LINEAR, Method, NETWORK, Scene, Way};
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

    /// Tries the other methods, the simplest first. Whether the observer stopped it.
    fn other_methods(
        &mut self,
        linear: &Tried,
        best: &mut Tried,
        candidates: &mut Vec<Candidate>,
    ) -> Result<bool, Error> {
        let scene = self.scene();
        let known = best.linear;
        let mut first = self.plan.named;
        let mut failures = Vec::new();
        for method in self.plan.methods.clone() {
            if method.name() == STATIC {
                first = false;
                continue;
            }
            if self.observer.stopped() {
                return Ok(true);
            }
            let started = Instant::now();
            let tried = match method {
                Way::Linear => {
                    // It was tried already.
                    if first || linear.held_out_rmse < best.held_out_rmse {
                        (*best, first) = (linear.clone(), false);
                    }
                    continue;
                }
                Way::Operator(method) => self.method(method, &scene, known),
                Way::Learned(family) => self.learned(family, known),
                Way::Network => self.network(&scene, known),
            };
            let mut tried = match tried.and_then(|tried| self.moved(tried)) {
                Ok(tried) => tried,
                Err(Error::Stopped) => return Ok(true),
                // A method that the data do not support is no reason to return nothing, unless only
                // such were asked for.
                Err(error) => {
                    candidates.push(Candidate::failed(
                        Some(method.name()),
                        method.name().to_owned(),
                        &error,
                    ));
                    failures.push((method.name(), error));
                    continue;
                }
            };
            tried.seconds = started.elapsed().as_secs_f64();
            let fall = 1.0 - tried.held_out_rmse / best.held_out_rmse;
            let open = match method {
                Way::Operator(method) => self.open_shape(&tried, method, &scene),
                Way::Linear | Way::Learned(_) | Way::Network => Vec::new(),
            };
            let mut reason = format!(
                "held-out error {:+.1} % against {} ({:.0} % less is needed)",
                -100.0 * fall,
                best.method.unwrap_or(STATIC),
                100.0 * SIGNIFICANT_FALL
            );
            if let Some(training_note) = &tried.training_note {
                reason += &format!("; {training_note}");
            }
            if !open.is_empty() {
                reason += &format!("; the records do not determine {}", open.join(", "));
            }
            candidates.push(self.candidate(&tried, &reason));
            if first || self.plan.named && fall > 0.0 {
                *best = tried;
                first = false;
            } else if open.is_empty() && fall >= SIGNIFICANT_FALL {
                *best = tried;
            }
        }
        if first { Err(Error::NoModel { failures }) } else { Ok(false) }
    }

    /// The model, where the command moves it.
    fn moved(&self, tried: Tried) -> Result<Tried, Error> {
        let height = |values: &[f64]| crate::settings::range(values);
        let mut each = self.records.iter().zip(&tried.simulations);
        if each.any(|(record, simulated)| height(simulated) > STILL * height(record.output())) {
            return Ok(tried);
        }
        let message = "the command moves nothing: the fit left every weight at 0; the records say nothing of this \
                       model, or it has another sign"
            .to_owned();
        Err(Error::Model { name: tried.method.unwrap_or(STATIC).to_owned(), message })
    }

    /// Parameters of the shape, and weights of any sign, that the records leave uncertain: a model that rests on them fits these
    /// records and need not fit others.
    fn open_shape(&self, tried: &Tried, method: &dyn Method, scene: &Scene) -> Vec<String> {
        let weights = method.weights(scene);
        let free = weights.names.into_iter().take(weights.free).map(|(name, _)| name);
        let shapes = method.shape(scene).into_iter().map(|s| s.name.into_owned());
        let named: Vec<String> = shapes.chain(free).collect();
        let uncertain = |p: &&Estimate| p.verdict == Verdict::Uncertain;
        let of_shape = |p: &&Estimate| named.contains(&p.name);
        tried.parameters.iter().filter(uncertain).filter(of_shape).map(|p| p.name.clone()).collect()
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

    fn method(
        &mut self,
        method: &'static dyn Method,
        scene: &Scene,
        known: LinearPart,
    ) -> Result<Tried, Error> {
        let operator = Operator {
            method,
            scene,
            records: self.records,
            rows: &self.plan.fitted,
            period: self.plan.period,
            substeps: linear_part::substeps(&known, self.plan.period),
        };
        let (longest, search) = (self.plan.longest_delay, self.plan.search);
        let fit = operator.fit(known, longest, search, self.observer)?;
        let solved = &fit.solved;
        let chain = method.chain(scene, &solved.shape, &solved.weights, solved.offset);
        let actuator = Actuator::Chain(&chain);
        let (linear, deviations) = (solved.linear, fit.deviations);
        let name = Some(method.name());
        let substeps = operator.substeps;
        let mut tried = self.tried(name, &actuator, solved.offset, linear, deviations, substeps)?;
        tried.parameters = estimates::of_operator(&self.plan, &self.target.axis, &operator, &fit);
        Ok(tried)
    }

    /// Plays between two curves, and the network over them that learns what they leave.
    fn network(&mut self, scene: &Scene, known: LinearPart) -> Result<Tried, Error> {
        let operator = Operator {
            method: CURVED,
            scene,
            records: self.records,
            rows: &self.plan.fitted,
            period: self.plan.period,
            substeps: 1,
        };
        // The curve of the position stands in the component: a mode behind it is none of this model.
        let known = LinearPart { mode: None, ..known };
        let (longest, search) = (self.plan.longest_delay, self.plan.search);
        let fit = operator.fit(known, longest, search, self.observer)?;
        let (linear, deviations) = (fit.solved.linear, fit.deviations);
        let solved = &fit.solved;
        let chain = CURVED.chain(scene, &solved.shape, &solved.weights, solved.offset);
        let plays =
            network::Plays::of(&chain).ok_or_else(|| Error::no_solution("it has no plays"))?;
        let period = self.plan.period;
        let mut lessons = Vec::with_capacity(self.records.len());
        for (record, rows) in self.records.iter().zip(&self.plan.fitted) {
            let mut before = before_hysteresis(&linear, period)?;
            let substeps = record.periods(period);
            let input = &record.input()[..rows.end.min(record.len())];
            lessons.push(network::Lesson {
                signal: through(&mut before, record.rest(), input, substeps),
                substeps,
                first: rows.first,
                position: rows.of(record.output()).to_vec(),
            });
        }
        let bounds: Vec<(f64, f64)> =
            CURVED.shape(scene).iter().map(|shape| (shape.lower, shape.upper)).collect();
        let (component, training_note) = plays.learn(&lessons, period, &bounds, self.observer)?;
        let chain = Chain::of(component);
        let actuator = Actuator::Chain(&chain);
        let mut tried =
            self.tried(Some(NETWORK), &actuator, solved.offset, linear, deviations, 1)?;
        tried.numbers = Some(plays.numbers());
        tried.training_note = Some(training_note);
        Ok(tried)
    }

    /// A learned machine with the linear part behind it, in the place of operator, lag and mode.
    fn learned(&mut self, family: Family, known: LinearPart) -> Result<Tried, Error> {
        if let Some(other) = self.records.iter().find(|r| r.periods(self.plan.period) > 1) {
            let message = format!(
                "{} learns from records of one rate; {} has {} s, others less: resample them",
                family.name(),
                other.name(),
                other.period()
            );
            return Err(Error::Learned { message });
        }
        let lesson = Lesson {
            family,
            records: self.records,
            fitted: &self.plan.fitted,
            judged: &self.plan.judged,
            offsets: &self.offsets,
            period: self.plan.period,
            known,
            stops: self.plan.thresholds.len(),
            learning: self.plan.learning,
            dynamic: self.plan.dynamics == Dynamics::Automatic,
        };
        let file = format!("{}.npy", self.target.axis.name);
        let Learned { chain, table, late, numbers, predicted } =
            lesson.learn(&file, &mut *self.observer)?;
        let chain = Chain { hysteresis: chain, reading: Vec::new() };
        let delay = late as f64 * self.plan.period;
        let plant = Plant {
            actuator: Actuator::Chain(&chain),
            offset: 0.0,
            linear: LinearPart { delay, ..LinearPart::default() },
            deviations: Deviations::default(),
            step: self.plan.period,
            table: Some((file, table)),
        };
        let kinds = chain.hysteresis.iter().map(|component| component.kind.as_str());
        let structure = (late > 0).then_some("delay").into_iter().chain(kinds);
        let structure = structure.collect::<Vec<_>>().join(", ");
        let mut tried = self.written(Some(family.name()), structure, &plant)?;
        (tried.numbers, tried.predicted) = (Some(numbers), predicted);
        Ok(tried)
    }
}

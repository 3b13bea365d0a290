//! From records to a plant: baseline, hysteresis with delay, linear parts, and the choice.

mod other_methods;
mod outcome;

use data::CheckedBlueprint;

use crate::error::Error;
use crate::estimates;
use crate::fit::coordinates::{Deviations, Structure};
use crate::fit::delay;
use crate::fit::linear_part;
use crate::fit::operator::{Fit, Operator};
use crate::fit::response::LinearPart;
use crate::identification::{Candidate, Estimate, Identification, Predicted};
use crate::judge::simulate;
use crate::methods::{Chain, FitContext, GAIN, Method, STATIC};
use crate::observer::Observer;
use crate::plant::Plant;
use crate::record::Record;
use crate::settings::{Dynamics, Plan, Settings, Target};
use crate::structure;

/// Relative fall of the held-out error from which a linear part is kept.
pub const SIGNIFICANT_FALL: f64 = 0.10;
/// Part of the measured range that a model must move by.
const STILL: f64 = 1e-6;

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
///    the simplest first, by the same rule. Among methods that are named the best is returned, and the static model only
///    where it is one of them; an error where none has a model. A model that nothing moves is never
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
    let scene = plan.scene(records);
    let offsets = vec![0.0; records.len()];
    let mut session = Session { records, target, plan: &plan, scene: &scene, observer, offsets };
    let baseline = session.line()?;
    let (delayed_line, _) = session.with_delay(GAIN, "straight line with delay")?;
    let (static_model, offsets) = session.with_delay(STATIC, "hysteresis and delay")?;
    session.offsets = offsets;
    let mut candidates = vec![
        session.candidate(&baseline, "the baseline, for comparison"),
        session.candidate(
            &delayed_line,
            "for comparison: at one frequency and amplitude a delay passes for hysteresis",
        ),
        session.candidate(&static_model, "the simplest model with hysteresis"),
    ];
    let (mut linear, mut plays) = (delayed_line, static_model);
    let mut stopped = session.observer.stopped();
    if session.plan.dynamics == Dynamics::Automatic {
        for (method, best) in [(GAIN, &mut linear), (STATIC, &mut plays)] {
            if stopped || method.name() == GAIN.name() && !session.plan.linear {
                continue;
            }
            match session.linear_parts(method, best, &mut candidates) {
                Ok(()) => {}
                Err(Error::Stopped) => stopped = true,
                Err(error) => return Err(error),
            }
        }
    }
    let mut best = plays.clone();
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
        stopped = session.other_methods([&linear, &plays], &mut best, &mut candidates)?;
    }
    for candidate in &mut candidates {
        candidate.accepted = is_of(candidate, &best);
    }
    Ok(session.result(baseline, best, candidates, stopped))
}

fn is_of(candidate: &Candidate, tried: &Tried) -> bool {
    candidate.method == tried.method && candidate.structure == tried.structure
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
    plan: &'a Plan,
    scene: &'a FitContext,
    observer: &'a mut dyn Observer,
    /// Of each record, by the static model.
    offsets: Vec<f64>,
}

impl<'a> Session<'a> {
    /// The fit of a method, one internal step per sample.
    fn operator(&self, method: &'static dyn Method) -> Operator<'a> {
        Operator {
            method,
            scene: self.scene,
            records: self.records,
            rows: &self.plan.fitted,
            period: self.plan.period,
            substeps: 1,
        }
    }

    /// The best straight line.
    fn line(&self) -> Result<Tried, Error> {
        let operator = self.operator(GAIN);
        let solved = operator.solve(LinearPart::default(), &[])?;
        let mut tried = self.fitted(&operator, &Fit::of(solved, Deviations::default()))?;
        // It is there to compare with.
        tried.method = None;
        Ok(tried)
    }

    /// A model with delay alone, and the offset of each record.
    fn with_delay(
        &mut self,
        method: &'static dyn Method,
        stage: &'static str,
    ) -> Result<(Tried, Vec<f64>), Error> {
        let operator = self.operator(method);
        let mut report = |done, total| self.observer.progress(stage, done, total);
        let fit = delay::search(&operator, self.plan.longest_delay, &mut report)?;
        Ok((self.fitted(&operator, &fit)?, fit.solved.offsets))
    }

    /// Lag, mode and both around a method without a shape; the best so far is where they begin.
    fn linear_parts(
        &mut self,
        method: &'static dyn Method,
        best: &mut Tried,
        candidates: &mut Vec<Candidate>,
    ) -> Result<(), Error> {
        let (without, first) = (best.held_out_rmse, best.linear);
        let mut found = Vec::new();
        for (lag, mode) in [(true, false), (false, true), (true, true)] {
            let structure = Structure { lag, mode };
            // A mode alone imitates a lag below it, and no way leads from there to both; the lag alone lies nearer.
            let known = if lag && mode && !found.is_empty() { &found[..] } else { &[first] };
            let tried = match self.linear_part(method, structure, known) {
                Ok(tried) => tried,
                // A structure that the data do not support is no reason to return nothing.
                Err(error @ Error::NoSolution { .. }) => {
                    let name = structure::name_of(method, structure);
                    candidates.push(Candidate::failed(Some(method.name()), name, &error));
                    continue;
                }
                Err(error) => return Err(error),
            };
            found.push(tried.linear);
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

    /// The best fit of a structure from these simpler ones on.
    fn linear_part(
        &mut self,
        method: &'static dyn Method,
        structure: Structure,
        known: &[LinearPart],
    ) -> Result<Tried, Error> {
        let stage = match (structure.lag, structure.mode) {
            (true, true) => "amplifier lag and mode",
            (_, true) => "mode",
            (_, false) => "amplifier lag",
        };
        let longest = self.plan.longest_delay;
        let mut best: Result<(Operator<'_>, Fit), Error> =
            Err(Error::no_solution("there is nothing to start from"));
        for known in known {
            let mut operator = self.operator(method);
            let mut report = |done, total| self.observer.progress(stage, done, total);
            let fit = linear_part::fit(&mut operator, structure, longest, known, &mut report);
            if self.observer.stopped() {
                return Err(Error::Stopped);
            }
            match (fit, &best) {
                (Ok(fit), Ok((_, least))) if fit.solved.cost() >= least.solved.cost() => {}
                (Ok(fit), _) => best = Ok((operator, fit)),
                (Err(error @ Error::NoSolution { .. }), Err(_)) => best = Err(error),
                (Err(Error::NoSolution { .. }), Ok(_)) => {}
                (Err(error), _) => return Err(error),
            }
        }
        let (operator, fit) = best?;
        self.fitted(&operator, &fit)
    }

    /// The model of a fit.
    fn fitted(&self, operator: &Operator<'_>, fit: &Fit) -> Result<Tried, Error> {
        let (method, solved) = (operator.method, &fit.solved);
        let offset = solved.offset();
        let mut chain = method.chain(self.scene, &solved.shape, &solved.weights, offset);
        if let Some(weights) = method.tolerance()
            && let Some(relative) = estimates::relative_deviation(solved)
        {
            let parts = chain.hysteresis.into_iter();
            chain.hysteresis = parts.map(|part| part.tolerance(weights, relative)).collect();
        }
        let step = self.plan.period / operator.substeps as f64;
        let mut tried = self.tried(method.name(), &chain, solved.linear, fit.deviations, step)?;
        tried.parameters = estimates::of(self.plan, &self.target.axis, operator, fit);
        Ok(tried)
    }

    fn tried(
        &self,
        method: &'static str,
        chain: &Chain,
        linear: LinearPart,
        deviations: Deviations,
        step: f64,
    ) -> Result<Tried, Error> {
        let structure = structure::describe(method, chain, &linear);
        self.written(method, structure, &Plant { chain, linear, deviations, step, table: None })
    }

    /// What is found, simulated as it will be written.
    fn written(
        &self,
        method: &'static str,
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
        Ok(Tried {
            method: Some(method),
            structure,
            plant,
            simulations,
            held_out_rmse,
            linear,
            parameters: Vec::new(),
            numbers: None,
            predicted: None,
            training_note: None,
            seconds: 0.0,
        })
    }
}

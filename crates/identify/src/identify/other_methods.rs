//! The methods that were asked for.

use super::SIGNIFICANT_FALL;
use super::STILL;
use super::Session;
use super::Tried;
use crate::error::Error;
use crate::fit::coordinates::Deviations;
use crate::fit::linear_part;
use crate::fit::operator::Operator;
use crate::fit::operator::through;
use crate::fit::response::LinearPart;
use crate::fit::response::before_hysteresis;
use crate::identification::Candidate;
use crate::identification::Estimate;
use crate::identification::Verdict;
use crate::learned::family::Family;
use crate::learned::network;
use crate::learned::plant::Learned;
use crate::learned::plant::TrainingSet;
use crate::methods::CURVED;
use crate::methods::Chain;
use crate::methods::Method;
use crate::methods::NETWORK;
use crate::methods::STATIC;
use crate::methods::Strategy;
use crate::plant::Plant;
use crate::settings::Dynamics;
use std::time::Instant;

impl Session<'_> {
    /// Tries the methods, the simplest first; those that find linear parts were tried already. Whether the observer
    /// stopped it.
    pub(super) fn other_methods(
        &mut self,
        tried_already: [&Tried; 2],
        best: &mut Tried,
        candidates: &mut Vec<Candidate>,
    ) -> Result<bool, Error> {
        let known = best.linear;
        let mut first = self.plan.named;
        let mut failures = Vec::new();
        for method in self.plan.methods.clone() {
            if let Some(tried) = tried_already.iter().find(|t| t.method == Some(method.name())) {
                if self.plan.named && (first || tried.held_out_rmse < best.held_out_rmse) {
                    (*best, first) = ((*tried).clone(), false);
                }
                continue;
            }
            if self.observer.stopped() {
                return Ok(true);
            }
            let started = Instant::now();
            let tried = match method {
                Strategy::Operator(method) => self.method(method, known),
                Strategy::Learned(family) => self.learned(family, known),
                Strategy::Network => self.network(known),
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
                Strategy::Operator(method) => self.open_shape(&tried, method),
                Strategy::Learned(_) | Strategy::Network => Vec::new(),
            };
            let mut reason = format!(
                "held-out error {:+.1} % against {} ({:.0} % less is needed)",
                -100.0 * fall,
                best.method.unwrap_or(STATIC.name()),
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
    pub(super) fn moved(&self, tried: Tried) -> Result<Tried, Error> {
        let height = |values: &[f64]| crate::settings::range(values);
        let mut each = self.records.iter().zip(&tried.simulations);
        if each.any(|(record, simulated)| height(simulated) > STILL * height(record.output())) {
            return Ok(tried);
        }
        let message = "the command moves nothing: the fit left every weight at 0; the records say nothing of this \
                       model, or it has another sign"
            .to_owned();
        Err(Error::Model { name: tried.method.unwrap_or(STATIC.name()).to_owned(), message })
    }

    /// Parameters of the shape, and weights of any sign, that the records leave uncertain: a model that rests on them fits these
    /// records and need not fit others.
    pub(super) fn open_shape(&self, tried: &Tried, method: &dyn Method) -> Vec<String> {
        let scene = self.scene;
        let weights = method.weights(scene);
        let free = weights.names.into_iter().take(weights.free).map(|(name, _)| name);
        let shapes = method.shape(scene).into_iter().map(|s| s.name.into_owned());
        let named: Vec<String> = shapes.chain(free).collect();
        let uncertain = |p: &&Estimate| p.verdict == Verdict::Uncertain;
        let of_shape = |p: &&Estimate| named.contains(&p.name);
        tried.parameters.iter().filter(uncertain).filter(of_shape).map(|p| p.name.clone()).collect()
    }

    pub(super) fn method(
        &mut self,
        method: &'static dyn Method,
        known: LinearPart,
    ) -> Result<Tried, Error> {
        let substeps = linear_part::substeps(&known, self.plan.period);
        let operator = Operator { substeps, ..self.operator(method) };
        let (longest, search) = (self.plan.longest_delay, self.plan.search);
        let fit = operator.fit(known, longest, search, self.observer)?;
        self.fitted(&operator, &fit)
    }

    /// Plays between two curves, and the network over them that learns what they leave.
    pub(super) fn network(&mut self, known: LinearPart) -> Result<Tried, Error> {
        let (operator, scene) = (self.operator(CURVED), self.scene);
        // The curve of the position stands in the component: a mode behind it is none of this model.
        let known = LinearPart { mode: None, ..known };
        let (longest, search) = (self.plan.longest_delay, self.plan.search);
        let fit = operator.fit(known, longest, search, self.observer)?;
        let (linear, deviations) = (fit.solved.linear, fit.deviations);
        let solved = &fit.solved;
        let chain = CURVED.chain(scene, &solved.shape, &solved.weights, solved.offset());
        let plays =
            network::Plays::of(&chain).ok_or_else(|| Error::no_solution("it has no plays"))?;
        let period = self.plan.period;
        let mut lessons = Vec::with_capacity(self.records.len());
        for (record, rows) in self.records.iter().zip(&self.plan.fitted) {
            let mut before = before_hysteresis(&linear, period)?;
            let substeps = record.periods(period);
            let input = &record.input()[..rows.end.min(record.len())];
            lessons.push(network::TrainingRecord {
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
        let mut tried = self.tried(NETWORK, &chain, linear, deviations, period)?;
        tried.numbers = Some(plays.numbers());
        tried.training_note = Some(training_note);
        Ok(tried)
    }

    /// A learned machine with the linear part behind it, in the place of operator, lag and mode.
    pub(super) fn learned(&mut self, family: Family, known: LinearPart) -> Result<Tried, Error> {
        if let Some(other) = self.records.iter().find(|r| r.periods(self.plan.period) > 1) {
            let message = format!(
                "{} learns from records of one rate; {} has {} s, others less: resample them",
                family.name(),
                other.name(),
                other.period()
            );
            return Err(Error::Learned { message });
        }
        let lesson = TrainingSet {
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
        let Learned { chain, table, delay, numbers, predicted } =
            lesson.learn(&file, &mut *self.observer)?;
        let chain = Chain { hysteresis: chain, reading: Vec::new() };
        let delay = delay as f64 * self.plan.period;
        let plant = Plant {
            chain: &chain,
            linear: LinearPart { delay, ..LinearPart::default() },
            deviations: Deviations::default(),
            step: self.plan.period,
            table: Some((file, table)),
        };
        let kinds = chain.hysteresis.iter().map(|component| component.kind.as_str());
        let structure = (delay > 0.0).then_some("delay").into_iter().chain(kinds);
        let structure = structure.collect::<Vec<_>>().join(", ");
        let mut tried = self.written(family.name(), structure, &plant)?;
        (tried.numbers, tried.predicted) = (Some(numbers), predicted);
        Ok(tried)
    }
}

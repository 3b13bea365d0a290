//! From the gap between a machine and its model to the physical effects that cause it.
//!
//! ```text
//! model + logs ─▶ residual in simulation mode ─▶ re-tune under tolerance ─▶ candidates: screen, fit
//!     ─▶ held-out acceptance, sets, probabilities ─▶ where, how much, what next, repaired model
//! ```
//!
//! [`diagnose`] gives the answer as [`Gap`], the content of `gap.json`.
//!
//! The files in layers, the lowest first, each of which knows those before it:
//!
//! ```text
//! data_set ─▶ parameter, chain (with its nodes) ─▶ fit ─▶ score ─▶ formula ─▶ base ─▶ candidate ─▶ library ─▶ belief
//!     ─▶ select ─▶ task, tasks ─▶ outcome ─▶ stages ─▶ course, coupled ─▶ answer, repair, repaired_fmu, page
//! ```

mod answer;
mod axis_group;
mod base;
mod belief;
mod between;
mod black_box;
mod candidate;
mod causal;
mod chain;
mod converter;
mod coupled;
mod course;
mod data_set;
mod discrepancy;
mod error;
mod excess_noise;
mod experiment;
pub mod figures;
mod fit;
mod fmu;
mod formula;
mod gap;
mod jitter;
mod left_out;
mod library;
mod new_record;
mod noise;
mod normal;
mod nuisance;
mod offset;
mod outcome;
mod own_course;
mod page;
mod parameter;
mod path_block;
mod place;
mod port;
mod repair;
mod repaired_fmu;
mod request;
mod robust;
mod score;
mod second;
mod select;
mod sentence;
mod setting;
mod shrink;
mod spectrum;
mod stages;
mod stand_in;
mod start;
mod steps;
mod tap;
mod task;
mod tasks;
mod thresholds;

use std::borrow::Cow;
use std::sync::atomic::{AtomicU64, Ordering};

pub use between::{Between, Reading};
pub use error::Error;
pub use gap::{
    BandShare, Baseline, Discrepancy, Estimate, Gap, HeldOut, Leftover, ModelKind, NamedEffect,
    NextExperiment, NoiseFloor, OutputGap, Partial, Place, Provenance, RecordShare, Retuned,
    SCHEMA, Shrink, Tried, Verdict,
};
pub use identify::{Observer, Silent};
pub use repair::is_linear;
pub use repaired_fmu::{Repaired, preset};
pub use request::{Deviation, Model, Noise, Request, Tolerance};

/// Part of each record, at its end, that is held out where no log is given to be held out.
pub const HELD_OUT: f64 = thresholds::base::Thresholds::HELD_OUT;
/// Error power that another reading of the logs must leave at most, over what the usual reading leaves, to be taken.
pub const READING_LESS: f64 = thresholds::base::Thresholds::READING_LESS;

/// The answer with what is needed to draw it and to repair the model.
pub struct Diagnosis {
    /// The answer.
    pub gap: Gap,
    outcomes: Vec<outcome::Outcome>,
    worker: Option<cosim::Worker>,
}

/// What was written beside the page.
#[derive(Clone, Copy, Debug, Default)]
pub struct Files<'a> {
    /// The repaired model.
    pub repair: Option<&'a std::path::Path>,
    /// What the repaired model leaves out, one sentence each.
    pub notes: &'a [String],
    /// The signal of the next experiment.
    pub experiment: Option<&'a std::path::Path>,
}

impl Diagnosis {
    /// What the FMU that was diagnosed did beside its answers, in sentences: failures with other
    /// inputs or parameters than its own, what it changed of the program that ran it.
    #[must_use]
    pub fn incidents(&self) -> Vec<String> {
        let boxes = self.outcomes.iter().flat_map(|outcome| outcome.task.base.black_boxes());
        let mut all: Vec<String> = boxes.flat_map(|fmu| fmu.incidents()).collect();
        all.sort();
        all.dedup();
        all
    }

    /// The page; the caller adds its provenance.
    #[must_use]
    pub fn report(&self, files: &Files<'_>) -> report::Report {
        page::report(self, files)
    }

    /// The gap of the first output over its command, before and after, in the record in which the
    /// command changes most slowly, as an SVG picture.
    #[must_use]
    pub fn picture(&self) -> Option<String> {
        page::picture(self)
    }

    /// The signal of the next experiment as a log without readings, to be played; none where nothing
    /// is undecided.
    #[must_use]
    pub fn next_experiment_csv(&self) -> Option<String> {
        let next = self.gap.next_experiment.as_ref()?;
        let own = |o: &&outcome::Outcome| next.columns.contains_key(&o.task.input);
        experiment::csv(self.outcomes.iter().find(own)?, next)
    }

    /// The FMU that was diagnosed with the effects around it; `library` is the platform and the bytes
    /// of the library for repaired FMUs.
    ///
    /// # Errors
    /// [`Error`]: an FMU that cannot be put into another one.
    pub fn repair_fmu(
        &self,
        file: &std::path::Path,
        names: &data::NameMap,
        libraries: &[(&str, &[u8])],
    ) -> Result<Repaired, Error> {
        let fmu = fmu::open(file, self.worker.as_ref())?;
        let archive = match file.is_dir() {
            true => file.join("modelDescription.xml"),
            false => file.to_path_buf(),
        };
        let sha256 = report::InputFile::read("original", archive)?.sha256;
        let (repair, notes) = repaired_fmu::repair(&self.outcomes, &fmu, names, &sha256)?;
        repaired_fmu::pack(fmu.package(), &repair, notes, libraries)
    }

    /// The blueprint that was diagnosed with re-tuned values and the linear dynamics that were found (modes, lags, delays,
    /// and what passes from the command to the reading); none where none were. A model that was identified from the same
    /// logs may lack them, whatever the machine is.
    #[must_use]
    pub fn linear_parts(&self, blueprint: &data::Blueprint) -> Option<data::Blueprint> {
        let mut completed = blueprint.clone();
        let mut has_any = false;
        for outcome in &self.outcomes {
            let mut own = completed.clone();
            if repair::linear_parts(outcome, outcome.task.axis, &mut own) {
                (completed, has_any) = (own, true);
            }
        }
        has_any.then_some(completed)
    }

    /// The blueprint that was diagnosed with re-tuned values and the effects in place. Disturbances of a
    /// record (drift, hum, lines) are no part of a model and stay out.
    ///
    /// Beside it what stays out of it, one sentence each. The answer's `shrink` then is that of the
    /// repaired blueprint, as it is written.
    #[must_use]
    pub fn repair(&mut self, blueprint: &data::Blueprint) -> (data::Blueprint, Vec<String>) {
        let mut repaired = blueprint.clone();
        let (mut notes, mut after) = (Vec::new(), Vec::new());
        let finer = self.outcomes.iter().map(|o| &o.task.data).filter(|data| data.is_finer);
        if let Some(step) = finer.map(|data| data.step).min_by(f64::total_cmp) {
            repaired.step = data::Value::Number(step);
            let is_within = self.outcomes.iter().any(|o| o.task.data.within.is_some());
            let why = if is_within {
                "a reading lies within a row"
            } else {
                "its command moves between rows"
            };
            notes.push(format!("the step of the repaired blueprint is {step} s, as {why}"));
        }
        repair::write_joint(&self.outcomes, &mut repaired);
        for outcome in &self.outcomes {
            let (own, judged) = repair::repair(outcome, outcome.task.axis, &mut repaired);
            notes.extend(own);
            after.push(judged);
        }
        for (outcome, after) in self.outcomes.iter().zip(&mut after) {
            let together = repair::judged_as_written(outcome, blueprint, &repaired);
            *after = together.or(after.take());
        }
        answer::hand_back(&mut self.gap, &self.outcomes, &after);
        (repaired, notes)
    }
}

/// Diagnoses the gap between a model and measured logs.
///
/// The same request gives the same answer for any number of threads.
///
/// # Errors
/// [`Error`]: logs, names, options or models that do not go together.
pub fn diagnose(request: &Request, observer: &mut dyn Observer) -> Result<Gap, Error> {
    Ok(examine(request, observer)?.gap)
}

/// Diagnoses the gap between a model and measured logs, with what the page and the repair need.
///
/// # Errors
/// [`Error`]: logs, names, options or models that do not go together.
pub fn examine(request: &Request, observer: &mut dyn Observer) -> Result<Diagnosis, Error> {
    let pool =
        numerics::threads::pool(request.threads).map_err(|_| Error::Threads(request.threads))?;
    let count = AtomicU64::new(0);
    let mut outcomes = outcomes(request, observer, (&pool, &count))?;
    let open = outcomes.iter().filter(|_| request.drop.is_none());
    let motion = open.filter_map(|o| start::in_motion(&o.task, &o.found.last.judged));
    let motion = motion.max_by(|a, b| a.1.total_cmp(&b.1));
    let mut request = Cow::Borrowed(request);
    if let Some((record, drop)) = motion {
        request.to_mut().drop = Some(drop);
        outcomes = self::outcomes(&request, observer, (&pool, &count))?;
        if let Some(first) = outcomes.first_mut() {
            first.task.warnings.push(format!(
                "{record} begins during a motion: the first {drop} s of each record are neither fitted nor judged \
                 (--drop 0 uses them)"
            ));
        }
    }
    let gap = pool.install(|| answer::gap(&request, &outcomes, count.load(Ordering::Relaxed)));
    Ok(Diagnosis { gap, outcomes, worker: request.worker.clone() })
}

/// The diagnosis of each output.
fn outcomes(
    request: &Request,
    observer: &mut dyn Observer,
    (pool, count): (&rayon::ThreadPool, &AtomicU64),
) -> Result<Vec<outcome::Outcome>, Error> {
    let tasks = tasks::of(request)?;
    let total = tasks.len();
    let (mut outcomes, mut fresh) = (Vec::with_capacity(total), Vec::with_capacity(total));
    for (number, task) in tasks.into_iter().enumerate() {
        observer.progress("diagnose", number, total);
        let boxes = task.base.black_boxes();
        let is_joined = task.base.joint().is_some() || !boxes.is_empty();
        fresh.push((total > 1 && is_joined).then(|| task.clone()));
        let outcome = pool.install(|| course::settled(task, request, count));
        // Without its FMU a search finds nothing; what it says of that is no answer.
        boxes.iter().try_for_each(black_box::BlackBox::is_alive)?;
        outcomes.push(
            outcome.map_err(|error| {
                boxes.iter().find_map(|fmu| fmu.reason(&error)).unwrap_or(error)
            })?,
        );
    }
    pool.install(|| coupled::together(&mut outcomes, &fresh, request, count))?;
    pool.install(|| coupled::with_hints_of_others(&mut outcomes, &fresh, request, count));
    pool.install(|| coupled::in_readings(&mut outcomes, request, count))?;
    observer.progress("diagnose", total, total);
    Ok(outcomes)
}

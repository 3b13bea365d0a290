//! The diagnosis of one output, stage by stage.
//!
//! ```text
//! task ─▶ noise ─▶ base ─▶ search ─▶ belief ─▶ repair ─▶ outcome
//! ```
//!
//! | stage | takes | gives |
//! |---|---|---|
//! | noise | the logs and the model | size and colour of the noise, and up to which error nothing is left |
//! | base | the noise | the re-tuned model and the model as given, both judged by that noise |
//! | search | the base | the effects that can act, and those that are found, with the rivals of each |
//! | belief | what was found | the same under the noise that the effects reveal, and the verdict |
//! | repair | what is believed | the offset and the evidence that belong to the repaired model |
//!
//! From the outcomes of all outputs `answer` puts the answer together.

mod again;
mod noise_level;

use std::sync::OnceLock;
use std::sync::atomic::AtomicU64;

use components::effects;
use surround::Span;

use self::again::drifts_alike;
pub(crate) use self::again::with_known_reading;
use self::noise_level::{quieter, settle_noise};

use crate::candidate::{Candidate, Found, has_gap};
use crate::data_set::DataSet;
use crate::error::Error;
use crate::fit::Fitter;
use crate::formula::Family;
use crate::gap::Verdict;
use crate::library;
use crate::noise::Shape;
use crate::outcome::Outcome;
use crate::own_course;
use crate::request::Request;
use crate::score::{Judge, Judged};
use crate::select::{Memo, Search};
use crate::sentence::together;
use crate::setting::{setting, simulated_span};
use crate::steps::Steps;
use crate::task::Task;
use crate::thresholds::base::Thresholds as BaseThresholds;
use crate::thresholds::belief::Thresholds as BeliefThresholds;
use crate::thresholds::noise::Thresholds;
use crate::{causal, excess_noise, offset, robust, second, shrink, start};

/// Diagnoses one output.
///
/// # Errors
/// [`Error::Model`]: the model cannot be simulated over the logs.
pub(crate) fn of(task: Task, request: &Request, count: &AtomicU64) -> Result<Outcome, Error> {
    let memo = Memo::default();
    let run = Run { request, count, memo: &memo };
    let (task, level) = run.noise(task)?;
    let (task, base) = run.base(task, level)?;
    let (task, searched) = run.search(task, base)?;
    let (task, believed) = run.belief(task, searched);
    let outcome = run.repair(task, believed);
    if !drifts_alike(&outcome) {
        return Ok(outcome);
    }
    let memo = Memo::default();
    Run { request, count, memo: &memo }.without_courses(outcome)
}

/// What all stages of one diagnosis share.
struct Run<'a> {
    request: &'a Request,
    /// Simulations so far.
    count: &'a AtomicU64,
    /// Parts of the search that are known.
    memo: &'a Memo,
}

/// The noise, and the fit whose residual shows it.
struct Level {
    shape: Shape,
    /// Part of the noise's power up to which nothing is left.
    sure: f64,
    /// The re-tuned model, judged by white noise of the size `guess`.
    retuned: Candidate,
    /// Standard deviation of the noise in SI before it was settled.
    guess: f64,
}

/// By what residuals are measured.
struct Scale {
    judge: Judge,
    /// Standard deviation of the noise in SI.
    sigma: f64,
    /// Part of the noise's power up to which nothing is left, whatever the user calls good enough.
    sure: f64,
    /// Mean square over the noise's up to which nothing is left.
    adequate: f64,
    /// What the user calls good enough, in powers of the noise.
    fine: f64,
}

impl Scale {
    /// Nothing is left within `sure` times the noise's power, nor within what the user calls good enough.
    fn new(task: &Task, shape: Shape, sigma: f64, sure: f64, request: &Request) -> Self {
        let fine = (request.accuracy * 2.0 * task.data.output_span.half / sigma).powi(2);
        let judge = Judge::new(&task.data, shape);
        Self { judge, sigma, sure, adequate: sure.max(1.0 + fine), fine }
    }
}

/// The re-tuned model, the model as given, and by what both are measured.
struct Base {
    retuned: Candidate,
    given: Judged,
    scale: Scale,
    /// Span of the simulated output.
    position: Span,
}

/// What was found.
struct Searched {
    /// The effects that can act in these logs.
    library: Vec<Family>,
    found: Found,
    given: Judged,
    scale: Scale,
    /// Whether the command moves the output out of its noise.
    moves: bool,
    /// Standard deviation of the noise over the stated one, where that is all that is missing.
    noise_ratio: Option<f64>,
}

/// What is believed of it.
struct Believed {
    searched: Searched,
    verdict: Verdict,
    /// Whether the re-tuned model leaves something to explain.
    has_gap: bool,
}

impl Run<'_> {
    /// Noise: its size, its colour, and up to which error nothing is left.
    ///
    /// The noise is seen in what the re-tuned model leaves. The fit does not depend on the noise's size; it is made
    /// again where the first readings show that the machine rested under another command than the model.
    fn noise(&self, mut task: Task) -> Result<(Task, Level), Error> {
        let guess = task.noise.sigma * task.factor;
        let white = Scale::new(&task, Shape::WHITE, guess, f64::INFINITY, self.request);
        let mut retuned = self.retuned(&task, &white)?;
        if start::find(&mut task, &retuned, self.count) {
            retuned = self.retuned(&task, &white)?;
        }
        let (shape, sure) = settle_noise(&mut task, &retuned.judged.residual);
        Ok((task, Level { shape, sure, retuned, guess }))
    }

    /// Base: the re-tuned model and the model as given, in standard deviations of the noise. Nothing is fitted again, unless
    /// the fitted rows do not determine the parameters.
    fn base(&self, task: Task, level: Level) -> Result<(Task, Base), Error> {
        let Level { shape, sure, retuned, guess } = level;
        let sigma = task.noise.sigma * task.factor;
        let scale = Scale::new(&task, shape, sigma, sure, self.request);
        let search = self.search_in(&task, &[], &scale);
        let retuned = search.judged_again(retuned, sigma / guess).map_err(|_| cannot_run(&task))?;
        let values = vec![0.0; retuned.chain.parameters.len()];
        let given = scale.judge.judge(&retuned.chain, &values, &task.data, sigma, self.count);
        let given = given.map_err(|_| cannot_run(&task))?;
        let position = simulated_span(&retuned, &task.data, self.count);
        let position = position.unwrap_or(task.data.output_span);
        Ok(self.over_all_rows(task, Base { retuned, given, scale, position }))
    }

    /// The base with the model fitted to all rows, where that leaves nothing. Parameters that the fitted rows do not
    /// determine predict nothing: what they leave on the held-out rows is no missing effect.
    fn over_all_rows(&self, mut task: Task, base: Base) -> (Task, Base) {
        let Base { retuned, scale, .. } = &base;
        // What the fitted rows show stays when more are fitted.
        let is_held_out_alone = retuned.judged.training <= scale.adequate;
        if !has_gap(retuned, scale.adequate) || !is_held_out_alone {
            return (task, base);
        }
        let Some(data) = task.data.with_all_rows() else { return (task, base) };
        let search = self.search_in(&task, &[], scale);
        let fitter = Fitter { data: &data, ..search.fitter() };
        let fit = fitter.fit_again(&retuned.chain, &retuned.fit.theta);
        let all = fit.and_then(|fit| search.candidate(Vec::new(), retuned.chain.clone(), fit));
        let Some(all) = all.ok().filter(|all| !has_gap(all, scale.adequate)) else {
            return (task, base);
        };
        let unit = scale.sigma / task.factor;
        task.warnings.push(format!(
            "{}: the parameters are fitted to all rows, none is held out: fitted to the first part of each log they leave \
             {} {} rms on the rest, fitted to all rows {}; a log that moves more determines them",
            task.output,
            report::format_number(unit * retuned.judged.held_out.sqrt(), 4),
            task.unit,
            report::format_number(unit * all.judged.held_out.sqrt(), 4),
        ));
        (task, Base { retuned: all, ..base })
    }

    /// Search: the effects that explain the gap, each with its rivals, among those that can act in these logs. The task
    /// loses steps of the reading that the model makes.
    fn search(&self, mut task: Task, base: Base) -> Result<(Task, Searched), Error> {
        let Base { retuned, scale, position, .. } = &base;
        task.steps = task.steps.filter(|_| !moves_in_steps(&task, retuned, scale.sigma));
        let setting = setting(&task, retuned, *position, scale.sigma);
        let mut library = library::families(&setting, &self.request.without);
        // The values show the steps better than any fit.
        library
            .retain(|f| task.steps.is_none() || f.effect.name != effects::SENSOR_QUANTISATION.name);
        let searched = self.search_among(&task, library, base)?;
        Ok((task, searched))
    }

    /// The search among these effects. Nothing is searched where no error is left, or where a reading that is noisier than
    /// stated is all of it.
    fn search_among(
        &self,
        task: &Task,
        library: Vec<Family>,
        base: Base,
    ) -> Result<Searched, Error> {
        let Base { retuned, given, mut scale, position } = base;
        let moves = position.half > BaseThresholds::MOVES * scale.sigma
            && task.data.command_span.half > 0.0;
        let is_open = has_gap(&retuned, scale.adequate);
        let is_asked = !self.request.without.iter().any(|n| n == effects::SENSOR_NOISE.name);
        let noise_ratio = (is_open && is_asked && task.noise.source == "given")
            .then(|| excess_noise::ratio(&retuned.judged.residual, &task.data))
            .flatten();
        let found = if is_open && noise_ratio.is_none() {
            scale.judge.is_course_own = own_course::is_own(&task.data, &retuned.judged.residual);
            self.search_in(task, &library, &scale).run(retuned).map_err(|_| cannot_run(task))?
        } else {
            Found::nothing(retuned)
        };
        Ok(Searched { library, found, given, scale, moves, noise_ratio })
    }

    /// Belief: what was found, judged by the noise that the effects reveal, and the verdict.
    fn belief(&self, task: Task, searched: Searched) -> (Task, Believed) {
        let (mut task, searched) = self.with_quieter_noise(task, searched);
        let Searched { library, found, given, scale, moves, noise_ratio } = &searched;
        let is_left =
            |steps: &Steps| steps.share(&found.last.judged, scale.sigma) > Thresholds::STEPS_NAMED;
        task.steps = task.steps.filter(is_left);
        let has_gap = has_gap(&found.base, scale.adequate);
        let has_one = !found.last.picks.is_empty() || noise_ratio.is_some() || task.steps.is_some();
        let verdict = if has_one {
            Verdict::Effects
        } else if has_gap {
            Verdict::Unknown
        } else if !moves {
            Verdict::InsufficientExcitation
        } else if given.held_out.max(given.training) > scale.adequate {
            Verdict::Retune
        } else {
            Verdict::Adequate
        };
        if !found.faint.is_empty() {
            let names = found.faint.iter().map(|(family, _)| library[*family].effect.name);
            task.warnings.push(format!(
                "{}: {} would explain the gap together, but it is less than {} times the noise's power: a second effect takes \
                 what a wrong first one leaves, and several are not named",
                task.output,
                together(names),
                report::format_number(BeliefThresholds::FAINT, 3)
            ));
        }
        (task, Believed { searched, verdict, has_gap })
    }

    /// Repair: what belongs to the repaired model beside its effects, and the evidence for it: the offset that the
    /// records share, the residual for the maps, and the prediction of complete records.
    fn repair(&self, task: Task, believed: Believed) -> Outcome {
        let Believed { searched, verdict, has_gap } = believed;
        let Searched { library, found, given, scale, noise_ratio, .. } = searched;
        let fitter = self.search_in(&task, &library, &scale).fitter();
        let robust = (has_gap && noise_ratio.is_none())
            .then(|| robust::residual(fitter, &scale.judge, &found.base))
            .flatten();
        let robust = robust.unwrap_or_else(|| found.base.judged.residual.clone());
        let second = if self.request.holdout.is_empty() {
            let first = shrink::fraction(found.base.judged.held_out, found.last.judged.held_out);
            let both = (&found.base, &found.last);
            second::of(fitter, &scale.judge, both, scale.sigma / task.factor, first)
        } else {
            None
        };
        let Scale { judge, sigma, adequate, fine, .. } = scale;
        let offset = offset::of(&task, (&found.base, &found.last), sigma, self.count);
        let predicted = own_course::left_out(&found.last, &judge, &task.data, sigma, self.count);
        let caused = causal::left_by(&found.last, &task.data, sigma);
        Outcome {
            task,
            library,
            judge,
            sigma,
            adequate,
            fine,
            caused,
            verdict,
            given,
            found,
            robust,
            noise_ratio,
            second,
            offset,
            predicted,
            moved_by: Vec::new(),
            original: None,
            otherwise: Vec::new(),
            on_new_records: OnceLock::new(),
        }
    }

    /// The re-tuned model, judged by noise of this size and colour.
    fn retuned(&self, task: &Task, scale: &Scale) -> Result<Candidate, Error> {
        self.search_in(task, &[], scale).retune().map_err(|_| cannot_run(task))
    }

    /// Under noise that the effects reveal to be less than it was taken for, more may be seen: the search is made
    /// again from there. Where it cannot be, what was found stands.
    fn with_quieter_noise(&self, mut task: Task, searched: Searched) -> (Task, Searched) {
        let Some((ratio, shape)) = quieter(&task, &searched.found) else { return (task, searched) };
        let Searched { library, mut found, given, scale, moves, noise_ratio } = searched;
        let is_course_own = scale.judge.is_course_own;
        let mut scale = Scale::new(&task, shape, ratio * scale.sigma, scale.sure, self.request);
        scale.judge.is_course_own = is_course_own;
        let search = self.search_in(&task, &library, &scale);
        let given = given.residual.iter().map(|r| r / ratio).collect();
        let given = scale.judge.figures(given, &task.data);
        found.each(|c| *c = search.in_units(c.clone(), ratio));
        let again = has_gap(&found.last, scale.adequate).then(|| search.run(found.base.clone()));
        match again {
            Some(Ok(again)) => found = again,
            _ => search.name_again(&mut found),
        }
        task.noise.sigma *= ratio;
        task.noise.corner = Some(shape.corner).filter(|c| *c > 0.0);
        (task, Searched { library, found, given, scale, moves, noise_ratio })
    }

    fn search_in<'b>(
        &'b self,
        task: &'b Task,
        library: &'b [Family],
        scale: &'b Scale,
    ) -> Search<'b> {
        Search {
            base: &task.base,
            data: &task.data,
            judge: &scale.judge,
            library,
            sigma: scale.sigma,
            adequate: scale.adequate,
            fine: scale.fine,
            count: self.count,
            max_effects: task.max_effects,
            reading_is_known: task.reading_is_known,
            memo: self.memo,
        }
    }
}

/// Whether the model's own output moves in steps.
fn moves_in_steps(task: &Task, base: &Candidate, sigma: f64) -> bool {
    let data = &task.data;
    let residual = base.judged.residual.iter().map(|r| sigma * r);
    let simulated: Vec<f64> = data.y.iter().zip(residual).map(|(y, r)| y - r).collect();
    Steps::of(&DataSet { y: simulated, ..data.clone() }).is_some()
}

fn cannot_run(task: &Task) -> Error {
    let message = "the model cannot be simulated over these logs with its own parameters and with ones \
                   beside them; check units and range of the command, and run `piezoloop simulate` \
                   for the details";
    Error::Model { model: task.output.clone(), message: message.to_owned() }
}

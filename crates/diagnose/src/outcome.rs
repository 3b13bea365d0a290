//! The diagnosis of one output: noise, base, search, verdict.

use std::sync::atomic::AtomicU64;

use components::effects;

use crate::data_set::DataSet;
use crate::error::Error;
use crate::gap::{SecondOpinion, Verdict};
use crate::library::{self, Family};
use crate::noise::{self, Shape};
use crate::offset::Offset;
use crate::problem::Problem;
use crate::request::Request;
use crate::score::{Judge, Judged};
use crate::select::{Candidate, Found, Memo, Search, has_gap};
use crate::setting::{setting, simulated_span};
use crate::steps::Steps;
use crate::{louder, offset, robust, second, shrink, start};

/// The diagnosis of one output.
pub(crate) struct Outcome {
    pub(crate) problem: Problem,
    pub(crate) library: Vec<Family>,
    pub(crate) judge: Judge,
    /// Standard deviation of the noise in SI.
    pub(crate) sigma: f64,
    /// Mean square over the noise's up to which nothing is left.
    pub(crate) adequate: f64,
    /// What the user calls good enough, in powers of the noise.
    pub(crate) fine: f64,
    pub(crate) verdict: Verdict,
    /// The model as it came.
    pub(crate) given: Judged,
    pub(crate) found: Found,
    /// Residual of the robustly re-tuned model, in standard deviations.
    pub(crate) robust: Vec<f64>,
    /// Standard deviation of the noise over the one that was stated, where that is all that is missing.
    pub(crate) louder: Option<f64>,
    /// What whole records that are left out say.
    pub(crate) second: Option<SecondOpinion>,
    /// Offsets of the records.
    pub(crate) offset: Option<Offset>,
}

/// Mean square over the noise's up to which nothing is left where the noise is estimated: logs of a driven machine
/// show a part of it only.
pub(crate) const ADEQUATE: f64 = 1.6;

/// Part of what is left at last that rounding must be, for the steps of the reading to be named.
const STEPS: f64 = 0.25;

impl Outcome {
    /// The answer's candidate, or the best single effect where none is named.
    pub(crate) fn best(&self) -> &Candidate {
        let found = &self.found;
        if !found.last.picks.is_empty() {
            return &found.last;
        }
        let fitted = found.first.iter().filter_map(|l| l.best.as_ref());
        fitted.min_by(|a, b| a.rank.total_cmp(&b.rank)).unwrap_or(&found.base)
    }

    /// What that leaves, as a mean square in SI, on fitted and held-out rows alike.
    pub(crate) fn left(&self) -> f64 {
        let judged = &self.best().judged;
        0.5 * (judged.training + judged.held_out) * self.sigma.powi(2)
    }
}

/// What residuals are measured by.
struct Scale {
    judge: Judge,
    /// Standard deviation of the noise in SI.
    sigma: f64,
    /// Mean square over the noise's up to which nothing is left.
    adequate: f64,
    /// What the user calls good enough, in powers of the noise.
    fine: f64,
}

impl Scale {
    /// Nothing is left within `sure` times the noise's power, nor within what the user calls good enough.
    fn new(problem: &Problem, judge: Judge, sigma: f64, sure: f64, request: &Request) -> Self {
        let fine = (request.accuracy * 2.0 * problem.data.output_span.half / sigma).powi(2);
        Self { judge, sigma, adequate: sure.max(1.0 + fine), fine }
    }
}

/// Diagnoses one output.
pub(crate) fn of(
    mut problem: Problem,
    request: &Request,
    count: &AtomicU64,
) -> Result<Outcome, Error> {
    let (base, given, scale, sure) = grounded(&mut problem, request, count)?;
    let position = simulated_span(&base, &problem.data, count).unwrap_or(problem.data.output_span);
    let moves = position.half > 3.0 * scale.sigma && problem.data.command_span.half > 0.0;
    problem.steps = problem.steps.filter(|_| !moves_in_steps(&problem, &base, scale.sigma));
    let written = setting(&problem, &base, position, scale.sigma);
    let mut library = library::families(&written, &request.without);
    // The values show the steps better than any fit.
    library
        .retain(|f| problem.steps.is_none() || f.effect.name != effects::SENSOR_QUANTISATION.name);
    let is_asked = !request.without.iter().any(|name| name == effects::SENSOR_NOISE.name);
    let is_stated = problem.noise.source == "given" && has_gap(&base, scale.adequate);
    let louder = (is_asked && is_stated)
        .then(|| louder::factor(&base.judged.residual, &problem.data))
        .flatten();
    let memo = Memo::default();
    let found = if louder.is_none() && has_gap(&base, scale.adequate) {
        let search = search_in((&problem, &library, &scale), request, count, &memo);
        search.run(base).map_err(|_| cannot_run(&problem))?
    } else {
        Found::nothing(base)
    };
    let with = (found, given, scale);
    let (found, given, scale) =
        with_quieter_noise(&mut problem, (&library, &memo), with, sure, request, count);
    let has_gap = has_gap(&found.base, scale.adequate);
    problem.steps = problem.steps.filter(|steps| steps.share(&found.last, scale.sigma) > STEPS);
    let has_one = !found.last.picks.is_empty() || louder.is_some() || problem.steps.is_some();
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
    let fitter = search_in((&problem, &library, &scale), request, count, &memo).fitter();
    let robust = (has_gap && louder.is_none())
        .then(|| robust::residual(fitter, &scale.judge, &found.base))
        .flatten();
    let robust = robust.unwrap_or_else(|| found.base.judged.residual.clone());
    let second = if request.holdout.is_empty() {
        let first = shrink::fraction(found.base.judged.held_out, found.last.judged.held_out);
        let both = (&found.base, &found.last);
        second::of(fitter, &scale.judge, both, scale.sigma / problem.factor, first)
    } else {
        None
    };
    let Scale { judge, sigma, adequate, fine } = scale;
    let offset = offset::of(&problem, (&found.base, &found.last), sigma, count);
    Ok(Outcome {
        problem,
        library,
        judge,
        sigma,
        adequate,
        fine,
        verdict,
        given,
        found,
        robust,
        louder,
        second,
        offset,
    })
}

/// Whether the model's own output moves in steps.
fn moves_in_steps(problem: &Problem, base: &Candidate, sigma: f64) -> bool {
    let data = &problem.data;
    let residual = base.judged.residual.iter().map(|r| sigma * r);
    let simulated: Vec<f64> = data.y.iter().zip(residual).map(|(y, r)| y - r).collect();
    Steps::of(&DataSet { y: simulated, ..data.clone() }).is_some()
}

fn cannot_run(problem: &Problem) -> Error {
    let message = "the model cannot be simulated over these logs with its own parameters and with ones \
                   beside them; check units and range of the command, and run `piezoloop simulate` \
                   for the details";
    Error::Model { model: problem.output.clone(), message: message.to_owned() }
}

/// The re-tuned model, the model as it came, and what both are measured by: the noise is settled on the way, and
/// where the machine rested before the logs begin. With it the part of the noise's power that is sure.
fn grounded(
    problem: &mut Problem,
    request: &Request,
    count: &AtomicU64,
) -> Result<(Candidate, Judged, Scale, f64), Error> {
    let retuned = |problem: &Problem, judge: &Judge, sigma: f64| {
        let (base, data) = (&problem.base, &problem.data);
        let memo = Memo::default();
        let search = Search {
            base,
            data,
            judge,
            library: &[],
            sigma,
            adequate: f64::INFINITY,
            fine: 0.0,
            count,
            max_effects: 0,
            memo: &memo,
        };
        search.retune().map_err(|_| cannot_run(problem))
    };
    let white = Judge::new(&problem.data, Shape::WHITE);
    let guess = problem.noise.sigma * problem.factor;
    let mut first = retuned(problem, &white, guess)?;
    if start::find(problem, &first, count) {
        first = retuned(problem, &white, guess)?;
    }
    let (shape, sure) = settle_noise(problem, &first.judged.residual);
    let sigma = problem.noise.sigma * problem.factor;
    let scale = Scale::new(problem, Judge::new(&problem.data, shape), sigma, sure, request);
    // The fit is the same for any noise.
    let memo = Memo::default();
    let search = search_in((problem, &[], &scale), request, count, &memo);
    let base = search.judged_again(first, sigma / guess).map_err(|_| cannot_run(problem))?;
    let nothing = vec![0.0; base.chain.parameters.len()];
    let given = scale.judge.judge(&base.chain, &nothing, &problem.data, sigma, count);
    let given = given.map_err(|_| cannot_run(problem))?;
    Ok((base, given, scale, sure))
}

/// Once the effects are found, the noise may be less than it was taken for: measured by that there may be more
/// to see.
fn with_quieter_noise(
    problem: &mut Problem,
    (library, memo): (&[Family], &Memo),
    (mut found, given, scale): (Found, Judged, Scale),
    sure: f64,
    request: &Request,
    count: &AtomicU64,
) -> (Found, Judged, Scale) {
    let Some((ratio, shape)) = quieter(problem, &found) else { return (found, given, scale) };
    let judge = Judge::new(&problem.data, shape);
    let scale = Scale::new(problem, judge, ratio * scale.sigma, sure, request);
    let search = search_in((problem, library, &scale), request, count, memo);
    let judge = &scale.judge;
    let given = judge.figures(scaled(&given.residual, ratio), &problem.data);
    found.each(|c| *c = search.in_units(c.clone(), ratio));
    if has_gap(&found.last, scale.adequate) {
        let base = found.base.clone();
        // What was found stands where it cannot be looked for again.
        match search.run(base) {
            Ok(again) => found = again,
            Err(_) => search.name_again(&mut found),
        }
    } else {
        search.name_again(&mut found);
    }
    problem.noise.sigma *= ratio;
    problem.noise.corner = Some(shape.corner).filter(|c| *c > 0.0);
    (found, given, scale)
}

fn scaled(residual: &[f64], ratio: f64) -> Vec<f64> {
    residual.iter().map(|r| r / ratio).collect()
}

fn search_in<'a>(
    (problem, library, scale): (&'a Problem, &'a [Family], &'a Scale),
    request: &Request,
    count: &'a AtomicU64,
    memo: &'a Memo,
) -> Search<'a> {
    let (base, data, max_effects) = (&problem.base, &problem.data, request.max_effects);
    let Scale { judge, sigma, adequate, fine } = scale;
    let (sigma, adequate, fine) = (*sigma, *adequate, *fine);
    Search { base, data, judge, library, sigma, adequate, fine, count, max_effects, memo }
}

/// Where the noise was estimated from residuals that held the gap: the noise over it and its shape,
/// from what the effects leave, where that is clearly less.
fn quieter(problem: &Problem, found: &Found) -> Option<(f64, Shape)> {
    /// A ratio that is worth another look.
    const LESS: f64 = 0.95;
    let is_estimated = problem.noise.source == "second differences";
    if !is_estimated || found.last.picks.is_empty() {
        return None;
    }
    let estimate = estimated(&problem.data, &found.last.judged.residual);
    Some(estimate).filter(|(ratio, _)| *ratio > 0.0 && *ratio < LESS)
}

/// The noise over what residuals are given in, and its shape, from the residuals themselves.
fn estimated(data: &DataSet, residual: &[f64]) -> (f64, Shape) {
    let sample = data.sample_time();
    let (low, high) = (1.0 / data.longest(), 0.5 / sample);
    let rows = || data.records.iter().map(|r| r.rows.clone());
    let finest = noise::fourth_differences(residual, rows()).unwrap_or(1.0).min(1.0);
    let corner = noise::corner_under(residual, rows(), finest * finest, sample);
    let colour = noise::coloured(corner, low, high);
    (finest * colour.sqrt(), Shape { white: 1.0 / colour, corner })
}

/// Says how large the noise is, how it is spread over frequency, and up to which mean square over it
/// nothing is left: the less is known about it, the more.
fn settle_noise(problem: &mut Problem, residual: &[f64]) -> (Shape, f64) {
    /// A standard deviation that was given may be off by a tenth or so.
    const GIVEN: f64 = 1.3;
    /// A record at rest is one draw of the noise.
    const RESTED: f64 = 1.35;
    let data = &problem.data;
    let sample = data.sample_time();
    let (low, high) = (1.0 / data.longest(), 0.5 / sample);
    let rows = || data.records.iter().map(|r| r.rows.clone());
    // In standard deviations of what was taken for the noise so far.
    let finest = noise::fourth_differences(residual, rows()).unwrap_or(1.0);
    let noise = &mut problem.noise;
    let (shape, adequate) = match (noise.source.as_str(), problem.rest_corner) {
        ("steps of the reading", _) => (Shape::WHITE, ADEQUATE),
        (_, Some(corner)) => {
            let white = 1.0 / noise::coloured(corner, low, high);
            (Shape { white, corner }, RESTED)
        }
        ("given", None) => (Shape::with_white(finest * finest, low, high), GIVEN),
        _ => {
            let (ratio, shape) = estimated(data, residual);
            noise.sigma *= ratio;
            (shape, ADEQUATE)
        }
    };
    noise.corner = Some(shape.corner).filter(|c| *c > 0.0);
    (shape, adequate)
}

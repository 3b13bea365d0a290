//! The diagnosis of one output.

use std::sync::atomic::AtomicU64;

use crate::block::Span;
use crate::chain::{Bench, Horizon};
use crate::data_set::DataSet;
use crate::error::Error;
use crate::gap::Verdict;
use crate::library::{self, Family, Setting};
use crate::noise;
use crate::problem::Problem;
use crate::request::Request;
use crate::score::{Judge, Judged};
use crate::select::{ADEQUATE, Candidate, Found, Search, has_gap};
use crate::spectrum;

/// The diagnosis of one output.
pub(crate) struct Outcome {
    pub(crate) problem: Problem,
    pub(crate) library: Vec<Family>,
    pub(crate) judge: Judge,
    /// Standard deviation of the noise in SI.
    pub(crate) sigma: f64,
    pub(crate) verdict: Verdict,
    /// The model as it came.
    pub(crate) given: Judged,
    pub(crate) found: Found,
}

/// Diagnoses one output.
pub(crate) fn of(mut problem: Problem, request: &Request, count: &AtomicU64) -> Result<Outcome, Error> {
    let judge = Judge::new(&problem.data);
    let model_error = |output: &str| Error::Model {
        model: output.to_owned(),
        message: "the model cannot be simulated over these logs with its own parameters; check units \
                  and range of the command, and run `piezoloop simulate` for the details"
            .to_owned(),
    };
    let mut sigma = problem.noise.sigma * problem.factor;
    let search = |sigma: f64, library: &'_ [Family], problem: &'_ Problem| -> Result<Candidate, Error> {
        let search = Search {
            base: &problem.base,
            data: &problem.data,
            judge: &judge,
            library,
            sigma,
            count,
            max_effects: request.max_effects,
        };
        search.retune().map_err(|_| model_error(&problem.output))
    };
    let mut base = search(sigma, &[], &problem)?;
    if problem.noise.source == "second differences" {
        let rows = problem.data.records.iter().map(|r| r.rows.clone());
        if let Some(finer) = noise::fourth_differences(&base.judged.residual, rows)
            && finer < 1.0
        {
            sigma *= finer;
            problem.noise.sigma = sigma / problem.factor;
            base = search(sigma, &[], &problem)?;
        }
    }
    let nothing = vec![0.0; base.chain.parameters.len()];
    let given = judge
        .judge(&base.chain, &nothing, &problem.data, sigma, count)
        .map_err(|_| model_error(&problem.output))?;
    let position = simulated_span(&base, &problem.data, count).unwrap_or(problem.data.output_span);
    let moves = position.half > 3.0 * sigma && problem.data.command_span.half > 0.0;
    let library = library::families(&setting(&problem, &base, position), &request.without);
    let search = Search {
        base: &problem.base,
        data: &problem.data,
        judge: &judge,
        library: &library,
        sigma,
        count,
        max_effects: request.max_effects,
    };
    let found = if has_gap(&base) {
        search.run(base).map_err(|_| model_error(&problem.output))?
    } else {
        Found {
            last: base.clone(),
            best: base.clone(),
            base,
            rivals: Vec::new(),
            first: Vec::new(),
            score: 0.0,
            alone: Vec::new(),
        }
    };
    let verdict = if !found.last.picks.is_empty() {
        Verdict::Effects
    } else if has_gap(&found.base) {
        Verdict::Unknown
    } else if !moves {
        Verdict::InsufficientExcitation
    } else if given.held_out.max(given.training) > ADEQUATE {
        Verdict::Retune
    } else {
        Verdict::Adequate
    };
    Ok(Outcome { problem, library, judge, sigma, verdict, given, found })
}

/// Range of the simulated output.
fn simulated_span(base: &Candidate, data: &DataSet, count: &AtomicU64) -> Option<Span> {
    let mut bench = Bench::new(&base.chain, data, Horizon::All, count);
    let simulated = bench.keep(&base.fit.theta).ok()?;
    let moves = simulated.windows(2).any(|w| w[0] != w[1]);
    let mut span = Span::of(simulated.iter().copied());
    if !moves {
        span.half = 0.0;
    }
    Some(span)
}

fn setting<'a>(problem: &'a Problem, base: &Candidate, position: Span) -> Setting<'a> {
    let data = &problem.data;
    let sample = data.sample_time();
    let length = data
        .records
        .iter()
        .map(|r| data.time[r.rows.end - 1] - data.time[r.rows.start])
        .fold(sample, f64::max);
    let rows: Vec<f64> = data.row_hit.iter().map(|h| data.command[*h as usize]).collect();
    let mut slopes: Vec<f64> = Vec::with_capacity(rows.len());
    for record in &data.records {
        let r = record.rows.clone();
        let pairs = rows[r.clone()].windows(2).zip(data.time[r].windows(2));
        slopes.extend(pairs.map(|(u, t)| ((u[1] - u[0]) / (t[1] - t[0])).abs()));
    }
    let slope_power = slopes.iter().map(|s| s * s).sum::<f64>() / slopes.len().max(1) as f64;
    let steepest = slopes.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let longest = data.records.iter().max_by_key(|r| r.training.len());
    let lines = longest.map_or_else(Vec::new, |r| {
        spectrum::lines(&base.judged.residual[r.training.clone()], sample, 4)
    });
    let half = if position.half > 0.0 { position.half } else { 1.0 };
    Setting {
        base: &problem.base,
        data,
        command: data.command_span,
        position: Span { half, ..position },
        sample,
        length,
        steepest,
        slope_power,
        lines,
    }
}

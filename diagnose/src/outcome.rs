//! The diagnosis of one output.

use std::sync::atomic::AtomicU64;

use crate::block::Span;
use crate::chain::{Bench, Horizon};
use crate::data_set::DataSet;
use crate::error::Error;
use crate::gap::Verdict;
use crate::library::{self, Family, Setting};
use crate::noise::{self, Shape};
use crate::problem::Problem;
use crate::request::Request;
use crate::score::{Judge, Judged};
use crate::select::{Candidate, Found, Search, has_gap};
use crate::spectrum;

/// The diagnosis of one output.
pub(crate) struct Outcome {
    pub(crate) problem: Problem,
    pub(crate) library: Vec<Family>,
    pub(crate) judge: Judge,
    /// Standard deviation of the noise in SI.
    pub(crate) sigma: f64,
    /// Mean square over the noise's up to which nothing is left.
    pub(crate) adequate: f64,
    pub(crate) verdict: Verdict,
    /// The model as it came.
    pub(crate) given: Judged,
    pub(crate) found: Found,
}

/// Diagnoses one output.
pub(crate) fn of(
    mut problem: Problem,
    request: &Request,
    count: &AtomicU64,
) -> Result<Outcome, Error> {
    let model_error = |output: &str| Error::Model {
        model: output.to_owned(),
        message:
            "the model cannot be simulated over these logs with its own parameters; check units \
                  and range of the command, and run `piezoloop simulate` for the details"
                .to_owned(),
    };
    let retune = |judge: &Judge, sigma: f64, problem: &Problem| {
        let search = Search {
            base: &problem.base,
            data: &problem.data,
            judge,
            library: &[],
            sigma,
            adequate: f64::INFINITY,
            count,
            max_effects: 0,
        };
        search.retune().map_err(|_| model_error(&problem.output))
    };
    let white = Judge::new(&problem.data, Shape::WHITE);
    let first = retune(&white, problem.noise.sigma * problem.factor, &problem)?;
    let (shape, adequate) = settle_noise(&mut problem, &first.judged.residual);
    let sigma = problem.noise.sigma * problem.factor;
    let judge = Judge::new(&problem.data, shape);
    let base = retune(&judge, sigma, &problem)?;
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
        adequate,
        count,
        max_effects: request.max_effects,
    };
    let found = if has_gap(&base, adequate) {
        search.run(base).map_err(|_| model_error(&problem.output))?
    } else {
        Found { last: base.clone(), base, rivals: Vec::new(), first: Vec::new(), alone: Vec::new() }
    };
    let verdict = if !found.last.picks.is_empty() {
        Verdict::Effects
    } else if has_gap(&found.base, adequate) {
        Verdict::Unknown
    } else if !moves {
        Verdict::InsufficientExcitation
    } else if given.held_out.max(given.training) > adequate {
        Verdict::Retune
    } else {
        Verdict::Adequate
    };
    Ok(Outcome { problem, library, judge, sigma, adequate, verdict, given, found })
}

/// Says how large the noise is, how it is spread over frequency, and up to which mean square over it
/// nothing is left: the less is known about it, the more.
fn settle_noise(problem: &mut Problem, residual: &[f64]) -> (Shape, f64) {
    /// A standard deviation that was given may be off by a tenth or so.
    const GIVEN: f64 = 1.3;
    /// A record at rest is one draw of the noise.
    const RESTED: f64 = 1.35;
    /// Logs of a driven machine show a part of it only.
    const ESTIMATED: f64 = 1.6;
    let data = &problem.data;
    let sample = data.sample_time();
    let (low, high) = (1.0 / data.longest(), 0.5 / sample);
    let rows = || data.records.iter().map(|r| r.rows.clone());
    // In standard deviations of what was taken for the noise so far.
    let finest = noise::fourth_differences(residual, rows()).unwrap_or(1.0);
    let noise = &mut problem.noise;
    let (shape, adequate) = match (noise.source.as_str(), problem.rest_corner) {
        (_, Some(corner)) => {
            let white = 1.0 / noise::coloured(corner, low, high);
            (Shape { white, corner }, RESTED)
        }
        ("given", None) => (Shape::with_white(finest * finest, low, high), GIVEN),
        _ => {
            let finest = finest.min(1.0);
            let corner = noise::corner_under(residual, rows(), finest * finest, sample);
            let colour = noise::coloured(corner, low, high);
            noise.sigma *= finest * colour.sqrt();
            (Shape { white: 1.0 / colour, corner }, ESTIMATED)
        }
    };
    noise.corner = Some(shape.corner).filter(|c| *c > 0.0);
    (shape, adequate)
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
    let (mut loop_power, mut apparent_power) = (0.0, 0.0);
    for record in &data.records {
        let r = record.rows.clone();
        let pairs = rows[r.clone()].windows(2).zip(data.time[r].windows(2));
        for (u, t) in pairs {
            let slope = ((u[1] - u[0]) / (t[1] - t[0])).abs();
            slopes.push(slope);
            loop_power += slope * (u[1] - data.command_span.centre).abs();
            apparent_power += slope * u[1].abs();
        }
    }
    loop_power /= slopes.len().max(1) as f64;
    apparent_power /= slopes.len().max(1) as f64;
    let slope_power = slopes.iter().map(|s| s * s).sum::<f64>() / slopes.len().max(1) as f64;
    let steepest = slopes.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let longest = data.records.iter().max_by_key(|r| r.training.len());
    let lines = longest.map_or_else(Vec::new, |r| {
        let is_mains = |f: f64| {
            [50.0, 60.0]
                .iter()
                .any(|m| (1..=6).any(|k| (f / (m * f64::from(k)) - 1.0).abs() < 0.01))
        };
        let mut lines = spectrum::lines(&base.judged.residual[r.training.clone()], sample, 6);
        lines.retain(|f| !is_mains(*f));
        // A line that the command has, or a multiple of its strongest, is an answer to the command.
        let scale = 1e3 / data.command_span.half;
        let command: Vec<f64> = rows[r.training.clone()].iter().map(|u| u * scale).collect();
        let driven = spectrum::lines(&command, sample, 40);
        let resolution = 2.0 / (r.training.len() as f64 * sample);
        lines.retain(|f| {
            let is_multiple = driven.first().is_some_and(|d| {
                let times = (f / d).round().max(1.0);
                times <= 20.0 && (f - times * d).abs() < resolution
            });
            !is_multiple && driven.iter().all(|d| (f - d).abs() > resolution)
        });
        lines
    });
    let steps = converter_steps(data, &rows, &base.judged.residual);
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
        loop_power,
        apparent_power,
        lines,
        resonance: problem.base.resonance(),
        steps,
    }
}

/// Converters whose steps the residual shows: it is then a periodic function of the command. The
/// strongest periods of the residual over the command, as steps over the range and phase.
fn converter_steps(data: &DataSet, command: &[f64], residual: &[f64]) -> Vec<(f64, f64)> {
    /// Most rows that are looked at.
    const ROWS: usize = 4000;
    /// Most steps over the range.
    const STEPS: usize = 1024;
    let training = data.records.iter().flat_map(|r| r.training.clone());
    let rows: Vec<usize> = training.collect();
    let stride = rows.len().div_ceil(ROWS).max(1);
    let z: Vec<(f64, f64)> = rows
        .iter()
        .step_by(stride)
        .map(|k| (command[*k] / (2.0 * data.command_span.half), residual[*k]))
        .collect();
    let power = |steps: f64| {
        let (mut s, mut c) = (0.0, 0.0);
        for (u, r) in &z {
            let (sin, cos) = (std::f64::consts::TAU * steps * u).sin_cos();
            s += r * sin;
            c += r * cos;
        }
        (s * s + c * c, s.atan2(c))
    };
    let mut all: Vec<(f64, f64, f64)> = (8..=4 * STEPS)
        .map(|k| {
            let steps = 0.25 * k as f64;
            let (power, angle) = power(steps);
            (power, steps, angle)
        })
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
    all.iter()
        .take(3)
        .flat_map(|(_, steps, _)| {
            let fine = (-8..=8).map(move |k| steps + 0.03 * f64::from(k));
            let best = fine.map(|s| (power(s), s)).max_by(|a, b| a.0.0.total_cmp(&b.0.0));
            // The rounding error −Σ sin(2πk(u/q − p))/(πk) has its first harmonic at this angle.
            best.into_iter().flat_map(|((_, angle), s)| {
                let phase = (std::f64::consts::PI - angle) / std::f64::consts::TAU;
                [0.25, -0.25].map(|shift| (s, (phase + shift).rem_euclid(1.0)))
            })
        })
        .chain(all.first().map(|(_, s, _)| (*s, 0.0)))
        .collect()
}

//! The diagnosis of one output.

use std::sync::atomic::AtomicU64;

use components::effects;
use components::linear::Transition;
use surround::Span;

use crate::between::Between;
use crate::chain::{Bench, Horizon};
use crate::converter::Converted;
use crate::data_set::DataSet;
use crate::error::Error;
use crate::gap::{SecondOpinion, Verdict};
use crate::library::{self, Family, Setting};
use crate::noise::{self, Shape};
use crate::offset::Offset;
use crate::problem::{self, Problem};
use crate::request::Request;
use crate::score::{Judge, Judged};
use crate::select::{Candidate, Found, Search, has_gap};
use crate::steps::Steps;
use crate::{jitter, louder, offset, robust, second, shrink, spectrum};

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
    /// What is left at last, in powers of the noise, on fitted and held-out rows alike.
    fn left(&self) -> f64 {
        0.5 * (self.found.last.judged.training + self.found.last.judged.held_out)
            * self.sigma.powi(2)
    }

    /// Frequency of a mode that was found within 10 % of half the sample rate, in Hz.
    fn mode_near_nyquist(&self) -> Option<f64> {
        /// In parts of the sample rate.
        const NEAR: f64 = 0.45;
        let last = &self.found.last;
        let is_mode = |(family, _): &(usize, usize)| {
            self.library[*family].effect.name == effects::EXTRA_MODE.name
        };
        if !last.picks.iter().any(is_mode) {
            return None;
        }
        let own = last.chain.parameters.iter().zip(&last.fit.theta).filter(|(p, _)| !p.is_base);
        let frequencies = own.filter(|(p, _)| p.unit == "Hz").map(|(p, q)| p.value(*q));
        let sample = self.problem.data.sample_time();
        frequencies.filter(|f| f * sample >= NEAR).reduce(f64::max)
    }
}

/// Diagnoses output number `number` of a request. A mode near half the sample rate is what a command looks like
/// that moves between the rows: before it is named, the other courses between the rows are tried, and the one is
/// taken that leaves less with fewer effects.
pub(crate) fn settled(
    problem: Problem,
    request: &Request,
    number: usize,
    count: &AtomicU64,
) -> Result<Outcome, Error> {
    let mut outcome = of(problem, request, count)?;
    let is_open = request.between.is_none() && outcome.problem.base.is_white;
    let Some(frequency) = outcome.mode_near_nyquist().filter(|_| is_open) else {
        return Ok(outcome);
    };
    for between in [Between::BandLimited, Between::Line] {
        let asked = Request { between: Some(between), ..request.clone() };
        let Some(other) = problem::problems(&asked)?.into_iter().nth(number) else { continue };
        let other = of(other, &asked, count)?;
        let is_plainer = other.found.last.picks.len() <= outcome.found.last.picks.len();
        if other.verdict == Verdict::Effects
            && is_plainer
            && other.mode_near_nyquist().is_none()
            && other.left() < outcome.left()
        {
            outcome = other;
        }
    }
    let output = outcome.problem.output.clone();
    outcome.problem.warnings.push(match outcome.problem.between {
        Between::Zoh => format!(
            "{output}: the mode at {frequency:.4} Hz lies within 10 % of half the sample rate; it stays whatever the \
             command does between the rows"
        ),
        between => format!(
            "{output}: the command is taken as {}: with a held one a mode would be missing at {frequency:.4} Hz, within \
             10 % of half the sample rate (--between zoh says otherwise)",
            between.words()
        ),
    });
    Ok(outcome)
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
            "the model cannot be simulated over these logs with its own parameters and with ones \
                  beside them; check units and range of the command, and run `piezoloop simulate` \
                  for the details"
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
    problem.steps = problem.steps.filter(|_| !moves_in_steps(&problem, &base, sigma));
    let mut library =
        library::families(&setting(&problem, &base, position, sigma), &request.without);
    // The values show the steps better than any fit.
    library
        .retain(|f| problem.steps.is_none() || f.effect.name != effects::SENSOR_QUANTISATION.name);
    let search = search_in(&problem, &library, (&judge, sigma, adequate), request, count);
    let is_asked = !request.without.iter().any(|name| name == effects::SENSOR_NOISE.name);
    let louder = (is_asked && problem.noise.source == "given" && has_gap(&base, adequate))
        .then(|| louder::factor(&base.judged.residual, &problem.data))
        .flatten();
    let found = if louder.is_none() && has_gap(&base, adequate) {
        search.run(base).map_err(|_| model_error(&problem.output))?
    } else {
        Found { last: base.clone(), base, rivals: Vec::new(), first: Vec::new(), alone: Vec::new() }
    };
    let quiet = quieter(&problem, &found);
    let (found, given, judge, sigma) = match quiet {
        None => (found, given, judge, sigma),
        Some((ratio, shape)) => {
            let (judge, sigma) = (Judge::new(&problem.data, shape), ratio * sigma);
            let search = search_in(&problem, &library, (&judge, sigma, adequate), request, count);
            let given = judge.figures(scaled(&given.residual, ratio), &problem.data);
            let mut found = found;
            let rows = search.fitter().effective();
            found.each(|c| {
                c.judged = judge.figures(scaled(&c.judged.residual, ratio), &problem.data);
                c.fit.mean_square /= ratio * ratio;
                c.rank -= 2.0 * rows * ratio.ln();
            });
            // Under the smaller noise there may be more to see.
            if has_gap(&found.last, adequate) {
                let base = found.base.clone();
                // What was found stands where it cannot be looked for again.
                match search.run(base) {
                    Ok(again) => found = again,
                    Err(_) => search.name_again(&mut found),
                }
            } else {
                search.name_again(&mut found);
            }
            (found, given, judge, sigma)
        }
    };
    if let Some((ratio, shape)) = quiet {
        problem.noise.sigma *= ratio;
        problem.noise.corner = Some(shape.corner).filter(|c| *c > 0.0);
    }
    let search = search_in(&problem, &library, (&judge, sigma, adequate), request, count);
    let has_one = !found.last.picks.is_empty() || louder.is_some();
    let robust = if has_gap(&found.base, adequate) && louder.is_none() {
        robust::residual(search.fitter(), &judge, &found.base)
    } else {
        None
    };
    let robust = robust.unwrap_or_else(|| found.base.judged.residual.clone());
    let second = if request.holdout.is_empty() {
        let first = shrink::fraction(found.base.judged.held_out, found.last.judged.held_out);
        let both = (&found.base, &found.last);
        second::of(search.fitter(), &judge, both, sigma / problem.factor, first)
    } else {
        None
    };
    problem.steps = problem.steps.filter(|steps| steps.share(&found.last, sigma) > STEPS);
    let has_one = has_one || problem.steps.is_some();
    let verdict = if has_one {
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
    let offset = offset::of(&problem, (&found.base, &found.last), sigma, count);
    Ok(Outcome {
        problem,
        library,
        judge,
        sigma,
        adequate,
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

fn scaled(residual: &[f64], ratio: f64) -> Vec<f64> {
    residual.iter().map(|r| r / ratio).collect()
}

fn search_in<'a>(
    problem: &'a Problem,
    library: &'a [Family],
    (judge, sigma, adequate): (&'a Judge, f64, f64),
    request: &Request,
    count: &'a AtomicU64,
) -> Search<'a> {
    let (base, data, max_effects) = (&problem.base, &problem.data, request.max_effects);
    Search { base, data, judge, library, sigma, adequate, count, max_effects }
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

fn setting<'a>(problem: &'a Problem, base: &Candidate, position: Span, sigma: f64) -> Setting<'a> {
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
    let lines = own_lines(data, &base.judged.residual, sample);
    let training = || data.records.iter().flat_map(|r| r.training.clone());
    let residual = &base.judged.residual;
    let before = before_mode(problem, residual);
    let command = Converted::new(&rows, data.command_span, &before, training());
    // The reading less what the model leaves of it: the simulated one.
    let simulated: Vec<f64> = data.y.iter().zip(residual).map(|(y, r)| y - sigma * r).collect();
    let reading = Converted::new(&simulated, position, residual, training());
    let swings = jitter::frequencies(data, residual, &simulated, sample);
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
        swings,
        resonance: problem.base.resonance(),
        steps: command.steps(),
        gaps: command.gaps(),
        reading_steps: reading.steps(),
        reading_gaps: reading.gaps(),
    }
}

/// Frequencies of lines that the residual has and no command has: of the longest record, or of two, or of one
/// where most records have a line just there, by whatever command. Those of most records first, then the
/// strongest ones.
fn own_lines(data: &DataSet, residual: &[f64], sample: f64) -> Vec<f64> {
    /// Lines that are kept.
    const MOST: usize = 6;
    /// Most that a multiple is off, in parts of the frequency.
    const SLOW: f64 = 0.25;
    /// Records that have a line, where in all but one it may be an answer.
    const SEEN: usize = 3;
    /// How near such lines are, over the resolution: a place between lines is known well.
    const SAME: f64 = 0.25;
    let neighbours = data.aux.iter().filter(|a| a.is_command).map(|a| (&a.hits, a.span));
    let commands: Vec<_> =
        std::iter::once((&data.command, data.command_span)).chain(neighbours).collect();
    let mut records: Vec<_> = data.records.iter().map(|r| r.training.clone()).collect();
    records.sort_by_key(|rows| std::cmp::Reverse(rows.len()));
    // Frequency, how many records have it, the first of them, place in that one.
    let mut all: Vec<(f64, usize, usize, usize)> = Vec::new();
    let mut seen: Vec<(f64, f64)> = Vec::new();
    for (record, rows) in records.into_iter().enumerate() {
        let resolution = 2.0 / (rows.len() as f64 * sample);
        let mut lines = spectrum::lines(&residual[rows.clone()], sample, MOST);
        lines.retain(|f| !is_mains(*f));
        seen.extend(lines.iter().map(|f| (*f, SAME * resolution)));
        for (hits, span) in commands.iter().filter(|(_, span)| span.half > 0.0) {
            let at = data.row_hit[rows.clone()].iter();
            let command: Vec<f64> = at.map(|h| hits[*h as usize] * 1e3 / span.half).collect();
            let driven = spectrum::lines(&command, sample, 40);
            // A line that the command has, or a multiple of its strongest, is an answer to the command.
            lines.retain(|f| {
                let is_multiple = driven.first().is_some_and(|d| {
                    let times = (f / d).round().max(1.0);
                    // Near a multiple of a slow command is every line, if near is not a part of its frequency.
                    times <= 20.0 && (f - times * d).abs() < resolution.min(SLOW * d)
                });
                !is_multiple && driven.iter().all(|d| (f - d).abs() > resolution)
            });
        }
        for (place, line) in lines.into_iter().enumerate() {
            match all.iter_mut().find(|(f, ..)| (f - line).abs() < resolution) {
                Some((_, records, ..)) => *records += 1,
                None => all.push((line, 1, record, place)),
            }
        }
    }
    let times = |line: f64| seen.iter().filter(|(f, near)| (f - line).abs() < *near).count();
    all.retain(|(f, records, first, _)| *records > 1 || *first == 0 || times(*f) >= SEEN);
    all.sort_by(|a, b| b.1.cmp(&a.1).then(a.3.cmp(&b.3)).then(a.0.total_cmp(&b.0)));
    all.into_iter().take(MOST).map(|(f, ..)| f).collect()
}

/// Whether a frequency is that of the mains or a multiple of it.
fn is_mains(frequency: f64) -> bool {
    let is_near = |f: f64| (frequency / f - 1.0).abs() < 0.01;
    [50.0, 60.0].iter().any(|m| (1..=6).any(|k| is_near(m * f64::from(k))))
}

/// What an error of the command would have to be at each row to leave this residual, in σ: the residual
/// with the model's first mode taken out, as far as noise permits.
fn before_mode(problem: &Problem, residual: &[f64]) -> Vec<f64> {
    /// Least power over that of noise which is sought.
    const LEAST: f64 = 0.01;
    let data = &problem.data;
    let Some((frequency, damping)) = problem.base.mode_values() else { return residual.to_vec() };
    let transition = Transition::new(frequency, damping, data.sample_time());
    let mut sought = residual.to_vec();
    for record in &data.records {
        let part = &mut sought[record.rows.clone()];
        let (mut position, mut rate) = (0.0, 0.0);
        let response: Vec<f64> = (0..part.len())
            .map(|row| {
                let command = if row == 0 { 1.0 } else { 0.0 };
                let (e, r) = transition.apply(position - command, rate);
                (position, rate) = (command + e, r);
                position
            })
            .collect();
        let power = part.iter().map(|r| r * r).sum::<f64>() / part.len().max(1) as f64;
        let found = spectrum::deconvolve(part, &response, 1.0 / (power - 1.0).max(LEAST));
        part.copy_from_slice(&found);
    }
    sought
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data_set::RecordRows;
    use crate::random::Random;

    #[test]
    fn a_line_of_two_records_that_no_command_has_is_one_of_its_own() {
        const SAMPLE: f64 = 1e-3;
        let tone = |f: f64, k: usize| (std::f64::consts::TAU * f * k as f64 * SAMPLE).sin();
        let record = |(name, rows): (&str, usize)| RecordRows {
            name: name.to_owned(),
            time: (0..rows).map(|k| SAMPLE * k as f64).collect(),
            command: (0..rows).map(|k| tone(17.3, k)).collect(),
            y: vec![0.0; rows],
            aux: vec![(0..rows).map(|k| tone(81.7, k)).collect()],
            others: Vec::new(),
            run_in: 0,
            training: 0.7,
        };
        let lengths = [("short", 2000), ("long", 3000), ("other", 2400)];
        let neighbour = [("neighbour".to_owned(), true)];
        let data = DataSet::new(lengths.map(record).into(), &neighbour, None);
        let mut random = Random::new(5);
        // Lines of two records, of one of them, of the longest; of the neighbour, of the command, of the mains.
        let residual: Vec<f64> = lengths
            .iter()
            .flat_map(|(name, rows)| (0..*rows).map(move |k| (*name, k)))
            .map(|(name, k)| {
                let lines: &[f64] = match name {
                    "short" => &[123.4, 222.2, 81.7, 51.9, 100.0],
                    "long" => &[333.3, 81.7, 17.3, 100.0],
                    _ => &[123.4, 81.7, 17.3],
                };
                lines.iter().map(|f| tone(*f, k)).sum::<f64>() + random.uniform() - 0.5
            })
            .collect();
        let found = own_lines(&data, &residual, SAMPLE);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!((found[0] - 123.4).abs() < 0.1 && (found[1] - 333.3).abs() < 0.1, "{found:?}");
    }

    /// Of a slow command each line is near a multiple; one that stays where it is while commands change is none.
    #[test]
    fn a_line_that_all_records_have_is_its_own_though_most_commands_could_cause_it() {
        const SAMPLE: f64 = 1e-3;
        const ROWS: usize = 2000;
        let tone = |f: f64, k: usize| (std::f64::consts::TAU * f * k as f64 * SAMPLE).sin();
        // Ten times 2.21, seven times 3.28; only the last one has nothing there.
        let commands = [("a", 2.21), ("b", 3.28), ("c", 138.25)];
        let record = |(name, f): (&str, f64)| RecordRows {
            name: name.to_owned(),
            time: (0..ROWS).map(|k| SAMPLE * k as f64).collect(),
            command: (0..ROWS).map(|k| tone(f, k)).collect(),
            y: vec![0.0; ROWS],
            aux: Vec::new(),
            others: Vec::new(),
            run_in: 0,
            training: 1.0,
        };
        let data = DataSet::new(commands.map(record).into(), &[], None);
        let found = |lines: [f64; 3]| {
            let mut random = Random::new(5);
            let rows = lines.iter().flat_map(|f| (0..ROWS).map(move |k| (*f, k)));
            let residual: Vec<f64> =
                rows.map(|(f, k)| tone(f, k) + random.uniform() - 0.5).collect();
            own_lines(&data, &residual, SAMPLE)
        };
        let own = found([22.53, 22.53, 22.53]);
        assert!(matches!(own[..], [f] if (f - 22.53).abs() < 0.05), "{own:?}");
        // Elsewhere in each: answers.
        let answers = found([22.1, 22.96, 22.53]);
        assert!(answers.is_empty(), "{answers:?}");
    }
}

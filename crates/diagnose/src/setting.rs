//! What the logs and the re-tuned model say before formulas are written: ranges, slopes, lines of its own.

use std::sync::atomic::AtomicU64;

use components::linear::Transition;
use surround::Span;

use crate::candidate::Candidate;
use crate::chain::{Bench, Horizon};
use crate::converter::Converted;
use crate::data_set::DataSet;
use crate::library::Setting;
use crate::score::mean_square;
use crate::task::Task;
use crate::thresholds::search::Thresholds;
use crate::{jitter, spectrum};

/// Range of the simulated output.
pub(crate) fn simulated_span(base: &Candidate, data: &DataSet, count: &AtomicU64) -> Option<Span> {
    let mut bench = Bench::new(&base.chain, data, Horizon::All, count);
    let simulated = bench.keep(&base.fit.theta).ok()?;
    let moves = simulated.windows(2).any(|w| w[0] != w[1]);
    let mut span = Span::of(simulated.iter().copied());
    if !moves {
        span.half = 0.0;
    }
    Some(span)
}

/// What formulas are written for, from the re-tuned model.
pub(crate) fn setting<'a>(
    task: &'a Task,
    base: &Candidate,
    position: Span,
    sigma: f64,
) -> Setting<'a> {
    let data = &task.data;
    let sample = data.sample_time;
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
    let before = before_mode(task, residual);
    let command = Converted::new(&rows, data.command_span, &before, training());
    // The reading less what the model leaves of it: the simulated one.
    let simulated: Vec<f64> = data.y.iter().zip(residual).map(|(y, r)| y - sigma * r).collect();
    let reading = Converted::new(&simulated, position, residual, training());
    let swings = jitter::frequencies(data, residual, &simulated, sample);
    let half = if position.half > 0.0 { position.half } else { 1.0 };
    let leaves = sigma * mean_square(residual).sqrt() / data.output_span.half;
    Setting {
        base: &task.base,
        data,
        command: data.command_span,
        position: Span { half, ..position },
        leaves,
        sample,
        length,
        steepest,
        slope_power,
        loop_power,
        apparent_power,
        lines,
        swings,
        resonance: task.base.resonance(),
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
        let mut lines = spectrum::lines(&residual[rows.clone()], sample, Thresholds::LINES);
        lines.retain(|f| !is_mains(*f));
        seen.extend(lines.iter().map(|f| (*f, Thresholds::LINE_SAME * resolution)));
        for (hits, span) in commands.iter().filter(|(_, span)| span.half > 0.0) {
            let at = data.row_hit[rows.clone()].iter();
            let command: Vec<f64> = at.map(|h| hits[*h as usize] * 1e3 / span.half).collect();
            let driven = spectrum::lines(&command, sample, Thresholds::COMMAND_LINES);
            // A line that the command has, or a multiple of its strongest, is an answer to the command.
            lines.retain(|f| {
                let is_multiple = driven.first().is_some_and(|d| {
                    let times = (f / d).round().max(1.0);
                    // Near a multiple of a slow command is every line, if near is not a part of its frequency.
                    times <= Thresholds::COMMAND_ORDERS
                        && (f - times * d).abs() < resolution.min(Thresholds::LINE_MULTIPLE * d)
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
    all.retain(|(f, records, first, _)| {
        *records > 1 || *first == 0 || times(*f) >= Thresholds::LINE_RECORDS
    });
    all.sort_by(|a, b| b.1.cmp(&a.1).then(a.3.cmp(&b.3)).then(a.0.total_cmp(&b.0)));
    all.into_iter().take(Thresholds::LINES).map(|(f, ..)| f).collect()
}

/// Whether a frequency is that of the mains or a multiple of it.
fn is_mains(frequency: f64) -> bool {
    let is_near = |f: f64| (frequency / f - 1.0).abs() < Thresholds::MAINS_NEAR;
    [50.0, 60.0].iter().any(|m| (1..=Thresholds::MAINS_ORDERS).any(|k| is_near(m * f64::from(k))))
}

/// What an error of the command would have to be at each row to leave this residual, in σ: the residual
/// with the model's first mode taken out, as far as noise permits.
fn before_mode(task: &Task, residual: &[f64]) -> Vec<f64> {
    let data = &task.data;
    let Some((frequency, damping)) = task.base.mode_values() else { return residual.to_vec() };
    let transition = Transition::new(frequency, damping, data.sample_time);
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
        let found =
            spectrum::deconvolve(part, &response, 1.0 / (power - 1.0).max(Thresholds::LEFT_SOUGHT));
        part.copy_from_slice(&found);
    }
    sought
}

#[cfg(test)]
mod tests {
    use numerics::random::SplitMix64;

    use super::*;
    use crate::data_set::RecordRows;

    #[test]
    fn a_line_of_two_records_that_no_command_has_is_one_of_its_own() {
        const SAMPLE: f64 = 1e-3;
        let tone = |f: f64, k: usize| (std::f64::consts::TAU * f * k as f64 * SAMPLE).sin();
        let record = |(name, rows): (&str, usize)| RecordRows {
            name: name.to_owned(),
            command: (0..rows).map(|k| tone(17.3, k)).collect(),
            aux: vec![(0..rows).map(|k| tone(81.7, k)).collect()],
            ..RecordRows::still(rows, 0.7)
        };
        let lengths = [("short", 2000), ("long", 3000), ("other", 2400)];
        let neighbour = [("neighbour".to_owned(), true)];
        let data = DataSet::new(lengths.map(record).into(), &neighbour, None);
        let mut random = SplitMix64::new(5);
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
            command: (0..ROWS).map(|k| tone(f, k)).collect(),
            ..RecordRows::still(ROWS, 1.0)
        };
        let data = DataSet::new(commands.map(record).into(), &[], None);
        let found = |lines: [f64; 3]| {
            let mut random = SplitMix64::new(5);
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

//! Where the machine rested before a log begins, or that it did not rest.
//!
//! A log often begins with the row whose command sets the machine in motion. Its readings then move though the
//! logged command stands still, which no model does that rests under the first row's command. The machine
//! rested under another one, u₀, which follows from how far the reading moves until it stands still itself:
//! `rest(u₀) = rest(u₁) + y₁ − y_still`, with the re-tuned model's `rest`.

use std::sync::atomic::AtomicU64;

use numerics::median;

use crate::between::Between;
use crate::candidate::Candidate;
use crate::chain::{Bench, Horizon};
use crate::data_set::{DataSet, RecordRows};
use crate::score::Judged;
use crate::task::Task;
use crate::thresholds::base::Thresholds;

/// A record that begins during a motion, which no model follows that starts at rest, and the time in s until what
/// that leaves has decayed: the record whose run-in is longest.
pub(crate) fn in_motion(task: &Task, left: &Judged) -> Option<(String, f64)> {
    // Without a mode nothing swings on by itself: what stands out then is a first stroke from rest.
    task.base.mode?;
    let data = &task.data;
    let all = data.records.iter().filter_map(|record| {
        let blocks = run_in(&left.residual[record.rows.clone()])?;
        let time = &data.time[record.rows.clone()];
        Some((record.name.clone(), time[blocks] - time[0]))
    });
    let (record, time) = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
    // A time that can be said in few digits.
    let digit = 10f64.powf(time.log10().floor() - 1.0);
    format!("{:.1e}", (time / digit).ceil() * digit).parse().ok().map(|time| (record, time))
}

/// Rows at the start of a residual that stand out.
fn run_in(residual: &[f64]) -> Option<usize> {
    let rows = (residual.len() / Thresholds::RUN_IN_BLOCKS).max(Thresholds::RUN_IN_ROWS);
    let longest = ((residual.len() / rows) as f64 * Thresholds::RUN_IN_LONGEST) as usize;
    if longest < 2 {
        return None;
    }
    let level = median(&mut residual[longest * rows..].to_vec())?;
    let squares = |block: &[f64]| block.iter().map(|e| (e - level).powi(2)).sum::<f64>();
    let blocks: Vec<f64> = residual.chunks_exact(rows).map(squares).collect();
    let mut later = blocks[longest..].to_vec();
    later.sort_by(f64::total_cmp);
    let usual = later[((later.len() - 1) as f64 * Thresholds::RUN_IN_USUAL) as usize];
    // What a machine at rest does that no model has begins with nothing.
    let at_once = Thresholds::RUN_IN_AT_ONCE * (blocks[0] / rows as f64).sqrt();
    let stands_out = blocks[0] > Thresholds::RUN_IN_STANDS_OUT * later.last()?
        && residual[..2].iter().any(|e| (e - level).abs() > at_once);
    let end = blocks[..longest].iter().position(|block| *block <= usual)?;
    stands_out.then_some(end * rows)
}

/// Takes each record from the rest that its first readings show, and says so; whether any is another one than
/// that of the first row's command.
pub(crate) fn find(task: &mut Task, base: &Candidate, count: &AtomicU64) -> bool {
    // A command that moves between the rows moves the machine before the row that shows it.
    if !task.base.is_white || task.course.between != Between::Zoh {
        return false;
    }
    let sigma = task.noise.sigma * task.factor;
    let found: Vec<(usize, f64, f64)> = (0..task.data.records.len())
        .filter_map(|record| {
            let (first, way) = moved(&task.data, record, sigma)?;
            Some((record, rest_before(&task.data, base, first, way, count)?, way))
        })
        .collect();
    for (record, rest, way) in &found {
        let data = &mut task.data.records[*record];
        data.rest = Some(*rest);
        task.warnings.push(format!(
            "{}: {} moves by {} {} before {} first changes: the machine is taken to have rested under {} {} before \
             the first row (--drop S omits the beginning)",
            data.name,
            task.output,
            report::format_number(-way / task.factor, 3),
            task.unit,
            task.input,
            report::format_number(rest / task.command_factor, 4),
            task.command_unit
        ));
    }
    if !found.is_empty() {
        task.data = task.data.played(task.course);
    }
    !found.is_empty()
}

/// The first command of a record, and where its first reading is beside that at which it stands while the
/// command does; none where it does not move, or is moved by a command of the log.
fn moved(data: &DataSet, record: usize, sigma: f64) -> Option<(f64, f64)> {
    let record = &data.records[record];
    let still = record.still();
    if !record.run_in.is_empty() || still < Thresholds::START_ROWS || still >= record.rows.len() {
        return None;
    }
    // The reading of a row is taken before its command acts.
    let y = &data.y[record.rows.start..=record.rows.start + still];
    let (first, stands) = (y[0], y[still]);
    let way = first - stands;
    let is_seen = way.abs() > Thresholds::START_MOVES.0 * 2.0 * data.output_span.half
        && way.abs() > Thresholds::START_MOVES.1 * sigma;
    let is_one_way = y.iter().all(|y| (y - stands).abs() <= Thresholds::START_SWINGS * way.abs());
    let first_command = data.command[record.hits.start];
    (is_seen && is_one_way).then_some((first_command, way))
}

/// The command under which the model rests this far from where it rests under `first`.
fn rest_before(
    data: &DataSet,
    base: &Candidate,
    first: f64,
    way: f64,
    count: &AtomicU64,
) -> Option<f64> {
    let target = rest(data, base, first, count)? + way;
    let beside = |u: f64| rest(data, base, u, count).map(|y| y - target);
    let span = data.command_span;
    let (mut low, mut high) = (
        span.centre - Thresholds::REST_FAR * span.half,
        span.centre + Thresholds::REST_FAR * span.half,
    );
    let (at_low, at_high) = (beside(low)?, beside(high)?);
    if at_low * at_high > 0.0 || at_low == at_high {
        return None;
    }
    for _ in 0..Thresholds::REST_HALVINGS {
        let middle = 0.5 * (low + high);
        if beside(middle)? * at_low > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

/// Where the re-tuned model rests under a command.
fn rest(data: &DataSet, base: &Candidate, command: f64, count: &AtomicU64) -> Option<f64> {
    let rows = RecordRows {
        name: String::new(),
        time: vec![0.0, data.step],
        command: vec![command; 2],
        y: vec![0.0; 2],
        aux: vec![vec![0.0; 2]; data.aux.len()],
        others: Vec::new(),
        run_in: 0,
        training: 1.0,
    };
    let names: Vec<_> = data.aux.iter().map(|a| (a.name.clone(), a.is_command)).collect();
    let still = DataSet::new(vec![rows], &names, Some(data.step));
    let mut bench = Bench::new(&base.chain, &still, Horizon::All, count);
    bench.keep(&base.fit.theta).ok()?.first().copied()
}

#[cfg(test)]
mod tests {
    use numerics::random::SplitMix64;

    use super::*;

    const SEED: u64 = 5;

    /// A swing that decays from the first row on, or grows to its size first, in noise.
    fn residual(swing: f64, delay: f64) -> Vec<f64> {
        let mut random = SplitMix64::new(SEED);
        let at = |t: f64| swing * (1.0 - (-t / delay).exp()) * (-t / 40.0).exp() * (0.7 * t).cos();
        (0..4000).map(|k| 3.0 + at(f64::from(k) + 0.01) + random.uniform() - 0.5).collect()
    }

    #[test]
    fn a_swing_from_the_first_row_on_is_a_motion() {
        let rows = run_in(&residual(60.0, 1e-3)).expect("a run-in");
        // Until 60·exp(−t/40) is below the noise of 0.29.
        assert!((140..300).contains(&rows), "seed {SEED}: {rows}");
    }

    #[test]
    fn what_begins_with_nothing_or_is_small_is_none() {
        for (swing, delay) in [(0.0, 1.0), (0.3, 1e-3), (60.0, 30.0)] {
            assert_eq!(run_in(&residual(swing, delay)), None, "seed {SEED}: {swing}, {delay}");
        }
    }

    #[test]
    fn a_burst_that_comes_again_is_none() {
        let one = residual(60.0, 1e-3);
        assert_eq!(run_in(&[&one[..1000], &one[..1000]].concat()), None, "seed {SEED}");
    }
}

//! Plays inside a black box, from its answer to a staircase.
//!
//! From a turning point on, a sum of plays follows `D(x) = w₀·x + Σ wₖ·max(0, x − 2rₖ)` of the way x, whose second
//! differences are the weights (Prandtl–Ishlinskii; Kuhnen, European Journal of Control 9, 2003).

use components::hysteresis::play::{Drive, Threshold, play};
use surround::{Block, Memory, Signals, Span};

use super::{BlackBox, Entry};
use crate::data_set::RecordData;
use crate::thresholds::base::Thresholds;

impl BlackBox {
    /// Thresholds and weights of the plays between the driven input and the mode that the output leaves through;
    /// none where the box holds no plays, or something else that bends its answer.
    pub(crate) fn memory(
        &self,
        record: &RecordData,
        command: Span,
        first: f64,
        entry: Option<Entry>,
    ) -> Option<Memory> {
        let held = match entry.map_or(0.0, |entry| entry.lag) {
            lag if lag > 0.0 => {
                Thresholds::PLAY_HELD + (Thresholds::PLAY_SETTLED.ln() / lag.ln()).ceil() as usize
            }
            _ => Thresholds::PLAY_HELD,
        };
        let (low, step) =
            (command.centre - command.half, 2.0 * command.half / Thresholds::PLAY_LEVELS as f64);
        // Up from below, down to the bottom, up again.
        let way = (0..=Thresholds::PLAY_LEVELS)
            .chain((0..Thresholds::PLAY_LEVELS).rev())
            .chain(1..=Thresholds::PLAY_LEVELS);
        let course: Vec<f64> =
            way.flat_map(|k| std::iter::repeat_n(low + k as f64 * step, held)).collect();
        let entered = self.entered(record, &course, entry)?;
        let at = |level: usize| entered[(level + 1) * held - 1];
        let falling: Vec<f64> = (0..=Thresholds::PLAY_LEVELS)
            .map(|k| at(Thresholds::PLAY_LEVELS) - at(Thresholds::PLAY_LEVELS + k))
            .collect();
        let memory = of_branch(&falling, step)?;
        // The staircase itself, then loops of several sizes from rest.
        if left(&course, &entered, entry, &memory) > Thresholds::PLAY_OFF {
            return None;
        }
        let rows = self.times.get(&record.rows.start)?.len().min(Thresholds::PLAY_CHECKED);
        let own: Vec<f64> = moved(command, first, rows);
        let entered = self.entered(record, &own, entry)?;
        (left(&own, &entered, entry, &memory) <= Thresholds::PLAY_OFF).then_some(memory)
    }

    /// What enters the mode under this course of the driven input, the others held.
    fn entered(
        &self,
        record: &RecordData,
        course: &[f64],
        entry: Option<Entry>,
    ) -> Option<Vec<f64>> {
        let answer = self.answer(record, course)?;
        let Some(Entry { frequency, damping, .. }) = entry else { return Some(answer) };
        let step = self.sample(record)?;
        let mut entered = vec![0.0; answer.len()];
        let before = Block::BeforeMode { frequency, damping }.prepare(&[], step).ok()?;
        before.run(Signals::path(&answer), &mut entered);
        Some(entered)
    }
}

/// What plays and a straight line leave of what enters the mode, over what the plays' own part is.
fn left(course: &[f64], entered: &[f64], entry: Option<Entry>, memory: &Memory) -> f64 {
    let lag = entry.map_or(0.0, |entry| entry.lag);
    let mut late = course.first().copied().unwrap_or(0.0);
    let mut states = vec![0.0_f64; memory.r.len()];
    let mut parts = Vec::with_capacity(course.len());
    for u in course {
        late = lag * late + (1.0 - lag) * u;
        let plays = memory.r.iter().zip(&memory.w).zip(&mut states);
        let part: f64 = plays
            .map(|((r, w), p)| {
                *p = play(Drive(late), Threshold(*r), *p);
                w * (*p - late)
            })
            .sum();
        parts.push((late, part));
    }
    let n = parts.len().max(1) as f64;
    let mean = |of: &dyn Fn(usize) -> f64| (0..parts.len()).map(of).sum::<f64>() / n;
    let (u, m) = (mean(&|k| parts[k].0), mean(&|k| parts[k].1));
    let x = mean(&|k| entered[k] - parts[k].1);
    let cross = mean(&|k| (parts[k].0 - u) * (entered[k] - parts[k].1 - x));
    let slope = cross / mean(&|k| (parts[k].0 - u).powi(2)).max(f64::MIN_POSITIVE);
    let rest = mean(&|k| (entered[k] - parts[k].1 - x - slope * (parts[k].0 - u)).powi(2));
    (rest / mean(&|k| (parts[k].1 - m).powi(2)).max(f64::MIN_POSITIVE)).sqrt()
}

/// Loops of several sizes within the range, from the value at rest.
fn moved(command: Span, first: f64, rows: usize) -> Vec<f64> {
    let turn = |k: usize| (0.37 * (k as f64 + 1.0) * (k as f64 + 2.3)).sin();
    let (turns, mut level) = (24, first);
    let length = (rows / turns).max(1);
    let mut all = Vec::with_capacity(rows);
    for k in 0..turns {
        let next = command.centre + command.half * turn(k);
        all.extend((1..=length).map(|n| level + (next - level) * n as f64 / length as f64));
        level = next;
    }
    all
}

/// The plays of a branch, from values at levels this far apart that begin at a turning point.
fn of_branch(branch: &[f64], step: f64) -> Option<Memory> {
    let slope = (branch.last()? - branch.first()?) / (step * (branch.len() - 1) as f64);
    let bend = |w: &[f64]| (w[2] - 2.0 * w[1] + w[0]) / step;
    // The weight at threshold k/2 steps.
    let mut weights = vec![0.0];
    weights.extend(branch.windows(3).map(bend));
    weights
        .iter_mut()
        .filter(|w| w.abs() < Thresholds::PLAY_NOTHING * slope.abs())
        .for_each(|w| *w = 0.0);
    let (mut r, mut w) = (Vec::new(), Vec::new());
    let mut k = 1;
    while k < weights.len() {
        let run = weights[k..].iter().take_while(|w| **w != 0.0).count();
        let place = |k: usize| 0.5 * step * k as f64;
        // A play between two levels shows at both.
        if run == 2 && weights[k] * weights[k + 1] > 0.0 {
            let sum = weights[k] + weights[k + 1];
            r.push((weights[k] * place(k) + weights[k + 1] * place(k + 1)) / sum);
            w.push(sum);
        } else {
            r.extend((k..k + run).map(place));
            w.extend(&weights[k..k + run]);
        }
        k += run.max(1);
    }
    let all: f64 = w.iter().map(|w: &f64| w.abs()).sum();
    (all > Thresholds::PLAY_SOME * slope.abs()).then_some(Memory { r, w })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plays_are_read_from_a_branch() {
        let (r, w) = ([0.61, 1.9, 4.0], [0.3, 0.2, 0.1]);
        let step = 0.25;
        let at = |k: usize| {
            let x = k as f64 * step;
            x + r.iter().zip(&w).map(|(r, w)| w * (x - 2.0 * r).max(0.0)).sum::<f64>()
        };
        let branch: Vec<f64> = (0..=Thresholds::PLAY_LEVELS).map(at).collect();
        let memory = of_branch(&branch, step).unwrap();
        assert_eq!(memory.r.len(), 3, "{memory:?}");
        for k in 0..3 {
            assert!((memory.r[k] - r[k]).abs() < 1e-9, "{memory:?}");
            assert!((memory.w[k] - w[k]).abs() < 1e-9, "{memory:?}");
        }
        let line: Vec<f64> = (0..=Thresholds::PLAY_LEVELS).map(|k| 0.7 * k as f64).collect();
        assert_eq!(of_branch(&line, step), None);
    }
}

//! What is doubtful about a log's samples: lost rows, outliers, saturation, a stuck reading.
//!
//! Nothing is repaired silently: a finding names the row of the file, and the user decides.

use std::fmt;
use std::ops::Range;

use super::{Log, Record};

/// What is doubtful.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quality {
    /// Rows are missing between this row and the next one: how many, by the median sample time.
    Missing(usize),
    /// One to three samples lie apart from both neighbours: by how many standard deviations of
    /// the signal's second differences.
    Outlier(f64),
    /// The reading stays exactly at its extreme, although it has noise elsewhere.
    Saturated,
    /// The reading stays exactly where it is, although it has noise elsewhere.
    Stuck,
}

/// Rows of a log that are doubtful.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The column; `time` for missing rows.
    pub column: String,
    /// The number of the record.
    pub record: i64,
    /// The rows, from 0.
    pub rows: Range<usize>,
    /// Where the first of them stands: `log.csv:12`.
    pub place: String,
    /// The value in the first of them, in the column's unit.
    pub value: f64,
    /// What is doubtful.
    pub quality: Quality,
}

/// Standard deviations from which a sample is an outlier: one in 1e32 Gaussian samples.
const OUTLIER: f64 = 12.0;
/// Samples of the longest outlier.
const WIDEST: usize = 3;
/// Samples that stay equal before they are doubtful.
const STAYS: usize = 8;
/// Part of the neighbours that may be equal in a signal with noise.
const RARE: f64 = 0.02;

impl Log {
    /// Everything that is doubtful about the samples, in the order of the rows.
    ///
    /// *Missing rows*: a sample time beyond 1.5 medians. *Outliers*: samples y_k … y_{k+w−1}, w ≤ 3, whose mean is more
    /// than 12 σ from the mean of y_{k−1} and y_{k+w}, and more than twice the smaller of the steps from y_{k−2} to y_{k−1}
    /// and from y_{k+w} to y_{k+w+1}, while y_{k−1} and y_{k+w} are no more than a quarter of that apart; σ is the
    /// median of |y_{k+1} − 2 y_k + y_{k−1}|/2 over 0.6745. *Saturated* and *stuck*: at least eight equal samples in a
    /// row, where fewer than 2 % of all neighbours are equal otherwise: a command that is held is neither.
    #[must_use]
    pub fn quality(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        for record in &self.records {
            self.missing(record, &mut findings);
            for column in &self.columns {
                let values = &column.values[record.rows.clone()];
                let mut note = |rows: Range<usize>, quality| {
                    let value = values[rows.start];
                    findings.push(self.finding(&column.name, record, rows, value, quality));
                };
                outliers(values, &mut note);
                stays(values, &mut note);
            }
        }
        findings.sort_by_key(|finding| finding.rows.start);
        findings
    }

    /// A finding in these rows of a record.
    fn finding(
        &self,
        column: &str,
        record: &Record,
        rows: Range<usize>,
        value: f64,
        quality: Quality,
    ) -> Finding {
        let rows = record.rows.start + rows.start..record.rows.start + rows.end;
        let place = self.place_of(rows.start);
        Finding { column: column.into(), record: record.id, rows, place, value, quality }
    }

    fn missing(&self, record: &Record, findings: &mut Vec<Finding>) {
        let time = &self.time[record.rows.clone()];
        let mut periods: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let Some(usual) = median(&mut periods) else { return };
        for (row, pair) in time.windows(2).enumerate() {
            let lost = (pair[1] - pair[0]) / usual - 1.0;
            if lost > 0.5 {
                let quality = Quality::Missing(lost.round() as usize);
                findings.push(self.finding("time", record, row..row + 2, pair[0], quality));
            }
        }
    }
}

fn outliers(values: &[f64], note: &mut impl FnMut(Range<usize>, Quality)) {
    let apart = |k: usize| (values[k + 1] - 2.0 * values[k] + values[k - 1]).abs() / 2.0;
    let mut all: Vec<f64> = (1..values.len().saturating_sub(1)).map(apart).collect();
    // Where most samples are on a straight line, the smallest deviation that occurs is the scale.
    let least = all.iter().copied().filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
    let Some(middle) = median(&mut all) else { return };
    let sigma = (middle / 0.6745).max(if least.is_finite() { least } else { return });
    // By the rules below the first sample of an outlier lies 0.5 − 0.125 distances from the one before it, or
    // more; nearly all samples need no other look.
    let step = 0.37 * OUTLIER * sigma;
    let mut k = 1;
    while k + 1 < values.len() {
        if (values[k] - values[k - 1]).abs() <= step {
            k += 1;
            continue;
        }
        let found = (1..=WIDEST.min(values.len() - 1 - k)).find_map(|width| {
            let (before, behind) = (values[k - 1], values[k + width]);
            let inside = &values[k..k + width];
            let distance = inside.iter().sum::<f64>() / width as f64 - 0.5 * (before + behind);
            let is_alone = (behind - before).abs() <= 0.25 * distance.abs();
            let is_one = inside.iter().all(|v| (v - 0.5 * (before + behind)) / distance > 0.5);
            // The corner of a triangle is as far from its neighbours' mean as these are from theirs.
            let outside =
                |at: usize, next: usize| Some((values.get(at)? - values.get(next)?).abs());
            let steps = [outside(k.wrapping_sub(2), k - 1), outside(k + width + 1, k + width)];
            let slope = steps.into_iter().flatten().reduce(f64::min).unwrap_or(0.0);
            let is_far = distance.abs() > (OUTLIER * sigma).max(2.0 * slope);
            (is_far && is_alone && is_one).then_some((width, distance.abs() / sigma))
        });
        match found {
            Some((width, by)) => {
                note(k..k + width, Quality::Outlier(by));
                k += width + 1;
            }
            None => k += 1,
        }
    }
}

fn stays(values: &[f64], note: &mut impl FnMut(Range<usize>, Quality)) {
    let runs = || {
        values.chunk_by(|left, right| left == right).scan(0, |start, run| {
            *start += run.len();
            Some(*start - run.len()..*start)
        })
    };
    // Equal neighbours outside of long runs: with quantisation or a held command they are common.
    let (mut equal, mut rows, mut has_long) = (0, 0, false);
    for run in runs() {
        if run.len() < STAYS {
            equal += run.len() - 1;
            rows += run.len();
        } else {
            has_long = true;
        }
    }
    if !has_long || rows < STAYS || equal as f64 > RARE * rows as f64 {
        return;
    }
    let (least, most) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    for run in runs().filter(|run| run.len() >= STAYS) {
        let value = values[run.start];
        let is_extreme = value == least || value == most;
        note(run, if is_extreme { Quality::Saturated } else { Quality::Stuck });
    }
}

/// The middle one of the values in order, of an even number the upper one of two. It reorders them.
pub(crate) fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

impl fmt::Display for Finding {
    /// `log.csv:12: y = 3.2: outlier, 41 standard deviations from its neighbours; …`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, column, value, rows, .. } = self;
        let count = rows.len();
        let s = if count == 1 { "" } else { "s" };
        write!(f, "{place}: {column} = {value}: ")?;
        match self.quality {
            Quality::Missing(lost) => {
                let rows = if lost == 1 { "1 row is" } else { &format!("{lost} rows are") };
                write!(f, "{rows} missing behind this one; begin a new record there, or resample")
            }
            Quality::Outlier(by) => write!(
                f,
                "{count} sample{s} {by:.0} standard deviations away from the neighbours; check the sensor, or \
                 leave the rows out"
            ),
            Quality::Saturated => write!(
                f,
                "{count} samples stay exactly at the signal's extreme: saturated; reduce the amplitude, or \
                 leave the rows out"
            ),
            Quality::Stuck => write!(
                f,
                "{count} samples stay exactly equal in a signal that has noise: stuck; check the sensor, or \
                 leave the rows out"
            ),
        }
    }
}

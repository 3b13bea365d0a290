//! Instants that swing: a sample that is taken, or a command that arrives, by `j(t)` too late shows
//! `j` times the signal's rate.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::data_set::DataSet;

/// Frequencies that are tried.
const MOST: usize = 2;
/// Part of the residual that a swing must take to be tried, as the sums over the records of the rms of both.
const LEAST: f64 = 0.1;
/// Highest frequency, times the sample time: faster jitter is noise.
pub(crate) const HIGHEST: f64 = 0.1;
/// Length of the transform over that of the longest record, so that no peak lies between its lines.
const FINE: usize = 4;
/// Rows that a record must have to show one.
const FEWEST: usize = 64;

/// Change of a signal per row, over the range of the output.
pub(crate) fn rate(signal: &[f64], data: &DataSet) -> Vec<f64> {
    let mut rate = vec![0.0; signal.len()];
    for rows in data.records.iter().map(|record| record.rows.clone()) {
        for row in rows.clone() {
            let (before, after) =
                (rows.start.max(row.saturating_sub(1)), rows.end.min(row + 2) - 1);
            let change = signal[after] - signal[before];
            rate[row] = change / ((after - before).max(1) as f64 * data.output_span.half);
        }
    }
    rate
}

/// Frequencies in Hz at which the residual swings with the rate of what is simulated, by what
/// `r ≈ v·(a + b·t + c·sin 2πft + d·cos 2πft)` takes with coefficients of each record's own; the
/// strongest first. The records' amplitudes are summed and not their powers: what swings does in all of
/// them, what only looks so at one command does in that one.
pub(crate) fn frequencies(
    data: &DataSet,
    residual: &[f64],
    simulated: &[f64],
    sample: f64,
) -> Vec<f64> {
    let longest = data.records.iter().map(|r| r.training.len()).max().unwrap_or(0);
    if longest < FEWEST {
        return Vec::new();
    }
    let rate = rate(simulated, data);
    let length = (FINE * longest).next_power_of_two();
    let transform = FftPlanner::new().plan_fft_forward(length);
    let mut taken = vec![0.0; length / 2];
    let mut total = 0.0;
    for rows in data.records.iter().map(|record| record.training.clone()) {
        let v = &rate[rows.clone()];
        let power: f64 = v.iter().map(|v| v * v).sum();
        if rows.len() < FEWEST || !(power > 0.0) {
            continue;
        }
        let left = without_steady(&residual[rows], v);
        total += left.iter().map(|r| r * r).sum::<f64>().sqrt();
        let mut line = vec![Complex::new(0.0, 0.0); length];
        line.iter_mut().zip(left.iter().zip(v)).for_each(|(z, (r, v))| z.re = r * v);
        transform.process(&mut line);
        for (sum, z) in taken.iter_mut().zip(&line) {
            *sum += (2.0 * z.norm_sqr() / power).sqrt();
        }
    }
    let step = 1.0 / (length as f64 * sample);
    let first = length.div_ceil(longest);
    let last = ((HIGHEST * length as f64) as usize).min(taken.len() - 1);
    let is_peak = |k: &usize| taken[*k] >= taken[k - 1] && taken[*k] > taken[k + 1];
    let mut peaks: Vec<usize> =
        (first..last).filter(|k| taken[*k] > LEAST * total && is_peak(k)).collect();
    peaks.sort_by(|a, b| taken[*b].total_cmp(&taken[*a]).then(a.cmp(b)));
    peaks.into_iter().take(MOST).map(|k| k as f64 * step).collect()
}

/// A residual less its mean and what it has of the rate, and of the rate times the time.
fn without_steady(residual: &[f64], rate: &[f64]) -> Vec<f64> {
    let mean = residual.iter().sum::<f64>() / residual.len() as f64;
    let mut left: Vec<f64> = residual.iter().map(|r| r - mean).collect();
    let middle = 0.5 * (rate.len() as f64 - 1.0);
    let growing: Vec<f64> =
        rate.iter().enumerate().map(|(k, v)| v * (k as f64 / middle - 1.0)).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let take = |left: &mut [f64], of: &[f64]| {
        let power = dot(of, of);
        if power > 0.0 {
            let part = dot(left, of) / power;
            left.iter_mut().zip(of).for_each(|(l, v)| *l -= part * v);
        }
    };
    // The second one less what it has of the first: one after the other is both together then.
    let mut own = growing;
    take(&mut own, rate);
    take(&mut left, rate);
    take(&mut left, &own);
    left
}

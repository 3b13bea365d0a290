//! Instants that swing: a sample that is taken, or a command that arrives, by `j(t)` too late shows
//! `j` times the signal's rate.

use numerics::Complex;
use numerics::fft::Fft;

use crate::data_set::DataSet;
use crate::normal::dot;
use crate::thresholds::search::Thresholds;

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
    if longest < Thresholds::JITTER_ROWS {
        return Vec::new();
    }
    let rate = rate(simulated, data);
    let length = (Thresholds::JITTER_FINE * longest).next_power_of_two();
    let transform = Fft::forward(length);
    let mut taken = vec![0.0; length / 2];
    let mut total = 0.0;
    for rows in data.records.iter().map(|record| record.training.clone()) {
        let v = &rate[rows.clone()];
        let power: f64 = v.iter().map(|v| v * v).sum();
        if rows.len() < Thresholds::JITTER_ROWS || power <= 0.0 {
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
    let last = ((Thresholds::JITTER_HIGHEST * length as f64) as usize).min(taken.len() - 1);
    let is_peak = |k: &usize| taken[*k] >= taken[k - 1] && taken[*k] > taken[k + 1];
    let mut peaks: Vec<usize> = (first..last)
        .filter(|k| taken[*k] > Thresholds::JITTER_LEAST * total && is_peak(k))
        .collect();
    peaks.sort_by(|a, b| taken[*b].total_cmp(&taken[*a]).then(a.cmp(b)));
    peaks.into_iter().take(Thresholds::JITTER_TRIED).map(|k| k as f64 * step).collect()
}

/// A residual less what it has of a constant, of the rate, and of the rate times the time.
fn without_steady(residual: &[f64], rate: &[f64]) -> Vec<f64> {
    let middle = 0.5 * (rate.len() as f64 - 1.0);
    let growing = rate.iter().enumerate().map(|(k, v)| v * (k as f64 / middle - 1.0)).collect();
    // Each one less what it has of those before: one after the other they are all together then.
    let mut taken: Vec<Vec<f64>> = Vec::new();
    let take = |from: &mut [f64], taken: &[Vec<f64>]| {
        for of in taken {
            let part = dot(from, of) / dot(of, of);
            from.iter_mut().zip(of).for_each(|(f, of)| *f -= part * of);
        }
    };
    for mut next in [vec![1.0; rate.len()], rate.to_vec(), growing] {
        let before = dot(&next, &next);
        take(&mut next, &taken);
        if dot(&next, &next) > 1e-12 * before {
            taken.push(next);
        }
    }
    let mut left = residual.to_vec();
    take(&mut left, &taken);
    left
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::data_set::RecordRows;

    const SAMPLE: f64 = 1e-3;

    /// Records of a sine, a triangle and steps, and the residual of instants that swing, with what a
    /// constant lateness and a clock that is fast leave beside it, in noise.
    fn records(swing: f64) -> (DataSet, Vec<f64>) {
        let rows = |name: &str, y: Vec<f64>| {
            let still = RecordRows::still(y.len(), 0.7);
            RecordRows { name: name.to_owned(), command: y.clone(), y, ..still }
        };
        let t = |k: usize| SAMPLE * k as f64;
        let sine = (0..3000).map(|k| (TAU * 11.0 * t(k)).sin()).collect();
        let triangle =
            (0..2500).map(|k| (4.0 * ((5.0 * t(k)).fract() - 0.5).abs()) - 1.0).collect();
        let steps = (0..2000).map(|k| f64::from((k / 90 % 5) as u8) - 2.0).collect();
        let records = vec![rows("a", sine), rows("b", triangle), rows("c", steps)];
        let data = DataSet::new(records, &[], None);
        let rate = rate(&data.y, &data);
        let (mut residual, mut noise) = (vec![0.0; data.y.len()], 1_u32);
        for (phase, record) in data.records.iter().enumerate() {
            for (k, row) in record.rows.clone().enumerate() {
                let late = 3.0 + 2.0 * t(k) + swing * (TAU * 3.3 * t(k) + phase as f64).sin();
                noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                residual[row] =
                    0.4 + late * rate[row] + 0.02 * (f64::from(noise >> 8) / 8.4e6 - 1.0);
            }
        }
        (data, residual)
    }

    #[test]
    fn the_frequency_of_a_swing_is_found_whatever_its_phase() {
        let (data, residual) = records(1.0);
        let found = frequencies(&data, &residual, &data.y, SAMPLE);
        assert!((found[0] - 3.3).abs() < 0.15, "{found:?}");
    }

    #[test]
    fn what_is_late_by_a_rule_does_not_swing() {
        let (data, residual) = records(0.0);
        let found = frequencies(&data, &residual, &data.y, SAMPLE);
        assert!(found.is_empty(), "{found:?}");
        // Nor does a model that stands still.
        let still = vec![1.0; data.y.len()];
        assert!(frequencies(&data, &residual, &still, SAMPLE).is_empty());
    }

    #[test]
    fn a_rate_stays_within_its_record() {
        let (data, _) = records(0.0);
        let rate = rate(&data.y, &data);
        let (first, second) = (data.records[0].rows.end - 1, data.records[1].rows.start);
        let half = data.output_span.half;
        assert!((rate[first] - (data.y[first] - data.y[first - 1]) / half).abs() < 1e-12);
        assert!((rate[second] - (data.y[second + 1] - data.y[second]) / half).abs() < 1e-12);
        assert!((rate[10] - (data.y[11] - data.y[9]) / (2.0 * half)).abs() < 1e-12);
    }
}

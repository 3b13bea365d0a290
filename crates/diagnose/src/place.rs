//! Where the gap lies: bands, records, amplitude, branch, time, and whether the command drives it.

use std::collections::BTreeMap;

use surround::Span;

use crate::data_set::DataSet;
use crate::gap::{BandShare, Place, RecordShare};
use crate::noise::Repeats;
use crate::score::mean_square;
use crate::spectrum::{self, Bands};
use crate::thresholds::answer::Thresholds;

/// Residuals before and after, in standard deviations, and where they are from.
pub(crate) struct Maps<'a> {
    pub(crate) data: &'a DataSet,
    /// Of the robustly re-tuned model.
    pub(crate) before: &'a [f64],
    pub(crate) after: &'a [f64],
    pub(crate) sigma: f64,
}

impl Maps<'_> {
    /// The command at each row.
    pub(crate) fn command(&self) -> Vec<f64> {
        // The row's own command acts after it: what moved the machine is the one before.
        self.data.row_hit.iter().map(|h| self.data.command[*h as usize]).collect()
    }

    pub(crate) fn place(&self, output: &str, input: &str, stage: Option<&str>) -> Place {
        let mut coherence = BTreeMap::new();
        let command = self.command();
        if let Some(c) = self.coherence(self.before, &command) {
            coherence.insert(input.to_owned(), c);
        }
        for aux in &self.data.aux {
            let values: Vec<f64> =
                self.data.row_hit.iter().map(|h| aux.hits[*h as usize]).collect();
            if let Some(c) = self.coherence(self.before, &values) {
                coherence.insert(aux.name.clone(), c);
            }
        }
        Place {
            output: output.to_owned(),
            stage: stage.map(str::to_owned),
            bands: self.bands(),
            records: self.records(),
            amplitude: self.amplitude(&command),
            branch: self.branch(&command),
            time: self.time(),
            input_driven: self.is_input_driven(self.before, &command),
            coherence,
        }
    }

    /// Power of each band over all records, noise taken off, largest first.
    pub(crate) fn bands(&self) -> Vec<BandShare> {
        let sample = self.data.sample_time;
        let longest = self.data.records.iter().map(|r| r.rows.len()).max().unwrap_or(0);
        let bands = Bands::new(longest, sample);
        let count = bands.ends.len() - 1;
        let (mut before, mut after, mut lines) =
            (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        for record in &self.data.records {
            let rows = record.rows.clone();
            let n = rows.len() as f64;
            let b = spectrum::band_powers(&self.before[rows.clone()], &bands, sample);
            let a = spectrum::band_powers(&self.after[rows], &bands, sample);
            for k in 0..count {
                let width = (bands.ends[k + 1] - bands.ends[k]) * n * sample;
                if b[k].is_finite() && a[k].is_finite() {
                    before[k] += b[k] * width;
                    after[k] += a[k] * width;
                    lines[k] += width;
                }
            }
        }
        let excess: Vec<f64> = (0..count).map(|k| (before[k] - lines[k]).max(0.0)).collect();
        let total: f64 = excess.iter().sum();
        let level = |p: f64, n: f64| 10.0 * (p / n).max(1e-12).log10();
        let mut all: Vec<BandShare> = (0..count)
            .filter(|k| lines[*k] > 0.0 && total > 0.0)
            .map(|k| BandShare {
                hz: [bands.ends[k], bands.ends[k + 1]],
                share: excess[k] / total,
                over_noise_db: [level(before[k], lines[k]), level(after[k], lines[k])],
            })
            .collect();
        all.sort_by(|a, b| b.share.total_cmp(&a.share).then(a.hz[0].total_cmp(&b.hz[0])));
        all.truncate(Thresholds::BANDS_LISTED);
        all
    }

    fn records(&self) -> Vec<RecordShare> {
        let excess = |r: &crate::data_set::RecordData| {
            let rows = r.rows.clone();
            (mean_square(&self.before[rows.clone()]) - 1.0).max(0.0) * rows.len() as f64
        };
        let total: f64 = self.data.records.iter().map(excess).sum();
        self.data
            .records
            .iter()
            .map(|r| {
                let rms = |v: &[f64]| self.sigma * mean_square(&v[r.rows.clone()]).sqrt();
                RecordShare {
                    record: r.name.clone(),
                    share: if total > 0.0 { excess(r) / total } else { 0.0 },
                    rms: [rms(self.before), rms(self.after)],
                }
            })
            .collect()
    }

    /// Coherence of a residual with a signal, the mean of the records by its power.
    fn coherence(&self, residual: &[f64], signal: &[f64]) -> Option<f64> {
        let (mut sum, mut weight) = (0.0, 0.0);
        for record in &self.data.records {
            let rows = record.rows.clone();
            let power = mean_square(&residual[rows.clone()]) * rows.len() as f64;
            if let Some(c) = spectrum::coherence(&residual[rows.clone()], &signal[rows]) {
                sum += power * c;
                weight += power;
            }
        }
        (weight > 0.0).then(|| sum / weight)
    }

    /// Mean square near the ends of the range against the middle.
    fn amplitude(&self, command: &[f64]) -> Option<String> {
        let span = Span::of(command.iter().copied());
        let mean = |is: &dyn Fn(f64) -> bool| {
            let all: Vec<f64> = command
                .iter()
                .zip(self.before)
                .filter(|(u, _)| is(span.unit(**u)))
                .map(|(_, r)| *r)
                .collect();
            (all.len() >= Thresholds::RANGE_ROWS).then(|| (mean_square(&all) - 1.0).max(0.0))
        };
        let (inner, outer) = Thresholds::RANGE_PARTS;
        let (low, middle, high) =
            (mean(&|z| z < -outer)?, mean(&|z| z.abs() < inner)?, mean(&|z| z > outer)?);
        let text = if high > Thresholds::MOSTLY * low.max(middle) {
            "mostly at the upper end of the range"
        } else if low > Thresholds::MOSTLY * high.max(middle) {
            "mostly at the lower end of the range"
        } else if low.min(high) > Thresholds::CLEARLY * middle {
            "at both ends of the range"
        } else if middle > Thresholds::CLEARLY * low.max(high) {
            "in the middle of the range"
        } else {
            "over the whole range"
        };
        Some(text.to_owned())
    }

    /// Mean residual on rising and on falling commands, level by level.
    fn branch(&self, command: &[f64]) -> Option<String> {
        let span = Span::of(command.iter().copied());
        let mut sums = [[(0.0, 0.0); 2]; Thresholds::BRANCH_LEVELS];
        let (mut squares, mut rows) = (0.0, 0.0);
        for record in &self.data.records {
            for k in record.rows.start + 1..record.rows.end {
                let way = command[k] - command[k - 1];
                if way == 0.0 {
                    continue;
                }
                let level = (0.5 * (span.unit(command[k]) + 1.0) * Thresholds::BRANCH_LEVELS as f64)
                    as usize;
                let cell =
                    &mut sums[level.min(Thresholds::BRANCH_LEVELS - 1)][usize::from(way < 0.0)];
                cell.0 += self.before[k];
                cell.1 += 1.0;
                squares += self.before[k].powi(2);
                rows += 1.0;
            }
        }
        let (mut difference, mut half_sum, mut cells) = (0.0, 0.0, 0.0);
        for [up, down] in sums {
            if up.1 < Thresholds::BRANCH_ROWS || down.1 < Thresholds::BRANCH_ROWS {
                continue;
            }
            let (u, d) = (up.0 / up.1, down.0 / down.1);
            difference += (0.5 * (u - d)).powi(2);
            half_sum += (0.5 * (u + d)).powi(2);
            cells += 1.0;
        }
        if cells < Thresholds::BRANCH_FEWEST {
            return None;
        }
        let text = if difference + half_sum < Thresholds::BRANCH_NOTHING * cells {
            "none: the mean over rising and falling commands is below the noise"
        } else if difference > Thresholds::BRANCH_MOSTLY * half_sum {
            "opposite on rising and falling commands: memory or lag"
        } else if half_sum > Thresholds::BRANCH_MOSTLY * difference {
            // The share of the gap's power that a curve over the command holds.
            if half_sum / cells > Thresholds::BRANCH_MAP * (squares / rows - 1.0_f64).max(0.0) {
                "the same on rising and falling commands: a static map"
            } else {
                "the mean gap is the same on rising and falling commands, but explains less than half of the gap"
            }
        } else {
            "different on rising and falling commands"
        };
        Some(text.to_owned())
    }

    fn time(&self) -> Option<String> {
        let (mut early, mut late, mut slow, mut all) = (0.0, 0.0, 0.0, 0.0);
        for record in &self.data.records {
            let r = &self.before[record.rows.clone()];
            let quarter = r.len() / 4;
            if quarter < Thresholds::QUARTER_ROWS {
                continue;
            }
            early += mean_square(&r[..quarter]);
            late += mean_square(&r[r.len() - quarter..]);
            all += mean_square(r);
            slow += mean_square(
                &r.chunks(r.len() / 8)
                    .map(|c| c.iter().sum::<f64>() / c.len() as f64)
                    .collect::<Vec<_>>(),
            );
        }
        if all <= 0.0 {
            return None;
        }
        let text = if slow > Thresholds::SLOW * all {
            "slow: most of it changes over eighths of the record or longer"
        } else if early > Thresholds::MOSTLY * late {
            "mostly at the start of the records"
        } else if late > Thresholds::MOSTLY * early {
            "growing over the records"
        } else {
            "throughout the records"
        };
        Some(text.to_owned())
    }

    /// Whether the command causes a residual: it does where functions of it (its value, square, cube and
    /// direction) are coherent with it, or where the command repeats and the residual with it. That it does
    /// not is seen only where the command repeats and the residual does not; else nobody knows.
    pub(crate) fn is_input_driven(&self, residual: &[f64], command: &[f64]) -> Option<bool> {
        let span = Span::of(command.iter().copied());
        let shapes: [fn(f64, f64) -> f64; 4] = [
            |z, _| z,
            |z, _| z * z,
            |z, _| z * z * z,
            |_, d| {
                if d > 0.0 {
                    1.0
                } else if d < 0.0 {
                    -1.0
                } else {
                    0.0
                }
            },
        ];
        let mut best = None;
        for shape in shapes {
            let mut signal = Vec::with_capacity(command.len());
            let mut direction = 0.0;
            for (k, u) in command.iter().enumerate() {
                let way = if k > 0 { u - command[k - 1] } else { 0.0 };
                if way != 0.0 {
                    direction = way;
                }
                signal.push(shape(span.unit(*u), direction));
            }
            if let Some(c) = self.coherence(residual, &signal) {
                best = Some(f64::max(best.unwrap_or(0.0), c));
            }
        }
        if best.is_some_and(|c| c > Thresholds::COHERENT) {
            return Some(true);
        }
        let rows = self.data.records.iter().map(|r| r.rows.clone());
        let differs = Repeats::of(command, residual, rows)?.sigma()?;
        let part = (differs * differs - 1.0).max(0.0)
            / (mean_square(residual) - 1.0).max(Thresholds::GAP_LEAST);
        match part {
            p if p < Thresholds::DIFFERS.0 => Some(true),
            p if p > Thresholds::DIFFERS.1 => Some(false),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use numerics::random::SplitMix64;

    use super::*;
    use crate::data_set::RecordRows;

    const ROWS: usize = 6000;
    const SEED: u64 = 7;

    /// What is said of a residual in noise of 1 under a command.
    fn driven(command: impl Fn(usize) -> f64, residual: impl Fn(usize) -> f64) -> Option<bool> {
        let mut random = SplitMix64::new(SEED);
        let mut noise = || (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
        let u: Vec<f64> = (0..ROWS).map(command).collect();
        let r: Vec<f64> = (0..ROWS).map(|k| residual(k) + noise()).collect();
        let (command, y) = (u.clone(), r.clone());
        let record = RecordRows { command, y, ..RecordRows::still(ROWS, 1.0) };
        let data = DataSet::new(vec![record], &[], None);
        Maps { data: &data, before: &r, after: &r, sigma: 1.0 }.is_input_driven(&r, &u)
    }

    #[test]
    fn that_it_does_not_follow_is_stated_where_the_command_repeats_and_the_gap_does_not() {
        let phase = |k: usize| (k % 1500) as f64 / 1500.0 * std::f64::consts::TAU;
        let repeats = |k: usize| phase(k).sin();
        let runs_up = |k: usize| (1e-6 * (k * k) as f64).sin();
        // Lines that no function of the command has; the second fits into its period.
        let own = |k: usize| 10.0 * (0.3785 * k as f64).sin();
        let of_it = |k: usize| 10.0 * (37.0 * phase(k)).sin();
        assert_eq!(driven(repeats, own), Some(false), "seed {SEED}");
        assert_eq!(driven(repeats, of_it), Some(true), "seed {SEED}");
        assert_eq!(driven(runs_up, own), None, "seed {SEED}");
    }
}

//! How good a fitted chain is on rows that the fit did not see.

use std::ops::Range;
use std::sync::atomic::AtomicU64;

use crate::chain::{Bench, Chain, Horizon};
use crate::data_set::DataSet;
use crate::discrepancy::{self, Discrepancy};
use crate::error::Failed;
use crate::noise::Shape;
use crate::nuisance::{self, Projector};
use crate::spectrum::{self, Bands};
use crate::thresholds::search::Thresholds;

/// Residuals of one chain on all rows.
#[derive(Clone, Debug)]
pub(crate) struct Judged {
    /// Residual of each row in standard deviations, nuisances taken out.
    pub(crate) residual: Vec<f64>,
    /// Mean square over the held-out rows.
    pub(crate) held_out: f64,
    /// Mean square over the training rows.
    pub(crate) training: f64,
    /// Mean of ln max(P/S, 1.3) over the bands of the held-out stretches.
    pub(crate) log_band: f64,
    /// Mean square of each block.
    pub(crate) blocks: Vec<f64>,
    /// Mean square of each record.
    pub(crate) records: Vec<f64>,
}

/// Where rows are judged: blocks and stretches.
#[derive(Clone, Debug)]
pub(crate) struct Judge {
    /// Blocks of rows.
    pub(crate) blocks: Vec<BlockOfRows>,
    /// Held-out stretch of each record that has one.
    pub(crate) stretches: Vec<Range<usize>>,
    pub(crate) bands: Bands,
    /// Noise of each band, and how far above it the band counts.
    floor: Vec<(f64, f64)>,
    /// Mean of the logarithms of how far.
    margin: f64,
    shape: Shape,
    /// Whether what the model leaves runs a course that nothing causes.
    pub(crate) is_course_own: bool,
}

/// Some rows of one record.
#[derive(Clone, Debug)]
pub(crate) struct BlockOfRows {
    pub(crate) rows: Range<usize>,
    pub(crate) record: usize,
    pub(crate) is_held_out: bool,
}

impl Judge {
    pub(crate) fn new(data: &DataSet, shape: Shape) -> Self {
        let length = (data.time.len() / Thresholds::JUDGED_BLOCKS).max(Thresholds::JUDGED_ROWS);
        let mut blocks = Vec::new();
        let mut stretches = Vec::new();
        for (k, record) in data.records.iter().enumerate() {
            let held_out = DataSet::held_out(record);
            for (part, is_held_out) in [(record.training.clone(), false), (held_out.clone(), true)]
            {
                let count = part.len() / length;
                for b in 0..count.max(usize::from(!part.is_empty())) {
                    let from = part.start + b * length;
                    let to = if b + 1 >= count { part.end } else { from + length };
                    blocks.push(BlockOfRows { rows: from..to, record: k, is_held_out });
                }
            }
            if !held_out.is_empty() {
                stretches.push(held_out);
            }
        }
        let longest = stretches.iter().map(Range::len).max().unwrap_or(0);
        let sample = data.sample_time;
        let bands = Bands::new(longest, sample);
        let floor = bands
            .ends
            .windows(2)
            .map(|ends| {
                // Lines of the longest stretch: with few of them the noise's own power spreads.
                let lines = ((ends[1] - ends[0]) * longest as f64 * sample).max(1.0);
                let margin =
                    Thresholds::BAND_FLOOR.max(1.0 + Thresholds::BAND_SPREAD / lines.sqrt());
                (shape.density(ends[0], ends[1]), margin)
            })
            .collect();
        let mut judge =
            Self { blocks, stretches, bands, floor, margin: 0.0, shape, is_course_own: false };
        judge.margin = judge.level(&vec![0.0; data.time.len()], sample);
        judge
    }

    /// Mean of ln max(P/S, floor) over the bands of the held-out stretches.
    fn level(&self, residual: &[f64], sample: f64) -> f64 {
        let (mut sum, mut terms) = (0.0, 0.0);
        for stretch in &self.stretches {
            let powers = spectrum::band_powers(&residual[stretch.clone()], &self.bands, sample);
            for (power, (floor, margin)) in powers.iter().zip(&self.floor) {
                if power.is_finite() {
                    sum += (power / floor).max(*margin).ln();
                    terms += 1.0;
                }
            }
        }
        if terms > 0.0 { sum / terms } else { 0.0 }
    }

    /// Whether all that is added to the model is a course that nothing causes. Beside another effect a free course would
    /// only make good what that one's formula lacks.
    pub(crate) fn has_own_course(&self, chain: &Chain) -> bool {
        let is_all = chain.parameters.iter().all(|p| p.is_base) && chain.nuisances.len() == 1;
        self.is_course_own && is_all && chain.nuisances[0].is_free_course()
    }

    /// Simulates a chain over all rows.
    pub(crate) fn judge(
        &self,
        chain: &Chain,
        theta: &[f64],
        data: &DataSet,
        sigma: f64,
        count: &AtomicU64,
    ) -> Result<Judged, Failed> {
        let mut bench = Bench::new(chain, data, Horizon::All, count);
        let simulated = bench.keep(theta)?;
        let mut residual = data.residual(simulated);
        if self.has_own_course(chain) {
            nuisance::take_own_course(data, &mut residual);
        } else {
            let values = chain.values(theta);
            Projector::new(&chain.nuisances, values, data, simulated).extend(data, &mut residual);
        }
        residual.iter_mut().for_each(|r| *r /= sigma);
        self.level_off(&mut residual, data);
        Ok(self.figures(residual, data))
    }

    /// Mean square of the noise over the fitted rows that the nuisances of a chain take out with what is
    /// theirs.
    pub(crate) fn taken(&self, chain: &Chain, theta: &[f64], data: &DataSet) -> f64 {
        let values = chain.values(theta);
        let Shape { white, corner } = self.shape;
        let mut sum = 0.0;
        for record in data.records.iter().filter(|r| !r.fit.is_empty()) {
            let rows = record.training.len() as f64;
            // Fewer rows hold as much of slow noise a row.
            let dense = record.fit.len() as f64 / rows;
            let length = rows * data.sample_time;
            let all = chain.nuisances.iter().flat_map(|n| n.frequencies(&values, length));
            sum += all.map(|f| white * (1.0 + dense * corner / f)).sum::<f64>();
        }
        sum / data.fit_rows.len().max(1) as f64
    }

    /// Takes out of the held-out end of a record what its mean may differ from that of the record's
    /// begin by noise that grows as 1/f; an offset that is larger stays with the rest.
    fn level_off(&self, residual: &mut [f64], data: &DataSet) {
        let nyquist = 0.5 / data.sample_time;
        let pink = self.shape.white * self.shape.corner / nyquist;
        let most = Thresholds::SLOW_DEVIATIONS * (Thresholds::SLOW_DIFFERENCE * pink).sqrt();
        for record in data.records.iter().filter(|r| !r.training.is_empty()) {
            let rows = DataSet::held_out(record);
            if rows.is_empty() {
                continue;
            }
            let part = &mut residual[rows];
            let mean = part.iter().sum::<f64>() / part.len() as f64;
            let offset = mean.clamp(-most, most);
            part.iter_mut().for_each(|r| *r -= offset);
        }
    }

    /// The figures of residuals in standard deviations.
    pub(crate) fn figures(&self, residual: Vec<f64>, data: &DataSet) -> Judged {
        let square = |rows: &Range<usize>| mean_square(&residual[rows.clone()]);
        let mean = |held: bool| {
            let (sum, count) = self
                .blocks
                .iter()
                .filter(|b| b.is_held_out == held)
                .fold((0.0, 0.0), |(s, n), b| {
                    (s + square(&b.rows) * b.rows.len() as f64, n + b.rows.len() as f64)
                });
            if count > 0.0 { sum / count } else { f64::NAN }
        };
        let (mut held_out, training) = (mean(true), mean(false));
        if held_out.is_nan() {
            held_out = training;
        }
        let training = if training.is_nan() { held_out } else { training };
        let log_band = self.level(&residual, data.sample_time);
        let blocks = self.blocks.iter().map(|b| square(&b.rows)).collect();
        let records = data.records.iter().map(|r| square(&r.rows)).collect();
        Judged { held_out, training, log_band, blocks, records, residual }
    }

    /// What is left beside the noise.
    pub(crate) fn discrepancy(&self, judged: &Judged, data: &DataSet) -> Discrepancy {
        let records = data.records.iter().map(|r| r.rows.clone());
        discrepancy::of(&judged.residual, records, self.shape, data.sample_time)
    }

    /// Held-out score between the re-tuned model (0) and the noise (1).
    pub(crate) fn score(&self, before: &Judged, after: &Judged) -> f64 {
        0.5 * explained(before, after) + 0.5 * self.explained_bands(before, after)
    }

    /// The part of the logarithmic levels of the bands that goes.
    fn explained_bands(&self, before: &Judged, after: &Judged) -> f64 {
        let gap = before.log_band - self.margin;
        if gap <= 1e-6 { 0.0 } else { (1.0 - (after.log_band - self.margin) / gap).max(-1.0) }
    }

    /// Mean difference of the blocks' logarithmic losses (a worse than b is positive) over its standard
    /// error.
    pub(crate) fn paired(&self, a: &Judged, b: &Judged) -> f64 {
        let loss = |m: f64| m.max(Thresholds::PAIRED_FLOOR).ln();
        let differences: Vec<f64> =
            a.blocks.iter().zip(&b.blocks).map(|(a, b)| loss(*a) - loss(*b)).collect();
        let n = differences.len() as f64;
        if n < Thresholds::PAIRED_BLOCKS {
            return 0.0;
        }
        let mean = differences.iter().sum::<f64>() / n;
        let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
        // Neighbouring blocks are alike: the first lag widens the error.
        let lag: f64 =
            differences.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum::<f64>() / (n - 1.0);
        let rho = (lag / variance.max(f64::MIN_POSITIVE)).clamp(0.0, Thresholds::PAIRED_ALIKE);
        let error = (variance * (1.0 + rho) / (1.0 - rho) / n).sqrt();
        if error > 0.0 { mean / error } else { 0.0 }
    }
}

/// `1 − (after − 1)/(before − 1)` of the mean squares; where nothing is held out to be explained, 0.
pub(crate) fn explained(before: &Judged, after: &Judged) -> f64 {
    let gap = before.held_out - 1.0;
    if gap <= 0.0 { 0.0 } else { (1.0 - (after.held_out - 1.0).max(0.0) / gap).max(-1.0) }
}

/// Mean of squares.
pub(crate) fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data_set::RecordRows;
    use crate::nuisance::Nuisance;

    #[test]
    fn terms_of_a_record_take_more_of_noise_that_is_slow() {
        let record = |rows: usize| RecordRows::still(rows, 1.0);
        let data = DataSet::new(vec![record(1000), record(2000)], &[], None);
        let chain =
            |nuisances| Chain { nodes: Vec::new(), parameters: Vec::new(), drive: 0, nuisances };
        let taken =
            |shape, nuisances| Judge::new(&data, shape).taken(&chain(nuisances), &[], &data);
        let fitted = data.fit_rows.len() as f64;
        assert_eq!(taken(Shape::WHITE, Vec::new()), 0.0);
        let parabola = || vec![Nuisance::Drift { order: 2 }];
        assert!((taken(Shape::WHITE, parabola()) - 4.0 / fitted).abs() < 1e-12);
        // 0.5·(1 + 10/f) for f of 0.68 and 1.18 Hz, and of half of these.
        let wanted = 2.0 + 5.0 * (1.0 / 0.68 + 1.0 / 1.18) * (1.0 + 2.0);
        let pink = Shape { white: 0.5, corner: 10.0 };
        assert!((taken(pink, parabola()) - wanted / fitted).abs() < 1e-12);
    }

    #[test]
    fn the_end_of_a_record_may_be_off_by_as_much_as_slow_noise_is_and_no_more() {
        let rows = 1000;
        let data = DataSet::new(vec![RecordRows::still(rows, 0.7)], &[], None);
        let level_off = |shape: Shape, offset: f64| {
            let judge = Judge::new(&data, shape);
            let mut residual = vec![offset; rows];
            judge.level_off(&mut residual, &data);
            (residual[0], residual[rows - 1])
        };
        let pink = Shape { white: 0.7, corner: 50.0 };
        // √(2.9·0.7·50/500) = 0.45 of the noise is one standard deviation of the offset.
        let most = 2.0 * (2.9_f64 * 0.7 * 50.0 / 500.0).sqrt();
        assert_eq!(level_off(pink, 0.5), (0.5, 0.0));
        let (begin, end) = level_off(pink, -3.0);
        assert_eq!(begin, -3.0);
        assert!((end + 3.0 - most).abs() < 1e-12, "{end}");
        // White noise has no slow part.
        assert_eq!(level_off(Shape::WHITE, 0.5), (0.5, 0.5));
    }
}

//! How much of the gap goes, with a prediction interval for a new record.

use numerics::random::SplitMix64;

use crate::data_set::DataSet;
use crate::gap::{HeldOut, Shrink};
use crate::score::{Judge, Judged, mean_square};
use crate::thresholds::answer::Thresholds;

/// What the figures are made from.
pub(crate) struct Evidence<'a> {
    pub(crate) data: &'a DataSet,
    pub(crate) judge: &'a Judge,
    pub(crate) given: &'a Judged,
    pub(crate) before: &'a Judged,
    pub(crate) after: &'a Judged,
    /// Standard deviation of the noise in the output's unit.
    pub(crate) sigma: f64,
    pub(crate) unit: &'a str,
    /// Range of the measured output in its unit.
    pub(crate) range: f64,
    pub(crate) seed: u64,
    /// Draws of the part of the gap's power that is left on new records.
    pub(crate) on_new_records: &'a [f64],
}

/// Fraction of the gap's power that goes, from mean squares over the noise's.
pub(crate) fn fraction(before: f64, after: f64) -> Option<f64> {
    let gap = before - 1.0;
    (gap > Thresholds::GAP_LEAST).then(|| (1.0 - (after - 1.0).max(0.0) / gap).clamp(-1.0, 1.0))
}

impl Evidence<'_> {
    pub(crate) fn shrink(&self, has_effects: bool) -> Shrink {
        let root = |m: f64| self.sigma * m.max(0.0).sqrt();
        let total = if has_effects {
            fraction(self.before.held_out, self.after.held_out)
        } else {
            fraction(self.before.held_out, 1.0).map(|_| 0.0)
        };
        Shrink {
            unit: self.unit.to_owned(),
            rms_before: root(self.before.held_out),
            rms_after: root(self.after.held_out),
            noise_floor: self.sigma,
            fraction: total,
            ci95: total.filter(|_| has_effects).map(|f| self.interval(f)),
            rms_as_given: root(self.given.held_out),
            relative_gap: root(self.given.held_out) / self.range.max(f64::MIN_POSITIVE),
            holdout: self.stretches(),
            second_opinion: None,
            as_found: None,
            offset: None,
            rms_as_it_stands: None,
            own_course: None,
        }
    }

    fn stretches(&self) -> Vec<HeldOut> {
        let held = |r: &&crate::data_set::RecordData| !DataSet::held_out(r).is_empty();
        self.data
            .records
            .iter()
            .filter(held)
            .map(|record| {
                let rows = DataSet::held_out(record);
                let before = mean_square(&self.before.residual[rows.clone()]);
                let after = mean_square(&self.after.residual[rows.clone()]);
                HeldOut {
                    record: record.name.clone(),
                    rows: [rows.start + 1, rows.end]
                        .map(|k| k + record.run_in.len() - record.rows.start),
                    rms_before: self.sigma * before.sqrt(),
                    rms_after: self.sigma * after.sqrt(),
                    fraction: fraction(before, after),
                }
            })
            .collect()
    }

    /// 95 % prediction interval: each draw takes one record and resamples its blocks; with few records
    /// the spread between them is widened by Student's factor.
    fn interval(&self, total: f64) -> [f64; 2] {
        let mut groups: Vec<Vec<(f64, f64)>> = vec![Vec::new(); self.data.records.len()];
        for ((block, before), after) in
            self.judge.blocks.iter().zip(&self.before.blocks).zip(&self.after.blocks)
        {
            if block.is_held_out {
                groups[block.record].push((*before, *after));
            }
        }
        groups.retain(|g| !g.is_empty());
        if groups.is_empty() {
            return [-1.0, 1.0];
        }
        let mut random = SplitMix64::new(self.seed);
        let mut draws: Vec<f64> = Vec::with_capacity(Thresholds::BOOTSTRAP_DRAWS);
        for _ in 0..Thresholds::BOOTSTRAP_DRAWS {
            let group = &groups[random.below(groups.len())];
            let (mut before, mut after) = (0.0, 0.0);
            for _ in 0..group.len() {
                let (b, a) = group[random.below(group.len())];
                before += b;
                after += a;
            }
            let n = group.len() as f64;
            draws.extend(fraction(before / n, after / n));
        }
        let Some([low, high]) = middle(draws) else { return [-1.0, 1.0] };
        let most = Thresholds::STUDENT.len();
        let widen = Thresholds::STUDENT[groups.len().min(most) - 1];
        // The noise's own spread of a new record's mean square, and what its variance may be off.
        let noise =
            Thresholds::NOISE_SPREAD / (self.before.held_out - 1.0).max(Thresholds::GAP_LEAST);
        let least = Thresholds::INTERVAL_LEAST;
        let low = total - widen * (total - low).max(0.0) - noise - least;
        let high = total + widen * (high - total).max(0.0) + noise + least;
        // What is left over what was is another ratio in a record of another level, and with a model
        // that was re-tuned to other records.
        let left = |spread: f64| 1.0 - (1.0 - total) * (1.96 * spread).exp();
        let (low, high) =
            (low.min(left(Thresholds::RATIO_SPREAD)), high.max(left(-Thresholds::RATIO_SPREAD)));
        let [least, most] = self.of_new_records(total).unwrap_or([low, high]);
        [low.max(-1.0).min(least), high.max(most).min(1.0)]
    }

    /// 95 % prediction interval by draws of new records, which leave what the formula leaves anyway, too.
    fn of_new_records(&self, total: f64) -> Option<[f64; 2]> {
        let mut random = SplitMix64::new(self.seed);
        let part = |left: &f64| {
            let spread = (Thresholds::RATIO_SPREAD * random.normal()).exp();
            1.0 - (left + 1.0 - total) * spread
        };
        middle(self.on_new_records.iter().map(part).collect())
    }
}

/// The ends between which 95 % of the draws lie; `None` without any.
fn middle(mut draws: Vec<f64>) -> Option<[f64; 2]> {
    draws.sort_by(f64::total_cmp);
    let last = draws.len().checked_sub(1)? as f64;
    Some([0.025, 0.975].map(|q| draws[(last * q).round() as usize]))
}

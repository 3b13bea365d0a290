//! Readings that are noisier than stated: what is left is white, the same in every record and normally
//! distributed.

use crate::data_set::DataSet;
use crate::noise;
use crate::score::mean_square;
use crate::thresholds::noise::Thresholds;

/// Standard deviation of the noise over the one that was stated, where residuals (in standard
/// deviations) are noise and nothing else.
pub(crate) fn ratio(residual: &[f64], data: &DataSet) -> Option<f64> {
    let records = || {
        data.records.iter().map(|r| r.rows.clone()).filter(|r| r.len() >= Thresholds::WHITE_ROWS)
    };
    let level = noise::fourth_differences(residual, records())?;
    let white = level * level;
    // Less than was stated is not noisier.
    if white <= 1.0 {
        return None;
    }
    let is_noise = records().all(|rows| {
        let n = rows.len() as f64;
        let part = &residual[rows.clone()];
        let Some(own) = noise::fourth_differences(residual, std::iter::once(rows)) else {
            return false;
        };
        let mean = part.iter().sum::<f64>() / n;
        let variance = mean_square(part) - mean * mean;
        // Neighbouring fourth differences are alike: a tenth of the rows says something.
        let spread = Thresholds::WHITE_LEVELS_ALIKE + 3.0 / (0.2 * n).sqrt();
        let beside = variance - white;
        (own / level - 1.0).abs() < spread
            && beside > -2.0 * spread * white
            && beside
                < Thresholds::COLOUR_LEFT.0
                    + (Thresholds::COLOUR_LEFT.1 + 3.0 / (0.5 * n).sqrt()) * white
    });
    let (mut squares, mut fourth, mut count) = (0.0, 0.0, 0.0);
    for rows in records() {
        let part = &residual[rows];
        let mean = part.iter().sum::<f64>() / part.len() as f64;
        for r in part {
            squares += (r - mean).powi(2);
            fourth += (r - mean).powi(4);
            count += 1.0;
        }
    }
    let tails = fourth * count / (squares * squares).max(f64::MIN_POSITIVE);
    (count > 0.0 && is_noise && (tails - 3.0).abs() < Thresholds::FOURTH_MOMENT).then_some(level)
}

#[cfg(test)]
mod tests {
    use numerics::random::SplitMix64;

    use super::ratio;
    use crate::data_set::{DataSet, RecordRows};

    #[test]
    fn readings_are_noisier_where_their_white_part_is_more_than_what_was_stated() {
        let rows = 4000;
        let data = DataSet::new(vec![RecordRows::still(rows, 0.7)], &[], None);
        let mut random = SplitMix64::new(7);
        let white: Vec<f64> =
            (0..rows).map(|_| (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0).collect();
        let of = |size: f64, slow: f64| {
            let part = |(k, r): (usize, &f64)| size * r + slow * (k as f64 / 300.0).sin();
            ratio(&white.iter().enumerate().map(part).collect::<Vec<f64>>(), &data)
        };
        assert!((of(1.4, 0.0).unwrap() - 1.4).abs() < 0.1);
        // Less than was stated, and a slow rest: that is no noise that was stated too small.
        assert_eq!(of(0.9, 0.9), None);
    }
}

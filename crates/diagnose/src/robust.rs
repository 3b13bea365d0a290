//! The residual of a model that is re-tuned robustly, for the maps of where a gap lies.
//!
//! Least squares bends the model's parameters towards what is missing and smears the gap over records
//! that have none. Here blocks of 50 ms count the less the more is left in them: Cauchy's weights
//! `1/(1 + m/c²)` of a block's mean square m, in rounds.

use crate::candidate::Candidate;
use crate::data_set::DataSet;
use crate::fit::Fitter;
use crate::score::{Judge, mean_square};
use crate::thresholds::fit::Thresholds;

/// Residual of each row in standard deviations; none where a fit fails.
pub(crate) fn residual(fitter: Fitter<'_>, judge: &Judge, base: &Candidate) -> Option<Vec<f64>> {
    let data = fitter.data;
    let mut theta = base.fit.theta.clone();
    let mut residual = base.judged.residual.clone();
    for _ in 0..Thresholds::ROBUST_ROUNDS {
        let weights = weights(data, &residual);
        let weighted = Fitter { weights: Some(&weights), ..fitter };
        theta = weighted.fit_again(&base.chain, &theta).ok()?.theta;
        let judged = judge.judge(&base.chain, &theta, data, fitter.sigma, fitter.count).ok()?;
        residual = judged.residual;
    }
    Some(residual)
}

/// Square roots of the weights of the rows of the fit.
fn weights(data: &DataSet, residual: &[f64]) -> Vec<f64> {
    let length = ((Thresholds::ROBUST_BLOCK / data.sample_time).round() as usize)
        .max(Thresholds::ROBUST_ROWS);
    let mut weights = vec![1.0; data.fit_rows.len()];
    for record in &data.records {
        for (weight, row) in
            weights[record.fit.clone()].iter_mut().zip(&data.fit_rows[record.fit.clone()])
        {
            let block = (*row as usize - record.rows.start) / length;
            let start = record.rows.start + block * length;
            let end = (start + length).min(record.rows.end);
            *weight =
                (1.0 / (1.0 + mean_square(&residual[start..end]) / Thresholds::ROBUST_HALF)).sqrt();
        }
    }
    weights
}

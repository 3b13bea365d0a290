//! The offset that all records share, and what a model leaves of logs as they stand.
//!
//! Each record may have an offset of its own, which is taken out before anything is judged. What the offsets have
//! in common foretells the next record's and belongs to the repaired model.

use std::sync::atomic::AtomicU64;

use crate::candidate::Candidate;
use crate::chain::{Bench, Chain, Horizon};
use crate::data_set::DataSet;
use crate::nuisance::Projector;
use crate::score::mean_square;
use crate::task::Task;
use crate::thresholds::repair::Thresholds;

/// Offsets of the records under a model, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Offset {
    /// What they share, to be added to the model's output; 0 where they share none.
    pub(crate) shared: f64,
    /// Root mean square of the held-out rows as they stand: under the model as it came, and under the one with the
    /// effects and the shared offset.
    pub(crate) as_it_stands: (f64, f64),
}

/// Offsets of the records under the model with its effects, and what is left without taking them out.
pub(crate) fn of(
    task: &Task,
    (base, last): (&Candidate, &Candidate),
    sigma: f64,
    count: &AtomicU64,
) -> Option<Offset> {
    let data = &task.data;
    let given = vec![0.0; base.chain.parameters.len()];
    let before = residual(data, &base.chain, &given, count)?;
    let mut after = residual(data, &last.chain, &last.fit.theta, count)?;
    let shared = shared(&offsets(data, (&last.chain, &last.fit.theta), &after), sigma);
    after.iter_mut().for_each(|r| *r -= shared);
    Some(Offset { shared, as_it_stands: (held_out(data, &before), held_out(data, &after)) })
}

/// The offset that all fitted records share under a chain at these coordinates.
pub(crate) fn left(
    data: &DataSet,
    (chain, theta): (&Chain, &[f64]),
    sigma: f64,
    count: &AtomicU64,
) -> Option<f64> {
    let residual = residual(data, chain, theta, count)?;
    Some(shared(&offsets(data, (chain, theta), &residual), sigma))
}

fn residual(data: &DataSet, chain: &Chain, theta: &[f64], count: &AtomicU64) -> Option<Vec<f64>> {
    let mut bench = Bench::new(chain, data, Horizon::All, count);
    Some(data.residual(bench.keep(theta).ok()?))
}

/// The offset of each record that is fitted, from its fitted rows.
fn offsets(data: &DataSet, (chain, theta): (&Chain, &[f64]), residual: &[f64]) -> Vec<f64> {
    let values = chain.values(theta);
    let simulated = Vec::new();
    // What swings with the simulated output has no mean of its own.
    let nuisances: Vec<_> =
        chain.nuisances.iter().filter(|n| !n.is_of_simulation()).cloned().collect();
    Projector::new(&nuisances, values, data, &simulated).offsets(data, residual)
}

/// What offsets share: their mean, where it is more than they differ by chance.
fn shared(offsets: &[f64], sigma: f64) -> f64 {
    let n = offsets.len() as f64;
    if offsets.is_empty() {
        return 0.0;
    }
    let mean = offsets.iter().sum::<f64>() / n;
    let squares: f64 = offsets.iter().map(|o| (o - mean).powi(2)).sum();
    let error = if offsets.len() > 1 { (squares / (n - 1.0) / n).sqrt() } else { 0.0 };
    if mean.abs() > (Thresholds::OFFSET_SHARED * error).max(Thresholds::OFFSET_LEAST * sigma) {
        mean
    } else {
        0.0
    }
}

/// Root mean square over the rows that are held out, or over all where none is.
fn held_out(data: &DataSet, residual: &[f64]) -> f64 {
    let rows = data.records.iter().map(DataSet::held_out);
    let mut all: Vec<f64> = rows.flat_map(|rows| residual[rows].to_vec()).collect();
    if all.is_empty() {
        all = residual.to_vec();
    }
    mean_square(&all).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_share_their_mean_where_they_differ_by_less() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a}, not {b}");
        close(shared(&[1.0, 1.1, 0.9], 0.01), 1.0);
        close(shared(&[1.0, -1.1, 0.4], 0.01), 0.0);
        close(shared(&[0.02, 0.021, 0.019], 1.0), 0.0);
        close(shared(&[0.7], 1.0), 0.7);
        close(shared(&[], 1.0), 0.0);
    }
}

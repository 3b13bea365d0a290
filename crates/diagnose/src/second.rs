//! A second opinion: records are left out of the fit one after the other.

use rayon::prelude::*;

use crate::candidate::Candidate;
use crate::chain::Chain;
use crate::data_set::DataSet;
use crate::fit::Fitter;
use crate::gap::{HeldOut, SecondOpinion};
use crate::score::{Judge, mean_square};
use crate::shrink::fraction;
use crate::thresholds::answer::Thresholds;

/// What the effects take away in records that were left out, where there are enough of them; `unit` is
/// a standard deviation of the noise in the output's unit, `first` the fraction of the first opinion.
pub(crate) fn of(
    fitter: Fitter<'_>,
    judge: &Judge,
    (base, last): (&Candidate, &Candidate),
    unit: f64,
    first: Option<f64>,
) -> Option<SecondOpinion> {
    let data = fitter.data;
    let count = data.records.len();
    if count < Thresholds::SECOND_RECORDS || last.picks.is_empty() {
        return None;
    }
    let folds = count.min(Thresholds::SECOND_FITS);
    let judged: Vec<(usize, f64, f64)> = (0..folds)
        .into_par_iter()
        .with_max_len(1)
        .filter_map(|fold| left_out(fitter, judge, (base, last), (fold, folds)))
        .flatten()
        .collect();
    let rows = |k: usize| data.records[k].rows.len() as f64;
    let total = |of: &dyn Fn(&(usize, f64, f64)) -> f64| {
        judged.iter().map(|j| of(j) * rows(j.0)).sum::<f64>()
            / judged.iter().map(|j| rows(j.0)).sum::<f64>()
    };
    let (before, after) = (total(&|j| j.1), total(&|j| j.2));
    let fraction_of_all = fraction(before, after)?;
    let mut records: Vec<HeldOut> = judged
        .iter()
        .map(|(k, before, after)| HeldOut {
            record: data.records[*k].name.clone(),
            rows: [1, data.records[*k].rows.len()],
            rms_before: unit * before.sqrt(),
            rms_after: unit * after.sqrt(),
            fraction: fraction(*before, *after),
        })
        .collect();
    records.sort_by(|a, b| a.record.cmp(&b.record));
    let agrees = first.is_none_or(|first| fraction_of_all >= Thresholds::SECOND_AGREES * first);
    let split = if folds == count {
        "each record in turn is left out of the fit and judged".to_owned()
    } else {
        format!("each {folds}th record is left out of the fit and judged, in {folds} turns")
    };
    Some(SecondOpinion { split, fraction: fraction_of_all, agrees, records })
}

/// Mean squares before and after of the records of a fold, which are not in the fit.
fn left_out(
    fitter: Fitter<'_>,
    judge: &Judge,
    (base, last): (&Candidate, &Candidate),
    (fold, folds): (usize, usize),
) -> Option<Vec<(usize, f64, f64)>> {
    let data = fitter.data.without(|k| k % folds == fold);
    let residual = |chain: &Chain, start: &[f64]| -> Option<Vec<f64>> {
        let theta = Fitter { data: &data, ..fitter }.fit_again(chain, start).ok()?.theta;
        let judged = judge.judge(chain, &theta, &data, fitter.sigma, fitter.count).ok()?;
        Some(judged.residual)
    };
    let before = residual(&base.chain, &base.fit.theta)?;
    let after = residual(&last.chain, &last.fit.theta)?;
    let own = (0..data.records.len()).filter(|k| k % folds == fold);
    let mean = |r: &[f64], data: &DataSet, k: usize| mean_square(&r[data.records[k].rows.clone()]);
    Some(own.map(|k| (k, mean(&before, &data, k), mean(&after, &data, k))).collect())
}

//! Whether what is left runs a course of its own, which the command does not cause.
//!
//! A regression of the slow part of a residual on causal functions of the command explains much of any slow course,
//! as both have few degrees of freedom. What a cause explains in addition is seen by exchanging the commands between
//! the records:
//!
//! ```text
//! D = Σ_i P_i·(R²(r_i | u_i) − mean_{j≠i} R²(r_i | u_j))/Σ_i P_i
//! ```
//!
//! for records i of power P_i. Without a cause the mean of D is zero, whatever the course is.
//! The functions are powers, low-passes, plays and heating by the command and by each auxiliary signal; those of u_j are
//! taken at the same part of the record. A course that returns in the records is none of its own.
//!
//! Limits: a response to the command that is so slow that smooth functions of any command explain it nearly as well counts as
//! a course of its own (creep over a sixth of the record, of a cube: in nine of ten logs).
//!
//! Source of the idea: permutation tests, R. A. Fisher, The Design of Experiments, 1935.

use std::ops::Range;
use std::sync::atomic::AtomicU64;

use components::hysteresis::play::{Drive, Threshold, play};
use nalgebra::{DMatrix, DVector};

use crate::candidate::Candidate;
use crate::chain::Chain;
use crate::data_set::{DataSet, RecordData};
use crate::score::{Judge, Judged};
use crate::thresholds::base::Thresholds;

/// The slow part of a residual and the functions of the command, by blocks, without their means.
struct Slow {
    residual: DVector<f64>,
    functions: DMatrix<f64>,
}

/// Whether the residual runs such a course. With less than four records nobody knows, and it is taken as caused.
pub(crate) fn is_own(data: &DataSet, residual: &[f64]) -> bool {
    let rows = |r: &&RecordData| r.rows.len() >= 4 * Thresholds::COURSE_BLOCKS;
    let records: Vec<Slow> = data
        .records
        .iter()
        .filter(rows)
        .map(|record| Slow {
            residual: means(residual[record.rows.clone()].iter().copied()),
            functions: functions(data, record.rows.clone()),
        })
        .collect();
    let n = records.len();
    if n < Thresholds::COURSE_RECORDS {
        return false;
    }
    let (mut gain, mut repeats, mut power) = (0.0, 0.0, 0.0);
    for (i, own) in records.iter().enumerate() {
        let square = own.residual.norm_squared();
        let others = records.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, r)| r);
        let by_others: f64 = others.clone().map(|r| part(&r.functions, &own.residual)).sum();
        let common: DVector<f64> = others.map(|r| &r.residual).sum();
        // One that runs the other way speaks against a return.
        let sign = common.dot(&own.residual).signum();
        let common = DMatrix::from_columns(&[common]);
        gain += square * (part(&own.functions, &own.residual) - by_others / (n - 1) as f64);
        repeats += square * sign * part(&common, &own.residual);
        power += square;
    }
    gain < Thresholds::COURSE_CAUSED * power && repeats < Thresholds::COURSE_REPEATS * power
}

/// A candidate judged without a course of its own, which no model predicts; none where it has none.
pub(crate) fn left_out(
    candidate: &Candidate,
    judge: &Judge,
    data: &DataSet,
    sigma: f64,
    count: &AtomicU64,
) -> Option<Judged> {
    if !judge.has_own_course(&candidate.chain) {
        return None;
    }
    let chain = Chain { nuisances: Vec::new(), ..candidate.chain.clone() };
    judge.judge(&chain, &candidate.fit.theta, data, sigma, count).ok()
}

/// Part of a signal's power that functions explain.
fn part(functions: &DMatrix<f64>, signal: &DVector<f64>) -> f64 {
    let mut normal = functions.tr_mul(functions);
    let ridge = Thresholds::COURSE_RIDGE * normal.diagonal().max().max(f64::MIN_POSITIVE);
    for k in 0..normal.nrows() {
        normal[(k, k)] += ridge;
    }
    let Some(factor) = normal.cholesky() else { return 0.0 };
    let rest = signal - functions * factor.solve(&functions.tr_mul(signal));
    1.0 - rest.norm_squared() / signal.norm_squared().max(f64::MIN_POSITIVE)
}

/// Means over blocks, about the mean of all.
fn means(values: impl ExactSizeIterator<Item = f64>) -> DVector<f64> {
    const BLOCKS: usize = Thresholds::COURSE_BLOCKS;
    let rows = values.len();
    let (mut sums, mut counts) = ([0.0; BLOCKS], [0.0; BLOCKS]);
    for (k, value) in values.enumerate() {
        sums[k * BLOCKS / rows] += value;
        counts[k * BLOCKS / rows] += 1.0;
    }
    let all = DVector::from_iterator(BLOCKS, sums.iter().zip(counts).map(|(s, n)| s / n));
    let mean = all.mean();
    all.add_scalar(-mean)
}

/// Functions of the command and of the auxiliary signals over a record, each of length one.
fn functions(data: &DataSet, rows: Range<usize>) -> DMatrix<f64> {
    let hits: Vec<usize> = data.row_hit[rows].iter().map(|hit| *hit as usize).collect();
    let of = |values: &[f64], middle: f64, half: f64| -> Vec<f64> {
        hits.iter().map(|hit| (values[*hit] - middle) / half.max(f64::MIN_POSITIVE)).collect()
    };
    let mut inputs = vec![of(&data.command, data.command_span.centre, data.command_span.half)];
    for aux in &data.aux {
        inputs.push(of(&aux.hits, aux.span.centre, aux.span.half));
    }
    let mut columns = Vec::new();
    for u in &inputs {
        let count = u.len() as f64;
        let rate = |k: usize| if k > 0 { u[k] - u[k - 1] } else { 0.0 };
        let scale = (0..u.len()).map(|k| rate(k).powi(2)).sum::<f64>().sqrt() / count.sqrt();
        let heat: Vec<f64> =
            (0..u.len()).map(|k| (rate(k) / scale.max(f64::MIN_POSITIVE)).powi(2)).collect();
        let square: Vec<f64> = u.iter().map(|u| u * u).collect();
        for values in [u, &square] {
            columns.push(means(values.iter().copied()));
        }
        columns.push(means(u.iter().map(|u| u.powi(3))));
        columns.push(means((0..u.len()).map(|k| rate(k).abs())));
        for time in Thresholds::COURSE_LOW_PASSES {
            for values in [u, &square, &heat] {
                let mut y = values[0];
                columns.push(means(values.iter().map(|x| {
                    y += (x - y) / (time * count).max(1.0);
                    y
                })));
            }
        }
        for half in Thresholds::COURSE_PLAYS {
            let mut last = u[0];
            columns.push(means(u.iter().map(|x| {
                last = play(Drive(*x), Threshold(half), last);
                last
            })));
        }
    }
    for column in &mut columns {
        let length = column.norm();
        if length > 0.0 {
            *column /= length;
        }
    }
    DMatrix::from_columns(&columns)
}

#[cfg(test)]
mod tests {
    use numerics::random::SplitMix64;

    use super::*;
    use crate::data_set::RecordRows;

    const SEEDS: std::ops::Range<u64> = 0..20;
    const ROWS: usize = 4000;
    const RECORDS: usize = 8;

    /// In how many of the seeds what this makes of a command, record and row is a course of its own, in noise of 1.
    fn own_of(mut course: impl FnMut(&[f64], usize, &mut SplitMix64) -> Vec<f64>) -> usize {
        SEEDS.filter(|seed| is_own_of(*seed, &mut course)).count()
    }

    fn is_own_of(
        seed: u64,
        course: &mut impl FnMut(&[f64], usize, &mut SplitMix64) -> Vec<f64>,
    ) -> bool {
        let mut random = SplitMix64::new(seed);
        let mut residual = Vec::new();
        let records = (0..RECORDS).map(|record| {
            let (rate, phase) = (1e-3 * (1.0 + record as f64), random.uniform());
            let u: Vec<f64> = (0..ROWS)
                .map(|k| (rate * k as f64 + phase).sin() + (0.37 * rate * k as f64).cos())
                .collect();
            residual.extend(course(&u, record, &mut random).iter().map(|r| r + random.normal()));
            RecordRows {
                name: record.to_string(),
                y: u.clone(),
                command: u,
                ..RecordRows::still(ROWS, 0.7)
            }
        });
        let data = DataSet::new(records.collect(), &[], None);
        is_own(&data, &residual)
    }

    #[test]
    fn walks_are_of_their_own_and_what_the_command_causes_is_not() {
        let walk = |_: &[f64], _: usize, random: &mut SplitMix64| {
            let mut at = 0.0;
            let mut step = || {
                at += 0.3 * random.normal();
                at
            };
            (0..ROWS).map(|_| step()).collect::<Vec<_>>()
        };
        // Two of 20 may be off: a walk may go along with the commands by chance.
        assert!(own_of(walk) >= 18, "{} of 20 walks", own_of(walk));
        let plays = |u: &[f64], _: usize, _: &mut SplitMix64| {
            let mut last = u[0];
            let mut follow = |u: &f64| {
                last = play(Drive(*u), Threshold(0.5), last);
                10.0 * (u - last)
            };
            u.iter().map(&mut follow).collect::<Vec<_>>()
        };
        assert!(own_of(plays) <= 2, "{} of 20 plays", own_of(plays));
        // The same in each record: what starts with the record.
        let settling = |_: &[f64], record: usize, _: &mut SplitMix64| {
            let size = 10.0 + record as f64;
            (0..ROWS).map(|k| size * (-(k as f64) / 1500.0).exp()).collect::<Vec<_>>()
        };
        assert_eq!(own_of(settling), 0);
    }
}

//! The mode through which the output of an FMU leaves, from its answer to a small step.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};
use surround::{Block, Signals, Span};

use crate::thresholds::base::Thresholds;

/// A small step up from the middle of the command.
pub(super) fn small_step(rows: usize, command: Span) -> Vec<f64> {
    let size = Thresholds::ENTRY_SIZE * command.half;
    let step = |row| if row < Thresholds::ENTRY_BEFORE { 0.0 } else { size };
    (0..rows).map(|row| command.centre + step(row)).collect()
}

/// The mode through which an output leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry {
    /// Natural frequency in Hz.
    pub(crate) frequency: f64,
    /// Damping ratio.
    pub(crate) damping: f64,
    /// What a lag before it keeps of its value from row to row; 0: there is none.
    pub(crate) lag: f64,
}

/// The mode that a response leaves through, if nothing else moves
/// there but at most one lag: the input is held from row `step` on, and differences of rows then follow
/// `d_n = Σ a_k·d_(n−k)`, with the two poles of the mode, and the lag's.
pub(super) fn ringing(response: &[f64], step: usize, sample: f64) -> Option<Entry> {
    let d: Vec<f64> = response.windows(2).map(|w| w[1] - w[0]).collect();
    // From the difference of the first two rows after the step.
    let d = d.get(step + 1..)?;
    let (poles, lag) = match recursion(d, 2).as_deref() {
        Some(&[a1, a2]) => ((a1, a2), 0.0),
        _ => {
            let &[a1, a2, a3] = recursion(d, 3)?.as_slice() else { return None };
            let lag = real_pole([a1, a2, a3])?;
            // z³ − a₁z² − a₂z − a₃ = (z − p)·(z² − (a₁ − p)·z + a₃/p)
            ((a1 - lag, -a3 / lag), lag)
        }
    };
    // Poles r·exp(±jφ) with r² = −a₂, 2r·cos φ = a₁.
    let r = (-poles.1).sqrt();
    let angle = (0.5 * poles.0 / r).acos();
    let (decay, turn) = (-r.ln() / sample, angle / sample);
    let omega = decay.hypot(turn);
    let (frequency, damping) = (omega / TAU, decay / omega);
    if !(damping > 0.0 && damping < 1.0 && angle < 0.9 * PI) {
        return None;
    }
    // What enters the mode is a step then.
    let mut entered = vec![0.0; response.len()];
    let before = Block::BeforeMode { frequency, damping }.prepare(&[], sample).ok()?;
    before.run(Signals::path(response), &mut entered);
    let (first, last) = (*entered.first()?, *entered.last()?);
    let held = entered.get(step + 1..)?;
    let mut left = held.first()? - last;
    let off = held.iter().map(|x| {
        let off = x - last - left;
        left *= lag;
        off * off
    });
    let off = (off.sum::<f64>() / held.len() as f64).sqrt();
    (off < Thresholds::ENTRY_ROUGH * (last - first).abs()).then_some(Entry {
        frequency,
        damping,
        lag,
    })
}

/// The recursion that a signal follows, by least squares; none where it leaves something or the signal
/// is too simple to tell.
fn recursion(d: &[f64], order: usize) -> Option<Vec<f64>> {
    let (mut normal, mut right) = (DMatrix::zeros(order, order), DVector::zeros(order));
    let rows = || {
        d.windows(order + 1).map(|w| (w[order], DVector::from_fn(order, |k, _| w[order - 1 - k])))
    };
    for (now, past) in rows() {
        normal += &past * past.transpose();
        right += past * now;
    }
    let values = normal.symmetric_eigenvalues();
    if !(values.max() > 0.0 && values.min() > 1e-13 * values.max()) {
        return None;
    }
    let a = normal.cholesky()?.solve(&right);
    let left: f64 = rows().map(|(now, past)| (now - a.dot(&past)).powi(2)).sum();
    let all: f64 = d.iter().skip(order).map(|d| d * d).sum();
    (left <= Thresholds::MODE_OTHER * Thresholds::MODE_OTHER * all)
        .then(|| a.iter().copied().collect())
}

/// A pole of `z³ = a₁z² + a₂z + a₃` between 0 and 1.
fn real_pole([a1, a2, a3]: [f64; 3]) -> Option<f64> {
    let p = |z: f64| ((z - a1) * z - a2) * z - a3;
    let (mut low, mut high) = (0.0, 1.0);
    if !(p(low) < 0.0 && p(high) > 0.0) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if p(middle) < 0.0 { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high)).filter(|pole| *pole > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE: f64 = 2.5e-4;

    /// A step at row 50 through these blocks, whose parameters stand beside them.
    fn answer(blocks: &[(Block, &[f64])]) -> Vec<f64> {
        let mut x: Vec<f64> = (0..3000).map(|row| if row < 50 { 2.0 } else { 2.5 }).collect();
        for (block, p) in blocks {
            let mut out = vec![0.0; x.len()];
            block.prepare(p, SAMPLE).unwrap().run(Signals::path(&x), &mut out);
            x = out;
        }
        x
    }

    #[test]
    fn the_mode_at_the_end_is_read_from_the_answer_to_a_step() {
        for (frequency, damping) in [(284.0, 0.04), (60.0, 0.3), (900.0, 0.01)] {
            let mode = (Block::SecondOrder, &[frequency, damping][..]);
            let lag = (Block::Lag { order: 1 }, &[500.0][..]);
            let gain = (Block::Gain, &[0.3][..]);
            for blocks in [vec![gain.clone(), mode.clone()], vec![lag, gain, mode]] {
                let Entry { frequency: f, damping: d, .. } =
                    ringing(&answer(&blocks), 50, SAMPLE).unwrap();
                assert!((f / frequency - 1.0).abs() < 1e-5, "{blocks:?}: {f}");
                assert!((d / damping - 1.0).abs() < 1e-4, "{blocks:?}: {d}");
            }
        }
    }

    #[test]
    fn what_is_no_single_mode_is_none() {
        let none = |blocks: &[(Block, &[f64])]| ringing(&answer(blocks), 50, SAMPLE).is_none();
        assert!(none(&[]), "nothing moves");
        assert!(none(&[(Block::Lag { order: 1 }, &[100.0])]), "a lag");
        assert!(none(&[(Block::ParallelMode, &[0.3, 284.0, 0.04])]), "a mode beside the path");
        assert!(
            none(&[(Block::SecondOrder, &[100.0, 0.1]), (Block::SecondOrder, &[284.0, 0.04])]),
            "two modes"
        );
    }
}

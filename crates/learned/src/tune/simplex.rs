//! The simplex of Nelder and Mead.
//!
//! Reference: J. Nelder, R. Mead, A simplex method for function minimization, Comput. J. 7 (1965).

use super::{Best, Counted, Watch, clamp};

/// Start and end of a simplex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simplex {
    /// First edge, as a part of the box.
    pub edge: f64,
    /// Most evaluations.
    pub evaluations: usize,
    /// It ends where the values differ less than this, relatively.
    pub tolerance: f64,
}

impl Default for Simplex {
    fn default() -> Self {
        Self { edge: 0.1, evaluations: 300, tolerance: 1e-10 }
    }
}

/// Goes down from `start` within the box.
pub fn nelder_mead(
    bounds: &[(f64, f64)],
    start: &[f64],
    simplex: Simplex,
    function: &mut dyn FnMut(&[f64]) -> f64,
    watch: Watch<'_>,
) -> Best {
    let mut counted = Counted::new(function, watch);
    descend(&mut counted, bounds, start, simplex);
    counted.best
}

/// Goes down from `start` within the box, with a count that goes on.
pub(super) fn descend(
    counted: &mut Counted<'_>,
    bounds: &[(f64, f64)],
    start: &[f64],
    simplex: Simplex,
) {
    let end = counted.best.evaluations + simplex.evaluations;
    let mut start = start.to_vec();
    clamp(&mut start, bounds);
    let mut corners = vec![(counted.at(&start), start.clone())];
    for (d, (low, high)) in bounds.iter().enumerate() {
        let mut corner = start.clone();
        let edge = simplex.edge * (high - low);
        corner[d] += if corner[d] + edge <= *high { edge } else { -edge };
        corners.push((counted.at(&corner), corner));
    }
    while counted.best.evaluations < end && !counted.stopped {
        corners.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (least, most) = (corners[0].0, corners[corners.len() - 1].0);
        if most - least <= simplex.tolerance * least.abs() {
            return;
        }
        step(counted, bounds, &mut corners);
    }
}

/// One reflection, expansion, contraction or shrinkage of sorted corners.
fn step(counted: &mut Counted<'_>, bounds: &[(f64, f64)], corners: &mut [(f64, Vec<f64>)]) {
    let last = corners.len() - 1;
    let centre: Vec<f64> = (0..bounds.len())
        .map(|d| corners[..last].iter().map(|c| c.1[d]).sum::<f64>() / last as f64)
        .collect();
    let worst = corners[last].clone();
    let mut probe = |factor: f64| {
        let mut point: Vec<f64> =
            centre.iter().zip(&worst.1).map(|(c, w)| c + factor * (w - c)).collect();
        clamp(&mut point, bounds);
        (counted.at(&point), point)
    };
    let reflected = probe(-1.0);
    let replacement = if reflected.0 < corners[0].0 {
        let expanded = probe(-2.0);
        if expanded.0 < reflected.0 { expanded } else { reflected }
    } else if reflected.0 < corners[last - 1].0 {
        reflected
    } else {
        let contracted = probe(if reflected.0 < worst.0 { -0.5 } else { 0.5 });
        if contracted.0 >= worst.0.min(reflected.0) {
            let best = corners[0].1.clone();
            for corner in &mut corners[1..] {
                for (x, b) in corner.1.iter_mut().zip(&best) {
                    *x = 0.5 * (*x + b);
                }
                corner.0 = counted.at(&corner.1);
            }
            return;
        }
        contracted
    };
    corners[last] = replacement;
}

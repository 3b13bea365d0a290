//! Broyden's correction of sensitivities (C. G. Broyden, Math. Comp. 19 (1965) 577-593).

use super::Point;
use crate::normal::dot;

/// Corrects the costly sensitivities so that they tell the step that was made, and says which part of the residual's
/// change they missed. Those of the cheap ones are known at both ends: `old` holds them at its beginning.
pub(super) fn correct(
    (before, after): (&Point, &Point),
    columns: &mut [Vec<f64>],
    costly: &[usize],
    (cheap, old): (&[usize], &[Vec<f64>]),
) -> f64 {
    let step = |k: usize| after.theta[k] - before.theta[k];
    let change: Vec<f64> =
        after.residual.iter().zip(&before.residual).map(|(a, b)| a - b).collect();
    let mut missed = change.clone();
    let mut take = |column: &[f64], by: f64| {
        missed.iter_mut().zip(column).for_each(|(m, c)| *m -= by * c);
    };
    for (k, old) in cheap.iter().zip(old) {
        take(old, 0.5 * step(*k));
        take(&columns[*k], 0.5 * step(*k));
    }
    for k in costly {
        take(&columns[*k], step(*k));
    }
    let length: f64 = costly.iter().map(|k| step(*k).powi(2)).sum();
    if length > 0.0 {
        for k in costly {
            let by = step(*k) / length;
            columns[*k].iter_mut().zip(&missed).for_each(|(c, m)| *c += by * m);
        }
    }
    (dot(&missed, &missed) / dot(&change, &change).max(f64::MIN_POSITIVE)).sqrt()
}

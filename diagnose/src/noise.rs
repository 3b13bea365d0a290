//! The noise floor of an output.

use std::ops::Range;

/// Standard deviation of white noise from second differences: `median |Δ²y| / (0.6745·√6)`. Signals
/// that move smoothly cancel; a lower bound where the noise is coloured. A reading that is rounded so
/// coarsely that most second differences are zero gives the rounding's own `q/√12`.
pub(crate) fn second_differences(
    y: &[f64],
    records: impl Iterator<Item = Range<usize>>,
) -> Option<f64> {
    let mut all: Vec<f64> = Vec::new();
    for rows in records {
        let y = &y[rows];
        all.extend(y.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()));
    }
    if all.len() < 20 {
        return None;
    }
    let middle = all.len() / 2;
    let median = *all.select_nth_unstable_by(middle, f64::total_cmp).1;
    let sigma = median / (0.6745 * 6f64.sqrt());
    if sigma > 0.0 {
        return Some(sigma);
    }
    let step = all.iter().copied().filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
    step.is_finite().then(|| step / 12f64.sqrt())
}

/// The same of a residual, from its differences at the highest order that still sees the noise only:
/// fourth differences, whose weights square to 70.
pub(crate) fn fourth_differences(
    r: &[f64],
    records: impl Iterator<Item = Range<usize>>,
) -> Option<f64> {
    let mut all: Vec<f64> = Vec::new();
    for rows in records {
        let r = &r[rows];
        all.extend(
            r.windows(5).map(|w| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs()),
        );
    }
    if all.len() < 20 {
        return None;
    }
    let middle = all.len() / 2;
    let median = *all.select_nth_unstable_by(middle, f64::total_cmp).1;
    (median > 0.0).then(|| median / (0.6745 * 70f64.sqrt()))
}

/// Standard deviation of what does not repeat, where a record repeats its command: from the
/// differences of neighbouring periods, a straight line taken out of each.
pub(crate) fn periods(
    command: &[f64],
    y: &[f64],
    records: impl Iterator<Item = Range<usize>>,
) -> Option<f64> {
    let (mut squares, mut count) = (0.0, 0.0);
    for rows in records {
        let (u, y) = (&command[rows.clone()], &y[rows]);
        let Some(period) = period_of(u) else { continue };
        // The first period is not settled.
        let mut from = period;
        while from + 2 * period <= y.len() {
            let d: Vec<f64> = (from..from + period).map(|k| y[k + period] - y[k]).collect();
            let n = period as f64;
            let mean = d.iter().sum::<f64>() / n;
            let centre = 0.5 * (n - 1.0);
            let (mut cross, mut square) = (0.0, 0.0);
            for (k, d) in d.iter().enumerate() {
                let t = k as f64 - centre;
                cross += t * (d - mean);
                square += t * t;
            }
            let slope = cross / square.max(1.0);
            squares += d
                .iter()
                .enumerate()
                .map(|(k, d)| (d - mean - slope * (k as f64 - centre)).powi(2))
                .sum::<f64>();
            count += n - 2.0;
            from += period;
        }
    }
    // The difference of two periods has twice the variance.
    (count > 50.0).then(|| (0.5 * squares / count).sqrt()).filter(|s| *s > 0.0)
}

/// The shortest shift at which a signal repeats to a billionth of its range, at least three times.
fn period_of(u: &[f64]) -> Option<usize> {
    let (low, high) =
        u.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let close = 1e-6 * (high - low);
    if close.is_nan() || close <= 0.0 {
        return None;
    }
    (8..=u.len() / 3).find(|shift| {
        // A few places first, then all.
        let same = |k: usize| (u[k] - u[k + shift]).abs() <= close;
        let last = u.len() - shift;
        (0..16).all(|k| same(k * (last - 1) / 15)) && (0..last).all(same)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: usize) -> Vec<f64> {
        let mut state = 7u64;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..n).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
    }

    #[test]
    fn three_estimates_of_one_noise() {
        let n = 20_000;
        let u: Vec<f64> =
            (0..n).map(|k| (std::f64::consts::TAU * (k % 1000) as f64 / 1000.0).sin()).collect();
        let y: Vec<f64> = u.iter().zip(noise(n)).map(|(u, e)| 3.0 * u + 0.01 * e).collect();
        let all = || std::iter::once(0..n);
        for sigma in
            [second_differences(&y, all()), fourth_differences(&y, all()), periods(&u, &y, all())]
        {
            assert!((sigma.unwrap() / 0.01 - 1.0).abs() < 0.05, "{sigma:?}");
        }
    }

    #[test]
    fn signals_that_do_not_repeat_have_no_period() {
        let u: Vec<f64> = (0..3000).map(|k| (f64::from(k).powi(2) * 1e-3).sin()).collect();
        assert_eq!(period_of(&u), None);
        assert_eq!(period_of(&[1.0; 100]), None);
    }
}

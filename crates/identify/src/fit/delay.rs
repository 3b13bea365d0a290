//! The delay, searched jointly with the weights.
//!
//! At one frequency and one amplitude a delay and a hysteresis look alike but for the sharpness of
//! the turning points, so that the fit error is nearly flat over several samples of delay; its
//! minimum then says more about the misfit of the model than about the delay. The estimate is
//! therefore the mean over all delays, each weighted with its profile likelihood
//!
//! ```text
//! L(d) = (S(d) / S_min)^(−n/2)
//! ```
//!
//! S(d) the sum of squares with the best weights for this delay, n the number of independent
//! residuals ([`independent_samples`]). Where the log determines the delay, L is a narrow peak and
//! the mean is the minimum; where it does not, the estimate lies in the middle of what the log
//! allows, and its standard deviation says how little that is.
//!
//! Limits: a misfit that repeats with every period of the input is no independent residual, and n
//! counts it as one per correlation time; the true uncertainty is then larger than the one stated.

use crate::error::Error;

use super::coordinates::Deviations;
use super::operator::{Fit, Operator, Solved};
use super::residual::independent_samples;
use super::response::LinearPart;

/// Grid of the search in samples.
const GRID: f64 = 0.5;
/// Log-likelihood below the best at which a delay counts as excluded.
const EXCLUDED: f64 = 8.0;
/// Intervals of the integral over the delays that are not excluded.
const INTERVALS: usize = 32;
/// Golden-section steps that narrow the minimum.
const NARROWING: usize = 24;

/// The fit of a method without a shape and without lag and mode, its delay searched from 0 to `longest` (s); `report`
/// is called with what is done and the total.
///
/// # Errors
/// [`Operator::solve`] has no solution.
pub(crate) fn search(
    operator: &Operator<'_>,
    longest: f64,
    report: &mut dyn FnMut(usize, usize),
) -> Result<Fit, Error> {
    let total_samples = longest / operator.period;
    let grid_points = (total_samples / GRID).ceil() as usize + 1;
    let total = grid_points + NARROWING + INTERVALS + 1;
    let mut done = 0;
    let mut fit_at = |samples: f64| {
        done += 1;
        report(done.min(total), total);
        let delay = samples * operator.period;
        operator.solve(LinearPart { delay, ..LinearPart::default() }, &[])
    };
    let mut profile = Vec::with_capacity(grid_points);
    for k in 0..grid_points {
        let samples = (k as f64 * GRID).min(total_samples);
        profile.push((samples, fit_at(samples)?.cost()));
    }
    let best = narrow(&profile, &mut fit_at)?;
    let independent = independent_samples(best.residual());
    // A residual of rounding errors has no likelihood of its own.
    let (least, floor) = (best.cost(), 1e-20 * operator.energy());
    // Natural logarithm of the profile likelihood, 0 at the minimum.
    let likelihood = |sum_of_squares: f64| {
        let ratio = (sum_of_squares + floor) / (least + floor);
        -0.5 * independent * ratio.max(1.0).ln()
    };
    profile.push((best.linear.delay / operator.period, least));
    profile.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (low, high) = allowed(&profile, likelihood);
    if high - low < 1e-9 {
        return Ok(found(best, 0.0));
    }
    let (mut weight, mut first, mut second) = (0.0, 0.0, 0.0);
    for k in 0..=INTERVALS {
        let samples = low + (high - low) * k as f64 / INTERVALS as f64;
        // Trapezoidal rule.
        let share = if k == 0 || k == INTERVALS { 0.5 } else { 1.0 };
        let density = share * likelihood(fit_at(samples)?.cost()).exp();
        weight += density;
        first += density * samples;
        second += density * samples * samples;
    }
    let mean = first / weight;
    let deviation = (second / weight - mean * mean).max(0.0).sqrt() * operator.period;
    Ok(found(fit_at(mean)?, deviation))
}

/// The fit with the standard deviation of its delay.
fn found(solved: Solved, deviation: f64) -> Fit {
    Fit::of(solved, Deviations { delay: Some(deviation), ..Deviations::default() })
}

/// The minimum near the best grid point, by golden section.
fn narrow(
    profile: &[(f64, f64)],
    fit_at: &mut impl FnMut(f64) -> Result<Solved, Error>,
) -> Result<Solved, Error> {
    let best = (0..profile.len()).min_by(|&a, &b| profile[a].1.total_cmp(&profile[b].1));
    let best = best.unwrap_or(0);
    let mut low = profile[best.saturating_sub(1)].0;
    let mut high = profile[(best + 1).min(profile.len() - 1)].0;
    let mut fitted = fit_at(profile[best].0)?;
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let mut left = fit_at(high - GOLDEN * (high - low))?;
    let mut right = fit_at(low + GOLDEN * (high - low))?;
    for _ in 0..NARROWING - 4 {
        let (x_left, x_right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        if left.cost() < right.cost() {
            high = x_right;
            right = left;
            left = fit_at(high - GOLDEN * (high - low))?;
        } else {
            low = x_left;
            left = right;
            right = fit_at(low + GOLDEN * (high - low))?;
        }
    }
    for candidate in [left, right] {
        if candidate.cost() < fitted.cost() {
            fitted = candidate;
        }
    }
    Ok(fitted)
}

/// The interval of delays around the best that are not excluded; at its ends the log-likelihood is
/// interpolated between points of the profile.
fn allowed(profile: &[(f64, f64)], likelihood: impl Fn(f64) -> f64) -> (f64, f64) {
    let values: Vec<(f64, f64)> = profile.iter().map(|&(d, s)| (d, likelihood(s))).collect();
    let best = (0..values.len()).max_by(|&a, &b| values[a].1.total_cmp(&values[b].1)).unwrap_or(0);
    let crossing = |inside: (f64, f64), outside: (f64, f64)| {
        // The profile is near a parabola with its top at the best delay.
        let depth = |l: f64| (-l).max(0.0).sqrt();
        let (from, to) = (depth(inside.1), depth(outside.1));
        let share = (EXCLUDED.sqrt() - from) / (to - from).max(1e-300);
        inside.0 + share.clamp(0.0, 1.0) * (outside.0 - inside.0)
    };
    let mut low = values[best].0;
    for k in (0..best).rev() {
        if values[k].1 < -EXCLUDED {
            low = crossing(values[k + 1], values[k]);
            break;
        }
        low = values[k].0;
    }
    let mut high = values[best].0;
    for k in best + 1..values.len() {
        if values[k].1 < -EXCLUDED {
            high = crossing(values[k - 1], values[k]);
            break;
        }
        high = values[k].0;
    }
    (low, high)
}

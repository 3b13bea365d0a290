//! Nonlinear least squares: Levenberg–Marquardt with bounds and a forward-difference Jacobian.
//!
//! minimise ½‖r(p)‖² with lower ≤ p ≤ upper. Each step solves (JᵀJ + λ diag(JᵀJ)) δ = −Jᵀr over the
//! parameters that do not push against a bound and is clipped to the bounds; λ falls tenfold after
//! a step that helps and grows tenfold after one that does not. J has one row per residual and one
//! column per parameter; the number of residuals is the same at every p.
//!
//! Reference: D. W. Marquardt, J. SIAM 11 (1963) 431–441; bounds by projection as in C. Kanzow,
//! N. Yamashita, M. Fukushima, J. Comput. Appl. Math. 172 (2004) 375–397.

use nalgebra::{DMatrix, DVector};

use crate::least_squares::{NoSolution, Partner, spread};

/// One parameter: start and bounds, scaled so that a change of 1 is a large one.
#[derive(Clone, Copy, Debug)]
pub struct Unknown {
    /// Where the search begins.
    pub start: f64,
    /// Least value.
    pub lower: f64,
    /// Greatest value.
    pub upper: f64,
}

/// Where the search ended.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The parameters.
    pub parameters: Vec<f64>,
    /// Diagonal of (JᵀJ)⁻¹; `None` where a parameter is at a bound or has no effect.
    pub variance: Vec<Option<f64>>,
    /// For each parameter, the other one it is correlated with most.
    pub partner: Vec<Option<Partner>>,
}

/// When a search ends.
#[derive(Clone, Copy, Debug)]
pub struct Ending {
    /// Most iterations; a problem of a few parameters needs 10 to 30.
    pub iterations: usize,
    /// Relative fall of the sum of squares below which the search has converged.
    pub tolerance: f64,
}

/// To the last digit that matters to a delay or a frequency.
pub const PATIENT: Ending = Ending { iterations: 100, tolerance: 1e-8 };
/// Step of the forward differences.
const DIFFERENCE: f64 = 1e-6;
/// Damping beyond which no step helps any more.
const DAMPING_LIMIT: f64 = 1e12;

/// Minimises the sum of squares of `residuals`, calling `report` with the number of each iteration.
///
/// # Errors
/// What `residuals` returns, and [`NoSolution`] where the search has not converged.
pub fn minimise<E: From<NoSolution>>(
    unknowns: &[Unknown],
    ending: Ending,
    mut residuals: impl FnMut(&[f64]) -> Result<Vec<f64>, E>,
    mut report: impl FnMut(usize),
) -> Result<Minimum, E> {
    let mut at: Vec<f64> = unknowns.iter().map(|u| u.start.clamp(u.lower, u.upper)).collect();
    let mut residual = DVector::from_vec(residuals(&at)?);
    let mut damping = 1e-3;
    for iteration in 0..ending.iterations {
        report(iteration);
        let jacobian = jacobian(unknowns, &at, &residual, &mut residuals)?;
        let gradient = jacobian.tr_mul(&residual);
        let free = free_parameters(unknowns, &at, &gradient);
        let before = residual.norm_squared();
        let mut moved = false;
        while damping < DAMPING_LIMIT {
            if free.is_empty() {
                break;
            }
            if let Some(next) = step(unknowns, &at, &jacobian, &gradient, &free, damping) {
                let candidate = DVector::from_vec(residuals(&next)?);
                if candidate.norm_squared() < before {
                    (at, residual, moved) = (next, candidate, true);
                    damping = (damping * 0.1).max(1e-12);
                    break;
                }
            }
            damping *= 10.0;
        }
        if !moved || before - residual.norm_squared() <= ending.tolerance * before {
            let (variance, partner) = spread(&jacobian, &free);
            return Ok(Minimum { parameters: at, variance, partner });
        }
    }
    Err(NoSolution("the search has not converged").into())
}

fn jacobian<E>(
    unknowns: &[Unknown],
    at: &[f64],
    residual: &DVector<f64>,
    residuals: &mut impl FnMut(&[f64]) -> Result<Vec<f64>, E>,
) -> Result<DMatrix<f64>, E> {
    let mut jacobian = DMatrix::zeros(residual.len(), at.len());
    for (j, unknown) in unknowns.iter().enumerate() {
        let mut shifted = at.to_vec();
        // Away from the upper bound, so that the shifted point is allowed.
        let step = if at[j] + DIFFERENCE <= unknown.upper { DIFFERENCE } else { -DIFFERENCE };
        shifted[j] += step;
        let step = shifted[j] - at[j];
        for (i, value) in residuals(&shifted)?.into_iter().enumerate() {
            jacobian[(i, j)] = (value - residual[i]) / step;
        }
    }
    Ok(jacobian)
}

/// Parameters whose descent direction does not leave the bounds.
fn free_parameters(unknowns: &[Unknown], at: &[f64], gradient: &DVector<f64>) -> Vec<usize> {
    (0..at.len())
        .filter(|&j| {
            let blocked_below = at[j] <= unknowns[j].lower && gradient[j] > 0.0;
            let blocked_above = at[j] >= unknowns[j].upper && gradient[j] < 0.0;
            gradient[j] != 0.0 && !blocked_below && !blocked_above
        })
        .collect()
}

/// The damped step, clipped to the bounds; `None` where the damped matrix is still singular.
fn step(
    unknowns: &[Unknown],
    at: &[f64],
    jacobian: &DMatrix<f64>,
    gradient: &DVector<f64>,
    free: &[usize],
    damping: f64,
) -> Option<Vec<f64>> {
    let columns = jacobian.select_columns(free);
    let own = DVector::from_fn(free.len(), |k, _| gradient[free[k]]);
    let delta = damped_step(columns.tr_mul(&columns), &own, damping)?;
    let mut next = at.to_vec();
    for (k, &j) in free.iter().enumerate() {
        next[j] = (at[j] + delta[k]).clamp(unknowns[j].lower, unknowns[j].upper);
    }
    Some(next)
}

/// −(N + λ diag N)⁻¹ g, for the normal matrix N = JᵀJ, the gradient g = Jᵀr and the damping λ; `None` where the damped
/// matrix is not positive definite.
#[must_use]
pub fn damped_step(
    mut normal: DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    for k in 0..normal.nrows() {
        normal[(k, k)] *= 1.0 + damping;
    }
    Some(-normal.cholesky()?.solve(gradient))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free(start: f64) -> Unknown {
        Unknown { start, lower: -10.0, upper: 10.0 }
    }

    #[test]
    fn finds_the_minimum_of_rosenbrocks_valley() {
        let valley = |p: &[f64]| Ok::<_, NoSolution>(vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]]);
        let minimum =
            minimise(&[free(-1.2), free(1.0)], PATIENT, valley, |_| {}).expect("converges");
        assert!(minimum.parameters.iter().all(|p| (p - 1.0).abs() < 1e-6), "{minimum:?}");
    }

    #[test]
    fn stops_at_a_bound_and_gives_no_variance_there() {
        let line = |p: &[f64]| Ok::<_, NoSolution>(vec![p[0] - 3.0, p[1] + 1.0]);
        let bounded = Unknown { start: 0.0, lower: -1.0, upper: 2.0 };
        let minimum = minimise(&[bounded, free(0.5)], PATIENT, line, |_| {}).expect("converges");
        assert_eq!(minimum.parameters[0], 2.0);
        assert!((minimum.parameters[1] + 1.0).abs() < 1e-6);
        assert_eq!(minimum.variance[0], None);
    }

    #[test]
    fn an_error_of_the_model_ends_the_search() {
        let fails = |_: &[f64]| Err(NoSolution("as stated"));
        assert!(minimise(&[free(0.0)], PATIENT, fails, |_| {}).is_err());
    }
}

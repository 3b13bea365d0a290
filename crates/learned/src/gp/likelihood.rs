//! The marginal likelihood and its gradient in one pass.
//!
//! ```text
//! ∂/∂θ = ½ tr(W ∂C/∂θ),   W = ααᵀ − C⁻¹,   M = W ∘ K
//! ∂/∂ln l_d = ½ Σ_ij M_ij (x_id − x_jd)²/l_d² = (Σ_i x_id² m_i − x_dᵀ M x_d)/l_d²,   m = M·1
//! ```
//!
//! No array of n × n × d is ever built: the sums over pairs are a product of M with the inputs.

use super::Hyperparameters;
use crate::Error;
use crate::lssvm::Samples;
use crate::solve::dense::{Mat, inverse, view};
use crate::solve::kernel::Scaled;
use crate::solve::{factorise, solve_factored};

/// A value of the likelihood.
#[derive(Clone, Debug, PartialEq)]
pub struct Likelihood {
    /// The hyperparameters.
    pub parameters: Hyperparameters,
    /// ln p(y).
    pub value: f64,
    /// The likelihood's derivatives by ln σ_f, ln σ_n, ln l_d.
    pub gradient: Vec<f64>,
}

/// The logarithm of the marginal likelihood and its gradient.
///
/// # Errors
/// [`Error::Setting`], [`Error::IllPosed`].
pub fn likelihood(samples: &Samples, parameters: &Hyperparameters) -> Result<Likelihood, Error> {
    let (n, d) = (samples.count(), samples.dimension());
    parameters.check(d)?;
    let points = Scaled::new(samples.inputs(), d, &parameters.scale(d));
    let mean = samples.outputs().iter().sum::<f64>() / n as f64;
    let y: Vec<f64> = samples.outputs().iter().map(|y| y - mean).collect();
    let signal2 = parameters.signal.powi(2);
    let lambda = parameters.noise.powi(2) / signal2;
    // C = σ_f² (k + λI): all in units of σ_f².
    let mut kernel = vec![0.0; n * n];
    points.fill_lower(&mut kernel);
    let mut factor = kernel.clone();
    factorise(&mut factor, n, lambda)?;
    let mut alpha = y.clone();
    solve_factored(&factor, n, &mut alpha);
    let half_log: f64 = (0..n).map(|i| factor[i * n + i].ln()).sum();
    let fit: f64 = y.iter().zip(&alpha).map(|(y, a)| y * a).sum::<f64>() / signal2;
    let logs = (n as f64) * (core::f64::consts::TAU.ln() + signal2.ln());
    let value = -0.5 * fit - half_log - 0.5 * logs;
    let mut inv = inverse(&view(&factor, n, n));
    drop(factor);
    // W in units of 1/σ_f² on the diagonal; M = W ∘ k over the inverse.
    let diagonal: f64 = (0..n).map(|i| alpha[i] * alpha[i] / signal2 - inv[(i, i)]).sum();
    hadamard(&mut inv, &kernel, &alpha, signal2);
    inv.fill_upper_triangle_with_lower_triangle();
    let sums = moments(&inv, &points);
    // ∂C/∂ln σ_f = 2K and ∂C/∂ln σ_n = 2σ_n² I.
    let mut gradient = vec![sums.total, lambda * diagonal];
    let by_length: Vec<f64> = sums.squares.iter().map(|s| 2.0 * s).collect();
    if parameters.lengths.len() == 1 {
        gradient.push(by_length.iter().sum());
    } else {
        gradient.extend(by_length);
    }
    Ok(Likelihood { parameters: parameters.clone(), value, gradient })
}

/// `inv := (ααᵀ/σ_f² − inv) ∘ kernel` in the lower half.
fn hadamard(inv: &mut Mat, kernel: &[f64], alpha: &[f64], signal2: f64) {
    let n = alpha.len();
    for (j, column) in inv.as_mut_slice().chunks_exact_mut(n).enumerate() {
        let factor = alpha[j] / signal2;
        for ((m, k), a) in
            column[j..].iter_mut().zip(&kernel[j * n + j..(j + 1) * n]).zip(&alpha[j..])
        {
            *m = (factor * a - *m) * k;
        }
    }
}

struct Moments {
    /// Σ_ij M_ij.
    total: f64,
    /// For each scaled input Σ_i x_i² m_i − xᵀ M x.
    squares: Vec<f64>,
}

fn moments(m: &Mat, points: &Scaled) -> Moments {
    let (n, d) = (points.n, points.d);
    let centre: Vec<f64> =
        (0..d).map(|k| (0..n).map(|i| points.point(i)[k]).sum::<f64>() / n as f64).collect();
    let x =
        Mat::from_fn(n, d + 1, |i, k| if k == d { 1.0 } else { points.point(i)[k] - centre[k] });
    let product = m * &x;
    let square = |k: usize| {
        (0..n).map(|i| x[(i, k)] * (x[(i, k)] * product[(i, d)] - product[(i, k)])).sum()
    };
    Moments { total: (0..n).map(|i| product[(i, d)]).sum(), squares: (0..d).map(square).collect() }
}

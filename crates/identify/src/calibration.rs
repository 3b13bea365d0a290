//! Calibration of any model by its residuals: values, 95 % intervals, correlation, and what the
//! residuals do not determine.
//!
//! minimise ‖r(p)‖², lower ≤ p ≤ upper, by [`minimise`] from several starts, the
//! best one then by Gauss–Newton steps with central differences until they no longer move. With J the
//! Jacobian there, n residuals and m parameters,
//!
//! ```text
//! s² = ‖r‖² / (n − m)        cov(p) = c s² (JᵀJ)⁻¹        p ± t(0.975, n − m) √cov
//! ```
//!
//! c = 1 for white residuals. Correlated residuals say less than as many independent ones: then
//! c = 1 + 2 Σ ρ_k, with their autocorrelation ρ_k as far as it stands out.
//!
//! Reference: G. A. F. Seber, C. J. Wild, Nonlinear Regression, Wiley 1989, chapters 2 and 5.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use numerics::levenberg_marquardt::{PATIENT, Unknown, minimise};

use crate::error::Error;

/// A parameter to be found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tunable {
    /// Where the search begins.
    pub start: f64,
    /// Least value.
    pub lower: f64,
    /// Greatest value.
    pub upper: f64,
    /// A change that is a large one.
    pub scale: f64,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// The values.
    pub values: Vec<f64>,
    /// Standard deviation of each; none where it is at a bound or not determined.
    pub sigma: Vec<Option<f64>>,
    /// Half the width of the 95 % interval of each.
    pub half_width: Vec<Option<f64>>,
    /// Correlation of each with each; 0 where one is not determined.
    pub correlation: Vec<Vec<f64>>,
    /// Parameters at a bound.
    pub at_bound: Vec<bool>,
    /// Groups of parameters that can move together without a change of the residuals worth speaking of; a
    /// group of one has no influence.
    pub undetermined: Vec<Vec<usize>>,
    /// ‖r‖² at the values.
    pub squares: f64,
    /// ‖r‖² that each start led to; none where it led to nothing.
    pub starts: Vec<Option<f64>>,
    /// By how much the intervals' squares grew because residuals are correlated.
    pub inflation: f64,
    /// How often the model was asked, and how often it had no answer.
    pub evaluations: usize,
    /// How often it had none.
    pub failures: usize,
}

/// Step of the central differences, of a scaled parameter.
const DIFFERENCE: f64 = 1e-5;
/// Gauss–Newton steps at the end.
const STEPS: usize = 30;
/// Boxes that a search may go through.
const BOXES: usize = 40;
/// How often one is halved.
const HALVINGS: i32 = 8;
/// A step that moves a scaled parameter by less has arrived.
const ARRIVED: f64 = 1e-10;
/// An eigenvalue of JᵀJ, with columns of length 1, below which a direction is not determined.
const DETERMINED: f64 = 1e-9;
/// Share of a direction from which a parameter takes part in it.
const TAKES_PART: f64 = 0.1;
/// Residual in place of one that the model does not answer: worse than any.
const NOTHING: f64 = 1e100;
/// The greatest lag at which residuals are looked at.
const LAGS: usize = 500;

/// The model as the search asks it.
struct Model<'f, F> {
    residuals: &'f mut F,
    parameters: &'f [Tunable],
    count: usize,
    evaluations: usize,
    failures: usize,
}

impl<F: FnMut(&[f64]) -> Option<Vec<f64>>> Model<'_, F> {
    fn at(&mut self, scaled: &[f64]) -> Vec<f64> {
        let values: Vec<f64> =
            scaled.iter().zip(self.parameters).map(|(q, p)| q * p.scale).collect();
        self.evaluations += 1;
        let found = (self.residuals)(&values);
        let found = found.filter(|r| r.len() == self.count && r.iter().all(|x| x.is_finite()));
        found.unwrap_or_else(|| {
            self.failures += 1;
            vec![NOTHING; self.count]
        })
    }
}

/// Finds the parameters. `residuals` gives those at some values, or none where the model has no answer
/// there; `series` are the lengths of the parts that follow each other in time; `starts` are further
/// starts besides the parameters' own.
///
/// # Errors
/// The model has no answer at the first start, or there are not more residuals than parameters.
pub fn calibrate(
    parameters: &[Tunable],
    starts: &[Vec<f64>],
    series: &[usize],
    mut residuals: impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Result<Calibration, Error> {
    let count = series.iter().sum::<usize>();
    if count <= parameters.len() {
        return Err(Error::no_solution("there are not more residuals than parameters"));
    }
    let residuals = &mut residuals;
    let mut model = Model { residuals, parameters, count, evaluations: 0, failures: 0 };
    let scaled = |values: &[f64]| -> Vec<f64> {
        values.iter().zip(parameters).map(|(x, p)| x.clamp(p.lower, p.upper) / p.scale).collect()
    };
    let own: Vec<f64> = parameters.iter().map(|p| p.start).collect();
    if model.at(&scaled(&own)).first() == Some(&NOTHING) {
        return Err(Error::no_solution("the model does not run with the start values"));
    }
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut reached = Vec::new();
    for start in std::iter::once(&own).chain(starts) {
        let end = descend(&mut model, scaled(start));
        let squares = model.at(&end).iter().map(|r| r * r).sum::<f64>();
        let squares = Some((squares, end)).filter(|(squares, _)| *squares < NOTHING);
        reached.push(squares.as_ref().map(|(squares, _)| *squares));
        if let Some(found) = squares
            && best.as_ref().is_none_or(|(least, _)| found.0 < *least)
        {
            best = Some(found);
        }
    }
    let begin = best.map_or_else(|| scaled(&own), |(_, at)| at);
    let (at, residual, jacobian) = polish(&mut model, begin);
    let (evaluations, failures) = (model.evaluations, model.failures);
    let mut answer = judged(parameters, &at, &residual, &jacobian, series);
    (answer.starts, answer.evaluations, answer.failures) = (reached, evaluations, failures);
    Ok(answer)
}

/// Levenberg–Marquardt within a box about the point, which follows it: a first step that is carried far
/// away ends where the model depends on nothing any more.
fn descend<F: FnMut(&[f64]) -> Option<Vec<f64>>>(
    model: &mut Model<'_, F>,
    mut at: Vec<f64>,
) -> Vec<f64> {
    for _ in 0..BOXES {
        let unknown = |(q, p): (&f64, &Tunable)| {
            let reach = 0.5 * q.abs().max(0.5);
            let lower = (q - reach).max(p.lower / p.scale);
            let upper = (q + reach).min(p.upper / p.scale);
            Unknown { start: *q, lower, upper }
        };
        let unknowns: Vec<Unknown> = at.iter().zip(model.parameters).map(unknown).collect();
        // One that has not converged is gone on with by the last steps.
        let Ok(found) = minimise::<Error>(&unknowns, PATIENT, |q| Ok(model.at(q)), |_| {}) else {
            break;
        };
        at = found.parameters;
        let is_at_side = |((q, u), p): ((&f64, &Unknown), &Tunable)| {
            (*q <= u.lower && u.lower > p.lower / p.scale)
                || (*q >= u.upper && u.upper < p.upper / p.scale)
        };
        if !at.iter().zip(&unknowns).zip(model.parameters).any(is_at_side) {
            break;
        }
    }
    at
}

/// Whether a scaled value lies at a bound.
fn is_at_bound(q: f64, p: &Tunable) -> bool {
    let near = |bound: f64| (q - bound / p.scale).abs() <= 1e-9 * (1.0 + q.abs());
    near(p.lower) || near(p.upper)
}

/// Gauss–Newton steps until they no longer move; where they do not help, the point stays. [`minimise`] cannot take its
/// place: forward differences end about as far from the minimum as their step is long, and central ones do not.
fn polish<F: FnMut(&[f64]) -> Option<Vec<f64>>>(
    model: &mut Model<'_, F>,
    mut at: Vec<f64>,
) -> (Vec<f64>, DVector<f64>, DMatrix<f64>) {
    let mut residual = DVector::from_vec(model.at(&at));
    for _ in 0..STEPS {
        let jacobian = jacobian(model, &at);
        let gradient = jacobian.tr_mul(&residual);
        let free: Vec<usize> = (0..at.len())
            .filter(|&j| {
                let p = &model.parameters[j];
                let (low, high) = (at[j] <= p.lower / p.scale, at[j] >= p.upper / p.scale);
                gradient[j] != 0.0 && !(low && gradient[j] > 0.0) && !(high && gradient[j] < 0.0)
            })
            .collect();
        let Some(next) = bounded_step(model.parameters, &jacobian, &residual, &at, free) else {
            return (at, residual, jacobian);
        };
        let moved = next.iter().zip(&at).map(|(a, b)| (a - b).abs() / (1.0 + b.abs()));
        let moved = moved.fold(0.0, f64::max);
        // Shorter, where the whole step leads up.
        let mut shorter = (0..HALVINGS).map(|n| 0.5_f64.powi(n)).filter_map(|part| {
            let point: Vec<f64> = at.iter().zip(&next).map(|(a, b)| a + part * (b - a)).collect();
            let found = DVector::from_vec(model.at(&point));
            let helps = found.norm_squared() <= residual.norm_squared() * (1.0 + 1e-12);
            helps.then_some((point, found))
        });
        let Some(better) = shorter.next() else { return (at, residual, jacobian) };
        drop(shorter);
        (at, residual) = better;
        if moved < ARRIVED {
            return (at, residual, jacobian);
        }
    }
    let jacobian = jacobian(model, &at);
    (at, residual, jacobian)
}

/// Central differences; one-sided at a bound, and where one side has no answer.
fn jacobian<F: FnMut(&[f64]) -> Option<Vec<f64>>>(
    model: &mut Model<'_, F>,
    at: &[f64],
) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(model.count, at.len());
    for j in 0..at.len() {
        let p = model.parameters[j];
        let size = DIFFERENCE * at[j].abs().max(1.0);
        let shifted = |by: f64| {
            let mut shifted = at.to_vec();
            shifted[j] = (at[j] + by).clamp(p.lower / p.scale, p.upper / p.scale);
            shifted
        };
        let ends = [shifted(-size), shifted(size)].map(|q| (q[j], model.at(&q)));
        let answers = |r: &Vec<f64>| r.first() != Some(&NOTHING);
        let (mut low, mut high) = (ends[0].clone(), ends[1].clone());
        if !answers(&low.1) {
            low = (at[j], model.at(at));
        }
        if !answers(&high.1) {
            high = (at[j], model.at(at));
        }
        let width = high.0 - low.0;
        if width > 0.0 {
            let slopes = high.1.iter().zip(&low.1).map(|(b, a)| (b - a) / width);
            slopes.enumerate().for_each(|(i, slope)| jacobian[(i, j)] = slope);
        }
    }
    jacobian
}

/// The end of a Gauss–Newton step. A parameter that it would carry over a bound stays at the bound, and
/// the step of the others is that of a problem in which it does.
fn bounded_step(
    parameters: &[Tunable],
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
    at: &[f64],
    mut free: Vec<usize>,
) -> Option<Vec<f64>> {
    let mut next = at.to_vec();
    loop {
        let moved = DVector::from_iterator(at.len(), next.iter().zip(at).map(|(a, b)| a - b));
        let rest = residual + jacobian * moved;
        if free.is_empty() {
            return (next != at).then_some(next);
        }
        let step = gauss_newton(jacobian, &rest, &free)?;
        let out = free.iter().enumerate().find_map(|(k, &j)| {
            let p = &parameters[j];
            let (to, low, high) = (at[j] + step[k], p.lower / p.scale, p.upper / p.scale);
            (!(low..=high).contains(&to)).then(|| (k, to.clamp(low, high)))
        });
        match out {
            Some((k, bound)) => next[free.remove(k)] = bound,
            None => {
                free.iter().enumerate().for_each(|(k, &j)| next[j] = at[j] + step[k]);
                return Some(next);
            }
        }
    }
}

fn gauss_newton(
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
    free: &[usize],
) -> Option<DVector<f64>> {
    if free.is_empty() {
        return None;
    }
    let columns = jacobian.select_columns(free);
    let lengths: Vec<f64> = columns.column_iter().map(|c| c.norm()).collect();
    if lengths.contains(&0.0) {
        return None;
    }
    let unit = DMatrix::from_fn(columns.nrows(), free.len(), |i, k| columns[(i, k)] / lengths[k]);
    let normal = unit.tr_mul(&unit);
    let eigen = SymmetricEigen::new(normal.clone());
    if eigen.eigenvalues.min() < DETERMINED {
        return None;
    }
    let step = normal.cholesky()?.solve(&(-unit.tr_mul(residual)));
    Some(DVector::from_fn(free.len(), |k, _| step[k] / lengths[k]))
}

/// Intervals, correlation, and what is not determined.
fn judged(
    parameters: &[Tunable],
    at: &[f64],
    residual: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    series: &[usize],
) -> Calibration {
    let m = parameters.len();
    let at_bound: Vec<bool> = at.iter().zip(parameters).map(|(q, p)| is_at_bound(*q, p)).collect();
    let lengths: Vec<f64> = jacobian.column_iter().map(|c| c.norm()).collect();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let has_influence = |j: usize| lengths[j] > DETERMINED * longest;
    let mut undetermined: Vec<Vec<usize>> =
        (0..m).filter(|j| !has_influence(*j)).map(|j| vec![j]).collect();
    let free: Vec<usize> = (0..m).filter(|j| has_influence(*j) && !at_bound[*j]).collect();
    let unit = DMatrix::from_fn(jacobian.nrows(), free.len(), |i, k| {
        jacobian[(i, free[k])] / lengths[free[k]]
    });
    let mut variance = vec![None; m];
    let mut covariance = DMatrix::zeros(m, m);
    if !free.is_empty() {
        let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(unit.tr_mul(&unit));
        let mut weak = vec![false; free.len()];
        let mut inverse = DMatrix::zeros(free.len(), free.len());
        for (value, direction) in eigenvalues.iter().zip(eigenvectors.column_iter()) {
            if *value >= DETERMINED {
                inverse += direction * direction.transpose() / *value;
                continue;
            }
            let group: Vec<usize> =
                (0..free.len()).filter(|k| direction[*k].abs() > TAKES_PART).collect();
            group.iter().for_each(|k| weak[*k] = true);
            undetermined.push(group.iter().map(|k| free[*k]).collect());
        }
        let solid = |k: &usize| !weak[*k];
        for k in (0..free.len()).filter(solid) {
            for l in (0..free.len()).filter(solid) {
                let (i, j) = (free[k], free[l]);
                covariance[(i, j)] = inverse[(k, l)] / (lengths[i] * lengths[j]);
            }
            variance[free[k]] = Some(covariance[(free[k], free[k])]);
        }
    }
    let squares = residual.norm_squared();
    let freedom = (residual.len() - m) as f64;
    let inflation = inflation(residual.as_slice(), series);
    let noise = inflation * squares / freedom;
    let t = student(freedom);
    let sigma: Vec<Option<f64>> = variance
        .iter()
        .zip(parameters)
        .map(|(v, p)| v.map(|v: f64| (noise * v.max(0.0)).sqrt() * p.scale))
        .collect();
    let correlation = (0..m)
        .map(|i| {
            let of = |j: usize| {
                let product: f64 = covariance[(i, i)] * covariance[(j, j)];
                if product > 0.0 { covariance[(i, j)] / product.sqrt() } else { 0.0 }
            };
            (0..m).map(of).collect()
        })
        .collect();
    Calibration {
        values: at.iter().zip(parameters).map(|(q, p)| q * p.scale).collect(),
        half_width: sigma.iter().map(|s| s.map(|s| t * s)).collect(),
        sigma,
        correlation,
        at_bound,
        undetermined,
        squares,
        starts: Vec::new(),
        inflation,
        evaluations: 0,
        failures: 0,
    }
}

/// 1 + 2 Σ ρ_k of correlated residuals, as far as ρ_k stands out; 1 where they do not.
fn inflation(residual: &[f64], series: &[usize]) -> f64 {
    let mut parts = Vec::new();
    let mut rest = residual;
    for length in series {
        let (part, after) = rest.split_at(*length.min(&rest.len()));
        parts.push(part);
        rest = after;
    }
    let total: f64 = residual.iter().map(|r| r * r).sum();
    if total == 0.0 {
        return 1.0;
    }
    let correlation = |lag: usize| {
        let products = parts
            .iter()
            .map(|part| part.iter().zip(part.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>());
        products.sum::<f64>() / total
    };
    let clear = 1.0 / (residual.len() as f64).sqrt();
    if correlation(1) < 4.0 * clear {
        return 1.0;
    }
    let standing = (1..=LAGS).map(correlation).take_while(|rho| *rho > 2.0 * clear);
    1.0 + 2.0 * standing.sum::<f64>()
}

/// The 97.5 % point of Student's distribution (M. Abramowitz, I. Stegun, 26.7.5).
fn student(freedom: f64) -> f64 {
    let z: f64 = 1.959_963_984_540_054;
    let (z3, z5, z7) = (z.powi(3), z.powi(5), z.powi(7));
    z + (z3 + z) / (4.0 * freedom)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * freedom.powi(2))
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * freedom.powi(3))
}

#[cfg(test)]
mod tests;

//! The frequency response matrix by the local polynomial method.
//!
//! ```text
//! Y(k + r) = [G(k) + g₁ r + … + g_d r^d] U(k + r) [+ t₀ + … + t_d r^d] + E(k + r),   |r| small
//! ```
//!
//! All experiments enter together; the least squares about each line give the response G (the best
//! linear approximation), and what they leave is the total variance. Whole periods of a steady
//! state need no transient t; their scatter from period to period is the noise, and what the total
//! variance is above it are stochastic nonlinear distortions: the robust method. Records that are not
//! periodic get the transient, which takes the leakage off, and no such separation.
//!
//! A resonance must be resolved: where fewer than about eight lines lie within its half-power width, the
//! polynomials cut its top, and what they miss counts as distortion. Take a longer period then.
//!
//! Source: R. Pintelon, J. Schoukens, *System Identification: A Frequency Domain Approach*, 2nd ed.
//! (2012), sections 4.3 and 7.2-7.3.

use nalgebra::{DMatrix, DVector};

use super::Complex;
use super::excitation::{Experiment, Spectra, period_of, spectra};
use super::levels::distortion;
use super::response::{Alone, Distortion, FrequencyResponse, Line};
use crate::error::{Error, Problem};

/// How a response is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasureSettings {
    /// Sample time in s.
    pub sample_time: f64,
    /// Samples of one period; `None`: looked for, and a record without whole periods is taken as one
    /// that is not periodic.
    pub period: Option<usize>,
    /// Degree d of the polynomials.
    pub degree: usize,
    /// Most lines at which the response is computed; lines between are used, not shown.
    pub most_lines: usize,
    /// Power of a line, as a part of the greatest, up to whose first and last occurrence a record that
    /// is not periodic counts as excited. Coherence tells how good such a line is.
    pub band: f64,
}

impl MeasureSettings {
    /// The usual ones.
    #[must_use]
    pub fn new(sample_time: f64) -> Self {
        Self { sample_time, period: None, degree: 2, most_lines: 4000, band: IN_BAND }
    }
}

/// Where the inputs' part is so many times the output, it only cancels the transient: the line holds what leaks
/// from others.
const CANCELLED: f64 = 10.0;
/// Power of a line, as a part of the greatest, from which it counts as excited.
const EXCITED: f64 = 1e-4;
/// Power from which a line of a record that is not periodic counts as excited: its lines scatter.
const IN_BAND: f64 = 1e-2;
/// Equations beyond the unknowns.
const FREEDOM: usize = 8;

/// Measures the frequency response.
///
/// # Errors
/// [`Error::Unsuitable`] with every problem of the experiments; [`Error::NoSolution`] where the inputs do
/// not excite enough lines.
pub fn measure(
    experiments: &[Experiment],
    settings: &MeasureSettings,
) -> Result<FrequencyResponse, Error> {
    let Some(first) = experiments.first() else {
        return Err(Error::Unsuitable(vec![Problem::NoRecord]));
    };
    let problems: Vec<Problem> =
        experiments.iter().filter_map(|one| one.check(first).err()).collect();
    if !problems.is_empty() {
        return Err(Error::Unsuitable(problems));
    }
    let period = settings.period.or_else(|| period_of(first));
    let length =
        period.unwrap_or_else(|| experiments.iter().map(Experiment::len).min().unwrap_or(0));
    let all = experiments.iter().map(|one| spectra(one, length)).collect::<Result<Vec<_>, _>>()?;
    let excited = excited(&all, period.is_none().then_some(settings.band));
    let window = Window {
        spectra: &all,
        degree: settings.degree,
        transient: period.is_none(),
        excited: &excited,
        length,
        sample_time: settings.sample_time,
    };
    let reach = window.reach()?;
    let stride = excited.len().div_ceil(settings.most_lines.max(1)).max(1);
    let lines = (0..excited.len())
        .step_by(stride)
        .filter_map(|centre| window.line(centre, reach))
        .collect::<Vec<_>>();
    if lines.is_empty() {
        return Err(Error::no_solution(
            "the inputs do not move independently of one another, and of the transient of a record \
             without periods, at any frequency; give as many experiments with different inputs as \
             there are inputs, and a signal richer than a sine",
        ));
    }
    let distortion = match period {
        Some(_) => distortion(&all, &excited, &lines, length, settings.sample_time),
        None => Distortion::default(),
    };
    Ok(FrequencyResponse {
        lines,
        sample_time: settings.sample_time,
        period,
        experiments: experiments.len(),
        periods: period.map_or(1, |period| first.len() / period),
        distortion,
    })
}

/// Lines that the inputs excite, without the constant and the last; `band` for a record without periods.
fn excited(all: &[Spectra], band: Option<f64>) -> Vec<usize> {
    let Some(first) = all.first() else { return Vec::new() };
    let count = first.inputs.first().map_or(0, Vec::len).saturating_sub(1);
    let inputs = first.inputs.len();
    let mut mark = vec![false; count];
    for input in 0..inputs {
        let power = |k: usize| all.iter().map(|s| s.inputs[input][k].norm_sqr()).sum::<f64>();
        let powers: Vec<f64> = (0..count).map(power).collect();
        let greatest = powers.iter().skip(1).copied().fold(0.0, f64::max);
        let least = greatest * band.unwrap_or(EXCITED);
        let is = |k: &usize| powers[*k] > least;
        if band.is_none() {
            (1..count).filter(is).for_each(|k| mark[k] = true);
        } else if let (Some(from), Some(to)) = ((1..count).find(is), (1..count).rev().find(is)) {
            mark[from..=to].fill(true);
        }
    }
    (1..count).filter(|k| mark[*k]).collect()
}

struct Window<'a> {
    spectra: &'a [Spectra],
    degree: usize,
    transient: bool,
    excited: &'a [usize],
    length: usize,
    sample_time: f64,
}

impl Window<'_> {
    fn unknowns(&self) -> usize {
        let transients = if self.transient { self.spectra.len() } else { 0 };
        (self.degree + 1) * (self.spectra[0].inputs.len() + transients)
    }

    /// Excited lines on either side of the centre.
    fn reach(&self) -> Result<usize, Error> {
        let needed = (self.unknowns() + FREEDOM).div_ceil(self.spectra.len());
        let reach = needed / 2;
        if self.excited.len() < 2 * reach + 1 {
            return Err(Error::no_solution(
                "too few lines are excited for this number of inputs; take a richer signal or a \
                 longer period",
            ));
        }
        Ok(reach)
    }

    /// The response at an excited line; `None` where the inputs are not independent there, of one another or of
    /// the transient.
    fn line(&self, centre: usize, reach: usize) -> Option<Line> {
        let last = self.excited.len() - 1;
        // A whole window at the edges of the band too.
        let from = centre.saturating_sub(reach).min(last.saturating_sub(2 * reach));
        let window = &self.excited[from..=(from + 2 * reach).min(last)];
        let line = self.excited[centre];
        let scale = window.iter().map(|k| k.abs_diff(line)).max().unwrap_or(1).max(1) as f64;
        let (inputs, outputs) = (self.spectra[0].inputs.len(), self.spectra[0].outputs.len());
        let (rows, columns) = (window.len() * self.spectra.len(), self.unknowns());
        let powers = self.degree + 1;
        let mut matrix = DMatrix::<Complex>::zeros(rows, columns);
        let mut right = DMatrix::<Complex>::zeros(rows, outputs);
        for (e, spectra) in self.spectra.iter().enumerate() {
            for (w, &k) in window.iter().enumerate() {
                let row = e * window.len() + w;
                let r = (k as f64 - line as f64) / scale;
                for power in 0..powers {
                    let factor = r.powi(power as i32);
                    for i in 0..inputs {
                        matrix[(row, power * inputs + i)] = spectra.inputs[i][k] * factor;
                    }
                    if self.transient {
                        let column = powers * inputs + power * self.spectra.len() + e;
                        matrix[(row, column)] = Complex::new(factor, 0.0);
                    }
                }
                for o in 0..outputs {
                    right[(row, o)] = spectra.outputs[o][k];
                }
            }
        }
        let norms: Vec<f64> = matrix.column_iter().map(|c| c.norm()).collect();
        for (mut column, norm) in matrix.column_iter_mut().zip(&norms) {
            column /= Complex::new(norm.max(f64::MIN_POSITIVE), 0.0);
        }
        let qr = matrix.clone().qr();
        let triangle = qr.r();
        let sound = triangle.diagonal().iter().all(|d| d.norm() > 1e-9);
        if !sound {
            return None;
        }
        let projected = qr.q().adjoint() * &right;
        let solution = triangle.solve_upper_triangular(&projected)?;
        let linear = matrix.columns(0, powers * inputs) * solution.rows(0, powers * inputs);
        let cancels = |o: usize| linear.column(o).norm() > CANCELLED * right.column(o).norm();
        if self.transient && (0..outputs).any(cancels) {
            return None;
        }
        let residual = &right - &matrix * &solution;
        let inverse = triangle.solve_upper_triangular(&DMatrix::identity(columns, columns))?;
        let freedom = (rows - columns) as f64;
        let unscaled = |row: usize| 1.0 / norms[row].max(f64::MIN_POSITIVE);
        let response = DMatrix::from_fn(outputs, inputs, |o, i| solution[(i, o)] * unscaled(i));
        let variance: Vec<f64> =
            (0..outputs).map(|o| residual.column(o).norm_squared() / freedom).collect();
        let spread = |i: usize| inverse.row(i).norm() * unscaled(i);
        let deviation = DMatrix::from_fn(outputs, inputs, |o, i| variance[o].sqrt() * spread(i));
        let power = |o: usize| right.column(o).norm_squared() / rows as f64;
        let coherence =
            (0..outputs)
                .map(|o| {
                    if power(o) > 0.0 {
                        (1.0 - variance[o] / power(o)).clamp(0.0, 1.0)
                    } else {
                        0.0
                    }
                })
                .collect();
        let amplitude = 2.0 / self.length as f64;
        let here = |o: usize| {
            let sum: f64 = self.spectra.iter().map(|s| s.outputs[o][line].norm_sqr()).sum();
            amplitude * (sum / self.spectra.len() as f64).sqrt()
        };
        Some(Line {
            frequency: line as f64 / (self.length as f64 * self.sample_time),
            response,
            deviation,
            coherence,
            amplitude: (0..outputs).map(here).collect(),
            total: variance.iter().map(|v| amplitude * v.sqrt()).collect(),
            noise: self
                .noise(window, outputs)
                .map(|n| n.iter().map(|v| amplitude * v.sqrt()).collect()),
            alone: if self.transient { None } else { self.alone(line) },
        })
    }

    /// Least squares over the experiments at one line.
    fn alone(&self, line: usize) -> Option<Alone> {
        let (inputs, outputs) = (self.spectra[0].inputs.len(), self.spectra[0].outputs.len());
        let count = self.spectra.len();
        if count < inputs {
            return None;
        }
        let u = DMatrix::from_fn(inputs, count, |i, e| self.spectra[e].inputs[i][line]);
        let y = DMatrix::from_fn(outputs, count, |o, e| self.spectra[e].outputs[o][line]);
        let inverse = (&u * u.adjoint()).try_inverse()?;
        let spread = inverse.diagonal().iter().map(|c| c.re).sum::<f64>() / inputs.max(1) as f64;
        let response = y * u.adjoint() * inverse;
        let sound = response.iter().all(|g| g.re.is_finite() && g.im.is_finite());
        (sound && spread.is_finite() && spread > 0.0)
            .then(|| Alone { response, strength: 1.0 / spread.sqrt() })
    }

    /// Variance of the noise per output, mean over the window.
    fn noise(&self, window: &[usize], outputs: usize) -> Option<Vec<f64>> {
        let mut sum = DVector::<f64>::zeros(outputs);
        for spectra in self.spectra {
            let noise = spectra.noise.as_ref()?;
            for (o, line) in noise.iter().enumerate() {
                sum[o] += window.iter().map(|k| line[*k]).sum::<f64>();
            }
        }
        let count = (window.len() * self.spectra.len()) as f64;
        Some(sum.iter().map(|s| s / count).collect())
    }
}

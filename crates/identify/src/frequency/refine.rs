//! Modes refined to the least error of the simulated outputs, at one level of excitation or at several together.
//!
//! ```text
//! G_l(z) = z⁻ⁿ·[D/z + Σ_k (R_k φ(z; ω_kl, ζ_kl) + Q_k ψ(z; ω_kl, ζ_kl))]
//! ω_kl = ω_k·(1 + shift_k·s_l),   ζ_kl = ζ_k·(1 + growth_k·s_l),   s_l = a_l^exponent
//! Σ_l Σ_lines w²·|G_measured − G|² → min,   w: strength of the inputs at the line over the rms of what is
//! not linear at the level
//! ```
//!
//! φ and ψ are the displacement and the rate of a mode over an input that is held, as the components
//! `modal-matrix` and `softening-modes` compute them. D, R and Q follow linearly for given ω and ζ: only these, shift
//! and growth are searched, by Gauss-Newton with damping (variable projection). a_l is the rms of level l over that of
//! the greatest.
//!
//! Source: G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413-432; Jacobian: L. Kaufman, BIT 15 (1975) 49-57.

use core::f64::consts::TAU;

use components::linear::Transition;
use nalgebra::{DMatrix, DVector};
use numerics::least_squares::scaled_columns;

use super::Complex;
use super::held::{HeldMode, HeldPlant, Softening};
use super::response::{FrequencyResponse, Line};
use crate::error::Error;

/// A response at one level of excitation.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// What was measured.
    pub response: FrequencyResponse,
    /// Rms of each input about its mean.
    pub rms: Vec<f64>,
}

/// Exponents that are tried: friction-like, hysteresis of a Rayleigh loop, cubic spring.
const EXPONENTS: [f64; 3] = [0.5, 1.0, 2.0];
/// Rounds of the search, and of the one that compares exponents.
const ROUNDS: usize = 30;
const QUICK: usize = 8;
/// Part of the error that a round must take for the search to go on.
const GAIN: f64 = 1e-4;
/// Greatest step of a parameter: a change of frequency or damping by so much.
const STEP: f64 = 0.3;
/// Least and greatest damping ratio.
const DAMPING: (f64, f64) = (5e-4, 20.0);
/// Greatest damped frequency over that of the highest line; and least corner over that of the lowest.
const BAND: (f64, f64) = (3.0, 1.1);
/// Bounds of shift and growth; the component holds beyond 1.5 times.
const SHIFT: (f64, f64) = (-0.5, 1.0);
const GROWTH: (f64, f64) = (-0.6, 5.0);
/// Parameters of a mode: logarithms of frequency and damping, shift, growth.
const KINDS: usize = 4;

/// The plant with its modes refined to one response.
///
/// # Errors
/// [`Error::NoSolution`] where the response has too few lines for these modes.
pub fn refined(level: &Level, start: &HeldPlant) -> Result<HeldPlant, Error> {
    let fit = Fit::new(core::slice::from_ref(level), start)?;
    let found = fit.search(Fit::start(start), 1.0, ROUNDS)?;
    Ok(fit.plant(&found, None))
}

/// The plant of small motion whose modes follow the amplitude, fitted to all levels together; `start` is a
/// plant of one of them. Two levels say nothing of the exponent: it is 1 then.
///
/// # Errors
/// [`Error::NoSolution`] for less than two levels, or too few lines.
pub fn softened(levels: &[Level], start: &HeldPlant) -> Result<HeldPlant, Error> {
    let fit = Fit::new(levels, start)?;
    if levels.len() < 2 {
        return Err(Error::no_solution("modes that follow the amplitude need two levels or more"));
    }
    let exponents = if levels.len() > 2 { &EXPONENTS[..] } else { &[1.0] };
    let mut best: Option<(f64, Found)> = None;
    for exponent in exponents {
        let found = fit.search(Fit::start(start), *exponent, QUICK)?;
        if best.as_ref().is_none_or(|(_, best)| found.squares < best.squares) {
            best = Some((*exponent, found));
        }
    }
    let (exponent, found) = best.ok_or(Error::no_solution("no exponent was tried"))?;
    let found = fit.search(found.x, exponent, ROUNDS)?;
    Ok(fit.plant(&found, Some((exponent, &levels[fit.top].rms))))
}

/// Amplitude of a level over that of the greatest: rms over the inputs, each relative to its own.
#[must_use]
pub fn relative(rms: &[f64], top: &[f64]) -> f64 {
    let squares: f64 =
        rms.iter().zip(top).filter(|(_, top)| **top > 0.0).map(|(a, top)| (a / top).powi(2)).sum();
    (squares / rms.len().max(1) as f64).sqrt()
}

/// One level as it enters.
struct Rows {
    z: Vec<Complex>,
    weight: Vec<f64>,
    amplitude: f64,
}

struct Fit {
    period: f64,
    delay: f64,
    shape: (usize, usize),
    modes: usize,
    rows: Vec<Rows>,
    count: usize,
    /// Weighted response, real above imaginary parts, level after level; a column per element, row by row.
    right: DMatrix<f64>,
    top: usize,
    lowest: f64,
    highest: f64,
}

/// A point of the search.
struct Found {
    x: DVector<f64>,
    /// φ of all modes, ψ of all modes, D; by elements.
    linear: DMatrix<f64>,
    rest: DMatrix<f64>,
    basis: DMatrix<f64>,
    squares: f64,
}

impl Fit {
    fn new(levels: &[Level], start: &HeldPlant) -> Result<Self, Error> {
        let total = |level: &Level| level.rms.iter().map(|r| r * r).sum::<f64>();
        let top = (0..levels.len())
            .max_by(|a, b| total(&levels[*a]).total_cmp(&total(&levels[*b])))
            .ok_or(Error::no_solution("there is no level"))?;
        let shape = start.direct.shape();
        let elements = shape.0 * shape.1;
        let count: usize = levels.iter().map(|l| 2 * l.response.lines.len()).sum();
        let modes = start.modes.len();
        if modes == 0 || count <= KINDS * modes + 2 * modes + 1 {
            return Err(Error::no_solution("there are fewer lines than the fit has modes"));
        }
        let mut right = DMatrix::zeros(count, elements);
        let mut rows = Vec::new();
        let mut first = 0;
        for level in levels {
            let lines = &level.response.lines;
            let are_alone = are_alone(lines);
            let weight = weights(lines);
            for (k, (line, weight)) in lines.iter().zip(&weight).enumerate() {
                let turn = Complex::from_polar(*weight, TAU * line.frequency * start.delay);
                for o in 0..shape.0 {
                    for i in 0..shape.1 {
                        let g = entering(line, are_alone)[(o, i)] * turn;
                        right[(first + k, o * shape.1 + i)] = g.re;
                        right[(first + lines.len() + k, o * shape.1 + i)] = g.im;
                    }
                }
            }
            first += 2 * lines.len();
            let z = |line: &Line| Complex::from_polar(1.0, TAU * line.frequency * start.period);
            let amplitude = relative(&level.rms, &levels[top].rms);
            rows.push(Rows { z: lines.iter().map(z).collect(), weight, amplitude });
        }
        let frequencies =
            || levels.iter().flat_map(|l| l.response.lines.iter().map(|l| l.frequency));
        Ok(Self {
            period: start.period,
            delay: start.delay,
            shape,
            modes,
            rows,
            count,
            right,
            top,
            lowest: frequencies().fold(f64::INFINITY, f64::min),
            highest: frequencies().fold(0.0, f64::max),
        })
    }

    fn start(plant: &HeldPlant) -> DVector<f64> {
        let count = plant.modes.len();
        let mut x = DVector::zeros(KINDS * count);
        for (k, mode) in plant.modes.iter().enumerate() {
            x[k] = mode.frequency.ln();
            x[count + k] = mode.damping.max(2.0 * DAMPING.0).ln();
        }
        x
    }

    /// Frequency and damping of mode k at s.
    fn mode(&self, x: &DVector<f64>, k: usize, s: f64) -> (f64, f64) {
        let m = self.modes;
        (x[k].exp() * (1.0 + x[2 * m + k] * s), x[m + k].exp() * (1.0 + x[3 * m + k] * s))
    }

    /// Whether all modes are those of a plant that the lines show.
    fn is_sound(&self, x: &DVector<f64>, from: &DVector<f64>) -> bool {
        let m = self.modes;
        // What lies outside already may stay there, and not go further.
        let sound = |k: usize, x: &DVector<f64>| {
            let within = |value: f64, (least, most): (f64, f64)| value >= least && value <= most;
            within(x[2 * m + k], SHIFT)
                && within(x[3 * m + k], GROWTH)
                && self.rows.iter().map(|rows| rows.amplitude).chain([0.0]).all(|s| {
                    let (f, d) = self.mode(x, k, s);
                    let corner = if d > 1.0 { f / (d + (d * d - 1.0).sqrt()) } else { f };
                    let damped = f * (1.0 - d * d).max(0.0).sqrt();
                    within(d, DAMPING)
                        && corner >= BAND.0 * self.lowest
                        && damped <= BAND.1 * self.highest
                        && f * self.period < 10.0
                })
        };
        x.iter().all(|x| x.is_finite())
            && (0..m).all(|k| sound(k, x) || (!sound(k, from) && self.is_same(k, x, from)))
    }

    fn is_same(&self, k: usize, a: &DVector<f64>, b: &DVector<f64>) -> bool {
        (0..KINDS).all(|kind| a[kind * self.modes + k] == b[kind * self.modes + k])
    }

    /// Weighted columns, one per function of z.
    fn columns(&self, count: usize, at: impl Fn(&Rows, &mut [Vec<Complex>])) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(self.count, count);
        let mut first = 0;
        for rows in &self.rows {
            let lines = rows.z.len();
            let mut values = vec![vec![Complex::new(0.0, 0.0); lines]; count];
            at(rows, &mut values);
            for (c, column) in values.iter().enumerate() {
                for (k, (value, weight)) in column.iter().zip(&rows.weight).enumerate() {
                    all[(first + k, c)] = weight * value.re;
                    all[(first + lines + k, c)] = weight * value.im;
                }
            }
            first += 2 * lines;
        }
        all
    }

    fn solve(&self, x: DVector<f64>, exponent: f64) -> Result<Found, Error> {
        let m = self.modes;
        let matrix = self.columns(2 * m + 1, |rows, values| {
            let s = rows.amplitude.powf(exponent);
            for k in 0..m {
                let (f, d) = self.mode(&x, k, s);
                for (line, z) in rows.z.iter().enumerate() {
                    (values[k][line], values[m + k][line]) = functions(*z, f, d, self.period);
                }
            }
            for (line, z) in rows.z.iter().enumerate() {
                values[2 * m][line] = z.inv();
            }
        });
        let mut scaled = matrix;
        let norms = scaled_columns(&mut scaled);
        let qr = scaled.qr();
        let basis = qr.q();
        let projected = basis.tr_mul(&self.right);
        let rest = &self.right - &basis * &projected;
        let squares = rest.norm_squared();
        let mut linear = projected;
        let solved = qr.r().solve_upper_triangular_mut(&mut linear);
        for mut column in linear.column_iter_mut() {
            column.component_div_assign(&norms);
        }
        if solved && squares.is_finite() && linear.iter().all(|x| x.is_finite()) {
            Ok(Found { x, linear, rest, basis, squares })
        } else {
            Err(Error::no_solution("two modes of the fit are one; fit fewer modes"))
        }
    }

    /// Normal equations of the reduced problem at a point: matrix and right side.
    fn normal(&self, found: &Found, exponent: f64) -> (DMatrix<f64>, DVector<f64>) {
        const H: f64 = 1e-6;
        let (m, p) = (self.modes, KINDS * self.modes);
        let x = &found.x;
        // What φ, then ψ, does with each parameter.
        let slopes = self.columns(2 * p, |rows, values| {
            let s = rows.amplitude.powf(exponent);
            for k in 0..m {
                let (f, d) = self.mode(x, k, s);
                let (by_shift, by_growth) =
                    (s / (1.0 + x[2 * m + k] * s), s / (1.0 + x[3 * m + k] * s));
                for (line, z) in rows.z.iter().enumerate() {
                    let at = |f: f64, d: f64| functions(*z, f, d, self.period);
                    let (up, down) = (at(f * (1.0 + H), d), at(f * (1.0 - H), d));
                    let (more, less) = (at(f, d * (1.0 + H)), at(f, d * (1.0 - H)));
                    let of = |a: Complex, b: Complex| (a - b) / (2.0 * H);
                    let each = [
                        (of(up.0, down.0), of(more.0, less.0)),
                        (of(up.1, down.1), of(more.1, less.1)),
                    ];
                    for (half, (by_f, by_d)) in each.into_iter().enumerate() {
                        values[half * p + k][line] = by_f;
                        values[half * p + m + k][line] = by_d;
                        values[half * p + 2 * m + k][line] = by_f * by_shift;
                        values[half * p + 3 * m + k][line] = by_d * by_growth;
                    }
                }
            }
        });
        let reduced = &slopes - &found.basis * found.basis.tr_mul(&slopes);
        let transposed = reduced.transpose();
        let gram = &transposed * &reduced;
        let pulls = transposed * &found.rest;
        let mut matrix = DMatrix::zeros(p, p);
        let mut right = DVector::zeros(p);
        for e in 0..found.rest.ncols() {
            let r = |row: usize| found.linear[(row % m, e)];
            let q = |row: usize| found.linear[(m + row % m, e)];
            for a in 0..p {
                right[a] += r(a) * pulls[(a, e)] + q(a) * pulls[(p + a, e)];
                for b in 0..p {
                    matrix[(a, b)] += r(a) * (gram[(a, b)] * r(b) + gram[(a, p + b)] * q(b))
                        + q(a) * (gram[(p + a, b)] * r(b) + gram[(p + a, p + b)] * q(b));
                }
            }
        }
        (matrix, right)
    }

    fn search(&self, x: DVector<f64>, exponent: f64, rounds: usize) -> Result<Found, Error> {
        let mut found = self.solve(x, exponent)?;
        let follows = self.rows.len() > 1;
        let mut caution = 1e-3;
        for _ in 0..rounds {
            let (matrix, right) = self.normal(&found, exponent);
            let p = right.len();
            let greatest = matrix.diagonal().max();
            // Parameters without influence, such as shifts at one level, stay.
            let fixed =
                |k: usize| matrix[(k, k)] <= 1e-24 * greatest || (!follows && k >= 2 * self.modes);
            let scale: Vec<f64> = (0..p).map(|k| matrix[(k, k)].sqrt()).collect();
            let mut next = None;
            for _ in 0..8 {
                let system = DMatrix::from_fn(p, p, |a, b| match (fixed(a) || fixed(b), a == b) {
                    (true, true) => 1.0,
                    (true, false) => 0.0,
                    (false, same) => {
                        matrix[(a, b)] / (scale[a] * scale[b]) + if same { caution } else { 0.0 }
                    }
                });
                let pull =
                    DVector::from_fn(p, |k, _| if fixed(k) { 0.0 } else { right[k] / scale[k] });
                let step = system.cholesky().map(|c| c.solve(&pull));
                let moved = step.map(|step| {
                    DVector::from_fn(p, |k, _| {
                        let way =
                            if fixed(k) { 0.0 } else { (step[k] / scale[k]).clamp(-STEP, STEP) };
                        found.x[k] + way
                    })
                });
                let moved = moved.map(|moved| self.within(moved, &found.x));
                if let Some(moved) = moved
                    && self.is_sound(&moved, &found.x)
                    && let Ok(tried) = self.solve(moved, exponent)
                    && tried.squares < found.squares
                {
                    next = Some(tried);
                    break;
                }
                caution *= 5.0;
            }
            let Some(next) = next else { break };
            let gain = 1.0 - next.squares / found.squares;
            found = next;
            caution = (caution / 5.0).max(1e-8);
            if gain < GAIN {
                break;
            }
        }
        Ok(found)
    }

    /// The point with each mode that would leave its bounds where it was.
    fn within(&self, mut x: DVector<f64>, from: &DVector<f64>) -> DVector<f64> {
        for k in 0..self.modes {
            let mut alone = from.clone();
            for kind in 0..KINDS {
                alone[kind * self.modes + k] = x[kind * self.modes + k];
            }
            if !self.is_sound(&alone, from) {
                for kind in 0..KINDS {
                    x[kind * self.modes + k] = from[kind * self.modes + k];
                }
            }
        }
        x
    }

    /// The plant of small motion; with one level that of the level.
    fn plant(&self, found: &Found, follows: Option<(f64, &Vec<f64>)>) -> HeldPlant {
        let (m, x) = (self.modes, &found.x);
        let matrix = |row: usize| {
            DMatrix::from_fn(self.shape.0, self.shape.1, |o, i| {
                found.linear[(row, o * self.shape.1 + i)]
            })
        };
        let mut order: Vec<usize> = (0..m).collect();
        order.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
        let modes = order.iter().map(|&k| {
            let (frequency, damping) = self.mode(x, k, 0.0);
            HeldMode { frequency, damping, residue: matrix(k), rate_residue: matrix(m + k) }
        });
        let softening = follows.map(|(exponent, rms)| Softening {
            shift: order.iter().map(|k| x[2 * m + k]).collect(),
            growth: order.iter().map(|k| x[3 * m + k]).collect(),
            exponent,
            rms: rms.clone(),
        });
        let (period, delay) = (self.period, self.delay);
        HeldPlant { period, direct: matrix(2 * m), modes: modes.collect(), delay, softening }
    }
}

/// Displacement and rate of a mode under an input that is held, over the input, at a z.
pub(super) fn functions(
    z: Complex,
    frequency: f64,
    damping: f64,
    period: f64,
) -> (Complex, Complex) {
    let t = Transition::new(frequency, damping, period);
    let rest = 1.0 - t.same;
    let (same, rate) = (z - t.same, z - t.rate);
    let inverse = (same * rate + t.cross * t.cross).inv();
    ((rate * rest + t.cross * t.cross) * inverse, (same * t.cross - t.cross * rest) * inverse)
}

/// Whether each line says something alone.
fn are_alone(lines: &[Line]) -> bool {
    lines.iter().all(|line| line.alone.is_some())
}

/// What a line is fitted by: what it says alone, as the local polynomials cut narrow resonances; where lines say nothing
/// of their own, the polynomials' response.
fn entering(line: &Line, are_alone: bool) -> &DMatrix<Complex> {
    let alone = line.alone.as_ref().filter(|_| are_alone);
    alone.map_or(&line.response, |alone| &alone.response)
}

/// Weight of each line: how strongly the inputs act there, over the rms of what is not linear.
fn weights(lines: &[Line]) -> Vec<f64> {
    // The deviation of the polynomials' response is what is not linear over the strength of the inputs.
    let by_deviation = |line: &Line| {
        let (outputs, inputs) = line.deviation.shape();
        let ratios = (0..outputs).flat_map(|o| (0..inputs).map(move |i| (o, i)));
        let sum: f64 = ratios.map(|(o, i)| line.total[o] / line.deviation[(o, i)]).sum();
        sum / (outputs * inputs).max(1) as f64
    };
    let are_alone = are_alone(lines);
    let strength = |line: &Line| match &line.alone {
        Some(alone) if are_alone => alone.strength,
        _ => by_deviation(line),
    };
    let mut strengths: Vec<f64> = lines.iter().map(strength).collect();
    // A response without any scatter.
    if !strengths.iter().all(|s| s.is_finite() && *s > 0.0) {
        strengths.fill(1.0);
    }
    let squares: f64 = lines.iter().flat_map(|l| &l.total).map(|t| t * t).sum();
    let count = lines.iter().map(|l| l.total.len()).sum::<usize>().max(1);
    let rms = (squares / count as f64).sqrt();
    let scale = if rms > 0.0 { 1.0 / rms } else { 1.0 };
    strengths.iter().map(|s| s * scale).collect()
}

#[cfg(test)]
mod tests;

//! Vector fitting: the poles move to where a common denominator of all elements is zero.
//!
//! ```text
//! (σ(x)·G(x)) ≈ Σ c_k φ_k(x) + d,   σ(x) = Σ c̃_k φ_k(x) + d̃,   new poles = zeros of σ
//! ```
//!
//! Linear least squares each round; the condition that σ does not vanish is the relaxed one.
//!
//! Source: B. Gustavsen, A. Semlyen, IEEE Trans. Power Delivery 14 (1999) 1052-1061; relaxed: B. Gustavsen,
//! ibid. 21 (2006) 1587-1592; one QR per element: D. Deschrijver et al., IEEE Microw. Wireless
//! Compon. Lett. 18 (2008) 383-385.

use nalgebra::{DMatrix, DVector};
use numerics::least_squares::of_full_rank;
use numerics::qr::triangle;
use rayon::prelude::*;

use super::Complex;
use super::rational::{Domain, Rational};
use crate::error::Error;

/// Why poles are not found.
const COINCIDENT: Error = Error::no_solution("the fit's poles coincide");

/// Samples of a transfer matrix with weights.
pub(super) struct Samples<'a> {
    /// x of each line.
    pub(super) variable: &'a [Complex],
    /// Response of each line, its delay taken off.
    pub(super) response: &'a [DMatrix<Complex>],
    /// Weight of each element of each line.
    pub(super) weight: &'a [DMatrix<f64>],
}

impl Samples<'_> {
    /// Row and column of each element, column by column.
    fn elements(&self) -> Vec<(usize, usize)> {
        let (rows, columns) = self.response[0].shape();
        (0..columns).flat_map(|i| (0..rows).map(move |o| (o, i))).collect()
    }

    /// Weight and weighted response of an element, line by line.
    fn of(&self, place: (usize, usize)) -> (Vec<f64>, Vec<Complex>) {
        let weighted = self.weight.iter().zip(self.response);
        weighted.map(|(weight, g)| (weight[place], g[place] * weight[place])).unzip()
    }
}

/// Partial fractions with real coefficients.
#[derive(Clone, Debug)]
pub(super) struct Basis {
    pub(super) domain: Domain,
    pub(super) poles: Vec<Complex>,
}

impl Basis {
    /// Coefficients without the constant.
    pub(super) fn width(&self) -> usize {
        self.poles.iter().map(|p| if p.im == 0.0 { 1 } else { 2 }).sum()
    }

    /// Each pole with the place of its first coefficient.
    pub(super) fn places(&self) -> impl Iterator<Item = (usize, &Complex)> {
        self.poles.iter().scan(0, |place, pole| {
            let at = *place;
            *place += if pole.im == 0.0 { 1 } else { 2 };
            Some((at, pole))
        })
    }

    /// φ_1 … φ_n and 1.
    fn at(&self, x: Complex) -> Vec<Complex> {
        let mut row = Vec::with_capacity(self.width() + 1);
        for pole in &self.poles {
            let one = (x - pole).inv();
            if pole.im == 0.0 {
                row.push(one);
            } else {
                let other = (x - pole.conj()).inv();
                row.push(one + other);
                row.push(Complex::i() * (one - other));
            }
        }
        row.push(Complex::new(1.0, 0.0));
        row
    }

    /// φ_1 … φ_n and 1 at each x, a row each.
    fn on(&self, variable: &[Complex]) -> DMatrix<Complex> {
        let rows = variable.iter().flat_map(|x| self.at(*x));
        DMatrix::from_row_iterator(variable.len(), self.width() + 1, rows)
    }

    /// The zeros of d + Σ c_k φ_k.
    fn zeros(&self, c: &[f64]) -> Vec<Complex> {
        let n = self.width();
        let d = c[n];
        let mut a = DMatrix::<f64>::zeros(n, n);
        let mut b = DVector::<f64>::zeros(n);
        for (place, pole) in self.places() {
            if pole.im == 0.0 {
                a[(place, place)] = pole.re;
                b[place] = 1.0;
            } else {
                a[(place, place)] = pole.re;
                a[(place, place + 1)] = pole.im;
                a[(place + 1, place)] = -pole.im;
                a[(place + 1, place + 1)] = pole.re;
                b[place] = 2.0;
            }
        }
        for row in 0..n {
            for (column, c) in c.iter().take(n).enumerate() {
                a[(row, column)] -= b[row] * c / d;
            }
        }
        a.complex_eigenvalues().iter().copied().collect()
    }

    /// The transfer matrix of these coefficients, one vector per element, columns first.
    fn rational(
        &self,
        (rows, columns): (usize, usize),
        elements: &[Vec<f64>],
        delay: f64,
    ) -> Rational {
        let element = |o: usize, i: usize| &elements[i * rows + o];
        let residue = |place: usize, pole: &Complex| {
            DMatrix::from_fn(rows, columns, |o, i| {
                let c = element(o, i);
                let imaginary = if pole.im == 0.0 { 0.0 } else { c[place + 1] };
                Complex::new(c[place], imaginary)
            })
        };
        let residues = self.places().map(|(place, pole)| residue(place, pole)).collect();
        let last = self.width();
        Rational {
            domain: self.domain,
            poles: self.poles.clone(),
            residues,
            direct: DMatrix::from_fn(rows, columns, |o, i| element(o, i)[last]),
            delay,
        }
    }
}

/// Rows of the least squares: real parts above imaginary parts.
fn stacked(rows: usize, columns: usize, value: impl Fn(usize, usize) -> Complex) -> DMatrix<f64> {
    let mut stacked = DMatrix::zeros(2 * rows, columns);
    for (c, mut column) in stacked.column_iter_mut().enumerate() {
        for r in 0..rows {
            let value = value(r, c);
            (column[r], column[rows + r]) = (value.re, value.im);
        }
    }
    stacked
}

/// One round: the poles moved.
pub(super) fn relocated(basis: &Basis, samples: &Samples<'_>) -> Result<Basis, Error> {
    let n = basis.width();
    let phi = basis.on(samples.variable);
    let lines = phi.nrows();
    let elements = samples.elements();
    // What each element says about σ; and that σ is one on average.
    let mut stack = DMatrix::zeros(elements.len() * (n + 1) + 1, n + 1);
    let mut scale = 0.0_f64;
    let element = |&place: &(usize, usize)| {
        let (weight, response) = samples.of(place);
        let both = stacked(lines, 2 * (n + 1), |k, c| match c.checked_sub(n + 1) {
            None => phi[(k, c)] * weight[k],
            Some(c) => -phi[(k, c)] * response[k],
        });
        (triangle(both), response.iter().map(Complex::norm_sqr).sum())
    };
    let triangles: Vec<(DMatrix<f64>, f64)> = elements.par_iter().map(element).collect();
    for (e, (triangle, power)) in triangles.iter().enumerate() {
        scale += power;
        for r in 0..=n {
            for c in 0..=n {
                if let (Some(x), true) = (at(triangle, n + 1 + r, n + 1 + c), r <= c) {
                    stack[(e * (n + 1) + r, c)] = x;
                }
            }
        }
    }
    let strength = scale.sqrt() / lines as f64;
    let last = elements.len() * (n + 1);
    for c in 0..=n {
        stack[(last, c)] = strength * phi.column(c).iter().map(|x| x.re).sum::<f64>();
    }
    let mut right = DVector::zeros(last + 1);
    right[last] = strength * lines as f64;
    let (mut c, _) = of_full_rank(stack, &right).ok_or(COINCIDENT)?;
    // A σ without its constant has no zeros to go to.
    let least = 1e-8;
    if c[n].abs() < least {
        c[n] = least.copysign(c[n]);
    }
    let mut poles = Vec::new();
    for zero in basis.zeros(&c) {
        if !(zero.re.is_finite() && zero.im.is_finite()) {
            return Err(Error::no_solution("the poles of the fit went to infinity"));
        }
        let zero = basis.domain.stable(zero);
        if zero.im.abs() < 1e-9 * zero.norm() {
            poles.push(Complex::new(zero.re, 0.0));
        } else if zero.im > 0.0 {
            poles.push(zero);
        }
    }
    poles.sort_by(|a, b| a.im.total_cmp(&b.im));
    Ok(Basis { domain: basis.domain, poles })
}

fn at(matrix: &DMatrix<f64>, row: usize, column: usize) -> Option<f64> {
    (row < matrix.nrows() && column < matrix.ncols()).then(|| matrix[(row, column)])
}

/// Residues and direct term for given poles, and the weighted mean square of what is left.
pub(super) fn residues(
    basis: &Basis,
    samples: &Samples<'_>,
    delay: f64,
) -> Result<(Rational, f64), Error> {
    let phi = basis.on(samples.variable);
    let lines = phi.nrows();
    let element = |&place: &(usize, usize)| {
        let (weight, response) = samples.of(place);
        let matrix = stacked(lines, phi.ncols(), |k, c| phi[(k, c)] * weight[k]);
        let right = stacked(lines, 1, |k, _| response[k]).column(0).into_owned();
        of_full_rank(matrix, &right).ok_or(COINCIDENT)
    };
    let fitted = samples.elements().par_iter().map(element).collect::<Result<Vec<_>, Error>>()?;
    let sum: f64 = fitted.iter().map(|(_, squares)| squares).sum();
    let all: Vec<Vec<f64>> = fitted.into_iter().map(|(c, _)| c).collect();
    let count = (lines * all.len()) as f64;
    Ok((basis.rational(samples.response[0].shape(), &all, delay), sum / count))
}

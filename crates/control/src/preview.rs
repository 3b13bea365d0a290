//! The inverse of axes whose coupling has dynamics: a matrix of filters that know the reference ahead.
//!
//! ```text
//! F(ω) = (Σ Mᴴ·M/P + ρ)⁻¹·Σ Mᴴ/P     over P plants: the mean square of M·F − 1 is least
//! ρ = 0.001/cos²(ω·T/2) + 0.03·max(0, ‖M‖²/n − 1)   n axes: 0.001 at rest, more where resonances make the axes
//!                                    unlike, and towards half the sample rate, up to which no model is right
//! taps = F of −d to a periods, d periods late
//! ```
//!
//! M as of the coupled loop. The plants: the modes' frequencies as given, 1 and 2 % lower and higher, each time at which
//! a command may act. Where a resonance moves, the mean keeps the filter from answering it in full; where
//! one mode outweighs the others, ρ keeps it from asking for large commands to move the weak direction. d and a are the
//! shortest whose error on all plants and frequencies is within 2 % of the least that was found.
//!
//! Source: O. Kirkeby, P. A. Nelson, H. Hamada, F. Orduna-Bustamante, IEEE Trans. Speech Audio Process. 6 (1998)
//! 189–194 (inverse of several channels by least squares in the frequency domain).

use core::f64::consts::{PI, TAU};

use nalgebra::{Complex, DMatrix};
use numerics::fft::Fft;
use serde::Serialize;

/// Factors of the modes' frequencies.
pub(crate) const SHIFTS: [f64; 5] = [1.0, 0.98, 0.99, 1.01, 1.02];
/// Lines of the transform.
const LINES: usize = 1 << 12;
/// Lines between those that are judged.
const APART: usize = 3;
/// Least square of the cosine.
const LEAST: f64 = 1e-9;
/// Weight of the filter itself: at low frequencies, and per mean square of the plants beyond that at rest.
const WEIGHTS: (f64, f64) = (1e-3, 0.03);
/// Periods ahead and behind that are tried.
const LENGTHS: [usize; 6] = [8, 16, 32, 64, 128, 256];
/// Factor of the least error up to which a shorter filter is taken.
const SHORTER: f64 = 1.02;

/// What is known of such an inverse.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PreviewFigures {
    /// By how much the position follows the reference input late, in s.
    pub preview: f64,
    /// Number of taps, each a matrix.
    pub taps: usize,
    /// Root mean square of what is left of a white reference, in parts of it: the plant as given, and all plants.
    pub left: (f64, f64),
}

/// The inverse.
#[derive(Clone, Debug)]
pub(crate) struct Preview {
    /// Row by row, tap after tap.
    pub(crate) taps: Vec<f64>,
    pub(crate) ahead: usize,
    pub(crate) figures: PreviewFigures,
}

/// The inverse of plants with these impulse responses, `[plant][command][motion]`, the plant as given first; `later`:
/// for each time at which a command acts whether it is a period later.
pub(crate) fn inverse(
    responses: &[Vec<Vec<Vec<f64>>>],
    slopes: &[f64],
    later: &[bool],
    period: f64,
) -> Preview {
    let n = slopes.len();
    let forward = Fft::forward(LINES);
    let plants: Vec<Vec<DMatrix<Complex<f64>>>> = responses
        .iter()
        .flat_map(|plant| later.iter().map(move |later| (plant, *later)))
        .map(|(plant, later)| spectrum(plant, slopes, later, &forward))
        .collect();
    let count = plants.len() as f64;
    let bins = LINES / 2 + 1;
    let unit = DMatrix::<Complex<f64>>::identity(n, n);
    let filter: Vec<DMatrix<Complex<f64>>> = (0..bins)
        .map(|bin| {
            let (mut square, mut sum) =
                (unit.map(|_| Complex::default()), unit.map(|_| Complex::default()));
            for plant in &plants {
                let back = plant[bin].adjoint();
                square += &back * &plant[bin] / Complex::new(count, 0.0);
                sum += back / Complex::new(count, 0.0);
            }
            let cosine = (PI * bin as f64 / LINES as f64).cos().powi(2).max(LEAST);
            let beyond = (square.trace().re / n as f64 - 1.0).max(0.0);
            square += &unit * Complex::new(WEIGHTS.0 / cosine + WEIGHTS.1 * beyond, 0.0);
            square.lu().solve(&sum).unwrap_or_else(|| unit.clone())
        })
        .collect();
    let inverse = Fft::inverse(LINES);
    // Of each entry, the response from −LINES/2 on, going round.
    let complete: Vec<Vec<f64>> = (0..n * n)
        .map(|at| {
            let mut lines = vec![Complex::new(0.0, 0.0); LINES];
            for (bin, matrix) in filter.iter().enumerate() {
                let value = matrix[(at / n, at % n)];
                let real = bin == 0 || bin == LINES / 2;
                lines[bin] = if real { Complex::new(value.re, 0.0) } else { value };
                lines[(LINES - bin) % LINES] = lines[bin].conj();
            }
            inverse.process(&mut lines);
            lines.iter().map(|line| line.re / LINES as f64).collect()
        })
        .collect();
    let cut = |ahead: usize, behind: usize| -> Vec<f64> {
        let taps = 0..ahead + behind;
        taps.flat_map(|tap| complete.iter().map(move |entry| entry[(LINES + tap - ahead) % LINES]))
            .collect()
    };
    let mut tried: Vec<(usize, usize, f64)> = Vec::new();
    for ahead in LENGTHS {
        for behind in LENGTHS {
            let found = left(&plants, &cut(ahead, behind), ahead, n, &forward);
            tried.push((ahead, behind, mean(&found)));
        }
    }
    let least = tried.iter().map(|(_, _, error)| *error).fold(f64::INFINITY, f64::min);
    tried.retain(|(_, _, error)| *error <= SHORTER * least);
    let shortest = tried.iter().min_by_key(|(ahead, behind, _)| (ahead + behind, *ahead));
    let (ahead, behind) =
        shortest.map_or((LENGTHS[0], LENGTHS[0]), |(ahead, behind, _)| (*ahead, *behind));
    let taps = cut(ahead, behind);
    let errors = left(&plants, &taps, ahead, n, &forward);
    let figures = PreviewFigures {
        preview: ahead as f64 * period,
        taps: ahead + behind,
        left: (mean(&errors[..later.len()]), mean(&errors)),
    };
    Preview { taps, ahead, figures }
}

/// M at each line, with the command acting at once or a period later.
fn spectrum(
    plant: &[Vec<Vec<f64>>],
    slopes: &[f64],
    later: bool,
    forward: &Fft,
) -> Vec<DMatrix<Complex<f64>>> {
    let n = slopes.len();
    let entries: Vec<Vec<Complex<f64>>> = (0..n * n)
        .map(|at| {
            let mut folded = vec![0.0; LINES];
            for (k, h) in (1 + usize::from(later)..).zip(&plant[at % n][at / n]) {
                folded[k % LINES] += h / slopes[at % n];
            }
            let lines = forward.of_real(&folded);
            lines.iter().map(|line| Complex::new(line.re, line.im)).collect()
        })
        .collect();
    (0..=LINES / 2).map(|bin| DMatrix::from_fn(n, n, |i, j| entries[i * n + j][bin])).collect()
}

/// Mean square of what is left of a white reference on each plant.
fn left(
    plants: &[Vec<DMatrix<Complex<f64>>>],
    taps: &[f64],
    ahead: usize,
    n: usize,
    forward: &Fft,
) -> Vec<f64> {
    let entries: Vec<Vec<Complex<f64>>> = (0..n * n)
        .map(|at| {
            let mut response: Vec<f64> = taps.iter().skip(at).step_by(n * n).copied().collect();
            response.resize(LINES, 0.0);
            let lines = forward.of_real(&response);
            lines.iter().map(|line| Complex::new(line.re, line.im)).collect()
        })
        .collect();
    let each = plants.iter().map(|plant| {
        let sum: f64 = plant
            .iter()
            .enumerate()
            .step_by(APART)
            .map(|(bin, matrix)| {
                let late =
                    Complex::from_polar(1.0, -TAU * (bin * ahead % LINES) as f64 / LINES as f64);
                let filter = DMatrix::from_fn(n, n, |i, j| entries[i * n + j][bin]);
                let mut error = matrix * filter;
                for axis in 0..n {
                    error[(axis, axis)] -= late;
                }
                error.iter().map(Complex::norm_sqr).sum::<f64>()
            })
            .sum();
        sum / (n * plant.len().div_ceil(APART)) as f64
    });
    each.collect()
}

/// Root of the mean.
fn mean(squares: &[f64]) -> f64 {
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_with_delay_are_inverted_but_for_the_weight_in_closed_form() {
        // Two axes with 3 and 1 periods of delay and slopes 2 and −4: F = 1/(1 + ρ), and what is left is ρ/(1 + ρ) with
        // ρ = a/cos²x, whose mean square over x is a²·(1 + 2a)/(2·(a + a²)^1.5).
        let plant = |across: f64| {
            vec![vec![vec![0.0, 0.0, 2.0], vec![0.0, 0.0, across]], vec![vec![0.0], vec![-4.0]]]
        };
        let found = inverse(&[plant(0.0)], &[2.0, -4.0], &[false], 1e-3);
        let a = WEIGHTS.0;
        let exact = (a * a * (1.0 + 2.0 * a) / (2.0 * (a + a * a).powf(1.5))).sqrt();
        // Of few taps less is left: they cannot follow the weight at half the sample rate.
        let left = found.figures.left.0;
        assert!(left > 0.5 * exact && left < 1.01 * exact, "{:?} {exact}", found.figures);
        // With half of the first's motion on the second, at rest: (Mᵀ·M + ρ)⁻¹·Mᵀ of M = [1, 0; 0.5, 1], whose mean
        // square is 1.125 per axis.
        let found = inverse(&[plant(1.0)], &[2.0, -4.0], &[false], 1e-3);
        let rho = WEIGHTS.0 + 0.125 * WEIGHTS.1;
        let determinant = (1.25 + rho) * (1.0 + rho) - 0.25;
        let wanted = [1.0 + rho, 0.5 * rho, -0.5, 1.0 + rho].map(|x| x / determinant);
        for (at, wanted) in wanted.iter().enumerate() {
            let sum = found.taps.iter().skip(at).step_by(4).sum::<f64>();
            assert!((sum - wanted).abs() < 4e-3, "{at}: {sum} {wanted}");
        }
    }
}

//! The plants at the lines of a Fourier transform.

use core::f64::consts::TAU;

use nalgebra::{Complex, DMatrix};
use numerics::fft::Fft;

use crate::loop_shape::transfer;

/// Fewest and most lines of a transform.
const LINES: (usize, usize) = (1 << 14, 1 << 17);
/// Change of the plant between neighbouring lines of the search, and the greatest ratio of their frequencies.
const APART: (f64, f64) = (0.08, 1.15);
/// Frequencies below the first line, and their ratio.
const BELOW: (i32, f64) = (24, 1.3);

/// A plant at a frequency.
pub(super) struct Line {
    pub(super) back: Complex<f64>,
    /// M, row by row, with the command acting at once.
    pub(super) matrix: Vec<Complex<f64>>,
    /// Bounds of its singular values: the norm, and 1 over that of the inverse.
    pub(super) most: f64,
    pub(super) least: f64,
}

impl Line {
    fn new(back: Complex<f64>, matrix: Vec<Complex<f64>>, n: usize) -> Self {
        let norm =
            |values: &[Complex<f64>]| values.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
        let inverse = DMatrix::from_row_slice(n, n, &matrix).try_inverse();
        let least = inverse.map_or(0.0, |inverse| 1.0 / norm(inverse.as_slice()));
        Self {
            back,
            most: norm(&matrix),
            least: if least.is_finite() { least } else { 0.0 },
            matrix,
        }
    }
}

/// A plant at all lines, from low frequencies on; `responses[column][row]`.
pub(super) fn lines(responses: &[Vec<Vec<f64>>], slopes: &[f64]) -> Vec<Line> {
    let n = slopes.len();
    let longest = responses.iter().flatten().map(Vec::len).max().unwrap_or(1);
    let length = (2 * longest).next_power_of_two().clamp(LINES.0, LINES.1);
    let transform = Fft::forward(length);
    let spectra: Vec<Vec<Vec<Complex<f64>>>> = responses
        .iter()
        .zip(slopes)
        .map(|(rows, slope)| {
            let row = |response: &Vec<f64>| {
                let mut folded = vec![0.0; length];
                for (k, h) in (1..).zip(response) {
                    folded[k % length] += h / slope;
                }
                transform
                    .of_real(&folded)
                    .iter()
                    .map(|line| Complex::new(line.re, line.im))
                    .collect()
            };
            rows.iter().map(row).collect()
        })
        .collect();
    let step = TAU / length as f64;
    let mut lines: Vec<Line> = (1..=BELOW.0)
        .rev()
        .map(|k| {
            let angle = step * BELOW.1.powi(-k);
            let ahead = Complex::from_polar(1.0, angle);
            let entry =
                |at: usize| transfer(&responses[at % n][at / n], angle) * ahead / slopes[at % n];
            Line::new(ahead.conj(), (0..n * n).map(entry).collect(), n)
        })
        .collect();
    lines.extend((1..=length / 2).map(|bin| {
        let matrix = (0..n * n).map(|at| spectra[at % n][at / n][bin]).collect();
        Line::new(Complex::from_polar(1.0, -step * bin as f64), matrix, n)
    }));
    lines
}

/// Those lines between which the plant changes.
pub(super) fn thinned(lines: &[Line]) -> Vec<Line> {
    let mut kept: Vec<Line> = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let changes = kept.last().is_none_or(|last| {
            let apart =
                line.matrix.iter().zip(&last.matrix).map(|(a, b)| (a - b).norm_sqr()).sum::<f64>();
            apart.sqrt() > APART.0 * last.most || line.back.arg() < APART.1 * last.back.arg()
        });
        // The peaks too.
        let near = lines.get(at.wrapping_sub(1)).zip(lines.get(at + 1));
        let is_peak = near.is_some_and(|(a, b)| line.most > a.most && line.most >= b.most);
        if changes || is_peak || at + 1 == lines.len() {
            let Line { back, most, least, ref matrix } = *line;
            kept.push(Line { back, most, least, matrix: matrix.clone() });
        }
    }
    kept
}

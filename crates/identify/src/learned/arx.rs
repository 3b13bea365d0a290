//! The linear part behind a learned hysteresis.
//!
//! ```text
//! y(t) = Σ b_i h(t−i) − Σ a_j y(t−j)
//! ```
//!
//! The equation error gives the start, the error of the simulation the result.

use nalgebra::{Complex, DMatrix, DVector};

use numerics::levenberg_marquardt::{PATIENT, Unknown, minimise};

use crate::error::Error;

/// A rational transfer function in the backward shift.
#[derive(Clone, Debug, PartialEq)]
pub struct Arx {
    /// b_0, b_1, …
    pub b: Vec<f64>,
    /// a_1, a_2, …
    pub a: Vec<f64>,
}

/// Greatest magnitude of a pole that counts as stable.
const STABLE: f64 = 1.0 - 1e-9;
/// Frequencies at which a bandwidth is looked for.
const FREQUENCIES: usize = 2000;
/// Repetitions of the linear start.
const REPEATS: usize = 8;

impl Arx {
    /// A first-order lag of this bandwidth in Hz, sampled exactly under commands that are held.
    #[must_use]
    pub fn lag(bandwidth: f64, period: f64) -> Self {
        let keep = (-core::f64::consts::TAU * bandwidth * period).exp();
        Self { b: vec![1.0 - keep], a: vec![-keep] }
    }

    /// Fits `zeros` + 1 numerator and `poles` denominator coefficients.
    ///
    /// # Errors
    /// [`Error::NoSolution`] where the record does not determine them.
    pub fn fit(input: &[f64], output: &[f64], zeros: usize, poles: usize) -> Result<Self, Error> {
        let first = output.first().copied().unwrap_or(0.0);
        Self::fit_all(&[(input, output, first)], zeros, poles)
    }

    /// Fits the coefficients to several records of input and output, each from rest with its position before the
    /// first sample.
    ///
    /// # Errors
    /// [`Error::NoSolution`] where the records do not determine them.
    pub fn fit_all(
        records: &[(&[f64], &[f64], f64)],
        zeros: usize,
        poles: usize,
    ) -> Result<Self, Error> {
        let start = Self::by_equation_error(records, zeros, poles)?;
        let unknowns: Vec<Unknown> = start
            .b
            .iter()
            .chain(&start.a)
            .map(|x| Unknown { start: *x, lower: x - 4.0, upper: x + 4.0 })
            .collect();
        let of = |p: &[f64]| Self { b: p[..=zeros].to_vec(), a: p[zeros + 1..].to_vec() };
        let errors = |tried: &Self| -> Vec<f64> {
            let of = |(input, output, y0): &(&[f64], &[f64], f64)| {
                let run = tried.simulate(input, *y0);
                run.iter().zip(*output).map(|(s, y)| (s - y).clamp(-1e3, 1e3)).collect::<Vec<_>>()
            };
            records.iter().flat_map(of).collect()
        };
        let squares = |tried: &Self| errors(tried).iter().map(|e| e * e).sum::<f64>();
        let residuals = |p: &[f64]| Ok(errors(&of(p)));
        let Ok(minimum) = minimise::<Error>(&unknowns, PATIENT, residuals, |_| ()) else {
            return Ok(start);
        };
        let fitted = of(&minimum.parameters);
        let (before, after) = (squares(&start), squares(&fitted));
        Ok(if after < before || before.is_nan() { fitted } else { start })
    }

    /// This one and another behind it.
    #[must_use]
    pub fn then(&self, other: &Self) -> Self {
        let product = |x: &[f64], y: &[f64]| {
            let mut all = vec![0.0; x.len() + y.len() - 1];
            for (i, x) in x.iter().enumerate() {
                for (j, y) in y.iter().enumerate() {
                    all[i + j] += x * y;
                }
            }
            all
        };
        let denominator = |arx: &Self| [&[1.0][..], &arx.a].concat();
        let a = product(&denominator(self), &denominator(other)).split_off(1);
        Self { b: product(&self.b, &other.b), a }
    }

    /// Whether a bounded input gives a bounded output: every zero of zⁿ + a_1 zⁿ⁻¹ + … lies inside the
    /// unit circle.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.a.iter().all(|a| a.is_finite()) && self.poles().iter().all(|p| p.norm() < STABLE)
    }

    /// The zeros of zⁿ + a_1 zⁿ⁻¹ + …, for finite coefficients.
    #[must_use]
    pub fn poles(&self) -> Vec<Complex<f64>> {
        let n = self.a.len();
        if n == 0 {
            return Vec::new();
        }
        let companion = DMatrix::from_fn(n, n, |r, c| match (r, c) {
            (0, c) => -self.a[c],
            (r, c) => f64::from(u8::from(r == c + 1)),
        });
        companion.complex_eigenvalues().iter().copied().collect()
    }

    /// Gain at rest.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.b.iter().sum::<f64>() / (1.0 + self.a.iter().sum::<f64>())
    }

    /// Least frequency in Hz at which the gain is 3 dB below that at rest; `None` where there is none up
    /// to half the sample rate.
    #[must_use]
    pub fn bandwidth(&self, period: f64) -> Option<f64> {
        let at = |angle: f64| {
            let back = Complex::from_polar(1.0, -angle);
            let sum = |x: &[f64]| x.iter().rev().fold(Complex::from(0.0), |s, x| s * back + x);
            sum(&self.b) / (1.0 + back * sum(&self.a))
        };
        let limit = self.gain().abs() * core::f64::consts::FRAC_1_SQRT_2;
        let angles =
            (1..=FREQUENCIES).map(|k| core::f64::consts::PI * k as f64 / FREQUENCIES as f64);
        let angle = angles.into_iter().find(|angle| at(*angle).norm() < limit)?;
        Some(angle / (core::f64::consts::TAU * period))
    }

    /// What undoes it: h(t) = (y(t) + Σ a_j y(t−j) − Σ b_i h(t−i))/b_0. It may be unstable.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let first = self.b.first().copied().unwrap_or(1.0);
        let b = core::iter::once(&1.0).chain(&self.a).map(|a| a / first).collect();
        Self { b, a: self.b.iter().skip(1).map(|b| b / first).collect() }
    }

    /// The orders of least error in simulation on the last third of the record, among those whose fit to
    /// the first two thirds and to all of it is stable; fitted to all of it.
    ///
    /// # Errors
    /// [`Error::NoSolution`] where no order up to `most_poles` gives a stable system.
    pub fn choose(input: &[f64], output: &[f64], most_poles: usize) -> Result<Self, Error> {
        let part = 2 * input.len().min(output.len()) / 3;
        let mut tried = Vec::new();
        for poles in 0..=most_poles {
            for zeros in 0..=poles.max(1) {
                let Ok(fit) = Self::fit(&input[..part], &output[..part], zeros, poles) else {
                    continue;
                };
                if !fit.is_stable() {
                    continue;
                }
                let run = fit.simulate(input, output[0]);
                let error = super::rms_difference(&run[part..], &output[part..]);
                tried.push((error, zeros, poles));
            }
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        tried
            .into_iter()
            .filter_map(|(_, zeros, poles)| Self::fit(input, output, zeros, poles).ok())
            .find(Self::is_stable)
            .ok_or(Error::NoSolution { reason: "no order gives a stable linear part" })
    }

    fn by_equation_error(
        records: &[(&[f64], &[f64], f64)],
        zeros: usize,
        poles: usize,
    ) -> Result<Self, Error> {
        let first = zeros.max(poles);
        let rows: Vec<(usize, usize)> = (0..records.len())
            .flat_map(|r| {
                let count = records[r].0.len().min(records[r].1.len());
                (first..count).map(move |k| (r, k))
            })
            .collect();
        // Steiglitz and McBride: again with both signals behind the poles found before, so that the
        // equation's error becomes that of the simulation.
        let mut best: Option<(f64, Self)> = None;
        let mut poles_before = Self { b: vec![1.0], a: vec![0.0; poles] };
        for _ in 0..REPEATS {
            let filtered: Vec<(Vec<f64>, Vec<f64>)> = records
                .iter()
                .map(|(input, output, _)| (poles_before.shaped(input), poles_before.shaped(output)))
                .collect();
            let at = |row: usize, column: usize| {
                let (r, k) = rows[row];
                match column.checked_sub(zeros + 1) {
                    None => filtered[r].0[k - column],
                    Some(j) => -filtered[r].1[k - j - 1],
                }
            };
            let matrix = DMatrix::from_fn(rows.len(), zeros + 1 + poles, at);
            let right = DVector::from_fn(rows.len(), |row, _| filtered[rows[row].0].1[rows[row].1]);
            // The shortest of all solutions where a record does not determine one: no least squares of full rank.
            let solution = matrix.svd(true, true).solve(&right, 1e-12).ok();
            let Some(p) = solution.filter(|p| p.iter().all(|x| x.is_finite())) else { break };
            let all = p.as_slice();
            let found = Self { b: all[..=zeros].to_vec(), a: all[zeros + 1..].to_vec() };
            let error: f64 = records
                .iter()
                .map(|(input, output, y0)| {
                    let run = found.simulate(input, *y0);
                    super::rms_difference(&run, output).powi(2) * output.len() as f64
                })
                .sum();
            let stable = found.is_stable();
            if best.as_ref().is_none_or(|(least, _)| error < *least) {
                best = Some((error, found.clone()));
            }
            if !stable {
                break;
            }
            poles_before.a = found.a;
        }
        let reason = "the record does not move the linear part";
        best.map(|(_, found)| found).ok_or(Error::NoSolution { reason })
    }

    /// A signal behind 1/A, whose gain at rest is kept at one, from rest at its first value.
    fn shaped(&self, signal: &[f64]) -> Vec<f64> {
        let gain: f64 = 1.0 + self.a.iter().sum::<f64>();
        let first = signal.first().copied().unwrap_or(0.0);
        Self { b: vec![gain], a: self.a.clone() }.simulate(signal, first)
    }

    /// The response to `input` of a system that rested at `y0` under the first input.
    #[must_use]
    pub fn simulate(&self, input: &[f64], y0: f64) -> Vec<f64> {
        let mut output: Vec<f64> = Vec::with_capacity(input.len());
        let first = input.first().copied().unwrap_or(0.0);
        let settled = self.b.len().max(self.a.len() + 1) - 1;
        for t in 0..input.len().min(settled) {
            let past = |i: usize| t.checked_sub(i).map_or(first, |k| input[k]);
            let before = |j: usize| t.checked_sub(j).map_or(y0, |k| output[k]);
            let forward: f64 = self.b.iter().enumerate().map(|(i, b)| b * past(i)).sum();
            let back: f64 = self.a.iter().zip(1..).map(|(a, j)| a * before(j)).sum();
            output.push((forward - back).clamp(-1e9, 1e9));
        }
        for t in settled..input.len() {
            let past = input[t + 1 - self.b.len()..=t].iter().rev();
            let before = output[t - self.a.len()..].iter().rev();
            let forward: f64 = self.b.iter().zip(past).map(|(b, u)| b * u).sum();
            let back: f64 = self.a.iter().zip(before).map(|(a, y)| a * y).sum();
            output.push((forward - back).clamp(-1e9, 1e9));
        }
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coefficients_of_a_known_system_are_found() {
        let truth = Arx { b: vec![0.2, -0.1], a: vec![-1.2, 0.3] };
        let input: Vec<f64> = (0..400).map(|t| (0.002 * f64::from(t * t)).sin()).collect();
        let output = truth.simulate(&input, 0.0);
        let found = Arx::fit(&input, &output, 1, 2).unwrap();
        for (a, b) in found.b.iter().chain(&found.a).zip(truth.b.iter().chain(&truth.a)) {
            assert!((a - b).abs() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn the_inverse_undoes_it() {
        let truth = Arx { b: vec![0.4, -0.1, 0.02], a: vec![-1.2, 0.3] };
        let inverse = truth.inverse();
        assert!(inverse.is_stable());
        let input: Vec<f64> = (0..300).map(|t| (0.002 * f64::from(t * t)).sin()).collect();
        // At rest with the first input 0.
        let back = inverse.simulate(&truth.simulate(&input, 0.0), 0.0);
        assert!(input.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn the_orders_are_chosen_among_stable_systems() {
        let truth = Arx { b: vec![0.2, -0.1], a: vec![-1.2, 0.3] };
        assert!(truth.is_stable() && !Arx { b: vec![1.0], a: vec![-1.1] }.is_stable());
        let input: Vec<f64> = (0..600).map(|t| (0.001 * f64::from(t * t)).sin()).collect();
        let output = truth.simulate(&input, 0.0);
        let found = Arx::choose(&input, &output, 4).unwrap();
        assert!(found.is_stable());
        assert!(crate::learned::rms_difference(&found.simulate(&input, 0.0), &output) < 1e-6);
        // What grows by itself has no stable order that follows it.
        let growing = Arx { b: vec![0.1], a: vec![-1.01] }.simulate(&input, 0.0);
        let follower = Arx::choose(&input, &growing, 3).unwrap();
        assert!(follower.is_stable());
    }
}

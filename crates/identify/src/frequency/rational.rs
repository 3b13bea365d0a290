//! Rational transfer matrices with one denominator for all elements.
//!
//! ```text
//! G(x) = e^(−jωτ)·[D + Σ R_k/(x − p_k)],   x = jω (continuous) or x = e^(jωT) (discrete)
//! ```
//!
//! Poles come alone (real) or with their conjugate. A discrete model runs in the time domain.

use nalgebra::DMatrix;

use super::Complex;

/// What the transfer matrix is rational in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// s = jω; the input's zero-order hold is part of what was measured.
    Continuous,
    /// z = e^(jωT) with this sample time in s.
    Discrete(f64),
}

impl Domain {
    pub(super) fn variable(self, frequency: f64) -> Complex {
        let omega = core::f64::consts::TAU * frequency;
        match self {
            Self::Continuous => Complex::new(0.0, omega),
            Self::Discrete(period) => Complex::from_polar(1.0, omega * period),
        }
    }

    /// The stable pole of the same magnitude response.
    pub(super) fn stable(self, pole: Complex) -> Complex {
        match self {
            Self::Continuous if pole.re > 0.0 => Complex::new(-pole.re, pole.im),
            Self::Discrete(_) if pole.norm_sqr() > 1.0 => pole.conj().inv(),
            _ => pole,
        }
    }

    /// The pole as one of the continuous plane.
    pub(super) fn continuous(self, pole: Complex) -> Complex {
        match self {
            Self::Continuous => pole,
            Self::Discrete(period) => pole.ln() / period,
        }
    }
}

/// A rational transfer matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Rational {
    /// What the rational is rational in.
    pub domain: Domain,
    /// Poles; one of each pair, that with the positive imaginary part.
    pub poles: Vec<Complex>,
    /// Per pole: outputs × inputs.
    pub residues: Vec<DMatrix<Complex>>,
    /// D: outputs × inputs.
    pub direct: DMatrix<f64>,
    /// τ in s; whole samples for a discrete model.
    pub delay: f64,
}

impl Rational {
    /// Number of states for each input: one per real pole, two per pair.
    #[must_use]
    pub fn order(&self) -> usize {
        self.poles.iter().map(|p| if p.im == 0.0 { 1 } else { 2 }).sum()
    }

    /// The response at a frequency in Hz.
    #[must_use]
    pub fn response(&self, frequency: f64) -> DMatrix<Complex> {
        let x = self.domain.variable(frequency);
        let mut sum = self.direct.map(|d| Complex::new(d, 0.0));
        for (pole, residue) in self.poles.iter().zip(&self.residues) {
            sum += residue / (x - pole);
            if pole.im != 0.0 {
                sum += residue.map(|r| r.conj()) / (x - pole.conj());
            }
        }
        let turn = Complex::from_polar(1.0, -core::f64::consts::TAU * frequency * self.delay);
        sum * turn
    }

    /// The outputs of a discrete model to these inputs; row k of an output is read before row k of the
    /// inputs acts, apart from D. With `settle` the inputs run through once before, so that a
    /// periodic input meets its steady state. `None` for a continuous model.
    #[must_use]
    pub fn simulate(&self, inputs: &[Vec<f64>], settle: bool) -> Option<Vec<Vec<f64>>> {
        let Domain::Discrete(period) = self.domain else { return None };
        let delay = (self.delay / period).round() as usize;
        let count = inputs.first().map_or(0, Vec::len);
        let mut outputs = vec![vec![0.0; count]; self.direct.nrows()];
        let mut state = vec![Complex::new(0.0, 0.0); self.poles.len() * inputs.len()];
        let mut u = vec![0.0; inputs.len()];
        for round in 0..if settle { 2 } else { 1 } {
            for k in 0..count {
                for (u, input) in u.iter_mut().zip(inputs) {
                    let late = (k + count - delay % count.max(1)) % count;
                    let started = round > 0 || k >= delay;
                    *u = if started { input[late] } else { 0.0 };
                }
                if round > 0 || !settle {
                    for (o, output) in outputs.iter_mut().enumerate() {
                        output[k] = self.output(o, &state, &u);
                    }
                }
                for (pole, x) in self.poles.iter().zip(state.chunks_exact_mut(u.len())) {
                    x.iter_mut().zip(&u).for_each(|(x, u)| *x = *x * pole + u);
                }
            }
        }
        Some(outputs)
    }

    fn output(&self, o: usize, state: &[Complex], u: &[f64]) -> f64 {
        let direct: f64 = u.iter().enumerate().map(|(i, u)| self.direct[(o, i)] * u).sum();
        let inputs = u.len();
        let moving: f64 = self
            .residues
            .iter()
            .zip(&self.poles)
            .zip(state.chunks_exact(inputs))
            .map(|((residue, pole), x)| {
                let sum: f64 = (0..inputs)
                    .map(|i| residue[(o, i)].re * x[i].re - residue[(o, i)].im * x[i].im)
                    .sum();
                if pole.im == 0.0 { sum } else { 2.0 * sum }
            })
            .sum();
        direct + moving
    }
}

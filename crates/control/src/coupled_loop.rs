//! The loop of axes whose coupling has dynamics, designed for all of them together.
//!
//! Behind the Jacobian J of the coupling at rest stands M(z) = J⁻¹·G(z)·diag(1/slope), which is the unit matrix at
//! rest. With the law of each axis behind it,
//!
//! ```text
//! L = M·diag(k_j·c_j(z)·N(z)),   S = (I + L)⁻¹
//! c_j = T/(1 − z⁻¹) + …          a shape as of a single axis
//! N                              two notches, the same on all axes, which share their modes; c_j in front of them by
//!                                the trapezoidal rule, T/2·(1 + z⁻¹)/(1 − z⁻¹), as no model is right up to half the
//!                                sample rate
//! greatest singular value of S ≤ M_S on every plant
//! ```
//!
//! The plants: the modes' frequencies 10 and 5 % lower and higher, their damping halved and doubled, the command
//! acting at once and one period later. Of the shapes of the single axes, of the integral and of the integral with
//! notches the one with the largest gains (their geometric mean) is taken. All k_j are raised together from zero, then
//! each by itself, while the bound holds. From a stable plant on, the loop cannot become unstable without S passing
//! through infinity; the generalised Nyquist curve det(I + L) confirms it on every plant. The bound implies a gain
//! margin of M_S/(M_S − 1) and a phase margin of 2·asin(1/2M_S), in each axis and in all at once.
//!
//! Frequencies: lines of the Fourier transform of the impulse responses, at least as close as these last; for the
//! search only those between which the plant changes, for the last word all.
//!
//! Source: S. Skogestad, I. Postlethwaite, Multivariable Feedback Control, Wiley 2005, ch. 3, 4.9 and 9.

mod lines;

use core::f64::consts::{PI, TAU};

use data::ComponentBlueprint;
use nalgebra::{Complex, DMatrix};
use serde::Serialize;

use self::lines::{Line, lines, thinned};
use crate::damping::grid;
use crate::design::{CommandActs, Feedback};
use crate::loop_shape::{Limits, Shape, Shaped};
use crate::nyquist::Round;
use crate::search::evolve;

/// Factors between the gains that are tried, in the search and at the end.
const SEARCHED: [f64; 3] = [2.0, 1.25, 1.05];
const RAISED: [f64; 3] = [1.25, 1.05, 1.01];
/// Most steps with a factor.
const STEPS: usize = 200;
/// By how much gains are lowered while a line between those of the search breaks the bound.
const LOWERED: f64 = 0.98;
/// Points per value that is sought, and rounds.
const EFFORT: (usize, usize) = (5, 16);
/// Notches, and bounds of their damping and depth.
const NOTCHES: usize = 2;
const WIDTHS: (f64, f64) = (0.1, 3.0);
const DEPTHS: (f64, f64) = (0.02, 1.0);
/// Highest frequency of a notch over the sample rate.
const HIGHEST: f64 = 0.45;

/// What is known of the loop of coupled axes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoupledFigures {
    /// Greatest singular value of S over all plants.
    pub sensitivity: f64,
    /// By how much all gains may grow together before a plant becomes unstable.
    pub gain_margin: f64,
    /// Number of plants, on all of which the loop is stable.
    pub plants: usize,
    /// Frequency in Hz, damping and depth of each notch; empty where there is none.
    pub notches: Vec<[f64; 3]>,
    /// Frequency in Hz at which each axis' loop gain is 1 with integral control that keeps the same bound on the same
    /// plants, with the largest gains.
    pub integral_bandwidth: Vec<f64>,
}

/// The laws of coupled axes.
pub(crate) struct CoupledLoop {
    pub(crate) axes: Vec<Shaped>,
    pub(crate) figures: CoupledFigures,
}

impl CoupledLoop {
    /// The notches in front of each law.
    pub(crate) fn notches(&self) -> Vec<ComponentBlueprint> {
        let each = self.figures.notches.iter().enumerate();
        each.map(|(at, [frequency, damping, depth])| {
            let notch = ComponentBlueprint::new("feedback-notch")
                .value("frequency", *frequency)
                .value("damping", *damping)
                .value("depth", *depth);
            if at == 0 { notch } else { notch.named(&format!("notch_{}", at + 1)) }
        })
        .collect()
    }
}

/// The plants, and what is asked.
pub(crate) struct CoupledPlants<'a> {
    /// Of each plant of the [`grid`]: the impulse responses of all motions to each command.
    pub(crate) responses: &'a [Vec<Vec<Vec<f64>>>],
    /// Motion per command of each axis.
    pub(crate) slopes: &'a [f64],
    /// Lowest frequency in Hz of a light mode.
    pub(crate) first: Option<f64>,
    pub(crate) period: f64,
}

/// The law of the axes with the largest gains that keep the limits on all plants.
///
/// # Errors
/// That there is none.
pub(crate) fn coupled(
    coupled_plants: &CoupledPlants<'_>,
    shapes: &[Shape],
    law: Feedback,
    acts: CommandActs,
    limits: Limits,
) -> Result<CoupledLoop, String> {
    let n = shapes.len();
    let complete: Vec<Vec<Line>> =
        coupled_plants.responses.iter().map(|plant| lines(plant, coupled_plants.slopes)).collect();
    let thin: Vec<Vec<Line>> = complete.iter().map(|lines| thinned(lines)).collect();
    let loops = Loops { n, period: coupled_plants.period, acts, limits };
    // The lightest modes at every frequency decide.
    let lightest: Vec<&Vec<Line>> = thin
        .iter()
        .zip(grid())
        .filter(|(_, (_, damping))| *damping < 1.0)
        .map(|(lines, _)| lines)
        .collect();
    let integral = vec![Shape { name: "integral", a: 0.0, b: 0.0, filter: 0.0 }; n];
    let mut laws = vec![Laws { shapes: integral.clone(), notches: Vec::new() }];
    if law != Feedback::Integral {
        laws.push(Laws { shapes: shapes.to_vec(), notches: Vec::new() });
        if let Some(first) =
            coupled_plants.first.filter(|first| first * coupled_plants.period < 0.4)
        {
            // Half a period less: the trapezoidal rule, which leaves nothing at half the sample rate.
            let name = "integral and notches";
            let rule = Shape { name, a: -0.5 * coupled_plants.period, b: 0.0, filter: 0.0 };
            laws.push(loops.notched(&lightest, &vec![rule; n], first));
        }
    }
    let mut found: Option<(Laws, Vec<f64>)> = None;
    let mut alone = vec![0.0; n];
    let all: Vec<&Vec<Line>> = thin.iter().collect();
    let every: Vec<&Vec<Line>> = complete.iter().collect();
    for (at, laws) in laws.into_iter().enumerate() {
        let Some(gains) = loops.raised(&all, &every, &laws) else { continue };
        if at == 0 {
            alone.clone_from(&gains);
        }
        let size = |gains: &[f64]| gains.iter().map(|k| k.ln()).sum::<f64>();
        if found.as_ref().is_none_or(|best| size(&gains) > size(&best.1)) {
            found = Some((laws, gains));
        }
    }
    let none = || {
        format!(
            "no gains of the coupled axes keep the greatest singular value of the sensitivity below {} with the modes' \
             frequencies up to 10 % off and their damping halved or doubled; allow a larger --sensitivity, or take a \
             shorter --period",
            limits.sensitivity
        )
    };
    let (laws, gains) = found.ok_or_else(none)?;
    if !every.iter().all(|plant| loops.is_stable(plant, &laws, &gains)) {
        return Err(none());
    }
    let sensitivity = loops.sensitivity(&every, &laws, &gains);
    let gain_margin = loops.gain_margin(&all, &laws, &gains);
    let phase_margin = 2.0 * (0.5 / sensitivity).asin();
    let nominal = complete.first().ok_or_else(none)?;
    let width = |laws: &Laws, axis: usize, gain: f64| {
        let within = nominal.iter().find(|line| {
            (line.matrix[axis * n + axis] * laws.at(axis, line.back, coupled_plants.period) * gain)
                .norm()
                <= 1.0
        });
        within.map_or(0.5 / coupled_plants.period, |line| {
            -line.back.arg() / (TAU * coupled_plants.period)
        })
    };
    let plain = Laws { shapes: integral, notches: Vec::new() };
    let integral_bandwidth =
        (0..n).map(|axis| if alone[axis] > 0.0 { width(&plain, axis, alone[axis]) } else { 0.0 });
    let figures = CoupledFigures {
        sensitivity,
        gain_margin,
        plants: every.len() * acts.later().len(),
        notches: laws.notches.iter().map(|notch| notch.parameters(coupled_plants.period)).collect(),
        integral_bandwidth: integral_bandwidth.collect(),
    };
    let axes = (0..n).map(|axis| Shaped {
        shape: laws.shapes[axis],
        ki: gains[axis] / coupled_plants.slopes[axis],
        sensitivity,
        gain_margin,
        phase_margin,
        bandwidth: width(&laws, axis, gains[axis]),
    });
    Ok(CoupledLoop { axes: axes.collect(), figures })
}

/// A notch, in parts of the sample rate.
#[derive(Clone, Copy)]
struct Notch {
    frequency: f64,
    damping: f64,
    depth: f64,
}

impl Notch {
    /// Where z⁻¹ is `back`; as of the component.
    fn at(&self, back: Complex<f64>) -> Complex<f64> {
        let w = (PI * self.frequency).tan();
        let (square, broad) = (w * w, 2.0 * self.damping * w);
        let side = |broad: f64| {
            back * (2.0 * (square - 1.0))
                + back * back * (1.0 + square - broad)
                + (1.0 + square + broad)
        };
        side(self.depth * broad) / side(broad)
    }

    fn parameters(&self, period: f64) -> [f64; 3] {
        [self.frequency / period, self.damping, self.depth]
    }
}

/// The laws of all axes, for k = 1.
struct Laws {
    shapes: Vec<Shape>,
    notches: Vec<Notch>,
}

impl Laws {
    fn at(&self, axis: usize, back: Complex<f64>, period: f64) -> Complex<f64> {
        let notches: Complex<f64> = self.notches.iter().map(|notch| notch.at(back)).product();
        self.shapes[axis].at(back, period) * notches
    }

    /// At each line.
    fn along(&self, lines: &[Line], period: f64) -> Vec<Complex<f64>> {
        let each = lines.iter().map(|line| {
            let notches: Complex<f64> =
                self.notches.iter().map(|notch| notch.at(line.back)).product();
            self.shapes.iter().map(move |shape| shape.at(line.back, period) * notches)
        });
        each.flatten().collect()
    }
}

/// What a loop of `n` axes must keep.
struct Loops {
    n: usize,
    period: f64,
    acts: CommandActs,
    limits: Limits,
}

impl Loops {
    /// Whether the singular values of S stay below 1/`least` at each line; `laws`: as of [`Laws::along`].
    fn holds(&self, lines: &[Line], laws: &[Complex<f64>], gains: &[f64], least: f64) -> bool {
        let n = self.n;
        let mut columns = vec![Complex::new(0.0, 0.0); n];
        let mut room = vec![Complex::new(0.0, 0.0); 2 * n * n];
        lines.iter().zip(laws.chunks_exact(n)).all(|(line, laws)| {
            let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
            for ((column, law), gain) in columns.iter_mut().zip(laws).zip(gains) {
                *column = law * *gain;
                let size = column.norm();
                (low, high) = (low.min(size), high.max(size));
            }
            if high * line.most <= 1.0 - least || low * line.least >= 1.0 + least {
                return true;
            }
            self.acts.later().iter().all(|later| {
                let turn = if *later { line.back } else { Complex::new(1.0, 0.0) };
                is_above(&line.matrix, &columns, turn, least, &mut room)
            })
        })
    }

    /// The largest common factor of these gains that keeps the bound.
    fn largest(&self, plants: &[&Vec<Line>], laws: &Laws, factors: &[f64]) -> Option<f64> {
        let along: Vec<_> = plants.iter().map(|lines| laws.along(lines, self.period)).collect();
        let bound = 1.0 / self.limits.sensitivity;
        let allowed = |k: f64| {
            let noise = laws.shapes.iter().map(|shape| k * shape.noise(self.period));
            noise.fold(0.0, f64::max) <= self.limits.noise
                && plants
                    .iter()
                    .zip(&along)
                    .all(|(lines, along)| self.holds(lines, along, &vec![k; self.n], bound))
        };
        let mut best = Some(1e-6 / self.period).filter(|k| allowed(*k))?;
        for factor in factors {
            for _ in 0..STEPS {
                if !allowed(best * factor) {
                    break;
                }
                best *= factor;
            }
        }
        Some(best)
    }

    /// The gains of all axes, raised together and then each by itself; they hold at `every` line.
    fn raised(&self, plants: &[&Vec<Line>], every: &[&Vec<Line>], laws: &Laws) -> Option<Vec<f64>> {
        let mut gains = vec![self.largest(plants, laws, &RAISED)?; self.n];
        let bound = 1.0 / self.limits.sensitivity;
        let hold = |plants: &[&Vec<Line>], along: &[Vec<Complex<f64>>], gains: &[f64]| {
            let pairs = plants.iter().zip(along);
            pairs.into_iter().all(|(lines, along)| self.holds(lines, along, gains, bound))
        };
        let along = |plants: &[&Vec<Line>]| -> Vec<_> {
            plants.iter().map(|lines| laws.along(lines, self.period)).collect()
        };
        let thin = along(plants);
        for factor in RAISED {
            for _ in 0..STEPS {
                let before = gains.clone();
                for axis in 0..self.n {
                    let last = gains[axis];
                    gains[axis] *= factor;
                    let noise = gains[axis] * laws.shapes[axis].noise(self.period);
                    if noise > self.limits.noise || !hold(plants, &thin, &gains) {
                        gains[axis] = last;
                    }
                }
                if before == gains {
                    break;
                }
            }
        }
        let full = along(every);
        for _ in 0..STEPS {
            if hold(every, &full, &gains) {
                return Some(gains);
            }
            for gain in &mut gains {
                *gain *= LOWERED;
            }
        }
        None
    }

    /// Notches in front of these shapes with which the gain is largest; `first`: the lowest mode in Hz.
    fn notched(&self, plants: &[&Vec<Line>], shapes: &[Shape], first: f64) -> Laws {
        let lowest = 0.5 * first * self.period;
        let one = [(lowest, HIGHEST), WIDTHS, DEPTHS].map(|(a, b): (f64, f64)| (a.ln(), b.ln()));
        let bounds = one.repeat(NOTCHES);
        let laws = |x: &[f64]| {
            let notch =
                |x: &[f64]| Notch { frequency: x[0].exp(), damping: x[1].exp(), depth: x[2].exp() };
            Laws { shapes: shapes.to_vec(), notches: x.chunks_exact(3).map(notch).collect() }
        };
        let (x, _) = evolve(&bounds, EFFORT, |x| {
            self.largest(plants, &laws(x), &SEARCHED).map_or(f64::INFINITY, |k| -k.ln())
        });
        laws(&x)
    }

    /// Whether the generalised Nyquist curve does not go round zero.
    fn is_stable(&self, lines: &[Line], laws: &Laws, gains: &[f64]) -> bool {
        let n = self.n;
        self.acts.later().iter().all(|later| {
            let mut round = Round::default();
            for line in lines {
                let turn = if *later { line.back } else { Complex::new(1.0, 0.0) };
                // Its integrators are taken out.
                let open = 1.0 - line.back;
                let matrix = DMatrix::from_fn(n, n, |row, column| {
                    let law = laws.at(column, line.back, self.period) * gains[column] * turn;
                    let unit = if row == column { 1.0 } else { 0.0 };
                    (line.matrix[row * n + column] * law + unit) * open
                });
                round.go(matrix.determinant());
            }
            round.is_none()
        })
    }

    /// Greatest singular value of S.
    fn sensitivity(&self, plants: &[&Vec<Line>], laws: &Laws, gains: &[f64]) -> f64 {
        let along: Vec<_> = plants.iter().map(|lines| laws.along(lines, self.period)).collect();
        let (mut low, mut high) = (1.0, self.limits.sensitivity);
        for _ in 0..9 {
            let middle = 0.5 * (low + high);
            let mut pairs = plants.iter().zip(&along);
            if pairs.all(|(lines, along)| self.holds(lines, along, gains, 1.0 / middle)) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }

    /// By how much all gains may grow together.
    fn gain_margin(&self, plants: &[&Vec<Line>], laws: &Laws, gains: &[f64]) -> f64 {
        let mut factor = 1.0;
        for step in [1.2, 1.02] {
            for _ in 0..40 {
                let grown: Vec<f64> = gains.iter().map(|gain| gain * factor * step).collect();
                if !plants.iter().all(|plant| self.is_stable(plant, laws, &grown)) {
                    break;
                }
                factor *= step;
            }
        }
        factor
    }
}

/// Whether all singular values of I + M·diag(columns)·turn are above `least`: whether the product with its conjugate
/// transpose, less `least`², has a Cholesky factor.
fn is_above(
    matrix: &[Complex<f64>],
    columns: &[Complex<f64>],
    turn: Complex<f64>,
    least: f64,
    room: &mut [Complex<f64>],
) -> bool {
    let n = columns.len();
    let (open, product) = room.split_at_mut(n * n);
    for row in 0..n {
        for column in 0..n {
            let unit = if row == column { 1.0 } else { 0.0 };
            open[row * n + column] = matrix[row * n + column] * columns[column] * turn + unit;
        }
    }
    for i in 0..n {
        for j in 0..=i {
            let mut sum: Complex<f64> =
                (0..n).map(|row| open[row * n + i].conj() * open[row * n + j]).sum();
            if i == j {
                sum -= least * least;
            }
            for k in 0..j {
                sum -= product[i * n + k] * product[j * n + k].conj();
            }
            if i == j {
                // What is not finite is not above either.
                if !(sum.re > 0.0 && sum.re.is_finite()) {
                    return false;
                }
                product[i * n + i] = Complex::new(sum.re.sqrt(), 0.0);
            } else {
                product[i * n + j] = sum / product[j * n + j].re;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests;

//! The response of one axis as that of parts in a row: delay, lags, gain, mode.
//!
//! G(jω) = k · exp(−jωτ) · Π 1/(1 + jω/ω_l) · ω₀²/(ω₀² + 2ζω₀jω − ω²). The gain is linear and follows from the other
//! parameters (variable projection: G. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413–432). Residuals are weighed
//! by the reciprocal of the response's standard deviation.

use core::f64::consts::{PI, TAU};

use components::COMPONENTS;
use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint};
use model::Kind;

use super::Complex;
use super::held::{PlantNames, delay_of};
use super::response::FrequencyResponse;
use numerics::levenberg_marquardt::{PATIENT, Unknown, minimise};

use crate::error::Error;

/// Parts in a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// In output units per input unit.
    pub gain: f64,
    /// In s; a lead of at most one sample, below 0, is that of readings that are taken after their command has acted.
    pub delay: f64,
    /// Bandwidths in Hz: the amplifier's, then the sensor's.
    pub lags: Vec<f64>,
    /// Frequency in Hz and damping ratio.
    pub mode: Option<[f64; 2]>,
    /// Relative standard deviations of gain, delay, lags, frequency and damping, in this order.
    pub deviations: Vec<Option<f64>>,
    /// Mean square of the weighted residual, and description length, as those of a [`Choice`](super::Choice).
    pub misfit: f64,
    /// Minimum description length per line.
    pub length: f64,
}

/// Most lags of a chain.
const MOST_LAGS: usize = 2;
/// Longest delay, over the period of the highest line.
const LONGEST: f64 = 20.0;
/// Highest frequency of a mode, over that of the highest line.
const HIGHEST: f64 = 1.5;

/// One line: angular frequency, response, weight.
type Point = (f64, Complex, f64);

/// The parts of least description length.
///
/// # Errors
/// [`Error::NoSolution`] for more than one axis or where no search converges.
pub fn choose_chain(measured: &FrequencyResponse) -> Result<Chain, Error> {
    let floor = measured.least_deviation();
    let mut points: Vec<Point> = Vec::new();
    for line in &measured.lines {
        if line.response.len() != 1 {
            return Err(Error::no_solution("parts in a row have one input and one output"));
        }
        points.push((
            TAU * line.frequency,
            line.response[(0, 0)],
            1.0 / line.deviation[(0, 0)].max(floor),
        ));
    }
    let mut best: Option<Chain> = None;
    for lags in 0..=MOST_LAGS {
        for has_mode in [false, true] {
            let Some(chain) = fitted(&points, measured.sample_time, lags, has_mode) else {
                continue;
            };
            if best.as_ref().is_none_or(|best| chain.length < best.length) {
                best = Some(chain);
            }
        }
    }
    best.ok_or(Error::no_solution("no search of parts in a row has converged"))
}

/// The response of the parts without their gain. `p` = delay over that of one radian at the highest line, logarithms of
/// the lags' corners, logarithms of frequency and damping; angular frequencies over the highest line's.
fn shape(p: &[f64], lags: usize, w: f64) -> Complex {
    let mode = match p[1 + lags..] {
        [frequency, damping] => Some([frequency.exp(), damping.exp()]),
        _ => None,
    };
    in_a_row(w * p[0], p[1..=lags].iter().map(|corner| w / corner.exp()), w, mode)
}

/// The response of a delay, given as the angle that it turns by, of lags, given as the frequency over their corners, and of a
/// mode, given as its frequency in the unit of `w` and its damping.
fn in_a_row(
    angle: f64,
    lags: impl Iterator<Item = f64>,
    w: f64,
    mode: Option<[f64; 2]>,
) -> Complex {
    let mut g = lags.fold(Complex::from_polar(1.0, -angle), |g, x| g / Complex::new(1.0, x));
    if let Some([natural, damping]) = mode {
        let x = w / natural;
        g /= Complex::new(1.0 - x * x, 2.0 * damping * x);
    }
    g
}

/// The gain of least squares.
fn gain(points: &[Point], top: f64, p: &[f64], lags: usize) -> f64 {
    let sums = points.iter().fold([0.0; 2], |[a, b], (w, g, weight)| {
        let m = shape(p, lags, w / top) * *weight;
        [a + (m.conj() * *g * *weight).re, b + m.norm_sqr()]
    });
    sums[0] / sums[1].max(f64::MIN_POSITIVE)
}

fn fitted(points: &[Point], period: f64, lags: usize, has_mode: bool) -> Option<Chain> {
    let (low, top) = (points.first()?.0, points.last()?.0);
    let unknown = |start: f64, lower: f64, upper: f64| Unknown { start, lower, upper };
    // Corners far beyond the lines are a delay.
    let corner = |start: f64| unknown(start, (0.1 * low / top).ln(), 10_f64.ln());
    let spread = (top / low).ln();
    let peak = points.iter().max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()))?.0;
    let mut best: Option<(f64, Vec<f64>, Vec<Option<f64>>)> = None;
    for delay in [0.0, 0.3, 2.0] {
        for part in [0.25, 0.5, 0.75] {
            let modes = [peak.max(2.0 * low) / top, (-0.2 * spread).exp(), (-0.5 * spread).exp()];
            for mode in &modes[..if has_mode { 3 } else { 1 }] {
                let mut unknowns = vec![unknown(delay, -period * top, LONGEST * TAU)];
                for lag in 0..lags {
                    unknowns.push(corner(-(part + 0.2 * lag as f64).min(0.95) * spread));
                }
                if has_mode {
                    unknowns.push(unknown(mode.ln(), (0.1 * low / top).ln(), HIGHEST.ln()));
                    // With more damping it is two lags.
                    unknowns.push(unknown(0.05_f64.ln(), 1e-4_f64.ln(), 0.0));
                }
                let residuals = |p: &[f64]| {
                    let k = gain(points, top, p, lags);
                    let rest = points.iter().flat_map(|(w, g, weight)| {
                        let e = (shape(p, lags, w / top) * k - *g) * *weight;
                        [e.re, e.im]
                    });
                    Ok(rest.collect::<Vec<f64>>())
                };
                let Ok(minimum) = minimise::<Error>(&unknowns, PATIENT, residuals, |_| ()) else {
                    continue;
                };
                let Ok(rest) = residuals(&minimum.parameters) else { continue };
                let cost: f64 = rest.iter().map(|r| r * r).sum();
                if cost.is_finite() && best.as_ref().is_none_or(|(least, ..)| cost < *least) {
                    best = Some((cost, minimum.parameters, minimum.variance));
                }
            }
        }
    }
    let (cost, p, variance) = best?;
    // A mode at its bounds only bends the response a little.
    if has_mode && variance[1 + lags..].iter().any(Option::is_none) {
        return None;
    }
    let misfit = cost / points.len() as f64;
    let count = (2 * points.len()) as f64;
    let k = gain(points, top, &p, lags);
    let known: f64 = points
        .iter()
        .map(|(w, _, weight)| (shape(&p, lags, w / top) * *weight).norm_sqr())
        .sum::<f64>();
    // What is left says how well the lines are known.
    let scatter = (cost / (count - p.len() as f64 - 1.0).max(1.0)).sqrt();
    let mut deviations = vec![Some(scatter / (known.sqrt() * k.abs()))];
    deviations.extend(variance.iter().enumerate().map(|(at, variance)| {
        let deviation = scatter * variance.filter(|v| *v >= 0.0)?.sqrt();
        Some(if at == 0 { deviation / p[0].abs() } else { deviation })
    }));
    let hertz = |ln: f64| ln.exp() * top / TAU;
    Some(Chain {
        gain: k,
        delay: p[0] / top,
        lags: p[1..=lags].iter().map(|ln| hertz(*ln)).collect(),
        mode: has_mode.then(|| [hertz(p[1 + lags]), p[2 + lags].exp()]),
        deviations,
        misfit,
        length: misfit.max(f64::MIN_POSITIVE).ln() + (p.len() + 1) as f64 * count.ln() / count,
    })
}

/// What commands that are held for `period` in s make of the response of a machine whose output is read before the next
/// command acts: (1 − exp(−jωT))/(jωT).
#[must_use]
pub fn hold(frequency: f64, period: f64) -> Complex {
    let half = PI * frequency * period;
    if half == 0.0 { Complex::new(1.0, 0.0) } else { Complex::from_polar(half.sin() / half, -half) }
}

impl Chain {
    /// The response.
    #[must_use]
    pub fn response(&self, frequency: f64) -> Complex {
        let lags = self.lags.iter().map(|corner| frequency / corner);
        in_a_row(TAU * frequency * self.delay, lags, frequency, self.mode) * self.gain
    }

    /// The checked blueprint of one axis, which is stepped with `period` in s. Each fitted parameter has its standard
    /// deviation as tolerance, at least `least`; the damping `least_of_damping`.
    ///
    /// # Errors
    /// [`Error::Model`] with every problem of names or units.
    pub fn blueprint(
        &self,
        names: &PlantNames,
        period: f64,
        [least, least_of_damping]: [f64; 2],
    ) -> Result<CheckedBlueprint, Error> {
        let refused = |message: String| Error::Model { name: names.model.clone(), message };
        let mut axes = names.axes();
        let (Some(mut axis), None) = (axes.next(), axes.next()) else {
            return Err(refused("parts in a row have one input and one output".into()));
        };
        let tolerance =
            |at: usize, least: f64| self.deviations[at].unwrap_or(0.0).clamp(least, 1.0);
        let part = |kind: &str, values: &[(&str, f64, f64)]| {
            let mut part = ComponentBlueprint::new(kind);
            for (name, value, tolerance) in values {
                part = part.value(name, *value);
                part.tolerance.insert((*name).to_owned(), *tolerance);
            }
            part
        };
        if let Some(mut delay) = delay_of(self.delay) {
            delay.tolerance.insert("delay".to_owned(), tolerance(1, least));
            axis = axis.component(delay);
        }
        let mut lags = self.lags.iter().zip(2..);
        let mut lag = |kind: &str| {
            let (bandwidth, at) = lags.next()?;
            Some(part(kind, &[("bandwidth", *bandwidth, tolerance(at, least))]))
        };
        let (amplifier, sensor) = (lag("amplifier-lag"), lag("sensor-lag"));
        axis = amplifier.into_iter().fold(axis, AxisBlueprint::component);
        axis = axis.component(part("actuator-gain", &[("gain", self.gain, tolerance(0, least))]));
        if let Some([frequency, damping]) = self.mode {
            let at = 2 + self.lags.len();
            let values = [
                ("frequency", frequency, tolerance(at, least)),
                ("damping", damping, tolerance(at + 1, least_of_damping)),
            ];
            axis = axis.component(part("mode", &values));
        }
        axis = sensor.into_iter().fold(axis, AxisBlueprint::component);
        let mut blueprint = Blueprint::new(Kind::Plant, &names.model, period);
        blueprint.description.clone_from(&names.description);
        blueprint.axis(axis).check(COMPONENTS).map_err(|problems| refused(problems.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(chain: &Chain, noise: f64) -> FrequencyResponse {
        let mut turn = 0.3_f64;
        let lines = (1..=300).map(|k| {
            let frequency = 4.0 * f64::from(k);
            // A fixed sequence of angles, without a source of random numbers.
            turn = (turn * 7.3 + 1.1) % TAU;
            let g = chain.response(frequency);
            (frequency, vec![g + Complex::from_polar(noise, turn)], vec![noise.max(1e-6)])
        });
        FrequencyResponse::given((1, 1), lines.collect(), 1e-4)
    }

    fn chain(delay: f64, lags: &[f64], mode: Option<[f64; 2]>) -> Chain {
        let (deviations, misfit, length) = (Vec::new(), 0.0, 0.0);
        Chain { gain: -3.0, delay, lags: lags.to_vec(), mode, deviations, misfit, length }
    }

    #[test]
    fn known_parts_are_found_and_no_more() {
        for (truth, noise) in [
            (chain(0.0, &[40.0], None), 1e-3),
            (chain(3e-4, &[150.0], Some([700.0, 0.02])), 1e-3),
            (chain(2e-3, &[], Some([310.0, 0.1])), 1e-3),
            (chain(0.0, &[50.0, 400.0], None), 1e-4),
        ] {
            let found = choose_chain(&measured(&truth, noise)).unwrap();
            assert_eq!(found.lags.len(), truth.lags.len(), "{found:?}");
            assert_eq!(found.mode.is_some(), truth.mode.is_some(), "{found:?}");
            let near = |a: f64, b: f64, part: f64| (a / b - 1.0).abs() < part;
            assert!(near(found.gain, truth.gain, 1e-3), "{found:?}");
            assert!((found.delay - truth.delay).abs() < 3e-6, "{found:?}");
            let mut lags = found.lags.clone();
            lags.sort_by(f64::total_cmp);
            assert!(lags.iter().zip(&truth.lags).all(|(a, b)| near(*a, *b, 0.01)), "{found:?}");
            if let (Some(a), Some(b)) = (found.mode, truth.mode) {
                assert!(near(a[0], b[0], 1e-3) && near(a[1], b[1], 0.02), "{found:?}");
            }
            assert!((0.5..1.5).contains(&found.misfit), "{found:?}");
        }
    }

    #[test]
    fn the_hold_is_that_of_a_staircase() {
        // Half the sample rate: 2/π, a quarter turn behind.
        let at = hold(5000.0, 1e-4);
        assert!((at - Complex::new(0.0, -2.0 / PI)).norm() < 1e-12, "{at}");
        assert_eq!(hold(0.0, 1e-4), Complex::new(1.0, 0.0));
    }
}

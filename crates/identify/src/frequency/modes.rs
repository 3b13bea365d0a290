//! Fits of a measured response: order, delay, modes.

use nalgebra::DMatrix;
use serde::Serialize;

use super::Complex;
use super::rational::{Domain, Rational};
use super::relocate::{Basis, Samples, relocated, residues};
use super::response::FrequencyResponse;
use crate::error::Error;

/// How a rational model is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RationalSettings {
    /// Pairs of poles.
    pub pairs: usize,
    /// Real poles beside them.
    pub single: usize,
    /// Rounds in which the poles move.
    pub rounds: usize,
    /// Weights: the reciprocal of the response's standard deviation (maximum likelihood), or equal.
    pub by_deviation: bool,
    /// Longest delay that is tried, in s.
    pub longest_delay: f64,
    /// Whether the poles are those of a plant over time that the lines show: none on the negative real axis of a
    /// discrete model, none below three times the lowest line, whose static part would be a guess, and no real
    /// ones in place of a pair where none were asked for.
    pub is_held: bool,
}

impl Default for RationalSettings {
    fn default() -> Self {
        Self {
            pairs: 1,
            single: 0,
            rounds: 25,
            by_deviation: true,
            longest_delay: 0.0,
            is_held: false,
        }
    }
}

/// One pole or pair as a mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mode {
    /// Undamped natural frequency in Hz; of a real pole its corner.
    pub frequency: f64,
    /// Damping ratio; 1 for a real pole.
    pub damping: f64,
    /// Greatest |residue| over the elements, relative to the pole's real part: its height in the response.
    pub height: f64,
}

/// A fit with what it leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The model.
    pub model: Rational,
    /// Mean square of the weighted residual; about 1 where the fit is as good as the measured response's
    /// own scatter, with weights by deviation.
    pub misfit: f64,
    /// Minimum description length per line and element, by which orders are compared.
    pub length: f64,
}

impl FrequencyResponse {
    /// Least deviation that counts: a response without any scatter would count without limit.
    pub(super) fn least_deviation(&self) -> f64 {
        let greatest = self.lines.iter().map(|l| l.deviation.max()).fold(0.0, f64::max);
        (1e-6 * greatest).max(1e-150)
    }

    /// Mean square of what a model leaves of the response, over the response's own variance.
    #[must_use]
    pub fn misfit(&self, model: &Rational) -> f64 {
        let floor = self.least_deviation();
        let square = |line: &super::response::Line| {
            let rest = &line.response - model.response(line.frequency);
            let each = rest.iter().zip(&line.deviation);
            each.map(|(rest, d)| rest.norm_sqr() / d.max(floor).powi(2)).sum::<f64>()
        };
        let count = self.lines.iter().map(|l| l.response.len()).sum::<usize>().max(1);
        self.lines.iter().map(square).sum::<f64>() / count as f64
    }
}

impl Rational {
    /// The modes, by frequency.
    #[must_use]
    pub fn modes(&self) -> Vec<Mode> {
        let mut all: Vec<Mode> = self
            .poles
            .iter()
            .zip(&self.residues)
            .map(|(pole, residue)| {
                let s = self.domain.continuous(*pole);
                let distance = match self.domain {
                    Domain::Continuous => -pole.re,
                    Domain::Discrete(_) => 1.0 - pole.norm(),
                };
                let greatest = residue.iter().map(|r| r.norm()).fold(0.0, f64::max);
                Mode {
                    frequency: s.norm() / core::f64::consts::TAU,
                    damping: -s.re / s.norm(),
                    height: greatest / distance.max(f64::MIN_POSITIVE),
                }
            })
            .collect();
        all.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        all
    }
}

/// Lines that a search uses; the result is fitted to all.
const SEARCH_LINES: usize = 1500;
/// Lines for the search of a delay.
const DELAY_LINES: usize = 400;
/// Delays that are tried between 0 and the longest.
const DELAYS: usize = 20;
/// Least frequency of a pole that the lines show, over that of the lowest line.
const LOWEST: f64 = 3.0;
/// Damping of the poles at the start.
const START_DAMPING: f64 = 0.01;

/// Lines thinned out, delay taken off, weights.
struct Prepared {
    frequency: Vec<f64>,
    variable: Vec<Complex>,
    response: Vec<DMatrix<Complex>>,
    weight: Vec<DMatrix<f64>>,
}

impl Prepared {
    fn new(
        measured: &FrequencyResponse,
        domain: Domain,
        by_deviation: bool,
        most: usize,
        delay: f64,
    ) -> Self {
        let stride = measured.lines.len().div_ceil(most).max(1);
        let lines: Vec<_> = measured.lines.iter().step_by(stride).collect();
        let turn = |f: f64| Complex::from_polar(1.0, core::f64::consts::TAU * f * delay);
        let weight = |deviation: &DMatrix<f64>| {
            if by_deviation {
                // A response without any scatter would weigh without limit.
                let floor = 1e-6 * deviation.max().max(f64::MIN_POSITIVE);
                deviation.map(|d| 1.0 / d.max(floor))
            } else {
                DMatrix::from_element(deviation.nrows(), deviation.ncols(), 1.0)
            }
        };
        Self {
            frequency: lines.iter().map(|line| line.frequency).collect(),
            variable: lines.iter().map(|line| domain.variable(line.frequency)).collect(),
            response: lines.iter().map(|line| &line.response * turn(line.frequency)).collect(),
            weight: lines.iter().map(|line| weight(&line.deviation)).collect(),
        }
    }

    fn samples(&self) -> Samples<'_> {
        Samples { variable: &self.variable, response: &self.response, weight: &self.weight }
    }

    /// Poles spread over the band.
    fn start(&self, domain: Domain, settings: &RationalSettings) -> Basis {
        let lowest = self.frequency.first().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
        let highest = self.frequency.last().copied().unwrap_or(1.0);
        let place = |s: Complex| match domain {
            Domain::Continuous => s,
            Domain::Discrete(period) => (s * period).exp(),
        };
        let at = |k: usize, count: usize| (k as f64 + 0.5) / count.max(1) as f64;
        let tau = core::f64::consts::TAU;
        let single = (0..settings.single).map(|k| {
            let corner = lowest * (highest / lowest).powf(at(k, settings.single));
            Complex::new(place(Complex::new(-tau * corner, 0.0)).re, 0.0)
        });
        let pairs = (0..settings.pairs).map(|k| {
            let omega = tau * (lowest + (highest - lowest) * at(k, settings.pairs));
            place(Complex::new(-START_DAMPING * omega, omega))
        });
        Basis { domain, poles: single.chain(pairs).collect() }
    }
}

/// Fits a model in `domain` with the delay given, in s.
fn fit_at(
    measured: &FrequencyResponse,
    domain: Domain,
    settings: &RationalSettings,
    delay: f64,
    most_lines: usize,
    start: Option<Basis>,
) -> Result<(Rational, f64, Basis), Error> {
    let search = Prepared::new(measured, domain, settings.by_deviation, most_lines, delay);
    let states = 2 * settings.pairs + settings.single;
    if search.variable.len() < states + 2 {
        return Err(Error::no_solution("there are fewer lines than the fit has poles"));
    }
    let mut basis = start.unwrap_or_else(|| search.start(domain, settings));
    let mut best: Option<(Rational, f64, Basis)> = None;
    for round in 0..=settings.rounds {
        let (model, misfit) = residues(&basis, &search.samples(), delay)?;
        if best.as_ref().is_none_or(|best| misfit < best.1) {
            best = Some((model, misfit, basis.clone()));
        }
        if round < settings.rounds {
            basis = relocated(&basis, &search.samples())?;
        }
    }
    best.ok_or(Error::no_solution("no round of the fit succeeded"))
}

/// Fits a rational model; with a longest delay the delay of least misfit is found too, whole samples in
/// a discrete model.
///
/// # Errors
/// [`Error::NoSolution`] where there are too few lines or the poles run away.
pub fn fit_with_delay(
    measured: &FrequencyResponse,
    domain: Domain,
    settings: &RationalSettings,
) -> Result<Choice, Error> {
    let step = match domain {
        Domain::Discrete(period) => period,
        Domain::Continuous => settings.longest_delay / DELAYS as f64,
    };
    let count = if step > 0.0 { (settings.longest_delay / step).round() as usize } else { 0 };
    let mut best: (f64, f64) = (0.0, f64::INFINITY);
    let mut start = None;
    if count > 0 {
        let quick = RationalSettings { rounds: 8, ..*settings };
        let try_delay = |delay: f64, start: &mut Option<Basis>| -> Option<f64> {
            let (_, misfit, basis) =
                fit_at(measured, domain, &quick, delay, DELAY_LINES, start.take()).ok()?;
            *start = Some(basis);
            Some(misfit)
        };
        for k in 0..=count {
            let delay = k as f64 * step;
            let Some(misfit) = try_delay(delay, &mut start) else { continue };
            if misfit < best.1 {
                best = (delay, misfit);
            }
        }
        if domain == Domain::Continuous {
            // Halving about the best of the grid.
            let mut width = step;
            for _ in 0..6 {
                width *= 0.5;
                for delay in [best.0 - width, best.0 + width] {
                    if let Some(misfit) = try_delay(delay.max(0.0), &mut start)
                        && misfit < best.1
                    {
                        best = (delay.max(0.0), misfit);
                    }
                }
            }
        }
    }
    let delay = best.0;
    let (_, _, mut basis) = fit_at(measured, domain, settings, delay, SEARCH_LINES, None)?;
    if settings.is_held {
        let lowest = measured.lines.first().map_or(0.0, |line| line.frequency);
        basis.poles.retain(|pole| {
            let is_decay = domain == Domain::Continuous || pole.re > 0.0;
            let is_of_plant = pole.im != 0.0 || (is_decay && settings.single > 0);
            let corner = domain.continuous(*pole).norm() / core::f64::consts::TAU;
            is_of_plant && corner > LOWEST * lowest
        });
    }
    let all = Prepared::new(measured, domain, settings.by_deviation, usize::MAX, delay);
    let (model, misfit) = residues(&basis, &all.samples(), delay)?;
    let elements = model.direct.len();
    let numbers = basis.width() + elements * (basis.width() + 1);
    let count = (2 * measured.lines.len() * elements) as f64;
    let length = misfit.max(f64::MIN_POSITIVE).ln() + numbers as f64 * count.ln() / count;
    Ok(Choice { model, misfit, length })
}

/// The number of pairs of least description length, from 1 to `most`; all that were tried, and the place
/// of the best.
///
/// # Errors
/// [`Error::NoSolution`] where no number of pairs has a fit.
pub fn choose(
    measured: &FrequencyResponse,
    domain: Domain,
    settings: &RationalSettings,
    most: usize,
) -> Result<(Vec<(usize, Choice)>, usize), Error> {
    let mut tried: Vec<(usize, Choice)> = Vec::new();
    let mut last = None;
    let threads = numerics::threads::pool(0)
        .map_err(|_| Error::no_solution("the system gives this program no thread"))?;
    for pairs in 1..=most.max(1) {
        let settings = RationalSettings { pairs, ..*settings };
        match threads.install(|| fit_with_delay(measured, domain, &settings)) {
            Ok(choice) => tried.push((pairs, choice)),
            Err(error) => last = Some(error),
        }
    }
    let best = (0..tried.len()).min_by(|a, b| tried[*a].1.length.total_cmp(&tried[*b].1.length));
    match (best, last) {
        (Some(best), _) => Ok((tried, best)),
        (None, Some(error)) => Err(error),
        (None, None) => Err(Error::no_solution("no order was tried")),
    }
}

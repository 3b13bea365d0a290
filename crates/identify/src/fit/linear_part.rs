//! The linear parts: delay, amplifier lag, mode, by an output-error fit.
//!
//! The residual of the whole simulated chain is minimised over the few nonlinear parameters; for
//! each of their values the weights are the best ones (variable projection), so that hysteresis and
//! dynamics are fitted together and not in turns. A scan over frequencies gives the start, since the
//! sum of squares has one valley per wrong frequency.
//!
//! Source: G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413–432 (variable projection).

use core::f64::consts::TAU;

use numerics::levenberg_marquardt::{PATIENT, minimise};

use crate::error::Error;
use crate::methods::FitContext;

use super::coordinates::{Coordinates, Structure, visible};
use super::operator::{Fit, Operator};
use super::residual::independent_samples;
use super::response::{LinearPart, ModeShape};

/// Plays of the scan, which needs the rough shape of the hysteresis only.
const SCAN_PLAYS: usize = 6;
/// Frequencies of the scan per decade.
const SCAN_DENSITY: f64 = 16.0;
/// Damping ratios of the scan: a light mode and a broad one.
const SCAN_DAMPING: [f64; 2] = [0.03, 0.3];
/// Internal steps per period of a mode where its input changes within a sample.
const STEPS_PER_CYCLE: f64 = 20.0;
/// Most internal steps per sample.
const MOST_SUBSTEPS: f64 = 16.0;

/// Fits the linear parts of `structure` together with the weights of a method without a shape, from `known` on: the
/// linear parts of a simpler structure. The operator gets the internal steps that they need.
///
/// # Errors
/// [`Error::NoSolution`] where the search does not converge, and those of [`Operator::solve`].
pub(crate) fn fit(
    operator: &mut Operator<'_>,
    structure: Structure,
    longest_delay: f64,
    known: &LinearPart,
    report: &mut dyn FnMut(usize, usize),
) -> Result<Fit, Error> {
    let start = scan(operator, structure, known, report)?;
    operator.substeps = substeps(&start, operator.period);
    let coordinates = Coordinates { structure, period: operator.period };
    let range = visible(operator.records, operator.rows);
    let unknowns = coordinates.unknowns(&start, longest_delay, &range);
    let solve = |p: &[f64]| operator.solve(coordinates.linear(p), &[]);
    let residuals = |p: &[f64]| solve(p).map(|solved| solved.residual().to_vec());
    let report = |iteration| report(iteration, PATIENT.iterations);
    let minimum = minimise(&unknowns, PATIENT, residuals, report)?;
    let solved = solve(&minimum.parameters)?;
    let degrees = independent_samples(solved.residual()) - minimum.parameters.len() as f64;
    let noise = solved.cost() / degrees.max(1.0);
    // Correlated residuals: the variance grows by samples over independent samples.
    let deviation = |v: Option<f64>| v.map(|v| (v * noise).sqrt());
    let deviations: Vec<_> = minimum.variance.iter().map(|v| deviation(*v)).collect();
    let deviations = coordinates.deviations(&solved.linear, &deviations);
    Ok(Fit::of(solved, deviations))
}

/// Internal steps per sample: more than one only where the mode's input changes within a sample.
pub(crate) fn substeps(linear: &LinearPart, period: f64) -> usize {
    match (linear.bandwidth, linear.mode) {
        (Some(_), Some(mode)) => {
            (STEPS_PER_CYCLE * mode.frequency * period).ceil().clamp(1.0, MOST_SUBSTEPS) as usize
        }
        _ => 1,
    }
}

/// The best start on a grid of frequencies, with a coarse hysteresis.
fn scan(
    operator: &Operator<'_>,
    structure: Structure,
    known: &LinearPart,
    report: &mut dyn FnMut(usize, usize),
) -> Result<LinearPart, Error> {
    let stride = operator.scene.thresholds.len().div_ceil(SCAN_PLAYS).max(1);
    let thresholds = operator.scene.thresholds.iter().copied().step_by(stride).collect();
    let scene = FitContext { thresholds, ..operator.scene.clone() };
    let coarse = Operator { scene: &scene, substeps: 1, ..*operator };
    let (lowest, highest) = visible(operator.records, operator.rows);
    let count = ((highest / lowest).log10() * SCAN_DENSITY).ceil().max(2.0) as usize;
    let grid: Vec<f64> = (0..count)
        .map(|k| lowest * (highest / lowest).powf(k as f64 / (count - 1) as f64))
        .collect();
    let candidates = candidates(structure, &grid, known);
    let mut best: Option<(f64, LinearPart)> = None;
    for (done, &linear) in candidates.iter().enumerate() {
        report(done, candidates.len());
        let sum = coarse.solve(linear, &[])?.cost();
        if best.is_none_or(|(least, _)| sum < least) {
            best = Some((sum, linear));
        }
    }
    best.map(|(_, linear)| linear).ok_or(Error::no_solution("there is no frequency to start from"))
}

/// Points of the scan: a lag or a mode in addition to what is known. Either explains a part of the
/// delay, so that part or all of it is taken off.
fn candidates(structure: Structure, grid: &[f64], known: &LinearPart) -> Vec<LinearPart> {
    let mut all = Vec::new();
    for &frequency in grid {
        if structure.lag && (known.mode.is_some() || !structure.mode) {
            let bandwidth = Some(frequency);
            let delay = (known.delay - 1.0 / (TAU * frequency)).max(0.0);
            all.push(LinearPart { bandwidth, delay, ..*known });
            all.push(LinearPart { bandwidth, ..*known });
        } else {
            for damping in SCAN_DAMPING {
                let mode = Some(ModeShape { frequency, damping });
                let bandwidth =
                    structure.lag.then(|| known.bandwidth.unwrap_or(grid[grid.len() - 1]));
                all.push(LinearPart { delay: known.delay, bandwidth, mode });
                all.push(LinearPart { delay: 0.0, bandwidth, mode });
            }
        }
    }
    all
}

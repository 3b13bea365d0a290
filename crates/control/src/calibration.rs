//! The Jacobian of coupled axes from their simultaneous motion.
//!
//! ```text
//! p_i = Σ_j J_ij·θ_j + p0_i      least squares, coordinate by coordinate, over the entries that are no
//!                                structural zeros: M = X·Ψᵀ·(Ψ·Ψᵀ)⁻¹
//! ```
//!
//! * Motions are known (driven through inverse models) or measured; positions are measured, all at the
//!   same instants. Where the sensors lag, `longest_delay` lets one common delay of the motions be
//!   found, by the least residual, in quarters of a sample.
//! * The half width of the 95 % interval of each value comes from the residual's variance; as
//!   residuals follow each other, the number of samples is counted as n·(1 − ρ)/(1 + ρ) with their
//!   correlation ρ from one sample to the next, where that is positive.
//! * Motion that does not determine the values is refused, and the axis named.
//!
//! Source: laser beam pointing with four piezo axes, eqs. (15)–(17); effective number of samples:
//! G. E. P. Box, G. M. Jenkins, Time Series Analysis, ch. 2.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use identify::Error;

/// Least singular value of the standardised motions, relative to the greatest.
const LEAST_INDEPENDENCE: f64 = 1e-3;
/// An axis whose standard deviation is below this part of the widest one's has not moved.
const LEAST_MOTION: f64 = 1e-4;

/// The motions and positions of one calibration, each a list of samples per axis.
#[derive(Clone, Debug)]
pub struct CalibrationRecord {
    /// Names and samples of the motions θ.
    pub motions: Vec<(String, Vec<f64>)>,
    /// Names and samples of the coordinates p.
    pub positions: Vec<(String, Vec<f64>)>,
    /// First sample of each record; the first is 0.
    pub starts: Vec<usize>,
    /// For each coordinate, whether it does not see an axis.
    pub zeros: Vec<Vec<bool>>,
    /// Most samples by which the motions may be late.
    pub longest_delay: f64,
}

/// One row of J.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoordinateFit {
    /// The coordinate's name.
    pub coordinate: String,
    /// The coordinate fit's row of J; structural zeros are 0.
    pub row: Vec<f64>,
    /// Half widths of the 95 % intervals of the row.
    pub row_ci95: Vec<f64>,
    /// The coordinate fit's offset p0.
    pub offset: f64,
    /// Half width of the 95 % interval of the offset.
    pub offset_ci95: f64,
    /// Root mean square residual.
    pub rms: f64,
}

/// A calibrated Jacobian.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// The calibration's rows.
    pub coordinates: Vec<CoordinateFit>,
    /// Greatest over least singular value of J; infinite where J is singular, `None` where it is not
    /// square.
    pub condition: Option<f64>,
    /// Greatest over least singular value of the motions, each with standard deviation 1.
    pub motion_condition: f64,
    /// Samples by which the motions were delayed.
    pub delay: f64,
    /// Samples used.
    pub samples: usize,
}

/// Fits J and p0.
///
/// # Errors
/// [`Error::Calibration`] where axes do not move, or not independently, or lists do not fit together.
pub fn calibrate(record: &CalibrationRecord) -> Result<Calibration, Error> {
    let samples = record.motions.first().map_or(0, |(_, m)| m.len());
    let lengths = record.motions.iter().chain(&record.positions);
    if let Some((name, values)) = lengths.clone().find(|(_, v)| v.len() != samples) {
        return refuse(format!(
            "{name} has {} samples and {} has {samples}; give all of the same rows",
            values.len(),
            record.motions[0].0
        ));
    }
    if let Some((name, _)) = lengths.clone().find(|(_, v)| v.iter().any(|x| !x.is_finite())) {
        return refuse(format!("{name} has values that are no numbers; leave these rows out"));
    }
    if record.zeros.len() != record.positions.len()
        || record.zeros.iter().any(|row| row.len() != record.motions.len())
    {
        return refuse("the structural zeros do not have a row per coordinate".into());
    }
    let unknowns = record.motions.len() + 1;
    if samples < 2 * unknowns {
        return refuse(format!(
            "{samples} samples for {unknowns} unknowns per coordinate; measure at least {}",
            2 * unknowns
        ));
    }
    let motion_condition = independence(&record.motions)?;
    let quarters = (4.0 * record.longest_delay.max(0.0)).floor() as usize;
    let mut best: Option<(f64, f64, Vec<CoordinateFit>)> = None;
    for delay in (0..=quarters).map(|quarter| quarter as f64 / 4.0) {
        let rows = rows_for(record, delay);
        let fits = fits(record, &rows, delay)?;
        let misfit: f64 = fits.iter().map(|fit| fit.rms * fit.rms).sum();
        if best.as_ref().is_none_or(|(least, _, _)| misfit < *least) {
            best = Some((misfit, delay, fits));
        }
    }
    let Some((_, delay, coordinates)) = best else {
        return refuse("no delay was tried".into());
    };
    let condition = (coordinates.len() == record.motions.len()).then(|| {
        let n = coordinates.len();
        let mut entries: Vec<f64> = coordinates.iter().flat_map(|fit| fit.row.clone()).collect();
        components::control::condition(&mut entries, n)
    });
    let samples = rows_for(record, delay).len();
    Ok(Calibration { coordinates, condition, motion_condition, delay, samples })
}

fn refuse<T>(message: String) -> Result<T, Error> {
    Err(Error::Calibration { message })
}

/// The rows whose delayed motions lie in their own record.
fn rows_for(record: &CalibrationRecord, delay: f64) -> Vec<usize> {
    let samples = record.motions.first().map_or(0, |(_, m)| m.len());
    let needed = delay.ceil() as usize;
    let start_of = |row: usize| record.starts.iter().rev().find(|s| **s <= row).copied();
    (0..samples).filter(|row| start_of(*row).unwrap_or(0) + needed <= *row).collect()
}

/// Condition number of the motions about their means, each scaled to standard deviation 1.
fn independence(motions: &[(String, Vec<f64>)]) -> Result<f64, Error> {
    let deviations: Vec<(f64, f64)> = motions
        .iter()
        .map(|(_, values)| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
            (mean, (variance / values.len() as f64).sqrt())
        })
        .collect();
    let widest = deviations.iter().map(|d| d.1).fold(0.0, f64::max);
    for ((name, _), (_, deviation)) in motions.iter().zip(&deviations) {
        if *deviation <= LEAST_MOTION * widest {
            return refuse(format!(
                "{name} did not move (standard deviation {deviation:.3e}, the widest motion's is \
                 {widest:.3e}): its column of the Jacobian cannot be determined; move all axes at \
                 once, each in its own way"
            ));
        }
    }
    let rows = motions[0].1.len();
    let scaled = DMatrix::from_fn(rows, motions.len(), |i, j| {
        (motions[j].1[i] - deviations[j].0) / deviations[j].1
    });
    let svd = scaled.svd(false, true);
    let (greatest, least) = (svd.singular_values.max(), svd.singular_values.min());
    if least > LEAST_INDEPENDENCE * greatest {
        return Ok(greatest / least);
    }
    let at = svd.singular_values.imin();
    let direction = svd.v_t.map(|v| v.row(at).iter().copied().collect::<Vec<f64>>());
    let direction = direction.unwrap_or_default();
    let largest = direction.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let names: Vec<&str> = motions
        .iter()
        .zip(&direction)
        .filter(|(_, x)| x.abs() > 0.1 * largest)
        .map(|((name, _), _)| name.as_str())
        .collect();
    refuse(format!(
        "{} moved together (condition number {:.1e}): their columns of the Jacobian cannot be distinguished; give each axis its own frequency",
        names.join(" and "),
        greatest / least.max(f64::MIN_POSITIVE)
    ))
}

fn fits(
    record: &CalibrationRecord,
    rows: &[usize],
    delay: f64,
) -> Result<Vec<CoordinateFit>, Error> {
    let (integer, fraction) = (delay.floor() as usize, delay - delay.floor());
    let motion = |axis: usize, row: usize| {
        let values = &record.motions[axis].1;
        let newer = values[row - integer];
        if fraction == 0.0 { newer } else { newer + fraction * (values[row - integer - 1] - newer) }
    };
    record
        .positions
        .iter()
        .zip(&record.zeros)
        .map(|((name, positions), zeros)| {
            let seen: Vec<usize> = (0..zeros.len()).filter(|axis| !zeros[*axis]).collect();
            let matrix = DMatrix::from_fn(rows.len(), seen.len() + 1, |i, j| {
                seen.get(j).map_or(1.0, |axis| motion(*axis, rows[i]))
            });
            let right = DVector::from_fn(rows.len(), |i, _| positions[rows[i]]);
            let gram = matrix.tr_mul(&matrix);
            let Some(inverse) = gram.cholesky().map(|c| c.inverse()) else {
                return refuse(format!("the motions do not determine {name}; move all axes more"));
            };
            let solution = &inverse * matrix.tr_mul(&right);
            let residual = &right - &matrix * &solution;
            let squares = residual.norm_squared();
            let freedom = (rows.len() - seen.len() - 1).max(1) as f64;
            let lagged: f64 = residual.as_slice().windows(2).map(|w| w[0] * w[1]).sum();
            let rho = if squares > 0.0 { (lagged / squares).clamp(0.0, 0.999) } else { 0.0 };
            let variance = squares / freedom * (1.0 + rho) / (1.0 - rho);
            let half_width = |k: usize| 1.96 * (variance * inverse[(k, k)]).sqrt();
            let mut fit = CoordinateFit {
                coordinate: name.clone(),
                row: vec![0.0; zeros.len()],
                row_ci95: vec![0.0; zeros.len()],
                offset: solution[seen.len()],
                offset_ci95: half_width(seen.len()),
                rms: (squares / rows.len() as f64).sqrt(),
            };
            for (k, axis) in seen.iter().enumerate() {
                (fit.row[*axis], fit.row_ci95[*axis]) = (solution[k], half_width(k));
            }
            Ok(fit)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const J: [[f64; 3]; 3] = [[500.0, 3.0, 0.0], [14.0, -515.0, 0.0], [210.0, -12.0, -129.0]];
    const P0: [f64; 3] = [-261.0, 272.0, -46.0];

    /// Sines of 3, 4 and 5 waves in 1000 samples; positions `late` samples later, with white noise.
    fn record(noise: f64, late: f64, waves: [f64; 3]) -> CalibrationRecord {
        let at = |axis: usize, k: f64| {
            0.5 - 0.4 * (core::f64::consts::TAU * waves[axis] * k / 1000.0).cos()
        };
        let motions = (0..3)
            .map(|axis| {
                let values = (0..1000).map(|k| at(axis, f64::from(k)));
                (format!("theta{}", axis + 1), values.collect())
            })
            .collect();
        let mut random = numerics::random::SplitMix64::new(1);
        let mut draw = move || (random.uniform() - 0.5) * 12.0_f64.sqrt();
        let positions = (0..3)
            .map(|i| {
                let values = (0..1000).map(|k| {
                    let t = f64::from(k) - late;
                    let p: f64 = (0..3).map(|j| J[i][j] * at(j, t)).sum();
                    p + P0[i] + noise * draw()
                });
                (format!("p{}", i + 1), values.collect())
            })
            .collect();
        let zeros = J.iter().map(|row| row.iter().map(|x| *x == 0.0).collect()).collect();
        CalibrationRecord { motions, positions, starts: vec![0], zeros, longest_delay: 0.0 }
    }

    #[test]
    fn a_known_jacobian_is_found_with_its_zeros() {
        let found = calibrate(&record(0.0, 0.0, [3.0, 4.0, 5.0])).unwrap();
        for (fit, (row, p0)) in found.coordinates.iter().zip(J.iter().zip(P0)) {
            assert!((fit.offset - p0).abs() < 1e-9 && fit.rms < 1e-9, "{fit:?}");
            for (a, b) in fit.row.iter().zip(row) {
                assert!(if *b == 0.0 { *a == 0.0 } else { (a - b).abs() < 1e-9 }, "{fit:?}");
            }
        }
        assert!(found.condition.is_some_and(|c| (3.0..10.0).contains(&c)), "{found:?}");
        assert!(found.motion_condition < 1.1);
    }

    #[test]
    fn the_intervals_hold_the_truth_about_as_often_as_they_say() {
        let found = calibrate(&record(2.0, 0.0, [3.0, 4.0, 5.0])).unwrap();
        let mut inside = 0;
        for (fit, (row, p0)) in found.coordinates.iter().zip(J.iter().zip(P0)) {
            inside += u32::from((fit.offset - p0).abs() <= fit.offset_ci95);
            for ((a, b), width) in fit.row.iter().zip(row).zip(&fit.row_ci95) {
                inside += u32::from((a - b).abs() <= *width);
            }
            // sigma·√2/(amplitude·√n) per column.
            let exact = 1.96 * 2.0 * 2.0_f64.sqrt() / (0.4 * 1000.0_f64.sqrt());
            assert!((fit.row_ci95[0] / exact - 1.0).abs() < 0.2, "{fit:?}, {exact}");
        }
        // Ten values and two zeros.
        assert!(inside >= 10, "{inside}: {found:?}");
    }

    #[test]
    fn a_delay_of_the_sensors_is_found() {
        let late = record(0.01, 3.25, [3.0, 4.0, 5.0]);
        let found = calibrate(&CalibrationRecord { longest_delay: 8.0, ..late }).unwrap();
        assert_eq!(found.delay, 3.25);
        assert!((found.coordinates[0].row[0] - 500.0).abs() < 0.05, "{found:?}");
    }

    #[test]
    fn an_axis_that_rests_and_axes_that_move_together_are_named() {
        let mut still = record(0.0, 0.0, [3.0, 4.0, 5.0]);
        still.motions[1].1.fill(0.3);
        let text = calibrate(&still).unwrap_err().to_string();
        assert!(text.contains("theta2 did not move"), "{text}");
        let text = calibrate(&record(0.0, 0.0, [3.0, 4.0, 3.0])).unwrap_err().to_string();
        assert!(text.contains("theta1 and theta3 moved together"), "{text}");
    }
}

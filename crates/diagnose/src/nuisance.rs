//! What each record brings with it that no model explains: an offset; and, for some candidates, a
//! drift or lines. These terms are linear in coefficients of each record's own, which are found by
//! linear least squares (variable projection).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::data_set::{DataSet, RecordData};
use crate::jitter;
use crate::thresholds::base::Thresholds;

/// A kind of terms.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Nuisance {
    /// Powers 1 to `order` of the record's time.
    Drift {
        /// Highest power.
        order: usize,
    },
    /// `exp(−t/τ)` and t; τ is the parameter with this number, in its coordinate's value.
    Settling {
        /// Number of the time constant.
        parameter: usize,
    },
    /// Sines and cosines of a frequency and its multiples.
    Lines {
        /// Number of the frequency's parameter.
        parameter: usize,
        /// Number of multiples.
        harmonics: usize,
    },
    /// Sines and cosines of a frequency times the reading: a gain that changes with time.
    Modulation {
        /// Number of the frequency's parameter.
        parameter: usize,
    },
    /// Sines and cosines of a frequency times the rate of the simulated output: instants that swing.
    Jitter {
        /// Number of the frequency's parameter.
        parameter: usize,
    },
    /// Straight lines between this many equidistant knots.
    Knots {
        /// Number of knots.
        count: usize,
    },
}

impl Nuisance {
    /// This nuisance with its parameter's number counted from `first`.
    pub(crate) fn shifted(&self, first: usize) -> Self {
        match self {
            Self::Settling { parameter } => Self::Settling { parameter: parameter + first },
            Self::Lines { parameter, harmonics } => {
                Self::Lines { parameter: parameter + first, harmonics: *harmonics }
            }
            Self::Modulation { parameter } => Self::Modulation { parameter: parameter + first },
            Self::Jitter { parameter } => Self::Jitter { parameter: parameter + first },
            other => other.clone(),
        }
    }

    /// Whether its terms depend on no parameter.
    pub(crate) fn is_fixed(&self) -> bool {
        matches!(self, Self::Drift { .. } | Self::Knots { .. })
    }

    /// Whether it is a course without a formula.
    pub(crate) fn is_free_course(&self) -> bool {
        matches!(self, Self::Knots { .. })
    }

    /// Whether its terms depend on what is simulated.
    pub(crate) fn is_of_simulation(&self) -> bool {
        matches!(self, Self::Jitter { .. })
    }

    /// Coefficients per record.
    pub(crate) fn count(&self) -> usize {
        match self {
            Self::Drift { order } => *order,
            Self::Settling { .. } | Self::Modulation { .. } | Self::Jitter { .. } => 2,
            Self::Lines { harmonics, .. } => 2 * harmonics,
            Self::Knots { count } => *count,
        }
    }

    /// Frequencies in Hz of noise that the terms of a record of this length take out as if it were theirs.
    pub(crate) fn frequencies(&self, values: &[f64], length: f64) -> Vec<f64> {
        let value = |parameter: usize| values.get(parameter).copied().unwrap_or(1.0);
        // Of noise with the density 1/f, the k-th Legendre polynomial over the length T holds as much as a
        // line at (k/2 + 0.18)/T (simulated for the first five).
        let slow = |count: usize| (1..=count).map(|k| (0.5 * k as f64 + 0.18) / length).collect();
        match self {
            Self::Drift { order: count } | Self::Knots { count } => slow(*count),
            Self::Settling { .. } => slow(2),
            Self::Lines { parameter, harmonics } => {
                (1..=*harmonics).flat_map(|k| [value(*parameter) * k as f64; 2]).collect()
            }
            // As white as the reading or its rate is wide.
            Self::Modulation { .. } | Self::Jitter { .. } => vec![f64::INFINITY; 2],
        }
    }

    /// The terms at time t of a record of this length, where the reading over its range is y and the
    /// simulated one moves by v per row; z is t over the record from −1 to 1.
    fn terms(
        &self,
        values: &[f64],
        (t, length): (f64, f64),
        (y, v): (f64, f64),
        row: &mut Vec<f64>,
    ) {
        let z = 2.0 * t / length - 1.0;
        let value = |parameter: usize| values.get(parameter).copied().unwrap_or(1.0);
        match self {
            Self::Drift { order } => {
                let mut power = 1.0;
                for _ in 0..*order {
                    power *= z;
                    row.push(power);
                }
            }
            Self::Settling { parameter } => {
                row.push((-t / value(*parameter)).exp());
                row.push(z);
            }
            Self::Lines { parameter, harmonics } => {
                for k in 1..=*harmonics {
                    let angle = std::f64::consts::TAU * value(*parameter) * k as f64 * t;
                    let (s, c) = angle.sin_cos();
                    row.push(s);
                    row.push(c);
                }
            }
            Self::Modulation { parameter } | Self::Jitter { parameter } => {
                let (s, c) = (std::f64::consts::TAU * value(*parameter) * t).sin_cos();
                let carrier = if matches!(self, Self::Jitter { .. }) { v } else { y };
                row.push(carrier * s);
                row.push(carrier * c);
            }
            Self::Knots { count } => {
                let place = 0.5 * (z + 1.0) * *count as f64;
                for k in 1..=*count {
                    row.push((1.0 - (place - k as f64).abs()).max(0.0));
                }
            }
        }
    }
}

/// Takes the terms out of signals at the rows that are fitted, and continues them beyond.
pub(crate) struct Projector {
    nuisances: Vec<Nuisance>,
    values: Vec<f64>,
    /// Rate of the simulated output over its range per row, where some terms depend on it.
    rate: Vec<f64>,
    records: Vec<Terms>,
}

fn subtract(residual: &mut [f64], rows: std::ops::Range<usize>, course: &DVector<f64>) {
    residual[rows].iter_mut().zip(course.iter()).for_each(|(r, f)| *r -= f);
}

/// The terms of one record.
struct Terms {
    /// Rows of the fit, in the fit's vectors.
    places: std::ops::Range<usize>,
    basis: DMatrix<f64>,
    normal: Option<Cholesky<f64, Dyn>>,
}

impl Projector {
    /// The terms for natural parameter values and what is simulated with them.
    pub(crate) fn new(
        nuisances: &[Nuisance],
        values: Vec<f64>,
        data: &DataSet,
        simulated: &[f64],
    ) -> Self {
        let depends = nuisances.iter().any(Nuisance::is_of_simulation);
        let rate = || jitter::rate(&data.at_rows(simulated), data);
        let rate = if depends { rate() } else { Vec::new() };
        let nuisances = nuisances.to_vec();
        let mut projector = Self { nuisances, values, rate, records: Vec::new() };
        for record in &data.records {
            let rows = &data.fit_rows[record.fit.clone()];
            let basis = projector.basis(record, data, rows.iter().map(|row| *row as usize));
            let normal = factor(basis.tr_mul(&basis), basis.nrows());
            projector.records.push(Terms { places: record.fit.clone(), basis, normal });
        }
        projector
    }

    fn basis(
        &self,
        record: &RecordData,
        data: &DataSet,
        rows: impl ExactSizeIterator<Item = usize>,
    ) -> DMatrix<f64> {
        let columns = 1 + self.nuisances.iter().map(Nuisance::count).sum::<usize>();
        let count = rows.len();
        let mut all = Vec::with_capacity(count * columns);
        let start = data.time[record.rows.start];
        let length = (data.time[record.rows.end - 1] - start).max(f64::MIN_POSITIVE);
        for row in rows {
            all.push(1.0);
            for nuisance in &self.nuisances {
                let rate = self.rate.get(row).copied().unwrap_or(0.0);
                let carriers = (data.y[row] / data.output_span.half, rate);
                nuisance.terms(&self.values, (data.time[row] - start, length), carriers, &mut all);
            }
        }
        DMatrix::from_row_slice(count, columns, &all)
    }

    /// Takes the terms out of a vector over the rows of the fit.
    pub(crate) fn project(&self, vector: &mut [f64]) {
        for terms in &self.records {
            let part = &mut vector[terms.places.clone()];
            if part.is_empty() {
                continue;
            }
            if self.nuisances.is_empty() {
                let mean = part.iter().sum::<f64>() / part.len() as f64;
                part.iter_mut().for_each(|v| *v -= mean);
                continue;
            }
            let Some(normal) = &terms.normal else { continue };
            let values = DVector::from_column_slice(part);
            let coefficients = normal.solve(&terms.basis.tr_mul(&values));
            let fitted = &terms.basis * coefficients;
            part.iter_mut().zip(fitted.iter()).for_each(|(v, f)| *v -= f);
        }
    }

    /// The offset of each record that is fitted, beside its other terms.
    pub(crate) fn offsets(&self, data: &DataSet, residual: &[f64]) -> Vec<f64> {
        let fitted = data.records.iter().zip(&self.records).filter(|(r, _)| !r.fit.is_empty());
        let offset = |(record, terms): (&RecordData, &Terms)| {
            let rows = &data.fit_rows[record.fit.clone()];
            let values = rows.iter().map(|row| residual[*row as usize]);
            let values = DVector::from_iterator(record.fit.len(), values);
            Some(terms.normal.as_ref()?.solve(&terms.basis.tr_mul(&values))[0])
        };
        fitted.filter_map(offset).collect()
    }

    /// Takes the terms that the fitted rows give out of all rows. A record without fitted rows judges: there
    /// each half is foretold by the terms of the other one, and nothing but one offset is fitted to all of it.
    pub(crate) fn extend(&self, data: &DataSet, residual: &mut [f64]) {
        for (record, terms) in data.records.iter().zip(&self.records) {
            if record.fit.is_empty() {
                self.foretell(record, data, residual);
                continue;
            }
            let Some(normal) = &terms.normal else { continue };
            let fitted =
                data.fit_rows[record.fit.clone()].iter().map(|row| residual[*row as usize]);
            let values = DVector::from_iterator(record.fit.len(), fitted);
            let coefficients = normal.solve(&terms.basis.tr_mul(&values));
            let all = self.basis(record, data, record.rows.clone());
            subtract(residual, record.rows.clone(), &(all * coefficients));
        }
    }

    /// Takes out of each half of a record what the terms fitted to the other half foretell, then the mean.
    fn foretell(&self, record: &RecordData, data: &DataSet, residual: &mut [f64]) {
        let rows = record.rows.clone();
        if !self.nuisances.is_empty() {
            let middle = rows.start + rows.len() / 2;
            let halves = [rows.start..middle, middle..rows.end];
            let courses = [(0, 1), (1, 0)].map(|(from, to): (usize, usize)| {
                let basis = self.basis(record, data, halves[from].clone());
                let normal = factor(basis.tr_mul(&basis), basis.nrows())?;
                let values = DVector::from_column_slice(&residual[halves[from].clone()]);
                let mut coefficients = normal.solve(&basis.tr_mul(&values));
                // The offset is that of all rows.
                coefficients[0] = 0.0;
                Some((to, self.basis(record, data, halves[to].clone()) * coefficients))
            });
            for (to, course) in courses.into_iter().flatten() {
                subtract(residual, halves[to].clone(), &course);
            }
        }
        let part = &mut residual[rows];
        let mean = part.iter().sum::<f64>() / part.len().max(1) as f64;
        part.iter_mut().for_each(|r| *r -= mean);
    }
}

/// The factor of normal equations over so many rows.
fn factor(mut normal: DMatrix<f64>, rows: usize) -> Option<Cholesky<f64, Dyn>> {
    // A ridge far below the data: a term that does not move in this record stays at zero.
    let ridge = 1e-9 * rows.max(1) as f64;
    for k in 0..normal.nrows() {
        normal[(k, k)] += ridge;
    }
    Cholesky::new(normal)
}

/// Takes a course out of each record that nothing causes, so that nothing foretells it: each piece is compared with
/// the course through the rows around it.
pub(crate) fn take_own_course(data: &DataSet, residual: &mut [f64]) {
    let nuisances = vec![Nuisance::Knots { count: Thresholds::OWN_KNOTS }];
    let (values, rate, records) = (Vec::new(), Vec::new(), Vec::new());
    let course = Projector { nuisances, values, rate, records };
    for record in &data.records {
        let rows = record.rows.clone();
        let basis = course.basis(record, data, rows.clone());
        let all = DVector::from_column_slice(&residual[rows.clone()]);
        let (normal, right) = (basis.tr_mul(&basis), basis.tr_mul(&all));
        let length = rows.len().div_ceil(2 * Thresholds::OWN_KNOTS);
        for from in (0..rows.len()).step_by(length) {
            let size = length.min(rows.len() - from);
            let piece = basis.rows(from, size);
            let surrounding = factor(&normal - piece.tr_mul(&piece), rows.len());
            let Some(surrounding) = surrounding else { continue };
            let course = piece * surrounding.solve(&(&right - piece.tr_mul(&all.rows(from, size))));
            subtract(residual, rows.start + from..rows.start + from + size, &course);
        }
    }
}

/// The values that nuisances depend on.
pub(crate) fn relevant(nuisances: &[Nuisance], values: &[f64]) -> Vec<f64> {
    nuisances
        .iter()
        .filter_map(|n| match n {
            Nuisance::Settling { parameter }
            | Nuisance::Lines { parameter, .. }
            | Nuisance::Modulation { parameter }
            | Nuisance::Jitter { parameter } => values.get(*parameter).copied(),
            Nuisance::Drift { .. } | Nuisance::Knots { .. } => None,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data_set::RecordRows;

    const ROWS: usize = 1000;

    /// A record that only judges.
    fn judging() -> DataSet {
        DataSet::new(vec![RecordRows::still(ROWS, 0.0)], &[], None)
    }

    /// What is left of a residual there.
    fn left(nuisance: Nuisance, mut residual: Vec<f64>) -> Vec<f64> {
        let data = judging();
        let simulated = vec![0.0; data.command.len()];
        Projector::new(&[nuisance], Vec::new(), &data, &simulated).extend(&data, &mut residual);
        residual
    }

    #[test]
    fn rows_that_judge_are_not_fitted_by_a_free_course() {
        let bump = (0..ROWS).map(|k| f64::from((600..700).contains(&k))).collect();
        let left = left(Nuisance::Knots { count: 8 }, bump);
        // Its own half must not take it; only the mean of all rows goes.
        assert!((left[650] - left[950] - 1.0).abs() < 1e-9, "{}", left[650] - left[950]);
        assert!(left.iter().sum::<f64>().abs() < 1e-9);
    }

    #[test]
    fn a_course_of_its_own_is_seen_from_the_neighbouring_rows() {
        let course = |k: usize| (0.012 * k as f64).sin();
        let mut residual: Vec<f64> = (0..ROWS).map(course).collect();
        // A bump shorter than a piece stays: its own rows do not count.
        residual[505..510].iter_mut().for_each(|r| *r += 1.0);
        take_own_course(&judging(), &mut residual);
        let left = residual;
        assert!((left[507] - 1.0).abs() < 0.05, "{}", left[507]);
        let rest = left.iter().enumerate().filter(|(k, _)| k.abs_diff(507) > 100);
        let worst = rest.map(|(_, r)| r.abs()).fold(0.0, f64::max);
        assert!(worst < 0.05, "{worst}");
    }

    #[test]
    fn a_drift_that_one_half_foretells_is_no_part_of_what_is_left() {
        let drift = (0..ROWS).map(|k| 5.0 + 2e-3 * k as f64).collect();
        let left = left(Nuisance::Drift { order: 1 }, drift);
        assert!(left.iter().all(|r| r.abs() < 1e-6), "{left:?}");
    }
}

//! What candidates promise in the first order, from sensitivities that they share.

use nalgebra::{DMatrix, DVector};
use numerics::least_squares::within;

use super::{Fitter, Work};
use crate::chain::Chain;
use crate::error::Failed;
use crate::normal::{dot, products};

/// A chain in the first order about a point.
pub(crate) struct Linear {
    pub(crate) residual: Vec<f64>,
    pub(crate) columns: Vec<Vec<f64>>,
    chain: Chain,
    squares: f64,
}

/// Sensitivities that candidates share, with their products.
struct Basis {
    /// Numbers of the chain's parameters.
    numbers: Vec<usize>,
    columns: Vec<Vec<f64>>,
    products: DMatrix<f64>,
}

impl<'a> Fitter<'a> {
    /// Residual at the rows of the fit, in standard deviations, and the sensitivities to all
    /// parameters: the point from which candidates are screened.
    pub(crate) fn linearise(self, chain: &'a Chain, theta: &[f64]) -> Result<Linear, Failed> {
        let mut work = self.work(chain);
        let point = work.keep(theta)?;
        let columns = work.columns(&point, 0..chain.parameters.len())?;
        let squares = point.squares;
        Ok(Linear { residual: point.residual, columns, chain: chain.clone(), squares })
    }

    /// Residual at the rows of the fit, in standard deviations.
    ///
    /// # Errors
    /// [`Failed`]: the chain cannot be simulated there.
    pub(crate) fn residual(self, chain: &'a Chain, theta: &[f64]) -> Result<Vec<f64>, Failed> {
        Ok(self.work(chain).keep(theta)?.residual)
    }

    /// For each start the part of the residual's squares that a candidate would take in the first
    /// order, with the parameters that are known moving along, and where that takes them; `screened` of its own parameters move.
    pub(crate) fn promises(
        self,
        chain: &'a Chain,
        known: &Linear,
        starts: &[Vec<f64>],
        screened: usize,
    ) -> Vec<Option<(f64, Vec<f64>)>> {
        let mut work = self.work(chain);
        let mut basis: Option<Basis> = None;
        starts.iter().map(|start| work.promise(known, start, screened, &mut basis).ok()).collect()
    }
}

impl Work<'_> {
    /// The known sensitivities as this chain sees them: its own terms per record taken out.
    pub(super) fn known(&self, known: &Linear) -> (Vec<usize>, Vec<Vec<f64>>) {
        let origin = self.chain().origin(&known.chain);
        let has_own_terms = self.chain().nuisances.len() > known.chain.nuisances.len();
        origin
            .iter()
            .enumerate()
            .filter_map(|(k, from)| Some((k, known.columns.get((*from)?)?)))
            .map(|(k, column)| {
                let mut column = column.clone();
                if let (true, Some((_, projector))) = (has_own_terms, &self.projector) {
                    projector.project(&mut column);
                }
                (k, column)
            })
            .unzip()
    }

    /// See [`Fitter::promises`].
    fn promise(
        &mut self,
        known: &Linear,
        start: &[f64],
        screened: usize,
        basis: &mut Option<Basis>,
    ) -> Result<(f64, Vec<f64>), Failed> {
        let point = self.keep(start)?;
        let changes = self.chain().nuisances.iter().any(|n| !n.is_fixed());
        if basis.is_none() || changes {
            let (numbers, columns) = self.known(known);
            let products = products(&columns);
            *basis = Some(Basis { numbers, columns, products });
        }
        let Some(basis) = basis else { return Err(Failed) };
        let is_own = |k: &usize| !basis.numbers.contains(k);
        let own: Vec<usize> =
            (0..self.chain().parameters.len()).filter(is_own).take(screened).collect();
        let own_columns = self.columns(&point, own.iter().copied())?;
        let shared = basis.columns.len();
        let all = shared + own_columns.len();
        let column = |k: usize| basis.columns.get(k).unwrap_or_else(|| &own_columns[k - shared]);
        let number = |k: usize| basis.numbers.get(k).copied().unwrap_or_else(|| own[k - shared]);
        let mut normal = DMatrix::zeros(all, all);
        normal.view_mut((0, 0), (shared, shared)).copy_from(&basis.products);
        for i in shared..all {
            for j in 0..=i {
                let value = dot(column(i), column(j));
                normal[(i, j)] = value;
                normal[(j, i)] = value;
            }
        }
        let data = normal.clone();
        let right = DVector::from_iterator(all, (0..all).map(|k| -dot(column(k), &point.residual)));
        let mut gradient = right.clone();
        // In units of the squares: priors weigh as much as the residual's own size says.
        let unit = point.squares.max(1.0) / self.fitter.effective();
        for k in 0..all {
            let prior = self.chain().parameters[number(k)].prior * unit;
            normal[(k, k)] = (normal[(k, k)] + prior) * (1.0 + 1e-9) + f64::MIN_POSITIVE;
            gradient[k] -= prior * point.theta[number(k)];
        }
        let parameters = &self.chain().parameters;
        let room: Vec<(f64, f64)> = (0..all)
            .map(|k| {
                let (p, q) = (&parameters[number(k)], point.theta[number(k)]);
                // Candidates' own bounds are no limit to a first-order promise.
                if p.is_base { (p.low - q, p.high - q) } else { (f64::MIN, f64::MAX) }
            })
            .collect();
        let step = within(&normal, &gradient, &room).ok_or(Failed)?;
        let left = point.squares - 2.0 * right.dot(&step) + (&data * &step).dot(&step);
        let mut to = point.theta.clone();
        (0..all).for_each(|k| to[number(k)] += step[k]);
        Ok((1.0 - (left / known.squares).max(0.0), to))
    }
}

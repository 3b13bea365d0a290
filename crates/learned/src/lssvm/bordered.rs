//! The inverse of the bordered matrix, from which samples are taken out without training again.
//!
//! ```text
//! A = [0 1ᵀ; 1 Ω + λI],  A⁻¹ = [c wᵀ; w B],  [b; α] = A⁻¹ [0; y]
//! without the samples V:  α' = α_K − B_KV B_VV⁻¹ α_V,  b' = b − w_V·B_VV⁻¹ α_V
//! ```

use crate::Error;
use crate::solve::dense::{
    Mat, add_lower, cholesky, divide, inverse, inverted_lower, solve_with, view, view_mut,
};
use crate::solve::{factorise, solve_factored};

/// `B`, `w`, `α` and `b`. Of the symmetric B the lower half counts.
pub(super) struct Bordered {
    pub(super) b: Mat,
    pub(super) w: Vec<f64>,
    pub(super) alpha: Vec<f64>,
    pub(super) bias: f64,
}

/// `α`, `b`, `w` and s = 1ᵀ(Ω + λI)⁻¹1 from the Cholesky factor.
fn solution(factor: &[f64], y: &[f64]) -> (Vec<f64>, f64, Vec<f64>, f64) {
    let n = y.len();
    let (mut a, mut u) = (y.to_vec(), vec![1.0; n]);
    solve_factored(factor, n, &mut a);
    solve_factored(factor, n, &mut u);
    let s: f64 = u.iter().sum();
    let bias = a.iter().sum::<f64>() / s;
    a.iter_mut().zip(&u).for_each(|(a, u)| *a -= bias * u);
    (a, bias, u, s)
}

impl Bordered {
    /// From the lower half of Ω, which is overwritten.
    pub(super) fn new(mut omega: Vec<f64>, lambda: f64, y: &[f64]) -> Result<Self, Error> {
        let n = y.len();
        factorise(&mut omega, n, lambda)?;
        let (alpha, bias, u, s) = solution(&omega, y);
        let mut b = inverse(&view(&omega, n, n));
        for (j, mut column) in b.column_iter_mut().enumerate() {
            let factor = u[j] / s;
            for (b, u) in column.iter_mut().zip(&u).skip(j) {
                *b -= factor * u;
            }
        }
        let w = u.iter().map(|u| u / s).collect();
        Ok(Self { b, w, alpha, bias })
    }

    /// An element of B.
    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.b[(i.max(j), i.min(j))]
    }

    pub(super) fn count(&self) -> usize {
        self.alpha.len()
    }

    /// Without the samples `gone`: `α'` of `kept` (in this order) and `b'`.
    pub(super) fn without(&self, kept: &[usize], gone: &[usize]) -> Option<(Vec<f64>, f64)> {
        let mut block = self.block(gone);
        cholesky(block.as_view_mut())?;
        let mut e = Mat::from_fn(gone.len(), 1, |i, _| self.alpha[gone[i]]);
        solve_with(&block.as_view(), e.as_view_mut());
        let change =
            |k: &usize| (0..gone.len()).map(|i| self.at(*k, gone[i]) * e[(i, 0)]).sum::<f64>();
        let alpha = kept.iter().map(|k| self.alpha[*k] - change(k)).collect();
        let bias: f64 = (0..gone.len()).map(|i| self.w[gone[i]] * e[(i, 0)]).sum();
        Some((alpha, self.bias - bias))
    }

    fn block(&self, of: &[usize]) -> Mat {
        Mat::from_fn(of.len(), of.len(), |i, j| self.at(of[i], of[j]))
    }

    /// Takes out the samples `gone`; `kept` are all others, rising.
    pub(super) fn take_out(&self, kept: &[usize], gone: &[usize]) -> Option<Self> {
        let (k, d) = (kept.len(), gone.len());
        let mut factor = self.block(gone);
        cholesky(factor.as_view_mut())?;
        // Y = R⁻¹ [B_DK | α_D | w_D]
        let mut y = Mat::from_fn(d, k + 2, |i, j| match j.checked_sub(k) {
            None => self.at(gone[i], kept[j]),
            Some(0) => self.alpha[gone[i]],
            Some(_) => self.w[gone[i]],
        });
        divide(&factor.as_view(), y.as_view_mut());
        let mut b = Mat::zeros(k, k);
        for j in 0..k {
            let (from, mut to) = (self.b.column(kept[j]), b.column_mut(j));
            for i in j..k {
                to[i] = from[kept[i]];
            }
        }
        let rows = y.columns(0, k);
        add_lower(&mut b.as_view_mut(), -1.0, &rows.transpose().as_view(), &rows);
        let product = |a: usize, b: usize| (0..d).map(|i| y[(i, a)] * y[(i, b)]).sum::<f64>();
        Some(Self {
            alpha: (0..k).map(|j| self.alpha[kept[j]] - product(j, k)).collect(),
            w: (0..k).map(|j| self.w[kept[j]] - product(j, k + 1)).collect(),
            bias: self.bias - product(k + 1, k),
            b,
        })
    }
}

/// The errors of cross-validation one step ahead, without models: of each part of successive
/// samples `B_VV⁻¹ α_V`. Takes the lower half of Ω, which is overwritten.
pub(super) fn held_out_errors(
    mut omega: Vec<f64>,
    lambda: f64,
    y: &[f64],
    parts: &[std::ops::Range<usize>],
) -> Result<Vec<f64>, Error> {
    let n = y.len();
    factorise(&mut omega, n, lambda)?;
    let (alpha, _, u, s) = solution(&omega, y);
    let inverse = inverted_lower(&view(&omega, n, n));
    let mut errors = alpha;
    for part in parts {
        let (from, size) = (part.start, part.len());
        // Above the part's own rows the columns are zero.
        let columns = inverse.view((from, from), (n - from, size));
        let mut block = Mat::from_fn(size, size, |i, j| -u[from + i] * u[from + j] / s);
        let transposed = columns.transpose();
        add_lower(&mut block.as_view_mut(), 1.0, &transposed.as_view(), &columns);
        cholesky(block.as_view_mut()).ok_or(Error::IllPosed { samples: n, lambda })?;
        solve_with(&block.as_view(), view_mut(&mut errors[part.clone()], size, 1));
    }
    Ok(errors)
}

//! The kernel matrix `K_ij = exp(−‖x_i − x_j‖²)` of scaled points, its columns and products with it.

use pulp::{Arch, Simd, WithSimd};

use crate::kernel_sum::blocks;
use crate::simd::{Block, LANES, distance4, exp4, groups, minus4};

/// Points divided by the kernel's width.
#[derive(Clone, Debug)]
pub(crate) struct Scaled {
    rows: Vec<f64>,
    blocks: Vec<Block>,
    pub(crate) d: usize,
    pub(crate) n: usize,
    arch: Arch,
}

impl Scaled {
    /// `points` one after the other, `d` numbers each, times `scale` (one for each coordinate).
    pub(crate) fn new(points: &[f64], d: usize, scale: &[f64]) -> Self {
        let n = points.len() / d.max(1);
        let rows: Vec<f64> = points
            .chunks_exact(d.max(1))
            .flat_map(|p| p.iter().zip(scale).map(|(x, s)| x * s))
            .collect();
        let blocks = blocks(d, n, |i, k| rows[i * d + k]);
        Self { rows, blocks, d, n, arch: Arch::new() }
    }

    pub(crate) fn point(&self, i: usize) -> &[f64] {
        &self.rows[i * self.d..(i + 1) * self.d]
    }

    /// The lower half of K into `matrix`, column after column, n rows each. Above the diagonal at
    /// most 31 numbers of a column are written.
    pub(crate) fn fill_lower(&self, matrix: &mut [f64]) {
        self.arch.dispatch(Fill { points: self, matrix, what: What::Kernel });
    }

    /// The lower half of the squared distances into `matrix`, column after column, n rows each.
    pub(crate) fn fill_distances(&self, matrix: &mut [f64]) {
        self.arch.dispatch(Fill { points: self, matrix, what: What::Distance });
    }

    /// The kernels of all points with point `j` into `column`.
    pub(crate) fn column(&self, j: usize, column: &mut [f64]) {
        self.arch.dispatch(Column {
            points: self,
            z: self.point(j),
            from: 0,
            column,
            what: What::Kernel,
        });
    }

    /// `K·x + add·x` for two vectors, with kernels computed on the way: nothing is stored.
    pub(crate) fn products(&self, x: [&[f64]; 2], add: f64) -> [Vec<f64>; 2] {
        let x = x.map(|x| blocks(1, self.n, |i, _| x[i]));
        let out = x.each_ref().map(|x| x.iter().map(|b| Block(b.0.map(|x| add * x))).collect());
        let out: [Vec<Block>; 2] = self.arch.dispatch(Products { points: self, x, out });
        out.map(|out| out.iter().flat_map(|b| b.0).take(self.n).collect())
    }
}

struct Products<'a> {
    points: &'a Scaled,
    x: [Vec<Block>; 2],
    out: [Vec<Block>; 2],
}

impl WithSimd for Products<'_> {
    type Output = [Vec<Block>; 2];

    /// Each point with all blocks up to its own; those below serve for both triangles.
    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> Self::Output {
        let Self { points, x: [x0, x1], out: [mut out0, mut out1] } = self;
        for i in 0..points.n {
            let (own, lane) = (i / LANES, i % LANES);
            let z = points.point(i);
            let head = [s.splat_f64s(x0[own].0[lane]), s.splat_f64s(x1[own].0[lane])];
            let mut sums = [[s.splat_f64s(0.0); 4]; 2];
            let rows = points.blocks.chunks_exact(points.d.max(1));
            for (at, rows) in rows.take(own + 1).enumerate() {
                for h in 0..groups::<S>() {
                    let distance = distance4(s, rows, z, h);
                    let k = exp4(s, minus4(s, distance));
                    let x0 = &S::as_simd_f64s(&x0[at].0).0[4 * h..4 * h + 4];
                    let x1 = &S::as_simd_f64s(&x1[at].0).0[4 * h..4 * h + 4];
                    for c in 0..4 {
                        sums[0][c] = s.mul_add_e_f64s(k[c], x0[c], sums[0][c]);
                        sums[1][c] = s.mul_add_e_f64s(k[c], x1[c], sums[1][c]);
                    }
                    if at < own {
                        let out0 = &mut S::as_mut_simd_f64s(&mut out0[at].0).0[4 * h..4 * h + 4];
                        let out1 = &mut S::as_mut_simd_f64s(&mut out1[at].0).0[4 * h..4 * h + 4];
                        for c in 0..4 {
                            out0[c] = s.mul_add_e_f64s(k[c], head[0], out0[c]);
                            out1[c] = s.mul_add_e_f64s(k[c], head[1], out1[c]);
                        }
                    }
                }
            }
            let [sum0, sum1] = sums.map(|[a, b, c, d]| {
                s.reduce_sum_f64s(s.add_f64s(s.add_f64s(a, b), s.add_f64s(c, d)))
            });
            out0[own].0[lane] += sum0;
            out1[own].0[lane] += sum1;
        }
        [out0, out1]
    }
}

/// `out = exp(−factor·distance)` for the lower half of matrices of squared distances.
pub(crate) fn kernels_of_distances(distances: &[f64], n: usize, factor: f64, out: &mut [f64]) {
    let arch = Arch::new();
    for j in 0..n {
        // Whole blocks: what lies above the diagonal is overwritten, never read.
        let from = j * n + j / LANES * LANES;
        let (distances, out) = (&distances[from..(j + 1) * n], &mut out[from..(j + 1) * n]);
        arch.dispatch(Exp { distances, factor, out });
    }
}

#[derive(Clone, Copy, PartialEq)]
enum What {
    Kernel,
    Distance,
}

struct Fill<'a> {
    points: &'a Scaled,
    matrix: &'a mut [f64],
    what: What,
}

impl WithSimd for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let n = self.points.n;
        for (j, column) in self.matrix.chunks_exact_mut(n.max(1)).enumerate() {
            let z = self.points.point(j);
            let from = j / LANES;
            Column { points: self.points, z, from, column, what: self.what }.with_simd(s);
        }
    }
}

struct Column<'a> {
    points: &'a Scaled,
    z: &'a [f64],
    from: usize,
    column: &'a mut [f64],
    what: What,
}

impl WithSimd for Column<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let rows = self.points.blocks.chunks_exact(self.points.d.max(1)).skip(self.from);
        let out = self.column[self.from * LANES..].chunks_mut(LANES);
        for (rows, out) in rows.zip(out) {
            let mut block = Block::ZERO;
            let lanes = S::as_mut_simd_f64s(&mut block.0).0;
            for h in 0..groups::<S>() {
                let distance = distance4(s, rows, self.z, h);
                let e =
                    if self.what == What::Kernel { exp4(s, minus4(s, distance)) } else { distance };
                lanes[4 * h..4 * h + 4].copy_from_slice(&e);
            }
            out.copy_from_slice(&block.0[..out.len()]);
        }
    }
}

struct Exp<'a> {
    distances: &'a [f64],
    factor: f64,
    out: &'a mut [f64],
}

impl WithSimd for Exp<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let factor = s.splat_f64s(-self.factor);
        for (distances, out) in self.distances.chunks(LANES).zip(self.out.chunks_mut(LANES)) {
            let mut block = Block::ZERO;
            block.0[..distances.len()].copy_from_slice(distances);
            let lanes = S::as_mut_simd_f64s(&mut block.0).0;
            for h in 0..groups::<S>() {
                let mut x = [factor; 4];
                for i in 0..4 {
                    x[i] = s.mul_f64s(lanes[4 * h + i], factor);
                }
                lanes[4 * h..4 * h + 4].copy_from_slice(&exp4(s, x));
            }
            out.copy_from_slice(&block.0[..out.len()]);
        }
    }
}

/// `(K + add)·x` for two vectors; of the symmetric K only the lower half is read.
pub(crate) fn symmetric_products(
    matrix: &[f64],
    n: usize,
    add: f64,
    x: [&[f64]; 2],
) -> [Vec<f64>; 2] {
    let mut all = [vec![0.0; n], vec![0.0; n]];
    let [out0, out1] = &mut all;
    Arch::new().dispatch(Symmetric { matrix, n, add, x, out: [out0, out1] });
    all
}

struct Symmetric<'a> {
    matrix: &'a [f64],
    n: usize,
    add: f64,
    x: [&'a [f64]; 2],
    out: [&'a mut [f64]; 2],
}

impl WithSimd for Symmetric<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { matrix, n, add, x, out: [out0, out1] } = self;
        let [x0, x1] = x;
        for i in 0..n {
            out0[i] = add * x0[i];
            out1[i] = add * x1[i];
        }
        for j in (0..n).step_by(4) {
            let width = (n - j).min(4);
            // The triangle on the diagonal.
            for c in j..j + width {
                for i in c..j + width {
                    let k = matrix[c * n + i];
                    out0[i] += k * x0[c];
                    out1[i] += k * x1[c];
                    if i > c {
                        out0[c] += k * x0[i];
                        out1[c] += k * x1[i];
                    }
                }
            }
            if width == 4 && j + 4 < n {
                let below = |c: usize| &matrix[(j + c) * n + j + 4..(j + c + 1) * n];
                let columns = [below(0), below(1), below(2), below(3)];
                let head = |x: &[f64]| [x[j], x[j + 1], x[j + 2], x[j + 3]];
                let (h0, h1) = (head(x0), head(x1));
                let (o0, t0) = out0.split_at_mut(j + 4);
                let (o1, t1) = out1.split_at_mut(j + 4);
                let sums = panel(s, columns, [&x0[j + 4..], &x1[j + 4..]], [t0, t1], [h0, h1]);
                for c in 0..4 {
                    o0[j + c] += sums[0][c];
                    o1[j + c] += sums[1][c];
                }
            }
        }
    }
}

/// Four columns below the diagonal: adds `columns·head` to `out`, returns `columnsᵀ·x`.
#[inline(always)]
fn panel<S: Simd>(
    s: S,
    columns: [&[f64]; 4],
    x: [&[f64]; 2],
    out: [&mut [f64]; 2],
    head: [[f64; 4]; 2],
) -> [[f64; 4]; 2] {
    let split = columns.map(S::as_simd_f64s);
    let [(x0, y0), (x1, y1)] = x.map(S::as_simd_f64s);
    let [out0, out1] = out;
    let (o0, r0) = S::as_mut_simd_f64s(out0);
    let (o1, r1) = S::as_mut_simd_f64s(out1);
    let heads = head.map(|head| head.map(|h| s.splat_f64s(h)));
    let mut sums = [[s.splat_f64s(0.0); 4]; 2];
    let count = x0.len();
    let wide = split.map(|(wide, _)| &wide[..count]);
    let (x1, o0, o1) = (&x1[..count], &mut o0[..count], &mut o1[..count]);
    for i in 0..count {
        let (a0, a1) = (x0[i], x1[i]);
        let (mut b0, mut b1) = (o0[i], o1[i]);
        for c in 0..4 {
            let k = wide[c][i];
            b0 = s.mul_add_e_f64s(k, heads[0][c], b0);
            b1 = s.mul_add_e_f64s(k, heads[1][c], b1);
            sums[0][c] = s.mul_add_e_f64s(k, a0, sums[0][c]);
            sums[1][c] = s.mul_add_e_f64s(k, a1, sums[1][c]);
        }
        (o0[i], o1[i]) = (b0, b1);
    }
    let mut all = sums.map(|sums| sums.map(|sum| s.reduce_sum_f64s(sum)));
    for c in 0..4 {
        for (i, k) in split[c].1.iter().enumerate() {
            r0[i] += k * head[0][c];
            r1[i] += k * head[1][c];
            all[0][c] += k * y0[i];
            all[1][c] += k * y1[i];
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::wave;

    #[test]
    fn matrix_columns_and_products_agree() {
        for n in [1, 5, 32, 77] {
            let d = 3;
            let points = wave(n * d, 1.3);
            let scaled = Scaled::new(&points, d, &[0.5, 1.0, 2.0]);
            let kernel = |i: usize, j: usize| {
                let (a, b) = (scaled.point(i), scaled.point(j));
                (-a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>()).exp()
            };
            let (mut k, mut distances) = (vec![0.0; n * n], vec![0.0; n * n]);
            scaled.fill_lower(&mut k);
            scaled.fill_distances(&mut distances);
            let mut of_distances = vec![0.0; n * n];
            kernels_of_distances(&distances, n, 1.0, &mut of_distances);
            for j in 0..n {
                for i in j..n {
                    assert!((k[j * n + i] - kernel(i, j)).abs() < 1e-15);
                    assert!((of_distances[j * n + i] - kernel(i, j)).abs() < 1e-15);
                }
            }
            let (x0, x1) = (wave(n, 0.7), wave(n, 2.1));
            let [y0, y1] = symmetric_products(&k, n, 0.5, [&x0, &x1]);
            let [z0, z1] = scaled.products([&x0, &x1], 0.5);
            for i in 0..n {
                let expected = 0.5 * x0[i] + (0..n).map(|j| kernel(i, j) * x0[j]).sum::<f64>();
                assert!((y0[i] - expected).abs() < 1e-12 && (z0[i] - expected).abs() < 1e-12);
                assert!((y1[i] - z1[i]).abs() < 1e-12);
            }
        }
    }
}

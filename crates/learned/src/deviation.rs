//! The standard deviation that a Gaussian process predicts, on few of its samples.
//!
//! ```text
//! σ²(z) = σ_f²·(1 − |v|² + |w|²) + σ_n²,   L·v = k(z),   C·w = v
//! ```
//!
//! k(z) are the kernels at the centres, L·Lᵀ those of the centres with each other, and C·Cᵀ = I + BᵀB·σ_f²/σ_n² with K ≈ B·Bᵀ over all
//! samples: what is not known at z, less what the samples say of the centres. With all samples as centres it is the
//! variance of the process; with fewer it is near it as long as little of K is left beside B·Bᵀ against σ_n²/σ_f².
//!
//! Reference: J. Quiñonero-Candela, C. Rasmussen, A unifying view of sparse approximate Gaussian process regression, JMLR 6 (2005) 1939-1959, eq.
//! (20b).

/// The part of σ_f² that is left at a point, by kernels at some centres.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    dimension: usize,
    /// What inputs are multiplied with, so that the kernel is exp(−‖·‖²).
    scales: Vec<f64>,
    /// Centres times their scales, one after the other.
    centres: Vec<f64>,
    /// L and C, row after row up to the diagonal.
    kernels: Vec<f64>,
    evidence: Vec<f64>,
}

/// Numbers of a triangle.
fn triangle(count: usize) -> usize {
    count * (count + 1) / 2
}

/// Sums that go on beside each other.
const LANES: usize = 8;

/// The sum of products, in lanes that a vector holds.
fn product(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    rest + lanes.iter().sum::<f64>()
}

/// Forward substitution in place.
fn solve(triangle: &[f64], x: &mut [f64]) {
    let mut row = 0;
    for i in 0..x.len() {
        let (before, own) = x.split_at_mut(i);
        own[0] = (own[0] - product(&triangle[row..row + i], before)) / triangle[row + i];
        row += i + 1;
    }
}

impl Deviation {
    /// From scaled centres and the two triangles.
    #[cfg(feature = "train")]
    pub(crate) fn new(
        scales: &[f64],
        centres: Vec<f64>,
        kernels: Vec<f64>,
        evidence: Vec<f64>,
    ) -> Self {
        Self { dimension: scales.len(), scales: scales.to_vec(), centres, kernels, evidence }
    }

    /// Number of centres.
    #[must_use]
    pub fn count(&self) -> usize {
        self.centres.len() / self.dimension.max(1)
    }

    /// The part of σ_f² that is left at `z`; `room` holds as many numbers as there are centres.
    #[must_use]
    pub fn left(&self, z: &[f64], room: &mut [f64]) -> f64 {
        let count = self.count().min(room.len());
        let room = &mut room[..count];
        for (k, centre) in room.iter_mut().zip(self.centres.chunks_exact(self.dimension.max(1))) {
            let each = centre.iter().zip(z).zip(&self.scales);
            let square: f64 = each.map(|((x, z), s)| (x - z * s) * (x - z * s)).sum();
            *k = libm::exp(-square);
        }
        let squares = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        solve(&self.kernels, room);
        let known = squares(room);
        solve(&self.evidence, room);
        (1.0 - known + squares(room)).clamp(0.0, 1.0)
    }

    /// Rows of a table with `columns` columns that hold so many centres and both triangles.
    #[must_use]
    pub fn rows(count: usize, columns: usize) -> usize {
        count + (2 * triangle(count)).div_ceil(columns.max(1))
    }

    /// These rows, where a table has these widths of its inputs: 0 and a centre each, then both triangles, and zeros up to
    /// the end of the last row.
    #[must_use]
    pub fn table(&self, widths: &[f64]) -> Vec<f64> {
        let (d, columns) = (self.dimension, self.dimension + 1);
        let mut rows = Vec::with_capacity(Self::rows(self.count(), columns) * columns);
        for centre in self.centres.chunks_exact(d.max(1)) {
            rows.push(0.0);
            rows.extend(centre.iter().zip(widths).map(|(x, width)| x * width));
        }
        rows.extend_from_slice(&self.kernels);
        rows.extend_from_slice(&self.evidence);
        rows.resize(Self::rows(self.count(), columns) * columns, 0.0);
        rows
    }

    /// From such rows and the widths of the inputs.
    ///
    /// # Errors
    /// A diagonal of a triangle that is not positive.
    pub(crate) fn of_table(rows: &[f64], count: usize, widths: &[f64]) -> Result<Self, String> {
        let (d, columns) = (widths.len(), widths.len() + 1);
        let scales: Vec<f64> = widths.iter().map(|width| 1.0 / width).collect();
        let (of_centres, triangles) = rows.split_at((count * columns).min(rows.len()));
        let centres: Vec<f64> = of_centres
            .chunks_exact(columns)
            .flat_map(|row| row[1..].iter().zip(&scales).map(|(x, s)| x * s))
            .collect();
        let numbers = triangle(count);
        if triangles.len() < 2 * numbers || centres.len() != count * d {
            return Err(format!(
                "the table's last rows do not hold {count} centres of a deviation"
            ));
        }
        let (kernels, evidence) = triangles[..2 * numbers].split_at(numbers);
        let diagonal = |i: usize| triangle(i) + i;
        if let Some(i) =
            (0..count).find(|i| kernels[diagonal(*i)] <= 0.0 || evidence[diagonal(*i)] <= 0.0)
        {
            return Err(format!(
                "centre {} of the deviation has no positive diagonal in the table; train it again",
                i + 1
            ));
        }
        let (kernels, evidence) = (kernels.to_vec(), evidence.to_vec());
        Ok(Self { dimension: d, scales, centres, kernels, evidence })
    }
}

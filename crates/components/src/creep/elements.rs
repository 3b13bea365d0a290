//! The sum of first-order elements, exact for an input that is held over each step.

/// Coefficients: `direct | fraction_i … | share_i …`; one state z_i per element.
pub(super) struct Elements<'a> {
    direct: f64,
    fractions: &'a [f64],
    shares: &'a [f64],
}

/// Moves an element that goes this fraction of the way to u in a period, and returns what its share adds to the output.
#[inline]
#[must_use]
pub fn crept(u: f64, (share, fraction): (f64, f64), z: &mut f64) -> f64 {
    *z += fraction * (u - *z);
    share * *z
}

/// Number of coefficients for this many elements.
pub(super) fn coefficients(elements: usize) -> usize {
    2 * elements + 1
}

/// The input that rests at the output `y`.
pub(super) fn at_rest(values: &[f64], y: f64) -> f64 {
    let Some(e) = Elements::new(values) else { return y };
    y / (e.direct + e.shares.iter().sum::<f64>())
}

/// The coefficients as direct part, fractions and shares, to be filled.
pub(super) fn parts_mut(values: &mut [f64]) -> Option<(&mut f64, &mut [f64], &mut [f64])> {
    let (direct, rest) = values.split_first_mut()?;
    let (fractions, shares) = rest.split_at_mut(rest.len() / 2);
    Some((direct, fractions, shares))
}

impl Elements<'_> {
    pub(super) fn new(values: &[f64]) -> Option<Elements<'_>> {
        let (&direct, rest) = values.split_first()?;
        let (fractions, shares) = rest.split_at(rest.len() / 2);
        Some(Elements { direct, fractions, shares })
    }

    /// All elements have reached the input.
    pub(super) fn rest(&self, u: f64, state: &mut [f64]) -> f64 {
        state.fill(u);
        self.shares.iter().fold(self.direct * u, |y, share| y + share * u)
    }

    /// One period.
    pub(super) fn step(&self, u: f64, state: &mut [f64]) -> f64 {
        let all = state.iter_mut().zip(self.shares).zip(self.fractions);
        all.fold(self.direct * u, |y, ((z, share), fraction)| y + crept(u, (*share, *fraction), z))
    }

    /// One period with the input that leads to the output `y`; returns the input.
    pub(super) fn solve(&self, y: f64, state: &mut [f64]) -> f64 {
        let (mut gain, mut known) = (self.direct, 0.0);
        for ((z, fraction), share) in state.iter().zip(self.fractions).zip(self.shares) {
            gain += share * fraction;
            known += share * (1.0 - fraction) * z;
        }
        let u = (y - known) / gain;
        self.step(u, state);
        u
    }
}

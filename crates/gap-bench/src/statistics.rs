//! Counts with their intervals.

use libm::{exp, lgamma, log, log1p};
use serde::{Deserialize, Serialize};

/// How often something came out, with the exact 95 % interval of C. J. Clopper and E. S. Pearson,
/// Biometrika 26 (1934) 404–413.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// How often it did.
    pub hits: usize,
    /// Of how many.
    pub of: usize,
    /// Lower end of the interval; 0 where nothing was counted.
    pub low: f64,
    /// Upper end; 1 where nothing was counted.
    pub high: f64,
}

impl Rate {
    /// Counts.
    pub fn count(outcomes: impl IntoIterator<Item = bool>) -> Self {
        let (mut hits, mut of) = (0, 0);
        for hit in outcomes {
            hits += usize::from(hit);
            of += 1;
        }
        Self::new(hits, of)
    }

    /// `hits` of `of`.
    #[must_use]
    pub fn new(hits: usize, of: usize) -> Self {
        let (low, high) = clopper_pearson(hits, of);
        Self { hits, of, low, high }
    }

    /// The share; `None` where nothing was counted.
    #[must_use]
    pub fn share(&self) -> Option<f64> {
        (self.of > 0).then(|| self.hits as f64 / self.of as f64)
    }
}

impl std::fmt::Display for Rate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.share() {
            None => write!(f, "no case"),
            Some(share) => write!(
                f,
                "{:.1} % [{:.1}, {:.1}] ({}/{})",
                100.0 * share,
                100.0 * self.low,
                100.0 * self.high,
                self.hits,
                self.of
            ),
        }
    }
}

fn clopper_pearson(hits: usize, of: usize) -> (f64, f64) {
    let (k, n) = (hits as f64, of as f64);
    let low = if hits == 0 { 0.0 } else { beta_quantile(0.025, k, n - k + 1.0) };
    let high = if hits >= of { 1.0 } else { beta_quantile(0.975, k + 1.0, n - k) };
    (low, high)
}

/// The x at which the regularised incomplete beta function is p, by bisection.
fn beta_quantile(p: f64, a: f64, b: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let x = 0.5 * (low + high);
        if beta(x, a, b) < p { low = x } else { high = x }
    }
    0.5 * (low + high)
}

/// The regularised incomplete beta function I_x(a, b), by Lentz's continued fraction
/// (W. H. Press et al., Numerical Recipes, 3rd ed., 6.4).
fn beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    // The fraction converges fast on this side of the mean only.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta(1.0 - x, b, a);
    }
    let front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x)) / a;
    let tiny = 1e-300;
    let guard = |x: f64| if x.abs() < tiny { tiny } else { x };
    let mut c = 1.0;
    let mut d = 1.0 / guard(1.0 - (a + b) * x / (a + 1.0));
    let mut sum = d;
    for i in 1..500 {
        let m = f64::from(i);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        for term in [even, odd] {
            d = 1.0 / guard(1.0 + term * d);
            c = guard(1.0 + term / c);
            sum *= c * d;
        }
        if (c * d - 1.0).abs() < 1e-14 {
            break;
        }
    }
    front * sum
}

/// How well probabilities say how often names are right.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Expected calibration error: Σ n_b/n |share right − mean probability| over ten bins of equal
    /// width (C. Guo et al., ICML 2017). `None` without names.
    pub error: Option<f64>,
    /// The bins that hold names.
    pub bins: Vec<Bin>,
}

/// Names of similar probability.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bin {
    /// Mean probability.
    pub probability: f64,
    /// How often the name was right.
    pub right: Rate,
}

impl Calibration {
    /// Bins pairs of a probability and whether the name was right.
    #[must_use]
    pub fn of(names: &[(f64, bool)]) -> Self {
        let bin_of = |p: f64| ((p * 10.0) as usize).min(9);
        let bins: Vec<Bin> = (0..10)
            .filter_map(|number| {
                let inside: Vec<_> = names.iter().filter(|(p, _)| bin_of(*p) == number).collect();
                let right = Rate::count(inside.iter().map(|(_, right)| *right));
                let sum: f64 = inside.iter().map(|(p, _)| p).sum();
                (right.of > 0).then(|| Bin { probability: sum / right.of as f64, right })
            })
            .collect();
        let error = bins.iter().map(|bin| {
            let share = bin.right.share().unwrap_or_default();
            bin.right.of as f64 / names.len() as f64 * (share - bin.probability).abs()
        });
        Self { error: (!names.is_empty()).then(|| error.sum()), bins }
    }
}

/// The q-quantile of values, 0 ≤ q ≤ 1, by the nearest rank; `None` without values.
#[must_use]
pub fn quantile(values: &[f64], q: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let rank = (q * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.clamp(1, sorted.len().max(1)) - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 5e-5, "{a} {b}");
    }

    #[test]
    fn intervals_without_and_with_only_hits_have_a_closed_form() {
        for n in [1, 10, 500, 5000] {
            let bound = 1.0 - 0.025_f64.powf(1.0 / n as f64);
            let none = Rate::new(0, n);
            close(none.high, bound);
            close(Rate::new(n, n).low, 1.0 - bound);
            assert_eq!((none.low, Rate::new(n, n).high), (0.0, 1.0));
        }
        assert_eq!(Rate::new(0, 0), Rate { hits: 0, of: 0, low: 0.0, high: 1.0 });
    }

    #[test]
    fn intervals_hold_the_tail_that_they_say() {
        // P(X ≥ k) at the lower end and P(X ≤ k) at the upper end are 2.5 %, by the binomial sum.
        let binomial = |n: usize, k: usize, p: f64| {
            let (n, k) = (n as f64, k as f64);
            let choose = lgamma(n + 1.0) - lgamma(k + 1.0) - lgamma(n - k + 1.0);
            exp(choose + k * log(p) + (n - k) * log1p(-p))
        };
        for (k, n) in [(1, 7), (9, 10), (33, 60), (480, 500)] {
            let rate = Rate::new(k, n);
            let upper: f64 = (k..=n).map(|i| binomial(n, i, rate.low)).sum();
            let lower: f64 = (0..=k).map(|i| binomial(n, i, rate.high)).sum();
            assert!((upper - 0.025).abs() < 1e-8 && (lower - 0.025).abs() < 1e-8, "{k}/{n}");
        }
    }

    #[test]
    fn calibration_is_the_weighted_distance_from_the_diagonal() {
        // Ten names at 0.9 of which 7 are right, ten at 0.25 of which 4 are.
        let names: Vec<(f64, bool)> =
            (0..10).map(|i| (0.95, i < 7)).chain((0..10).map(|i| (0.25, i < 4))).collect();
        let calibration = Calibration::of(&names);
        close(calibration.error.unwrap(), 0.5 * 0.25 + 0.5 * 0.15);
        assert_eq!(calibration.bins.len(), 2);
        assert_eq!(Calibration::of(&[]).error, None);
        // A probability of one has a bin.
        assert_eq!(Calibration::of(&[(1.0, true)]).error, Some(0.0));
    }

    #[test]
    fn quantiles_are_values_of_the_set() {
        let values = [3.0, 1.0, 2.0, f64::NAN];
        assert_eq!(quantile(&values, 0.5), Some(2.0));
        assert_eq!(quantile(&values, 1.0), Some(3.0));
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&[], 0.5), None);
    }
}

//! What a residual is worth: its mean, and how many independent samples it has.

/// Longest correlation that is looked for, in samples.
const LONGEST_CORRELATION: usize = 4096;

/// Mean of the values; 0 for none.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// How many independent residuals a correlated residual of this many samples is worth:
/// N / (1 + 2 Σ ρ_k), the sum running up to the first autocorrelation that is not positive.
///
/// Source: C. J. Geyer, Statistical Science 7 (1992) 473–483 (initial positive sequence).
pub(crate) fn independent_samples(residual: &[f64]) -> f64 {
    let count = residual.len();
    let power: f64 = residual.iter().map(|e| e * e).sum();
    if count < 2 || power == 0.0 {
        return count as f64;
    }
    let mut sum = 1.0;
    for lag in 1..(count / 2).min(LONGEST_CORRELATION) {
        let product: f64 = residual.iter().zip(&residual[lag..]).map(|(a, b)| a * b).sum();
        if product <= 0.0 {
            break;
        }
        sum += 2.0 * product / power;
    }
    (count as f64 / sum).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::random::SplitMix64;

    #[test]
    fn independent_samples_of_white_and_of_correlated_noise() {
        let mut random = SplitMix64::new(7);
        let white: Vec<f64> = (0..20_000).map(|_| random.normal()).collect();
        assert!(independent_samples(&white) > 0.9 * 20_000.0);
        // First-order noise with ρ = 0.9 is worth N (1−ρ)/(1+ρ).
        let mut state = 0.0;
        let slow: Vec<f64> = white
            .iter()
            .map(|e| {
                state = 0.9 * state + e;
                state
            })
            .collect();
        let expected = 20_000.0 * 0.1 / 1.9;
        let found = independent_samples(&slow);
        assert!((found / expected - 1.0).abs() < 0.3, "seed 7: {found}, expected {expected}");
    }
}

//! Random numbers of one variable in one run.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use sha2::{Digest, Sha256};

/// ChaCha8, keyed by SHA-256 of the plan's seed and the variable's name; the run is the stream. So
/// a variable that is added or taken away leaves the numbers of the others as they are.
pub(crate) struct Draw(ChaCha8Rng);

impl Draw {
    pub(crate) fn new(seed: u64, name: &str, run: u64) -> Self {
        let mut hash = Sha256::new();
        hash.update(b"piezoloop sweep 1\0");
        hash.update(seed.to_le_bytes());
        hash.update(name.as_bytes());
        let mut generator = ChaCha8Rng::from_seed(hash.finalize().into());
        generator.set_stream(run);
        Self(generator)
    }

    /// Uniform over (0, 1): 53 random bits, in the middle of their cell.
    fn unit(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// Uniform from `low` to `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        (low + (high - low) * self.unit()).clamp(low, high)
    }

    /// A whole number from `low` to `high`, both included; the bias is at most (high − low)/2⁶⁴.
    pub(crate) fn integer(&mut self, low: i64, high: i64) -> i64 {
        let count = (i128::from(high) - i128::from(low) + 1) as u128;
        let at = (u128::from(self.0.next_u64()) * count) >> 64;
        (i128::from(low) + at as i128) as i64
    }

    /// Normal with mean 0 and standard deviation 1 (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        let (u, v) = (self.unit(), self.unit());
        libm::sqrt(-2.0 * libm::log(u)) * libm::cos(2.0 * std::f64::consts::PI * v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seed_name_and_run_alone_decide() {
        let first = |seed, name, run| Draw::new(seed, name, run).normal();
        assert_eq!(first(1, "a", 7), first(1, "a", 7));
        for other in [first(2, "a", 7), first(1, "b", 7), first(1, "a", 8)] {
            assert_ne!(first(1, "a", 7), other);
        }
    }

    #[test]
    fn moments_are_those_of_the_law() {
        let draws = |law: fn(&mut Draw) -> f64| -> Vec<f64> {
            (0..20_000).map(|run| law(&mut Draw::new(3, "x", run))).collect()
        };
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let normal = draws(Draw::normal);
        let squares: Vec<f64> = normal.iter().map(|x| x * x).collect();
        // Standard errors: 1/√20000 = 0.007 and √(2/20000) = 0.01.
        assert!(mean(&normal).abs() < 0.03 && (mean(&squares) - 1.0).abs() < 0.04);
        let uniform = draws(|draw| draw.between(2.0, 4.0));
        assert!((mean(&uniform) - 3.0).abs() < 0.02);
        assert!(uniform.iter().all(|x| (2.0..=4.0).contains(x)));
    }

    #[test]
    fn integers_reach_both_ends() {
        let draws: Vec<i64> = (0..600).map(|run| Draw::new(1, "n", run).integer(-1, 1)).collect();
        for value in -1..=1 {
            let count = draws.iter().filter(|&&draw| draw == value).count();
            assert!((140..260).contains(&count), "{value}: {count}");
        }
        let all: Vec<i64> =
            (0..9).map(|run| Draw::new(1, "n", run).integer(i64::MIN, i64::MAX)).collect();
        assert!(all.iter().any(|&x| x < 0) && all.iter().any(|&x| x > 0));
    }
}

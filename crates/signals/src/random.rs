//! Random numbers with a stated generator.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// ChaCha8 with the seed's eight little-endian bytes, then zeros, as its key. Different uses of one
/// seed take different streams, so that one use does not shift the numbers of another.
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    /// The generator of a seed (a whole number of at most 2⁵³) and a stream.
    pub(crate) fn new(seed: f64, stream: u64) -> Self {
        let mut key = [0; 32];
        for (slot, byte) in key.iter_mut().zip((seed as u64).to_le_bytes()) {
            *slot = byte;
        }
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(stream);
        Self(generator)
    }

    /// Uniform from `low` (included) to `high`: 53 random bits.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Uniform from 0 to `count` − 1; the bias of at most `count`/2⁵³ does not matter here.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.between(0.0, count as f64) as usize).min(count.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First words of the ChaCha8 key stream for an all-zero key and nonce, as published in
    /// draft-strombergson-chacha-test-vectors-01, TC1.
    #[test]
    fn seed_zero_is_the_published_key_stream() {
        let bytes: [u8; 8] = [0x3e, 0x00, 0xef, 0x2f, 0x89, 0x5f, 0x40, 0xd6];
        let expected = (u64::from_le_bytes(bytes) >> 11) as f64 / (1u64 << 53) as f64;
        assert_eq!(Random::new(0.0, 0).between(0.0, 1.0), expected);
    }

    #[test]
    fn seeds_and_streams_differ_and_repeat() {
        let first = |seed, stream| Random::new(seed, stream).between(0.0, 1.0);
        assert_eq!(first(7.0, 0), first(7.0, 0));
        assert_ne!(first(7.0, 0), first(8.0, 0));
        assert_ne!(first(7.0, 0), first(7.0, 1));
        let mut random = Random::new(5.0, 0);
        let draws: Vec<usize> = (0..1000).map(|_| random.below(4)).collect();
        assert!((0..4).all(|k| draws.iter().filter(|&&d| d == k).count() > 200));
        assert!(draws.iter().all(|&d| d < 4));
    }
}

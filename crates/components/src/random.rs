//! Random numbers as a function of a seed, a channel and a count.
//!
//! Philox 4×32 with 10 rounds: a number does not depend on how many were drawn before, so noise is
//! the same for every partition of a run, after a reset, and after a saved state was restored.
//!
//! Source: J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, Parallel random numbers: as easy as
//! 1, 2, 3, SC 2011.

use libm::{log, sqrt};

use crate::turn;

const MULTIPLIERS: [u32; 2] = [0xd251_1f53, 0xcd9e_8d57];
const WEYL: [u32; 2] = [0x9e37_79b9, 0xbb67_ae85];

/// Ten rounds of Philox 4×32.
#[must_use]
pub fn philox(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let ([mut a, mut b, mut c, mut d], [mut k, mut l]) = (counter, key);
    for _ in 0..10 {
        let first = u64::from(MULTIPLIERS[0]) * u64::from(a);
        let second = u64::from(MULTIPLIERS[1]) * u64::from(c);
        let (high, low) = ((second >> 32) as u32, second as u32);
        (a, b, c, d) = (high ^ b ^ k, low, (first >> 32) as u32 ^ d ^ l, first as u32);
        (k, l) = (k.wrapping_add(WEYL[0]), l.wrapping_add(WEYL[1]));
    }
    [a, b, c, d]
}

/// Two independent normally distributed numbers of mean 0 and variance 1 (Box–Muller).
///
/// `seed` is a parameter's value, `channel` tells the sources of one component apart, `count` is
/// the number of the hit.
#[inline]
#[must_use]
pub fn normals(seed: f64, channel: u32, count: u64) -> [f64; 2] {
    let seed = seed.to_bits();
    let counter = [count as u32, (count >> 32) as u32, channel, 0];
    let [a, b, c, d] = philox(counter, [seed as u32, (seed >> 32) as u32]);
    // Two uniform numbers from 2⁻⁵³ to 1: never 0, so that the logarithm is finite.
    let uniform = |high: u32, low: u32| {
        (((u64::from(high) << 32 | u64::from(low)) >> 11) + 1) as f64 / (1u64 << 53) as f64
    };
    let radius = sqrt(-2.0 * log(uniform(a, b)));
    let [sin, cos] = turn::sin_cos(uniform(c, d));
    [radius * cos, radius * sin]
}

/// The first of [`normals`].
#[inline]
#[must_use]
pub fn normal(seed: f64, channel: u32, count: u64) -> f64 {
    let [first, _] = normals(seed, channel, count);
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn philox_gives_the_published_vectors() {
        let published = [
            ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([u32::MAX; 4], [u32::MAX; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, expected) in published {
            assert_eq!(philox(counter, key), expected);
        }
    }

    #[test]
    fn normal_numbers_have_the_moments_of_their_distribution() {
        let count = 100_000u64;
        for (seed, channel) in [(1.0, 0), (1.0, 1), (2.0, 0)] {
            let (mut m1, mut m2, mut m4, mut lag) = (0.0, 0.0, 0.0, 0.0);
            for n in 0..count {
                let x = normal(seed, channel, n);
                m1 += x;
                m2 += x * x;
                m4 += x * x * x * x;
                lag += x * normal(seed, channel, n + 1);
            }
            let n = count as f64;
            // Five standard errors each: 1/√n, √2/√n, √96/√n, 1/√n.
            assert!((m1 / n).abs() < 5.0 / n.sqrt());
            assert!((m2 / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
            assert!((m4 / n - 3.0).abs() < 5.0 * (96.0 / n).sqrt());
            assert!((lag / n).abs() < 5.0 / n.sqrt());
        }
    }

    #[test]
    fn the_two_numbers_of_a_draw_are_independent_and_alike() {
        let (count, mut product, mut squares, mut power) = (100_000u64, 0.0, 0.0, 0.0);
        for n in 0..count {
            let [x, y] = normals(3.0, 7, n);
            (product, squares, power) = (product + x * y, squares + x * x * y * y, power + y * y);
        }
        let n = count as f64;
        // Five standard errors each: 1/√n, √8/√n, √2/√n.
        assert!((product / n).abs() < 5.0 / n.sqrt());
        assert!((squares / n - 1.0).abs() < 5.0 * (8.0 / n).sqrt());
        assert!((power / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
    }

    #[test]
    fn channels_and_seeds_are_independent() {
        let n = 20_000u64;
        let product = |a: (f64, u32), b: (f64, u32)| {
            let sum: f64 = (0..n).map(|k| normal(a.0, a.1, k) * normal(b.0, b.1, k)).sum();
            sum / n as f64
        };
        for (a, b) in [((1.0, 0), (1.0, 1)), ((1.0, 0), (2.0, 0)), ((0.0, 0), (-0.0, 0))] {
            assert!(product(a, b).abs() < 5.0 / (n as f64).sqrt(), "{a:?} {b:?}");
        }
    }
}

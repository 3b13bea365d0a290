//! What several tests need.

/// Numbers without structure, from −1 to 1.
pub(crate) fn wave(count: usize, seed: f64) -> Vec<f64> {
    (0..count).map(|i| libm::sin(seed * (i as f64 + 1.0) * (i as f64 + 0.37))).collect()
}

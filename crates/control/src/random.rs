//! Random numbers that are the same at every run.

/// Xorshift of 64 bits (G. Marsaglia, Journal of Statistical Software 8 (2003) 14), uniform on [0, 1).
pub(crate) struct Uniform(u64);

impl Uniform {
    /// From a state that is not 0.
    pub(crate) const fn new(state: u64) -> Self {
        Self(state)
    }

    pub(crate) const fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

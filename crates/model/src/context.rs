//! Everything of a system that changes: values, coefficients, state, signals, clock.

use alloc::vec::Vec;
use core::fmt;

/// What changes in a [`System`](crate::System). Saving, restoring and resetting are copies of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Context {
    /// One block: values | coefficients | state | signals.
    pub(crate) cells: Vec<f64>,
    /// Start time in s.
    pub(crate) start: f64,
    /// Number of the last hit.
    pub(crate) index: u64,
    /// A parameter changed since the coefficients were computed.
    pub(crate) dirty: bool,
}

/// Bytes that are no context of this system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContextError {
    /// Bytes expected.
    pub expected: usize,
    /// Bytes given.
    pub found: usize,
}

impl fmt::Display for ContextError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "a saved state of this model has {} bytes, but {} were given; it belongs to another model",
            self.expected, self.found
        )
    }
}

impl core::error::Error for ContextError {}

const HEAD: usize = 8 + 8 + 1;

impl Context {
    /// Takes over everything of `other`, without allocating where the sizes agree.
    pub fn copy_from(&mut self, other: &Self) {
        self.cells.clone_from(&other.cells);
        (self.start, self.index, self.dirty) = (other.start, other.index, other.dirty);
    }

    /// Whether the last hit lies at `time` or less than one `period` before it, up to what adding up times
    /// loses: of a state that says otherwise the next step would never end.
    #[must_use]
    pub fn is_at(&self, time: f64, period: f64) -> bool {
        let passed = (time - self.start) / period - self.index as f64;
        let lost = 1e-3 + 16.0 * f64::EPSILON * (time.abs() + self.start.abs()) / period;
        // Neither holds for NaN.
        passed >= -lost && passed <= 1.0 + lost
    }

    /// Length of [`to_bytes`](Self::to_bytes).
    #[must_use]
    pub fn byte_len(&self) -> usize {
        HEAD + 8 * self.cells.len()
    }

    /// The context as bytes, little endian: start, index, flags, cells.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.byte_len());
        bytes.extend_from_slice(&self.start.to_le_bytes());
        bytes.extend_from_slice(&self.index.to_le_bytes());
        bytes.push(u8::from(self.dirty));
        for cell in &self.cells {
            bytes.extend_from_slice(&cell.to_le_bytes());
        }
        bytes
    }

    /// A context of the same system as `self` from bytes.
    ///
    /// # Errors
    /// [`ContextError`] where the length is another.
    pub fn with_bytes(&self, bytes: &[u8]) -> Result<Self, ContextError> {
        let wrong = ContextError { expected: self.byte_len(), found: bytes.len() };
        if bytes.len() != self.byte_len() {
            return Err(wrong);
        }
        let (head, tail) = bytes.split_at(HEAD);
        let word = |b: &[u8]| <[u8; 8]>::try_from(b).unwrap_or_default();
        Ok(Self {
            start: f64::from_le_bytes(word(&head[..8])),
            index: u64::from_le_bytes(word(&head[8..16])),
            dirty: head[16] != 0,
            cells: tail.chunks_exact(8).map(|b| f64::from_le_bytes(word(b))).collect(),
        })
    }
}

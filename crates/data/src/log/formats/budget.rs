//! How much memory the numbers of a file may take.
//!
//! Packed files can hold a thousand times their size, and a description of a table can name one
//! stretch of a file as often as it likes. What a file becomes is bounded by its size, unless the
//! user says otherwise.

use crate::log::group::Refusal;

/// Bytes that any file may become.
const FREE: u64 = 256 << 20;
/// Larger files may become so many times their size.
const EXPANSION: u64 = 100;

/// What is left of the memory for one file.
#[derive(Debug)]
pub(super) struct Budget {
    limit: u64,
    left: u64,
    /// Bytes that may still be unpacked.
    packed: u64,
    is_given: bool,
}

impl Budget {
    /// For a file of `size` bytes; `given` is the user's limit in bytes.
    pub(super) fn new(size: u64, given: Option<u64>) -> Self {
        let limit = given.unwrap_or_else(|| FREE.max(size.saturating_mul(EXPANSION)));
        Self { limit, left: limit, packed: limit, is_given: given.is_some() }
    }

    /// Takes `count` numbers of `bytes` bytes each.
    pub(super) fn take(&mut self, count: u64, bytes: u64) -> Result<(), Refusal> {
        let wanted = count.checked_mul(bytes).filter(|wanted| *wanted <= self.left);
        self.left -= wanted.ok_or_else(|| self.refusal())?;
        Ok(())
    }

    /// Takes a column of `rows` doubles; the result is `rows` in memory.
    pub(super) fn column(&mut self, rows: u64) -> Result<usize, Refusal> {
        self.take(rows, 8)?;
        usize::try_from(rows).map_err(|_| self.refusal())
    }

    /// Takes bytes that are unpacked, used and forgotten.
    pub(super) fn unpack(&mut self, bytes: u64) -> Result<(), Refusal> {
        self.packed = self.packed.checked_sub(bytes).ok_or_else(|| self.refusal())?;
        Ok(())
    }

    /// Bytes that numbers may still take.
    pub(super) fn left(&self) -> u64 {
        self.left
    }

    /// Bytes that may still be unpacked.
    pub(super) fn to_unpack(&self) -> u64 {
        self.packed
    }

    /// Why no more is read.
    pub(super) fn refusal(&self) -> Refusal {
        let megabytes = self.limit.div_ceil(1_000_000);
        let whose = if self.is_given { "" } else { ", 100 times the file's size but at least 268" };
        (
            format!("takes more memory than {megabytes} MB (the limit{whose})"),
            format!("where the file is trusted, raise the limit: --log-memory {}", 4 * megabytes),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_follows_the_size_and_is_in_the_message() {
        let mut small = Budget::new(1000, None);
        assert_eq!(small.column(1 << 20), Ok(1 << 20));
        let (rule, way_out) = small.column(1 << 25).unwrap_err();
        assert!(rule.contains("more memory than 269 MB"), "{rule}");
        assert!(way_out.contains("--log-memory 1076"), "{way_out}");
        assert!(small.take(u64::MAX, u64::MAX).is_err());
        assert!(Budget::new(10_000_000, None).take(1_000_000_000, 1).is_ok());
        assert!(Budget::new(10_000_000, Some(1000)).take(1001, 1).is_err());
    }
}

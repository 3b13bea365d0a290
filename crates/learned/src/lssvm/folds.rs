//! Which samples are held out together.

/// Parts of the samples; each is held out once.
#[derive(Clone, Debug, PartialEq)]
pub struct Folds {
    /// Indices of the samples of each part.
    parts: Vec<Vec<usize>>,
}

impl Folds {
    /// `parts` blocks of successive samples: for time series, and for simulation mode.
    #[must_use]
    pub fn blocks(samples: usize, parts: usize) -> Self {
        let parts = parts.clamp(1, samples.max(1));
        let block = |k: usize| (k * samples / parts..(k + 1) * samples / parts).collect();
        Self { parts: (0..parts).map(block).collect() }
    }

    /// Samples dealt out in turn: every part sees the whole record.
    #[must_use]
    pub fn interleaved(samples: usize, parts: usize) -> Self {
        let parts = parts.clamp(1, samples.max(1));
        let every = |k: usize| (k..samples).step_by(parts).collect();
        Self { parts: (0..parts).map(every).collect() }
    }

    /// The parts.
    #[must_use]
    pub fn parts(&self) -> &[Vec<usize>] {
        &self.parts
    }

    /// All samples in the order of the parts, and where each part ends.
    pub(crate) fn order(&self) -> (Vec<usize>, Vec<std::ops::Range<usize>>) {
        let order: Vec<usize> = self.parts.iter().flatten().copied().collect();
        let mut from = 0;
        let ranges = self.parts.iter().map(|part| {
            from += part.len();
            from - part.len()..from
        });
        (order, ranges.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_held_out_once() {
        for folds in [Folds::blocks(23, 5), Folds::interleaved(23, 5), Folds::blocks(3, 10)] {
            let (mut order, ranges) = folds.order();
            assert_eq!(ranges.last().map(|r| r.end), Some(order.len()));
            order.sort_unstable();
            assert!(order.iter().copied().eq(0..order.len()));
        }
        assert_eq!(Folds::blocks(23, 5).parts().len(), 5);
    }
}

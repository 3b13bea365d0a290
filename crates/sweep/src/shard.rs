//! A part of a sweep.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Part `index` of `count`, counted from 1: neighbouring runs, as many as in the other parts or one
/// more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

impl Shard {
    /// The runs of this part, of `runs` in all.
    #[must_use]
    pub fn range(self, runs: u64) -> Range<u64> {
        let cut = |at: u64| (u128::from(runs) * u128::from(at) / u128::from(self.count)) as u64;
        cut(self.index - 1)..cut(self.index)
    }

    /// Number of the part, from 1.
    #[must_use]
    pub fn index(self) -> u64 {
        self.index
    }

    /// Number of parts.
    #[must_use]
    pub fn count(self) -> u64 {
        self.count
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text
            .split_once('/')
            .and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        match parsed {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Shard { index, count }),
            _ => Err("write PART/PARTS, counted from 1, as in 3/8".to_owned()),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_complete_without_overlap() {
        for (runs, count) in [(10, 3), (2, 5), (0, 2), (1_000_003, 7)] {
            let parts = (1..=count).map(|index| Shard { index, count }.range(runs));
            let parts: Vec<_> = parts.collect();
            assert!(parts[0].start == 0 && parts.last().unwrap().end == runs);
            assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start));
            let sizes = parts.iter().map(|part| part.end - part.start);
            assert!(sizes.clone().max().unwrap() - sizes.min().unwrap() <= 1);
        }
    }

    #[test]
    fn what_is_no_part_is_refused() {
        for text in ["0/4", "5/4", "1", "1/0", "a/b", "-1/4", ""] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
        assert_eq!("3/8".parse::<Shard>().unwrap().to_string(), "3/8");
    }
}

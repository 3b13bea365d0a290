//! Which rows of a run are judged.

use std::ops::Range;
use std::str::FromStr;

use clap::Args;

/// Which rows are judged.
#[derive(Args, Debug, Clone, Default)]
pub(crate) struct Window {
    /// Judge these rows only, counted from 1 without the header, both ends included
    #[arg(long, value_name = "FIRST..LAST")]
    rows: Option<RowRange>,
    /// Judge from this time in s after the start of each record on
    #[arg(long = "drop", value_name = "S", value_parser = crate::ranges::time())]
    drop: Option<f64>,
}

/// `FIRST..LAST`, from 1, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct RowRange {
    first: usize,
    last: usize,
}

impl FromStr for RowRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let rule =
            || format!("\"{text}\": write FIRST..LAST, as in 5051..6050, with 1 as the first row");
        let (first, last) = text.split_once("..").ok_or_else(rule)?;
        let number = |t: &str| t.trim().parse::<usize>().map_err(|_| rule());
        let range = Self { first: number(first)?, last: number(last)? };
        if range.first < 1 || range.last < range.first {
            return Err(rule());
        }
        Ok(range)
    }
}

impl Window {
    /// The rows of `record` (from 0, in the log) that are judged; `None` where there is none.
    pub(crate) fn rows(&self, time: &[f64], record: &Range<usize>) -> Option<Range<usize>> {
        let mut rows = record.clone();
        if let Some(RowRange { first, last }) = self.rows {
            rows = rows.start.max(first - 1)..rows.end.min(last);
        }
        if let (Some(drop), Some(start)) = (self.drop, time.get(record.start)) {
            let from = time[record.clone()].partition_point(|t| *t < start + drop - 1e-9);
            rows.start = rows.start.max(record.start + from);
        }
        (rows.start < rows.end).then_some(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_counted_from_one_and_both_ends_count() {
        let window = Window { rows: Some("2..3".parse().expect("a range")), drop: None };
        assert_eq!(window.rows(&[0.0; 5], &(0..5)), Some(1..3));
        assert_eq!(window.rows(&[0.0; 5], &(3..5)), None);
        assert!("0..3".parse::<RowRange>().is_err());
        assert!("4..3".parse::<RowRange>().is_err());
        assert!("4".parse::<RowRange>().is_err());
    }

    #[test]
    fn the_run_in_is_left_out() {
        let time = [0.0, 0.5, 1.0, 1.5];
        let window = Window { rows: None, drop: Some(1.0) };
        assert_eq!(window.rows(&time, &(0..4)), Some(2..4));
        assert_eq!(Window { rows: None, drop: Some(9.0) }.rows(&time, &(0..4)), None);
    }
}

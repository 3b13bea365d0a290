//! Rows of the same time: jumps of a signal, or times that were written with too few digits.

use super::lines::Place;
use super::quality::median;
use super::ticks::EXACT;

/// Rows from which times can be judged.
const ENOUGH: usize = 30;

/// The rows that had the time of the row before.
#[derive(Debug, Default)]
pub(super) struct Repeats {
    /// How many there are.
    pub(super) rows: usize,
    /// Those before which all signals kept their values: a table of steps.
    pub(super) held: usize,
    /// Those that are the third or a later row of their time.
    pub(super) third: usize,
    /// The row of the log that the last of them is.
    pub(super) last: Option<usize>,
    /// The first of them.
    pub(super) first: Option<(Place, f64)>,
}

impl Repeats {
    /// Whether they are no jumps: too many of `times` different times occur twice, in what is no table of steps.
    pub(super) fn are_too_many(&self, times: usize) -> bool {
        let is_table = self.third == 0 && 10 * self.held >= 8 * self.rows;
        times + self.rows >= ENOUGH && 5 * self.rows >= 2 * times && !is_table
    }

    /// What was done about them.
    pub(super) fn note(&self) -> Option<String> {
        let (place, time) = self.first?;
        let rows = match self.rows {
            1 => "one row has".to_owned(),
            rows => format!("{rows} rows have"),
        };
        Some(format!(
            "{rows} the time of the row before (first in {place}, {time} s): these are jumps, of which the last row acts"
        ))
    }
}

/// What is doubtful about the times of a log, `None` for nothing; `is_stated` where the file has their unit. `base`
/// was taken off each of them.
pub(super) fn doubt(time: &[f64], is_stated: bool, base: f64) -> Option<String> {
    /// Intervals of which the usual one is taken.
    const FEW: usize = 1000;
    /// Usual intervals that are doubtful as one.
    const STRAY: f64 = 1000.0;
    // Seconds since 1970 have ten digits.
    if let Some(first) = time.first().filter(|first| !is_stated && base + **first > 1e11) {
        return Some(format!(
            "nothing says the unit of the times: {} s is more than 3000 years; are they ms, us or ns since 1970? Then \
             say it, as in --unit time=ms",
            base + first
        ));
    }
    let mut some: Vec<f64> = time.windows(2).take(FEW).map(|pair| pair[1] - pair[0]).collect();
    if some.len() < 10 {
        return None;
    }
    let usual = median(&mut some)?;
    let widest = time
        .windows(2)
        .enumerate()
        .max_by(|(_, a), (_, b)| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    if let Some((row, pair)) = widest
        && pair[1] - pair[0] > STRAY * usual
    {
        return Some(format!(
            "time jumps from {} s to {} s after row {}, where otherwise a row follows after {usual} s: is that a wrong time?",
            pair[0],
            pair[1],
            row + 1
        ));
    }
    // Beyond this, doubles tell times apart by a hundredth of a row or worse.
    let largest = time.iter().fold(0.0_f64, |most, time| most.max(time.abs()));
    if usual > 0.0 && largest * f64::EPSILON > 0.01 * usual {
        return Some(format!(
            "times up to {largest} s are too large for rows every {usual} s: numbers have 16 digits, of which {:.0} % of \
             a row is the last; save the times after the first row",
            100.0 * largest * f64::EPSILON / usual
        ));
    }
    // Times in µs that were computed from seconds have rounding in them: 900.0000000000001.
    let integral = || time.iter().all(|time| (time - time.round()).abs() <= 1e-12 * time.abs());
    if is_stated || usual < 1.0 || time.len() < if usual < 10.0 { 100 } else { 50 } || !integral() {
        return None;
    }
    let unit = if usual < 1000.0 { "ms or us" } else { "us or ns" };
    Some(format!(
        "nothing says the unit of the times: in s, a row follows every {usual} s; is time in {unit}? Then say it, as in \
         --unit time=us"
    ))
}

/// Whether these cells count rows: whole numbers that grow, by 1 somewhere.
pub(super) fn counts(cells: &[f64]) -> bool {
    let are_integers = cells.iter().all(|cell| cell.fract() == 0.0 && cell.abs() <= EXACT);
    let least = cells.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    are_integers && (cells.len() < 2 || least == 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_are_distinguished_from_times() {
        assert!(counts(&[10.0, 11.0, 13.0]) && counts(&[5.0]));
        for none in
            [&[0.0, 0.5][..], &[0.0, 100.0, 200.0], &[0.0, 0.0, 1.0], &[2.0, 1.0], &[f64::NAN]]
        {
            assert!(!counts(none), "{none:?}");
        }
    }

    #[test]
    fn stray_times_and_wrong_units_are_doubted() {
        let grid = |period: f64| (0..200).map(|k| f64::from(k) * period).collect::<Vec<_>>();
        assert_eq!(doubt(&grid(1e-3), false, 0.0), None);
        assert_eq!(doubt(&grid(100.0), true, 0.0), None);
        assert!(
            doubt(&grid(100.0), false, 0.0).unwrap().contains("every 100 s; is time in ms or us?")
        );
        let rounded: Vec<f64> = (0..200).map(|k| f64::from(k) * 1e-4 * 1e6).collect();
        assert!(doubt(&rounded, false, 0.0).unwrap().contains("is time in ms or us?"));
        assert!(doubt(&grid(5e4), false, 0.0).unwrap().contains("us or ns"));
        let since = |start: f64, period: f64| {
            grid(period).iter().map(|time| start + time).take(20).collect::<Vec<_>>()
        };
        assert!(doubt(&since(1.764e12, 10.0), false, 0.0).unwrap().contains("since 1970?"));
        assert_eq!(doubt(&since(1.764e9, 1e-3), true, 0.0), None);
        assert!(
            doubt(&since(1.764e9, 1e-6), true, 0.0).unwrap().contains("are too large for rows")
        );
        let mut stray = grid(1e-3);
        stray[150] = 1e9;
        stray[151..].iter_mut().for_each(|time| *time += 1e9);
        assert!(doubt(&stray, true, 0.0).unwrap().contains("after row 150"));
    }
}

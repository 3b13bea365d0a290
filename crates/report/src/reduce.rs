//! Fewer points for the same picture.
//!
//! Over time, each stretch keeps its smallest and its largest value, so that no peak is lost
//! whatever the zoom. Over frequency the stretches are equal on the logarithmic axis. Loops keep
//! their shape: Visvalingam and Whyatt (1993), *Line generalisation by repeated elimination of
//! points*, with the ends and the extremes of both coordinates pinned.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

/// Stretches of equal length over `samples` samples, two points kept of each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Buckets {
    samples: usize,
    count: usize,
}

impl Buckets {
    /// Stretches such that at most `max_points` points remain; `None` if all samples may stay.
    pub(crate) fn new(samples: usize, max_points: usize) -> Option<Self> {
        (samples > max_points).then_some(Self { samples, count: (max_points / 2).max(1) })
    }

    fn ranges(self) -> impl Iterator<Item = Range<usize>> {
        let edge = move |k: usize| (k as u128 * self.samples as u128 / self.count as u128) as usize;
        (0..self.count).map(move |k| edge(k)..edge(k + 1))
    }

    /// Two times per stretch: its first sample's and its middle's (at the very end, the last's).
    pub(crate) fn times(self, time: &[f64]) -> Vec<f64> {
        let mut times: Vec<f64> = self
            .ranges()
            .flat_map(|range| [range.start, range.start + range.len() / 2])
            .map(|i| value_at(time, i))
            .collect();
        if let (Some(end), Some(last)) = (times.last_mut(), time.last()) {
            *end = *last;
        }
        times
    }

    /// The smallest and the largest value of each stretch, in the order in which they occur.
    pub(crate) fn extremes(self, values: &[f64]) -> Vec<f64> {
        self.ranges()
            .flat_map(|range| match extreme_indices(values, range) {
                Some((first, second)) => [value_at(values, first), value_at(values, second)],
                None => [f64::NAN; 2],
            })
            .collect()
    }
}

fn value_at(values: &[f64], i: usize) -> f64 {
    values.get(i).copied().unwrap_or(f64::NAN)
}

/// Where the smallest and the largest finite value of a stretch lie, in order.
fn extreme_indices(values: &[f64], range: Range<usize>) -> Option<(usize, usize)> {
    let finite = range.filter(|&i| value_at(values, i).is_finite());
    let (low, high) = finite.fold(None, |found: Option<(usize, usize)>, i| {
        let (mut low, mut high) = found.unwrap_or((i, i));
        if value_at(values, i) < value_at(values, low) {
            low = i;
        }
        if value_at(values, i) > value_at(values, high) {
            high = i;
        }
        Some((low, high))
    })?;
    Some((low.min(high), low.max(high)))
}

/// Indices of at most `max_points` points of `values`, extremes kept; all if there are few enough.
///
/// A stretch without a finite value keeps one index, so that the gap is still seen.
pub(crate) fn extremes(values: &[f64], max_points: usize) -> Vec<usize> {
    let Some(buckets) = Buckets::new(values.len(), max_points) else {
        return (0..values.len()).collect();
    };
    let mut kept = Vec::with_capacity(max_points);
    for range in buckets.ranges() {
        let start = range.start;
        let (first, second) = extreme_indices(values, range).unwrap_or((start, start));
        kept.push(first);
        if second != first {
            kept.push(second);
        }
    }
    kept
}

/// Indices of the points of curves over an increasing positive `x` that share an x axis; the
/// stretches are equal on a logarithmic axis and keep the extremes of every curve.
pub(crate) fn log_extremes(x: &[f64], curves: &[&[f64]], max_points: usize) -> Vec<usize> {
    let all = || (0..x.len()).collect();
    let (Some(&first), Some(&last)) = (x.first(), x.last()) else {
        return Vec::new();
    };
    if x.len() <= max_points || curves.is_empty() || first <= 0.0 || last <= first {
        return all();
    }
    let buckets = (max_points / (2 * curves.len())).max(1);
    let decades = (last / first).ln();
    let bucket = |i: usize| {
        ((value_at(x, i) / first).ln() / decades * buckets as f64).min(buckets as f64 - 1.0)
            as usize
    };
    let mut kept = vec![0];
    let mut start = 0;
    while start < x.len() {
        let this = bucket(start);
        let end = (start + 1..x.len()).find(|&i| bucket(i) != this).unwrap_or(x.len());
        for curve in curves {
            kept.extend(extreme_indices(curve, start..end).map(|(a, b)| [a, b]).iter().flatten());
        }
        start = end;
    }
    kept.push(x.len() - 1);
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// One point of a line that may go, with the area that goes with it.
#[derive(PartialEq)]
struct Candidate {
    area: f64,
    index: usize,
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap gives its largest: the smallest area first, and of equals the first point.
        other.area.total_cmp(&self.area).then(other.index.cmp(&self.index))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Indices of at most `max_points` points of the line through `(x, y)` that keep its shape.
///
/// Points that are not finite split the line and stay, as gaps, if there is room for them.
pub(crate) fn shape(x: &[f64], y: &[f64], max_points: usize) -> Vec<usize> {
    let n = x.len().min(y.len());
    if n <= max_points || max_points < 8 {
        return (0..n).take(max_points.max(2)).collect();
    }
    let mut line = Line::new(&x[..n], &y[..n]);
    line.thin_to(max_points);
    line.kept()
}

/// A line whose points leave one by one, held as a doubly linked list of indices.
struct Line {
    x: Vec<f64>,
    y: Vec<f64>,
    before: Vec<usize>,
    after: Vec<usize>,
    area: Vec<f64>,
    alive: Vec<bool>,
    left: usize,
}

impl Line {
    fn new(x: &[f64], y: &[f64]) -> Self {
        let n = x.len();
        let mut line = Self {
            x: unit_range(x),
            y: unit_range(y),
            before: (0..n).map(|i| i.saturating_sub(1)).collect(),
            after: (0..n).map(|i| (i + 1).min(n - 1)).collect(),
            area: vec![f64::INFINITY; n],
            alive: vec![true; n],
            left: n,
        };
        line.drop_repeated_gaps();
        for i in (0..n).filter(|&i| line.alive[i]) {
            line.area[i] = line.triangle(i);
        }
        for values in [x, y] {
            if let Some((low, high)) = extreme_indices(values, 0..n) {
                line.area[low] = f64::INFINITY;
                line.area[high] = f64::INFINITY;
            }
        }
        line
    }

    fn is_gap(&self, i: usize) -> bool {
        !(self.x[i].is_finite() && self.y[i].is_finite())
    }

    /// A run of missing points is one gap: one point says it.
    fn drop_repeated_gaps(&mut self) {
        for i in 1..self.x.len().saturating_sub(1) {
            if self.is_gap(i) && self.is_gap(self.before[i]) {
                self.remove(i);
            }
        }
    }

    /// Area of the triangle of a point and its neighbours; infinite at ends and gaps.
    fn triangle(&self, i: usize) -> f64 {
        let (a, b) = (self.before[i], self.after[i]);
        if a == i || b == i {
            return f64::INFINITY;
        }
        let area = (self.x[b] - self.x[a]) * (self.y[i] - self.y[a])
            - (self.x[i] - self.x[a]) * (self.y[b] - self.y[a]);
        if area.is_finite() { area.abs() } else { f64::INFINITY }
    }

    fn remove(&mut self, i: usize) {
        let (a, b) = (self.before[i], self.after[i]);
        self.after[a] = b;
        self.before[b] = a;
        self.alive[i] = false;
        self.left -= 1;
    }

    fn thin_to(&mut self, max_points: usize) {
        let mut heap: BinaryHeap<Candidate> = (0..self.x.len())
            .filter(|&i| self.alive[i])
            .map(|index| Candidate { area: self.area[index], index })
            .collect();
        while self.left > max_points {
            let Some(Candidate { area, index }) = heap.pop() else { break };
            // An entry whose area has changed since is stale; its newer twin is in the heap.
            if !self.alive[index] || area != self.area[index] {
                continue;
            }
            let (a, b) = (self.before[index], self.after[index]);
            if a == index || b == index {
                continue;
            }
            self.remove(index);
            for neighbour in [a, b] {
                if self.area[neighbour].is_finite() {
                    // Never smaller than what has gone: the order of leaving stays monotone.
                    self.area[neighbour] = self.triangle(neighbour).max(area);
                    heap.push(Candidate { area: self.area[neighbour], index: neighbour });
                }
            }
        }
    }

    fn kept(&self) -> Vec<usize> {
        (0..self.x.len()).filter(|&i| self.alive[i]).collect()
    }
}

/// The values mapped onto 0…1, so that areas weigh both axes alike.
fn unit_range(values: &[f64]) -> Vec<f64> {
    let finite = || values.iter().copied().filter(|x| x.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    let span = if high > low { high - low } else { 1.0 };
    values.iter().map(|x| (x - low) / span).collect()
}

/// Rounds values to a millionth of their range, on a decimal grid: short numbers for the page.
pub(crate) fn short(values: &[f64]) -> Vec<f64> {
    let finite = || values.iter().copied().filter(|x| x.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    let span = high - low;
    if !(span.is_finite() && span > 0.0) {
        return values.to_vec();
    }
    let decimals = 6 - span.log10().floor() as i32;
    values.iter().map(|&x| round_to(x, decimals)).collect()
}

/// Rounds a value to six significant digits, for axes and curves that span decades.
pub(crate) fn short_relative(values: &[f64]) -> Vec<f64> {
    values.iter().map(|x| format!("{x:.5e}").parse().unwrap_or(*x)).collect()
}

fn round_to(x: f64, decimals: i32) -> f64 {
    match usize::try_from(decimals) {
        Ok(decimals) if x.is_finite() && decimals <= 300 => {
            format!("{x:.decimals$}").parse().unwrap_or(x)
        }
        _ => x.round(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn finite_ends(values: &[f64]) -> (f64, f64) {
        let finite = || values.iter().copied().filter(|x| x.is_finite());
        (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max))
    }

    proptest! {
        #[test]
        fn extremes_survive_over_time(
            values in prop::collection::vec(
                prop_oneof![9 => -1e6..1e6, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY)],
                1..3000,
            ),
            max_points in 2_usize..200,
        ) {
            let kept = extremes(&values, max_points);
            let drawn: Vec<f64> = kept.iter().map(|&i| values[i]).collect();
            prop_assert!(kept.len() <= max_points.max(2));
            prop_assert!(kept.windows(2).all(|pair| pair[0] < pair[1]));
            prop_assert_eq!(finite_ends(&drawn), finite_ends(&values));
            if let Some(buckets) = Buckets::new(values.len(), max_points) {
                prop_assert_eq!(finite_ends(&buckets.extremes(&values)), finite_ends(&values));
                prop_assert_eq!(buckets.times(&values).len(), buckets.extremes(&values).len());
            }
        }

        #[test]
        fn loops_keep_ends_and_extremes(
            points in prop::collection::vec((-1e3..1e3, -1e3..1e3), 20..800),
            max_points in 8_usize..200,
        ) {
            let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
            let kept = shape(&x, &y, max_points);
            prop_assert!(kept.len() <= max_points);
            prop_assert_eq!(kept.first(), Some(&0));
            prop_assert_eq!(kept.last(), Some(&(x.len() - 1)));
            for values in [&x, &y] {
                let drawn: Vec<f64> = kept.iter().map(|&i| values[i]).collect();
                prop_assert_eq!(finite_ends(&drawn), finite_ends(values));
            }
        }
    }

    #[test]
    fn a_thinned_loop_lies_on_the_loop() {
        let n = 100_000;
        let angle = |i: usize| i as f64 / n as f64 * std::f64::consts::TAU;
        let x: Vec<f64> = (0..n).map(|i| angle(i).cos()).collect();
        let y: Vec<f64> = (0..n).map(|i| (angle(i) - 0.3).sin()).collect();
        let kept = shape(&x, &y, 400);
        assert_eq!(kept.len(), 400);
        // The sagitta of 400 chords of an ellipse of half axes up to 1.2.
        for pair in kept.windows(2) {
            let middle = (pair[0] + pair[1]) / 2;
            let chord = |v: &[f64]| (v[pair[0]] + v[pair[1]]) / 2.0;
            let off = (chord(&x) - x[middle]).hypot(chord(&y) - y[middle]);
            assert!(off < 2e-4, "{off} at {middle}");
        }
    }

    #[test]
    fn a_gap_in_a_loop_stays_a_gap() {
        let mut x: Vec<f64> = (0..1000).map(f64::from).collect();
        x[300..400].fill(f64::NAN);
        let y: Vec<f64> = (0..1000).map(|i| f64::from(i % 7)).collect();
        let kept = shape(&x, &y, 100);
        assert_eq!(kept.iter().filter(|&&i| x[i].is_nan()).count(), 1);
    }

    #[test]
    fn a_narrow_peak_survives_on_a_logarithmic_axis() {
        let f: Vec<f64> = (1..100_000).map(f64::from).collect();
        let mut y = vec![1.0; f.len()];
        y[77_777] = 50.0;
        y[5] = 0.1;
        let kept = log_extremes(&f, &[&y], 500);
        assert!(kept.len() <= 502, "{}", kept.len());
        assert!(kept.contains(&77_777) && kept.contains(&5));
        assert!(kept.contains(&0) && kept.contains(&(f.len() - 1)));
    }

    #[test]
    fn short_numbers_keep_a_millionth_of_the_range() {
        let values = [1_000.123_456_789, 1_001.987_654_321, f64::NAN];
        let rounded = short(&values);
        assert_eq!(&rounded[..2], &[1_000.123_457, 1_001.987_654]);
        assert!(rounded[2].is_nan());
        assert_eq!(short(&[3e300, -3e300]), [3e300, -3e300]);
        assert_eq!(short(&[1.0 / 3.0; 2]), [1.0 / 3.0; 2]);
    }
}

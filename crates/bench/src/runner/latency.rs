//! Histograms of times.

use hdrhistogram::Histogram;

/// Longest time that is told apart from longer ones: 10 s.
const LONGEST_NS: u64 = 10_000_000_000;

/// A histogram of times in ns, three significant digits, of fixed size.
#[derive(Clone, Debug)]
pub struct Latency(Option<Histogram<u64>>);

/// What a histogram says, in µs.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Percentiles {
    /// Number of times.
    pub count: u64,
    /// Half are shorter.
    pub p50_us: f64,
    /// 99 % are shorter.
    pub p99_us: f64,
    /// 99.9 % are shorter.
    pub p999_us: f64,
    /// 99.99 % are shorter.
    pub p9999_us: f64,
    /// The longest.
    pub max_us: f64,
}

impl Default for Latency {
    fn default() -> Self {
        Self::new()
    }
}

impl Latency {
    /// An empty one.
    #[must_use]
    pub fn new() -> Self {
        // The bounds are good ones; a histogram that cannot be made counts nothing.
        Latency(Histogram::new_with_bounds(1, LONGEST_NS, 3).ok())
    }

    /// Counts one time; allocates nothing.
    pub fn record(&mut self, ns: u64) {
        if let Some(histogram) = &mut self.0 {
            histogram.saturating_record(ns.max(1));
        }
    }

    /// What it says.
    #[must_use]
    pub fn percentiles(&self) -> Percentiles {
        let Some(histogram) = self.0.as_ref().filter(|histogram| !histogram.is_empty()) else {
            return Percentiles::default();
        };
        let at = |part: f64| histogram.value_at_quantile(part) as f64 * 1e-3;
        Percentiles {
            count: histogram.len(),
            p50_us: at(0.5),
            p99_us: at(0.99),
            p999_us: at(0.999),
            p9999_us: at(0.9999),
            max_us: histogram.max() as f64 * 1e-3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_times() {
        let mut latency = Latency::new();
        assert_eq!(latency.percentiles(), Percentiles::default());
        (1..=10_000u64).for_each(|us| latency.record(us * 1000));
        let found = latency.percentiles();
        assert_eq!(found.count, 10_000);
        for (value, exact) in [
            (found.p50_us, 5000.0),
            (found.p99_us, 9900.0),
            (found.p999_us, 9990.0),
            (found.p9999_us, 9999.0),
            (found.max_us, 10_000.0),
        ] {
            assert!((value / exact - 1.0).abs() < 2e-3, "{value} for {exact}");
        }
    }
}

//! How long the FMUs' steps take.
//!
//! Reading the clock costs as much as a step of a small FMU. So only some communication steps are
//! timed, chosen at random and so rarely that it takes at most half a percent of the run; where steps
//! take some microseconds and more, that is each of them.

use std::time::{Duration, Instant};

use numerics::random::SplitMix64;

/// Part of a run's time that reading the clock may take.
const SHARE: f64 = 0.005;
/// Bins of the histogram: the first is below 1 ns, each ends at twice the end before.
const BINS: usize = 48;

/// How long one FMU's steps took.
#[derive(Clone, Debug, PartialEq)]
pub struct FmuTimes {
    /// Name of the FMU.
    pub name: String,
    /// Steps that it has made, those that an iteration repeats included.
    pub calls: u64,
    /// Steps that were timed.
    pub timed: u64,
    /// Mean time of a timed step in s.
    pub mean: f64,
    /// Shortest and longest time of a timed step in s.
    pub range: (f64, f64),
    /// Number of timed steps by their time: upper end in s (each bin begins where the one before ends,
    /// and ends at twice that), count. From the first to the last bin that is not empty.
    pub histogram: Vec<(f64, u64)>,
}

impl FmuTimes {
    /// Time of all its steps in s, from those that were timed.
    pub fn total(&self) -> f64 {
        self.mean * self.calls as f64
    }
}

/// How long a run took, or several of one system.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Time on the clock in s, from the first communication step to the end.
    pub wall: f64,
    /// Time that was simulated in s.
    pub simulated: f64,
    /// Communication steps.
    pub steps: u64,
    /// Communication steps that were timed.
    pub timed_steps: u64,
    /// The FMUs, in the order of the system.
    pub fmus: Vec<FmuTimes>,
    /// Steps of a paced run that began too late by more than a tenth of a step.
    pub late_steps: u64,
    /// The most that a step of a paced run began too late, s.
    pub latest: f64,
}

/// Times of one FMU's steps.
#[derive(Clone, Debug)]
pub(crate) struct Times {
    pub(crate) calls: u64,
    timed: u64,
    nanoseconds: u64,
    least: u64,
    most: u64,
    bins: [u64; BINS],
}

impl Default for Times {
    fn default() -> Self {
        let (calls, timed, nanoseconds, least, most) = (0, 0, 0, u64::MAX, 0);
        Times { calls, timed, nanoseconds, least, most, bins: [0; BINS] }
    }
}

impl Times {
    /// Notes a step that took so long.
    pub(crate) fn note(&mut self, took: Duration) {
        let took = u64::try_from(took.as_nanos()).unwrap_or(u64::MAX);
        self.timed += 1;
        self.nanoseconds = self.nanoseconds.saturating_add(took);
        self.least = self.least.min(took);
        self.most = self.most.max(took);
        let bin = (u64::BITS - took.leading_zeros()) as usize;
        if let Some(count) = self.bins.get_mut(bin.min(BINS - 1)) {
            *count += 1;
        }
    }

    /// What is told of an FMU of this name.
    pub(crate) fn report(&self, name: &str) -> FmuTimes {
        let seconds = |nanoseconds: u64| nanoseconds as f64 * 1e-9;
        let first = self.bins.iter().position(|count| *count > 0).unwrap_or(BINS);
        let last = self.bins.iter().rposition(|count| *count > 0).map_or(first, |last| last + 1);
        let bins = self.bins.get(first..last).unwrap_or_default();
        let end = |bin: usize| seconds(1) * (bin as f64).exp2();
        let least = if self.timed == 0 { 0 } else { self.least };
        FmuTimes {
            name: name.to_owned(),
            calls: self.calls,
            timed: self.timed,
            mean: seconds(self.nanoseconds) / self.timed.max(1) as f64,
            range: (seconds(least), seconds(self.most)),
            histogram: (first..).map(end).zip(bins.iter().copied()).collect(),
        }
    }
}

/// Chooses the communication steps that are timed, and keeps the run's pace.
pub(crate) struct Stopwatch {
    begin: Instant,
    /// Number of the next step that is timed.
    next: usize,
    /// What timing one step costs in s.
    cost: f64,
    /// Step and time of the last choice, and the shortest mean time of a step between two: what else the
    /// machine does makes steps longer, but not their part of the processor's time.
    last: (usize, f64),
    quickest: f64,
    random: SplitMix64,
    timed: u64,
    late: (u64, f64),
}

impl Stopwatch {
    /// For a system of so many FMUs.
    pub(crate) fn start(fmus: usize) -> Self {
        const READINGS: u32 = 32;
        let begin = Instant::now();
        for _ in 0..READINGS {
            std::hint::black_box(Instant::now());
        }
        let reading = begin.elapsed().as_secs_f64() / f64::from(READINGS);
        let cost = reading * (2 * fmus + 1) as f64;
        let (next, random, timed) = (0, SplitMix64::new(1), 0);
        let (last, quickest, late) = ((0, 0.0), f64::INFINITY, (0, 0.0));
        Stopwatch { begin: Instant::now(), next, cost, last, quickest, random, timed, late }
    }

    /// Whether step `n` is timed.
    #[inline]
    pub(crate) fn is_due(&mut self, n: usize) -> bool {
        n >= self.next && self.choose(n)
    }

    /// Chooses the step after `n` that is timed: from all steps alike, so that nothing in the FMUs that
    /// repeats is always met or always missed.
    #[cold]
    fn choose(&mut self, n: usize) -> bool {
        self.timed += 1;
        let now = self.begin.elapsed().as_secs_f64();
        if n > self.last.0 {
            // The last step was a timed one.
            let step = (now - self.last.1 - self.cost).max(1e-9) / (n - self.last.0) as f64;
            self.quickest = self.quickest.min(step);
        }
        self.last = (n, now);
        let apart =
            if n == 0 { 1.0 } else { (self.cost / (SHARE * self.quickest)).clamp(1.0, 1e6) };
        self.next = n + 1 + (2.0 * self.random.uniform() * (apart - 1.0)).round() as usize;
        true
    }

    /// Waits until `due` seconds after the begin; a step of `step` seconds (both on the clock) begins then.
    pub(crate) fn wait(&mut self, due: f64, step: f64) {
        /// The operating system wakes a thread up to so much too late, so the rest is waited for awake.
        const AWAKE: Duration = Duration::from_micros(150);
        let Ok(due) = Duration::try_from_secs_f64(due.max(0.0)) else { return };
        let left = due.saturating_sub(self.begin.elapsed());
        if left.is_zero() {
            let late = self.begin.elapsed().saturating_sub(due).as_secs_f64();
            self.late.0 += u64::from(late > 0.1 * step);
            self.late.1 = self.late.1.max(late);
            return;
        }
        if left > AWAKE {
            std::thread::sleep(left - AWAKE);
        }
        while self.begin.elapsed() < due {
            std::hint::spin_loop();
        }
    }

    /// Adds this run, which has made so many steps over so many seconds.
    pub(crate) fn stop(&self, total: &mut Statistics, steps: usize, simulated: f64) {
        total.wall += self.begin.elapsed().as_secs_f64();
        total.simulated += simulated;
        total.steps += steps as u64;
        total.timed_steps += self.timed;
        total.late_steps += self.late.0;
        total.latest = total.latest.max(self.late.1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_sorted_into_bins_that_double() {
        let mut times = Times::default();
        for nanoseconds in [1, 2, 3, 1000, 1023, 1024] {
            times.note(Duration::from_nanos(nanoseconds));
        }
        times.calls = 12;
        let report = times.report("p");
        assert_eq!((report.timed, report.range), (6, (1e-9, 1.024e-6)));
        assert!((report.total() - 12.0 * 3053e-9 / 6.0).abs() < 1e-18);
        let counts: Vec<u64> = report.histogram.iter().map(|bin| bin.1).collect();
        assert_eq!(counts, [1, 2, 0, 0, 0, 0, 0, 0, 0, 2, 1]);
        assert!((report.histogram[0].0 - 2e-9).abs() < 1e-20, "{:?}", report.histogram);
        assert!((report.histogram[10].0 - 2.048e-6).abs() < 1e-18, "{:?}", report.histogram);
        assert!(Times::default().report("p").histogram.is_empty());
    }

    #[test]
    fn a_paced_run_waits() {
        let mut watch = Stopwatch::start(1);
        watch.wait(0.02, 0.01);
        assert!(watch.begin.elapsed() >= Duration::from_millis(20));
        watch.wait(0.001, 0.01);
        assert_eq!(watch.late.0, 1);
        assert!(watch.late.1 >= 0.019);
    }
}

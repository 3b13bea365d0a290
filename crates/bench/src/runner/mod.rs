//! The runner: one [`Cycle`] per deadline, and what it costs in time.

mod latency;
mod orders;

pub use latency::{Latency, Percentiles};
pub use orders::SharedOrders;

use rtrb::Producer;

use crate::clock::{now_ns, thread_time_ns, wait_until};
use crate::cycle::{Cycle, Orders, Tick};
use crate::gateway::{Gateway, Refused};
use crate::receive::Counters;
use crate::safety::{Memory, Reason, State};

/// How the runner goes about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Length of a cycle in ns.
    pub period_ns: u64,
    /// So many cycles in the state ready before it starts by itself.
    pub settle: u64,
    /// So many cycles in the state idle before it gives up.
    pub patience: u64,
}

/// Cycles without ENABLE at the end, so that one of them arrives.
const GOODBYE: u32 = 10;

/// What came of a run.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Outcome {
    /// Last state.
    #[serde(serialize_with = "as_text")]
    pub state: State,
    /// Why.
    #[serde(serialize_with = "as_text")]
    pub reason: Reason,
    /// Whether the last command was the safe value; not after a third interruption.
    pub at_rest: bool,
    /// Cycles that ran.
    pub cycles: u64,
    /// Cycles that ended after the next deadline.
    pub overruns: u64,
    /// Deadlines that had no cycle because of them.
    pub skipped: u64,
    /// Cycles that drove on with an older sample.
    pub held: u64,
    /// Rows that the recorder was too slow for.
    pub unrecorded: u64,
    /// Packets that the gateway did not take.
    pub unsent: u64,
    /// Packets that were refused for their tags; none: the gateway has no key.
    pub keyed: Option<Refused>,
    /// Cycles times axes in which a command was limited.
    pub clipped: u64,
    /// Packets from the machine.
    pub measurements: Counters,
    /// How long after its deadline a cycle began.
    pub wake: Percentiles,
    /// How long a cycle worked: receive, compute, send, hand over the row.
    pub work: Percentiles,
    /// Processor time of the same: what the work costs on a computer that does nothing else.
    pub processor: Percentiles,
    /// From a command to its answer, as the cycle sees it.
    pub round_trip: Percentiles,
    /// What the controller said when it failed.
    pub failure: Option<String>,
    /// What the machine's driver said when it first failed.
    pub gateway_failure: Option<String>,
    /// Why whole packets were refused, if some were.
    pub refused: Option<String>,
}

fn as_text<S: serde::Serializer>(
    value: &impl std::fmt::Display,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

impl Outcome {
    /// Whether it ended as it should.
    #[must_use]
    pub fn is_good(&self) -> bool {
        matches!(self.reason, Reason::Finished | Reason::Stopped | Reason::None)
    }

    /// What somebody who reads the record should know: what was missed, held and lost.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let notes = [
            (self.skipped, "deadlines were missed: no row, and bench.skipped of the next row"),
            (self.held, "cycles drove on with an older position: bench.missing is not 0"),
            (self.unrecorded, "rows are missing in the record: it was written too slowly"),
        ];
        let some = notes.into_iter().filter(|(count, _)| *count > 0);
        some.map(|(count, what)| format!("{count} {what}")).collect()
    }
}

/// Runs cycles until the plan has ended, somebody stops it, or a fault has brought the machine to
/// rest. Rows go into the ring buffer from the state ready on.
///
/// It allocates nothing and takes no lock between the first cycle and the last.
pub fn run(
    cycle: &mut Cycle,
    gateway: &mut dyn Gateway,
    orders: &SharedOrders,
    settings: &Settings,
    rows: &mut Producer<f64>,
) -> Outcome {
    let mut pace = Pace::new(settings.period_ns);
    let mut waits = Waits::default();
    let mut unrecorded = 0;
    let mut goodbye = 0;
    loop {
        let tick = pace.wait();
        let given = orders.read();
        let start = given.start || waits.ready >= settings.settle;
        let stop = given.stop || waits.idle >= settings.patience;
        let memory = cycle.run(&tick, &Orders { start, stop, ..given }, gateway);
        waits.count(memory.state);
        if memory.state != State::Idle && !hand_over(cycle.row(), rows) {
            unrecorded += 1;
        }
        pace.done(cycle.round_trip_ns());
        let ends = matches!(memory.state, State::Safe | State::Fault) && cycle.at_rest();
        goodbye = if ends { goodbye + 1 } else { 0 };
        if goodbye > GOODBYE || orders.leaves() {
            break;
        }
    }
    Outcome {
        keyed: gateway.refused(),
        gateway_failure: gateway.failure(),
        ..outcome(cycle, &pace, waits.lonely(settings), unrecorded)
    }
}

fn outcome(cycle: &Cycle, pace: &Pace, lonely: bool, unrecorded: u64) -> Outcome {
    let Memory { state, reason } = cycle.memory();
    Outcome {
        state,
        reason: if lonely { Reason::SampleLost } else { reason },
        at_rest: cycle.at_rest(),
        cycles: pace.cycles,
        overruns: pace.overruns,
        skipped: pace.skipped,
        held: cycle.held(),
        unrecorded,
        keyed: None,
        gateway_failure: None,
        unsent: cycle.unsent(),
        clipped: cycle.clipped(),
        measurements: *cycle.counters(),
        wake: pace.wake.percentiles(),
        work: pace.work.percentiles(),
        processor: pace.processor.percentiles(),
        round_trip: pace.round_trip.percentiles(),
        failure: cycle.failure(),
        refused: cycle.refused().map(|error| error.to_string()),
    }
}

/// Puts a row into the ring; false when the ring is full.
fn hand_over(row: &[f64], rows: &mut Producer<f64>) -> bool {
    let Ok(mut chunk) = rows.write_chunk(row.len()) else { return false };
    let (first, second) = chunk.as_mut_slices();
    let (head, tail) = row.split_at(first.len());
    first.copy_from_slice(head);
    second.copy_from_slice(tail);
    chunk.commit_all();
    true
}

/// How long it has been in a state.
#[derive(Clone, Copy, Debug, Default)]
struct Waits {
    idle: u64,
    ready: u64,
}

impl Waits {
    fn count(&mut self, state: State) {
        self.idle = if state == State::Idle { self.idle + 1 } else { self.idle };
        self.ready = if state == State::Ready { self.ready + 1 } else { 0 };
        if state == State::Ready {
            self.idle = 0;
        }
    }

    fn lonely(&self, settings: &Settings) -> bool {
        self.idle >= settings.patience
    }
}

/// Deadlines on a grid, and the times around them.
#[derive(Debug)]
struct Pace {
    period_ns: u64,
    begin_ns: u64,
    next: u64,
    tick: Tick,
    cycles: u64,
    overruns: u64,
    skipped: u64,
    last_work_ns: u64,
    processor_ns: u64,
    wake: Latency,
    work: Latency,
    processor: Latency,
    round_trip: Latency,
}

impl Pace {
    fn new(period_ns: u64) -> Self {
        let begin_ns = now_ns() + 10 * period_ns;
        Pace {
            period_ns,
            begin_ns,
            next: 0,
            tick: Tick::default(),
            cycles: 0,
            overruns: 0,
            skipped: 0,
            last_work_ns: 0,
            processor_ns: 0,
            wake: Latency::new(),
            work: Latency::new(),
            processor: Latency::new(),
            round_trip: Latency::new(),
        }
    }

    /// Waits for the next deadline that has not passed by a whole period.
    fn wait(&mut self) -> Tick {
        let deadline = self.begin_ns + self.next * self.period_ns;
        wait_until(deadline);
        self.processor_ns = thread_time_ns();
        let now_ns = now_ns();
        let wake_ns = now_ns.saturating_sub(deadline);
        let missed = wake_ns / self.period_ns;
        self.tick = Tick {
            index: self.next + missed,
            skipped: u32::try_from(missed).unwrap_or(u32::MAX),
            now_ns,
            wake_ns: wake_ns % self.period_ns,
            last_work_ns: self.last_work_ns,
        };
        self.skipped += missed;
        self.wake.record(wake_ns);
        self.next = self.tick.index + 1;
        self.tick
    }

    fn done(&mut self, round_trip_ns: Option<u64>) {
        let end = now_ns();
        self.processor.record(thread_time_ns().saturating_sub(self.processor_ns));
        self.last_work_ns = end.saturating_sub(self.tick.now_ns);
        self.work.record(self.last_work_ns);
        if let Some(time) = round_trip_ns {
            self.round_trip.record(time);
        }
        self.cycles += 1;
        self.overruns += u64::from(end > self.begin_ns + self.next * self.period_ns);
    }
}

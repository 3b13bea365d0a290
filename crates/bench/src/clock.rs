//! Monotonic time, absolute waits, and what makes a thread real-time.

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{ClockId, clock_nanosleep_absolute, set_current_timer_slack};
use rustix::time::{Timespec, clock_gettime};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Nanoseconds per second.
pub(crate) const SECOND: u64 = 1_000_000_000;

/// Monotonic time in ns.
#[must_use]
pub fn now_ns() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    u64::try_from(time.tv_sec).unwrap_or(0) * SECOND + u64::try_from(time.tv_nsec).unwrap_or(0)
}

/// Processor time of the calling thread in ns.
#[must_use]
pub fn thread_time_ns() -> u64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    u64::try_from(time.tv_sec).unwrap_or(0) * SECOND + u64::try_from(time.tv_nsec).unwrap_or(0)
}

/// Sleeps until this monotonic time, at once if it has passed.
pub fn wait_until(deadline_ns: u64) {
    let request =
        Timespec { tv_sec: (deadline_ns / SECOND) as i64, tv_nsec: (deadline_ns % SECOND) as i64 };
    while clock_nanosleep_absolute(ClockId::Monotonic, &request)
        .is_err_and(|error| error == rustix::io::Errno::INTR)
    {}
}

/// What the operating system granted.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Realtime {
    /// The thread runs under SCHED_FIFO, before all ordinary ones.
    pub fifo: bool,
    /// Memory is locked: no page is fetched from disk in the middle of a cycle.
    pub locked: bool,
    /// One line for a person.
    pub line: String,
}

/// Priority of the cycle among real-time threads (1 to 99): above most, below the kernel's.
const PRIORITY: u8 = 80;

/// Makes the calling thread real-time as far as it is permitted.
#[must_use]
pub fn become_realtime() -> Realtime {
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let priority = thread_priority::ThreadPriorityValue::try_from(PRIORITY)
        .map_or(ThreadPriority::Max, ThreadPriority::Crossplatform);
    let fifo = set_thread_priority_and_policy(thread_native_id(), priority, policy).is_ok();
    let locked = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).is_ok();
    // The smallest slack; without effect under SCHED_FIFO.
    let _ = set_current_timer_slack(std::num::NonZeroU64::new(1));
    let line = match (fifo, locked) {
        (true, true) => "real-time: SCHED_FIFO and locked memory".to_owned(),
        _ => format!(
            "real-time: {} and {}; permit it with rtprio and memlock in /etc/security/limits.conf, or CAP_SYS_NICE and CAP_IPC_LOCK",
            if fifo {
                "SCHED_FIFO"
            } else {
                "NOT SCHED_FIFO (not permitted): cycles will be late under load"
            },
            if locked { "locked memory" } else { "memory NOT locked (not permitted)" },
        ),
    };
    Realtime { fifo, locked, line }
}

/// Keeps the calling thread on one processor, counted from 0.
///
/// # Errors
/// There is no such processor.
pub fn pin(cpu: usize) -> std::io::Result<()> {
    let mut set = rustix::thread::CpuSet::new();
    if cpu >= rustix::thread::CpuSet::MAX_CPU {
        return Err(std::io::ErrorKind::InvalidInput.into());
    }
    set.set(cpu);
    Ok(rustix::thread::sched_setaffinity(None, &set)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_ends_after_its_deadline() {
        let deadline = now_ns() + 3_000_000;
        wait_until(deadline);
        assert!(now_ns() >= deadline);
        wait_until(0);
    }
}

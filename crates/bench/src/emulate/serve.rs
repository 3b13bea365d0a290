//! The emulator in real time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::link::Injected;
use super::{Emulator, Timing};
use crate::clock::{now_ns, wait_until};
use crate::gateway::Gateway;
use crate::plant::PlantError;
use crate::receive::Counters;

/// When it ends.
#[derive(Debug)]
pub struct Serve<'a> {
    /// Somebody wants it to end.
    pub stop: &'a AtomicBool,
    /// After this time in ns.
    pub duration_ns: Option<u64>,
}

/// What was served.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Served {
    /// Steps of the machine.
    pub steps: u64,
    /// Whether it stopped itself in the end.
    pub stopped: bool,
    /// Packets from the runner.
    pub commands: Counters,
    /// Injected into the runner's packets.
    pub injected_into_commands: Injected,
    /// Injected into the machine's packets.
    pub injected_into_measurements: Injected,
}

/// Longest wait without looking at `stop`.
const LOOK_NS: u64 = 2_000_000;

/// Plays the machine until it shall end.
///
/// # Errors
/// The plant FMU failed.
pub fn serve(
    emulator: &mut Emulator,
    gateway: &mut dyn Gateway,
    serve: &Serve<'_>,
) -> Result<Served, PlantError> {
    let begin = now_ns();
    let by_commands = emulator.behaviour.timing == Timing::Commands;
    loop {
        let now = now_ns();
        emulator.serve(now, gateway)?;
        let over = serve.duration_ns.is_some_and(|duration| now - begin >= duration);
        if over || serve.stop.load(Ordering::Relaxed) {
            break;
        }
        let next = emulator.next_ns().unwrap_or(now + LOOK_NS).min(now + LOOK_NS);
        if by_commands {
            gateway.wait(Duration::from_nanos(next.saturating_sub(now_ns())));
        } else {
            wait_until(next);
        }
    }
    let (injected_into_commands, injected_into_measurements) = emulator.injected();
    Ok(Served {
        steps: emulator.steps(),
        stopped: emulator.is_stopped(),
        commands: *emulator.counters(),
        injected_into_commands,
        injected_into_measurements,
    })
}

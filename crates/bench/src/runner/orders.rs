//! Orders from other threads, without a lock.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::cycle::Orders;

/// Interruptions after which the runner does not wait for the command to be at its safe value.
const LEAVES: usize = 3;

/// Orders that any thread may give.
#[derive(Clone, Debug, Default)]
pub struct SharedOrders {
    start: Arc<AtomicBool>,
    stops: Arc<AtomicUsize>,
}

impl SharedOrders {
    /// To run now, without waiting for it to settle.
    pub fn start(&self) {
        self.start.store(true, Ordering::Relaxed);
    }

    /// To go to the safe state and end.
    pub fn stop(&self) {
        self.stops.fetch_max(1, Ordering::Relaxed);
    }

    /// To go to the safe state and end, by Ctrl-C or a signal: the third one ends the run wherever the command is.
    pub fn interrupt(&self) {
        self.stops.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn leaves(&self) -> bool {
        self.stops.load(Ordering::Relaxed) >= LEAVES
    }

    pub(super) fn read(&self) -> Orders {
        Orders {
            start: self.start.load(Ordering::Relaxed),
            stop: self.stops.load(Ordering::Relaxed) > 0,
            reset: false,
        }
    }
}

//! Orders from other threads and from signals, without a lock.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::cycle::Orders;

/// Orders that any thread may give.
#[derive(Clone, Debug, Default)]
pub struct SharedOrders {
    start: Arc<AtomicBool>,
    stop: Arc<AtomicBool>,
}

impl SharedOrders {
    /// To run now, without waiting for it to settle.
    pub fn start(&self) {
        self.start.store(true, Ordering::Relaxed);
    }

    /// To go to the safe state and end.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// The flag of [`stop`](Self::stop).
    #[must_use]
    pub fn stop_flag(&self) -> &Arc<AtomicBool> {
        &self.stop
    }

    pub(super) fn read(&self) -> Orders {
        Orders {
            start: self.start.load(Ordering::Relaxed),
            stop: self.stop.load(Ordering::Relaxed),
            reset: false,
        }
    }
}

/// Lets Ctrl-C, SIGTERM and SIGHUP set a flag.
///
/// # Errors
/// What the operating system says.
pub fn on_signals(flag: &Arc<AtomicBool>) -> io::Result<()> {
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::flag::register(signal, Arc::clone(flag))?;
    }
    Ok(())
}

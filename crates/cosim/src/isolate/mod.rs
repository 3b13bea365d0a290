//! FMUs in processes of their own: one that crashes or hangs ends the run with an error, not the
//! program.
//!
//! The program starts itself again as a *worker* (see [`Worker`]), which loads the FMU and answers
//! calls over a socket pair that is its standard input. What the FMU prints goes to standard error.
//! A call costs a round trip between processes, some 10 µs; writing values waits for no answer.
//!
//! Elsewhere than on Unix opening such an FMU is an error that says so.

mod protocol;
mod slave;
mod worker;

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

pub(crate) use slave::IsolatedSlave;
pub use worker::serve;

/// How workers are started.
#[derive(Clone, Debug)]
pub struct Worker {
    /// The program, which must come to [`serve`] when it is started with the arguments.
    pub program: PathBuf,
    /// The worker's arguments.
    pub arguments: Vec<OsString>,
    /// A call that takes longer ends the process.
    pub timeout: Duration,
    /// Most memory for data that a process may have, in bytes; none: as much as there is. An FMU that asks
    /// for more gets none, upon which most crash.
    pub memory: Option<u64>,
}

impl Worker {
    /// This program, with this argument.
    ///
    /// # Errors
    /// If the operating system does not tell which program this is.
    pub fn this_program(argument: &str, timeout: Duration) -> std::io::Result<Self> {
        let program = std::env::current_exe()?;
        Ok(Worker { program, arguments: vec![argument.into()], timeout, memory: None })
    }
}

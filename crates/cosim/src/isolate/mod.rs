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

pub(crate) use slave::IsolatedSlave;
pub use slave::Worker;
pub use worker::serve;

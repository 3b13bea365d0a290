//! Import: the one place that loads a foreign FMU's shared library and calls it.
//!
//! ```text
//! Binary (dlopen) ── v2::Library (the functions of FMI 2.0) ── v2::Instance (one slave)
//!                 └─ v3::Library (the functions of FMI 3.0) ── v3::Instance
//!                                                              Log (messages of the FMU)
//! ```
//!
//! A call that fails becomes an [`Error`] that names the FMU, the call, the status and the last
//! messages of the FMU. A status of *warning* is a success; its message is in the [`Log`].

mod binary;
mod error;
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod format;
mod host;
mod log;
mod logger;
mod registry;
mod state;
mod status;
mod step;
mod text;
pub mod v2;
pub mod v3;

pub use binary::Binary;
pub use error::{CallError, Error};
#[cfg(unix)]
pub use host::keep_standard_output;
pub use log::{HOST, Log, Message, NameOf, OnMessage};
pub use registry::{called, names as instances};
pub use state::SavedState;
pub use status::Status;
pub use step::{Experiment, StepResult};
